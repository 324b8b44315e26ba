/* SPDX-License-Identifier: MIT
 *
 * What batches know beforehand of objects and of the segments that end on them.
 */
#include "compact/batch_guide.h"

#include <string.h>

#include "compact/step.h"

static bool alike(const double *value, int n)
{
    for (int i = 1; i < n; i++)
        if (value[i] != value[0])
            return false;
    return true;
}

/* Events at a side of a surface that weigh all channels alike (retrace_colour.c). */
static uint32_t grey_events(const struct rmap_scene *scene, const struct rmap_surface *surface)
{
    bool dispersive = false;
    int n = scene->channels.n;
    uint32_t grey = 0;
    for (size_t i = 0; i < scene->n_medium; i++)
        dispersive = dispersive || scene->medium[i].dispersive;
    if (rmap_surface_scatters(surface))
        return n == 1 ? UINT32_MAX : 0;
    if (surface->type == RMAP_SURFACE_FRESNEL)
        return dispersive || surface->coat == RMAP_COAT_REFLECTANCE ||
                       surface->coat == RMAP_COAT_FILM
                   ? 0
                   : UINT32_MAX;
    if (!(surface->type == RMAP_SURFACE_MIRROR && surface->is_metal) &&
        alike(surface->reflect_specular, n))
        grey |= RMAP_EVENT_REFLECT_SPECULAR;
    if (alike(surface->reflect_diffuse, n))
        grey |= RMAP_EVENT_REFLECT_DIFFUSE;
    if (alike(surface->transmit_diffuse, n))
        grey |= RMAP_EVENT_TRANSMIT_DIFFUSE;
    if (!dispersive && alike(surface->transmit_specular, n))
        grey |= RMAP_EVENT_TRANSMIT_SPECULAR;
    return grey;
}

void rmap_batch_set_flat(struct rmap_compact_object *object)
{
    struct rmap_vec3 normal = rmap_affine_transposed(&object->to_local, rmap_vec3(0.0, 0.0, 1.0));
    int16_t recorded[4] = {0};
    if (!object->rigid)
        normal = rmap_normalize(normal);
    rmap_step_normal(normal, recorded);
    object->flat[0] = normal.x;
    object->flat[1] = normal.y;
    object->flat[2] = normal.z;
    memcpy(&object->flat[3], recorded, sizeof recorded);
}

uint32_t rmap_batch_step(const struct rmap_compact_guide *guide, uint32_t kind, uint32_t event)
{
    uint32_t turn = kind > RMAP_BATCH_NOTHING ? (uint32_t)rmap_step_turn(event) : RMAP_TURN_NONE;
    turn = turn == RMAP_TURN_DIFFUSE && guide->scatters ? RMAP_TURN_SCATTER : turn;
    uint32_t flags = (event & RMAP_EVENT_LEFT ? RMAP_BATCH_LEFT : 0) |
                     (event & guide->grey[0] ? RMAP_BATCH_GREY_BACK : 0) |
                     (event & guide->grey[1] ? RMAP_BATCH_GREY_FRONT : 0);
    return flags << 8 | (kind * RMAP_BATCH_TURNS + turn);
}

static void set_steps(struct rmap_compact_guide *guide)
{
    for (int k = 0; k < RMAP_GUIDE_STEPS; k++) {
        uint32_t event = k + 1 < RMAP_GUIDE_STEPS ? 1u << k : 0;
        guide->step[k] = (uint16_t)rmap_batch_step(guide, guide->batch, event);
    }
}

void rmap_batch_guide(const struct rmap_scene *scene, const struct rmap_compact_object *object,
                      struct rmap_compact_guide *guide)
{
    guide->grey[0] = grey_events(scene, object->back);
    guide->grey[1] = grey_events(scene, object->front);
    guide->scatters = rmap_surface_scatters(object->front) || rmap_surface_scatters(object->back);
    guide->n_primitive = SIZE_MAX;
    guide->corner = (const float *)(const void *)&object->to_local;
    switch (object->kind) {
    case RMAP_FACING_FLAT:
        guide->batch = RMAP_BATCH_FLAT;
        break;
    case RMAP_FACING_QUADRIC:
        guide->batch = RMAP_BATCH_QUADRIC;
        guide->quadric = RMAP_BATCH_TURNS;
        break;
    case RMAP_FACING_ASPHERE:
    case RMAP_FACING_SAG:
    case RMAP_FACING_WALL:
        guide->batch = RMAP_BATCH_ALONE;
        break;
    case RMAP_FACING_MESH:
        guide->batch =
            object->corner && !object->mesh->surface ? RMAP_BATCH_MESH : RMAP_BATCH_ALONE;
        guide->n_primitive = object->mesh->n_triangle;
        if (object->corner) {
            guide->corner = (const float *)object->corner;
            guide->stride = sizeof *object->corner / sizeof(float);
        }
        break;
    }
    set_steps(guide);
}

void rmap_batch_guide_out(const struct rmap_compact_model *model, struct rmap_compact_guide *guide)
{
    guide->batch = model->participating ? RMAP_BATCH_ALONE : RMAP_BATCH_NOTHING;
    guide->n_primitive = SIZE_MAX;
    guide->corner = (const float *)(const void *)model->object;
    set_steps(guide);
}

/* SPDX-License-Identifier: MIT
 *
 * What waves know of an object beforehand.
 */
#include "compact/step.h"
#include "compact/wave.h"

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
    if (surface->type == RMAP_SURFACE_FRESNEL)
        return dispersive || surface->coat == RMAP_COAT_REFLECTANCE ? 0 : UINT32_MAX;
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

void rmap_wave_set_flat(struct rmap_compact_object *object)
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

uint32_t rmap_wave_step(const struct rmap_compact_guide *guide, uint32_t kind, uint32_t event)
{
    uint32_t turn = kind > RMAP_WAVE_NOTHING ? (uint32_t)rmap_step_turn(event) : RMAP_TURN_NONE;
    uint32_t flags = (event & RMAP_EVENT_LEFT ? RMAP_WAVE_LEFT : 0) |
                     (event & guide->grey[0] ? RMAP_WAVE_GREY_BACK : 0) |
                     (event & guide->grey[1] ? RMAP_WAVE_GREY_FRONT : 0);
    return flags << 8 | (kind * RMAP_WAVE_TURNS + turn);
}

static void set_steps(struct rmap_compact_guide *guide)
{
    for (int k = 0; k < RMAP_GUIDE_STEPS; k++) {
        uint32_t event = k + 1 < RMAP_GUIDE_STEPS ? 1u << k : 0;
        guide->step[k] = (uint16_t)rmap_wave_step(guide, guide->wave, event);
    }
}

void rmap_wave_guide(const struct rmap_scene *scene, const struct rmap_compact_object *object,
                     struct rmap_compact_guide *guide)
{
    guide->grey[0] = grey_events(scene, object->back);
    guide->grey[1] = grey_events(scene, object->front);
    guide->n_primitive = SIZE_MAX;
    guide->corner = (const float *)(const void *)&object->to_local;
    switch (object->kind) {
    case RMAP_FACING_FLAT:
        guide->wave = RMAP_WAVE_FLAT;
        break;
    case RMAP_FACING_QUADRIC:
        guide->wave = RMAP_WAVE_QUADRIC;
        guide->quadric = RMAP_WAVE_TURNS;
        break;
    case RMAP_FACING_ASPHERE:
        guide->wave = RMAP_WAVE_ALONE;
        break;
    case RMAP_FACING_MESH:
        guide->wave = object->corner ? RMAP_WAVE_MESH : RMAP_WAVE_ALONE;
        guide->n_primitive = object->mesh->n_triangle;
        if (object->corner) {
            guide->corner = (const float *)object->corner;
            guide->stride = sizeof *object->corner / sizeof(float);
        }
        break;
    }
    set_steps(guide);
}

void rmap_wave_guide_out(const struct rmap_compact_model *model, struct rmap_compact_guide *guide)
{
    guide->wave = model->absorbing ? RMAP_WAVE_ALONE : RMAP_WAVE_NOTHING;
    guide->n_primitive = SIZE_MAX;
    guide->corner = (const float *)(const void *)model->object;
    set_steps(guide);
}

/* SPDX-License-Identifier: MIT
 *
 * Where a ray starts: the source's random numbers drawn again.
 */
#include "base/rng.h"
#include "compact/model.h"
#include "compact/portable.h"
#include "formula/emit.h"
#include "trace/source.h"

static struct rmap_vec3 point_direction(const struct rmap_source *source,
                                        const struct rmap_compact_source *own, const double u[4])
{
    struct rmap_vec3 local = rmap_vec3(0.0, 0.0, 1.0);
    switch (source->distribution) {
    case RMAP_DISTRIBUTION_ISOTROPIC:
        local = rmap_about_z(2.0 * u[0], u[1]);
        break;
    case RMAP_DISTRIBUTION_CONE:
        local = rmap_about_z(u[0] * own->cone, u[1]);
        break;
    case RMAP_DISTRIBUTION_COSINE:
        local = rmap_about_z(
            rmap_portable_one_minus_exp(-rmap_portable_log(u[0]) / (source->cosine_power + 1.0)),
            u[1]);
        break;
    }
    return rmap_normalize(rmap_affine_vector(&source->frame, local));
}

static void from_list(const struct rmap_scene *scene, const struct rmap_source *source,
                      uint64_t ray, struct rmap_departure *departure)
{
    uint64_t ordinal = 0;
    if (source->n_list == 0 || scene->schedule_len == 0)
        return;
    (void)rmap_scene_source_of(scene, ray, &ordinal);
    const struct rmap_list_ray *row = &source->list[ordinal % source->n_list];
    departure->position = row->origin;
    departure->direction = row->direction;
    departure->channel = row->channel;
}

void rmap_departure_find(const struct rmap_compact_model *model, uint64_t seed, uint64_t ray,
                         int32_t index, struct rmap_departure *departure)
{
    *departure = (struct rmap_departure){.direction = {0.0, 0.0, 1.0}, .channel = -1};
    if (index < 0 || (size_t)index >= model->n_source)
        return;
    const struct rmap_source *source = &model->scene->source[index];
    const struct rmap_compact_source *own = &model->source[index];
    departure->medium = source->medium;
    if (source->type == RMAP_SOURCE_RAYS) {
        from_list(model->scene, source, ray, departure);
        return;
    }
    double place[4] = {0.5, 0.5, 0.5, 0.5}, way[4];
    struct rmap_vec3 normal = own->axis, x = own->tangent[0], y = own->tangent[1];
    if (source->shape != RMAP_EMITTER_POINT)
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
    departure->position = source->shape == RMAP_EMITTER_MESH
                              ? rmap_source_point(model->scene, source, place, &normal)
                              : rmap_source_flat_point(source, place);
    departure->direction = normal;
    if (source->type == RMAP_SOURCE_COLLIMATED)
        return;
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
    if (source->type == RMAP_SOURCE_POINT) {
        departure->direction = point_direction(source, own, way);
        return;
    }
    departure->normal = normal;
    if (source->shape == RMAP_EMITTER_MESH)
        rmap_basis(normal, &x, &y);
    departure->direction = rmap_lambertian(normal, x, y, way[0], way[1]);
}

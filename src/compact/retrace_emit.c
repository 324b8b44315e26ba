/* SPDX-License-Identifier: MIT
 *
 * Where a ray starts: the source's random numbers drawn again.
 */
#include "base/rng.h"
#include "compact/model.h"
#include "compact/portable.h"
#include "trace/azimuth.h"

static struct rmap_vec3 about_z(double one_minus_cos, double azimuth_turns)
{
    double x, y, sine = sqrt(one_minus_cos * (2.0 - one_minus_cos));
    rmap_azimuth(azimuth_turns, &x, &y);
    return rmap_vec3(sine * x, sine * y, 1.0 - one_minus_cos);
}

static struct rmap_vec3 point_direction(const struct rmap_source *source,
                                        const struct rmap_compact_source *own, const double u[4])
{
    struct rmap_vec3 local = rmap_vec3(0.0, 0.0, 1.0);
    switch (source->distribution) {
    case RMAP_DISTRIBUTION_ISOTROPIC:
        local = about_z(2.0 * u[0], u[1]);
        break;
    case RMAP_DISTRIBUTION_CONE:
        local = about_z(u[0] * own->cone, u[1]);
        break;
    case RMAP_DISTRIBUTION_COSINE:
        local = about_z(
            rmap_portable_one_minus_exp(-rmap_portable_log(u[0]) / (source->cosine_power + 1.0)),
            u[1]);
        break;
    }
    return rmap_normalize(rmap_affine_vector(&source->frame, local));
}

static size_t choose_triangle(const double *cdf, size_t n, double u)
{
    size_t low = 0, high = n - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (cdf[middle] > u)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

static struct rmap_vec3 point_on_mesh(const struct rmap_scene *scene,
                                      const struct rmap_source *source, const double u[4],
                                      struct rmap_vec3 *normal)
{
    const struct rmap_mesh *mesh = scene->geometry[source->shape_geometry].mesh;
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(mesh, choose_triangle(source->triangle_cdf, mesh->n_triangle, u[2]), corner);
    for (int k = 0; k < 3; k++)
        corner[k] = rmap_affine_point(&source->frame, corner[k]);
    struct rmap_vec3 a = rmap_sub(corner[1], corner[0]), b = rmap_sub(corner[2], corner[0]);
    *normal = rmap_normalize(rmap_cross(a, b));
    if (rmap_affine_determinant(&source->frame) < 0.0)
        *normal = rmap_scale(*normal, -1.0);
    double root = sqrt(u[0]);
    return rmap_axpy(root * (1.0 - u[1]), a, rmap_axpy(root * u[1], b, corner[0]));
}

static struct rmap_vec3 emitter_point(const struct rmap_scene *scene,
                                      const struct rmap_source *source, const double u[4],
                                      struct rmap_vec3 *normal)
{
    struct rmap_vec3 local = rmap_vec3(0.0, 0.0, 0.0);
    double x, y, r;
    switch (source->shape) {
    case RMAP_EMITTER_POINT:
        break;
    case RMAP_EMITTER_DISC:
        r = source->shape_size[0] * sqrt(u[0]);
        rmap_azimuth(u[1], &x, &y);
        local = rmap_vec3(r * x, r * y, 0.0);
        break;
    case RMAP_EMITTER_RECTANGLE:
        local = rmap_vec3((u[0] - 0.5) * source->shape_size[0],
                          (u[1] - 0.5) * source->shape_size[1], 0.0);
        break;
    case RMAP_EMITTER_MESH:
        return point_on_mesh(scene, source, u, normal);
    }
    return rmap_affine_point(&source->frame, local);
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
    departure->position = emitter_point(model->scene, source, place, &normal);
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
    struct rmap_vec3 local = about_z(1.0 - sqrt(way[0]), way[1]);
    departure->direction =
        rmap_normalize(rmap_axpy(local.x, x, rmap_axpy(local.y, y, rmap_scale(normal, local.z))));
}

/* SPDX-License-Identifier: MIT
 *
 * Emission: where a ray begins, in which direction, of which colour, and when.
 */
#include "trace/source.h"

#include <math.h>

#include "base/portable.h"
#include "base/rng.h"
#include "base/search.h"
#include "formula/emit.h"

double rmap_source_cone(const struct rmap_source *source)
{
    const double turns = source->cone_rad / (2.0 * RMAP_PI);
    return rmap_one_minus_cos(turns >= 0.0 && turns <= 2.0 ? turns : 0.0);
}

struct rmap_vec3 rmap_source_about_z(const struct rmap_source *source, const double u[2])
{
    double c, s;
    switch (source->distribution) {
    case RMAP_DISTRIBUTION_ISOTROPIC:
        return rmap_about_z(2.0 * u[0], u[1]);
    case RMAP_DISTRIBUTION_CONE:
        return rmap_about_z(rmap_source_cone(source) * u[0], u[1]);
    case RMAP_DISTRIBUTION_COSINE:
        return rmap_about_z(
            rmap_portable_one_minus_exp(-rmap_portable_log(u[0]) / (source->cosine_power + 1.0)),
            u[1]);
    case RMAP_DISTRIBUTION_TABLE:
        return rmap_about_z(rmap_profile_draw(&source->profile, u[0]), u[1]);
    case RMAP_DISTRIBUTION_LAMP:
        return rmap_lamp_draw(source->lamp, u);
    case RMAP_DISTRIBUTION_SINE: {
        const double sine = source->aperture * sqrt(u[0]);
        rmap_azimuth(u[1], &c, &s);
        return rmap_vec3(sine * c, sine * s, sqrt((1.0 - sine) * (1.0 + sine)));
    }
    case RMAP_DISTRIBUTION_STEPS: /* by rmap_source_start */
    case RMAP_DISTRIBUTION_SKY:
        break;
    }
    return rmap_vec3(0.0, 0.0, 1.0);
}

struct rmap_vec3 rmap_source_about_axis(const struct rmap_source *source, const double u[2])
{
    if (source->distribution == RMAP_DISTRIBUTION_CONE) {
        double half_sine = sin(0.5 * source->cone_rad);
        return rmap_about_z(u[0] * 2.0 * half_sine * half_sine, u[1]);
    }
    if (source->distribution == RMAP_DISTRIBUTION_COSINE)
        return rmap_about_z(-expm1(log(u[0]) / (source->cosine_power + 1.0)), u[1]);
    return rmap_source_about_z(source, u);
}

/* Each ray on a hyperboloid of one sheet, turning about the axis to one side or the other: the
 * radius of every share of the light grows as the beam's does. */
static void start_beam(const struct rmap_source *source, const double u[4],
                       struct rmap_list_ray *start)
{
    double c, s;
    const double r = source->shape_size[0] * sqrt(-0.5 * rmap_portable_log(u[0])),
                 turn = (u[2] < 0.5 ? -1.0 : 1.0) / source->shape_size[1], z = -source->cone_rad;
    rmap_azimuth(u[1], &c, &s);
    const double x = r * c, y = r * s, dx = -turn * y, dy = turn * x;
    start->origin = rmap_affine_point(&source->frame, rmap_vec3(x + z * dx, y + z * dy, 0.0));
    start->direction = rmap_normalize(rmap_affine_vector(&source->frame, rmap_vec3(dx, dy, 1.0)));
}

struct rmap_vec3 rmap_source_directed(const struct rmap_source *source, struct rmap_vec3 normal,
                                      const double u[2])
{
    const struct rmap_vec3 local = rmap_source_about_z(source, u);
    struct rmap_vec3 x, y;
    if (source->shape != RMAP_EMITTER_MESH)
        return rmap_normalize(rmap_affine_vector(&source->frame, local));
    rmap_basis(normal, &x, &y);
    return rmap_in_frame(local, x, y, normal);
}

/* The same, put onto the surface that the triangle stands for. */
static struct rmap_vec3 point_on_surface(const struct rmap_source *source,
                                         const struct rmap_mesh *mesh, size_t triangle,
                                         const struct rmap_vec3 corner[3], const double u[4],
                                         struct rmap_vec3 *normal)
{
    struct rmap_vec3 a = rmap_sub(corner[1], corner[0]), b = rmap_sub(corner[2], corner[0]);
    struct rmap_affine back;
    const double root = sqrt(u[0]);
    struct rmap_vec3 p = rmap_axpy(root * (1.0 - u[1]), a, rmap_axpy(root * u[1], b, corner[0]));
    *normal = rmap_cross(a, b);
    rmap_mesh_lift(mesh, triangle, &p, normal);
    if (rmap_affine_invert(&source->frame, &back))
        *normal = rmap_affine_transposed(&back, *normal);
    *normal = rmap_normalize(*normal);
    return rmap_affine_point(&source->frame, p);
}

/* Uniform on a mesh, with the world normal of the triangle's front side (Osada et al. 2002,
 * doi:10.1145/571647.571648, eq. 1). */
static struct rmap_vec3 point_on_mesh(const struct rmap_scene *scene,
                                      const struct rmap_source *source, const double u[4],
                                      struct rmap_vec3 *normal)
{
    const struct rmap_mesh *mesh = scene->geometry[source->shape_geometry].mesh;
    const size_t triangle = rmap_first_above(source->triangle_cdf, mesh->n_triangle, u[2]);
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(mesh, triangle, corner);
    if (rmap_mesh_surface(mesh, triangle))
        return point_on_surface(source, mesh, triangle, corner, u, normal);
    for (int k = 0; k < 3; k++)
        corner[k] = rmap_affine_point(&source->frame, corner[k]);
    struct rmap_vec3 a = rmap_sub(corner[1], corner[0]), b = rmap_sub(corner[2], corner[0]);
    *normal = rmap_normalize(rmap_cross(a, b));
    if (rmap_affine_determinant(&source->frame) < 0.0)
        *normal = rmap_scale(*normal, -1.0);
    double root = sqrt(u[0]);
    return rmap_axpy(root * (1.0 - u[1]), a, rmap_axpy(root * u[1], b, corner[0]));
}

struct rmap_vec3 rmap_source_flat_normal(const struct rmap_source *source)
{
    return rmap_normalize(rmap_affine_vector(&source->frame, rmap_vec3(0.0, 0.0, 1.0)));
}

struct rmap_vec3 rmap_source_flat_point(const struct rmap_source *source, const double u[4])
{
    struct rmap_vec3 local = rmap_vec3(0.0, 0.0, 0.0);
    switch (source->shape) {
    case RMAP_EMITTER_POINT:
    case RMAP_EMITTER_MESH:
    case RMAP_EMITTER_BODY:
    case RMAP_EMITTER_SKY:
        break;
    case RMAP_EMITTER_DISC:
        local = rmap_source_is_apodised(source)
                    ? rmap_disc_point(source->shape_size[0],
                                      0.5 * rmap_profile_draw(&source->profile, u[0]), u[1])
                    : rmap_disc_point(source->shape_size[0], u[0], u[1]);
        break;
    case RMAP_EMITTER_RECTANGLE:
        local = rmap_rectangle_point(source->shape_size, u[0], u[1]);
        break;
    }
    return rmap_affine_point(&source->frame, local);
}

struct rmap_vec3 rmap_source_point(const struct rmap_scene *scene, const struct rmap_source *source,
                                   const double u[4], struct rmap_vec3 *normal)
{
    if (source->shape == RMAP_EMITTER_MESH)
        return point_on_mesh(scene, source, u, normal);
    *normal = rmap_source_flat_normal(source);
    return rmap_source_flat_point(source, u);
}

/* The scene of a map's decoder may have no rays. */
static void start_row(const struct rmap_scene *scene, const struct rmap_source *source,
                      uint64_t ordinal, struct rmap_list_ray *start)
{
    const struct rmap_file_rays *rays = source->rays;
    if (!rays) {
        if (source->n_list > 0)
            *start = source->list[ordinal % source->n_list];
        return;
    }
    const size_t k = rmap_file_rays_row(rays, ordinal);
    const double nm = rmap_file_rays_nm(rays, k);
    struct rmap_vec3 p, d;
    rmap_file_rays_get(rays, k, &p, &d);
    start->origin = rmap_affine_point(&source->frame, p);
    start->direction = rmap_normalize(rmap_affine_vector(&source->frame, d));
    if (nm > 0.0 && scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        start->channel = rmap_channel_nearest(&scene->channels, nm);
    if (rays->delay_ns)
        start->delay_ns = rays->delay_ns[k];
}

void rmap_source_photon(const struct rmap_scene *scene, const struct rmap_source *source,
                        uint64_t seed, uint64_t ray, struct rmap_photon *photon)
{
    const struct rmap_steps_medium medium = rmap_source_steps_medium(scene, source);
    double place[4], way[4];
    uint64_t ordinal = 0;
    (void)rmap_scene_source_of(scene, ray, &ordinal);
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
    rmap_steps_draw(source->steps, &medium, ordinal, place, way, photon);
}

static void start_lamp(const struct rmap_scene *scene, const struct rmap_source *source,
                       const double place[4], const double way[4], struct rmap_list_ray *start)
{
    const struct rmap_vec3 local = rmap_lamp_draw(source->lamp, way);
    struct rmap_vec3 normal;
    start->origin =
        source->shape == RMAP_EMITTER_MESH
            ? rmap_source_point(scene, source, place, &normal)
            : rmap_affine_point(&source->frame, rmap_lamp_point(source->lamp, local, place));
    start->direction = rmap_normalize(rmap_affine_vector(&source->frame, local));
}

bool rmap_source_start(const struct rmap_scene *scene, const struct rmap_source *source,
                       uint64_t seed, uint64_t ray, struct rmap_list_ray *start)
{
    const struct rmap_vec3 z = {0.0, 0.0, 1.0};
    double place[4], way[4];
    uint64_t ordinal = 0;
    struct rmap_photon photon;
    *start = (struct rmap_list_ray){.direction = z, .channel = -1};
    switch (source->type) {
    case RMAP_SOURCE_COLLIMATED:
    case RMAP_SOURCE_POINT:
    case RMAP_SOURCE_AREA:
        return false;
    case RMAP_SOURCE_RAYS:
        if (scene->schedule_len == 0)
            break;
        (void)rmap_scene_source_of(scene, ray, &ordinal);
        start_row(scene, source, ordinal, start);
        break;
    case RMAP_SOURCE_STEPS:
        if (scene->schedule_len == 0)
            break;
        rmap_source_photon(scene, source, seed, ray, &photon);
        *start = (struct rmap_list_ray){photon.position, photon.direction, photon.channel,
                                        photon.delay_ns};
        break;
    case RMAP_SOURCE_VOLUME:
        start->origin = rmap_volume_draw(scene, source, seed, ray);
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
        start->direction = rmap_about_z(2.0 * way[0], way[1]);
        break;
    case RMAP_SOURCE_LAMP:
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
        start_lamp(scene, source, place, way, start);
        break;
    case RMAP_SOURCE_BEAM:
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
        start_beam(source, place, start);
        break;
    case RMAP_SOURCE_SKY:
    case RMAP_SOURCE_SUN:
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
        rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
        start->direction = rmap_sky_draw(source, place, way, &start->origin, &start->channel);
        break;
    }
    if (!scene->timed)
        start->delay_ns = 0.0;
    return true;
}

int rmap_source_channel(const struct rmap_scene *scene, const struct rmap_source *source,
                        uint64_t seed, uint64_t ray, int own)
{
    struct rmap_colour colour;
    double u[4];
    if (own >= 0 || !rmap_scene_draws_wavelength(scene))
        return own;
    rmap_colour_set(&colour, source->colour, scene->channels.n);
    rmap_rng(seed, ray, 0, RMAP_RNG_WAVELENGTH, u);
    return rmap_colour_pick(&colour, NULL, u[0]);
}

/* How far a start may be from where it is meant to be. */
static double looseness(const struct rmap_source *source, struct rmap_vec3 start)
{
    const struct rmap_vec3 from = rmap_sub(start, source->frame.t);
    return source->rays && source->rays->loose > 0.0
               ? source->rays->loose * fmax(fabs(from.x), fmax(fabs(from.y), fabs(from.z)))
               : 0.0;
}

void rmap_source_emit(const struct rmap_scene *scene, uint64_t seed, uint64_t ray,
                      struct rmap_colour *colour, struct rmap_emission *emission)
{
    uint64_t ordinal;
    int32_t index = rmap_scene_source_of(scene, ray, &ordinal);
    const struct rmap_source *source = &scene->source[index];
    struct rmap_list_ray start;
    const bool started = rmap_source_start(scene, source, seed, ray, &start);
    const int channel = rmap_source_channel(scene, source, seed, ray, start.channel);
    rmap_colour_set(colour, source->colour, scene->channels.n);
    if (channel >= 0)
        rmap_colour_collapse(colour, channel);
    *emission = (struct rmap_emission){.ray = ray,
                                       .source = index,
                                       .object = -1,
                                       .primitive = -1,
                                       .medium = source->medium,
                                       .colour = colour->share,
                                       .predicted = true};
    if (started) {
        emission->position = start.origin;
        emission->direction = start.direction;
        emission->delay_ns = start.delay_ns;
        emission->loose = looseness(source, start.origin);
        return;
    }
    double place[4], way[4];
    struct rmap_vec3 normal;
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, place);
    emission->position = rmap_source_point(scene, source, place, &normal);
    emission->direction = normal;
    if (rmap_source_is_parallel(source))
        return;
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_DIRECTION, way);
    if (source->type == RMAP_SOURCE_AREA) {
        struct rmap_vec3 x, y;
        rmap_basis(normal, &x, &y);
        emission->normal = normal;
        emission->direction = rmap_source_is_directed(source)
                                  ? rmap_source_directed(source, normal, way)
                                  : rmap_lambertian(normal, x, y, way[0], way[1]);
    } else {
        emission->predicted = source->distribution == RMAP_DISTRIBUTION_ISOTROPIC ||
                              source->distribution == RMAP_DISTRIBUTION_TABLE;
        emission->direction =
            rmap_normalize(rmap_affine_vector(&source->frame, rmap_source_about_axis(source, way)));
    }
}

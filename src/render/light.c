/* SPDX-License-Identifier: MIT
 *
 * The scene's sources as seen from where light arrives: by sampling them from a point (next-event
 * estimation), and by meeting their shining side along a segment.
 */
#include "render/light.h"

#include "base/alloc.h"
#include "trace/source.h"

/* ---- strengths ---- */

static double mesh_area(const struct rmap_mesh *mesh, const struct rmap_affine *frame)
{
    double sum = 0.0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3];
        rmap_mesh_corners(mesh, t, corner);
        struct rmap_vec3 a = rmap_affine_vector(frame, rmap_sub(corner[1], corner[0]));
        struct rmap_vec3 b = rmap_affine_vector(frame, rmap_sub(corner[2], corner[0]));
        sum += 0.5 * rmap_length(rmap_cross(a, b));
    }
    return sum;
}

static void bound_mesh(const struct rmap_mesh *mesh, struct rmap_light *light)
{
    struct rmap_vec3 lower, upper;
    rmap_mesh_bounds(mesh, &lower, &upper);
    light->centre =
        rmap_affine_point(&light->source->frame, rmap_scale(rmap_add(lower, upper), 0.5));
    for (int k = 0; k < 8; k++) {
        struct rmap_vec3 corner = rmap_vec3(k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y,
                                            k & 4 ? upper.z : lower.z);
        corner = rmap_affine_point(&light->source->frame, corner);
        light->radius = fmax(light->radius, rmap_length(rmap_sub(corner, light->centre)));
    }
    light->radius *= 1.0 + 1e-12;
    for (size_t i = 0; mesh->surface && i < mesh->n_triangle; i++)
        light->bulge = fmax(light->bulge, rmap_mesh_bulge(mesh, i));
    light->bulge *= rmap_affine_norm(&light->source->frame);
}

static double emitter_area(const struct rmap_scene *scene, const struct rmap_source *source)
{
    switch (source->shape) {
    case RMAP_EMITTER_POINT:
    case RMAP_EMITTER_BODY:
    case RMAP_EMITTER_SKY:
        break;
    case RMAP_EMITTER_DISC:
        return RMAP_PI * source->shape_size[0] * source->shape_size[0];
    case RMAP_EMITTER_RECTANGLE:
        return source->shape_size[0] * source->shape_size[1];
    case RMAP_EMITTER_MESH:
        return mesh_area(scene->geometry[source->shape_geometry].mesh, &source->frame);
    }
    return 0.0;
}

/* Intensity on the axis per flux: one over the integral of the distribution. */
static double axial_intensity(const struct rmap_source *source)
{
    double half_sine = sin(0.5 * source->cone_rad);
    switch (source->distribution) {
    case RMAP_DISTRIBUTION_ISOTROPIC:
        break;
    case RMAP_DISTRIBUTION_CONE:
        return 1.0 / (4.0 * RMAP_PI * half_sine * half_sine);
    case RMAP_DISTRIBUTION_COSINE:
        return (source->cosine_power + 1.0) / (2.0 * RMAP_PI);
    case RMAP_DISTRIBUTION_TABLE:
    case RMAP_DISTRIBUTION_SINE: /* of no point */
    case RMAP_DISTRIBUTION_LAMP:
    case RMAP_DISTRIBUTION_STEPS:
    case RMAP_DISTRIBUTION_SKY:
        return 1.0; /* they are of unit flux */
    }
    return 0.25 / RMAP_PI;
}

static enum rmap_status make_light(const struct rmap_lights *lights,
                                   const struct rmap_source *source, struct rmap_light *light,
                                   struct rmap_error *err)
{
    *light = (struct rmap_light){.source = source};
    if (source->sky) /* which knows its radiance */
        return RMAP_OK;
    if (!rmap_affine_invert(&source->frame, &light->to_local))
        return rmap_error_set(err, RMAP_INPUT, "source '%s': its transform is singular",
                              source->name);
    light->area = emitter_area(lights->scene, source);
    light->normal = rmap_source_flat_normal(source);
    if (source->shape == RMAP_EMITTER_MESH)
        bound_mesh(lights->scene->geometry[source->shape_geometry].mesh, light);
    if (source->type == RMAP_SOURCE_POINT || source->type == RMAP_SOURCE_LAMP)
        light->strength = source->flux * axial_intensity(source);
    else
        light->strength = source->flux / (light->area * lights->unit_m2);
    if (source->type == RMAP_SOURCE_AREA)
        light->strength /= RMAP_PI;
    return RMAP_OK;
}

/* Lights are drawn in proportion to their flux. */
static void share_out(struct rmap_lights *lights)
{
    double sum = 0.0;
    for (size_t i = 0; i < lights->n; i++)
        lights->light[i].share = sum += lights->light[i].source->flux;
    for (size_t i = 0; i < lights->n; i++)
        lights->light[i].share /= sum;
}

static bool has_area(const struct rmap_source *source)
{
    return source->type == RMAP_SOURCE_AREA || source->shape == RMAP_EMITTER_BODY;
}

enum rmap_status rmap_lights_create(const struct rmap_scene *scene, struct rmap_lights **lights_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_lights *lights = rmap_alloc(1, sizeof *lights);
    struct rmap_light *light = rmap_alloc(scene->n_source, sizeof *light);
    if (!lights || !light) {
        rmap_free(lights);
        rmap_free(light);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the lights");
    }
    *lights = (struct rmap_lights){
        .scene = scene, .light = light, .unit_m2 = scene->unit_m * scene->unit_m};
    for (int area = 1; area >= 0; area--)
        for (size_t s = 0; s < scene->n_source; s++) {
            const struct rmap_source *source = &scene->source[s];
            if (rmap_source_is_unseen(source))
                lights->n_unseen += (size_t)area;
            else if (has_area(source) == area)
                RMAP_TRY(make_light(lights, source, &light[lights->n++], err));
            lights->four_numbers |= source->type == RMAP_SOURCE_LAMP || source->sky;
            lights->n_sky += (source->sky != NULL) * (size_t)area;
            if (!has_area(source) || !area)
                continue;
            lights->n_area++;
            lights->four_numbers |= source->shape == RMAP_EMITTER_MESH;
            lights->n_bent += source->gradient > 0;
        }
    lights->four_numbers |= lights->n > RMAP_LIGHT_DRAWS;
    share_out(lights);
    *lights_ret = lights;
    lights = NULL;
out:
    rmap_lights_destroy(lights);
    return st;
}

void rmap_lights_destroy(struct rmap_lights *lights)
{
    if (!lights)
        return;
    rmap_free(lights->light);
    rmap_free(lights);
}

/* ---- looked at from a point ---- */

static bool see_point(const struct rmap_lights *lights, struct rmap_vec3 from,
                      struct rmap_light_sample *sample)
{
    const struct rmap_source *source = sample->light->source;
    struct rmap_vec3 away = rmap_sub(source->frame.t, from);
    double square = rmap_dot(away, away), factor = 1.0;
    if (!(square > 0.0))
        return false;
    sample->distance = sqrt(square);
    sample->direction = rmap_scale(away, 1.0 / sample->distance);
    double cosine = -rmap_dot(sample->direction, sample->light->normal);
    if (source->distribution == RMAP_DISTRIBUTION_CONE && cosine < cos(source->cone_rad))
        return false;
    if (source->distribution == RMAP_DISTRIBUTION_COSINE)
        factor = cosine > 0.0 ? pow(cosine, source->cosine_power) : 0.0;
    if (source->distribution == RMAP_DISTRIBUTION_TABLE)
        factor = rmap_profile_intensity(&source->profile, 1.0 - cosine);
    sample->irradiance = sample->light->strength * factor / (square * lights->unit_m2);
    return sample->irradiance > 0.0;
}

/* As bright all over as it is seen from a direction; of a mesh each part sends the same. */
static bool see_lamp(const struct rmap_lights *lights, struct rmap_vec3 from, const double u[4],
                     struct rmap_light_sample *sample)
{
    const struct rmap_light *light = sample->light;
    const struct rmap_source *source = light->source;
    struct rmap_vec3 facing = {0.0, 0.0, 0.0}, point;
    if (source->shape == RMAP_EMITTER_MESH)
        point = rmap_source_point(lights->scene, source, u, &facing);
    else
        point = rmap_affine_point(&source->frame, rmap_lamp_surface(source->lamp, u, &facing));
    const struct rmap_vec3 away = rmap_sub(point, from);
    const double square = rmap_dot(away, away);
    if (!(square > 0.0))
        return false;
    sample->distance = sqrt(square);
    sample->direction = rmap_scale(away, 1.0 / sample->distance);
    const struct rmap_vec3 way =
        rmap_affine_vector(&light->to_local, rmap_scale(sample->direction, -1.0));
    const double intensity = light->strength * rmap_lamp_intensity(source->lamp, way),
                 area = source->shape == RMAP_EMITTER_BODY ? rmap_lamp_seen_area(source->lamp, way)
                                                           : 0.0;
    sample->irradiance = area > 0.0 ? intensity / (area * lights->unit_m2) *
                                          fmax(rmap_dot(facing, way), 0.0) / square
                                    : intensity / (square * lights->unit_m2);
    return sample->irradiance > 0.0;
}

static bool in_shape(const struct rmap_source *source, double x, double y)
{
    const double *size = source->shape_size;
    if (source->shape == RMAP_EMITTER_DISC)
        return x * x + y * y <= size[0] * size[0];
    return fabs(x) <= 0.5 * size[0] && fabs(y) <= 0.5 * size[1];
}

/* Frames of all but meshes are rigid. The radiance of a beam of some angular diameter is the same
 * all over its cone; one direction of it is looked along. */
static bool see_beam(struct rmap_vec3 from, const double u[4], struct rmap_light_sample *sample)
{
    const struct rmap_light *light = sample->light;
    const struct rmap_source *source = light->source;
    struct rmap_vec3 along = rmap_vec3(0.0, 0.0, 1.0);
    if (!rmap_source_is_parallel(source))
        along = rmap_source_about_axis(source, u);
    struct rmap_vec3 local = rmap_affine_point(&light->to_local, from);
    sample->distance = local.z / along.z;
    if (!(local.z > 0.0) || !in_shape(source, local.x - along.x * sample->distance,
                                      local.y - along.y * sample->distance))
        return false;
    sample->direction = rmap_affine_vector(&source->frame, rmap_scale(along, -1.0));
    sample->irradiance = light->strength / along.z;
    return true;
}

static bool see_area(const struct rmap_lights *lights, struct rmap_vec3 from, const double u[4],
                     struct rmap_light_sample *sample)
{
    const struct rmap_light *light = sample->light;
    struct rmap_vec3 point, normal = light->normal;
    if (light->source->shape == RMAP_EMITTER_MESH)
        point = rmap_source_point(lights->scene, light->source, u, &normal);
    else
        point = rmap_source_flat_point(light->source, u);
    struct rmap_vec3 away = rmap_sub(point, from);
    double square = rmap_dot(away, away);
    double towards = -rmap_dot(away, normal);
    if (!(square > 0.0) || !(towards > 0.0))
        return false;
    sample->distance = sqrt(square);
    double inverse = 1.0 / sample->distance;
    sample->direction = rmap_scale(away, inverse);
    sample->irradiance = light->strength * light->area * towards * (inverse * inverse * inverse);
    return true;
}

static bool see_sky(const struct rmap_lights *lights, struct rmap_vec3 from, const double u[4],
                    struct rmap_light_sample *sample)
{
    struct rmap_sky_look look;
    rmap_sky_look(sample->light->source, from, u, lights->scene->channels.n, sample->own, &look);
    sample->direction = look.towards;
    sample->distance = look.distance;
    sample->irradiance = look.irradiance;
    sample->colour = sample->own;
    return look.irradiance > 0.0;
}

int rmap_lights_n_draw(const struct rmap_lights *lights)
{
    return lights->n < RMAP_LIGHT_DRAWS ? (int)lights->n : RMAP_LIGHT_DRAWS;
}

/* First light whose cumulative share exceeds u. */
static size_t pick(const struct rmap_lights *lights, double u, double *probability)
{
    size_t low = 0, high = lights->n - 1;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (lights->light[middle].share > u)
            high = middle;
        else
            low = middle + 1;
    }
    *probability = lights->light[low].share - (low > 0 ? lights->light[low - 1].share : 0.0);
    return low;
}

bool rmap_lights_draw(const struct rmap_lights *lights, int draw, struct rmap_vec3 from,
                      const double u[4], struct rmap_light_sample *sample)
{
    size_t chosen = (size_t)draw;
    double probability = 0.0, factor = 1.0;
    bool seen = false;
    if (lights->n > RMAP_LIGHT_DRAWS) {
        chosen = pick(lights, u[3], &probability);
        factor = 1.0 / (RMAP_LIGHT_DRAWS * probability);
    }
    sample->light = &lights->light[chosen];
    sample->colour = sample->light->source->colour;
    switch (sample->light->source->type) {
    case RMAP_SOURCE_POINT:
        seen = see_point(lights, from, sample);
        break;
    case RMAP_SOURCE_LAMP:
        seen = see_lamp(lights, from, u, sample);
        break;
    case RMAP_SOURCE_COLLIMATED:
        seen = see_beam(from, u, sample);
        break;
    case RMAP_SOURCE_AREA:
        seen = see_area(lights, from, u, sample);
        break;
    case RMAP_SOURCE_SKY:
    case RMAP_SOURCE_SUN:
        seen = see_sky(lights, from, u, sample);
        break;
    case RMAP_SOURCE_RAYS:
    case RMAP_SOURCE_STEPS:
    case RMAP_SOURCE_VOLUME:
    case RMAP_SOURCE_BEAM:
        break;
    }
    sample->irradiance *= factor;
    return seen;
}

/* ---- met by a segment ---- */

/* From the side to which the triangle's normal points (Moeller & Trumbore 1997,
 * doi:10.1080/10867651.1997.10487468). */
static bool meet_triangle(const struct rmap_vec3 corner[3], const struct rmap_way *way,
                          double *distance)
{
    struct rmap_vec3 a = rmap_sub(corner[1], corner[0]), b = rmap_sub(corner[2], corner[0]);
    struct rmap_vec3 p = rmap_cross(way->direction, b), start = rmap_sub(way->from, corner[0]);
    double determinant = rmap_dot(a, p);
    if (!(determinant > 0.0))
        return false;
    double u = rmap_dot(start, p) / determinant;
    struct rmap_vec3 q = rmap_cross(start, a);
    double v = rmap_dot(way->direction, q) / determinant;
    *distance = rmap_dot(b, q) / determinant;
    return u >= 0.0 && v >= 0.0 && u + v <= 1.0 && *distance > way->after &&
           *distance <= way->length;
}

static bool meet_mesh(const struct rmap_lights *lights, const struct rmap_light *light,
                      const struct rmap_way *way, double *distance)
{
    const struct rmap_mesh *mesh = lights->scene->geometry[light->source->shape_geometry].mesh;
    struct rmap_vec3 centre = rmap_sub(light->centre, way->from);
    double along = rmap_dot(centre, way->direction), t;
    double aside = rmap_dot(centre, centre) - along * along;
    if (aside > light->radius * light->radius || along + light->radius < way->after)
        return false;
    bool mirrored = rmap_affine_determinant(&light->source->frame) < 0.0, met = false;
    struct rmap_way rest = *way;
    rest.length += light->bulge; /* a body that it is lies in front of its triangles */
    for (size_t i = 0; i < mesh->n_triangle; i++) {
        struct rmap_vec3 local[3], corner[3];
        rmap_mesh_corners(mesh, i, local);
        for (int k = 0; k < 3; k++)
            corner[mirrored ? 2 - k : k] = rmap_affine_point(&light->source->frame, local[k]);
        if (!meet_triangle(corner, &rest, &t))
            continue;
        *distance = rest.length = t;
        met = true;
    }
    return met;
}

double rmap_light_radiance(const struct rmap_lights *lights, const struct rmap_light *light,
                           struct rmap_vec3 direction)
{
    const struct rmap_source *source = light->source;
    if (source->shape != RMAP_EMITTER_BODY)
        return light->strength;
    const struct rmap_vec3 way = rmap_affine_vector(&light->to_local, rmap_scale(direction, -1.0));
    const double area = rmap_lamp_seen_area(source->lamp, way) * lights->unit_m2;
    return area > 0.0 ? light->strength * rmap_lamp_intensity(source->lamp, way) / area : 0.0;
}

bool rmap_light_met(const struct rmap_lights *lights, const struct rmap_light *light,
                    const struct rmap_way *way, double *distance)
{
    if (light->source->shape == RMAP_EMITTER_MESH)
        return meet_mesh(lights, light, way, distance);
    struct rmap_vec3 start = rmap_affine_point(&light->to_local, way->from);
    struct rmap_vec3 to = rmap_affine_vector(&light->to_local, way->direction);
    if (light->source->shape == RMAP_EMITTER_BODY) {
        *distance = rmap_lamp_entered(light->source->lamp, start, to);
        return *distance > way->after && *distance <= way->length;
    }
    if (!(start.z > 0.0) || !(to.z < 0.0))
        return false;
    *distance = -start.z / to.z;
    return *distance > way->after && *distance <= way->length &&
           in_shape(light->source, start.x + *distance * to.x, start.y + *distance * to.y);
}

/* SPDX-License-Identifier: MIT
 *
 * Places in a body, along a track, or in the cells of a grid.
 */
#include "scene/volume.h"

#include "base/alloc.h"
#include "base/rng.h"
#include "base/search.h"
#include "scene/scene.h"

void rmap_volume_fini(struct rmap_volume *volume)
{
    rmap_grid_drop(volume->grid);
    rmap_free(volume->below);
    rmap_free(volume->part);
    *volume = (struct rmap_volume){.on_object = -1, .on_group = -1};
}

enum rmap_status rmap_volume_take_grid(struct rmap_volume *volume, struct rmap_grid *grid,
                                       struct rmap_error *err)
{
    const size_t n = rmap_grid_count(grid);
    double sum = 0.0;
    volume->below = rmap_alloc(n, sizeof *volume->below);
    if (!volume->below)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a grid of %zu numbers", n);
    for (size_t i = 0; i < n; i++) {
        const double value = grid->value[i];
        if (value < 0.0)
            return rmap_error_set(err, RMAP_INPUT, "the grid has %g: light is 0 or more", value);
        volume->below[i] = sum += value > 0.0 ? value : 0.0; /* a hole is dark */
    }
    if (!(sum > 0.0 && sum < 1e300))
        return rmap_error_set(err, RMAP_INPUT, "the grid has no light: its numbers add up to %g",
                              sum);
    volume->grid = rmap_grid_hold(grid);
    return RMAP_OK;
}

/* ---- where a line meets a part first ---- */

struct crossing {
    double t; /* > 0 */
    bool front;
};

static void offer(struct crossing *nearest, double t, bool front)
{
    if (t > 0.0 && t < nearest->t)
        *nearest = (struct crossing){t, front};
}

/* Moeller & Trumbore 1997, doi:10.1080/10867651.1997.10487468, from both sides. */
static void cross_mesh(const struct rmap_mesh *mesh, struct rmap_vec3 o, struct rmap_vec3 d,
                       struct crossing *nearest)
{
    for (size_t i = 0; i < mesh->n_triangle; i++) {
        struct rmap_vec3 c[3];
        rmap_mesh_corners(mesh, i, c);
        const struct rmap_vec3 a = rmap_sub(c[1], c[0]), b = rmap_sub(c[2], c[0]),
                               p = rmap_cross(d, b), s = rmap_sub(o, c[0]), q = rmap_cross(s, a);
        const double determinant = rmap_dot(a, p);
        if (determinant == 0.0)
            continue;
        const double u = rmap_dot(s, p) / determinant, v = rmap_dot(d, q) / determinant;
        if (u >= 0.0 && v >= 0.0 && u + v <= 1.0)
            offer(nearest, rmap_dot(b, q) / determinant, determinant > 0.0);
    }
}

/* Roots of a t^2 + 2 b t + c, whose surface is left at the greater one where a > 0. */
static void cross_quadratic(double a, double b, double c, const double z[2], double length,
                            struct crossing *nearest)
{
    const double root = b * b - a * c;
    if (!(root >= 0.0) || a == 0.0)
        return;
    for (int k = 0; k < 2; k++) {
        const double t = (-b + (k ? sqrt(root) : -sqrt(root))) / a, at = z[0] + t * z[1];
        if (length < 0.0 || (at >= 0.0 && at <= length))
            offer(nearest, t, a * t + b < 0.0);
    }
}

static double conic_sag(const struct rmap_shape *shape, double square)
{
    const double c = shape->curvature, under = 1.0 - (1.0 + shape->conic) * c * c * square;
    double sum = 0.0;
    for (int i = shape->n_asphere; i-- > 0;)
        sum = (sum + shape->asphere[i]) * square;
    return c * square / (1.0 + sqrt(under > 0.0 ? under : 0.0)) + sum;
}

static void cross_shape(const struct rmap_shape *shape, struct rmap_vec3 o, struct rmap_vec3 d,
                        struct crossing *nearest)
{
    const double z[2] = {o.z, d.z};
    const double t = -o.z / d.z, x = o.x + t * d.x, y = o.y + t * d.y;
    switch (shape->type) {
    case RMAP_SHAPE_CONIC: { /* along its axis, as lenses are looked through */
        const double square = o.x * o.x + o.y * o.y;
        if (square <= shape->aperture * shape->aperture && square >= shape->inner * shape->inner)
            offer(nearest, (conic_sag(shape, square) - o.z) / d.z, d.z < 0.0);
        break;
    }
    case RMAP_SHAPE_DISC: {
        const double square = x * x + y * y;
        if (square <= shape->aperture * shape->aperture && square >= shape->inner * shape->inner)
            offer(nearest, t, d.z < 0.0);
        break;
    }
    case RMAP_SHAPE_RECTANGLE:
        if (x * x <= 0.25 * shape->size[0] * shape->size[0] &&
            y * y <= 0.25 * shape->size[1] * shape->size[1])
            offer(nearest, t, d.z < 0.0);
        break;
    case RMAP_SHAPE_TUBE: {
        const double slope = (shape->radius2 - shape->radius) / shape->length,
                     radius = shape->radius + slope * o.z, turn = slope * d.z;
        cross_quadratic(d.x * d.x + d.y * d.y - turn * turn, o.x * d.x + o.y * d.y - radius * turn,
                        o.x * o.x + o.y * o.y - radius * radius, z, shape->length, nearest);
        break;
    }
    case RMAP_SHAPE_SPHERE:
        cross_quadratic(rmap_dot(d, d), rmap_dot(o, d),
                        rmap_dot(o, o) - shape->radius * shape->radius, z, -1.0, nearest);
        break;
    case RMAP_SHAPE_SAG:
    case RMAP_SHAPE_WALL: {
        struct rmap_shape_hit hit;
        if (rmap_shape_intersect(shape, o, d, false, 0.0, HUGE_VAL, &hit))
            offer(nearest, hit.t, rmap_dot(hit.normal, d) < 0.0);
        break;
    }
    }
}

/* Along the first part's z, what is met first shows on which side of it the place lies. */
static bool is_inside(const struct rmap_scene *scene, const struct rmap_volume *volume,
                      struct rmap_vec3 place)
{
    const struct rmap_object *first = &scene->object[volume->part[0]], *met = NULL;
    const struct rmap_vec3 way = rmap_affine_vector(&first->to_world, rmap_vec3(0.0, 0.0, 1.0));
    struct crossing nearest = {.t = HUGE_VAL};
    for (size_t k = 0; k < volume->n_part; k++) {
        const struct rmap_object *object = &scene->object[volume->part[k]];
        const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
        const struct rmap_vec3 o = rmap_affine_point(&object->to_local, place),
                               d = rmap_affine_vector(&object->to_local, way);
        const double before = nearest.t;
        if (geometry->kind == RMAP_GEOMETRY_MESH)
            cross_mesh(geometry->mesh, o, d, &nearest);
        else
            cross_shape(&geometry->shape, o, d, &nearest);
        met = nearest.t < before ? object : met;
    }
    if (!met || !volume->is_lens)
        return met && !nearest.front;
    const int32_t medium = nearest.front ? met->medium_front : met->medium_back;
    return medium >= 0 && medium != met->medium_outside;
}

/* ---- the body ---- */

/* Is the object a part of it? */
static bool closes(const struct rmap_scene *scene, const struct rmap_volume *volume, int32_t object)
{
    return object == volume->on_object ||
           (volume->on_group >= 0 && rmap_scene_in_group(scene, object, volume->on_group));
}

/* A face of a lens. */
static bool is_cap(const struct rmap_scene *scene, int32_t object)
{
    const struct rmap_geometry *geometry = &scene->geometry[scene->object[object].geometry];
    return geometry->kind == RMAP_GEOMETRY_SHAPE &&
           (geometry->shape.type == RMAP_SHAPE_CONIC || geometry->shape.type == RMAP_SHAPE_SAG);
}

static enum rmap_status find_parts(const struct rmap_scene *scene, struct rmap_volume *volume,
                                   struct rmap_error *err)
{
    rmap_free(volume->part);
    volume->n_part = 0;
    volume->is_lens = false;
    volume->part = rmap_alloc(scene->n_object + 1, sizeof *volume->part);
    if (!volume->part)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a body");
    for (int32_t i = 0; i < (int32_t)scene->n_object; i++) {
        if (!closes(scene, volume, i))
            continue;
        volume->part[volume->n_part++] = i;
        volume->is_lens = volume->is_lens || is_cap(scene, i);
    }
    return RMAP_OK;
}

/* In the frame of the first part. */
static void enclose(const struct rmap_scene *scene, const struct rmap_volume *volume,
                    struct rmap_affine *box)
{
    const struct rmap_object *first = &scene->object[volume->part[0]];
    double low[3] = {HUGE_VAL, HUGE_VAL, HUGE_VAL}, high[3] = {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL};
    for (size_t k = 0; k < volume->n_part; k++) {
        const struct rmap_object *object = &scene->object[volume->part[k]];
        const struct rmap_affine to = rmap_affine_compose(&first->to_local, &object->to_world);
        struct rmap_vec3 end[2];
        rmap_geometry_bounds(&scene->geometry[object->geometry], &end[0], &end[1]);
        for (int c = 0; c < 8; c++) {
            const struct rmap_vec3 p =
                rmap_affine_point(&to, rmap_vec3(end[c & 1].x, end[c >> 1 & 1].y, end[c >> 2].z));
            const double at[3] = {p.x, p.y, p.z};
            for (int i = 0; i < 3; i++) {
                low[i] = rmap_min(low[i], at[i]);
                high[i] = rmap_max(high[i], at[i]);
            }
        }
    }
    *box = (struct rmap_affine){
        {{high[0] - low[0], 0, 0}, {0, high[1] - low[1], 0}, {0, 0, high[2] - low[2]}},
        {low[0], low[1], low[2]}};
}

/* A place in the box, in the world, and whether it lies inside. */
static bool try_place(const struct rmap_scene *scene, const struct rmap_source *source,
                      const double u[3], struct rmap_vec3 *place)
{
    const struct rmap_object *first = &scene->object[source->volume->part[0]];
    *place = rmap_affine_point(&first->to_world,
                               rmap_affine_point(&source->frame, rmap_vec3(u[0], u[1], u[2])));
    return is_inside(scene, source->volume, *place);
}

enum { TRIES = 4096 };

static struct rmap_vec3 draw_in_body(const struct rmap_scene *scene,
                                     const struct rmap_source *source, uint64_t seed, uint64_t ray)
{
    struct rmap_vec3 place = rmap_vec3(0.0, 0.0, 0.0);
    double u[4];
    for (int k = 0; k < TRIES; k++) {
        rmap_rng(seed, ray, 0, (enum rmap_rng_slot)(RMAP_RNG_VOLUME + k), u);
        if (try_place(scene, source, u, &place))
            break;
    }
    return place;
}

enum rmap_status rmap_volume_finish(const struct rmap_scene *scene, struct rmap_source *source,
                                    struct rmap_error *err)
{
    enum { LEAST = 16 }; /* of so many times TRIES places: all tries of a ray never fail then */
    struct rmap_volume *volume = source->volume;
    if (volume->kind != RMAP_VOLUME_BODY)
        return RMAP_OK;
    const enum rmap_status st = find_parts(scene, volume, err);
    if (st != RMAP_OK)
        return st;
    if (volume->n_part == 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "source '%s': the body that it fills is not in the scene; leave the "
                              "source out, too",
                              source->name);
    enclose(scene, volume, &source->frame);
    size_t n_inside = 0;
    for (uint64_t i = 0; i < TRIES && n_inside < LEAST; i++) {
        struct rmap_vec3 place;
        double u[4];
        rmap_rng(1, i, 0, RMAP_RNG_VOLUME, u);
        n_inside += try_place(scene, source, u, &place);
    }
    return n_inside >= LEAST
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT,
                                "source '%s': of %d places in the box about the body %zu lie "
                                "inside: it must be closed, its normals outwards, and fill its box",
                                source->name, TRIES, n_inside);
}

int32_t rmap_volume_medium(const struct rmap_scene *scene, const struct rmap_volume *volume)
{
    int32_t medium = -1;
    for (int32_t i = 0; i < (int32_t)scene->n_object; i++) {
        const struct rmap_object *object = &scene->object[i];
        const bool cap = is_cap(scene, i);
        if (!closes(scene, volume, i))
            continue;
        const int32_t side[2] = {object->medium_back, cap ? object->medium_front : -1};
        for (int k = 0; k < 2; k++) {
            if (side[k] < 0 || (cap && side[k] == object->medium_outside) || side[k] == medium)
                continue;
            if (medium >= 0)
                return -1;
            medium = side[k];
        }
    }
    return medium;
}

/* ---- places ---- */

static struct rmap_vec3 draw_in_grid(const struct rmap_source *source, const double u[4])
{
    const struct rmap_grid *grid = source->volume->grid;
    const size_t n = rmap_grid_count(grid);
    const size_t node =
        rmap_first_above(source->volume->below, n, u[3] * source->volume->below[n - 1]);
    const size_t k = node % grid->n[2], j = node / grid->n[2] % grid->n[1],
                 i = node / grid->n[2] / grid->n[1];
    return rmap_affine_point(
        &source->frame, rmap_vec3(grid->origin.x + ((double)i + u[0] - 0.5) * grid->spacing.x,
                                  grid->origin.y + ((double)j + u[1] - 0.5) * grid->spacing.y,
                                  grid->origin.z + ((double)k + u[2] - 0.5) * grid->spacing.z));
}

struct rmap_vec3 rmap_volume_draw(const struct rmap_scene *scene, const struct rmap_source *source,
                                  uint64_t seed, uint64_t ray)
{
    double u[4];
    if (source->volume->kind == RMAP_VOLUME_BODY)
        return draw_in_body(scene, source, seed, ray);
    rmap_rng(seed, ray, 0, RMAP_RNG_EMIT_POINT, u);
    return source->volume->kind == RMAP_VOLUME_GRID
               ? draw_in_grid(source, u)
               : rmap_affine_point(&source->frame, rmap_vec3(0.0, 0.0, u[0]));
}

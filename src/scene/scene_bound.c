/* SPDX-License-Identifier: MIT
 *
 * The bounding sphere of a scene.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "scene/bounds.h"
#include "scene/vertex_grid.h"

static void include_source(struct rmap_bounds *box, const struct rmap_scene *scene,
                           const struct rmap_source *source)
{
    if (source->type == RMAP_SOURCE_RAYS) {
        for (size_t i = 0; i < source->n_list; i++)
            rmap_bounds_include(box, source->list[i].origin);
        if (source->rays)
            rmap_bounds_include_box(box, &source->frame, source->rays->lower, source->rays->upper);
        return;
    }
    if (source->type == RMAP_SOURCE_STEPS) {
        for (size_t i = 0; source->steps && i < source->steps->n; i++) {
            const struct rmap_track_step *step = &source->steps->step[i];
            rmap_bounds_include(box, step->position);
            rmap_bounds_include(box, rmap_axpy(step->length, step->direction, step->position));
        }
        return;
    }
    if (source->volume && source->volume->grid) {
        const struct rmap_grid *grid = source->volume->grid;
        const struct rmap_vec3 half = rmap_scale(grid->spacing, 0.5);
        rmap_bounds_include_box(
            box, &source->frame, rmap_sub(grid->origin, half),
            rmap_add(grid->origin, rmap_vec3(((double)grid->n[0] - 0.5) * grid->spacing.x,
                                             ((double)grid->n[1] - 0.5) * grid->spacing.y,
                                             ((double)grid->n[2] - 0.5) * grid->spacing.z)));
        return;
    }
    if (source->volume) { /* a body is bounded with the objects */
        for (int k = 0; source->volume->kind == RMAP_VOLUME_TRACK && k < 2; k++)
            rmap_bounds_include(box, rmap_affine_point(&source->frame, rmap_vec3(0, 0, k)));
        return;
    }
    if (source->shape == RMAP_EMITTER_MESH) {
        rmap_bounds_include_geometry(box, &scene->geometry[source->shape_geometry], &source->frame);
        return;
    }
    if (source->sky) /* its sphere is about all the rest */
        return;
    const struct rmap_vec3 half = rmap_source_half_size(source);
    rmap_bounds_include_box(box, &source->frame, rmap_scale(half, -1.0), half);
}

static double box_radius(const struct rmap_bounds *box)
{
    return 0.5 * rmap_length(rmap_sub(box->upper, box->lower));
}

/* How far from the origin a box reaches along an axis. */
static double box_reach(const struct rmap_bounds *box)
{
    struct rmap_vec3 far = rmap_greatest(box->upper, rmap_scale(box->lower, -1.0));
    return box->infinite ? HUGE_VAL : fmax(far.x, fmax(far.y, far.z));
}

static const char *object_place(const struct rmap_object *object, char text[32])
{
    text[0] = 0;
    if (object->line > 0)
        (void)snprintf(text, 32, " (line %d)", (int)object->line);
    return text;
}

enum rmap_status rmap_object_invert(struct rmap_object *object, struct rmap_error *err)
{
    char place[32];
    if (rmap_affine_invert(&object->to_world, &object->to_local))
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT,
                          "object '%s'%s: its transform, with its groups', has no inverse: "
                          "no scale may be 0, very small or very large",
                          object->name ? object->name : "", object_place(object, place));
}

void rmap_scene_bound_object(struct rmap_scene *scene, size_t i)
{
    const struct rmap_object *object = &scene->object[i];
    scene->object_bounds[i] = rmap_bounds_empty();
    rmap_bounds_include_geometry(&scene->object_bounds[i], &scene->geometry[object->geometry],
                                 &object->to_world);
}

/* Of so many vertices in all of a mesh's instances a grid is made in less time than it saves. */
#define WORTH_A_GRID 20000

static bool is_worth_a_grid(const struct rmap_geometry *geometry, size_t n_instance)
{
    return geometry->kind == RMAP_GEOMETRY_MESH && !geometry->mesh->surface && n_instance >= 4 &&
           geometry->mesh->n_vertex >= WORTH_A_GRID / n_instance;
}

/* As they are known, or as the object stands in the scene of before: at the same number, or at that
 * from the end. */
static bool take_bounds(struct rmap_scene *scene, size_t i)
{
    const struct rmap_scene *before = scene->before;
    const struct rmap_object *object = &scene->object[i];
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    if (geometry->kind != RMAP_GEOMETRY_MESH)
        return false;
    if (scene->known_box && !geometry->mesh->surface) {
        const double *box = &scene->known_box[6 * i];
        scene->object_bounds[i] = (struct rmap_bounds){.lower = rmap_vec3(box[0], box[1], box[2]),
                                                       .upper = rmap_vec3(box[3], box[4], box[5])};
        return true;
    }
    if (!before)
        return false;
    for (size_t at = i, tries = 0; tries < 2;
         tries++, at = before->n_object - (scene->n_object - i)) {
        const struct rmap_object *old = at < before->n_object ? &before->object[at] : NULL;
        if (!old || before->geometry[old->geometry].mesh != geometry->mesh ||
            memcmp(&old->to_world, &object->to_world, sizeof old->to_world) != 0)
            continue;
        scene->object_bounds[i] = before->object_bounds[at];
        return true;
    }
    return false;
}

enum rmap_status rmap_scene_bound_objects(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t *n_instance = rmap_alloc(scene->n_geometry, sizeof *n_instance);
    struct rmap_vertex_grid **grid =
        rmap_alloc(scene->n_geometry, sizeof(struct rmap_vertex_grid *));
    bool *is_known = rmap_alloc(scene->n_object, sizeof *is_known);
    rmap_free(scene->object_bounds);
    scene->object_bounds = rmap_alloc(scene->n_object, sizeof *scene->object_bounds);
    if (!scene->object_bounds || !n_instance || !grid || !is_known)
        RMAP_TRY(
            rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu objects", scene->n_object));
    for (size_t i = 0; i < scene->n_object; i++)
        if (!(is_known[i] = take_bounds(scene, i)))
            n_instance[scene->object[i].geometry]++;
    for (size_t i = 0; i < scene->n_geometry; i++) /* without memory there is none */
        if (is_worth_a_grid(&scene->geometry[i], n_instance[i]))
            grid[i] = rmap_vertex_grid_create(scene->geometry[i].mesh);
    for (size_t i = 0; i < scene->n_object; i++) {
        if (is_known[i])
            continue;
        const struct rmap_object *object = &scene->object[i];
        const struct rmap_vertex_grid *own = grid[object->geometry];
        if (!own || !rmap_vertex_grid_bounds(own, &object->to_world, &scene->object_bounds[i]))
            rmap_scene_bound_object(scene, i);
    }
out:
    for (size_t i = 0; grid && i < scene->n_geometry; i++)
        rmap_vertex_grid_destroy(grid[i]);
    rmap_free(grid);
    rmap_free(is_known);
    rmap_free(n_instance);
    return st;
}

/* All objects together are too large: the one that reaches farthest is named. */
static enum rmap_status too_large(const struct rmap_scene *scene, struct rmap_error *err)
{
    size_t farthest = 0;
    char place[32];
    for (size_t i = 1; i < scene->n_object; i++)
        if (box_reach(&scene->object_bounds[i]) > box_reach(&scene->object_bounds[farthest]))
            farthest = i;
    const struct rmap_object *object = &scene->object[farthest];
    return rmap_error_set(err, RMAP_INPUT,
                          "object '%s'%s reaches %.3g %s from the origin: all objects must fit "
                          "in a sphere of %g %s; check its scale, its place and its size",
                          object->name ? object->name : "", object_place(object, place),
                          box_reach(&scene->object_bounds[farthest]), scene->unit,
                          RMAP_OBJECTS_RADIUS_MAX, scene->unit);
}

/* The box about all objects; without calls, as they are many. */
static enum rmap_status include_objects(const struct rmap_scene *scene, struct rmap_bounds *box,
                                        struct rmap_error *err)
{
    bool any = false;
    for (size_t i = 0; i < scene->n_object; i++) {
        const struct rmap_bounds *own = &scene->object_bounds[i];
        if (own->lower.x > own->upper.x)
            continue; /* nothing at all */
        any = true;
        box->infinite |= own->infinite;
        box->lower = rmap_vec3(own->lower.x < box->lower.x ? own->lower.x : box->lower.x,
                               own->lower.y < box->lower.y ? own->lower.y : box->lower.y,
                               own->lower.z < box->lower.z ? own->lower.z : box->lower.z);
        box->upper = rmap_vec3(own->upper.x > box->upper.x ? own->upper.x : box->upper.x,
                               own->upper.y > box->upper.y ? own->upper.y : box->upper.y,
                               own->upper.z > box->upper.z ? own->upper.z : box->upper.z);
    }
    if (any && (box->infinite || !(box_radius(box) < RMAP_OBJECTS_RADIUS_MAX)))
        return too_large(scene, err);
    return RMAP_OK;
}

enum rmap_status rmap_scene_bound(struct rmap_scene *scene, struct rmap_error *err)
{
    struct rmap_bounds box = rmap_bounds_empty();
    enum rmap_status st = include_objects(scene, &box, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < scene->n_source; i++)
        include_source(&box, scene, &scene->source[i]);
    for (size_t i = 0; i < scene->n_detector; i++)
        rmap_bounds_include_detector(&box, &scene->detector[i]);
    if (box.lower.x > box.upper.x) /* nothing at all */
        box.lower = box.upper = rmap_vec3(0.0, 0.0, 0.0);
    if (box.infinite)
        return rmap_error_set(err, RMAP_INPUT,
                              "the scene reaches to infinity: a position or size is not finite");
    if (!(box_reach(&box) < RMAP_SCENE_REACH_MAX))
        return rmap_error_set(err, RMAP_INPUT,
                              "a source or detector reaches %.3g %s from the origin: positions are "
                              "stored up to %g; check its place and its size",
                              box_reach(&box), scene->unit, RMAP_SCENE_REACH_MAX);
    struct rmap_vec3 half = rmap_scale(rmap_sub(box.upper, box.lower), 0.5);
    scene->centre = rmap_add(box.lower, half);
    /* Margin: leaving rays end clear of the outermost surface; 1 for a scene that is a point. */
    double radius = 1.001 * rmap_length(half);
    scene->radius = radius > 0.0 ? radius : 1.0;
    for (size_t i = 0; i < scene->n_source; i++)
        if (scene->source[i].sky) /* the edge of a disc that touches the sphere */
            scene->radius =
                fmax(scene->radius,
                     1.001 * (rmap_length(rmap_sub(scene->source[i].frame.t, scene->centre)) +
                              sqrt(2.0) * scene->source[i].shape_size[0]));
    return RMAP_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * What a scene says implicitly: inverse transforms, areas, the bounding sphere, which ray id
 * belongs to which source, which detectors lie where.
 */
#include <math.h>
#include <stdio.h>

#include "base/alloc.h"
#include "scene/bounds.h"
#include "scene/scene_gradient.h"
#include "scene/schedule.h"

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

/* The box about all objects; of those too large together the one that reaches farthest is named. */
static enum rmap_status bound_objects(const struct rmap_scene *scene, struct rmap_bounds *box,
                                      struct rmap_error *err)
{
    const struct rmap_object *farthest = NULL;
    double reach = 0.0;
    for (size_t i = 0; i < scene->n_object; i++) {
        const struct rmap_object *object = &scene->object[i];
        struct rmap_bounds own = rmap_bounds_empty();
        rmap_bounds_include_geometry(&own, &scene->geometry[object->geometry], &object->to_world);
        if (own.lower.x > own.upper.x)
            continue; /* nothing at all */
        rmap_bounds_include(box, own.lower);
        rmap_bounds_include(box, own.upper);
        box->infinite |= own.infinite;
        if (!farthest || box_reach(&own) > reach) {
            farthest = object;
            reach = box_reach(&own);
        }
    }
    char place[32];
    if (farthest && (box->infinite || !(box_radius(box) < RMAP_OBJECTS_RADIUS_MAX)))
        return rmap_error_set(err, RMAP_INPUT,
                              "object '%s'%s reaches %.3g %s from the origin: all objects must fit "
                              "in a sphere of %g %s; check its scale, its place and its size",
                              farthest->name ? farthest->name : "", object_place(farthest, place),
                              reach, scene->unit, RMAP_OBJECTS_RADIUS_MAX, scene->unit);
    return RMAP_OK;
}

static enum rmap_status bound_scene(struct rmap_scene *scene, struct rmap_error *err)
{
    struct rmap_bounds box = rmap_bounds_empty();
    enum rmap_status st = bound_objects(scene, &box, err);
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

static enum rmap_status invert_transforms(struct rmap_scene *scene, struct rmap_error *err)
{
    for (size_t i = 0; i < scene->n_object; i++) {
        struct rmap_object *object = &scene->object[i];
        char place[32];
        if (!rmap_affine_invert(&object->to_world, &object->to_local))
            return rmap_error_set(err, RMAP_INPUT,
                                  "object '%s'%s: its transform, with its groups', has no inverse: "
                                  "no scale may be 0, very small or very large",
                                  object->name ? object->name : "", object_place(object, place));
    }
    return RMAP_OK;
}

/* Cumulative world areas of the triangles of a mesh source, divided by their sum. */
static enum rmap_status tabulate_areas(struct rmap_scene *scene, struct rmap_source *source,
                                       struct rmap_error *err)
{
    const char *name = source->name ? source->name : "";
    if (source->shape_geometry < 0 || (size_t)source->shape_geometry >= scene->n_geometry ||
        scene->geometry[source->shape_geometry].kind != RMAP_GEOMETRY_MESH)
        return rmap_error_set(err, RMAP_INPUT, "source '%s': its shape is not a mesh", name);
    const struct rmap_mesh *mesh = scene->geometry[source->shape_geometry].mesh;
    rmap_free(source->triangle_cdf);
    source->triangle_cdf = rmap_alloc(mesh->n_triangle, sizeof *source->triangle_cdf);
    if (!source->triangle_cdf)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for source '%s'", name);
    double total = 0.0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3];
        rmap_mesh_corners(mesh, t, corner);
        struct rmap_vec3 a = rmap_affine_vector(&source->frame, rmap_sub(corner[1], corner[0]));
        struct rmap_vec3 b = rmap_affine_vector(&source->frame, rmap_sub(corner[2], corner[0]));
        total += 0.5 * rmap_length(rmap_cross(a, b));
        source->triangle_cdf[t] = total;
    }
    if (!(total > 0.0) || !isfinite(total))
        return rmap_error_set(err, RMAP_INPUT, "source '%s': its mesh has no area", name);
    for (size_t t = 0; t < mesh->n_triangle; t++)
        source->triangle_cdf[t] /= total;
    return RMAP_OK;
}

/* Lists of detectors by kind; those on a group stand with each of its objects. */
static enum rmap_status list_detectors(struct rmap_scene *scene, struct rmap_error *err)
{
    rmap_free(scene->free_detector);
    rmap_free(scene->far_detector);
    rmap_free(scene->on_first);
    rmap_free(scene->on_detector);
    scene->n_free_detector = scene->n_far_detector = 0;
    scene->on_detector = NULL;
    scene->free_detector = rmap_alloc(scene->n_detector, sizeof *scene->free_detector);
    scene->far_detector = rmap_alloc(scene->n_detector, sizeof *scene->far_detector);
    scene->on_first = rmap_alloc(scene->n_object + 1, sizeof *scene->on_first);
    if (!scene->free_detector || !scene->far_detector || !scene->on_first)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of detectors");
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct rmap_detector *detector = &scene->detector[d];
        if (detector->type == RMAP_DETECTOR_INTENSITY)
            scene->far_detector[scene->n_far_detector++] = (int32_t)d;
        else if (!rmap_detector_lies_on(detector))
            scene->free_detector[scene->n_free_detector++] = (int32_t)d;
    }
    for (int pass = 0; pass < 2; pass++) { /* count, then fill */
        size_t n = 0;
        for (size_t o = 0; o < scene->n_object; o++) {
            scene->on_first[o] = n;
            for (size_t d = 0; d < scene->n_detector; d++) {
                if (!rmap_detector_lies_at(scene, &scene->detector[d], o))
                    continue;
                if (pass == 1)
                    scene->on_detector[n] = (int32_t)d;
                n++;
            }
        }
        scene->on_first[scene->n_object] = n;
        if (pass == 0 && !(scene->on_detector = rmap_alloc(n, sizeof *scene->on_detector)))
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of detectors");
    }
    return RMAP_OK;
}

/* Light at a side comes in its medium, or in any. */
static enum rmap_status tabulate_side(struct rmap_scene *scene, const struct rmap_object *object,
                                      bool front, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    const int32_t near = front ? object->medium_front : object->medium_back,
                  far = front ? object->medium_back : object->medium_front;
    const int32_t first = near == RMAP_MEDIUM_ANY ? 0 : near,
                  last = near == RMAP_MEDIUM_ANY ? (int32_t)scene->n_medium - 1 : near;
    for (int way = 0; way < 2; way++) {
        const int32_t row = way ? surface->scatter_transmit : surface->scatter_reflect;
        for (int32_t i = first; row > 0 && i <= last; i++) {
            const int32_t beyond = far == RMAP_MEDIUM_ANY ? i : far;
            RMAP_TRY(rmap_scatter_tabulate(&scene->scatter[row - 1], scene->channels.n, i, beyond,
                                           scene->medium[i].n, scene->medium[beyond].n, err));
        }
    }
out:
    return st;
}

static enum rmap_status tabulate_scatter(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; scene->n_scatter > 0 && i < scene->n_object; i++) {
        RMAP_TRY(tabulate_side(scene, &scene->object[i], true, err));
        RMAP_TRY(tabulate_side(scene, &scene->object[i], false, err));
    }
out:
    return st;
}

static enum rmap_status prepare_steps(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < scene->n_source; i++) {
        struct rmap_source *source = &scene->source[i];
        if (source->type != RMAP_SOURCE_STEPS)
            continue;
        const struct rmap_steps_medium medium = rmap_source_steps_medium(scene, source);
        if (source->steps && source->steps->counted && scene->n_source > 1)
            return rmap_error_set(
                err, RMAP_INPUT,
                "source '%s' has 'count: counted', each ray a photon, and is to be "
                "the only one: leave the others out",
                source->name ? source->name : "");
        st = source->steps ? rmap_steps_prepare(source->steps, &medium, source->colour, err)
                           : rmap_error_set(err, RMAP_INPUT, "it has no steps");
        if (st != RMAP_OK)
            rmap_error_context(err, "source '%s'", source->name ? source->name : "");
        else
            source->flux = rmap_steps_photons(source->steps);
    }
    return st;
}

void rmap_scene_include(struct rmap_scene *scene, const struct rmap_camera *camera)
{
    double away = rmap_length(rmap_sub(camera->at, scene->centre)) + camera->aperture;
    scene->radius = fmax(scene->radius, 1.001 * away);
}

static void set_worth(struct rmap_scene *scene)
{
    const double *nm = scene->channels.wavelength_nm;
    scene->fluoresces = false;
    for (size_t i = 0; i < scene->n_medium; i++)
        scene->fluoresces = scene->fluoresces || scene->medium[i].n_species > 0;
    for (int i = 0; i < scene->channels.n; i++) {
        scene->worth[i] = scene->accounting == RMAP_ACCOUNTING_PHOTONS ? 1.0 : 1.0 / nm[i];
        if (scene->accounting == RMAP_ACCOUNTING_ENERGY && scene->flux_unit == RMAP_FLUX_LM)
            scene->worth[i] *= rmap_luminous_efficiency(nm[i]);
    }
}

enum rmap_status rmap_scene_finish(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(invert_transforms(scene, err));
    for (size_t i = 0; i < scene->n_source; i++)
        if (scene->source[i].shape == RMAP_EMITTER_MESH &&
            scene->source[i].type != RMAP_SOURCE_RAYS)
            RMAP_TRY(tabulate_areas(scene, &scene->source[i], err));
    RMAP_TRY(prepare_steps(scene, err));
    for (size_t i = 0; i < scene->n_source; i++)
        if (scene->source[i].volume)
            RMAP_TRY(rmap_volume_finish(scene, &scene->source[i], err));
    RMAP_TRY(bound_scene(scene, err));
    RMAP_TRY(rmap_scene_place_gradients(scene, err));
    RMAP_TRY(tabulate_scatter(scene, err));
    RMAP_TRY(list_detectors(scene, err));
    set_worth(scene);
    RMAP_TRY(rmap_scene_schedule(scene, err));
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * What a scene says implicitly: inverse transforms, areas, the bounding sphere, which ray id
 * belongs to which source, which detectors lie where.
 */
#include "base/alloc.h"
#include "scene/bounds.h"
#include "scene/scene_gradient.h"
#include "scene/schedule.h"

static enum rmap_status invert_transforms(struct rmap_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < scene->n_object && st == RMAP_OK; i++)
        st = rmap_object_invert(&scene->object[i], err);
    return st;
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
    for (size_t i = 0; scene->n_scatter > 0 && !scene->totals_on_demand && i < scene->n_object;
         i++) {
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
    RMAP_TRY(rmap_scene_bound_objects(scene, err));
    RMAP_TRY(rmap_scene_bound(scene, err));
    RMAP_TRY(rmap_scene_place_gradients(scene, err));
    RMAP_TRY(tabulate_scatter(scene, err));
    RMAP_TRY(list_detectors(scene, err));
    set_worth(scene);
    RMAP_TRY(rmap_scene_schedule(scene, err));
out:
    return st;
}

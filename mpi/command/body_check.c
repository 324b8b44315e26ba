/* SPDX-License-Identifier: MIT
 *
 * What is likely wrong with bodies, found without light.
 */
#include "mpi/command/body_check.h"

#include <math.h>
#include <stdlib.h>

#include "base/alloc.h"
#include "geometry/mesh_edges.h"
#include "scene/bounds.h"

/* ---- meshes that are not closed ---- */

/* Two media, one of which light can be inside of. */
static bool bounds_medium(const struct rmap_scene *scene, const struct rmap_object *object)
{
    return object->medium_front >= 0 && object->medium_back >= 0 &&
           object->medium_front != object->medium_back &&
           rmap_scene_transmits(scene, object->surface_front);
}

static bool boxes_touch(const struct rmap_bounds *a, const struct rmap_bounds *b)
{
    return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
           b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

/* Another object close by has the medium, too, and may close what this one leaves open; so may the
 * other faces of its mesh, which are opaque. */
static bool is_shared(const struct rmap_scene *scene, const struct rmap_bounds *box, size_t object,
                      int32_t medium)
{
    for (size_t i = 0; i < scene->n_object; i++)
        if (i != object &&
            (scene->object[i].medium_back == medium || scene->object[i].medium_front == medium ||
             (scene->object[i].medium_back == RMAP_MEDIUM_ANY &&
              scene->object[i].parent == scene->object[object].parent)) &&
            boxes_touch(&box[i], &box[object]))
            return true;
    return false;
}

static struct rmap_vec3 corner_of(const struct rmap_object *object, const struct rmap_mesh *mesh,
                                  uint32_t vertex)
{
    const float *v = mesh->vertex[vertex];
    return rmap_affine_point(&object->to_world,
                             rmap_vec3((double)v[0], (double)v[1], (double)v[2]));
}

static enum rmap_status check_closed(const struct rmap_scene *scene, const struct rmap_bounds *box,
                                     size_t index, struct rmap_diagnostics *diagnostics,
                                     struct rmap_error *err)
{
    const struct rmap_object *object = &scene->object[index];
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    struct rmap_mesh_edge edge = {0};
    size_t n = 0;
    if (geometry->kind != RMAP_GEOMETRY_MESH || !bounds_medium(scene, object) ||
        is_shared(scene, box, index, object->medium_back))
        return RMAP_OK;
    const enum rmap_status st = rmap_mesh_open_edges(geometry->mesh, &n, &edge, err);
    if (st != RMAP_OK || n == 0)
        return st;
    const struct rmap_vec3 a = corner_of(object, geometry->mesh, edge.from),
                           b = corner_of(object, geometry->mesh, edge.to);
    rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_WARNING, object->line, object->column,
                         "mesh '%s' is not closed around '%s': %zu of its edges belong to one "
                         "triangle alone, or to two that face each other, as that from (%.6g, "
                         "%.6g, %.6g) to (%.6g, %.6g, %.6g); close it, or name the same medium on "
                         "both sides",
                         object->name, scene->medium[object->medium_back].name, n, a.x, a.y, a.z,
                         b.x, b.y, b.z);
    return RMAP_OK;
}

/* ---- meshes in other units ---- */

/* Times that a mesh is larger, or smaller, than all else to be taken for one in other units. */
#define OTHER_UNITS 200.0

static double size_of(const struct rmap_bounds *box)
{
    return rmap_length(rmap_sub(box->upper, box->lower));
}

/* box: [objects]. Sizes of those of other geometries, and of planes that detect. */
static void sizes_of_others(const struct rmap_scene *scene, const struct rmap_bounds *box,
                            int32_t geometry, double *least, double *greatest)
{
    *least = HUGE_VAL;
    *greatest = 0.0;
    for (size_t i = 0; i < scene->n_object; i++) {
        if (scene->object[i].geometry == geometry)
            continue;
        *least = fmin(*least, size_of(&box[i]));
        *greatest = fmax(*greatest, size_of(&box[i]));
    }
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct rmap_detector *detector = &scene->detector[d];
        if (detector->type != RMAP_DETECTOR_PLANE)
            continue;
        const double size = hypot(detector->size[0], detector->size[1]);
        *least = fmin(*least, size);
        *greatest = fmax(*greatest, size);
    }
}

static void check_size(const struct rmap_scene *scene, const struct rmap_bounds *box, size_t index,
                       struct rmap_diagnostics *diagnostics)
{
    const struct rmap_object *object = &scene->object[index];
    double least, greatest;
    if (scene->geometry[object->geometry].kind != RMAP_GEOMETRY_MESH)
        return;
    const double size = size_of(&box[index]);
    sizes_of_others(scene, box, object->geometry, &least, &greatest);
    const bool large = greatest > 0.0 && size > OTHER_UNITS * greatest;
    if (!large && !(least < HUGE_VAL && size * OTHER_UNITS < least))
        return;
    rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_WARNING, object->line, object->column,
                         "mesh '%s' is %.3g %s across, %.3g times %s than all else: is its file in "
                         "another unit? say which with 'scale' of its geometry, as in 'scale: mm'",
                         object->name, size, scene->unit, large ? size / greatest : least / size,
                         large ? "larger" : "smaller");
}

enum rmap_status rmap_bodies_check(const struct rmap_scene *scene,
                                   struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bounds *box = rmap_alloc(scene->n_object + 1, sizeof *box);
    uint8_t *told = rmap_alloc(scene->n_geometry + 1, 1); /* once for all its copies */
    if (!told || !box)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory"));
    for (size_t i = 0; i < scene->n_object; i++) {
        const struct rmap_object *object = &scene->object[i];
        box[i] = rmap_bounds_empty();
        rmap_bounds_include_geometry(&box[i], &scene->geometry[object->geometry],
                                     &object->to_world);
    }
    for (size_t i = 0; i < scene->n_object; i++) {
        uint8_t *its = &told[scene->object[i].geometry];
        if (!*its) {
            check_size(scene, box, i, diagnostics);
            RMAP_TRY(check_closed(scene, box, i, diagnostics, err));
        }
        *its = 1;
    }
out:
    rmap_free(told);
    rmap_free(box);
    return st;
}

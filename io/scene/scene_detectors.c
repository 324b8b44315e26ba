/* SPDX-License-Identifier: MIT
 *
 * Virtual detectors: planes free in space or lying on an object, and far-field grids.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_detectors.h"

#include "io/scene/scene_cameras.h"
#include "io/scene/scene_faces.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_placement.h"
#include "io/scene/scene_reader.h"
#include "io/scene/scene_reading.h"
#include "io/scene/scene_response.h"

/* What a detector lies on: an object, some faces of its mesh, or a group; and the frame and size
 * that it takes from there. */

/* The object or group that `key` of the mapping names. */
static void find_on(struct rmap_reader *reader, const struct rmap_yaml_node *node, const char *key,
                    struct rmap_detector *detector)
{
    const char *text = rmap_reader_text(reader, node, key, RMAP_REQUIRED);
    const struct rmap_yaml_node *at = rmap_yaml_get(node, key);
    if (!text)
        return;
    const struct rmap_name *name = rmap_reader_find_body(reader, "object", at, text);
    if (name && name->kind == RMAP_MEMBER_OBJECT)
        detector->on_object = name->index;
    else if (name)
        detector->on_group = name->index;
}

static void read_faces(struct rmap_reader *reader, const struct rmap_yaml_node *on,
                       struct rmap_detector *detector)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_yaml_node *faces = rmap_yaml_get(on, "faces");
    const struct rmap_mesh *mesh = NULL;
    if (detector->on_object >= 0)
        mesh = scene->geometry[scene->object[detector->on_object].geometry].mesh;
    if (!faces) {
        rmap_reader_error(reader, on, "'faces' is missing: give it, or the object's name alone");
        return;
    }
    if (!mesh || mesh->n_face == 0) {
        if (rmap_detector_lies_on(detector))
            rmap_reader_error(reader, faces, "'faces' are of an object that is a mesh");
        return;
    }
    detector->face = rmap_alloc(mesh->n_face, 1);
    if (!detector->face) {
        rmap_reader_no_memory(reader);
        return;
    }
    (void)rmap_reader_mark_faces(reader, faces, mesh, false, detector->face);
}

/* `on:` of a detector, whose list of faces is the scene's. */
static void reader_detector_on(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_detector *detector)
{
    const struct rmap_yaml_node *on = rmap_yaml_get(node, "on");
    if (on->kind != RMAP_YAML_MAP) {
        find_on(reader, node, "on", detector);
        return;
    }
    (void)rmap_reader_check_map(reader, on, "what a detector lies on", "object faces");
    find_on(reader, on, "object", detector);
    read_faces(reader, on, detector);
}

static bool has_triangle(const struct rmap_detector *detector, const struct rmap_mesh *mesh,
                         size_t t)
{
    return !detector->face || detector->face[mesh->face[t]];
}

/* Area-weighted mean normal in the world of what it lies on of a mesh, not normalised, and the
 * area. */
static struct rmap_vec3 mean_normal(const struct rmap_detector *detector,
                                    const struct rmap_mesh *mesh, const struct rmap_affine *place,
                                    double *area_ret)
{
    struct rmap_vec3 sum = {0, 0, 0};
    *area_ret = 0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3];
        if (!has_triangle(detector, mesh, t))
            continue;
        rmap_mesh_corners(mesh, t, corner);
        struct rmap_vec3 a = rmap_affine_vector(place, rmap_sub(corner[1], corner[0]));
        struct rmap_vec3 b = rmap_affine_vector(place, rmap_sub(corner[2], corner[0]));
        sum = rmap_add(sum, rmap_cross(a, b));
        *area_ret += rmap_length(rmap_cross(a, b));
    }
    return rmap_affine_determinant(place) < 0 ? rmap_scale(sum, -1) : sum;
}

/* Bounds of what it lies on of an object, in the object's frame. */
static void bounds_of(const struct rmap_scene *scene, const struct rmap_object *object,
                      const struct rmap_detector *detector, struct rmap_vec3 *lower,
                      struct rmap_vec3 *upper)
{
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    bool any = false;
    for (size_t t = 0; detector->face && t < geometry->mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3];
        if (!has_triangle(detector, geometry->mesh, t))
            continue;
        rmap_mesh_corners(geometry->mesh, t, corner);
        for (int k = 0; k < 3; k++) {
            const struct rmap_vec3 c = corner[k], l = any ? *lower : c, u = any ? *upper : c;
            *lower = rmap_vec3(fmin(l.x, c.x), fmin(l.y, c.y), fmin(l.z, c.z));
            *upper = rmap_vec3(fmax(u.x, c.x), fmax(u.y, c.y), fmax(u.z, c.z));
            any = true;
        }
    }
    if (!any)
        rmap_geometry_bounds(geometry, lower, upper);
}

static void reader_adopt_frame(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               struct rmap_detector *detector)
{
    const struct rmap_scene *scene = reader->scene;
    bool directed = rmap_yaml_get(node, "direction") != NULL;
    struct rmap_vec3 axis[3], lower, upper;
    if (detector->on_object < 0) {
        const struct rmap_affine *place = &reader->scene->group[detector->on_group].to_world;
        rmap_placement_axes(place, axis);
        detector->origin = place->t;
    } else {
        const struct rmap_object *object = &scene->object[detector->on_object];
        const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
        rmap_placement_axes(&object->to_world, axis);
        detector->origin = object->to_world.t;
        if (geometry->kind == RMAP_GEOMETRY_MESH) {
            bounds_of(scene, object, detector, &lower, &upper);
            detector->origin =
                rmap_affine_point(&object->to_world, rmap_scale(rmap_add(lower, upper), 0.5));
            double area;
            struct rmap_vec3 normal =
                mean_normal(detector, geometry->mesh, &object->to_world, &area);
            if (rmap_length(normal) > 1e-6 * area) {
                axis[2] = rmap_normalize(normal);
                rmap_placement_plane(axis[2], &axis[0], &axis[1]);
            } else if (!directed) {
                rmap_reader_error(reader, node,
                                  "the normals of mesh '%.60s' cancel: say where detector '%.60s' "
                                  "faces, with 'direction'",
                                  object->name, detector->name);
            }
        }
    }
    detector->x = axis[0];
    detector->y = axis[1];
    detector->axis = axis[2];
}

static void widen(const struct rmap_scene *scene, const struct rmap_object *object,
                  struct rmap_detector *detector)
{
    struct rmap_vec3 lower, upper;
    bounds_of(scene, object, detector, &lower, &upper);
    for (int k = 0; k < 8; k++) {
        struct rmap_vec3 corner = rmap_vec3(k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y,
                                            k & 4 ? upper.z : lower.z);
        corner = rmap_sub(rmap_affine_point(&object->to_world, corner), detector->origin);
        detector->size[0] = fmax(detector->size[0], 2 * fabs(rmap_dot(corner, detector->x)));
        detector->size[1] = fmax(detector->size[1], 2 * fabs(rmap_dot(corner, detector->y)));
    }
}

/* The frame that what it lies on suggests, and the smallest centred rectangle that covers the
 * bounds of that. node: the detector. */
static void reader_adopt_size(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              struct rmap_detector *detector)
{
    const struct rmap_scene *scene = reader->scene;
    detector->size[0] = detector->size[1] = 0;
    for (size_t i = 0; i < scene->n_object; i++)
        if (rmap_detector_lies_at(scene, detector, i))
            widen(scene, &scene->object[i], detector);
    if (!(detector->size[0] > 0 && detector->size[1] > 0))
        rmap_reader_error(reader, node,
                          "'size' is missing: what detector '%.60s' lies on has no extent in its "
                          "plane",
                          detector->name);
}

#define CELLS_PER_SIDE_MAX 65535 /* cells are stored in 16 bits */
#define CELLS_MAX          (1u << 26)

static void read_cells(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_detector *detector)
{
    const struct rmap_range range = {1, CELLS_PER_SIDE_MAX, "between 1 and 65535"};
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "cells");
    double cells[2] = {1, 1};
    size_t n = 0;
    if (!rmap_reader_numbers(reader, node, "cells", RMAP_REQUIRED, &range, 1, 2, cells, &n))
        return;
    if (n == 1)
        cells[1] = cells[0];
    if (cells[0] != floor(cells[0]) || cells[1] != floor(cells[1])) {
        rmap_reader_error(reader, at, "'cells' must be whole numbers");
        return;
    }
    if (cells[0] * cells[1] > CELLS_MAX)
        rmap_reader_error(reader, at, "%.0f x %.0f cells are too many: %u at most", cells[0],
                          cells[1], CELLS_MAX);
    detector->cells[0] = (uint32_t)cells[0];
    detector->cells[1] = (uint32_t)cells[1];
}

/* ---- frames ---- */

static void face(struct rmap_detector *detector, struct rmap_vec3 axis)
{
    detector->axis = axis;
    rmap_placement_plane(axis, &detector->x, &detector->y);
}

static void read_frame(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const char *axis_key, struct rmap_vec3 axis, bool lies_on,
                       struct rmap_detector *detector)
{
    struct rmap_affine placement;
    const struct rmap_yaml_node *rotate = rmap_yaml_get(node, "rotate");
    bool directed = rmap_yaml_get(node, axis_key) != NULL;
    bool matrix = rmap_yaml_get(node, "matrix") != NULL;
    if (rotate && directed)
        rmap_reader_error(reader, rotate, "give '%s' or 'rotate', not both", axis_key);
    if (matrix && directed && strcmp(axis_key, "axis") == 0)
        rmap_reader_error(reader, rmap_yaml_get(node, axis_key),
                          "give 'matrix' or 'axis', not both");
    face(detector, axis);
    bool good = rmap_reader_placement(reader, node, &placement);
    good &= rmap_reader_direction(reader, node, axis_key, &axis);
    if (lies_on)
        reader_adopt_frame(reader, node, detector);
    if (!good)
        return;
    if (!lies_on || rmap_yaml_get(node, "at") || matrix)
        detector->origin = placement.t;
    if (rotate || matrix) {
        struct rmap_vec3 axes[3];
        rmap_placement_axes(&placement, axes);
        detector->x = axes[0];
        detector->y = axes[1];
        detector->axis = axes[2];
    } else if (directed) {
        face(detector, axis);
    }
}

static const struct rmap_range right_angle = {
    1e-9, 90, "an angle greater than 0 and up to 90 degrees", RMAP_DIMENSION_ANGLE};
enum { CAMERA_KEYS = 2 }; /* of types below */
const struct rmap_mapping rmap_detector_keys = {
    "detectors",
    "plane intensity camera",
    {{"a plane detector",
      "name type on size cells at direction rotate matrix side max_angle response detect "
      "reading"},
     {"an intensity detector", "name type cells axis at rotate matrix response detect reading"},
     {"a camera detector", "name type at look_at direction up resolution fov sensor focal_length "
                           "focus aperture response detect reading"}},
    {{"side", RMAP_KEY_WORD, offsetof(struct rmap_detector, side), .words = "front back both"},
     {"max_angle", RMAP_KEY_ANGLE, offsetof(struct rmap_detector, max_angle_rad), &right_angle,
      90}}};

static void read_plane(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_detector *detector)
{
    size_t n = 0;
    bool lies_on = false, on = rmap_yaml_get(node, "on") != NULL;
    detector->side = on ? RMAP_SIDE_BOTH : RMAP_SIDE_FRONT;
    (void)rmap_reader_known(reader, node, &rmap_detector_keys, RMAP_DETECTOR_PLANE);
    (void)rmap_reader_fill(reader, node, &rmap_detector_keys, RMAP_DETECTOR_PLANE, detector);
    detector->type = RMAP_DETECTOR_PLANE;
    detector->size[0] = detector->size[1] = 1;
    if (on) {
        reader_detector_on(reader, node, detector);
        lies_on = rmap_detector_lies_on(detector);
    }
    read_frame(reader, node, "direction", rmap_vec3(0, 0, -1), lies_on, detector);
    if (lies_on && !rmap_yaml_get(node, "size")) {
        reader_adopt_size(reader, node, detector);
        return;
    }
    if (!on || rmap_yaml_get(node, "size"))
        (void)rmap_reader_numbers(reader, node, "size", RMAP_REQUIRED, &rmap_range_size, 1, 2,
                                  detector->size, &n);
    if (n == 1)
        detector->size[1] = detector->size[0];
}

static void read_intensity(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_detector *detector)
{
    (void)rmap_reader_known(reader, node, &rmap_detector_keys, RMAP_DETECTOR_INTENSITY);
    detector->type = RMAP_DETECTOR_INTENSITY;
    read_frame(reader, node, "axis", rmap_vec3(0, 0, 1), false, detector);
    detector->size[0] = RMAP_PI;
    detector->size[1] = 2 * RMAP_PI;
    detector->side = RMAP_SIDE_BOTH;
    detector->max_angle_rad = RMAP_PI / 2;
}

/* Keys as of a thin lens under `cameras`. */
static void read_camera(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct rmap_detector *detector)
{
    struct rmap_camera view = {
        .name = detector->name, .type = RMAP_CAMERA_THIN_LENS, .slope = 1, .aperture = 1};
    (void)rmap_reader_known(reader, node, &rmap_detector_keys, CAMERA_KEYS);
    rmap_reader_view(reader, node, true, &view);
    (void)rmap_reader_number(reader, node, "aperture", RMAP_REQUIRED, &rmap_range_positive_length,
                             &view.aperture);
    detector->type = RMAP_DETECTOR_PLANE;
    detector->side = RMAP_SIDE_FRONT;
    detector->max_angle_rad = RMAP_PI / 2;
    detector->origin = view.at;
    detector->x = view.right;
    detector->y = view.up;
    detector->axis = view.forward;
    detector->size[0] = detector->size[1] = 2 * view.aperture;
    detector->camera = (struct rmap_detector_camera){
        .radius = view.aperture,
        .focus = view.focus > 0 ? view.focus : (double)INFINITY,
        .slope = {view.slope * view.resolution[0] / view.resolution[1], view.slope},
        .pixels = {view.resolution[0], view.resolution[1]}};
}

static void read_detectors(struct rmap_reader *reader, const struct rmap_yaml_node *detectors,
                           size_t reading_receivers)
{
    struct rmap_scene *scene = reader->scene;
    if (!detectors || !rmap_reader_check_list(reader, detectors, "'detectors'"))
        return;
    for (size_t i = 0; i < detectors->n_item; i++) {
        const struct rmap_yaml_node *node = detectors->item[i].value;
        if (node->kind != RMAP_YAML_MAP) {
            rmap_reader_error(reader, node,
                              "a detector must be a mapping, as in {name: sensor, ...}");
            continue;
        }
        struct rmap_detector *detector =
            RMAP_READER_NEW(reader, scene->detector, scene->n_detector, reader->cap_detector);
        if (!detector)
            return;
        reader->n_receiver += reading_receivers;
        detector->on_object = detector->on_group = -1;
        detector->name = rmap_reader_strdup(reader, rmap_reader_name(reader, node));
        detector->line = node->line;
        detector->column = node->column;
        rmap_reader_add_member(reader, detector->name, RMAP_MEMBER_DETECTOR,
                               (int32_t)(scene->n_detector - 1), node);
        int type = rmap_reader_type(reader, node, &rmap_detector_keys);
        if (type < 0)
            continue;
        detector->cells[0] = detector->cells[1] = 1;
        if (type != CAMERA_KEYS)
            read_cells(reader, node, detector);
        rmap_reader_response(reader, node, detector);
        rmap_reader_reading(reader, node, detector);
        if (type == 0)
            read_plane(reader, node, detector);
        else if (type == CAMERA_KEYS)
            read_camera(reader, node, detector);
        else
            read_intensity(reader, node, detector);
    }
}

void rmap_reader_read_detectors(struct rmap_reader *reader)
{
    read_detectors(reader, rmap_yaml_get(reader->root, "detectors"), 0);
}

static void read_receivers(struct rmap_reader *reader)
{
    const struct rmap_yaml_node *list = reader->root; /* alone, or under `detectors` */
    if (list->kind != RMAP_YAML_LIST) {
        if (!rmap_reader_check_map(reader, list, "a file of receivers", "raymap detectors"))
            return;
        list = rmap_yaml_get(list, "detectors");
    }
    read_detectors(reader, list, 1);
    if (reader->n_receiver == 0 && reader->diagnostics->n_error == 0)
        rmap_reader_error(reader, reader->root,
                          "no receivers: list them under 'detectors', as a scene file does");
}

void rmap_reader_read_receivers(struct rmap_reader *reader)
{
    const struct rmap_yaml_node *const root = reader->root;
    struct rmap_yaml_node *theirs = NULL;
    struct rmap_diagnostics *diagnostics = reader->diagnostics;
    if (!reader->receivers)
        return;
    reader->diagnostics = reader->receivers->diagnostics;
    enum rmap_status st = rmap_yaml_parse(reader->receivers->text, reader->receivers->nbytes,
                                          &theirs, reader->diagnostics, &reader->failure);
    reader->root = theirs;
    if (st != RMAP_OK && st != RMAP_INPUT) /* INPUT: reported in the diagnostics */
        rmap_reader_fail(reader, st);
    if (st == RMAP_OK && theirs)
        read_receivers(reader);
    rmap_yaml_destroy(theirs);
    reader->root = root;
    reader->diagnostics = diagnostics;
}

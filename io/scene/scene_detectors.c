/* SPDX-License-Identifier: MIT
 *
 * Virtual detectors: planes free in space or lying on an object, and far-field grids.
 */
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_keys.h"

#define CELLS_PER_SIDE_MAX 65535 /* cells are stored in 16 bits */
#define CELLS_MAX          (1u << 26)

static void read_cells(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_detector *detector)
{
    const struct rmap_range range = {1, CELLS_PER_SIDE_MAX, "between 1 and 65535"};
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "cells");
    double cells[2] = {1, 1};
    size_t n = 0;
    detector->cells[0] = detector->cells[1] = 1;
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
        rmap_reader_adopt_frame(reader, node, detector);
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

static const struct rmap_range right_angle = {1e-9, 90,
                                              "an angle greater than 0 and up to 90 degrees"};
const struct rmap_mapping rmap_detector_keys = {
    "detectors",
    "plane intensity",
    {{"a plane detector", "name type on size cells at direction rotate matrix side max_angle"},
     {"an intensity detector", "name type cells axis at rotate matrix"}},
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
        rmap_reader_detector_on(reader, node, detector);
        lies_on = rmap_detector_lies_on(detector);
    }
    read_frame(reader, node, "direction", rmap_vec3(0, 0, -1), lies_on, detector);
    if (lies_on && !rmap_yaml_get(node, "size")) {
        rmap_reader_adopt_size(reader, node, detector);
        return;
    }
    if (!on || rmap_yaml_get(node, "size"))
        (void)rmap_reader_numbers(reader, node, "size", RMAP_REQUIRED, &rmap_range_positive, 1, 2,
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
        rmap_reader_add_member(reader, detector->name, RMAP_MEMBER_DETECTOR,
                               (int32_t)(scene->n_detector - 1), node);
        int type = rmap_reader_type(reader, node, &rmap_detector_keys);
        if (type < 0)
            continue;
        read_cells(reader, node, detector);
        if (type == 0)
            read_plane(reader, node, detector);
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
    enum rmap_status st = rmap_yaml_parse(reader->receivers->text, reader->receivers->nbytes,
                                          &reader->root, reader->diagnostics, &reader->failure);
    if (st != RMAP_OK && st != RMAP_INPUT) /* INPUT: told in the diagnostics */
        rmap_reader_fail(reader, st);
    if (st != RMAP_OK || !reader->root)
        return;
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
    struct rmap_yaml_node *root = reader->root;
    struct rmap_diagnostics *diagnostics = reader->diagnostics;
    if (!reader->receivers)
        return;
    reader->root = NULL;
    reader->diagnostics = reader->receivers->diagnostics;
    read_receivers(reader);
    rmap_yaml_destroy(reader->root);
    reader->root = root;
    reader->diagnostics = diagnostics;
}

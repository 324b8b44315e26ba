/* SPDX-License-Identifier: MIT
 *
 * Something of a scene's text goes elsewhere.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene/scene_text.h"

/* Three numbers without units; missing: none. */
static bool read_place(const struct rmap_yaml_node *node, double place[3])
{
    if (!node)
        return true;
    if (node->kind != RMAP_YAML_LIST || node->n_item != 3)
        return false;
    for (size_t i = 0; i < 3; i++) {
        const struct rmap_yaml_node *item = node->item[i].value;
        char *end = NULL;
        if (item->kind != RMAP_YAML_SCALAR || !item->text[0])
            return false;
        place[i] = strtod(item->text, &end);
        if (*end)
            return false;
    }
    return true;
}

/* A source that stands in a group, below a list of objects whose path begins `path`; NULL: none. */
static const struct rmap_yaml_node *source_in_groups(const struct rmap_yaml_node *objects,
                                                     const char *name, char *path, size_t nbytes)
{
    const struct rmap_yaml_node *found = NULL;
    const size_t used = strlen(path);
    for (size_t i = 0; objects && i < objects->n_item && !found; i++) {
        const struct rmap_yaml_node *group = objects->item[i].value;
        const struct rmap_yaml_node *sources = rmap_yaml_get(group, "sources");
        const char *rest = name;
        if (sources)
            found = rmap_yaml_find(sources, name, &rest, NULL);
        found = *rest ? NULL : found;
        if (found)
            (void)snprintf(path + used, nbytes - used, ".%zu.sources.%s", i + 1, name);
        else if (rmap_yaml_get(group, "objects") &&
                 snprintf(path + used, nbytes - used, ".%zu.objects", i + 1) < (int)(nbytes - used))
            found = source_in_groups(rmap_yaml_get(group, "objects"), name, path, nbytes);
        if (!found)
            path[used] = 0;
    }
    return found;
}

/* What has that name, and its path; NULL: nothing has. */
static const struct rmap_yaml_node *find_named(const struct rmap_yaml_node *root, const char *name,
                                               char *path, size_t nbytes)
{
    static const char *const section[] = {"objects", "sources", "detectors", "cameras"};
    for (size_t i = 0; i < sizeof section / sizeof *section; i++) {
        const char *rest = path;
        (void)snprintf(path, nbytes, "%s.%s", section[i], name);
        const struct rmap_yaml_node *node = rmap_yaml_find(root, path, &rest, NULL);
        if (!*rest)
            return node;
    }
    (void)snprintf(path, nbytes, "objects");
    return source_in_groups(rmap_yaml_get(root, "objects"), name, path, nbytes);
}

/* From the axes of the world into those of a frame, without what rounding leaves of a turn. */
static void turn_into(const struct rmap_affine *frame, double way[3])
{
    struct rmap_affine back;
    if (!rmap_affine_invert(frame, &back))
        return;
    const struct rmap_vec3 own = rmap_affine_vector(&back, rmap_vec3(way[0], way[1], way[2]));
    const double number[3] = {own.x, own.y, own.z}, least = 1e-12 * rmap_length(own);
    for (size_t i = 0; i < 3; i++)
        way[i] = fabs(number[i]) < least ? 0.0 : number[i];
}

enum rmap_status rmap_scene_text_move(struct rmap_scene_text *from, const char *name,
                                      const json_t *by, const struct rmap_affine *frame,
                                      const struct rmap_vec3 *from_place,
                                      struct rmap_scene_text *scene_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_yaml_node *node = NULL;
    double place[3] = {0.0, 0.0, 0.0}, way[3] = {0.0, 0.0, 0.0};
    char path[512];
    bool right = json_array_size(by) == 3;
    for (size_t i = 0; i < 3 && right; i++) {
        right = json_is_number(json_array_get(by, i));
        way[i] = json_number_value(json_array_get(by, i));
    }
    if (!right)
        return rmap_error_set(err, RMAP_USAGE, "'by' is a list of three numbers");
    st = rmap_scene_text_parse(from, err);
    if (st != RMAP_OK)
        return st;
    node = find_named(from->root, name, path, sizeof path - 3);
    if (!node)
        return rmap_error_set(err, RMAP_INPUT, "there is no '%s' in the scene's text", name);
    if (way[0] == 0.0 && way[1] == 0.0 && way[2] == 0.0)
        return rmap_scene_text_change(from, NULL, NULL, scene_ret, err);
    if (from_place && strncmp(path, "detectors.", 10) == 0 && !rmap_yaml_get(node, "at"))
        memcpy(place, (double[]){from_place->x, from_place->y, from_place->z}, sizeof place);
    if (!read_place(rmap_yaml_get(node, "at"), place))
        return rmap_error_set(err, RMAP_INPUT,
                              "the `at` of '%s' is not three numbers without units: change it "
                              "in the text",
                              name);
    if (frame)
        turn_into(frame, way);
    for (size_t i = 0; i < 3; i++)
        place[i] += way[i];
    (void)strcat(path, ".at");
    json_t *values = json_pack("{s:[f, f, f]}", path, place[0], place[1], place[2]);
    st = rmap_scene_text_change(from, NULL, values, scene_ret, err);
    json_decref(values);
    return st;
}

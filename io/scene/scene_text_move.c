/* SPDX-License-Identifier: MIT
 *
 * Something of a scene's text goes elsewhere.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/unit.h"
#include "io/scene/scene_text.h"
#include "io/scene/scene_values.h"

/* What is to be written for a place to be another: a whole list, or those of its items that change,
 * so that the others stay as they are written. */
struct place {
    const struct rmap_yaml_node *list; /* of `at`, or of `matrix`; NULL: it is not there */
    size_t n, first, step;             /* its numbers, and which are the place's */
    double number[12];
    const struct rmap_written_unit *unit[12], *scene_unit; /* NULL: of the scene, by `units` */
    bool whole;
};

/* false: one that counts is no length. */
static bool read_numbers(struct place *place, const double way[3])
{
    bool right =
        !place->list || (place->list->kind == RMAP_YAML_LIST && place->list->n_item == place->n);
    for (size_t i = 0; place->list && i < place->n && right; i++) {
        const struct rmap_yaml_node *item = place->list->item[i].value;
        const bool moves = i % place->step == place->first && way[i / place->step] != 0.0;
        const char *unit = "";
        if (!place->whole && !moves)
            continue;
        right = item->kind == RMAP_YAML_SCALAR &&
                rmap_reader_parse_quantity(item->text, &place->number[i], &unit);
        if (right && *unit) {
            place->unit[i] = rmap_unit_of_scene(unit, RMAP_DIMENSION_LENGTH);
            right = place->unit[i] != NULL;
        }
    }
    return right;
}

/* Number i of the place, moved; in its unit, as a text. */
static json_t *moved(const struct place *place, size_t i, double by)
{
    const struct rmap_written_unit *unit = place->unit[i];
    char text[64];
    if (!unit)
        return json_real(place->number[i] + by);
    const double number = place->number[i] + by * (place->scene_unit->size / unit->size);
    (void)snprintf(text, sizeof text, "%.15g %s", number, unit->name);
    return json_string(text);
}

/* {"objects.lens.at.3": 5}, or {"objects.lens.at": [0, 0, 5]}; path: "objects.lens.at". */
static json_t *values_of(const struct place *place, const char *path, const double way[3])
{
    json_t *values = json_object(), *list = json_array();
    char item[540];
    for (size_t i = 0; i < place->n; i++) {
        const bool counts = i % place->step == place->first;
        const double by = counts ? way[i / place->step] : 0.0;
        json_t *number = moved(place, i, by);
        (void)json_array_append(list, number);
        (void)snprintf(item, sizeof item, "%s.%zu", path, i + 1);
        if (!place->whole && by != 0.0)
            (void)json_object_set(values, item, number);
        json_decref(number);
    }
    if (place->whole)
        (void)json_object_set(values, path, list);
    json_decref(list);
    return values;
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
    if (!rmap_yaml_is_path(name, strlen(name)))
        return NULL;
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

/* Why it has no place that could be another; else RMAP_OK. */
static enum rmap_status check_has_place(const struct rmap_yaml_node *node, const char *name,
                                        const char *path, struct rmap_error *err)
{
    const struct rmap_yaml_node *fills = rmap_yaml_get(node, "fills"),
                                *type = rmap_yaml_get(node, "type");
    const bool is_source = strncmp(path, "sources.", 8) == 0 || strstr(path, ".sources.");
    if (!is_source || !type || type->kind != RMAP_YAML_SCALAR)
        return RMAP_OK;
    if (fills && fills->kind == RMAP_YAML_SCALAR)
        return rmap_error_set(
            err, RMAP_INPUT,
            "'%s' stands before '%s', which it fills, and goes with it: move that, "
            "or give it 'shape', 'at' and 'direction' instead of 'fills'",
            name, fills->text);
    if (rmap_yaml_get(node, "in") || strcmp(type->text, "sky") == 0 ||
        strcmp(type->text, "sun") == 0 || strcmp(type->text, "rays") == 0)
        return rmap_error_set(err, RMAP_INPUT,
                              "'%s' has no place of its own (type: %s): change it in the text",
                              name, type->text);
    return RMAP_OK;
}

/* There is nothing of that name; perhaps of its first words, "lens" of "lens.edge.1". */
static enum rmap_status refuse_name(const struct rmap_yaml_node *root, const char *name,
                                    struct rmap_error *err)
{
    char whole[256], path[512];
    (void)snprintf(whole, sizeof whole, "%s", name);
    for (char *dot; (dot = strrchr(whole, '.'));) {
        *dot = 0;
        if (find_named(root, whole, path, sizeof path))
            return rmap_error_set(err, RMAP_INPUT,
                                  "'%s' has its place by '%s', of which it is a part: move that",
                                  name, whole);
    }
    return rmap_error_set(err, RMAP_INPUT, "there is no '%s' in the scene's text", name);
}

/* That of lengths without one. */
static const struct rmap_written_unit *unit_of(const struct rmap_yaml_node *root)
{
    const struct rmap_yaml_node *node = rmap_yaml_get(root, "units");
    const struct rmap_written_unit *unit = NULL;
    if (node && node->kind == RMAP_YAML_SCALAR)
        unit = rmap_unit_of_scene(node->text, RMAP_DIMENSION_LENGTH);
    return unit ? unit : rmap_unit_of_scene("mm", RMAP_DIMENSION_LENGTH);
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
    const struct rmap_yaml_node *node = NULL, *in = NULL;
    double way[3] = {0.0, 0.0, 0.0};
    struct place place = {0};
    const char *rest;
    char path[512];
    bool right = json_array_size(by) == 3;
    for (size_t i = 0; i < 3 && right; i++) {
        right = json_is_number(json_array_get(by, i));
        way[i] = json_number_value(json_array_get(by, i));
    }
    if (!right)
        return rmap_error_set(err, RMAP_USAGE, "'by' is a list of three numbers");
    RMAP_TRY(rmap_scene_text_parse(from, err));
    node = find_named(from->root, name, path, sizeof path - 16);
    if (!node)
        return refuse_name(from->root, name, err);
    RMAP_TRY(check_has_place(node, name, path, err));
    if (way[0] == 0.0 && way[1] == 0.0 && way[2] == 0.0)
        return rmap_scene_text_change(from, NULL, NULL, scene_ret, err);
    if (frame)
        turn_into(frame, way);
    const char *key = rmap_yaml_get(node, "matrix") ? "matrix" : "at";
    place = strcmp(key, "at") == 0 ? (struct place){.n = 3, .step = 1}
                                   : (struct place){.n = 12, .first = 3, .step = 4};
    place.list = rmap_yaml_get(node, key);
    place.scene_unit = unit_of(from->root);
    if (from_place && strncmp(path, "detectors.", 10) == 0 && !place.list)
        memcpy(place.number, (double[]){from_place->x, from_place->y, from_place->z},
               3 * sizeof *place.number);
    (void)strcat(strcat(path, "."), key);
    place.whole = !place.list || rmap_yaml_find_shared(from->root, path, &rest, &in);
    if (!read_numbers(&place, way))
        return rmap_error_set(err, RMAP_INPUT,
                              "the `%s` of '%s' is not %zu numbers: change it in the text", key,
                              name, place.n);
    json_t *values = values_of(&place, path, way);
    st = rmap_scene_text_change(from, NULL, values, scene_ret, err);
    json_decref(values);
out:
    return st;
}

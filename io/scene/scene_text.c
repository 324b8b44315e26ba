/* SPDX-License-Identifier: MIT
 *
 * Changes of a scene's text that leave the rest of it as it is written. The tree says which node is
 * meant; libyaml's events say from where to where it stands.
 */
#include "io/scene/scene_text.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <yaml.h>

#include "base/alloc.h"
#include "io/scene/yaml_tree.h"

/* Where a node stands. */
struct span {
    size_t first, end; /* bytes; end: behind the last of its content */
    int column;        /* of the first, from 0 */
    bool flow, empty;
};

static bool is_flow(const yaml_event_t *event)
{
    return (event->type == YAML_SEQUENCE_START_EVENT &&
            event->data.sequence_start.style == YAML_FLOW_SEQUENCE_STYLE) ||
           (event->type == YAML_MAPPING_START_EVENT &&
            event->data.mapping_start.style == YAML_FLOW_MAPPING_STYLE);
}

static bool begins(const yaml_event_t *event)
{
    return event->type == YAML_SEQUENCE_START_EVENT || event->type == YAML_MAPPING_START_EVENT;
}

static bool ends(const yaml_event_t *event)
{
    return event->type == YAML_SEQUENCE_END_EVENT || event->type == YAML_MAPPING_END_EVENT;
}

/* The event at the node's place is its first. Of a block, libyaml's end is where the next thing
 * begins: its own is that of the last thing in it. */
static bool span_of(const char *text, const struct rmap_yaml_node *node, struct span *span)
{
    yaml_parser_t parser;
    yaml_event_t event;
    int depth = 0, inside = -1; /* depth at which the node begins */
    bool done = false, over = false;
    if (!yaml_parser_initialize(&parser))
        return false;
    yaml_parser_set_input_string(&parser, (const unsigned char *)text, strlen(text));
    while (!done && !over && yaml_parser_parse(&parser, &event)) {
        const yaml_mark_t at = event.start_mark, end = event.end_mark;
        const bool content = event.type == YAML_SCALAR_EVENT || event.type == YAML_ALIAS_EVENT;
        depth -= ends(&event);
        if (inside < 0 && (content || begins(&event)) && (int)at.line + 1 == node->line &&
            (int)at.column + 1 == node->column &&
            begins(&event) == (node->kind != RMAP_YAML_SCALAR)) {
            *span = (struct span){at.index, end.index, (int)at.column, is_flow(&event), true};
            inside = depth;
            done = content;
        } else if (inside >= 0 && (content || (ends(&event) && end.index > at.index))) {
            span->empty = span->empty && ends(&event);
            span->end = end.index;
        }
        done = done || (inside >= 0 && ends(&event) && depth == inside);
        depth += begins(&event);
        over = event.type == YAML_STREAM_END_EVENT;
        yaml_event_delete(&event);
    }
    yaml_parser_delete(&parser);
    return done;
}

/* libyaml counts characters, texts are bytes. */
static size_t byte_of(const char *text, size_t character)
{
    size_t at = 0;
    if (strncmp(text, "\xEF\xBB\xBF", 3) == 0)
        at = 3;
    for (; character > 0 && text[at]; character--)
        for (at++; (text[at] & 0xC0) == 0x80;)
            at++;
    return at;
}

/* Whether a text says the same in YAML without quotes. */
static bool is_plain(const char *text)
{
    static const char letters[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789";
    const size_t n = strlen(text);
    if (n == 0 || text[n - 1] == ' ' || !strchr(letters, text[0]))
        return n > 1 && (text[0] == '-' || text[0] == '.') && strchr(letters, text[1]) &&
               is_plain(text + 1);
    for (size_t i = 0; i < n; i++)
        if (!strchr(letters, text[i]) && !strchr(" _.+-/%()*^", text[i]))
            return false;
    return true;
}

static void put_number(FILE *out, double value)
{
    char text[32];
    for (int digits = 15; digits <= 17; digits++) {
        (void)snprintf(text, sizeof text, "%.*g", digits, value);
        if (strtod(text, NULL) == value)
            break;
    }
    fputs(text, out);
}

static void put_value(FILE *out, const json_t *value)
{
    const char *key;
    json_t *item;
    size_t i = 0;
    if (json_is_real(value)) {
        put_number(out, json_real_value(value));
    } else if (json_is_string(value) && is_plain(json_string_value(value))) {
        fputs(json_string_value(value), out);
    } else if (json_is_array(value)) {
        for (fputc('[', out); i < json_array_size(value); i++) {
            fputs(i ? ", " : "", out);
            put_value(out, json_array_get(value, i));
        }
        fputc(']', out);
    } else if (json_is_object(value)) {
        fputc('{', out);
        json_object_foreach((json_t *)(uintptr_t)value, key, item)
        {
            fprintf(out, "%s", i++ ? ", " : "");
            json_t *name = json_string(key);
            put_value(out, name);
            json_decref(name);
            fputs(": ", out);
            put_value(out, item);
        }
        fputc('}', out);
    } else {
        (void)json_dumpf(value, out, JSON_ENCODE_ANY | JSON_COMPACT);
    }
}

/* "a.b" and a value: "a: {b: value}". */
static void put_path(FILE *out, const char *path, const json_t *value)
{
    size_t depth = 0;
    for (const char *dot; (dot = strchr(path, '.')); path = dot + 1, depth++)
        fprintf(out, "%.*s: {", (int)(dot - path), path);
    fprintf(out, "%s: ", path);
    put_value(out, value);
    while (depth-- > 0)
        fputc('}', out);
}

/* Writes the text with the node's value, or with a key more in it. */
static void put_changed(FILE *out, const char *text, const struct span *span, const char *rest,
                        const json_t *value)
{
    const size_t first = byte_of(text, span->first), end = byte_of(text, span->end);
    if (!*rest) {
        fprintf(out, "%.*s%s", (int)first, text, first == end ? " " : "");
        put_value(out, value);
        fputs(text + end, out);
    } else if (span->flow) { /* before its bracket */
        fprintf(out, "%.*s%s", (int)(end - 1), text, span->empty ? "" : ", ");
        put_path(out, rest, value);
        fputs(text + end - 1, out);
    } else {
        fprintf(out, "%.*s", (int)first, text);
        put_path(out, rest, value);
        fprintf(out, "\n%*s%s", span->column, "", text + first);
    }
}

static enum rmap_status parse(const char *text, struct rmap_yaml_node **root,
                              struct rmap_error *err)
{
    struct rmap_diagnostics found;
    rmap_diagnostics_init(&found, "scene");
    enum rmap_status st = rmap_yaml_parse(text, strlen(text), root, &found, err);
    if (st == RMAP_INPUT)
        (void)rmap_error_set(err, st, "%s", found.n ? found.item[0].text : "the text is no YAML");
    rmap_diagnostics_fini(&found);
    return st;
}

static enum rmap_status set_one(const char *text, const char *path, const json_t *value,
                                char **text_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_yaml_node *root = NULL;
    const char *rest = path;
    struct span span = {0};
    char *written = NULL;
    size_t n = 0;
    FILE *out = NULL;
    RMAP_TRY(parse(text, &root, err));
    const struct rmap_yaml_node *node = rmap_yaml_find(root, path, &rest);
    if (!*path || (*rest && node->kind != RMAP_YAML_MAP) || !span_of(text, node, &span))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "'%s' leads nowhere in the scene: no '%s' (items of a list: by "
                                "name, or by number from 1)",
                                path, rest));
    out = open_memstream(&written, &n);
    if (out) {
        put_changed(out, text, &span, rest, value);
        if (fclose(out) == 0)
            *text_ret = rmap_strdup(written);
    }
    if (!*text_ret)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene's text");
out:
    free(written);
    rmap_yaml_destroy(root);
    return st;
}

enum rmap_status rmap_scene_text_set(const char *text, const json_t *values, char **text_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char *now = rmap_strdup(text);
    const char *path;
    json_t *value;
    if (!now)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene's text");
    json_object_foreach((json_t *)(uintptr_t)values, path, value)
    {
        char *next = NULL;
        st = set_one(now, path, value, &next, err);
        if (st != RMAP_OK)
            break;
        rmap_free(now);
        now = next;
    }
    if (st == RMAP_OK)
        *text_ret = now;
    else
        rmap_free(now);
    return st;
}

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

/* The section that has something of that name; NULL: none. */
static const char *section_of(const struct rmap_yaml_node *root, const char *name, char *path,
                              size_t nbytes, const struct rmap_yaml_node **node_ret)
{
    static const char *const section[] = {"objects", "sources", "detectors", "cameras"};
    for (size_t i = 0; i < sizeof section / sizeof *section; i++) {
        const char *rest = path;
        (void)snprintf(path, nbytes, "%s.%s", section[i], name);
        *node_ret = rmap_yaml_find(root, path, &rest);
        if (!*rest)
            return section[i];
    }
    return NULL;
}

enum rmap_status rmap_scene_text_move(const char *text, const char *name, const json_t *by,
                                      char **text_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_yaml_node *root = NULL;
    const struct rmap_yaml_node *node = NULL;
    double place[3] = {0.0, 0.0, 0.0};
    char path[512];
    json_t *values = NULL;
    bool right = json_array_size(by) == 3;
    for (size_t i = 0; i < 3 && right; i++)
        right = json_is_number(json_array_get(by, i));
    if (!right)
        return rmap_error_set(err, RMAP_USAGE, "'by' is a list of three numbers");
    RMAP_TRY(parse(text, &root, err));
    if (!section_of(root, name, path, sizeof path - 3, &node))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "there is no '%s' in the scene's text", name));
    if (!read_place(rmap_yaml_get(node, "at"), place))
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "the `at` of '%s' is not three numbers without units: change it "
                                "in the text",
                                name));
    for (size_t i = 0; i < 3; i++)
        place[i] += json_number_value(json_array_get(by, i));
    (void)strcat(path, ".at");
    values = json_pack("{s:[f, f, f]}", path, place[0], place[1], place[2]);
    st = rmap_scene_text_set(text, values, text_ret, err);
out:
    json_decref(values);
    rmap_yaml_destroy(root);
    return st;
}

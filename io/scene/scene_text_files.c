/* SPDX-License-Identifier: MIT
 *
 * Names of files in a scene's text, which are relative to its folder, for another folder.
 */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/file/publish.h"
#include "io/scene/scene_include.h"
#include "io/scene/scene_text.h"
#include "io/scene/yaml_span.h"
#include "io/scene/yaml_write.h"

struct name {
    const struct rmap_yaml_node *node;
    char *led; /* rmap_free */
    size_t first, end;
};

struct names {
    const char *text, *way;
    const struct rmap_yaml_node *root;
    struct name *name; /* [n]; of an anchor as often as it is taken */
    size_t n, cap;
    struct rmap_error *err;
};

/* The way, and the name behind it: of "parts/" and "../a.stl" "a.stl". */
static char *lead(const char *way, const char *name)
{
    size_t n = strlen(way);
    for (; strncmp(name, "./", 2) == 0; name += 2)
        continue;
    while (n > 0 && strncmp(name, "../", 3) == 0 &&
           (n < 3 || strncmp(way + n - 3, "../", 3) != 0)) {
        for (n--; n > 0 && way[n - 1] != '/'; n--)
            continue;
        name += 3;
    }
    return rmap_path_format("%.*s%s", (int)n, way, name);
}

static enum rmap_status refuse(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_INPUT,
                          "the names of files in the scene cannot be those of another folder: save "
                          "it in its own");
}

static enum rmap_status note(struct names *names, const struct rmap_yaml_node *node)
{
    struct rmap_yaml_span span = {0};
    if (node->kind != RMAP_YAML_SCALAR || !node->text[0] || node->text[0] == '/')
        return RMAP_OK;
    if (!rmap_yaml_span(names->text, names->root, node->line, node->column, true, 1, &span))
        return refuse(names->err);
    const enum rmap_status st = RMAP_RESERVE(names->name, names->cap, names->n + 1, names->err);
    if (st != RMAP_OK)
        return st;
    if (names->text[span.first] == '&') /* the anchor stays */
        span.first += strcspn(names->text + span.first, " \t\r\n");
    span.first += strspn(names->text + span.first, " \t\r\n");
    char *led = lead(names->way, node->text);
    if (!led)
        return rmap_error_set(names->err, RMAP_SYSTEM, "out of memory for a file's name");
    names->name[names->n++] = (struct name){node, led, span.first, span.end};
    return RMAP_OK;
}

/* What the keys of a mapping are. */
enum keys { WORDS, NAMES, OF_DISTRIBUTION, PATHS };

static enum keys keys_below(enum keys keys, const char *key, size_t n)
{
    static const char *const of_names[] = {"media",   "films",     "surfaces", "geometries",
                                           "species", "constants", "match"};
    bool is = rmap_yaml_has_named(key, n);
    for (size_t i = 0; i < RMAP_COUNT(of_names); i++)
        is = is || (strlen(of_names[i]) == n && memcmp(of_names[i], key, n) == 0);
    if (keys == NAMES)
        return WORDS;
    if (n == 3 && memcmp(key, "set", n) == 0)
        return PATHS;
    return n == 12 && memcmp(key, "distribution", n) == 0 ? OF_DISTRIBUTION : is ? NAMES : WORDS;
}

/* "file", "table" of an angular distribution, and "geometries.body.file" of what a simulation
 * sets; of names of the scene's own none. */
static enum rmap_status note_all(struct names *names, const struct rmap_yaml_node *node,
                                 enum keys keys)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < node->n_item && st == RMAP_OK; i++) {
        const char *key = node->item[i].key ? node->item[i].key : "";
        enum keys its = keys == PATHS ? WORDS : keys;
        for (size_t n; keys == PATHS && key[n = strcspn(key, ".")]; key += n + 1)
            its = keys_below(its, key, n);
        if (its != NAMES &&
            (strcmp(key, "file") == 0 || (its == OF_DISTRIBUTION && strcmp(key, "table") == 0)))
            st = note(names, node->item[i].value);
        if (st == RMAP_OK)
            st = note_all(names, node->item[i].value, keys_below(its, key, strlen(key)));
    }
    return st;
}

/* Included files that stand elsewhere; the others go with the scene. */
static enum rmap_status note_included(struct names *names)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_yaml_node *list = rmap_yaml_get(names->root, "include");
    if (list && list->kind == RMAP_YAML_SCALAR && rmap_include_stands_elsewhere(list->text))
        st = note(names, list);
    for (size_t i = 0; list && i < list->n_item && st == RMAP_OK; i++)
        if (list->item[i].value->kind == RMAP_YAML_SCALAR &&
            rmap_include_stands_elsewhere(list->item[i].value->text))
            st = note(names, list->item[i].value);
    return st;
}

static int compare(const void *a, const void *b)
{
    const struct name *left = a, *right = b;
    return left->first < right->first ? -1 : left->first > right->first;
}

/* Whether the second tree is the first with other names. *at: of which one comes next. */
static bool is_led(const struct names *names, const struct rmap_yaml_node *a,
                   const struct rmap_yaml_node *b, size_t *at)
{
    bool same = a->kind == b->kind && a->n_item == b->n_item;
    if (same && a->kind == RMAP_YAML_SCALAR && strcmp(a->text, b->text) != 0) {
        size_t n = 0;
        for (; n < names->n && names->name[*at % names->n].node != a; n++)
            ++*at;
        return n < names->n && strcmp(names->name[*at % names->n].led, b->text) == 0;
    }
    for (size_t i = 0; same && i < a->n_item; i++)
        same = (!a->item[i].key || strcmp(a->item[i].key, b->item[i].key) == 0) &&
               is_led(names, a->item[i].value, b->item[i].value, at);
    return same;
}

static void put_all(FILE *out, const struct names *names)
{
    size_t from = 0;
    for (size_t i = 0; i < names->n; i++) {
        const struct name *name = &names->name[i];
        if (name->first < from)
            continue;
        (void)fwrite(names->text + from, 1, name->first - from, out);
        json_t *value = json_string(name->led);
        rmap_yaml_write_value(out, value);
        json_decref(value);
        from = name->end;
    }
    fputs(names->text + from, out);
}

enum rmap_status rmap_scene_text_lead(const char *text, const char *way, char **text_ret,
                                      struct rmap_error *err)
{
    struct rmap_scene_text scene = {.text = (char *)(uintptr_t)text}, led = {0};
    struct names names = {.text = text, .way = way, .err = err};
    char *written = NULL;
    size_t n = 0, at = 0;
    FILE *out = NULL;
    enum rmap_status st = rmap_scene_text_parse(&scene, err);
    RMAP_TRY(st);
    names.root = scene.root;
    RMAP_TRY(note_all(&names, names.root, WORDS));
    RMAP_TRY(note_included(&names));
    if (names.n > 0)
        qsort(names.name, names.n, sizeof *names.name, compare);
    out = open_memstream(&written, &n);
    if (out)
        put_all(out, &names);
    if (out && fclose(out) == 0)
        led.text = rmap_strdup(written);
    if (!led.text)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene's text"));
    st = rmap_scene_text_parse(&led, err);
    if (st == RMAP_INPUT || (st == RMAP_OK && !is_led(&names, scene.root, led.root, &at)))
        st = refuse(err);
    RMAP_TRY(st);
    *text_ret = led.text;
    led.text = NULL;
out:
    free(written);
    for (size_t i = 0; i < names.n; i++)
        rmap_free(names.name[i].led);
    rmap_free(names.name);
    rmap_scene_text_fini(&led);
    rmap_yaml_destroy(scene.root);
    return st;
}

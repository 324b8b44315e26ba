/* SPDX-License-Identifier: MIT
 *
 * Names of files in a scene's text, which are relative to its folder, for another folder.
 */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_include.h"
#include "io/scene/scene_text.h"
#include "io/scene/yaml_span.h"
#include "io/scene/yaml_write.h"

struct name {
    const char *says;
    size_t first, end;
};

struct names {
    const char *text;
    const struct rmap_yaml_node *root;
    struct name *name; /* [n]; of an anchor as often as it is taken */
    size_t n, cap;
    struct rmap_error *err;
};

static enum rmap_status note(struct names *names, const struct rmap_yaml_node *name)
{
    struct rmap_yaml_span span = {0};
    if (name->kind != RMAP_YAML_SCALAR || !name->text[0] || name->text[0] == '/' ||
        !rmap_yaml_span(names->text, names->root, name->line, name->column, true, 1, &span))
        return RMAP_OK;
    const enum rmap_status st = RMAP_RESERVE(names->name, names->cap, names->n + 1, names->err);
    if (st != RMAP_OK)
        return st;
    if (names->text[span.first] == '&') /* the anchor stays */
        span.first += strcspn(names->text + span.first, " \t\r\n");
    span.first += strspn(names->text + span.first, " \t\r\n");
    names->name[names->n++] = (struct name){name->text, span.first, span.end};
    return RMAP_OK;
}

/* "file", "table" of an angular distribution, and "geometries.body.file" of what a simulation sets.
 */
static bool names_file(const char *key)
{
    const char *dot = strrchr(key, '.'), *last = dot ? dot + 1 : key;
    return strcmp(last, "file") == 0 || strcmp(last, "table") == 0;
}

static enum rmap_status note_all(struct names *names, const struct rmap_yaml_node *node)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < node->n_item && st == RMAP_OK; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        st = item->key && names_file(item->key) ? note(names, item->value) : RMAP_OK;
        if (st == RMAP_OK)
            st = note_all(names, item->value);
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

/* The way, and the name behind it: of "parts/" and "../a.stl" "a.stl". */
static void put_name(FILE *out, const char *way, const char *name)
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
    char *whole = rmap_alloc(n + strlen(name) + 1, 1);
    if (whole) {
        (void)snprintf(whole, n + strlen(name) + 1, "%.*s%s", (int)n, way, name);
        json_t *value = json_string(whole);
        rmap_yaml_write_value(out, value);
        json_decref(value);
    }
    rmap_free(whole);
}

static int compare(const void *a, const void *b)
{
    const struct name *left = a, *right = b;
    return left->first < right->first ? -1 : left->first > right->first;
}

enum rmap_status rmap_scene_text_lead(const char *text, const char *way, char **text_ret,
                                      struct rmap_error *err)
{
    struct rmap_scene_text scene = {.text = (char *)(uintptr_t)text};
    struct names names = {.text = text, .err = err};
    char *written = NULL;
    size_t n = 0, from = 0;
    FILE *out = NULL;
    enum rmap_status st = rmap_scene_text_parse(&scene, err);
    RMAP_TRY(st);
    names.root = scene.root;
    RMAP_TRY(note_all(&names, names.root));
    RMAP_TRY(note_included(&names));
    if (names.n > 0)
        qsort(names.name, names.n, sizeof *names.name, compare);
    out = open_memstream(&written, &n);
    for (size_t i = 0; out && i < names.n; i++) {
        const struct name *name = &names.name[i];
        if (name->first < from)
            continue;
        (void)fwrite(text + from, 1, name->first - from, out);
        put_name(out, way, name->says);
        from = name->end;
    }
    if (out)
        fputs(text + from, out);
    if (out && fclose(out) == 0)
        *text_ret = rmap_strdup(written);
    if (!*text_ret)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene's text");
out:
    free(written);
    rmap_free(names.name);
    rmap_yaml_destroy(scene.root);
    return st;
}

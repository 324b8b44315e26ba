/* SPDX-License-Identifier: MIT
 *
 * `--set key.path=value`, and `set:` of a simulation: edits of a YAML tree before it is read as a
 * scene.
 */
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/yaml_tree.h"

struct edit {
    const char *option, *assignment; /* for messages */
    int line, column;                /* of what it adds */
    struct rmap_diagnostics *diagnostics;
    struct rmap_error *err;
};

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory while applying --set");
}

/* A mistake; of the command line, which has no place in the file, or of a line there. */
static void RMAP_PRINTF(2, 3) complain(struct edit *e, const char *format, ...)
{
    char text[400];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    rmap_diagnostics_add(e->diagnostics, RMAP_SEVERITY_ERROR, e->line > 0 ? e->line : 0,
                         e->line > 0 ? e->column : 0, "%s %.100s: %s", e->option, e->assignment,
                         text);
}

/* Length of `key` if the path begins with it as a whole component, else 0. Keys may contain dots
 * themselves, so the path is matched against them rather than split. */
static size_t match(const char *path, const char *key)
{
    size_t len = key ? strlen(key) : 0;
    if (!len || strncmp(path, key, len) != 0 || (path[len] && path[len] != '.'))
        return 0;
    return len;
}

static const char *item_name(const struct rmap_yaml_item *item)
{
    if (item->key)
        return item->key;
    const struct rmap_yaml_node *name = rmap_yaml_get(item->value, "name");
    return name && name->kind == RMAP_YAML_SCALAR ? name->text : NULL;
}

/* Number from 1 at the head of a path; 0 when there is none. */
static size_t match_number(const char *path, size_t n_item, size_t *len_ret)
{
    size_t len = strspn(path, "0123456789"), number = 0;
    if (!len || len > 9 || (path[len] && path[len] != '.'))
        return 0;
    for (size_t i = 0; i < len; i++)
        number = 10 * number + (size_t)(path[i] - '0');
    *len_ret = len;
    return number <= n_item ? number : 0;
}

/* The item that the head of the path addresses: the longest matching name; then, in a list, a
 * number; then a name inside the groups of a list. */
static struct rmap_yaml_item *find(const struct rmap_yaml_node *node, const char *path,
                                   size_t *len_ret)
{
    struct rmap_yaml_item *found = NULL;
    *len_ret = 0;
    for (size_t i = 0; i < node->n_item; i++) {
        size_t len = match(path, item_name(&node->item[i]));
        if (len > *len_ret) {
            *len_ret = len;
            found = &node->item[i];
        }
    }
    if (found || node->kind != RMAP_YAML_LIST)
        return found;
    size_t number = match_number(path, node->n_item, len_ret);
    if (number)
        return &node->item[number - 1];
    for (size_t i = 0; i < node->n_item && !found; i++) {
        struct rmap_yaml_node *members = rmap_yaml_get(node->item[i].value, "objects");
        if (members && members->kind == RMAP_YAML_LIST)
            found = find(members, path, len_ret);
    }
    return found;
}

static void set_place(struct rmap_yaml_node *node, int line)
{
    node->line = line;
    node->column = 0;
    for (size_t i = 0; i < node->n_item; i++) {
        node->item[i].line = line;
        node->item[i].column = 0;
        set_place(node->item[i].value, line);
    }
}

static void first_word(const char *path, char word[80])
{
    size_t len = strcspn(path, ".");
    if (len > 79)
        len = 79;
    memcpy(word, path, len);
    word[len] = 0;
}

const char *rmap_yaml_nearest(const struct rmap_yaml_node *node, const char *path)
{
    enum { SHOWN = 64 };
    const char *name[SHOWN];
    size_t n = 0;
    char word[80];
    for (size_t i = 0; i < node->n_item && n < SHOWN; i++)
        name[n++] = item_name(&node->item[i]);
    first_word(path, word);
    return rmap_nearest_word(word, name, n);
}

const struct rmap_yaml_node *rmap_yaml_find(const struct rmap_yaml_node *root, const char *path,
                                            const char **rest_ret,
                                            const struct rmap_yaml_item **item_ret)
{
    for (;;) {
        size_t len = 0;
        const struct rmap_yaml_item *item = find(root, path, &len);
        *rest_ret = item ? path + len + (path[len] == '.') : path;
        if (item && item_ret)
            *item_ret = item;
        if (!item || !path[len])
            return item ? item->value : root;
        path = *rest_ret;
        root = item->value;
    }
}

const struct rmap_yaml_item *rmap_yaml_find_shared(const struct rmap_yaml_node *root,
                                                   const char *path, const char **rest_ret,
                                                   const struct rmap_yaml_node **in_ret)
{
    size_t len = 0;
    for (const struct rmap_yaml_item *item; (item = find(root, path, &len)); root = item->value) {
        *in_ret = root;
        *rest_ret = path + len + (path[len] == '.');
        if (item->value->aliased || item->value->merged)
            return item;
        if (!path[len])
            return NULL;
        path = *rest_ret;
    }
    return NULL;
}

static void complain_unknown(struct edit *e, const struct rmap_yaml_node *list, const char *path)
{
    char word[80];
    const char *nearest = rmap_yaml_nearest(list, path);
    first_word(path, word);
    complain(e, "no item named '%s'%s%s%s (items of a list: by name, or by number from 1)", word,
             nearest ? " (did you mean '" : "", nearest ? nearest : "", nearest ? "'?)" : "");
}

/* Adds the missing rest of a path to a mapping, a mapping per component. */
static enum rmap_status add_path(struct edit *e, struct rmap_yaml_node *map, const char *path,
                                 struct rmap_yaml_node *value)
{
    enum rmap_status st = RMAP_OK;
    size_t len = strcspn(path, ".");
    struct rmap_yaml_node *inner =
        path[len] ? rmap_yaml_new(map, RMAP_YAML_MAP, e->line, 0) : value;
    char *key = rmap_alloc(len + 1, 1);
    if (!key || !inner)
        RMAP_TRY(no_memory(e->err));
    memcpy(key, path, len);
    RMAP_TRY(rmap_yaml_append(map, key, e->line, 0, inner, e->err));
    if (path[len])
        st = add_path(e, inner, path + len + 1, value);
out:
    rmap_free(key);
    return st;
}

/* A copy of the value. */
static enum rmap_status put(struct edit *e, struct rmap_yaml_node *node, const char *path,
                            const struct rmap_yaml_node *from)
{
    struct rmap_yaml_node *value = NULL;
    const enum rmap_status st = rmap_yaml_copy(node, from, &value, e->err);
    if (st != RMAP_OK)
        return st;
    for (;;) {
        size_t len = 0;
        struct rmap_yaml_item *item = find(node, path, &len);
        if (!item && node->kind == RMAP_YAML_MAP)
            return add_path(e, node, path, value);
        if (!item) {
            complain_unknown(e, node, path);
            return RMAP_OK;
        }
        if (!path[len]) {
            item->value = value;
            return RMAP_OK;
        }
        path += len + 1;
        node = item->value;
        bool nothing = node->kind == RMAP_YAML_SCALAR && !node->text[0];
        if (nothing)
            node->kind = RMAP_YAML_MAP;
    }
}

bool rmap_yaml_is_path(const char *path, size_t n)
{
    size_t dots = 0;
    bool broken = n == 0 || path[0] == '.';
    for (size_t i = 0; i < n; i++) {
        const bool dot = path[i] == '.';
        dots += dot;
        broken |= dot && (i + 1 == n || path[i + 1] == '.');
    }
    return !broken && dots < RMAP_YAML_DEPTH_MAX;
}

/* Whether `path` of n letters is one; else it is told. */
static bool check_path(struct edit *e, const char *path, size_t n)
{
    if (!rmap_yaml_is_path(path, n))
        complain(e, "write key.path%svalue", e->option[0] == '-' ? "=" : ": ");
    else if (n >= 7 && strncmp(path, "include", 7) == 0 && (n == 7 || path[7] == '.'))
        complain(e, "files are included before anything is set: write 'include' in a scene file%s",
                 "");
    else
        return true;
    return false;
}

enum rmap_status rmap_yaml_edit(struct rmap_yaml_node *root, const char *assignment, int line,
                                struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct edit e = {"--set", assignment, line, 0, diagnostics, err};
    struct rmap_yaml_node *value = NULL;
    struct rmap_diagnostics inner = {0};
    char *path = NULL;
    const char *equals = strchr(assignment, '=');
    const size_t len = equals ? (size_t)(equals - assignment) : 0;
    if (!check_path(&e, assignment, len))
        return RMAP_OK;
    path = rmap_alloc(len + 1, 1);
    if (!path)
        return no_memory(err);
    memcpy(path, assignment, len);
    st = rmap_yaml_parse(equals + 1, strlen(equals + 1), &value, &inner, err);
    if (st == RMAP_INPUT || (st == RMAP_OK && inner.n_error)) {
        complain(&e, "the value is not YAML: %s", inner.n ? inner.item[0].text : "unreadable");
        st = RMAP_OK;
        goto out;
    }
    if (st != RMAP_OK)
        goto out;
    set_place(value, line);
    st = put(&e, root, path, value);
out:
    rmap_yaml_destroy(value);
    rmap_diagnostics_fini(&inner);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_yaml_put(struct rmap_yaml_node *root, const struct rmap_yaml_item *assignment,
                               struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    struct edit e = {"set:", assignment->key, assignment->line, assignment->column, diagnostics,
                     err};
    const size_t n = strlen(assignment->key);
    if (!check_path(&e, assignment->key, n))
        return RMAP_OK;
    if (strncmp(assignment->key, "simulations", 11) == 0) {
        complain(&e, "a simulation does not change simulations%s", "");
        return RMAP_OK;
    }
    return put(&e, root, assignment->key, assignment->value);
}

/* SPDX-License-Identifier: MIT
 *
 * Nodes of a YAML tree: made, copied, looked up, taken out.
 */
#include "io/scene/yaml_tree.h"

#include <string.h>

#include "base/alloc.h"

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a YAML tree");
}

void rmap_yaml_destroy(struct rmap_yaml_node *root)
{
    struct rmap_pool *pool = root ? root->pool : NULL;
    if (pool)
        rmap_pool_fini(pool);
    rmap_free(pool);
}

static struct rmap_yaml_node *new_node(struct rmap_pool *pool, enum rmap_yaml_kind kind, int line,
                                       int column)
{
    struct rmap_yaml_node *node = rmap_pool_alloc(pool, 1, sizeof *node);
    if (node)
        *node = (struct rmap_yaml_node){.kind = kind, .line = line, .column = column, .pool = pool};
    return node;
}

struct rmap_yaml_node *rmap_yaml_create(void)
{
    struct rmap_pool *pool = rmap_alloc(1, sizeof *pool);
    struct rmap_yaml_node *node = pool ? new_node(pool, RMAP_YAML_SCALAR, 0, 0) : NULL;
    if (!node)
        rmap_free(pool);
    return node;
}

struct rmap_yaml_node *rmap_yaml_new(const struct rmap_yaml_node *in, enum rmap_yaml_kind kind,
                                     int line, int column)
{
    return new_node(in->pool, kind, line, column);
}

enum rmap_status rmap_yaml_append(struct rmap_yaml_node *node, const char *key, int line,
                                  int column, struct rmap_yaml_node *value, struct rmap_error *err)
{
    char *copy = rmap_pool_strdup(node->pool, key);
    if (key && !copy)
        return no_memory(err);
    if (node->n_item == node->cap_item) {
        const size_t cap = node->cap_item ? 2 * node->cap_item : 4;
        struct rmap_yaml_item *grown = rmap_pool_alloc(node->pool, cap, sizeof *grown);
        if (!grown)
            return no_memory(err);
        if (node->n_item > 0)
            memcpy(grown, node->item, node->n_item * sizeof *grown);
        node->item = grown;
        node->cap_item = cap;
    }
    node->item[node->n_item++] =
        (struct rmap_yaml_item){.key = copy, .line = line, .column = column, .value = value};
    return RMAP_OK;
}

static enum rmap_status copy_node(struct rmap_pool *pool, const struct rmap_yaml_node *from,
                                  int depth, size_t *n_left, struct rmap_yaml_node **node_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (*n_left == 0)
        return rmap_error_set(err, RMAP_INPUT, "this alias expands to too much");
    --*n_left;
    if (depth > RMAP_YAML_DEPTH_MAX)
        return rmap_error_set(err, RMAP_INPUT, RMAP_YAML_TOO_DEEP);
    struct rmap_yaml_node *node = new_node(pool, from->kind, from->line, from->column);
    if (!node)
        return no_memory(err);
    node->quoted = from->quoted;
    node->aliased = from->aliased;
    node->merged = from->merged;
    node->text = rmap_pool_strdup(pool, from->text);
    if (from->n_item > 0)
        node->item = rmap_pool_alloc(pool, from->n_item, sizeof *node->item);
    if ((from->text && !node->text) || (from->n_item > 0 && !node->item))
        return no_memory(err);
    node->cap_item = from->n_item;
    for (size_t i = 0; i < from->n_item && st == RMAP_OK; i++) {
        const struct rmap_yaml_item *item = &from->item[i];
        struct rmap_yaml_node *value = NULL;
        st = copy_node(pool, item->value, depth + 1, n_left, &value, err);
        if (st == RMAP_OK)
            st = rmap_yaml_append(node, item->key, item->line, item->column, value, err);
    }
    *node_ret = node;
    return st;
}

enum rmap_status rmap_yaml_copy_some(const struct rmap_yaml_node *in,
                                     const struct rmap_yaml_node *from, int depth, size_t *n_left,
                                     struct rmap_yaml_node **node_ret, struct rmap_error *err)
{
    return copy_node(in->pool, from, depth, n_left, node_ret, err);
}

enum rmap_status rmap_yaml_copy(const struct rmap_yaml_node *in, const struct rmap_yaml_node *from,
                                struct rmap_yaml_node **node_ret, struct rmap_error *err)
{
    size_t n_left = RMAP_YAML_COPY_MAX;
    return copy_node(in->pool, from, 0, &n_left, node_ret, err);
}

enum rmap_status rmap_yaml_duplicate(const struct rmap_yaml_node *root,
                                     struct rmap_yaml_node **root_ret, struct rmap_error *err)
{
    size_t n_left = SIZE_MAX;
    struct rmap_pool *pool = rmap_alloc(1, sizeof *pool);
    if (!pool)
        return no_memory(err);
    const enum rmap_status st = copy_node(pool, root, 0, &n_left, root_ret, err);
    if (st != RMAP_OK) {
        rmap_pool_fini(pool);
        rmap_free(pool);
    }
    return st;
}

void rmap_yaml_remove(struct rmap_yaml_node *node, size_t index)
{
    node->n_item--;
    memmove(&node->item[index], &node->item[index + 1],
            (node->n_item - index) * sizeof *node->item);
}

bool rmap_yaml_is_nothing(const struct rmap_yaml_node *node)
{
    return node->kind == RMAP_YAML_SCALAR && !node->quoted &&
           (!node->text[0] || strcmp(node->text, "~") == 0 || strcmp(node->text, "null") == 0);
}

struct rmap_yaml_node *rmap_yaml_get(const struct rmap_yaml_node *node, const char *key)
{
    if (!node || node->kind != RMAP_YAML_MAP)
        return NULL;
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        if (item->key[0] == key[0] && strcmp(item->key, key) == 0)
            return rmap_yaml_is_nothing(item->value) ? NULL : item->value;
    }
    return NULL;
}

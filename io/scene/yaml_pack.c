/* SPDX-License-Identifier: MIT
 *
 * A YAML tree as bytes. A node: what it is, its line and column, then its text, or how many items
 * and these: a mapping's with their keys, line and column of each, and its value. Numbers have
 * seven bits a byte, the lowest first; texts end with a 0.
 */
#include "io/scene/yaml_pack.h"

#include <limits.h>
#include <string.h>

#include "base/alloc.h"

enum { KIND = 3, QUOTED = 4 }; /* bits of the first byte */

/* ---- bytes out ---- */

struct sink {
    uint8_t *bytes;
    size_t n, cap;
    struct rmap_error *err;
};

static enum rmap_status put(struct sink *out, const void *bytes, size_t n)
{
    const enum rmap_status st = RMAP_RESERVE(out->bytes, out->cap, out->n + n, out->err);
    if (st == RMAP_OK)
        memcpy(out->bytes + out->n, bytes, n);
    out->n += st == RMAP_OK ? n : 0;
    return st;
}

static enum rmap_status put_number(struct sink *out, size_t value)
{
    uint8_t byte[10];
    size_t n = 0;
    for (; value >= 0x80; value >>= 7)
        byte[n++] = (uint8_t)(value | 0x80);
    byte[n++] = (uint8_t)value;
    return put(out, byte, n);
}

static enum rmap_status put_node(struct sink *out, const struct rmap_yaml_node *node)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(put_number(out, (size_t)node->kind | (node->quoted ? QUOTED : 0)));
    RMAP_TRY(put_number(out, (size_t)node->line));
    RMAP_TRY(put_number(out, (size_t)node->column));
    if (node->kind == RMAP_YAML_SCALAR)
        return put(out, node->text, strlen(node->text) + 1);
    RMAP_TRY(put_number(out, node->n_item));
    for (size_t i = 0; i < node->n_item; i++) {
        const struct rmap_yaml_item *item = &node->item[i];
        if (node->kind == RMAP_YAML_MAP)
            RMAP_TRY(put(out, item->key, strlen(item->key) + 1));
        RMAP_TRY(put_number(out, (size_t)item->line));
        RMAP_TRY(put_number(out, (size_t)item->column));
        RMAP_TRY(put_node(out, item->value));
    }
out:
    return st;
}

enum rmap_status rmap_yaml_pack(const struct rmap_yaml_node *root, uint8_t **bytes_ret,
                                size_t *nbytes_ret, struct rmap_error *err)
{
    struct sink out = {.err = err};
    const enum rmap_status st = put_node(&out, root);
    if (st != RMAP_OK) {
        rmap_free(out.bytes);
        return st;
    }
    *bytes_ret = out.bytes;
    *nbytes_ret = out.n;
    return RMAP_OK;
}

/* ---- bytes in ---- */

struct cursor {
    const uint8_t *at, *end;
    size_t n_node;
    struct rmap_error *err;
};

static enum rmap_status damaged(struct cursor *in)
{
    return rmap_error_set(in->err, RMAP_FORMAT, "it is no scene");
}

static enum rmap_status take_number(struct cursor *in, int *value)
{
    size_t number = 0;
    unsigned shift = 0;
    do {
        if (in->at == in->end || shift > 28)
            return damaged(in);
        number |= (size_t)(*in->at & 0x7F) << shift;
        shift += 7;
    } while (*in->at++ & 0x80);
    if (number > INT_MAX)
        return damaged(in);
    *value = (int)number;
    return RMAP_OK;
}

static enum rmap_status take_text(struct cursor *in, const char **text)
{
    const uint8_t *end = memchr(in->at, 0, (size_t)(in->end - in->at));
    if (!end)
        return damaged(in);
    *text = (const char *)in->at;
    in->at = end + 1;
    return RMAP_OK;
}

static enum rmap_status no_memory(struct cursor *in)
{
    return rmap_error_set(in->err, RMAP_SYSTEM, "out of memory for a scene");
}

/* Objects of a list have the same keys, mostly in the same order: one copy serves all. */
static char *key_of(struct rmap_pool *pool, const char *text, const struct rmap_yaml_node *before,
                    size_t i)
{
    const bool same = before && i < before->n_item && before->kind == RMAP_YAML_MAP &&
                      strcmp(before->item[i].key, text) == 0;
    return same ? before->item[i].key : rmap_pool_strdup(pool, text);
}

/* Into a node that is there; `before` is that of the item before it, or NULL. */
static enum rmap_status take_node(struct cursor *in, struct rmap_yaml_node *node,
                                  const struct rmap_yaml_node *before, int depth)
{
    enum rmap_status st = RMAP_OK;
    int kind = 0, n = 0;
    const char *text = NULL;
    struct rmap_yaml_node *value;
    RMAP_TRY(take_number(in, &kind));
    if ((kind & KIND) > RMAP_YAML_MAP || kind > (KIND | QUOTED) || depth > RMAP_YAML_DEPTH_MAX)
        RMAP_TRY(damaged(in));
    node->kind = (enum rmap_yaml_kind)(kind & KIND);
    node->quoted = kind & QUOTED;
    RMAP_TRY(take_number(in, &node->line));
    RMAP_TRY(take_number(in, &node->column));
    if (node->kind == RMAP_YAML_SCALAR) {
        RMAP_TRY(take_text(in, &text));
        node->text = rmap_pool_strdup(node->pool, text);
        return node->text ? st : no_memory(in);
    }
    RMAP_TRY(take_number(in, &n));
    in->n_node += (size_t)n; /* what a damaged number can claim has an end */
    if (in->n_node > RMAP_YAML_NODE_MAX + RMAP_YAML_COPY_MAX)
        RMAP_TRY(damaged(in));
    node->item = rmap_pool_alloc(node->pool, (size_t)n, sizeof *node->item);
    value = rmap_pool_alloc(node->pool, (size_t)n, sizeof *value);
    if (!node->item || !value)
        RMAP_TRY(no_memory(in));
    node->cap_item = (size_t)n;
    for (size_t i = 0; i < node->cap_item; i++) {
        struct rmap_yaml_item item = {.value = &value[i]};
        value[i] = (struct rmap_yaml_node){.pool = node->pool};
        if (node->kind == RMAP_YAML_MAP) {
            RMAP_TRY(take_text(in, &text));
            item.key = key_of(node->pool, text, before, i);
            if (!item.key)
                RMAP_TRY(no_memory(in));
        }
        RMAP_TRY(take_number(in, &item.line));
        RMAP_TRY(take_number(in, &item.column));
        RMAP_TRY(take_node(in, &value[i], i > 0 ? &value[i - 1] : NULL, depth + 1));
        node->item[node->n_item++] = item;
    }
out:
    return st;
}

enum rmap_status rmap_yaml_unpack(const uint8_t *bytes, size_t nbytes,
                                  struct rmap_yaml_node **root_ret, struct rmap_error *err)
{
    struct cursor in = {.at = bytes, .end = bytes + nbytes, .err = err};
    struct rmap_yaml_node *root = rmap_yaml_create();
    if (!root)
        return no_memory(&in);
    enum rmap_status st = take_node(&in, root, NULL, 1);
    if (st == RMAP_OK && in.at != in.end)
        st = damaged(&in);
    if (st == RMAP_OK)
        *root_ret = root;
    else
        rmap_yaml_destroy(root);
    return st;
}

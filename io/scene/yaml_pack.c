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

/* Into a node that is there. */
static enum rmap_status take_node(struct cursor *in, struct rmap_yaml_node *node, int depth)
{
    enum rmap_status st = RMAP_OK;
    int kind = 0, n = 0, line = 0, column = 0;
    const char *text = NULL;
    RMAP_TRY(take_number(in, &kind));
    if ((kind & KIND) > RMAP_YAML_MAP || kind > (KIND | QUOTED) || depth > RMAP_YAML_DEPTH_MAX ||
        ++in->n_node > RMAP_YAML_NODE_MAX + RMAP_YAML_COPY_MAX)
        RMAP_TRY(damaged(in));
    node->kind = (enum rmap_yaml_kind)(kind & KIND);
    node->quoted = kind & QUOTED;
    RMAP_TRY(take_number(in, &node->line));
    RMAP_TRY(take_number(in, &node->column));
    if (node->kind == RMAP_YAML_SCALAR) {
        RMAP_TRY(take_text(in, &text));
        node->text = rmap_pool_strdup(node->pool, text);
        return node->text ? st : rmap_error_set(in->err, RMAP_SYSTEM, "out of memory for a scene");
    }
    RMAP_TRY(take_number(in, &n));
    for (int i = 0; i < n; i++) {
        struct rmap_yaml_node *value = rmap_yaml_new(node, RMAP_YAML_SCALAR, 0, 0);
        if (!value)
            RMAP_TRY(rmap_error_set(in->err, RMAP_SYSTEM, "out of memory for a scene"));
        if (node->kind == RMAP_YAML_MAP)
            RMAP_TRY(take_text(in, &text));
        RMAP_TRY(take_number(in, &line));
        RMAP_TRY(take_number(in, &column));
        RMAP_TRY(take_node(in, value, depth + 1));
        RMAP_TRY(rmap_yaml_append(node, text, line, column, value, in->err));
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
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    enum rmap_status st = take_node(&in, root, 1);
    if (st == RMAP_OK && in.at != in.end)
        st = damaged(&in);
    if (st == RMAP_OK)
        *root_ret = root;
    else
        rmap_yaml_destroy(root);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Differences of two YAML trees, as far down as their keys and names are the same.
 */
#include "io/scene/yaml_difference.h"

#include <string.h>

enum { PATH = 1000 };

struct difference {
    const char *indent;
    FILE *out;
    size_t n;
    char path[PATH];
};

static bool is_equal(const struct rmap_yaml_node *a, const struct rmap_yaml_node *b)
{
    if (a->kind != b->kind || a->n_item != b->n_item)
        return false;
    if (a->kind == RMAP_YAML_SCALAR)
        return strcmp(a->text, b->text) == 0;
    for (size_t i = 0; i < a->n_item; i++)
        if ((a->item[i].key && strcmp(a->item[i].key, b->item[i].key) != 0) ||
            !is_equal(a->item[i].value, b->item[i].value))
            return false;
    return true;
}

static void put_value(FILE *out, const struct rmap_yaml_node *node)
{
    if (node->kind == RMAP_YAML_SCALAR) {
        (void)fprintf(out, node->quoted ? "'%s'" : "%s", node->text);
        return;
    }
    (void)fputc(node->kind == RMAP_YAML_LIST ? '[' : '{', out);
    for (size_t i = 0; i < node->n_item; i++) {
        (void)fputs(i ? ", " : "", out);
        if (node->item[i].key)
            (void)fprintf(out, "%s: ", node->item[i].key);
        put_value(out, node->item[i].value);
    }
    (void)fputc(node->kind == RMAP_YAML_LIST ? ']' : '}', out);
}

static const char *name_of(const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *name = rmap_yaml_get(node, "name");
    return name && name->kind == RMAP_YAML_SCALAR ? name->text : "";
}

/* Whether the items of two lists can be set one by one. */
static bool is_alike(const struct rmap_yaml_node *a, const struct rmap_yaml_node *b)
{
    if (a->n_item != b->n_item)
        return false;
    for (size_t i = 0; i < a->n_item; i++)
        if (a->item[i].value->kind != RMAP_YAML_MAP || b->item[i].value->kind != RMAP_YAML_MAP ||
            strcmp(name_of(a->item[i].value), name_of(b->item[i].value)) != 0)
            return false;
    return true;
}

/* What is there and is not in the other cannot be taken away. */
static bool has_all_keys(const struct rmap_yaml_node *of, const struct rmap_yaml_node *in)
{
    for (size_t i = 0; i < of->n_item; i++)
        if (!rmap_yaml_get(in, of->item[i].key))
            return false;
    return true;
}

static void compare(struct difference *d, const struct rmap_yaml_node *a,
                    const struct rmap_yaml_node *b);

/* Of b alone where a is NULL. */
static void compare_below(struct difference *d, const char *name, const struct rmap_yaml_node *a,
                          const struct rmap_yaml_node *b)
{
    const size_t n = strlen(d->path);
    if (n == 0 && strcmp(name, "simulations") == 0)
        return;
    if (snprintf(d->path + n, PATH - n, "%s%s", n ? "." : "", name) >= (int)(PATH - n)) {
        d->path[n] = 0;
        return;
    }
    compare(d, a, b);
    d->path[n] = 0;
}

static void compare(struct difference *d, const struct rmap_yaml_node *a,
                    const struct rmap_yaml_node *b)
{
    if (a && is_equal(a, b))
        return;
    if (a && a->kind == RMAP_YAML_MAP && b->kind == RMAP_YAML_MAP && has_all_keys(a, b)) {
        for (size_t i = 0; i < b->n_item; i++)
            compare_below(d, b->item[i].key, rmap_yaml_get(a, b->item[i].key), b->item[i].value);
    } else if (a && a->kind == RMAP_YAML_LIST && b->kind == RMAP_YAML_LIST && is_alike(a, b)) {
        for (size_t i = 0; i < b->n_item; i++) {
            char number[24];
            const char *name = name_of(b->item[i].value);
            (void)snprintf(number, sizeof number, "%zu", i + 1);
            compare_below(d, name[0] ? name : number, a->item[i].value, b->item[i].value);
        }
    } else {
        (void)fprintf(d->out, "%s%s: ", d->indent, d->path);
        put_value(d->out, b);
        (void)fputc('\n', d->out);
        d->n++;
    }
}

size_t rmap_yaml_difference(const struct rmap_yaml_node *base, const struct rmap_yaml_node *other,
                            const char *indent, FILE *out)
{
    struct difference d = {.indent = indent, .out = out};
    compare(&d, base, other);
    return d.n;
}

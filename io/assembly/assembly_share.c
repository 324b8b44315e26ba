/* SPDX-License-Identifier: MIT
 *
 * Equal shapes, which a file has several times.
 */
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/assembly/assembly.h"

static bool same_text(const char *a, const char *b)
{
    return strcmp(a ? a : "", b ? b : "") == 0;
}

static bool same_looks(const struct rmap_assembly_face *a, const struct rmap_assembly_face *b)
{
    return same_text(a->material, b->material) && a->colour.given == b->colour.given &&
           memcmp(a->colour.rgb, b->colour.rgb, sizeof a->colour.rgb) == 0;
}

/* Its parts have them from the first face. */
static void drop_common_looks(struct rmap_assembly_shape *shape)
{
    for (size_t f = 1; f < shape->n_face; f++)
        if (!same_looks(&shape->face[0], &shape->face[f]))
            return;
    for (size_t f = 0; f < shape->n_face; f++) {
        rmap_free(shape->face[f].material);
        shape->face[f].material = NULL;
        shape->face[f].colour = (struct rmap_assembly_colour){0};
    }
}

static bool is_same(const struct rmap_assembly_shape *a, const struct rmap_assembly_shape *b)
{
    bool same = a->n_face == b->n_face;
    for (size_t f = 0; same && f < a->n_face; f++)
        same = same_looks(&a->face[f], &b->face[f]);
    return same;
}

struct by_hash {
    const struct rmap_assembly_shape *shape;
};

/* Of one hash the first in the file comes first. */
static int compare(const void *a, const void *b)
{
    const struct by_hash *x = a, *y = b;
    const int order = strcmp(x->shape->hash, y->shape->hash);
    return order ? order : (x->shape > y->shape) - (x->shape < y->shape);
}

/* same[i]: the first shape that is as shape i, or i. */
static void find_same(const struct rmap_assembly *a, struct by_hash *list, int32_t *same)
{
    for (size_t i = 0; i < a->n_shape; i++) {
        list[i].shape = &a->shape[i];
        same[i] = (int32_t)i;
    }
    if (a->n_shape > 0)
        qsort(list, a->n_shape, sizeof *list, compare);
    for (size_t i = 0, first = 0; i < a->n_shape; i++) {
        if (strcmp(list[first].shape->hash, list[i].shape->hash) != 0)
            first = i;
        /* Of those that look otherwise one after the other is a first. */
        if (i != first && is_same(list[first].shape, list[i].shape))
            same[list[i].shape - a->shape] = (int32_t)(list[first].shape - a->shape);
        else
            first = i;
    }
}

enum rmap_status rmap_assembly_share(struct rmap_assembly *a, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct by_hash *list = rmap_alloc(a->n_shape, sizeof *list);
    int32_t *same = rmap_alloc(a->n_shape, sizeof *same), *at = rmap_alloc(a->n_shape, sizeof *at);
    size_t n = 0;
    if (!list || !same || !at)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu shapes", a->n_shape));
    for (size_t i = 0; i < a->n_shape; i++)
        drop_common_looks(&a->shape[i]);
    find_same(a, list, same);
    for (size_t i = 0; i < a->n_shape; i++) {
        if (same[i] != (int32_t)i) {
            rmap_assembly_shape_fini(&a->shape[i]);
            continue;
        }
        at[i] = (int32_t)n;
        a->shape[n++] = a->shape[i];
    }
    for (size_t i = 0; i < a->n_part; i++)
        if (a->part[i].shape >= 0)
            a->part[i].shape = at[same[a->part[i].shape]];
    a->n_shape = n;
out:
    rmap_free(list);
    rmap_free(same);
    rmap_free(at);
    return st;
}

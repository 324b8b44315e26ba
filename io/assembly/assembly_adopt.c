/* SPDX-License-Identifier: MIT
 *
 * What a revision takes over of the one before: names in the scene, and mesh files.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/assembly/assembly_match.h"

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
}

static enum rmap_status put_text(char **to, const char *text, struct rmap_error *err)
{
    rmap_free(*to);
    *to = rmap_strdup(text);
    return *to ? RMAP_OK : no_memory(err);
}

static bool same_mesh(const struct rmap_assembly_shape *a, const struct rmap_assembly_shape *b)
{
    return strcmp(a->hash, b->hash) == 0 && fabs(a->chord - b->chord) <= 1e-9 * fabs(a->chord);
}

struct by_hash {
    const struct rmap_assembly_shape *shape;
};

static int compare_hash(const void *a, const void *b)
{
    const struct by_hash *x = a, *y = b;
    return strcmp(x->shape->hash, y->shape->hash);
}

static enum rmap_status keep_file(const struct rmap_assembly_shape *before,
                                  struct rmap_assembly_shape *after, struct rmap_error *err)
{
    after->digest = before->digest;
    return put_text(&after->file, before->file, err);
}

/* A file that is as it was, and of the same chord, for the parts that had it. */
static enum rmap_status keep_own_files(const struct rmap_assembly *before,
                                       struct rmap_assembly *after,
                                       struct rmap_assembly_match *match, bool *taken,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < after->n_part && st == RMAP_OK; i++) {
        const int32_t from = match->from[i], to = after->part[i].shape,
                      old = from < 0 ? -1 : before->part[from].shape;
        if (to < 0 || old < 0 || match->kept[to] || taken[old] ||
            !same_mesh(&before->shape[old], &after->shape[to]))
            continue;
        taken[old] = match->kept[to] = true;
        st = keep_file(&before->shape[old], &after->shape[to], err);
    }
    return st;
}

/* Of any shape that is as it was. taken: [old shapes]. */
static enum rmap_status keep_files(const struct rmap_assembly *before, struct rmap_assembly *after,
                                   struct rmap_assembly_match *match, bool *taken,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct by_hash *list = rmap_alloc(before->n_shape, sizeof *list);
    if (!list)
        return no_memory(err);
    for (size_t i = 0; i < before->n_shape; i++)
        list[i].shape = &before->shape[i];
    if (before->n_shape > 0)
        qsort(list, before->n_shape, sizeof *list, compare_hash);
    for (size_t i = 0; i < after->n_shape && st == RMAP_OK; i++) {
        if (match->kept[i])
            continue;
        const struct by_hash wanted = {&after->shape[i]};
        const struct by_hash *found =
            before->n_shape ? bsearch(&wanted, list, before->n_shape, sizeof *list, compare_hash)
                            : NULL;
        const size_t old = found ? (size_t)(found->shape - before->shape) : 0;
        if (!found || taken[old] || !same_mesh(found->shape, &after->shape[i]))
            continue;
        taken[old] = match->kept[i] = true;
        st = keep_file(found->shape, &after->shape[i], err);
    }
    rmap_free(list);
    return st;
}

enum rmap_status rmap_assembly_adopt(const struct rmap_assembly *before,
                                     struct rmap_assembly *after, struct rmap_assembly_match *match,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool *taken = rmap_alloc(before->n_shape, sizeof *taken),
         *settled = rmap_alloc(after->n_shape, sizeof *settled);
    if (!taken || !settled)
        RMAP_TRY(no_memory(err));
    for (size_t i = 0; i < after->n_part; i++)
        if (match->from[i] >= 0) {
            after->part[i].number = before->part[match->from[i]].number;
            RMAP_TRY(put_text(&after->part[i].label, before->part[match->from[i]].label, err));
        }
    if (fabs(before->angle - after->angle) <= 1e-9 * before->angle) {
        RMAP_TRY(keep_own_files(before, after, match, taken, err));
        RMAP_TRY(keep_files(before, after, match, taken, err));
    }
    for (size_t i = 0; i < after->n_shape; i++)
        settled[i] = match->kept[i];
    for (size_t i = 0; i < after->n_part; i++) {
        const int32_t from = match->from[i], to = after->part[i].shape,
                      old = from < 0 ? -1 : before->part[from].shape;
        if (to < 0 || old < 0 || settled[to] || taken[old])
            continue;
        taken[old] = settled[to] = true;
        RMAP_TRY(put_text(&after->shape[to].file, before->shape[old].file, err));
    }
    for (size_t i = 0; i < after->n_shape; i++)
        if (!settled[i])
            RMAP_TRY(put_text(&after->shape[i].file, "", err));
out:
    rmap_free(taken);
    rmap_free(settled);
    return st;
}

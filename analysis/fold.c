/* SPDX-License-Identifier: MIT */
#include "analysis/fold.h"

#include "analysis/query_marker.h"
#include "base/alloc.h"

struct rmap_fold_scanner {
    const struct rmap_fold *fold;
    struct rmap_query_marker *marker; /* NULL: all rays match */
    struct rmap_cursor *cursor;
};

enum rmap_status rmap_fold_scanner_create(const struct rmap_fold *fold,
                                          struct rmap_fold_scanner **scanner_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_fold_scanner *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->fold = fold;
    RMAP_TRY(rmap_cursor_create(fold->map, fold->columns, &self->cursor, err));
    if (fold->criterion)
        RMAP_TRY(rmap_query_marker_create(fold->map, fold->criterion, &self->marker, err));
    *scanner_ret = self;
    self = NULL;
out:
    rmap_fold_scanner_destroy(self);
    return st;
}

void rmap_fold_scanner_destroy(struct rmap_fold_scanner *self)
{
    if (!self)
        return;
    rmap_query_marker_destroy(self->marker);
    rmap_cursor_destroy(self->cursor);
    rmap_free(self);
}

static enum rmap_status add_portion(struct rmap_fold_scanner *self, void *state, size_t index,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold *fold = self->fold;
    const struct rmap_portion_info *info = rmap_map_portion(fold->map, index);
    struct rmap_matched rays = {.index = index, .space = (size_t)info->space};
    uint8_t *match = NULL;
    if (fold->kind->may_count && !fold->kind->may_count(fold->context, info))
        return RMAP_OK;
    rays.n_match = (size_t)info->n_row[RMAP_TABLE_RAY];
    if (self->marker)
        RMAP_TRY(rmap_query_marker_mark(self->marker, index, &match, &rays.n_match, err));
    if (rays.n_match == 0)
        return RMAP_OK;
    rays.match = match;
    RMAP_TRY(rmap_cursor_read(self->cursor, index, &rays.portion, err));
    st = fold->kind->add(state, &rays, err);
out:
    return st;
}

enum rmap_status rmap_fold_scanner_add(struct rmap_fold_scanner *self, void *state, size_t first,
                                       size_t last, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = first; i < last && st == RMAP_OK; i++)
        st = add_portion(self, state, i, err);
    return st;
}

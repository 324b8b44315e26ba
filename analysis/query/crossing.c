/* SPDX-License-Identifier: MIT
 *
 * Which rays of a portion come to a detector.
 */
#include "analysis/query/crossing.h"

#include "base/alloc.h"
#include "io/map/map_cursor.h"

void rmap_crossing_fini(struct rmap_crossing_filter *self)
{
    rmap_free(self->crosses);
    rmap_free(self->own);
}

/* Which of these rays, whose registrations follow each other, cross it. */
static void look(const struct rmap_portion *rays, int32_t detector, uint8_t *crosses)
{
    size_t row = 0;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        crosses[i] = 0;
        for (const size_t end = row + rays->ray.registration_count[i]; row < end; row++)
            crosses[i] |= rays->registration.detector[row] == detector;
    }
}

/* Once for a piece. */
static enum rmap_status enter_piece(struct rmap_crossing_filter *self,
                                    const struct rmap_portion *paths, size_t piece,
                                    struct rmap_error *err)
{
    if (self->crosses && self->piece == piece)
        return RMAP_OK;
    const enum rmap_status st =
        RMAP_RESERVE(self->crosses, self->cap, paths->n_row[RMAP_TABLE_RAY] + 1, err);
    if (st != RMAP_OK)
        return st;
    look(paths, self->detector, self->crosses);
    self->piece = piece;
    return RMAP_OK;
}

/* By columns. */
static enum rmap_status keep_rows(struct rmap_crossing_filter *self,
                                  const struct rmap_portion *rays, uint8_t *match,
                                  struct rmap_error *err)
{
    const size_t n = rays->n_row[RMAP_TABLE_RAY];
    const enum rmap_status st = RMAP_RESERVE(self->own, self->cap_own, n + 1, err);
    if (st != RMAP_OK)
        return st;
    look(rays, self->detector, self->own);
    for (size_t i = 0; i < n; i++)
        match[i] &= self->own[i];
    return RMAP_OK;
}

enum rmap_status rmap_crossing_keep(struct rmap_crossing_filter *self, struct rmap_cursor *cursor,
                                    const struct rmap_portion *rays, size_t piece, uint8_t *match,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector);
    const size_t n = rays->n_row[RMAP_TABLE_RAY];
    const struct rmap_portion *own;
    struct rmap_path_summary summary;
    RMAP_TRY(rmap_cursor_path_summary(cursor, false, &summary, err));
    if (!summary.paths || !summary.paths->registration.detector) {
        RMAP_TRY(rmap_cursor_fetch(cursor, columns, err));
        return keep_rows(self, rays, match, err);
    }
    RMAP_TRY(enter_piece(self, summary.paths, piece, err));
    RMAP_TRY(RMAP_RESERVE(self->own, self->cap_own, summary.n_own + 1, err));
    if (summary.n_own > 0) {
        RMAP_TRY(rmap_cursor_own_paths(cursor, columns, &own, err));
        look(own, self->detector, self->own);
    }
    for (size_t i = 0, k = 0; i < n; i++) {
        const uint32_t path = summary.path[i];
        match[i] &= path > 0 ? self->crosses[path - 1] : self->own[k];
        k += path == 0;
    }
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Which registrations of a portion count: told by bounds where its columns are not there, and by
 * tracing the rays again that bounds leave open.
 */
#include <string.h>

#include "analysis/query/fold_internal.h"
#include "base/alloc.h"
#include "io/map/map_cursor.h"

/* Rays of the portion, all of them, that match and have registrations which are open: *n_ret. */
static enum rmap_status mark_unsure(struct rmap_fold_scanner *self, const struct rmap_matched *rays,
                                    size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = rays->portion;
    const size_t n = (size_t)rmap_map_portion(self->fold->map, rays->index)->n_row[RMAP_TABLE_RAY];
    RMAP_TRY(RMAP_RESERVE(self->unsure, self->unsure_cap, n + 1, err));
    memset(self->unsure, 0, n);
    *n_ret = 0;
    const uint8_t *const last = self->open + portion->n_row[RMAP_TABLE_REGISTRATION];
    const uint8_t *next = self->open;
    for (size_t s = 0, end = 0; (next = memchr(next, 1, (size_t)(last - next))); s++) {
        while (end + portion->ray.registration_count[s] <= (size_t)(next - self->open))
            end += portion->ray.registration_count[s++];
        end += portion->ray.registration_count[s];
        next = self->open + end;
        const uint8_t any = rays->match ? rays->match[s] : 1;
        self->unsure[self->row ? self->row[s] : s] = any;
        *n_ret += any;
    }
out:
    return st;
}

/* What counts of the rays that were traced again: ray [those] their rows. */
static enum rmap_status choose_exactly(struct rmap_fold_scanner *self,
                                       const struct rmap_portion *portion,
                                       const struct rmap_portion *traced, const uint32_t *ray,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->exact, self->exact_cap, traced->n_row[RMAP_TABLE_REGISTRATION] + 1,
                          err));
    RMAP_TRY(rmap_which_mark(self->which, traced, self->exact, err));
    const size_t n_traced = traced->n_row[RMAP_TABLE_RAY];
    for (size_t s = 0, k = 0, at = 0, from = 0; s < portion->n_row[RMAP_TABLE_RAY]; s++) {
        const size_t n = portion->ray.registration_count[s], its = self->row ? self->row[s] : s;
        while (k < n_traced && ray[k] < its)
            from += traced->ray.registration_count[k++];
        if (k < n_traced && ray[k] == its && n > 0)
            memcpy(self->chosen + at, self->exact + from, n);
        at += n;
    }
out:
    return st;
}

/* The whole portion takes the place of rays that were selected: which of its rays match, and room
 * for its registrations. */
static enum rmap_status read_whole(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = (size_t)rmap_map_portion(self->fold->map, rays->index)->n_row[RMAP_TABLE_RAY];
    if (self->row) {
        memset(self->unsure, 0, n);
        for (size_t s = 0; s < rays->portion->n_row[RMAP_TABLE_RAY]; s++)
            self->unsure[self->row[s]] = rays->match ? rays->match[s] : 1;
        rays->match = self->unsure;
        rays->scanner = self;
        self->row = NULL;
    }
    RMAP_TRY(rmap_fold_read(self, rmap_fold_columns(self->fold), &rays->portion, err));
    st = RMAP_RESERVE(self->chosen, self->chosen_cap,
                      rays->portion->n_row[RMAP_TABLE_REGISTRATION] + 1, err);
out:
    return st;
}

/* The registrations that count, of a portion which tells of some of them: the rays of the others
 * are traced again. */
static enum rmap_status choose_bounded(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set all = rmap_fold_columns(self->fold);
    const struct rmap_portion *traced = NULL;
    struct rmap_cursor *cursor;
    const uint32_t *ray;
    size_t n = 0;
    RMAP_TRY(RMAP_RESERVE(self->open, self->open_cap,
                          rays->portion->n_row[RMAP_TABLE_REGISTRATION] + 1, err));
    RMAP_TRY(rmap_which_bound(self->which, rays->portion, self->bounding, self->chosen, self->open,
                              err));
    RMAP_TRY(mark_unsure(self, rays, &n, err));
    if (n == 0)
        goto out;
    RMAP_TRY(rmap_fold_enter(self, &cursor, err));
    RMAP_TRY(rmap_cursor_select(cursor, self->unsure, 1, all, &traced, &ray, err));
    if (traced) {
        RMAP_TRY(choose_exactly(self, rays->portion, traced, ray, err));
    } else { /* too many for a selection, or read already */
        RMAP_TRY(read_whole(self, rays, err));
        st = rmap_which_mark(self->which, rays->portion, self->chosen, err);
    }
out:
    return st;
}

enum rmap_status rmap_fold_choose(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->chosen, self->chosen_cap,
                          rays->portion->n_row[RMAP_TABLE_REGISTRATION] + 1, err));
    RMAP_TRY(self->bounding ? choose_bounded(self, rays, err)
                            : rmap_which_mark(self->which, rays->portion, self->chosen, err));
    rays->chosen = self->chosen;
out:
    return st;
}

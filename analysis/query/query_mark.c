/* SPDX-License-Identifier: MIT
 *
 * Which rays of a portion a question picks: those that match a criterion, or those of a list of
 * ids; and those rays whole.
 */
#include "analysis/query/query_mark.h"

#include <string.h>

#include "analysis/criterion/criterion_tree.h"
#include "analysis/query/query_marker.h"
#include "base/alloc.h"
#include "base/count.h"
#include "io/map/map_cursor.h"

struct rmap_picker {
    const struct rmap_map *map;
    struct rmap_pick pick;
    struct rmap_query_marker *marker; /* each made when first needed */
    size_t in_hand;                   /* the marker's portion; SIZE_MAX: none */
    struct rmap_cursor *identify;     /* ids */
    struct rmap_cursor *whole;
    struct rmap_portion **picked; /* [spaces] */
    uint8_t *every;               /* marks of a portion without a criterion */
    size_t cap_every;
    uint64_t *id; /* of a portion without gaps */
    size_t cap_id;
};

rmap_column_set rmap_pick_columns(const struct rmap_pick *pick)
{
    return pick->columns ? pick->columns | RMAP_COLUMN_BIT(RMAP_RAY_id) |
                               RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                               RMAP_COLUMN_BIT(RMAP_RAY_registration_count)
                         : RMAP_COLUMNS_ALL;
}

enum rmap_status rmap_picker_create(const struct rmap_map *map, const struct rmap_pick *pick,
                                    struct rmap_picker **picker_ret, struct rmap_error *err)
{
    struct rmap_picker *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->picked = rmap_alloc(rmap_map_n_space(map), sizeof *self->picked);
    if (!self || !self->picked) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for picking rays");
    }
    self->map = map;
    self->pick = *pick;
    self->in_hand = SIZE_MAX;
    *picker_ret = self;
    return RMAP_OK;
}

void rmap_picker_destroy(struct rmap_picker *self)
{
    if (!self)
        return;
    for (size_t i = 0; i < rmap_map_n_space(self->map); i++)
        rmap_portion_destroy(self->picked[i]);
    rmap_free(self->picked);
    rmap_query_marker_destroy(self->marker);
    rmap_cursor_destroy(self->identify);
    rmap_cursor_destroy(self->whole);
    rmap_free(self->every);
    rmap_free(self->id);
    rmap_free(self);
}

/* The piece's chunks vouch for a portion's rows before memory is taken for them. */
static enum rmap_status vouch(struct rmap_picker *self, size_t portion,
                              const struct rmap_portion **rows_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (!self->identify)
        st = rmap_cursor_create(self->map, RMAP_COLUMN_BIT(RMAP_RAY_id), &self->identify, err);
    return st == RMAP_OK ? rmap_cursor_enter(self->identify, portion, rows_ret, err) : st;
}

enum rmap_status rmap_picker_ids(struct rmap_picker *self, size_t portion, const uint64_t **id_ret,
                                 struct rmap_error *err)
{
    const struct rmap_portion *rows = NULL;
    const struct rmap_portion_info *info = rmap_map_portion(self->map, portion);
    size_t n = (size_t)info->n_row[RMAP_TABLE_RAY];
    enum rmap_status st = vouch(self, portion, &rows, err);
    if (st == RMAP_OK && rmap_portion_has_gaps(info)) {
        st = rmap_cursor_fetch(self->identify, RMAP_COLUMN_BIT(RMAP_RAY_id), err);
        *id_ret = rows->ray.id;
        return st;
    }
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->id, self->cap_id, n, err);
    for (size_t i = 0; st == RMAP_OK && i < n; i++)
        self->id[i] = info->first_ray + i;
    *id_ret = self->id;
    return st;
}

/* First of the list that is at least `id`. */
static size_t lower_bound(const struct rmap_pick *pick, uint64_t id)
{
    size_t low = 0, high = pick->n_id;
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (pick->id[middle] < id)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Clears the marks of rays that are not in the list; all of them when none can be. */
static enum rmap_status keep_listed(struct rmap_picker *self, size_t portion, uint8_t *match,
                                    struct rmap_error *err)
{
    const struct rmap_portion_info *info = rmap_map_portion(self->map, portion);
    const struct rmap_pick *pick = &self->pick;
    size_t n = (size_t)info->n_row[RMAP_TABLE_RAY], at = lower_bound(pick, info->first_ray);
    const uint64_t *id = NULL;
    enum rmap_status st = rmap_picker_ids(self, portion, &id, err);
    for (size_t i = 0; st == RMAP_OK && i < n; i++) {
        while (at < pick->n_id && pick->id[at] < id[i])
            at++;
        match[i] &= at < pick->n_id && pick->id[at] == id[i];
    }
    return st;
}

static bool may_pick(const struct rmap_picker *self, const struct rmap_portion_info *info)
{
    const struct rmap_pick *pick = &self->pick;
    if (pick->criterion && rmap_criterion_skips(pick->criterion, info))
        return false;
    if (!pick->id)
        return true;
    size_t at = lower_bound(pick, info->first_ray);
    return at < pick->n_id && pick->id[at] < rmap_portion_end(info);
}

static enum rmap_status mark_every(struct rmap_picker *self, size_t portion, uint8_t **match_ret,
                                   struct rmap_error *err)
{
    const struct rmap_portion *rows;
    size_t n = (size_t)rmap_map_portion(self->map, portion)->n_row[RMAP_TABLE_RAY];
    enum rmap_status st = vouch(self, portion, &rows, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->every, self->cap_every, n, err);
    if (st == RMAP_OK && n > 0)
        memset(self->every, 1, n);
    *match_ret = self->every;
    return st;
}

static enum rmap_status mark_matching(struct rmap_picker *self, size_t portion, uint8_t **match_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n;
    self->in_hand = SIZE_MAX;
    RMAP_TRY(rmap_query_marker_enter(self->marker, portion, &n, err));
    RMAP_TRY(rmap_query_marker_mark(self->marker, match_ret, &n, err));
    self->in_hand = n > 0 ? portion : SIZE_MAX;
out:
    return st;
}

enum rmap_status rmap_picker_mark(struct rmap_picker *self, size_t portion,
                                  const uint8_t **match_ret, size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = rmap_map_portion(self->map, portion);
    const struct rmap_criterion *criterion = self->pick.criterion;
    size_t n = (size_t)info->n_row[RMAP_TABLE_RAY];
    uint8_t *match = NULL;
    *match_ret = NULL;
    *n_ret = 0;
    if (!may_pick(self, info))
        return RMAP_OK;
    if (criterion && !self->marker)
        RMAP_TRY(rmap_query_marker_create(self->map, criterion, rmap_pick_columns(&self->pick),
                                          &self->marker, err));
    if (criterion)
        RMAP_TRY(mark_matching(self, portion, &match, err));
    else
        RMAP_TRY(mark_every(self, portion, &match, err));
    if (!match)
        goto out;
    if (self->pick.id)
        RMAP_TRY(keep_listed(self, portion, match, err));
    *n_ret = rmap_count_ones(match, n);
    if (*n_ret > 0)
        *match_ret = match;
out:
    return st;
}

/* The cursor that has the portion in hand, or takes it. */
static enum rmap_status enter_whole(struct rmap_picker *self, size_t portion,
                                    struct rmap_cursor **cursor_ret,
                                    const struct rmap_portion **rows_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (self->in_hand == portion) {
        RMAP_TRY(rmap_query_marker_cursor(self->marker, cursor_ret, err));
        return rmap_query_marker_read(self->marker, 0, rows_ret, err);
    }
    if (!self->whole)
        RMAP_TRY(rmap_cursor_create(self->map, rmap_pick_columns(&self->pick), &self->whole, err));
    *cursor_ret = self->whole;
    st = rmap_cursor_enter(self->whole, portion, rows_ret, err);
out:
    return st;
}

enum rmap_status rmap_picker_read(struct rmap_picker *self, size_t portion, const uint8_t *match,
                                  size_t n, const struct rmap_portion **rays_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *rows = NULL;
    struct rmap_portion **picked = &self->picked[rmap_map_portion(self->map, portion)->space];
    const uint32_t *row;
    size_t segment = 0, registration = 0;
    const rmap_column_set columns = rmap_pick_columns(&self->pick);
    struct rmap_cursor *cursor;
    RMAP_TRY(enter_whole(self, portion, &cursor, &rows, err));
    RMAP_TRY(rmap_cursor_select(cursor, match, 1, columns, rays_ret, &row, err));
    const bool selected =
        *rays_ret != NULL; /* these, and others perhaps that the marker has seen */
    if (!selected) {
        RMAP_TRY(rmap_cursor_fetch(cursor, columns, err));
        *rays_ret = rows;
    }
    rows = *rays_ret;
    if (n == rows->n_row[RMAP_TABLE_RAY])
        goto out;
    if (!*picked)
        RMAP_TRY(rmap_portion_create(0, rows->n_channel, picked, err));
    rmap_portion_clear(*picked);
    for (size_t i = 0; i < rows->n_row[RMAP_TABLE_RAY]; i++) {
        if (match[selected ? row[i] : i])
            RMAP_TRY(rmap_portion_append_ray(*picked, rows, i, segment, registration, err));
        segment += rows->ray.segment_count[i];
        registration += rows->ray.registration_count[i];
    }
    *rays_ret = *picked;
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Reads the portions that may hold matches, and of those a column when a test, or the sums over
 * rays that matched, first ask for it. Criteria of one scan share what was read.
 */
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion_evaluate.h"
#include "analysis/query.h"
#include "analysis/query_collect.h"
#include "base/alloc.h"

/* What adding up matched rays takes. */
static const rmap_column_set sum_columns = RMAP_COLUMN_BIT(RMAP_RAY_source) |
                                           RMAP_COLUMN_BIT(RMAP_RAY_weight) |
                                           RMAP_COLUMN_BIT(RMAP_RAY_segment_count);

struct place {
    int32_t piece;
    size_t portion;
};

struct rmap_query_scanner {
    const struct rmap_map *map;
    struct rmap_criterion *const *criterion;
    size_t n_criterion, n_source;
    bool *wanted;        /* [n_criterion] that the portion in hand may answer */
    struct place *place; /* of the range in hand, in the order of reading */
    size_t place_cap;
    uint8_t *verdict; /* [n_ray] */
    size_t verdict_cap;
    struct rmap_judge judge;
    struct rmap_cursor *cursor; /* columns of the criteria and the sums */
    const struct rmap_portion *portion;
    struct rmap_count *count; /* [n_criterion], of the scan in hand */
    struct rmap_collector collector;
};

static bool skips(const struct rmap_criterion *criterion, const struct rmap_portion_info *info)
{
    return (double)info->first_ray > rmap_criterion_last_ray(criterion) ||
           !rmap_criterion_may_match(criterion, &info->summary);
}

static enum rmap_status fetch(void *context, rmap_column_set columns, struct rmap_error *err)
{
    struct rmap_query_scanner *self = context;
    return rmap_cursor_fetch(self->cursor, columns, err);
}

/* Without a branch per ray: which rays match is random. */
static enum rmap_status add_sums(const struct rmap_query_scanner *self, struct rmap_count *count,
                                 struct rmap_error *err)
{
    const struct rmap_portion *portion = self->portion;
    const struct rmap_ray_columns *ray = &portion->ray;
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    const uint8_t *verdict = self->verdict;
    for (size_t i = 0; i < n_ray; i++) {
        uint32_t match = verdict[i] & 1;
        count->rays += match;
        count->segments += ray->segment_count[i] & (0u - match);
    }
    for (size_t i = 0; i < n_ray; i++) {
        size_t source = (size_t)ray->source[i];
        double weight = verdict[i] ? ray->weight[i] : 0.0;
        if (source >= self->n_source)
            return rmap_error_set(
                err, RMAP_FORMAT, "a ray of the portion from id %llu on has source %d of %zu",
                (unsigned long long)portion->first_ray, (int)ray->source[i], self->n_source);
        count->source_weight[source] += weight;
        count->source_weight_squared[source] += weight * weight;
    }
    return RMAP_OK;
}

static enum rmap_status answer(struct rmap_query_scanner *self, size_t index, size_t c,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_evidence evidence = {.portion = self->portion,
                                           .columns = RMAP_COLUMNS_ALL,
                                           .flux_per_weight = rmap_map_flux_per_weight(self->map),
                                           .context = self,
                                           .fetch = fetch};
    self->count[c].portions_read++;
    RMAP_TRY(rmap_criterion_judge(self->criterion[c], &evidence, &self->judge, self->verdict, err));
    if (!memchr(self->verdict, RMAP_VERDICT_YES, self->portion->n_row[RMAP_TABLE_RAY]))
        return RMAP_OK;
    RMAP_TRY(fetch(self, sum_columns, err));
    RMAP_TRY(add_sums(self, &self->count[c], err));
    if (c == 0 && self->collector.rays)
        RMAP_TRY(rmap_collector_add(&self->collector, index, self->verdict, err));
out:
    return st;
}

static enum rmap_status scan_portion(struct rmap_query_scanner *self, size_t index,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_cursor_enter(self->cursor, index, &self->portion, err));
    void *block = self->verdict;
    RMAP_TRY(
        rmap_reserve(&block, &self->verdict_cap, self->portion->n_row[RMAP_TABLE_RAY], 1, err));
    self->verdict = block;
    for (size_t c = 0; c < self->n_criterion; c++)
        if (self->wanted[c])
            RMAP_TRY(answer(self, index, c, err));
out:
    return st;
}

/* Which criteria the portion may answer; true when any of them. */
static bool choose(struct rmap_query_scanner *self, size_t index)
{
    if (self->n_criterion == 1 && rmap_collector_is_done(&self->collector))
        return false;
    const struct rmap_portion_info *info = rmap_map_portion(self->map, index);
    bool any = false;
    for (size_t c = 0; c < self->n_criterion; c++) {
        self->wanted[c] = !(c == 0 && rmap_collector_is_done(&self->collector)) &&
                          !skips(self->criterion[c], info);
        any |= self->wanted[c];
    }
    return any;
}

static rmap_column_set columns_of(struct rmap_criterion *const *criterion, size_t n_criterion)
{
    rmap_column_set columns = sum_columns;
    for (size_t c = 0; c < n_criterion; c++)
        columns |= rmap_criterion_columns(criterion[c]);
    return columns;
}

enum rmap_status rmap_query_scanner_create(const struct rmap_map *map,
                                           struct rmap_criterion *const *criterion,
                                           size_t n_criterion,
                                           struct rmap_query_scanner **scanner_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_scanner *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    *self = (struct rmap_query_scanner){.map = map,
                                        .criterion = criterion,
                                        .n_criterion = n_criterion,
                                        .n_source = rmap_map_scene(map)->n_source,
                                        .collector.map = map};
    self->wanted = rmap_alloc(n_criterion, sizeof *self->wanted);
    if (!self->wanted)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", n_criterion));
    RMAP_TRY(rmap_cursor_create(map, columns_of(criterion, n_criterion), &self->cursor, err));
    *scanner_ret = self;
    self = NULL;
out:
    rmap_query_scanner_destroy(self);
    return st;
}

void rmap_query_scanner_destroy(struct rmap_query_scanner *self)
{
    if (!self)
        return;
    rmap_collector_fini(&self->collector);
    rmap_cursor_destroy(self->cursor);
    rmap_judge_fini(&self->judge);
    rmap_free(self->verdict);
    rmap_free(self->place);
    rmap_free(self->wanted);
    rmap_free(self);
}

static uint64_t nbytes_read(const struct rmap_query_scanner *self, bool with_rays)
{
    return rmap_cursor_nbytes_of_rows(self->cursor) +
           (with_rays && self->collector.whole ? rmap_cursor_nbytes_of_rows(self->collector.whole)
                                               : 0);
}

static int compare_places(const void *a, const void *b)
{
    const struct place *x = a, *y = b;
    if (x->piece != y->piece)
        return x->piece < y->piece ? -1 : 1;
    return (x->portion > y->portion) - (x->portion < y->portion);
}

/* Rays are collected in the order of their ids; to be counted, portions are read piece by piece:
 * chunks, and what is known of a piece, then are at hand. */
static enum rmap_status arrange(struct rmap_query_scanner *self, size_t first, size_t last,
                                struct rmap_error *err)
{
    void *block = self->place;
    enum rmap_status st =
        rmap_reserve(&block, &self->place_cap, last - first, sizeof *self->place, err);
    self->place = block;
    if (st != RMAP_OK || first == last)
        return st;
    for (size_t p = first; p < last; p++)
        self->place[p - first] = (struct place){rmap_map_portion(self->map, p)->piece, p};
    if (!self->collector.rays)
        qsort(self->place, last - first, sizeof *self->place, compare_places);
    return RMAP_OK;
}

enum rmap_status rmap_query_scanner_scan(struct rmap_query_scanner *self, size_t first, size_t last,
                                         struct rmap_count *count, struct rmap_portion *collect,
                                         uint64_t limit, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t before[2] = {nbytes_read(self, false), nbytes_read(self, true)};
    self->count = count;
    self->collector.rays = collect;
    self->collector.n_left = limit;
    RMAP_TRY(arrange(self, first, last, err));
    for (size_t i = 0; i < last - first; i++)
        if (choose(self, self->place[i].portion))
            RMAP_TRY(scan_portion(self, self->place[i].portion, err));
    for (size_t c = 0; c < self->n_criterion; c++)
        count[c].nbytes_read += nbytes_read(self, c == 0) - before[c == 0];
out:
    return st;
}

enum rmap_status rmap_query_scan(const struct rmap_map *map,
                                 struct rmap_criterion *const *criterion, size_t n_criterion,
                                 size_t first, size_t last, struct rmap_count *count,
                                 struct rmap_portion *collect, uint64_t limit,
                                 struct rmap_error *err)
{
    struct rmap_query_scanner *scanner = NULL;
    enum rmap_status st = rmap_query_scanner_create(map, criterion, n_criterion, &scanner, err);
    if (st == RMAP_OK)
        st = rmap_query_scanner_scan(scanner, first, last, count, collect, limit, err);
    rmap_query_scanner_destroy(scanner);
    return st;
}

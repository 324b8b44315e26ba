/* SPDX-License-Identifier: MIT
 *
 * One scan of a range of portions for several criteria: counts, and the matching rays if wanted.
 */
#include <math.h>
#include <stdlib.h>

#include "analysis/criterion/criterion_tree.h"
#include "analysis/query/query.h"
#include "analysis/query/query_collect.h"
#include "analysis/query/query_outcomes.h"
#include "analysis/query/query_pieces.h"
#include "analysis/table/flux_error.h"
#include "base/alloc.h"
#include "base/count.h"
#include "compact/streams.h"
#include "io/map/map_cursor.h"
#include "trace/tally.h"

/* Ranges of portions: which of them may hold matches, in which order they are read, what is done
 * with the rays that match. */

struct place {
    int32_t piece;
    size_t portion;
};

struct rmap_query_scanner {
    const struct rmap_map *map;
    const struct rmap_criterion **criterion; /* [n_criterion] */
    size_t n_criterion;
    bool *wanted;        /* [n_criterion] that the portion in hand may answer */
    struct place *place; /* of the range in hand, in the order of reading */
    size_t place_cap;
    struct rmap_query_outcomes *outcomes;
    const uint8_t *counted; /* [n_criterion][n_piece] or NULL */
    struct rmap_collector collector;
    uint8_t *match; /* [n_ray] of those collected */
    size_t match_cap;
};

static enum rmap_status collect(struct rmap_query_scanner *self, size_t index,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_ray = (size_t)rmap_map_portion(self->map, index)->n_row[RMAP_TABLE_RAY];
    RMAP_TRY(RMAP_RESERVE(self->match, self->match_cap, n_ray, err));
    RMAP_TRY(rmap_query_outcomes_mark(self->outcomes, 0, self->match, err));
    if (rmap_count_ones(self->match, n_ray) > 0)
        st = rmap_collector_add(&self->collector, index, self->match, err);
out:
    return st;
}

static bool is_counted(const struct rmap_query_scanner *self, size_t c, size_t piece)
{
    return self->counted && self->counted[c * rmap_map_n_piece(self->map) + piece];
}

/* Of criteria that the portion may answer: none of its rays is left to be looked at. */
static bool is_done(const struct rmap_query_scanner *self, const struct rmap_portion_info *info)
{
    bool done = info->stored_rows[RMAP_COMPACT_OWN] == 0;
    for (size_t c = 0; c < self->n_criterion; c++)
        done &= !self->wanted[c] || is_counted(self, c, (size_t)info->piece);
    return done;
}

static enum rmap_status scan_portion(struct rmap_query_scanner *self, size_t index,
                                     struct rmap_count *count, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion_info *info = rmap_map_portion(self->map, index);
    for (size_t c = 0; c < self->n_criterion; c++)
        count[c].portions_read += self->wanted[c];
    if (is_done(self, info))
        return RMAP_OK;
    RMAP_TRY(rmap_query_outcomes_enter(self->outcomes, index, err));
    for (size_t c = 0; c < self->n_criterion; c++) {
        if (!self->wanted[c])
            continue;
        if (is_counted(self, c, (size_t)info->piece)) {
            RMAP_TRY(rmap_query_outcomes_add_own(self->outcomes, c, err));
            continue;
        }
        RMAP_TRY(rmap_query_outcomes_add(self->outcomes, c, &count[c], err));
        if (c == 0 && self->collector.rays)
            RMAP_TRY(collect(self, index, err));
    }
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
                          !rmap_criterion_skips(self->criterion[c], info);
        any |= self->wanted[c];
    }
    return any;
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
    *self =
        (struct rmap_query_scanner){.map = map, .n_criterion = n_criterion, .collector.map = map};
    self->criterion = rmap_alloc(n_criterion, sizeof(void *));
    self->wanted = rmap_alloc(n_criterion, sizeof *self->wanted);
    if (!self->wanted || !self->criterion)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", n_criterion));
    for (size_t c = 0; c < n_criterion; c++)
        self->criterion[c] = criterion[c];
    RMAP_TRY(
        rmap_query_outcomes_create(map, self->criterion, n_criterion, 0, &self->outcomes, err));
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
    rmap_query_outcomes_destroy(self->outcomes);
    rmap_free(self->match);
    rmap_free(self->place);
    rmap_free(self->wanted);
    rmap_free(self->criterion);
    rmap_free(self);
}

static uint64_t nbytes_read(const struct rmap_query_scanner *self, bool with_rays)
{
    return rmap_query_outcomes_nbytes(self->outcomes) +
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
    enum rmap_status st = RMAP_RESERVE(self->place, self->place_cap, last - first, err);
    if (st != RMAP_OK || first == last)
        return st;
    for (size_t p = first; p < last; p++)
        self->place[p - first] = (struct place){rmap_map_portion(self->map, p)->piece, p};
    if (!self->collector.rays)
        qsort(self->place, last - first, sizeof *self->place, compare_places);
    return RMAP_OK;
}

void rmap_query_scanner_set_counted(struct rmap_query_scanner *self, const uint8_t *counted)
{
    self->counted = counted;
}

enum rmap_status rmap_query_scanner_scan(struct rmap_query_scanner *self, size_t first, size_t last,
                                         struct rmap_count *count, struct rmap_portion *collect,
                                         uint64_t limit, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t before[2] = {nbytes_read(self, false), nbytes_read(self, true)};
    self->collector.rays = collect;
    self->collector.n_left = limit;
    RMAP_TRY(arrange(self, first, last, err));
    for (size_t i = 0; i < last - first; i++)
        if (choose(self, self->place[i].portion))
            RMAP_TRY(scan_portion(self, self->place[i].portion, count, err));
    rmap_query_outcomes_settle(self->outcomes, count);
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
    enum rmap_status st = RMAP_OK;
    struct rmap_query_scanner *scanner = NULL;
    uint8_t *counted = NULL;
    if (first == 0 && last == rmap_map_n_portion(map) && !collect)
        RMAP_TRY(rmap_query_pieces_count(map, criterion, n_criterion, 0, 1, count, &counted, err));
    RMAP_TRY(rmap_query_scanner_create(map, criterion, n_criterion, &scanner, err));
    rmap_query_scanner_set_counted(scanner, counted);
    st = rmap_query_scanner_scan(scanner, first, last, count, collect, limit, err);
out:
    rmap_query_scanner_destroy(scanner);
    rmap_free(counted);
    return st;
}

enum rmap_status rmap_count_init(struct rmap_count *count, size_t n_source, struct rmap_error *err)
{
    *count = (struct rmap_count){.source_weight = rmap_alloc(n_source, sizeof(double)),
                                 .source_weight_squared = rmap_alloc(n_source, sizeof(double))};
    if (count->source_weight && count->source_weight_squared)
        return RMAP_OK;
    rmap_count_fini(count);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the sums of %zu sources", n_source);
}

void rmap_count_fini(struct rmap_count *count)
{
    rmap_free(count->source_weight);
    rmap_free(count->source_weight_squared);
    *count = (struct rmap_count){0};
}

void rmap_count_add(struct rmap_count *into, const struct rmap_count *from, size_t n_source)
{
    into->rays += from->rays;
    into->segments += from->segments;
    into->portions_read += from->portions_read;
    into->nbytes_read += from->nbytes_read;
    for (size_t s = 0; s < n_source; s++) {
        into->source_weight[s] += from->source_weight[s];
        into->source_weight_squared[s] += from->source_weight_squared[s];
    }
}

void rmap_count_flux(const struct rmap_count *count, const struct rmap_map *map, double *flux_ret,
                     double *standard_error_ret)
{
    const double *emitted = rmap_map_emitted(map);
    const double *flux_per_weight = rmap_map_flux_per_weight(map);
    double flux = 0.0, variance = 0.0;
    for (size_t s = 0; s < rmap_map_scene(map)->n_source; s++) {
        double w = count->source_weight[s];
        double w2 = count->source_weight_squared[s];
        flux += rmap_map_flux(map, s, w);
        variance += rmap_flux_variance(flux_per_weight[s], emitted[s], w, w2);
    }
    *flux_ret = flux;
    *standard_error_ret = rmap_flux_error(variance);
}

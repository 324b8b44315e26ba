/* SPDX-License-Identifier: MIT
 *
 * Discrete criteria on whole pieces, by the paths of their dictionaries.
 */
#include "analysis/query/query_pieces.h"

#include <string.h>

#include "analysis/criterion/criterion_evaluate.h"
#include "analysis/query/query_known.h"
#include "base/alloc.h"
#include "compact/streams.h"
#include "io/map/piece_paths.h"

struct pieces {
    const struct rmap_map *map;
    struct rmap_criterion *const *criterion;
    size_t n_criterion;
    struct rmap_evaluator evaluator;
    uint8_t *outcome; /* [paths of a piece] */
    size_t outcome_cap;
};

static bool is_discrete(const struct rmap_criterion *criterion)
{
    return (rmap_criterion_columns(criterion) & ~RMAP_COLUMNS_DISCRETE) == 0;
}

/* Whether any criterion can be counted so. */
static bool is_useful(const struct pieces *self)
{
    bool any = false;
    for (size_t c = 0; c < self->n_criterion; c++) {
        const struct rmap_criterion *one = self->criterion[c];
        if (!rmap_query_known_tells(self->map, &one, 1)) /* who scans portions must know paths */
            return false;
        any |= is_discrete(one);
    }
    return any;
}

static void add(struct rmap_count *count, const struct rmap_piece_paths *piece,
                const uint8_t *outcome)
{
    const struct rmap_ray_columns *ray = &piece->paths->ray;
    for (size_t i = 0; i < piece->paths->n_row[RMAP_TABLE_RAY]; i++) {
        const uint64_t rays = outcome[i] == RMAP_OUTCOME_YES ? piece->of[i].rays : 0;
        count->rays += rays;
        count->segments += rays * ray->segment_count[i];
        count->source_weight[ray->source[i]] += (double)rays;
        count->source_weight_squared[ray->source[i]] += (double)rays;
    }
}

static enum rmap_status count_piece(struct pieces *self, const struct rmap_piece_paths *piece,
                                    size_t c, struct rmap_count *count, uint8_t *counted,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = piece->paths->n_row[RMAP_TABLE_RAY];
    const struct rmap_criterion_input input = {.portion = piece->paths,
                                               .columns = RMAP_COLUMNS_DISCRETE};
    RMAP_TRY(RMAP_RESERVE(self->outcome, self->outcome_cap, n, err));
    RMAP_TRY(
        rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, self->outcome, err));
    if (memchr(self->outcome, RMAP_OUTCOME_OPEN, n))
        goto out;
    add(count, piece, self->outcome);
    *counted = 1;
out:
    return st;
}

/* needed: [n_piece] becomes true for those of the pieces first, first + step, ... of which some
 * portion may have a match of a discrete criterion. */
static void find_needed(const struct pieces *self, size_t first, size_t step, bool *needed)
{
    for (size_t i = 0; i < rmap_map_n_portion(self->map); i++) {
        const struct rmap_portion_info *info = rmap_map_portion(self->map, i);
        const size_t p = (size_t)info->piece;
        for (size_t c = 0; c < self->n_criterion && p % step == first && !needed[p]; c++)
            needed[p] =
                is_discrete(self->criterion[c]) && !rmap_criterion_skips(self->criterion[c], info);
    }
}

/* All discrete criteria on a piece. counted: [n_criterion][n_piece]. */
static enum rmap_status visit_piece(struct pieces *self, size_t p, const struct rmap_piece_sum *sum,
                                    struct rmap_count *count, uint8_t *counted,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_piece_paths piece = {0};
    bool told;
    rmap_column_set columns = 0;
    for (size_t c = 0; c < self->n_criterion; c++)
        if (is_discrete(self->criterion[c]))
            columns |= rmap_criterion_columns(self->criterion[c]);
    RMAP_TRY(rmap_piece_paths_open(self->map, p, rmap_compact_needs_rows(columns), sum, &piece,
                                   &told, err));
    for (size_t c = 0; told && c < self->n_criterion; c++)
        if (is_discrete(self->criterion[c]))
            RMAP_TRY(count_piece(self, &piece, c, &count[c],
                                 &counted[c * rmap_map_n_piece(self->map) + p], err));
out:
    rmap_piece_paths_fini(&piece);
    return st;
}

enum rmap_status rmap_query_pieces_count(const struct rmap_map *map,
                                         struct rmap_criterion *const *criterion,
                                         size_t n_criterion, size_t first, size_t step,
                                         struct rmap_count *count, uint8_t **counted_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct pieces self = {.map = map, .criterion = criterion, .n_criterion = n_criterion};
    const size_t n_piece = rmap_map_n_piece(map);
    struct rmap_piece_sum *sum = NULL;
    uint8_t *counted = NULL;
    bool *needed = NULL;
    *counted_ret = NULL;
    if (!is_useful(&self))
        return RMAP_OK;
    counted = rmap_alloc(n_criterion * n_piece, 1);
    needed = rmap_alloc(n_piece, sizeof *needed);
    if (!counted || !needed)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the pieces of a map"));
    RMAP_TRY(rmap_piece_sums(map, &sum, err));
    find_needed(&self, first, step, needed);
    for (size_t p = first; p < n_piece; p += step)
        if (needed[p])
            RMAP_TRY(visit_piece(&self, p, &sum[p], count, counted, err));
    *counted_ret = counted;
    counted = NULL;
out:
    rmap_free(counted);
    rmap_evaluator_fini(&self.evaluator);
    rmap_free(self.outcome);
    rmap_free(needed);
    rmap_free(sum);
    return st;
}

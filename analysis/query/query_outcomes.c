/* SPDX-License-Identifier: MIT
 *
 * What several criteria say of the rays of a portion, by their paths where these tell, and of the
 * rays that they leave open, by columns.
 */
#include <string.h>

#include "analysis/criterion/criterion_tree.h"
#include "analysis/query/query_known.h"
#include "analysis/query/query_outcomes.h"
#include "analysis/query/query_sums.h"
#include "base/alloc.h"
#include "base/count.h"
#include "base/wide.h"
#include "io/map/map_cursor.h"

struct rmap_query_outcomes {
    const struct rmap_map *map;
    const struct rmap_criterion *const *criterion;
    size_t n_criterion, n_source;
    rmap_column_set more; /* that rays which match are asked for */
    struct rmap_evaluator evaluator;
    struct rmap_cursor *cursor;           /* columns of the criteria and the sums */
    struct rmap_query_known *known_paths; /* or NULL */

    size_t index; /* portion in hand */
    size_t n_ray;
    bool is_entered;                    /* by the cursor */
    const struct rmap_portion *portion; /* the cursor's */
    bool is_by_paths;  /* what was evaluated last, but for the rays that they leave open */
    bool is_looked_at; /* for what the sums need to know: */
    struct rmap_sums_facts facts;
    uint8_t *open, *marked; /* [n_ray] outcomes of open rays; of all rays */
    size_t open_cap, marked_cap;
};

/* Columns of the portion in hand. */

uint64_t rmap_query_outcomes_nbytes(const struct rmap_query_outcomes *self)
{
    return rmap_cursor_nbytes_of_rows(self->cursor);
}

/* The portion's columns in hand. */
static enum rmap_status query_outcomes_enter_columns(struct rmap_query_outcomes *self,
                                                     struct rmap_error *err)
{
    if (self->is_entered)
        return RMAP_OK;
    enum rmap_status st = rmap_cursor_enter(self->cursor, self->index, &self->portion, err);
    self->is_entered = st == RMAP_OK;
    return st;
}

/* For input: context is the outcomes, which have entered columns. */
static enum rmap_status query_outcomes_fetch(void *context, rmap_column_set columns,
                                             struct rmap_error *err)
{
    struct rmap_query_outcomes *self = context;
    return rmap_cursor_fetch(self->cursor, columns, err);
}

enum rmap_status rmap_query_outcomes_read(struct rmap_query_outcomes *self, rmap_column_set columns,
                                          const struct rmap_portion **portion_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = query_outcomes_enter_columns(self, err);
    *portion_ret = self->portion;
    return st == RMAP_OK ? query_outcomes_fetch(self, columns, err) : st;
}

enum rmap_status rmap_query_outcomes_weigh(struct rmap_query_outcomes *self, bool *are_one_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = query_outcomes_enter_columns(self, err);
    return st == RMAP_OK ? rmap_cursor_weigh(self->cursor, are_one_ret, err) : st;
}

enum rmap_status rmap_query_outcomes_cursor(struct rmap_query_outcomes *self,
                                            struct rmap_cursor **cursor_ret, struct rmap_error *err)
{
    *cursor_ret = self->cursor;
    return query_outcomes_enter_columns(self, err);
}

/* What adding up matched rays takes. */
static const rmap_column_set sum_columns = RMAP_COLUMN_BIT(RMAP_RAY_source) |
                                           RMAP_COLUMN_BIT(RMAP_RAY_weight) |
                                           RMAP_COLUMN_BIT(RMAP_RAY_segment_count);

rmap_column_set rmap_query_columns(const struct rmap_criterion *const *criterion,
                                   size_t n_criterion)
{
    rmap_column_set columns = sum_columns;
    for (size_t c = 0; c < n_criterion; c++)
        columns |= rmap_criterion_columns(criterion[c]);
    return columns;
}

enum rmap_status rmap_query_outcomes_create(const struct rmap_map *map,
                                            const struct rmap_criterion *const *criterion,
                                            size_t n_criterion, rmap_column_set more,
                                            struct rmap_query_outcomes **outcomes_ret,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_outcomes *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->map = map;
    self->criterion = criterion;
    self->n_criterion = n_criterion;
    self->n_source = rmap_map_scene(map)->n_source;
    self->more = more;
    RMAP_TRY(rmap_query_known_create(map, criterion, n_criterion, &self->known_paths, err));
    RMAP_TRY(rmap_cursor_create(map, rmap_query_columns(criterion, n_criterion) | more,
                                &self->cursor, err));
    *outcomes_ret = self;
    self = NULL;
out:
    rmap_query_outcomes_destroy(self);
    return st;
}

void rmap_query_outcomes_destroy(struct rmap_query_outcomes *self)
{
    if (!self)
        return;
    rmap_query_known_destroy(self->known_paths);
    rmap_cursor_destroy(self->cursor);
    rmap_evaluator_fini(&self->evaluator);
    rmap_free(self->open);
    rmap_free(self->marked);
    rmap_free(self);
}

enum rmap_status rmap_query_outcomes_enter(struct rmap_query_outcomes *self, size_t portion,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->index = portion;
    self->is_entered = self->is_looked_at = self->is_by_paths = false;
    self->n_ray = (size_t)rmap_map_portion(self->map, portion)->n_row[RMAP_TABLE_RAY];
    /* The piece's chunks vouch for the number of rays. */
    RMAP_TRY(query_outcomes_enter_columns(self, err));
    RMAP_TRY(RMAP_RESERVE(self->open, self->open_cap, self->n_ray, err));
    RMAP_TRY(RMAP_RESERVE(self->marked, self->marked_cap, self->n_ray, err));
    if (self->known_paths)
        rmap_query_known_enter(self->known_paths, self->cursor, portion, self->n_ray);
out:
    return st;
}

enum rmap_status rmap_query_outcomes_narrow(struct rmap_query_outcomes *self, bool *is_narrow_ret,
                                            size_t *n_ray_ret, struct rmap_error *err)
{
    const enum rmap_status st = rmap_cursor_narrow(self->cursor, is_narrow_ret, err);
    *n_ray_ret = self->n_ray = self->portion->n_row[RMAP_TABLE_RAY];
    if (self->known_paths)
        rmap_query_known_enter(self->known_paths, self->cursor, self->index, self->n_ray);
    return st;
}

static enum rmap_status evaluate_columns(struct rmap_query_outcomes *self, size_t c,
                                         uint8_t *outcome, struct rmap_error *err)
{
    const struct rmap_criterion_input input = {.portion = self->portion,
                                               .columns = RMAP_COLUMNS_ALL,
                                               .flux_per_weight =
                                                   rmap_map_flux_per_weight(self->map),
                                               .context = self,
                                               .fetch = query_outcomes_fetch};
    return rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, outcome, err);
}

/* What decides rays that paths leave open: `and` and `or` ask no discrete test of theirs again. */
static rmap_column_set rest_columns(const struct rmap_criterion *criterion)
{
    const struct rmap_criterion_node *node = &criterion->node[criterion->root];
    rmap_column_set columns = 0;
    while (node->kind == RMAP_CRITERION_NOT)
        node = &criterion->node[node->first];
    if (node->kind != RMAP_CRITERION_AND && node->kind != RMAP_CRITERION_OR)
        return node->columns;
    for (int32_t child = node->first; child >= 0; child = criterion->node[child].next)
        if (criterion->node[child].columns & ~RMAP_COLUMNS_DISCRETE)
            columns |= criterion->node[child].columns;
    return columns;
}

static const rmap_column_set direction = RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction);

/* Without a branch: which rays are open is random. */
static inline uint8_t taken(uint8_t was, uint8_t open)
{
    const uint8_t mask = (uint8_t)(0u - (was == RMAP_OUTCOME_OPEN));
    return (uint8_t)((open & mask) | (was & ~mask));
}

/* What was found of n rays takes the place of OPEN. row: which they are; NULL: all. */
RMAP_WIDE static void take_open(const uint8_t *restrict open, const uint32_t *row, size_t n,
                                uint8_t *restrict outcome)
{
    if (!row) {
        for (size_t s = 0; s < n; s++)
            outcome[s] = taken(outcome[s], open[s]);
        return;
    }
    for (size_t s = 0; s < n; s++)
        outcome[row[s]] = taken(outcome[row[s]], open[s]);
}

/* Decides rays that are open by these columns, which some may stay open by: those rays alone are
 * decoded, where they are few. */
static enum rmap_status decide_open(struct rmap_query_outcomes *self, size_t c,
                                    rmap_column_set columns, uint8_t *outcome,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *few = NULL;
    const uint32_t *row = NULL;
    if (!memchr(outcome, RMAP_OUTCOME_OPEN, self->n_ray))
        return RMAP_OK;
    RMAP_TRY(
        rmap_cursor_select(self->cursor, outcome, RMAP_OUTCOME_OPEN, columns, &few, &row, err));
    if (!few)
        RMAP_TRY(query_outcomes_fetch(self, columns, err));
    const struct rmap_criterion_input input = {.portion = few ? few : self->portion,
                                               .columns = columns,
                                               .is_rest = true,
                                               .counts_exactly = (self->more & direction) != 0,
                                               .flux_per_weight =
                                                   rmap_map_flux_per_weight(self->map)};
    RMAP_TRY(rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, self->open, err));
    take_open(self->open, few ? row : NULL, input.portion->n_row[RMAP_TABLE_RAY], outcome);
out:
    return st;
}

/* Rays that their paths leave open: by what stands as it is. *left_ret: columns that decide those
 * which still are; 0: none can be. */
static enum rmap_status decide_standing(struct rmap_query_outcomes *self, size_t c,
                                        uint8_t *outcome, rmap_column_set *left_ret,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set columns = rest_columns(self->criterion[c]);
    rmap_column_set traced, more = 0;
    RMAP_TRY(rmap_cursor_traced(self->cursor, &traced, err));
    const rmap_column_set told = rmap_cursor_tells_of(self->cursor, columns & traced);
    const rmap_column_set standing = (columns & ~traced) | told;
    if (self->more && !((columns | self->more) & traced & ~(told ? direction : 0)))
        more = (self->more & ~traced) | sum_columns; /* whoever asks for them finds them selected */
    *left_ret = columns & traced ? columns | more : 0;
    if (*left_ret == 0 || (standing & ~RMAP_COLUMNS_DISCRETE))
        st = decide_open(self, c, standing | more, outcome, err);
out:
    return st;
}

/* Then by tracing those still open. */
static enum rmap_status evaluate_open(struct rmap_query_outcomes *self, size_t c, uint8_t *outcome,
                                      struct rmap_error *err)
{
    rmap_column_set left;
    const enum rmap_status st = decide_standing(self, c, outcome, &left, err);
    return st == RMAP_OK && left ? decide_open(self, c, left, outcome, err) : st;
}

/* Outcomes per ray, whatever they come from: NO or YES. */
static enum rmap_status evaluate_rays(struct rmap_query_outcomes *self, size_t c, uint8_t *outcome,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->is_by_paths = false;
    if (self->known_paths)
        RMAP_TRY(rmap_query_known_evaluate(self->known_paths, c, outcome, &self->is_by_paths, err));
    if (self->is_by_paths)
        RMAP_TRY(evaluate_open(self, c, outcome, err));
    else
        st = evaluate_columns(self, c, outcome, err);
out:
    return st;
}

enum rmap_status rmap_query_outcomes_add(struct rmap_query_outcomes *self, size_t c,
                                         struct rmap_count *count, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *outcome = self->marked;
    bool is_counted = false;
    if (self->known_paths)
        RMAP_TRY(rmap_query_known_add(self->known_paths, c, &is_counted, err));
    if (is_counted)
        return RMAP_OK;
    RMAP_TRY(evaluate_rays(self, c, outcome, err));
    if (!memchr(outcome, RMAP_OUTCOME_YES, self->n_ray))
        return RMAP_OK;
    if (self->is_by_paths)
        return rmap_query_known_count(self->known_paths, c, outcome, err);
    RMAP_TRY(query_outcomes_fetch(self, sum_columns, err));
    if (!self->is_looked_at)
        RMAP_TRY(rmap_sums_look(self->portion, self->n_source, &self->facts, err));
    self->is_looked_at = true;
    rmap_sums_add_rays(count, self->portion, outcome, &self->facts);
out:
    return st;
}

enum rmap_status rmap_query_outcomes_add_own(struct rmap_query_outcomes *self, size_t c,
                                             struct rmap_error *err)
{
    return rmap_query_known_add_own(self->known_paths, c, err);
}

void rmap_query_outcomes_settle(struct rmap_query_outcomes *self, struct rmap_count *count)
{
    if (self->known_paths)
        rmap_query_known_settle(self->known_paths, count);
}

enum rmap_status rmap_query_outcomes_mark(struct rmap_query_outcomes *self, size_t c,
                                          uint8_t *match, struct rmap_error *err)
{
    const enum rmap_status st = evaluate_rays(self, c, match, err);
    const size_t n = st == RMAP_OK ? self->n_ray : 0;
    for (size_t i = 0; i < n; i++)
        match[i] &= 1;
    return st;
}

enum rmap_status rmap_query_outcomes_foresee(struct rmap_query_outcomes *self, size_t c,
                                             struct rmap_query_outlook *outlook, bool *told_ret,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *outcome = self->marked;
    rmap_column_set left;
    *told_ret = false;
    *outlook = (struct rmap_query_outlook){self->n_ray, self->n_ray, self->n_ray, self->n_ray};
    if (!self->known_paths)
        goto out;
    RMAP_TRY(rmap_query_known_evaluate(self->known_paths, c, outcome, told_ret, err));
    if (!*told_ret)
        goto out;
    outlook->n_open = rmap_count_equal(outcome, self->n_ray, RMAP_OUTCOME_OPEN);
    RMAP_TRY(decide_standing(self, c, outcome, &left, err));
    outlook->n_left = rmap_count_equal(outcome, self->n_ray, RMAP_OUTCOME_OPEN);
    outlook->n_possible = self->n_ray - rmap_count_equal(outcome, self->n_ray, RMAP_OUTCOME_NO);
out:
    return st;
}

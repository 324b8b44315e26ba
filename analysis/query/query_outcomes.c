/* SPDX-License-Identifier: MIT
 *
 * What several criteria say of the rays of a portion, from the history index where there is one,
 * and of the rays that it leaves undecided, or without one, from columns.
 */
#include <string.h>

#include "analysis/query/query_known.h"
#include "analysis/query/query_outcomes.h"
#include "analysis/query/query_sums.h"
#include "analysis/query/query_undecided.h"
#include "base/alloc.h"
#include "io/map/map_cursor.h"

struct rmap_query_outcomes {
    const struct rmap_map *map;
    const struct rmap_criterion *const *criterion;
    size_t n_criterion, n_source;
    struct rmap_evaluator evaluator;
    struct rmap_cursor *cursor; /* columns of the criteria and the sums */
    struct rmap_query_history *history;
    struct rmap_query_known *known_paths; /* or NULL */
    struct rmap_undecided undecided;

    size_t index;                         /* portion in hand */
    const struct rmap_history_view *view; /* NULL: its columns are to be read */
    size_t n_ray;
    bool is_entered;                    /* by the cursor */
    const struct rmap_portion *portion; /* the cursor's */
    bool is_by_paths;  /* what was evaluated last, but for the rays that they leave open */
    bool is_looked_at; /* for what the sums need to know: */
    struct rmap_sums_facts facts;
    rmap_column_set known;      /* columns unfolded from its history */
    struct rmap_portion joined; /* these, and those of the cursor */
    bool *is_open;              /* [n_criterion] its history leaves rays undecided */
    uint8_t *outcome;           /* [n_criterion][n_ray] of its history */
    uint8_t *own, *marked;      /* [n_ray] of undecided rays; of all rays */
    uint32_t *path_rays;        /* [n_path] that match */
    size_t outcome_cap, path_cap;
};

/* Columns of the portion in hand. */

uint64_t rmap_query_outcomes_nbytes(const struct rmap_query_outcomes *self)
{
    return rmap_query_history_nbytes(self->history) + rmap_cursor_nbytes_of_rows(self->cursor);
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

/* Columns of the portion in hand, of those of the criteria and of `more`. Borrowed until the next
 * enter. */
static enum rmap_status query_outcomes_read(struct rmap_query_outcomes *self,
                                            rmap_column_set columns,
                                            const struct rmap_portion **portion_ret,
                                            struct rmap_error *err)
{
    enum rmap_status st = query_outcomes_enter_columns(self, err);
    *portion_ret = self->portion;
    return st == RMAP_OK ? query_outcomes_fetch(self, columns, err) : st;
}

enum rmap_status rmap_query_outcomes_know(struct rmap_query_outcomes *self, rmap_column_set columns,
                                          const struct rmap_portion **portion_ret,
                                          struct rmap_error *err)
{
    const rmap_column_set discrete = self->view ? columns & RMAP_COLUMNS_DISCRETE : 0;
    const struct rmap_portion *known = NULL;
    enum rmap_status st = query_outcomes_read(self, columns & ~discrete, portion_ret, err);
    if (st != RMAP_OK || !self->view)
        return st;
    st = rmap_query_history_unfold(self->history, discrete, &known, err);
    if (st != RMAP_OK)
        return st;
    self->known |= discrete;
    self->joined = *self->portion;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (self->known & RMAP_COLUMN_BIT(c))
            *rmap_portion_column_address(&self->joined, (enum rmap_column)c) =
                rmap_portion_column(known, (enum rmap_column)c);
    *portion_ret = &self->joined;
    return RMAP_OK;
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

const struct rmap_history_view *rmap_query_outcomes_view(const struct rmap_query_outcomes *self)
{
    return self->view;
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
    self->is_open = rmap_alloc(n_criterion, sizeof *self->is_open);
    if (!self->is_open)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", n_criterion));
    RMAP_TRY(rmap_query_history_create(map, criterion, n_criterion, &self->history, err));
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
    rmap_undecided_fini(&self->undecided);
    rmap_query_history_destroy(self->history);
    rmap_query_known_destroy(self->known_paths);
    rmap_cursor_destroy(self->cursor);
    rmap_evaluator_fini(&self->evaluator);
    rmap_free(self->outcome);
    rmap_free(self->path_rays);
    rmap_free(self->is_open);
    rmap_free(self);
}

/* Rows that the history decides: paths, or rays. */
static size_t n_decided(const struct rmap_query_outcomes *self)
{
    return self->view->form == RMAP_HISTORY_PATHS ? self->view->n_path : self->n_ray;
}

/* Row of the outcomes by history that a ray has. */
static size_t row_of(const struct rmap_query_outcomes *self, size_t ray)
{
    return self->view->form == RMAP_HISTORY_PATHS ? self->view->path[ray] : ray;
}

static uint8_t *outcome_of(const struct rmap_query_outcomes *self, size_t c)
{
    return self->outcome + c * self->n_ray;
}

static enum rmap_status make_room(struct rmap_query_outcomes *self, struct rmap_error *err)
{
    void *block = self->outcome;
    enum rmap_status st =
        rmap_reserve(&block, &self->outcome_cap, (self->n_criterion + 2) * self->n_ray, 1, err);
    self->outcome = block;
    if (st != RMAP_OK)
        return st;
    self->own = outcome_of(self, self->n_criterion);
    self->marked = self->own + self->n_ray;
    block = self->path_rays;
    st = rmap_reserve(&block, &self->path_cap, self->n_ray, sizeof *self->path_rays, err);
    self->path_rays = block;
    return st;
}

/* Outcomes of the wanted criteria from history alone. */
static enum rmap_status evaluate_history(struct rmap_query_outcomes *self, const bool *wanted,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t c = 0; c < self->n_criterion; c++) {
        if (!wanted[c])
            continue;
        RMAP_TRY(rmap_query_history_evaluate(self->history, c, outcome_of(self, c), err));
        self->is_open[c] = memchr(outcome_of(self, c), RMAP_OUTCOME_OPEN, n_decided(self)) != NULL;
    }
out:
    return st;
}

enum rmap_status rmap_query_outcomes_enter(struct rmap_query_outcomes *self, size_t portion,
                                           const bool *wanted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->index = portion;
    self->is_entered = self->is_looked_at = self->is_by_paths = false;
    self->known = 0;
    self->n_ray = (size_t)rmap_map_portion(self->map, portion)->n_row[RMAP_TABLE_RAY];
    RMAP_TRY(rmap_query_history_enter(self->history, portion, &self->view, err));
    if (!self->view) /* the piece's chunks vouch for the number of rays */
        RMAP_TRY(query_outcomes_enter_columns(self, err));
    RMAP_TRY(make_room(self, err));
    if (self->view)
        RMAP_TRY(evaluate_history(self, wanted, err));
    else if (!self->view && self->known_paths)
        rmap_query_known_enter(self->known_paths, self->cursor, portion);
out:
    return st;
}

/* NO where history had decided. */
static void keep_open(const struct rmap_query_outcomes *self, size_t c, uint8_t *restrict outcome)
{
    const uint8_t *restrict before = outcome_of(self, c);
    const uint16_t *path = self->view->path;
    size_t n = self->n_ray;
    if (self->view->form == RMAP_HISTORY_PATHS)
        for (size_t i = 0; i < n; i++)
            outcome[i] &= (uint8_t)(0 - (before[path[i]] == RMAP_OUTCOME_OPEN));
    else
        for (size_t i = 0; i < n; i++)
            outcome[i] &= (uint8_t)(0 - (before[i] == RMAP_OUTCOME_OPEN));
}

/* Outcomes of criterion c on the rays that its history leaves undecided. */
static enum rmap_status evaluate_undecided(struct rmap_query_outcomes *self, size_t c,
                                           uint8_t *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_undecided *undecided = &self->undecided;
    const struct rmap_criterion_input input = {.portion = &undecided->rows,
                                               .columns = RMAP_COLUMNS_ALL,
                                               .is_rest = true,
                                               .flux_per_weight =
                                                   rmap_map_flux_per_weight(self->map),
                                               .context = undecided,
                                               .fetch = rmap_undecided_fetch};
    RMAP_TRY(query_outcomes_enter_columns(self, err));
    undecided->cursor = self->cursor;
    undecided->measured = self->portion;
    RMAP_TRY(rmap_undecided_enter(undecided, outcome_of(self, c), self->view, self->history, err));
    RMAP_TRY(rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, outcome, err));
    if (undecided->is_whole)
        keep_open(self, c, outcome);
out:
    return st;
}

/* Outcomes per ray with those of the undecided rays: open or NO | YES is YES. */
static void join_undecided(const struct rmap_query_outcomes *self, uint8_t *restrict outcome)
{
    const struct rmap_undecided *undecided = &self->undecided;
    const uint8_t *restrict own = self->own;
    if (undecided->is_whole)
        for (size_t i = 0; i < undecided->n; i++)
            outcome[i] |= own[i];
    else
        for (size_t s = 0; s < undecided->n; s++)
            outcome[undecided->ray[s]] |= own[s];
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

/* Decides rays that are open by these columns, which some may stay open by: those rays alone are
 * decoded, where they are few. */
static enum rmap_status decide_open(struct rmap_query_outcomes *self, size_t c,
                                    rmap_column_set columns, uint8_t *outcome,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *few = NULL;
    if (!memchr(outcome, RMAP_OUTCOME_OPEN, self->n_ray))
        return RMAP_OK;
    RMAP_TRY(rmap_cursor_select(self->cursor, outcome, RMAP_OUTCOME_OPEN, columns, &few, err));
    if (!few)
        RMAP_TRY(query_outcomes_fetch(self, columns, err));
    const struct rmap_criterion_input input = {.portion = few ? few : self->portion,
                                               .columns = columns,
                                               .is_rest = true,
                                               .flux_per_weight =
                                                   rmap_map_flux_per_weight(self->map)};
    RMAP_TRY(rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, self->own, err));
    for (size_t i = 0, s = 0; i < self->n_ray; i++)
        if (outcome[i] == RMAP_OUTCOME_OPEN)
            outcome[i] = self->own[few ? s++ : i];
out:
    return st;
}

/* Rays that their paths leave open: by what stands as it is, then by tracing those still open. */
static enum rmap_status evaluate_open(struct rmap_query_outcomes *self, size_t c, uint8_t *outcome,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set columns = rmap_criterion_columns(self->criterion[c]);
    rmap_column_set traced;
    RMAP_TRY(rmap_cursor_traced(self->cursor, &traced, err));
    if ((columns & traced) && (columns & ~traced & ~RMAP_COLUMNS_DISCRETE))
        RMAP_TRY(decide_open(self, c, columns & ~traced, outcome, err));
    st = decide_open(self, c, columns, outcome, err);
out:
    return st;
}

/* Outcomes per ray, whatever they come from: NO or YES. */
static enum rmap_status evaluate_rays(struct rmap_query_outcomes *self, size_t c, uint8_t *outcome,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    self->is_by_paths = false;
    if (!self->view && self->known_paths)
        RMAP_TRY(rmap_query_known_evaluate(self->known_paths, c, outcome, &self->is_by_paths, err));
    if (self->is_by_paths)
        RMAP_TRY(evaluate_open(self, c, outcome, err));
    if (self->is_by_paths)
        goto out;
    if (!self->view)
        return evaluate_columns(self, c, outcome, err);
    for (size_t i = 0; i < self->n_ray; i++)
        outcome[i] = outcome_of(self, c)[row_of(self, i)] == RMAP_OUTCOME_YES ? RMAP_OUTCOME_YES
                                                                              : RMAP_OUTCOME_NO;
    if (!self->is_open[c])
        return RMAP_OK;
    RMAP_TRY(evaluate_undecided(self, c, self->own, err));
    join_undecided(self, outcome);
out:
    return st;
}

/* By columns: a portion without history, or with weights of its own. */
static enum rmap_status add_rays(struct rmap_query_outcomes *self, size_t c,
                                 struct rmap_count *count, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *outcome = self->marked;
    bool is_counted = false;
    if (!self->view && self->known_paths)
        RMAP_TRY(rmap_query_known_add(self->known_paths, c, &is_counted, err));
    if (is_counted)
        return RMAP_OK;
    RMAP_TRY(evaluate_rays(self, c, outcome, err));
    if (!memchr(outcome, RMAP_OUTCOME_YES, self->n_ray))
        return RMAP_OK;
    if (self->is_by_paths)
        return rmap_query_known_count(self->known_paths, outcome, count, err);
    RMAP_TRY(query_outcomes_enter_columns(self, err));
    RMAP_TRY(query_outcomes_fetch(self, sum_columns, err));
    if (!self->is_looked_at)
        RMAP_TRY(rmap_sums_look(self->portion, self->n_source, &self->facts, err));
    self->is_looked_at = true;
    rmap_sums_add_rays(count, self->portion, outcome, &self->facts);
out:
    return st;
}

static enum rmap_status add_paths(struct rmap_query_outcomes *self, size_t c,
                                  struct rmap_count *count, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_history_view *view = self->view;
    const uint8_t *outcome = outcome_of(self, c);
    uint32_t *rays = self->path_rays;
    for (size_t k = 0; k < view->n_path; k++)
        rays[k] = outcome[k] == RMAP_OUTCOME_YES ? view->path_rays[k] : 0;
    if (self->is_open[c])
        RMAP_TRY(evaluate_undecided(self, c, self->own, err));
    for (size_t s = 0; self->is_open[c] && s < self->undecided.n; s++)
        rays[view->path[self->undecided.is_whole ? s : self->undecided.ray[s]]] +=
            self->own[s] >> 1;
    rmap_sums_add_paths(count, view, &rmap_history_paths(view->index)->ray, rays);
out:
    return st;
}

static enum rmap_status add_rows(struct rmap_query_outcomes *self, size_t c,
                                 struct rmap_count *count, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *outcome = outcome_of(self, c);
    if (self->is_open[c])
        RMAP_TRY(evaluate_undecided(self, c, self->own, err));
    if (self->is_open[c])
        join_undecided(self, outcome);
    self->is_open[c] = false;
    rmap_sums_add_rows(count, self->view, outcome);
out:
    return st;
}

enum rmap_status rmap_query_outcomes_add(struct rmap_query_outcomes *self, size_t c,
                                         struct rmap_count *count, struct rmap_error *err)
{
    const struct rmap_history_view *view = self->view;
    if (!view || !view->unit_weight)
        return add_rays(self, c, count, err);
    return view->form == RMAP_HISTORY_PATHS ? add_paths(self, c, count, err)
                                            : add_rows(self, c, count, err);
}

enum rmap_status rmap_query_outcomes_add_own(struct rmap_query_outcomes *self, size_t c,
                                             struct rmap_error *err)
{
    enum rmap_status st = query_outcomes_enter_columns(self, err);
    if (st != RMAP_OK)
        return st;
    if (self->view)
        rmap_query_known_enter(self->known_paths, self->cursor, self->index);
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
    enum rmap_status st = evaluate_rays(self, c, match, err);
    for (size_t i = 0; st == RMAP_OK && i < self->n_ray; i++)
        match[i] &= 1;
    return st;
}

void rmap_query_outcomes_foresee(const struct rmap_query_outcomes *self, size_t c,
                                 struct rmap_query_outlook *outlook)
{
    const uint8_t *outcome = outcome_of(self, c);
    *outlook = (struct rmap_query_outlook){self->view, self->n_ray, self->n_ray, self->n_ray};
    if (!self->view)
        return;
    outlook->n_open = outlook->n_possible = 0;
    for (size_t i = 0; i < n_decided(self); i++) {
        uint64_t rays = self->view->form == RMAP_HISTORY_PATHS ? self->view->path_rays[i] : 1;
        outlook->n_open += outcome[i] == RMAP_OUTCOME_OPEN ? rays : 0;
        outlook->n_possible += outcome[i] != RMAP_OUTCOME_NO ? rays : 0;
    }
}

enum rmap_status rmap_query_outcomes_foresee_paths(struct rmap_query_outcomes *self, size_t c,
                                                   struct rmap_query_outlook *outlook,
                                                   bool *told_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint8_t *outcome = self->marked;
    *told_ret = false;
    if (self->view || !self->known_paths)
        goto out;
    RMAP_TRY(rmap_query_known_evaluate(self->known_paths, c, self->marked, told_ret, err));
    if (!*told_ret)
        goto out;
    outlook->n_open = outlook->n_possible = 0;
    for (size_t i = 0; i < self->n_ray; i++) {
        outlook->n_open += outcome[i] == RMAP_OUTCOME_OPEN;
        outlook->n_possible += outcome[i] != RMAP_OUTCOME_NO;
    }
out:
    return st;
}

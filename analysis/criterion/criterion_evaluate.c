/* SPDX-License-Identifier: MIT
 *
 * Evaluation: every test becomes a byte per ray; and, or, not combine bytes. A test whose columns
 * may not all be fetched counts the rows that could count: more it cannot be.
 */
#include "analysis/criterion/criterion_evaluate.h"

#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_compare.h"
#include "analysis/criterion/criterion_sum.h"
#include "analysis/criterion/criterion_tests.h"
#include "analysis/criterion/path_in.h"
#include "analysis/criterion/registration_response.h"
#include "analysis/criterion/step_number.h"
#include "base/alloc.h"
#include "base/count.h"
#include "base/wide.h"
#include "compact/path_sum.h"

static void compare_ray_numbers(const struct rmap_evaluation *ev,
                                const struct rmap_criterion_node *node, uint8_t *outcome)
{
    const struct rmap_ray_columns *ray = &ev->portion->ray;
    const double *stored = rmap_ray_number_stored(node->ray_number, ray);
    const bool is_flux = node->ray_number == RMAP_RAY_NUMBER_FLUX;
    size_t n_source = ev->criterion->scene->n_source;
    if (stored) {
        rmap_compare_numbers(stored, ev->n_ray, &node->interval, outcome);
        return;
    }
    if (node->ray_number == RMAP_RAY_NUMBER_EVENT) {
        for (size_t i = 0; i < ev->n_ray; i++) {
            uint64_t event = 0;
            const bool has = rmap_scene_event(ev->criterion->scene, ray->id[i], &event);
            const bool inside = (event >= node->id_low) & (event <= node->id_high);
            outcome[i] =
                has && inside != node->interval.outside ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
        }
        return;
    }
    if (node->ray_number == RMAP_RAY_NUMBER_ID) {
        for (size_t i = 0; i < ev->n_ray; i++) {
            bool inside = (ray->id[i] >= node->id_low) & (ray->id[i] <= node->id_high);
            outcome[i] = inside != node->interval.outside ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
        }
        return;
    }
    for (size_t i = 0; i < ev->n_ray; i++) {
        const double number = is_flux && (size_t)ray->source[i] >= n_source
                                  ? (double)NAN
                                  : rmap_ray_number_at(node->ray_number, ev->criterion->scene, ray,
                                                       i, ev->input->flux_per_weight);
        outcome[i] =
            rmap_interval_holds(&node->interval, number) ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
    }
}

static void mark_rays(const struct rmap_evaluation *ev, const struct rmap_criterion_node *node,
                      uint8_t *outcome)
{
    rmap_id_set_mark(node->rays, ev->portion->ray.id, ev->n_ray, outcome);
    for (size_t i = 0; i < ev->n_ray; i++)
        outcome[i] = outcome[i] ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
}

static enum rmap_status compare_sums(const struct rmap_evaluation *ev,
                                     const struct rmap_criterion_node *node, uint8_t *outcome,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint32_t *n_row = NULL;
    RMAP_TRY(rmap_evaluation_fetch(ev, node->columns, err));
    if (node->columns & RMAP_COLUMN_BIT(RMAP_RAY_registration_count))
        RMAP_TRY(rmap_test_count_rows(ev, RMAP_TABLE_REGISTRATION, &n_row, err));
    for (size_t i = 0, first = 0; i < ev->n_ray; i++) {
        const size_t n = n_row ? n_row[i] : 0;
        outcome[i] = rmap_sum_holds_for_ray(ev->criterion, node, ev->portion,
                                            ev->input->flux_per_weight, i, first, n)
                         ? RMAP_OUTCOME_YES
                         : RMAP_OUTCOME_NO;
        first += n;
    }
out:
    return st;
}

/* exactly: else of rays that were in none of the media only. */
static enum rmap_status compare_paths_in(const struct rmap_evaluation *ev,
                                         const struct rmap_criterion_node *node, bool exactly,
                                         uint8_t *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = ev->portion;
    const uint32_t *n_segment;
    RMAP_TRY(
        rmap_evaluation_fetch(ev, exactly ? RMAP_PATH_IN_COLUMNS : RMAP_PATH_IN_DISCRETE, err));
    RMAP_TRY(rmap_test_count_rows(ev, RMAP_TABLE_SEGMENT, &n_segment, err));
    for (size_t i = 0, first = 0; i < ev->n_ray; first += n_segment[i++]) {
        double length = 0.0;
        outcome[i] = RMAP_OUTCOME_OPEN;
        if (rmap_path_is_in(&node->media, portion, first, n_segment[i])) {
            if (!exactly)
                continue;
            length = rmap_path_length_in(&node->media, portion, i, first);
        }
        outcome[i] =
            rmap_interval_holds(&node->interval, length) ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO;
    }
out:
    return st;
}

/* What a test counts, of what is asked for: just that, or at most, or at most and at least. */
enum certainty { EXACTLY, AT_MOST, BETWEEN };

/* Outcomes by what a test counts. index: of the node, which may stand looser here. */
static enum rmap_status compare_rows(const struct rmap_evaluation *ev, int32_t index,
                                     const struct rmap_criterion_node *node,
                                     enum certainty certainty, uint8_t *outcome,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_marks marks;
    struct rmap_evaluator *memory = ev->evaluator;
    const uint32_t *least = certainty == EXACTLY ? ev->count : NULL;
    RMAP_TRY(rmap_test_mark(ev, index, node, certainty == BETWEEN, &marks, err));
    rmap_test_count(marks.bits, marks.n_rows, ev->n_ray, ev->count);
    if (certainty == BETWEEN) {
        RMAP_TRY(RMAP_RESERVE(memory->least, memory->least_cap, ev->n_ray, err));
        rmap_test_count(marks.sure, marks.n_rows, ev->n_ray, memory->least);
        least = memory->least;
    }
    rmap_compare_counts(least, ev->count, ev->n_ray, &node->interval, outcome);
    for (size_t i = 0; certainty == BETWEEN && ev->input->counts_exactly && i < ev->n_ray; i++)
        outcome[i] = least[i] < ev->count[i] ? RMAP_OUTCOME_OPEN : outcome[i];
out:
    return st;
}

/* A test of registrations without what needs columns that may not be fetched. What it counts then
 * may count, or, where places are known and something of `where`, some of it does. */
static enum certainty loosen_registrations(const struct rmap_evaluation *ev,
                                           struct rmap_registration_test *test)
{
    enum certainty certainty = test->where < 0 ? AT_MOST : BETWEEN;
    const rmap_column_set place = test->region == RMAP_REGION_CELLS
                                      ? RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell)
                                      : RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative);
    if (place & ~ev->input->columns) {
        test->region = RMAP_REGION_ALL;
        test->box = NULL;
        certainty = AT_MOST;
    }
    if (test->where >= 0 &&
        !rmap_where_tells(ev->criterion, test->where, ev->portion, ev->input->columns)) {
        test->where = -1;
        certainty = AT_MOST;
    }
    return certainty;
}

/* Rays of which only the least and greatest number is known, or a sum of such. */
static void bound_numbers(const struct rmap_evaluation *ev, const struct rmap_criterion_node *node,
                          uint8_t *outcome)
{
    const bool is_sum = node->kind == RMAP_CRITERION_SUM;
    for (size_t i = 0; i < ev->n_ray; i++) {
        double bound[2];
        if (is_sum)
            rmap_sum_bound(&node->sum, &ev->input->bounds[i], bound);
        else
            rmap_number_bound(node->ray_number, &ev->input->bounds[i], bound);
        outcome[i] = rmap_bounds_outcome(&node->interval, bound[0], bound[1]);
    }
}

static bool has_bounds(const struct rmap_evaluation *ev, const struct rmap_criterion_node *node)
{
    if (!ev->input->bounds)
        return false;
    return node->kind == RMAP_CRITERION_SUM
               ? rmap_sum_is_bounded(&node->sum)
               : node->kind == RMAP_CRITERION_NUMBER && rmap_number_is_bounded(node->ray_number);
}

/* A test that asks for columns which may not be fetched: without what needs them. */
static enum rmap_status bound_test(const struct rmap_evaluation *ev, int32_t index,
                                   uint8_t *outcome, struct rmap_error *err)
{
    struct rmap_criterion_node loose = ev->criterion->node[index];
    enum certainty certainty = AT_MOST;
    loose.columns &= ev->input->columns;
    if (loose.kind == RMAP_CRITERION_STEPS) {
        loose.steps.part = RMAP_PART_ALL;
        loose.steps.side = NULL;
        loose.steps.n_limit =
            rmap_step_limits_known(loose.steps.limit, loose.steps.n_limit, loose.columns);
    } else if (loose.kind == RMAP_CRITERION_REGISTRATIONS) {
        certainty = loosen_registrations(ev, &loose.registrations);
    } else if (loose.kind == RMAP_CRITERION_PATH_IN &&
               (loose.columns & RMAP_PATH_IN_DISCRETE) == RMAP_PATH_IN_DISCRETE) {
        return compare_paths_in(ev, &loose, false, outcome, err);
    } else if (has_bounds(ev, &loose)) {
        bound_numbers(ev, &loose, outcome);
        return RMAP_OK;
    } else {
        memset(outcome, RMAP_OUTCOME_OPEN, ev->n_ray);
        return RMAP_OK;
    }
    return compare_rows(ev, index, &loose, certainty, outcome, err);
}

static enum rmap_status evaluate_test(const struct rmap_evaluation *ev, int32_t index,
                                      uint8_t *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_criterion_node *node = &ev->criterion->node[index];
    if (node->columns & ~ev->input->columns)
        return bound_test(ev, index, outcome, err);
    if (node->kind == RMAP_CRITERION_ALL) {
        bool holds = rmap_interval_holds(&node->interval, 1.0);
        memset(outcome, holds ? RMAP_OUTCOME_YES : RMAP_OUTCOME_NO, ev->n_ray);
    } else if (node->kind == RMAP_CRITERION_NUMBER) {
        RMAP_TRY(rmap_evaluation_fetch(ev, node->columns, err));
        compare_ray_numbers(ev, node, outcome);
    } else if (node->kind == RMAP_CRITERION_RAYS) {
        RMAP_TRY(rmap_evaluation_fetch(ev, node->columns, err));
        mark_rays(ev, node, outcome);
    } else if (node->kind == RMAP_CRITERION_SUM) {
        st = compare_sums(ev, node, outcome, err);
    } else if (node->kind == RMAP_CRITERION_PATH_IN) {
        st = compare_paths_in(ev, node, true, outcome, err);
    } else {
        st = compare_rows(ev, index, node, EXACTLY, outcome, err);
    }
out:
    return st;
}

/* True when every ray has this outcome, which further children cannot change. */
RMAP_WIDE static bool all_are(const uint8_t *outcome, uint8_t which, size_t n)
{
    uint8_t other = 0;
    for (size_t i = 0; i < n; i++)
        other |= outcome[i] ^ which;
    return !other;
}

static enum rmap_status evaluate_node(const struct rmap_evaluation *ev, int32_t index, int level,
                                      bool is_rest, uint8_t *outcome, struct rmap_error *err);

RMAP_WIDE static void combine(const uint8_t *restrict own, size_t n, bool is_and,
                              uint8_t *restrict outcome)
{
    if (is_and)
        for (size_t i = 0; i < n; i++)
            outcome[i] &= own[i];
    else
        for (size_t i = 0; i < n; i++)
            outcome[i] |= own[i];
}

/* level: masks that are in use above. is_rest: as in the input, and this node is its `and` or
 * `or`. */
static enum rmap_status evaluate_logic(const struct rmap_evaluation *ev,
                                       const struct rmap_criterion_node *node, int level,
                                       bool is_rest, uint8_t *outcome, struct rmap_error *err)
{
    size_t n = ev->n_ray;
    bool is_and = node->kind == RMAP_CRITERION_AND;
    const uint8_t last_word = is_and ? RMAP_OUTCOME_NO : RMAP_OUTCOME_YES;
    uint8_t *own = ev->evaluator->mask + (size_t)level * n;
    enum rmap_status st = RMAP_OK;
    memset(outcome, last_word ^ RMAP_OUTCOME_YES, n);
    for (int32_t child = node->first;
         st == RMAP_OK && child >= 0 && !all_are(outcome, last_word, n);
         child = ev->criterion->node[child].next) {
        if (is_rest && !(ev->criterion->node[child].columns & ~RMAP_COLUMNS_DISCRETE))
            continue;
        st = evaluate_node(ev, child, level + 1, false, own, err);
        combine(own, n, is_and, outcome);
    }
    return st;
}

RMAP_WIDE static void negate(uint8_t *outcome, size_t n)
{
    for (size_t i = 0; i < n; i++)
        outcome[i] = rmap_outcome_not(outcome[i]);
}

static enum rmap_status evaluate_node(const struct rmap_evaluation *ev, int32_t index, int level,
                                      bool is_rest, uint8_t *outcome, struct rmap_error *err)
{
    const struct rmap_criterion_node *node = &ev->criterion->node[index];
    if (node->kind == RMAP_CRITERION_AND || node->kind == RMAP_CRITERION_OR)
        return evaluate_logic(ev, node, level, is_rest, outcome, err);
    if (node->kind != RMAP_CRITERION_NOT)
        return evaluate_test(ev, index, outcome, err);
    enum rmap_status st = evaluate_node(ev, node->first, level, is_rest, outcome, err);
    if (st == RMAP_OK)
        negate(outcome, ev->n_ray);
    return st;
}

void rmap_evaluator_fini(struct rmap_evaluator *evaluator)
{
    rmap_free(evaluator->count);
    rmap_free(evaluator->mask);
    rmap_free(evaluator->least);
    rmap_free(evaluator->mark);
    rmap_free(evaluator->sure);
    rmap_free(evaluator->last);
    *evaluator = (struct rmap_evaluator){0};
}

enum rmap_status rmap_criterion_decide(const struct rmap_criterion *criterion,
                                       const struct rmap_criterion_input *input,
                                       struct rmap_evaluator *evaluator, uint8_t *outcome,
                                       struct rmap_error *err)
{
    size_t n_ray = input->portion->n_row[RMAP_TABLE_RAY];
    if (n_ray == 0)
        return RMAP_OK;
    enum rmap_status st = RMAP_RESERVE(evaluator->count, evaluator->count_cap, n_ray, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(evaluator->mask, evaluator->mask_cap, n_ray * (size_t)criterion->n_mask,
                          err);
    if (st != RMAP_OK)
        return st;
    struct rmap_evaluation ev = {.criterion = criterion,
                                 .input = input,
                                 .portion = input->portion,
                                 .evaluator = evaluator,
                                 .n_ray = n_ray,
                                 .count = evaluator->count};
    return evaluate_node(&ev, criterion->root, 0, input->is_rest, outcome, err);
}

static enum rmap_status check_portion(const struct rmap_criterion *criterion,
                                      const struct rmap_portion *portion, struct rmap_error *err)
{
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const struct rmap_column_info *info = rmap_column_info((enum rmap_column)c);
        if (criterion->columns & RMAP_COLUMN_BIT(c) && portion->n_row[info->table] > 0 &&
            !rmap_portion_column(portion, (enum rmap_column)c))
            return rmap_error_set(err, RMAP_INTERNAL, "column %s was not read", info->path);
    }
    if ((portion->ray.segment_count &&
         !rmap_sums_to(portion->ray.segment_count, n_ray, portion->n_row[RMAP_TABLE_SEGMENT])) ||
        (portion->ray.registration_count && !rmap_sums_to(portion->ray.registration_count, n_ray,
                                                          portion->n_row[RMAP_TABLE_REGISTRATION])))
        return rmap_error_set(err, RMAP_FORMAT,
                              "the rays from id %llu on do not add up to the rows of their tables",
                              (unsigned long long)portion->first_ray);
    return RMAP_OK;
}

enum rmap_status rmap_criterion_evaluate(const struct rmap_criterion *criterion,
                                         const struct rmap_portion *portion,
                                         const double *flux_per_weight, uint8_t *match,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_evaluator evaluator = {0};
    const struct rmap_criterion_input input = {
        .portion = portion, .columns = RMAP_COLUMNS_ALL, .flux_per_weight = flux_per_weight};
    RMAP_TRY(check_portion(criterion, portion, err));
    RMAP_TRY(rmap_criterion_decide(criterion, &input, &evaluator, match, err));
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++)
        match[i] &= 1;
out:
    rmap_evaluator_fini(&evaluator);
    return st;
}

enum rmap_status rmap_criterion_count(const struct rmap_criterion *criterion,
                                      const struct rmap_portion *portion, uint32_t *count,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_evaluator evaluator = {0};
    struct rmap_marks marks;
    const struct rmap_criterion_node *node = &criterion->node[criterion->root];
    const struct rmap_criterion_input input = {.portion = portion, .columns = RMAP_COLUMNS_ALL};
    struct rmap_evaluation ev = {.criterion = criterion,
                                 .input = &input,
                                 .portion = portion,
                                 .evaluator = &evaluator,
                                 .n_ray = portion->n_row[RMAP_TABLE_RAY],
                                 .count = count};
    RMAP_TRY(check_portion(criterion, portion, err));
    RMAP_TRY(rmap_test_mark(&ev, criterion->root, node, false, &marks, err));
    rmap_test_count(marks.bits, marks.n_rows, ev.n_ray, count);
out:
    rmap_evaluator_fini(&evaluator);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Outcomes on a portion of which the history index has the rows (RMAP_HISTORY_ROWS): tests are put
 * to the classes of segments and registrations, and the index counts the rows of those that pass.
 */
#include "analysis/query/query_rows.h"

#include <string.h>

#include "analysis/query/class_tests.h"
#include "analysis/query/query_path.h"
#include "base/alloc.h"
#include "base/byte_set.h"
#include "history/history_gather.h"
#include "history/history_view.h"

struct rmap_query_rows {
    const struct rmap_criterion *const *criterion;
    struct rmap_class_tests *tests;
    size_t c; /* criterion being evaluated */

    /* The portion in hand. */
    const struct rmap_history_view *view;
    const struct rmap_portion *rays;
    enum rmap_status (*fetch)(void *context, rmap_column_set columns, struct rmap_error *err);
    void *context;
    uint64_t *bits; /* [2] [words of n_ray] */
    uint8_t *flag;  /* [n_ray] */
    size_t bits_cap, flag_cap;
    struct rmap_query_path path;
};

enum rmap_status rmap_query_rows_create(const struct rmap_criterion *const *criterion,
                                        size_t n_criterion, struct rmap_query_rows **rows_ret,
                                        struct rmap_error *err)
{
    struct rmap_query_rows *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->criterion = criterion;
    enum rmap_status st = rmap_class_tests_create(criterion, n_criterion, &self->tests, err);
    if (st == RMAP_OK)
        *rows_ret = self;
    else
        rmap_query_rows_destroy(self);
    return st;
}

void rmap_query_rows_destroy(struct rmap_query_rows *self)
{
    if (!self)
        return;
    rmap_class_tests_destroy(self->tests);
    rmap_free(self->bits);
    rmap_free(self->flag);
    rmap_query_path_fini(&self->path);
    rmap_free(self);
}

enum rmap_status rmap_query_rows_enter_piece(struct rmap_query_rows *self,
                                             const struct rmap_history_index *index,
                                             struct rmap_error *err)
{
    return rmap_class_tests_enter(self->tests, rmap_history_classes(index),
                                  rmap_history_n_class(index), rmap_history_hits(index),
                                  rmap_history_n_hit(index), err);
}

void rmap_query_rows_enter(struct rmap_query_rows *self, const struct rmap_history_view *view,
                           const struct rmap_portion *rays,
                           enum rmap_status (*fetch)(void *context, rmap_column_set columns,
                                                     struct rmap_error *err),
                           void *context)
{
    self->view = view;
    self->rays = rays;
    self->fetch = fetch;
    self->context = context;
}

static enum rmap_status reserve_rays(struct rmap_query_rows *self, struct rmap_error *err)
{
    size_t n_ray = self->view->n_row[RMAP_TABLE_RAY];
    enum rmap_status st =
        RMAP_RESERVE(self->bits, self->bits_cap, 2 * (rmap_bit_words(n_ray) + 1), err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->flag, self->flag_cap, n_ray + 1, err);
    return st;
}

/* A bit per ray: of a kind for which the test holds. */
static enum rmap_status mark_kinds(struct rmap_query_rows *self,
                                   const struct rmap_criterion_node *node, uint64_t *bits,
                                   struct rmap_error *err)
{
    static const uint8_t is_one[256] = {0, 1};
    const struct rmap_history_view *view = self->view;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    uint8_t *own = rmap_alloc(view->n_kind + 1, sizeof *own);
    if (!own)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu kinds", view->n_kind);
    for (size_t k = 0; k < view->n_kind; k++)
        own[k] = node->kind == RMAP_CRITERION_SOURCE
                     ? rmap_index_set_has(&node->source, view->kind_source[k])
                     : view->kind_stop[k] == node->ending.stop;
    for (size_t i = 0; view->kind && i < n_ray; i++)
        self->flag[i] = own[view->kind[i]];
    if (view->kind)
        rmap_byte_set_bits(self->flag, n_ray, is_one, bits);
    else
        memset(bits, own[0] ? UINT8_MAX : 0, rmap_bit_words(n_ray) * sizeof *bits);
    rmap_free(own);
    return RMAP_OK;
}

/* Of the rays that ended so, those whose last segment is of a class that passes. */
static void keep_places(struct rmap_query_rows *self, const uint8_t *pass, uint64_t *bits)
{
    size_t n_word = rmap_bit_words(self->view->n_row[RMAP_TABLE_RAY]);
    uint64_t *there = bits + n_word + 1;
    const uint64_t *segment = rmap_history_mark(self->view, pass);
    memset(there, 0, n_word * sizeof *there);
    if (segment)
        rmap_bits_last_groups(segment, self->view->segment_count, self->view->n_row[RMAP_TABLE_RAY],
                              there);
    for (size_t w = 0; w < n_word; w++)
        bits[w] &= there[w];
}

/* Tests of rays: source, end, path. index: of the node, as `mark` has it. */
static enum rmap_status mark_rays(struct rmap_query_rows *self, int32_t index,
                                  const struct rmap_criterion_node *node, struct rmap_marks *marks,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const void *of_class = NULL;
    RMAP_TRY(reserve_rays(self, err));
    *marks = (struct rmap_marks){self->bits, NULL};
    if (node->kind == RMAP_CRITERION_PATH) {
        RMAP_TRY(rmap_class_tests_answer(self->tests, self->c, index, node, &of_class, err));
        return rmap_query_path_mark(&self->path, self->view, node, of_class, self->bits, err);
    }
    RMAP_TRY(mark_kinds(self, node, self->bits, err));
    if (node->kind == RMAP_CRITERION_SOURCE || !node->ending.somewhere)
        return RMAP_OK;
    RMAP_TRY(rmap_class_tests_answer(self->tests, self->c, index, node, &of_class, err));
    keep_places(self, of_class, self->bits);
out:
    return st;
}

/* As rmap_criterion_input.mark says. */
static enum rmap_status mark(void *context, int32_t index, const struct rmap_criterion_node *node,
                             struct rmap_marks *marks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_rows *self = context;
    const bool is_step = node->kind == RMAP_CRITERION_STEPS;
    const void *of_class = NULL;
    if (!is_step && node->kind != RMAP_CRITERION_REGISTRATIONS)
        return mark_rays(self, index, node, marks, err);
    if (!is_step && node->registrations.where >= 0)
        return RMAP_OK; /* what went before is told by the ray's rows, in their order */
    RMAP_TRY(rmap_class_tests_answer(self->tests, self->c, index, node, &of_class, err));
    marks->bits = is_step ? rmap_history_mark(self->view, of_class)
                          : rmap_history_mark_hits(self->view, of_class);
    marks->n_rows = is_step ? self->view->segment_count : self->view->registration_count;
    if (marks->bits)
        return RMAP_OK;
    RMAP_TRY(reserve_rays(self, err));
    memset(self->bits, 0, rmap_bit_words(self->view->n_row[RMAP_TABLE_RAY]) * sizeof *self->bits);
    *marks = (struct rmap_marks){self->bits, NULL};
out:
    return st;
}

static enum rmap_status fetch_columns(void *context, rmap_column_set columns,
                                      struct rmap_error *err)
{
    const struct rmap_query_rows *self = context;
    return self->fetch(self->context, columns, err);
}

enum rmap_status rmap_query_rows_evaluate(struct rmap_query_rows *self, size_t c,
                                          struct rmap_evaluator *evaluator, uint8_t *outcome,
                                          struct rmap_error *err)
{
    const struct rmap_criterion_input input = {.portion = self->rays,
                                               .columns = RMAP_COLUMNS_DISCRETE,
                                               .context = self,
                                               .fetch = fetch_columns,
                                               .mark = mark};
    self->c = c;
    return rmap_criterion_decide(self->criterion[c], &input, evaluator, outcome, err);
}

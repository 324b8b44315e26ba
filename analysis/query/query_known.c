/* SPDX-License-Identifier: MIT
 *
 * Criteria on compact pieces: what paths decide is decided once for each path of
 * a piece's dictionary; rays that share one look it up, and those with paths of their own are
 * evaluated by themselves.
 */
#include "analysis/query/query_known.h"

#include <string.h>

#include "analysis/criterion/path_mark.h"
#include "analysis/query/class_tests.h"
#include "analysis/query/query_sums.h"
#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/count.h"
#include "base/wide.h"
#include "io/map/map_cursor.h"
#include "io/map/map_keep.h"
#include "io/map/map_memory.h"

#define STEP_COLUMNS                                                                               \
    (RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |                  \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_medium))

/* Outcomes on dictionaries are kept up to this, in all threads; then all are forgotten. */
enum { DECISION_NBYTES_MAX = 16 << 20 };

/* On the dictionary of a piece. */
struct decision {
    size_t n_path;
    uint8_t *outcome; /* [n_criterion][1 + n_path], NULL: not yet evaluated; first NO: of no path */
    size_t *n_open;   /* [n_criterion] paths that it leaves open */
    uint32_t *rays;   /* [n_criterion][1 + n_path] that have this path, not summed up yet: all of
                         them where the path decides, those that match where it is open */
    uint32_t *segments; /* [n_path] */
    int32_t *source;    /* [n_path] */
};

struct rmap_query_known {
    const struct rmap_map *map;
    const struct rmap_criterion *const *criterion;
    size_t n_criterion;
    struct decision *decision; /* [n_piece] */
    size_t nbytes;             /* of all decisions */
    struct rmap_count *sum;    /* [n_criterion] of what was counted since they were asked for */
    struct rmap_evaluator evaluator;

    struct rmap_cursor *cursor; /* has the portion in hand */
    size_t piece, n_ray;
    bool is_told;                     /* what follows is of this portion; */
    struct rmap_path_summary summary; /* its `path` is NULL where own paths alone were asked for */
    const struct rmap_portion *own;   /* NULL: not asked for yet */
    uint8_t *own_outcome;             /* [n_own] */
    size_t own_cap;
    struct rmap_class_tests *tests;          /* of the steps of own paths */
    const struct rmap_step_classes *classes; /* that they have in hand, */
    size_t classes_piece;                    /* of this piece */
    size_t c;                                /* criterion being evaluated */
    uint64_t *bits;                          /* of own segments, own paths or rays */
    uint16_t *symbol;                        /* of own segments, for a path("...") */
    uint8_t *match;                          /* own paths that it matches */
    size_t bits_cap, symbol_cap, match_cap;
};

/* Where columns are kept, numbers are decoded once and for all: paths would leave out portions that
 * the next question asks for. */
bool rmap_query_known_tells(const struct rmap_map *map,
                            const struct rmap_criterion *const *criterion, size_t n_criterion)
{
    struct rmap_map_kept kept;
    rmap_column_set columns = 0;
    bool any = false;
    rmap_map_kept(map, &kept);
    for (size_t c = 0; c < n_criterion; c++)
        columns |= rmap_criterion_columns(criterion[c]);
    for (size_t p = 0; p < rmap_map_n_piece(map); p++)
        any |= rmap_map_piece(map, p)->encoding == RMAP_ENCODING_COMPACT;
    return any && n_criterion > 0 && (kept.budget == 0 || !(columns & ~RMAP_COLUMNS_DISCRETE));
}

enum rmap_status rmap_query_known_create(const struct rmap_map *map,
                                         const struct rmap_criterion *const *criterion,
                                         size_t n_criterion, struct rmap_query_known **known_ret,
                                         struct rmap_error *err)
{
    *known_ret = NULL;
    if (!rmap_query_known_tells(map, criterion, n_criterion))
        return RMAP_OK;
    struct rmap_query_known *self = rmap_alloc(1, sizeof *self);
    if (self)
        self->decision = rmap_alloc(rmap_map_n_piece(map), sizeof *self->decision);
    if (!self || !self->decision) {
        rmap_free(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    }
    self->map = map;
    self->criterion = criterion;
    self->n_criterion = n_criterion;
    enum rmap_status st = rmap_class_tests_create(criterion, n_criterion, &self->tests, err);
    self->sum = rmap_alloc(n_criterion, sizeof *self->sum);
    if (!self->sum && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    for (size_t c = 0; c < n_criterion && st == RMAP_OK; c++)
        st = rmap_count_init(&self->sum[c], rmap_map_scene(map)->n_source, err);
    if (st == RMAP_OK)
        *known_ret = self;
    else
        rmap_query_known_destroy(self);
    return st;
}

static void add_source(struct rmap_count *count, size_t source, double rays)
{
    count->source_weight[source] += rays;
    count->source_weight_squared[source] += rays;
}

/* Sums up the rays that were counted path by path. */
static void sum_up(struct rmap_query_known *self, struct decision *decision)
{
    const size_t n = decision->n_path;
    for (size_t c = 0; decision->rays && c < self->n_criterion; c++) {
        struct rmap_count *sum = &self->sum[c];
        const uint8_t *outcome = decision->outcome + c * (n + 1) + 1;
        uint32_t *rays = decision->rays + c * (n + 1) + 1;
        for (size_t k = 0; k < n; k++) {
            if (rays[k] > 0 && outcome[k] != RMAP_OUTCOME_NO) {
                sum->rays += rays[k];
                sum->segments += (uint64_t)rays[k] * decision->segments[k];
                add_source(sum, (size_t)decision->source[k], rays[k]);
            }
            rays[k] = 0;
        }
    }
}

static void forget(struct decision *decision)
{
    rmap_free(decision->outcome);
    rmap_free(decision->n_open);
    rmap_free(decision->rays);
    rmap_free(decision->segments);
    rmap_free(decision->source);
    *decision = (struct decision){0};
}

static void forget_all(struct rmap_query_known *self)
{
    for (size_t p = 0; p < rmap_map_n_piece(self->map); p++) {
        sum_up(self, &self->decision[p]);
        forget(&self->decision[p]);
    }
    self->nbytes = 0;
}

void rmap_query_known_destroy(struct rmap_query_known *self)
{
    if (!self)
        return;
    forget_all(self);
    for (size_t c = 0; self->sum && c < self->n_criterion; c++)
        rmap_count_fini(&self->sum[c]);
    rmap_free(self->sum);
    rmap_evaluator_fini(&self->evaluator);
    rmap_free(self->decision);
    rmap_free(self->own_outcome);
    rmap_class_tests_destroy(self->tests);
    rmap_free(self->bits);
    rmap_free(self->symbol);
    rmap_free(self->match);
    rmap_free(self);
}

void rmap_query_known_enter(struct rmap_query_known *self, struct rmap_cursor *cursor,
                            size_t portion, size_t n_ray)
{
    self->cursor = cursor;
    self->piece = (size_t)rmap_map_portion(self->map, portion)->piece;
    self->n_ray = n_ray;
    self->is_told = false;
    self->own = NULL;
}

/* Of these, paths tell bounds. */
static const rmap_column_set bounded_columns =
    RMAP_COLUMN_BIT(RMAP_RAY_path_length) | RMAP_COLUMN_BIT(RMAP_RAY_optical_path);

/* Outcomes of a criterion on the paths of the dictionary in hand. */
static enum rmap_status evaluate_dictionary(struct rmap_query_known *self, size_t c,
                                            uint8_t *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_input input = {.portion = self->summary.paths,
                                         .columns = RMAP_COLUMNS_DISCRETE};
    if (rmap_criterion_columns(self->criterion[c]) & bounded_columns)
        RMAP_TRY(rmap_cursor_path_sums(self->cursor, &input.bounds, err));
    st = rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, outcome, err);
out:
    return st;
}

static enum rmap_status evaluate_paths(struct rmap_query_known *self, struct decision *decision,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *paths = self->summary.paths;
    const size_t n = paths->n_row[RMAP_TABLE_RAY];
    decision->n_path = n;
    decision->outcome = rmap_alloc(self->n_criterion, n + 1);
    decision->n_open = rmap_alloc(self->n_criterion, sizeof *decision->n_open);
    decision->rays = rmap_alloc(self->n_criterion * (n + 1), sizeof *decision->rays);
    decision->segments = rmap_alloc_unset(n + 1, sizeof *decision->segments);
    decision->source = rmap_alloc_unset(n + 1, sizeof *decision->source);
    if (!decision->outcome || !decision->n_open || !decision->rays || !decision->segments ||
        !decision->source)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n);
    for (size_t c = 0; c < self->n_criterion; c++) {
        uint8_t *outcome = decision->outcome + c * (n + 1);
        outcome[0] = RMAP_OUTCOME_NO;
        RMAP_TRY(evaluate_dictionary(self, c, outcome + 1, err));
        decision->n_open[c] = rmap_count_equal(outcome + 1, n, RMAP_OUTCOME_OPEN);
    }
    memcpy(decision->segments, paths->ray.segment_count, n * sizeof *decision->segments);
    memcpy(decision->source, paths->ray.source, n * sizeof *decision->source);
out:
    return st;
}

/* Decides on the piece in hand, whose paths are known. */
static enum rmap_status decide(struct rmap_query_known *self, struct rmap_error *err)
{
    struct decision *decision = &self->decision[self->piece];
    const size_t n = self->summary.paths->n_row[RMAP_TABLE_RAY] + 1;
    const size_t nbytes = n * (self->n_criterion * (1 + sizeof *decision->rays) +
                               sizeof *decision->segments + sizeof *decision->source);
    if (decision->outcome)
        return RMAP_OK;
    if (self->nbytes + nbytes > rmap_map_share(self->map, DECISION_NBYTES_MAX))
        forget_all(self);
    const enum rmap_status st = evaluate_paths(self, decision, err);
    if (st == RMAP_OK)
        self->nbytes += nbytes;
    else
        forget(decision);
    return st;
}

/* Whether the criterion decides no path. */
static bool is_idle(const struct decision *decision, size_t c)
{
    return decision->n_open[c] == decision->n_path;
}

static enum rmap_status sum_up_paths(struct rmap_query_known *self, bool own_alone,
                                     struct rmap_error *err)
{
    if (self->is_told && (own_alone || self->summary.path || !self->summary.paths))
        return RMAP_OK;
    self->is_told = true;
    return rmap_cursor_path_summary(self->cursor, own_alone, &self->summary, err);
}

/* Looks at the portion in hand: *is_told_ret whether its paths tell of criterion c, or may leave
 * all to what stands beside them. */
static enum rmap_status look(struct rmap_query_known *self, size_t c, bool *is_told_ret,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct decision *decision = &self->decision[self->piece];
    rmap_column_set traced;
    *is_told_ret = false;
    RMAP_TRY(rmap_cursor_traced(self->cursor, &traced, err));
    const rmap_column_set more =
        rmap_cursor_tells_of(self->cursor, rmap_criterion_columns(self->criterion[c]) & traced);
    if (decision->outcome && is_idle(decision, c) && !more)
        goto out;
    RMAP_TRY(sum_up_paths(self, false, err));
    if (!self->summary.paths)
        goto out;
    RMAP_TRY(decide(self, err));
    *is_told_ret = more || !is_idle(decision, c);
out:
    return st;
}

/* The rays with paths of their own, for all criteria. */
static enum rmap_status enter_own(struct rmap_query_known *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = self->summary.n_own;
    if (self->own)
        goto out;
    RMAP_TRY(RMAP_RESERVE(self->own_outcome, self->own_cap, n + 1, err));
    st = rmap_cursor_own_paths(self->cursor, RMAP_COLUMN_BIT(RMAP_RAY_source), &self->own, err);
out:
    return st;
}

/* As rmap_criterion_input.fetch: what no class answers. */
static enum rmap_status fetch_own(void *context, rmap_column_set columns, struct rmap_error *err)
{
    struct rmap_query_known *self = context;
    return rmap_cursor_own_paths(self->cursor, columns, &self->own, err);
}

/* A bit for each own path that a node (RMAP_CRITERION_PATH) matches, to which its comparison is not
 * put. */
static enum rmap_status mark_paths(struct rmap_query_known *self, int32_t index,
                                   const struct rmap_criterion_node *node,
                                   const struct rmap_own_steps *steps, struct rmap_error *err)
{
    static const uint8_t marked = 1;
    enum rmap_status st = RMAP_OK;
    const size_t n = self->summary.n_own_segment;
    RMAP_TRY(fetch_own(self, node->columns & ~STEP_COLUMNS, err));
    RMAP_TRY(RMAP_RESERVE(self->symbol, self->symbol_cap, n + RMAP_PATH_COPY, err));
    RMAP_TRY(RMAP_RESERVE(self->match, self->match_cap, self->summary.n_own + 1, err));
    RMAP_TRY(
        rmap_class_tests_symbols(self->tests, self->c, index, node, steps, n, self->symbol, err));
    RMAP_TRY(rmap_path_mark(node, self->own, self->symbol, self->match, err));
    rmap_bytes_among(self->match, self->summary.n_own, &marked, 1, self->bits);
out:
    return st;
}

/* As rmap_criterion_input.mark: steps, and paths of steps, by their classes. */
static enum rmap_status mark_own(void *context, int32_t index,
                                 const struct rmap_criterion_node *node, struct rmap_marks *marks,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_query_known *self = context;
    const struct rmap_path_summary *summary = &self->summary;
    const bool is_path = node->kind == RMAP_CRITERION_PATH;
    const size_t n_bit = is_path ? summary->n_own : summary->n_own_segment;
    struct rmap_own_steps steps;
    if ((node->kind != RMAP_CRITERION_STEPS && !is_path) || !summary->classes)
        return RMAP_OK;
    if (!is_path && node->steps.n_limit > 0) /* classes do not know which step comes first */
        return RMAP_OK;
    /* Dictionaries that are let go may come back elsewhere, or another one in their place. */
    if (self->classes != summary->classes || self->classes_piece != self->piece)
        RMAP_TRY(
            rmap_class_tests_enter(self->tests, summary->classes->of, summary->classes->n, err));
    self->classes = summary->classes;
    self->classes_piece = self->piece;
    RMAP_TRY(RMAP_RESERVE(self->bits, self->bits_cap, rmap_bit_words(n_bit) + 1, err));
    RMAP_TRY(rmap_cursor_own_steps(self->cursor, &steps, err));
    if (is_path)
        RMAP_TRY(mark_paths(self, index, node, &steps, err));
    else
        RMAP_TRY(rmap_class_tests_mark(self->tests, self->c, index, node, &steps, n_bit, self->bits,
                                       err));
    *marks = (struct rmap_marks){.bits = self->bits,
                                 .n_rows = is_path ? NULL : self->own->ray.segment_count};
out:
    return st;
}

static enum rmap_status evaluate_own(struct rmap_query_known *self, size_t c,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_input input = {.portion = self->own,
                                         .columns = RMAP_COLUMNS_DISCRETE,
                                         .context = self,
                                         .fetch = fetch_own,
                                         .mark = mark_own};
    self->c = c;
    if (rmap_criterion_columns(self->criterion[c]) & bounded_columns)
        RMAP_TRY(rmap_cursor_own_lengths(self->cursor, &input.bounds, err));
    st =
        rmap_criterion_decide(self->criterion[c], &input, &self->evaluator, self->own_outcome, err);
out:
    return st;
}

/* Theirs take their places. */
static enum rmap_status place_own(struct rmap_query_known *self, uint8_t *outcome,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint8_t *own = self->own_outcome;
    RMAP_TRY(RMAP_RESERVE(self->bits, self->bits_cap, rmap_bit_words(self->n_ray), err));
    rmap_range_bits((const int32_t *)self->summary.path, self->n_ray, 0, 1, self->bits);
    for (size_t w = 0; w < rmap_bit_words(self->n_ray); w++)
        for (uint64_t left = self->bits[w]; left; left &= left - 1)
            outcome[64 * w + (size_t)__builtin_ctzll(left)] = *own++;
out:
    return st;
}

enum rmap_status rmap_query_known_evaluate(struct rmap_query_known *self, size_t c,
                                           uint8_t *outcome, bool *is_told_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = self->n_ray;
    RMAP_TRY(look(self, c, is_told_ret, err));
    if (!*is_told_ret)
        goto out;
    const struct decision *decision = &self->decision[self->piece];
    const uint8_t *known = decision->outcome + c * (decision->n_path + 1);
    const uint32_t *path = self->summary.path;
    RMAP_UNROLL
    for (size_t i = 0; i < n_ray; i++)
        outcome[i] = known[path[i]];
    if (self->summary.n_own > 0) {
        RMAP_TRY(enter_own(self, err));
        RMAP_TRY(evaluate_own(self, c, err));
        RMAP_TRY(place_own(self, outcome, err));
    }
out:
    return st;
}

static void count_own(const struct rmap_query_known *self, struct rmap_count *sum)
{
    const size_t n_source = rmap_map_scene(self->map)->n_source;
    const struct rmap_sums_facts facts = {n_source, n_source <= RMAP_SUMS_SOURCES_MAX};
    rmap_sums_add_rays(sum, self->own, self->own_outcome, &facts);
}

enum rmap_status rmap_query_known_add(struct rmap_query_known *self, size_t c, bool *is_counted_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct decision *decision = &self->decision[self->piece];
    bool is_told;
    *is_counted_ret = false;
    RMAP_TRY(look(self, c, &is_told, err));
    if (!is_told || decision->n_open[c] > 0)
        goto out;
    if (self->summary.n_own > 0) {
        RMAP_TRY(enter_own(self, err));
        RMAP_TRY(evaluate_own(self, c, err));
        if (memchr(self->own_outcome, RMAP_OUTCOME_OPEN, self->summary.n_own))
            goto out;
        count_own(self, &self->sum[c]);
    }
    uint32_t *rays = decision->rays + c * (decision->n_path + 1);
    for (size_t i = 0; i < self->n_ray; i++)
        rays[self->summary.path[i]]++;
    *is_counted_ret = true;
out:
    return st;
}

enum rmap_status rmap_query_known_add_own(struct rmap_query_known *self, size_t c,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(sum_up_paths(self, true, err));
    if (!self->summary.paths)
        RMAP_TRY(rmap_error_set(err, RMAP_FORMAT,
                                "%s counts rays by paths, which do not tell all of them",
                                rmap_map_piece(self->map, self->piece)->name));
    if (self->summary.n_own == 0)
        goto out;
    RMAP_TRY(enter_own(self, err));
    RMAP_TRY(evaluate_own(self, c, err));
    if (memchr(self->own_outcome, RMAP_OUTCOME_OPEN, self->summary.n_own))
        RMAP_TRY(rmap_error_set(err, RMAP_INTERNAL, "a discrete criterion leaves a path open"));
    count_own(self, &self->sum[c]);
out:
    return st;
}

void rmap_query_known_settle(struct rmap_query_known *self, struct rmap_count *count)
{
    const size_t n_source = rmap_map_scene(self->map)->n_source;
    for (size_t p = 0; p < rmap_map_n_piece(self->map); p++)
        sum_up(self, &self->decision[p]);
    for (size_t c = 0; c < self->n_criterion; c++) {
        struct rmap_count *sum = &self->sum[c];
        rmap_count_add(&count[c], sum, n_source);
        sum->rays = sum->segments = 0;
        memset(sum->source_weight, 0, n_source * sizeof *sum->source_weight);
        memset(sum->source_weight_squared, 0, n_source * sizeof *sum->source_weight_squared);
    }
}

enum rmap_status rmap_query_known_count(struct rmap_query_known *self, size_t c,
                                        const uint8_t *outcome, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct decision *decision = &self->decision[self->piece];
    const uint32_t *path = self->summary.path;
    uint32_t *rays = decision->rays + c * (decision->n_path + 1);
    for (size_t i = 0; i < self->n_ray; i++)
        rays[path[i]] += outcome[i] >> 1;
    if (self->summary.n_own == 0)
        goto out;
    RMAP_TRY(enter_own(self, err));
    for (size_t i = 0, k = 0; i < self->n_ray; i++) { /* there is room for one more */
        self->own_outcome[k] = outcome[i];
        k += path[i] == 0;
    }
    count_own(self, &self->sum[c]);
out:
    return st;
}

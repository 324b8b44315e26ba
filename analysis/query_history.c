/* SPDX-License-Identifier: MIT
 *
 * A piece's dictionary is judged once, as if its paths were rays; a portion in the form PATHS then
 * looks its verdicts up. In the form ROWS tests are put to the classes of legs and registrations,
 * and the index counts the rows of those that pass.
 */
#include "analysis/query_history.h"

#include <string.h>

#include "base/alloc.h"
#include "io/map_history.h"

/* Verdicts on dictionaries are kept up to this; then all are forgotten. */
enum { DECISION_NBYTES_MAX = 64 << 20 };

/* What was found out of a piece's dictionary. */
struct decision {
    size_t n_path;
    uint8_t *verdict;                    /* [n_criterion][n_path], NULL: not yet judged */
    size_t *first_row[RMAP_TABLE_COUNT]; /* [n_path], NULL: not yet added up; /ray has none */
};

/* The classes of the piece in hand as rows of one ray, and which of them pass a test. */
struct classes {
    struct rmap_portion portion; /* columns borrowed from the arrays below */
    uint32_t n_segment, n_registration;
    int32_t *object, *detector;
    uint32_t *event;
    int16_t *medium;
    uint8_t *registered;
    size_t object_cap, event_cap, medium_cap, detector_cap, registered_cap;
};

struct wanted {
    uint8_t *flag; /* [n_class] or [n_hit] */
    size_t cap;
    uint64_t stamp; /* of the piece it was made for */
};

struct rmap_query_history {
    const struct rmap_map *map;
    struct rmap_criterion *const *criterion;
    size_t n_criterion;
    const struct rmap_shared_tests *shared;
    struct decision *decision; /* [n_piece] */
    size_t decision_nbytes;
    struct wanted *wanted; /* [first_node[n_criterion]] per node of all criteria */
    size_t *first_node;    /* [n_criterion + 1] */
    struct rmap_judge judge;

    size_t piece;                           /* in hand, if index is not NULL */
    const struct rmap_history_index *index; /* borrowed from the map until given back */
    uint64_t stamp;                         /* changes with the piece in hand */
    struct classes classes;
    struct rmap_history_view view;
    bool is_begun; /* the judge has kept verdicts of the portion in hand alone */
    struct rmap_portion *unfolded;
    rmap_column_set present;  /* columns of it */
    struct rmap_portion rays; /* the portion in hand as evidence: the unfolded one's columns */
    size_t c;                 /* criterion being judged */
    uint64_t nbytes;
};

enum rmap_status
rmap_query_history_create(const struct rmap_map *map, struct rmap_criterion *const *criterion,
                          size_t n_criterion, const struct rmap_shared_tests *shared,
                          struct rmap_query_history **history_ret, struct rmap_error *err)
{
    struct rmap_query_history *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->map = map;
    self->criterion = criterion;
    self->n_criterion = n_criterion;
    self->shared = shared;
    self->decision = rmap_alloc(rmap_map_n_piece(map), sizeof *self->decision);
    self->first_node = rmap_alloc(n_criterion + 1, sizeof *self->first_node);
    self->unfolded = rmap_alloc(1, sizeof *self->unfolded);
    for (size_t c = 0; self->first_node && c < n_criterion; c++)
        self->first_node[c + 1] = self->first_node[c] + criterion[c]->n_node;
    if (self->first_node)
        self->wanted = rmap_alloc(self->first_node[n_criterion], sizeof *self->wanted);
    if (!self->decision || !self->wanted || !self->unfolded) {
        rmap_query_history_destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    }
    *history_ret = self;
    return RMAP_OK;
}

static void forget_decisions(struct rmap_query_history *self)
{
    for (size_t p = 0; self->decision && p < rmap_map_n_piece(self->map); p++) {
        rmap_free(self->decision[p].verdict);
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            rmap_free(self->decision[p].first_row[t]);
        self->decision[p] = (struct decision){0};
    }
    self->decision_nbytes = 0;
}

static void leave_piece(struct rmap_query_history *self)
{
    if (self->index)
        rmap_map_history_release(self->map, self->piece);
    self->index = NULL;
}

void rmap_query_history_destroy(struct rmap_query_history *self)
{
    if (!self)
        return;
    rmap_history_view_fini(&self->view);
    leave_piece(self);
    forget_decisions(self);
    for (size_t i = 0; self->wanted && i < self->first_node[self->n_criterion]; i++)
        rmap_free(self->wanted[i].flag);
    rmap_free(self->classes.object);
    rmap_free(self->classes.event);
    rmap_free(self->classes.medium);
    rmap_free(self->classes.detector);
    rmap_free(self->classes.registered);
    rmap_judge_fini(&self->judge);
    rmap_portion_destroy(self->unfolded);
    rmap_free(self->wanted);
    rmap_free(self->first_node);
    rmap_free(self->decision);
    rmap_free(self);
}

uint64_t rmap_query_history_nbytes(const struct rmap_query_history *self)
{
    return self->nbytes;
}

static enum rmap_status reserve_classes(struct classes *self, size_t n_class, size_t n_hit,
                                        struct rmap_error *err)
{
    const struct {
        void **block;
        size_t *cap, n, size;
    } row[] = {{(void **)&self->object, &self->object_cap, n_class, sizeof *self->object},
               {(void **)&self->event, &self->event_cap, n_class, sizeof *self->event},
               {(void **)&self->medium, &self->medium_cap, n_class, sizeof *self->medium},
               {(void **)&self->detector, &self->detector_cap, n_hit, sizeof *self->detector},
               {(void **)&self->registered, &self->registered_cap, n_hit, 1}};
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < sizeof row / sizeof *row; i++)
        st = rmap_reserve(row[i].block, row[i].cap, row[i].n, row[i].size, err);
    return st;
}

/* Classes as columns, so that tests are put to them as to rows. */
static enum rmap_status list_classes(struct rmap_query_history *self, struct rmap_error *err)
{
    struct classes *own = &self->classes;
    size_t n_class = rmap_history_n_class(self->index), n_hit = rmap_history_n_hit(self->index);
    const struct rmap_history_class *class = rmap_history_classes(self->index);
    const struct rmap_history_hit *hit = rmap_history_hits(self->index);
    enum rmap_status st = reserve_classes(own, n_class, n_hit, err);
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < n_class; i++) {
        own->object[i] = class[i].object;
        own->event[i] = class[i].event;
        own->medium[i] = (int16_t) class[i].medium;
    }
    for (size_t i = 0; i < n_hit; i++) {
        own->detector[i] = hit[i].detector;
        own->registered[i] = (uint8_t)hit[i].registered;
    }
    own->n_segment = (uint32_t)n_class;
    own->n_registration = (uint32_t)n_hit;
    own->portion = (struct rmap_portion){
        .n_row = {1, n_class, n_hit},
        .ray.segment_count = &own->n_segment,
        .ray.registration_count = &own->n_registration,
        .segment = {.object = own->object, .event = own->event, .medium = own->medium},
        .registration = {.detector = own->detector, .registered = own->registered}};
    return RMAP_OK;
}

static enum rmap_status enter_piece(struct rmap_query_history *self, size_t piece,
                                    struct rmap_error *err)
{
    if (self->index && self->piece == piece)
        return RMAP_OK;
    leave_piece(self);
    self->piece = piece;
    self->stamp++;
    enum rmap_status st = rmap_map_history(self->map, piece, &self->index, err);
    return st == RMAP_OK && self->index ? list_classes(self, err) : st;
}

enum rmap_status rmap_query_history_enter(struct rmap_query_history *self, size_t portion,
                                          const struct rmap_history_view **view_ret,
                                          struct rmap_error *err)
{
    const struct rmap_portion_info *info = rmap_map_portion(self->map, portion);
    *view_ret = NULL;
    self->is_begun = false;
    self->present = 0;
    enum rmap_status st = enter_piece(self, (size_t)info->piece, err);
    if (st != RMAP_OK || !self->index)
        return st;
    size_t at = rmap_history_find(self->index, info->first_ray, info->n_row, info->digest);
    if (at == SIZE_MAX)
        return RMAP_OK;
    st = rmap_history_view_open(self->index, at, &self->view, err);
    if (st == RMAP_FORMAT) /* the columns know, too; `verify` tells of the damage */
        return RMAP_OK;
    if (st == RMAP_OK) {
        self->nbytes += self->view.nbytes;
        *view_ret = &self->view;
    }
    return st;
}

/* Verdicts of all criteria on the dictionary of the piece in hand. */
static enum rmap_status judge_paths(struct rmap_query_history *self, struct decision *decision,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_evidence evidence = {.portion = rmap_history_paths(self->index),
                                           .columns = RMAP_COLUMNS_DISCRETE};
    size_t n_path = evidence.portion->n_row[RMAP_TABLE_RAY];
    decision->n_path = n_path;
    decision->verdict = rmap_alloc(self->n_criterion, n_path);
    if (!decision->verdict)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n_path);
    self->decision_nbytes += self->n_criterion * n_path;
    RMAP_TRY(rmap_judge_begin(&self->judge, self->shared->n_slot, n_path, err));
    for (size_t c = 0; c < self->n_criterion; c++)
        RMAP_TRY(rmap_criterion_judge(self->criterion[c], self->shared->slot[c], &evidence,
                                      &self->judge, decision->verdict + c * n_path, err));
out:
    return st;
}

/* The decision on the piece in hand. */
static enum rmap_status decide(struct rmap_query_history *self, struct decision **decision_ret,
                               struct rmap_error *err)
{
    struct decision *decision = &self->decision[self->piece];
    *decision_ret = decision;
    if (decision->verdict && decision->n_path == rmap_history_paths(self->index)->n_row[0])
        return RMAP_OK;
    if (decision->verdict || self->decision_nbytes > DECISION_NBYTES_MAX)
        forget_decisions(self);
    return judge_paths(self, decision, err);
}

/* Which classes pass a test of steps or registrations. */
static enum rmap_status want(struct rmap_query_history *self, int32_t index,
                             const struct rmap_criterion_node *node, const uint8_t **flag_ret,
                             struct rmap_error *err)
{
    struct wanted *wanted = &self->wanted[self->first_node[self->c] + (size_t)index];
    const struct rmap_criterion *criterion = self->criterion[self->c];
    const struct rmap_portion *classes = &self->classes.portion;
    bool of_steps = node->kind == RMAP_CRITERION_STEPS;
    size_t n = classes->n_row[of_steps ? RMAP_TABLE_SEGMENT : RMAP_TABLE_REGISTRATION];
    void *flag = wanted->flag;
    enum rmap_status st = rmap_reserve(&flag, &wanted->cap, n + 1, 1, err);
    wanted->flag = flag;
    *flag_ret = flag;
    if (st != RMAP_OK || wanted->stamp == self->stamp)
        return st;
    wanted->stamp = self->stamp;
    const struct rmap_strip strip = {.n = n};
    if (n > 0 && of_steps)
        rmap_steps_mark(criterion, &node->steps, classes, &strip, flag);
    else if (n > 0)
        rmap_registrations_mark(criterion, &node->registrations, classes, &strip, flag);
    return RMAP_OK;
}

/* 1 or 0 per kind of ray, then per ray. */
static enum rmap_status count_kinds(const struct rmap_history_view *view,
                                    const struct rmap_criterion_node *node, uint32_t *count,
                                    struct rmap_error *err)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    uint32_t *own = rmap_alloc(view->n_kind + 1, sizeof *own);
    if (!own)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu kinds", view->n_kind);
    for (size_t k = 0; k < view->n_kind; k++)
        own[k] = node->kind == RMAP_CRITERION_SOURCE
                     ? rmap_index_set_has(&node->source, view->kind_source[k])
                     : view->kind_stop[k] == node->ending.stop;
    for (size_t i = 0; i < n_ray; i++)
        count[i] = own[view->kind ? view->kind[i] : 0];
    rmap_free(own);
    return RMAP_OK;
}

/* As rmap_evidence.count says, of a portion in the form ROWS. */
static enum rmap_status count_by_class(void *context, int32_t index,
                                       const struct rmap_criterion_node *node, uint32_t *count,
                                       bool *counted_ret, struct rmap_error *err)
{
    struct rmap_query_history *self = context;
    const struct rmap_history_view *view = &self->view;
    const uint8_t *flag;
    enum rmap_status st = RMAP_OK;
    *counted_ret = true;
    if (node->kind == RMAP_CRITERION_SOURCE ||
        (node->kind == RMAP_CRITERION_ENDED && !node->ending.somewhere))
        return count_kinds(view, node, count, err);
    *counted_ret = node->kind == RMAP_CRITERION_STEPS || node->kind == RMAP_CRITERION_REGISTRATIONS;
    if (!*counted_ret)
        return RMAP_OK;
    st = want(self, index, node, &flag, err);
    if (st == RMAP_OK && node->kind == RMAP_CRITERION_STEPS)
        rmap_history_count(view, flag, count);
    else if (st == RMAP_OK)
        rmap_history_count_hits(view, flag, count);
    return st;
}

/* Discrete columns of the portion in hand, unfolded when first asked for. */
static enum rmap_status unfold(void *context, rmap_column_set columns, struct rmap_error *err)
{
    struct rmap_query_history *self = context;
    rmap_column_set fresh = columns & ~self->present;
    if (!fresh)
        return RMAP_OK;
    enum rmap_status st = rmap_history_unfold(&self->view, fresh, self->unfolded, err);
    if (st != RMAP_OK)
        return st;
    self->present |= fresh | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                     RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    self->rays = *self->unfolded;
    return RMAP_OK;
}

enum rmap_status rmap_query_history_unfold(struct rmap_query_history *self, rmap_column_set columns,
                                           const struct rmap_portion **rows_ret,
                                           struct rmap_error *err)
{
    *rows_ret = &self->rays;
    return unfold(self, columns, err);
}

static enum rmap_status judge_rows(struct rmap_query_history *self, size_t c, uint8_t *verdict,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_evidence evidence = {.portion = &self->rays,
                                           .columns = RMAP_COLUMNS_DISCRETE,
                                           .context = self,
                                           .fetch = unfold,
                                           .count = count_by_class};
    if (!self->is_begun) {
        self->rays.n_row[RMAP_TABLE_RAY] = self->view.n_row[RMAP_TABLE_RAY];
        RMAP_TRY(rmap_judge_begin(&self->judge, self->shared->n_slot,
                                  self->view.n_row[RMAP_TABLE_RAY], err));
        self->is_begun = true;
    }
    self->c = c;
    RMAP_TRY(rmap_criterion_judge(self->criterion[c], self->shared->slot[c], &evidence,
                                  &self->judge, verdict, err));
out:
    return st;
}

enum rmap_status rmap_query_history_judge(struct rmap_query_history *self, size_t c,
                                          uint8_t *verdict, struct rmap_error *err)
{
    const struct rmap_history_view *view = &self->view;
    struct decision *decision;
    if (view->form != RMAP_HISTORY_PATHS)
        return judge_rows(self, c, verdict, err);
    enum rmap_status st = decide(self, &decision, err);
    if (st != RMAP_OK)
        return st;
    const uint8_t *known = decision->verdict + c * decision->n_path;
    for (size_t k = 0; k < view->n_path; k++)
        verdict[k] = known[view->path_row[k]];
    return RMAP_OK;
}

/* Where the rows of the dictionary's paths begin in a table. */
static enum rmap_status add_up(struct rmap_query_history *self, struct decision *decision,
                               enum rmap_table table, struct rmap_error *err)
{
    const struct rmap_ray_columns *path = &rmap_history_paths(self->index)->ray;
    const uint32_t *rows =
        table == RMAP_TABLE_SEGMENT ? path->segment_count : path->registration_count;
    size_t *first = decision->first_row[table], at = 0;
    if (first)
        return RMAP_OK;
    first = rmap_alloc(decision->n_path, sizeof *first);
    if (!first)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", decision->n_path);
    for (size_t i = 0; i < decision->n_path; at += rows[i++])
        first[i] = at;
    decision->first_row[table] = first;
    self->decision_nbytes += decision->n_path * sizeof *first;
    return RMAP_OK;
}

enum rmap_status rmap_query_history_know(struct rmap_query_history *self, rmap_column_set columns,
                                         struct rmap_known_rows *known, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct decision *decision;
    *known = (struct rmap_known_rows){.portion = &self->rays};
    if (self->view.form != RMAP_HISTORY_PATHS)
        return unfold(self, columns, err);
    known->portion = rmap_history_paths(self->index);
    RMAP_TRY(decide(self, &decision, err));
    for (int t = RMAP_TABLE_SEGMENT; t < RMAP_TABLE_COUNT; t++) {
        RMAP_TRY(add_up(self, decision, (enum rmap_table)t, err));
        known->first_row[t] = decision->first_row[t];
    }
out:
    return st;
}

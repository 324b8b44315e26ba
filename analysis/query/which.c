/* SPDX-License-Identifier: MIT
 *
 * Which registrations of the rays that match are counted: those that --which chooses, else those
 * for which a conjunct registered(NAME, REGION where CONDITION) of the criterion holds, else all.
 */
#include "analysis/query/which.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/registration_response.h"
#include "base/alloc.h"
#include "base/byte_set.h"

static const rmap_column_set always = RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |
                                      RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                                      RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered);

/* Rows marked at a time, whole words of bits. */
enum { STRIP_ROWS = 4096 };

static bool sets_meet(const struct rmap_index_set *a, const struct rmap_index_set *b, size_t n)
{
    for (size_t i = 0; i < n; i++)
        if (rmap_index_set_has(a, (int32_t)i) && rmap_index_set_has(b, (int32_t)i))
            return true;
    return false;
}

/* Alone, or with >= 1 or > 0. */
static bool asks_for_any(const struct rmap_interval *interval)
{
    return !interval->outside && interval->low > 0.0 && interval->low <= 1.0 &&
           isinf(interval->high);
}

static bool is_registered(const struct rmap_criterion_node *node)
{
    return node->kind == RMAP_CRITERION_REGISTRATIONS && !node->registrations.crossed &&
           !node->registrations.of_number && asks_for_any(&node->interval);
}

static enum rmap_status add_test(struct rmap_which *self, int32_t node, struct rmap_error *err)
{
    int32_t *more = rmap_alloc(self->n_test + 1, sizeof *more);
    if (!more)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the registrations that count");
    if (self->n_test > 0)
        memcpy(more, self->test, self->n_test * sizeof *more);
    rmap_free(self->test);
    self->test = more;
    self->test[self->n_test++] = node;
    const struct rmap_criterion_node *its = &self->criterion->node[node];
    self->columns |= its->columns;
    self->chooses = true;
    for (size_t d = 0; d < self->scene->n_detector; d++)
        self->chosen_on[d] |= rmap_index_set_has(&its->registrations.detector, (int32_t)d);
    return RMAP_OK;
}

/* Conjuncts of the criterion, through `and` and parentheses. */
static enum rmap_status take_conjuncts(struct rmap_which *self,
                                       const struct rmap_index_set *detector, int32_t index,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_criterion_node *node = &self->criterion->node[index];
    if (node->kind == RMAP_CRITERION_AND) {
        for (int32_t child = node->first; child >= 0 && st == RMAP_OK;
             child = self->criterion->node[child].next)
            st = take_conjuncts(self, detector, child, err);
        return st;
    }
    if (!is_registered(node) ||
        !sets_meet(&node->registrations.detector, detector, self->scene->n_detector))
        return RMAP_OK;
    for (size_t d = 0; d < self->scene->n_detector; d++)
        self->asked_on[d] |= rmap_index_set_has(&node->registrations.detector, (int32_t)d);
    return node->registrations.chooses ? add_test(self, index, err) : RMAP_OK;
}

static int by_place(const void *a, const void *b)
{
    const int32_t x = *(const int32_t *)a, y = *(const int32_t *)b;
    return (x > y) - (x < y);
}

/* The tests as they are written, in the order in which they are. */
static enum rmap_status write_text(struct rmap_which *self, struct rmap_error *err)
{
    static const char joint[] = " or ";
    size_t n = sizeof "all", at = 0;
    if (self->n_test > 1)
        qsort(self->test, self->n_test, sizeof *self->test, by_place);
    for (size_t i = 0; i < self->n_test; i++)
        n += strlen(self->criterion->node[self->test[i]].registrations.chooses) + sizeof joint;
    self->text = rmap_alloc(n, 1);
    if (!self->text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the registrations that count");
    if (self->n_test == 0)
        (void)snprintf(self->text, n, "all");
    for (size_t i = 0; i < self->n_test; i++)
        at += (size_t)snprintf(self->text + at, n - at, "%s%s", i > 0 ? joint : "",
                               self->criterion->node[self->test[i]].registrations.chooses);
    return RMAP_OK;
}

static bool is_taken(const struct rmap_which *self, int32_t node)
{
    for (size_t i = 0; i < self->n_test; i++)
        if (self->test[i] == node)
            return true;
    return false;
}

static enum rmap_status write_remark(struct rmap_which *self,
                                     const struct rmap_criterion_node *node, struct rmap_error *err)
{
    char *bytes = NULL;
    size_t nbytes = 0;
    FILE *out = open_memstream(&bytes, &nbytes);
    if (out) {
        fprintf(out, "%.*s chooses rays, %s; to choose registrations: --which '%s'",
                (int)(node->end - node->begin), self->criterion->text + node->begin,
                self->n_test > 0 ? "not which of their registrations are counted"
                                 : "all whose registrations are counted",
                node->registrations.chooses);
        if (fclose(out) == 0)
            self->remark = rmap_strdup(bytes);
    }
    free(bytes);
    return self->remark ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a remark");
}

/* A test of these detectors with a region, a condition or a number that chooses rays alone. */
static enum rmap_status find_remark(struct rmap_which *self, const struct rmap_index_set *detector,
                                    struct rmap_error *err)
{
    const struct rmap_criterion *criterion = self->criterion;
    for (size_t i = 0; i < criterion->n_node; i++) {
        const struct rmap_criterion_node *node = &criterion->node[i];
        const struct rmap_registration_test *test = &node->registrations;
        if (node->kind == RMAP_CRITERION_REGISTRATIONS && test->chooses &&
            !is_taken(self, (int32_t)i) &&
            sets_meet(&test->detector, detector, self->scene->n_detector))
            return write_remark(self, node, err);
    }
    return RMAP_OK;
}

static enum rmap_status allocate(const struct rmap_scene *scene, struct rmap_which **which_ret,
                                 struct rmap_error *err)
{
    struct rmap_which *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->scene = scene;
        self->chosen_on = rmap_alloc(scene->n_detector + 1, 1);
        self->asked_on = rmap_alloc(scene->n_detector + 1, 1);
    }
    if (self && self->chosen_on && self->asked_on) {
        *which_ret = self;
        return RMAP_OK;
    }
    rmap_which_destroy(self);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the registrations that count");
}

enum rmap_status rmap_which_create(const struct rmap_scene *scene,
                                   const struct rmap_index_set *detector, const char *text,
                                   const struct rmap_criteria *criteria,
                                   const struct rmap_criterion *criterion,
                                   struct rmap_which **which_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_which *self = NULL;
    RMAP_TRY(allocate(scene, &self, err));
    self->criterion = criterion;
    self->from = text ? RMAP_WHICH_OPTION : RMAP_WHICH_ALL;
    if (text) {
        RMAP_TRY(rmap_criterion_compile_which(text, criteria, scene, detector, &self->own, err));
        self->criterion = self->own;
        RMAP_TRY(add_test(self, self->own->root, err));
    } else if (criterion) {
        RMAP_TRY(take_conjuncts(self, detector, criterion->root, err));
        self->from = self->n_test > 0 ? RMAP_WHICH_WHERE : RMAP_WHICH_ALL;
        RMAP_TRY(find_remark(self, detector, err));
    }
    RMAP_TRY(write_text(self, err));
    if (self->chooses)
        self->columns |= always;
    *which_ret = self;
    self = NULL;
out:
    rmap_which_destroy(self);
    return st;
}

enum rmap_status rmap_which_create_any(const struct rmap_scene *scene,
                                       const struct rmap_index_set *detector,
                                       const struct rmap_criterion *const *criterion, size_t n,
                                       const double *flux_per_weight, struct rmap_which **which_ret,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_which *self = NULL;
    RMAP_TRY(allocate(scene, &self, err));
    self->from = RMAP_WHICH_WHERE;
    self->rays = criterion;
    self->flux_per_weight = flux_per_weight;
    self->columns = always;
    self->text = rmap_strdup("of each criterion");
    self->of = rmap_alloc(n + 1, sizeof(struct rmap_which *));
    if (!self->of || !self->text)
        RMAP_TRY(
            rmap_error_set(err, RMAP_SYSTEM, "out of memory for the registrations that count"));
    for (; self->n_of < n; self->n_of++) {
        struct rmap_which **own = &self->of[self->n_of];
        RMAP_TRY(rmap_which_create(scene, detector, NULL, NULL, criterion[self->n_of], own, err));
        self->chooses |= (*own)->chooses;
        self->columns |= (*own)->columns | rmap_criterion_columns(criterion[self->n_of]);
    }
    *which_ret = self;
    self = NULL;
out:
    rmap_which_destroy(self);
    return st;
}

enum rmap_status rmap_which_create_with(const struct rmap_which *a, const struct rmap_which *b,
                                        bool b_counts, struct rmap_which **which_ret,
                                        struct rmap_error *err)
{
    struct rmap_which *self = NULL;
    enum rmap_status st = allocate(a->scene, &self, err);
    if (st != RMAP_OK)
        return st;
    self->both[0] = a;
    self->both[1] = b;
    self->second_counts = b_counts;
    self->from = a->from;
    self->columns = always | a->columns | b->columns;
    self->chooses = true;
    self->text = rmap_strdup(a->text);
    if (self->text)
        *which_ret = self;
    else
        rmap_which_destroy(self);
    return *which_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a choice");
}

void rmap_which_destroy(struct rmap_which *self)
{
    if (!self)
        return;
    for (size_t k = 0; k < self->n_of; k++)
        rmap_which_destroy(self->of[k]);
    rmap_free(self->of);
    rmap_criterion_destroy(self->own);
    rmap_free(self->text);
    rmap_free(self->test);
    rmap_free(self->chosen_on);
    rmap_free(self->asked_on);
    rmap_free(self->remark);
    rmap_free(self);
}

/* Bits of rows, for a test. */
struct bits {
    uint64_t *may, *sure; /* one word more than they take */
};

/* Adds the registrations that one test chooses. columns: that there are; open: [n] those that it
 * may choose, or NULL where all columns are there. */
static void mark_test(const struct rmap_which *self, int32_t index,
                      const struct rmap_portion *portion, rmap_column_set columns,
                      const struct bits *bits, uint8_t *chosen, uint8_t *open)
{
    static const uint8_t marked = 1;
    const struct rmap_registration_test *test = &self->criterion->node[index].registrations;
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION];
    const bool is_told = test->where < 0; /* by the registration itself */
    uint8_t flag[STRIP_ROWS];
    for (struct rmap_strip strip = {0}; strip.first < n; strip.first += strip.n) {
        strip.n = n - strip.first < STRIP_ROWS ? n - strip.first : STRIP_ROWS;
        rmap_registrations_mark(self->criterion, test, portion, &strip, flag);
        const size_t n_flag = strip.n;
        if (!is_told)
            rmap_bytes_among(flag, n_flag, &marked, 1, bits->may + strip.first / 64);
        else
            for (size_t i = 0; i < n_flag; i++)
                chosen[strip.first + i] |= flag[i];
    }
    if (is_told)
        return;
    rmap_where_keep(self->criterion, test->where, columns, portion, n, bits->may, bits->sure);
    for (size_t i = 0; i < n; i++)
        chosen[i] |= (uint8_t)(bits->sure[i / 64] >> i % 64 & 1);
    for (size_t i = 0; open && i < n; i++)
        open[i] |= (uint8_t)(bits->may[i / 64] >> i % 64 & 1);
}

/* open: NULL where all columns are there. */
static enum rmap_status mark_tests(const struct rmap_which *self,
                                   const struct rmap_portion *portion, rmap_column_set columns,
                                   uint8_t *chosen, uint8_t *open, struct rmap_error *err)
{
    const struct rmap_registration_columns *seen = &portion->registration;
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION], n_word = n / 64 + 2;
    uint64_t *word = rmap_alloc(2 * n_word, sizeof *word);
    const struct bits bits = {word, word + n_word};
    if (!word)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu registrations", n);
    const int32_t *detector = seen->detector;
    const uint8_t *registered = seen->registered, *chosen_on = self->chosen_on;
    const size_t n_detector = self->scene->n_detector; /* the last of which is followed by a 0 */
    for (size_t i = 0; i < n; i++) {
        const size_t d = (size_t)detector[i] < n_detector ? (size_t)detector[i] : n_detector;
        chosen[i] = (registered[i] != 0) & !chosen_on[d];
    }
    for (size_t i = 0; i < self->n_test; i++)
        mark_test(self, self->test[i], portion, columns, &bits, chosen, open);
    for (size_t i = 0; open && i < n; i++)
        open[i] &= !chosen[i];
    rmap_free(word);
    return RMAP_OK;
}

bool rmap_which_may_be_bound(const struct rmap_which *self)
{
    return self->n_test > 0 && self->n_of == 0 && !self->both[0] && !self->detects;
}

enum rmap_status rmap_which_bound(const struct rmap_which *self, const struct rmap_portion *portion,
                                  rmap_column_set columns, uint8_t *chosen, uint8_t *open,
                                  struct rmap_error *err)
{
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION];
    if (n == 0)
        return RMAP_OK;
    memset(open, 0, n);
    return mark_tests(self, portion, columns, chosen, open, err);
}

/* Registrations that the k-th criterion has count, of the rays that match it. */
static enum rmap_status mark_one(const struct rmap_which *self, size_t k,
                                 const struct rmap_portion *portion, uint8_t *match, uint8_t *own,
                                 uint8_t *chosen, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_criterion_evaluate(self->rays[k], portion, self->flux_per_weight, match, err));
    RMAP_TRY(rmap_which_mark(self->of[k], portion, own, err));
    for (size_t i = 0, row = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++)
        for (const size_t end = row + portion->ray.registration_count[i]; row < end; row++)
            chosen[row] |= own[row] & match[i];
out:
    return st;
}

static enum rmap_status mark_any(const struct rmap_which *self, const struct rmap_portion *portion,
                                 uint8_t *chosen, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION];
    uint8_t *match = rmap_alloc(portion->n_row[RMAP_TABLE_RAY] + 1, 1), *own = rmap_alloc(n, 1);
    if (!match || !own)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu registrations", n));
    memset(chosen, 0, n);
    for (size_t k = 0; k < self->n_of; k++)
        RMAP_TRY(mark_one(self, k, portion, match, own, chosen, err));
out:
    rmap_free(match);
    rmap_free(own);
    return st;
}

static enum rmap_status mark_both(const struct rmap_which *self, const struct rmap_portion *portion,
                                  uint8_t *chosen, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = portion->n_row[RMAP_TABLE_REGISTRATION];
    uint8_t *second = rmap_alloc(n, 1);
    if (!second)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu registrations", n);
    RMAP_TRY(rmap_which_mark(self->both[0], portion, chosen, err));
    RMAP_TRY(rmap_which_mark(self->both[1], portion, second, err));
    for (size_t i = 0; i < n; i++)
        chosen[i] &= second[i] == self->second_counts;
out:
    rmap_free(second);
    return st;
}

enum rmap_status rmap_which_detect(struct rmap_which *self, const struct rmap_index_set *detector,
                                   struct rmap_error *err)
{
    static const char behind[] = " and detected";
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < self->n_of; k++) {
        RMAP_TRY(rmap_which_detect(self->of[k], detector, err));
        self->chooses |= self->of[k]->chooses;
        self->columns |= self->of[k]->columns;
    }
    for (size_t d = 0; self->n_of == 0 && d < self->scene->n_detector; d++)
        self->detects |= rmap_index_set_has(detector, (int32_t)d) &&
                         rmap_detector_chances(&self->scene->detector[d]);
    if (!self->detects)
        return RMAP_OK;
    RMAP_TRY(rmap_check_channels(self->scene, RMAP_RESPONSE_COLUMNS, err));
    const size_t n = strlen(self->text) + sizeof behind;
    char *text = rmap_alloc(n, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the registrations that count");
    (void)snprintf(text, n, "%s%s", self->chooses ? self->text : "",
                   behind + (self->chooses ? 0 : sizeof " and"));
    rmap_free(self->text);
    self->text = text;
    self->chooses = true;
    self->columns |= always | RMAP_RESPONSE_COLUMNS;
out:
    return st;
}

static void keep_detected(const struct rmap_which *self, const struct rmap_portion *portion,
                          uint8_t *chosen)
{
    struct rmap_registration_place at = {0, 0, 0};
    for (; at.ray < portion->n_row[RMAP_TABLE_RAY]; at.ray++) {
        for (const size_t end = at.row + portion->ray.registration_count[at.ray]; at.row < end;
             at.row++)
            if (chosen[at.row])
                chosen[at.row] = rmap_registration_detected(self->scene, portion, &at);
        at.first_segment += portion->ray.segment_count[at.ray];
    }
}

enum rmap_status rmap_which_mark(const struct rmap_which *self, const struct rmap_portion *portion,
                                 uint8_t *chosen, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (portion->n_row[RMAP_TABLE_REGISTRATION] == 0)
        return RMAP_OK;
    st = self->both[0]    ? mark_both(self, portion, chosen, err)
         : self->n_of > 0 ? mark_any(self, portion, chosen, err)
                          : mark_tests(self, portion, RMAP_COLUMNS_ALL, chosen, NULL, err);
    if (st == RMAP_OK && self->detects)
        keep_detected(self, portion, chosen);
    return st;
}

json_t *rmap_which_json(const struct rmap_which *self)
{
    static const char *const from[] = {"option", "where", "all"};
    return json_pack("{s:s, s:s}", "text", self ? self->text : "all", "from",
                     from[self ? self->from : RMAP_WHICH_ALL]);
}

void rmap_which_caption(const struct rmap_which *self, const char *criterion, char *line,
                        size_t nbytes)
{
    (void)snprintf(line, nbytes, "rays: %s%s%s", criterion ? criterion : "all",
                   rmap_which_chooses(self) ? "; registrations: " : "",
                   rmap_which_chooses(self) ? self->text : "");
}

void rmap_which_print(const struct rmap_which *self, FILE *out)
{
    if (rmap_which_chooses(self))
        fprintf(out, "%-14s %s\n", "which", self->text);
}

void rmap_which_csv(const struct rmap_which *self, FILE *out)
{
    if (rmap_which_chooses(self))
        fprintf(out, "# which: %s\n", self->text);
}

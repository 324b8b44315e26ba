/* SPDX-License-Identifier: MIT
 *
 * Tests of single steps and registrations put to their classes, once for each piece.
 */
#include "analysis/query/class_tests.h"

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/path_mark.h"
#include "base/alloc.h"

/* What a test says of the classes of the piece in hand. */
struct answer {
    void *of_class;
    size_t cap;     /* bytes */
    uint64_t stamp; /* of the piece it was made for */
};

struct rmap_class_tests {
    const struct rmap_criterion *const *criterion;
    size_t n_criterion;
    struct answer *answer; /* [first_node[n_criterion]] per node of all criteria */
    size_t *first_node;    /* [n_criterion + 1] */

    /* Classes of the piece in hand, as rows of one ray. */
    uint64_t stamp;
    const struct rmap_step_class *class;
    struct rmap_portion classes; /* columns borrowed from the arrays below */
    uint32_t n_segment, n_registration;
    int32_t *object, *detector;
    uint32_t *event;
    int16_t *medium;
    uint8_t *registered;
    size_t object_cap, event_cap, medium_cap, detector_cap, registered_cap;
};

enum rmap_status rmap_class_tests_create(const struct rmap_criterion *const *criterion,
                                         size_t n_criterion, struct rmap_class_tests **tests_ret,
                                         struct rmap_error *err)
{
    struct rmap_class_tests *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    self->criterion = criterion;
    self->n_criterion = n_criterion;
    self->first_node = rmap_alloc(n_criterion + 1, sizeof *self->first_node);
    for (size_t c = 0; self->first_node && c < n_criterion; c++)
        self->first_node[c + 1] = self->first_node[c] + criterion[c]->n_node;
    if (self->first_node)
        self->answer = rmap_alloc(self->first_node[n_criterion], sizeof *self->answer);
    if (!self->answer) {
        rmap_class_tests_destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    }
    *tests_ret = self;
    return RMAP_OK;
}

void rmap_class_tests_destroy(struct rmap_class_tests *self)
{
    if (!self)
        return;
    for (size_t i = 0; self->answer && i < self->first_node[self->n_criterion]; i++)
        rmap_free(self->answer[i].of_class);
    rmap_free(self->answer);
    rmap_free(self->first_node);
    rmap_free(self->object);
    rmap_free(self->event);
    rmap_free(self->medium);
    rmap_free(self->detector);
    rmap_free(self->registered);
    rmap_free(self);
}

static enum rmap_status reserve(struct rmap_class_tests *self, size_t n_class, size_t n_hit,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    st = RMAP_RESERVE(self->object, self->object_cap, n_class, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->event, self->event_cap, n_class, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->medium, self->medium_cap, n_class, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->detector, self->detector_cap, n_hit, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->registered, self->registered_cap, n_hit, err);
    return st;
}

enum rmap_status rmap_class_tests_enter(struct rmap_class_tests *self,
                                        const struct rmap_step_class *step, size_t n_class,
                                        const struct rmap_history_hit *hit, size_t n_hit,
                                        struct rmap_error *err)
{
    enum rmap_status st = reserve(self, n_class, n_hit, err);
    if (st != RMAP_OK)
        return st;
    self->stamp++;
    self->class = step;
    for (size_t i = 0; i < n_class; i++) {
        self->object[i] = self->class[i].object;
        self->event[i] = self->class[i].event;
        self->medium[i] = (int16_t)self->class[i].medium;
    }
    for (size_t i = 0; i < n_hit; i++) {
        self->detector[i] = hit[i].detector;
        self->registered[i] = (uint8_t)hit[i].registered;
    }
    self->n_segment = (uint32_t)n_class;
    self->n_registration = (uint32_t)n_hit;
    self->classes = (struct rmap_portion){
        .n_row = {1, n_class, n_hit},
        .ray.segment_count = &self->n_segment,
        .ray.registration_count = &self->n_registration,
        .segment = {.object = self->object, .event = self->event, .medium = self->medium},
        .registration = {.detector = self->detector, .registered = self->registered}};
    return RMAP_OK;
}

/* A test put to every class. */
static void ask(const struct rmap_class_tests *self, size_t c,
                const struct rmap_criterion_node *node, void *of_class)
{
    const struct rmap_criterion *criterion = self->criterion[c];
    uint8_t *pass = of_class;
    uint16_t *symbol = of_class;
    const struct rmap_strip segments = {.n = self->n_segment};
    const struct rmap_strip registrations = {.n = self->n_registration};
    if (node->kind == RMAP_CRITERION_STEPS && segments.n > 0)
        rmap_steps_mark(criterion, &node->steps, &self->classes, &segments, pass);
    else if (node->kind == RMAP_CRITERION_REGISTRATIONS && registrations.n > 0)
        rmap_registrations_mark(criterion, &node->registrations, &self->classes, &registrations,
                                pass);
    for (size_t i = 0; node->kind == RMAP_CRITERION_ENDED && i < self->n_segment; i++)
        pass[i] = self->object[i] >= 0 ? rmap_index_set_has(&node->ending.object, self->object[i])
                                       : rmap_index_set_has(&node->ending.medium, self->medium[i]);
    for (size_t i = 0; node->kind == RMAP_CRITERION_PATH && i < self->n_segment; i++)
        symbol[i] = rmap_path_symbol(node, self->object[i], self->event[i], self->class[i].medium);
}

enum rmap_status rmap_class_tests_answer(struct rmap_class_tests *self, size_t c, int32_t index,
                                         const struct rmap_criterion_node *node,
                                         const void **of_class_ret, struct rmap_error *err)
{
    struct answer *known = &self->answer[self->first_node[c] + (size_t)index];
    size_t n = self->n_segment > self->n_registration ? self->n_segment : self->n_registration;
    enum rmap_status st = rmap_reserve(&known->of_class, &known->cap, 2 * n + 2, 1, err);
    if (st == RMAP_OK && known->stamp != self->stamp)
        ask(self, c, node, known->of_class);
    known->stamp = self->stamp;
    *of_class_ret = known->of_class;
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Tests of single steps put to their classes, once for each piece.
 */
#include "analysis/query/class_tests.h"

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/path_table.h"
#include "base/alloc.h"
#include "base/byte_set.h"

/* What a test says of the classes of the piece in hand. */
struct answer {
    uint8_t *pass;    /* [classes] of a test of steps; */
    uint16_t *symbol; /* [classes + 1] of a path, the last for a step of no class in hand */
    size_t pass_cap, symbol_cap;
    uint64_t stamp; /* of the piece it was made for */
};

struct rmap_class_tests {
    const struct rmap_criterion *const *criterion;
    size_t n_criterion;
    struct answer *answer; /* [first_node[n_criterion]] per node of all criteria */
    size_t *first_node;    /* [n_criterion + 1] */

    /* Classes of the piece in hand, as rows of one ray. */
    uint64_t stamp;
    struct rmap_portion classes; /* columns borrowed from the arrays below */
    uint32_t n_segment;
    int32_t *object;
    uint32_t *event;
    int16_t *medium;
    size_t object_cap, event_cap, medium_cap;
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
    for (size_t i = 0; self->answer && i < self->first_node[self->n_criterion]; i++) {
        rmap_free(self->answer[i].pass);
        rmap_free(self->answer[i].symbol);
    }
    rmap_free(self->answer);
    rmap_free(self->first_node);
    rmap_free(self->object);
    rmap_free(self->event);
    rmap_free(self->medium);
    rmap_free(self);
}

enum rmap_status rmap_class_tests_enter(struct rmap_class_tests *self,
                                        const struct rmap_step_class *step, size_t n_class,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(self->object, self->object_cap, n_class, err));
    RMAP_TRY(RMAP_RESERVE(self->event, self->event_cap, n_class, err));
    RMAP_TRY(RMAP_RESERVE(self->medium, self->medium_cap, n_class, err));
    self->stamp++;
    for (size_t i = 0; i < n_class; i++) {
        self->object[i] = step[i].object;
        self->event[i] = step[i].event;
        self->medium[i] = (int16_t)step[i].medium;
    }
    self->n_segment = (uint32_t)n_class;
    self->classes = (struct rmap_portion){
        .n_row = {1, n_class},
        .ray.segment_count = &self->n_segment,
        .segment = {.object = self->object, .event = self->event, .medium = self->medium}};
out:
    return st;
}

enum rmap_status rmap_class_tests_mark(struct rmap_class_tests *self, size_t c, int32_t index,
                                       const struct rmap_criterion_node *node,
                                       const struct rmap_own_steps *steps, size_t n, uint64_t *bits,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct answer *known = &self->answer[self->first_node[c] + (size_t)index];
    const struct rmap_strip segments = {.n = self->n_segment};
    RMAP_TRY(RMAP_RESERVE(known->pass, known->pass_cap, segments.n + 1, err));
    if (known->stamp != self->stamp && segments.n > 0)
        rmap_steps_mark(self->criterion[c], &node->steps, &self->classes, &segments, known->pass);
    known->stamp = self->stamp;
    const size_t n_class = self->n_segment;
    const uint8_t *pass = known->pass;
    const uint32_t *class = steps->class;
    bits[rmap_bit_words(n)] = 0;
    if (steps->codes.n_code > 0)
        rmap_step_codes_mark(&steps->codes, pass, n_class, bits);
    for (size_t i = 0; steps->codes.n_code == 0 && i < n; i += 64) {
        const size_t end = n - i < 64 ? n - i : 64;
        uint64_t word = 0;
        for (size_t k = 0; k < end; k++)
            word |= (uint64_t)(class[i + k] < n_class && pass[class[i + k]]) << k;
        bits[i / 64] = word;
    }
out:
    return st;
}

enum rmap_status rmap_class_tests_symbols(struct rmap_class_tests *self, size_t c, int32_t index,
                                          const struct rmap_criterion_node *node,
                                          const struct rmap_own_steps *steps, size_t n,
                                          uint16_t *symbol, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct answer *known = &self->answer[self->first_node[c] + (size_t)index];
    const size_t n_class = self->n_segment;
    int32_t object = -1;
    uint32_t event = 0;
    int16_t medium = 0;
    const struct rmap_segment_columns none = {
        .object = &object, .event = &event, .medium = &medium};
    RMAP_TRY(RMAP_RESERVE(known->symbol, known->symbol_cap, n_class + 1, err));
    if (known->stamp != self->stamp) {
        rmap_path_symbols(node->path.table, &self->classes.segment, 0, n_class, known->symbol);
        known->symbol[n_class] = rmap_path_row_symbol(node->path.table, &none, 0);
    }
    known->stamp = self->stamp;
    if (steps->codes.n_code > 0)
        rmap_step_codes_look_up(&steps->codes, known->symbol, n_class, symbol);
    for (size_t i = 0; steps->codes.n_code == 0 && i < n; i++)
        symbol[i] = known->symbol[steps->class[i] < n_class ? steps->class[i] : n_class];
out:
    return st;
}

/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_pack.h"

#include <string.h>

#include "base/alloc.h"

/* What a state is as bytes: this, weights [2][n_source], classes, cells, steps
 * and the sketch. */
struct head {
    uint64_t rays, segments, again_rays, again_segments, n_class, n_cell;
    double most_weight;
    uint64_t is_full, cells_full, has_sketch;
    uint64_t n_with_steps, n_step_word, n_first_step, steps_closed, steps_full;
};

static uint8_t *put(uint8_t *to, const void *from, size_t nbytes)
{
    if (nbytes > 0)
        memcpy(to, from, nbytes);
    return to + nbytes;
}

static uint8_t *put_classes(uint8_t *to, const struct rmap_class_sums *classes)
{
    for (size_t i = 0; i < classes->n; i++) {
        const struct rmap_class_sum sum = rmap_class_sums_at(classes, i);
        to = put(to, &sum, sizeof sum);
    }
    return to;
}

static uint8_t *put_sums(uint8_t *to, const struct rmap_key_sums *sums)
{
    for (size_t i = 0; i < sums->n; i++)
        to = put(to, &sums->entry[i], sizeof(struct rmap_key_sum));
    return to;
}

static size_t state_nbytes(const struct head *head, size_t n_source)
{
    return sizeof *head + 2 * n_source * sizeof(double) +
           (size_t)head->n_class * sizeof(struct rmap_class_sum) +
           (size_t)head->n_cell * sizeof(struct rmap_key_sum) +
           (size_t)head->n_step_word * sizeof(uint32_t) +
           (head->has_sketch ? RMAP_PATH_SKETCH_NBYTES : 0);
}

enum rmap_status rmap_path_counts_pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                                       struct rmap_error *err)
{
    const struct rmap_path_counts *self = state;
    const size_t n_source = rmap_map_scene(self->context->map)->n_source;
    const struct head head = {.rays = self->total.rays,
                              .segments = self->total.segments,
                              .again_rays = self->again.rays,
                              .again_segments = self->again.segments,
                              .n_class = self->tally.classes.n,
                              .n_cell = self->cells.n,
                              .most_weight = self->most_weight,
                              .is_full = self->is_full,
                              .cells_full = self->cells_full,
                              .has_sketch = self->sketch.rays != NULL,
                              .n_with_steps = self->tally.steps.n,
                              .n_step_word = self->tally.steps.n_word,
                              .n_first_step = self->tally.steps.n_first,
                              .steps_closed = self->tally.steps.is_closed,
                              .steps_full = self->tally.steps.is_full};
    const size_t nbytes = state_nbytes(&head, n_source);
    uint8_t *bytes = rmap_alloc(nbytes, 1), *at = bytes;
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a rank");
    at = put(at, &head, sizeof head);
    at = put(at, self->total.source_weight, n_source * sizeof(double));
    at = put(at, self->total.source_weight_squared, n_source * sizeof(double));
    at = put_classes(at, &self->tally.classes);
    at = put_sums(at, &self->cells);
    at = put(at, self->tally.steps.word, (size_t)head.n_step_word * sizeof *self->tally.steps.word);
    if (head.has_sketch)
        (void)put(at, self->sketch.rays, RMAP_PATH_SKETCH_NBYTES);
    *bytes_ret = bytes;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

static enum rmap_status take_classes(struct rmap_class_sums *classes, const uint8_t **at,
                                     uint64_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (uint64_t i = 0; i < n; i++) {
        struct rmap_class_sum sum;
        size_t index;
        uint64_t before;
        memcpy(&sum, *at, sizeof sum);
        *at += sizeof sum;
        RMAP_TRY(rmap_class_sums_add(classes, &sum, &index, &before, err));
    }
out:
    return st;
}

static enum rmap_status take_sums(struct rmap_key_sums *sums, const uint8_t **at, uint64_t n,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (uint64_t i = 0; i < n; i++) {
        struct rmap_key_sum sum, *entry = NULL;
        memcpy(&sum, *at, sizeof sum);
        *at += sizeof sum;
        RMAP_TRY(rmap_key_sums_enter(sums, sum.key, &entry, err));
        if (entry)
            *entry = sum;
    }
out:
    return st;
}

static enum rmap_status take_steps(struct rmap_path_steps *steps, const uint8_t **at,
                                   const struct head *head, struct rmap_error *err)
{
    const size_t nbytes = (size_t)head->n_step_word * sizeof *steps->word;
    steps->is_closed = head->steps_closed != 0;
    steps->is_full = head->steps_full != 0;
    if (nbytes == 0)
        return RMAP_OK;
    steps->word = rmap_alloc_unset((size_t)head->n_step_word, sizeof *steps->word);
    if (!steps->word)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the paths of a rank");
    memcpy(steps->word, *at, nbytes);
    steps->n_word = (size_t)head->n_step_word;
    steps->n = (size_t)head->n_with_steps;
    steps->n_first = (size_t)head->n_first_step;
    *at += nbytes;
    return RMAP_OK;
}

enum rmap_status rmap_path_counts_unpack(const void *context_, const uint8_t *bytes, size_t nbytes,
                                         void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = context_;
    const size_t n_source = rmap_map_scene(context->map)->n_source;
    struct head head = {0};
    struct rmap_path_counts *self = NULL;
    void *state = NULL;
    if (nbytes >= sizeof head)
        memcpy(&head, bytes, sizeof head);
    if (nbytes < sizeof head || nbytes != state_nbytes(&head, n_source))
        return rmap_error_set(err, RMAP_INTERNAL, "paths of a rank: %zu bytes came", nbytes);
    RMAP_TRY(rmap_path_count_kind.create(context, &state, err));
    self = state;
    self->pool = NULL;
    self->total.rays = head.rays;
    self->total.segments = head.segments;
    self->again.rays = head.again_rays;
    self->again.segments = head.again_segments;
    self->most_weight = head.most_weight;
    self->is_full = head.is_full != 0;
    self->cells_full = head.cells_full != 0;
    const uint8_t *at = bytes + sizeof head;
    memcpy(self->total.source_weight, at, n_source * sizeof(double));
    at += n_source * sizeof(double);
    memcpy(self->total.source_weight_squared, at, n_source * sizeof(double));
    at += n_source * sizeof(double);
    RMAP_TRY(take_classes(&self->tally.classes, &at, head.n_class, err));
    RMAP_TRY(take_sums(&self->cells, &at, head.n_cell, err));
    RMAP_TRY(take_steps(&self->tally.steps, &at, &head, err));
    if (head.has_sketch) {
        RMAP_TRY(rmap_path_sketch_init(&self->sketch, err));
        memcpy(self->sketch.rays, at, RMAP_PATH_SKETCH_NBYTES);
    }
    *state_ret = self;
    self = NULL;
out:
    rmap_path_count_kind.destroy(self);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Keeps the whole history of one ray in double precision, for reports and tests.
 */
#include "portion/history.h"

#include <string.h>

#include "base/alloc.h"

/* rmap_reserve through the typed pointer; the first failure is kept. */
static bool reserve(struct rmap_history *history, void **block, size_t *cap, size_t need,
                    size_t size)
{
    if (history->status == RMAP_OK)
        history->status = rmap_reserve(block, cap, need, size, NULL);
    return history->status == RMAP_OK;
}

static bool keep_colour(struct rmap_history *history, size_t row, const double *colour)
{
    size_t n = (size_t)history->n_channel;
    void *block = history->colour;
    bool kept = reserve(history, &block, &history->colour_cap, (row + 1) * n, sizeof *colour);
    history->colour = block;
    if (kept)
        memcpy(history->colour + row * n, colour, n * sizeof *colour);
    return kept;
}

static void emit(struct rmap_recorder *self, const struct rmap_emission *emission)
{
    struct rmap_history *history = (struct rmap_history *)self;
    history->status = RMAP_OK;
    history->n_step = history->n_registration = history->n_curve = 0;
    history->emission = *emission;
    history->emission.colour = NULL;
    (void)keep_colour(history, 0, emission->colour);
}

static void add_step(struct rmap_recorder *self, const struct rmap_step *step)
{
    struct rmap_history *history = (struct rmap_history *)self;
    void *block = history->step;
    bool kept =
        reserve(history, &block, &history->step_cap, history->n_step + 1, sizeof *history->step);
    history->step = block;
    if (!kept || !keep_colour(history, history->n_step + 1, step->colour))
        return;
    history->step[history->n_step] = *step;
    history->step[history->n_step++].colour = NULL;
}

static void add_curve(struct rmap_recorder *self, const struct rmap_curve_point *point)
{
    struct rmap_history *history = (struct rmap_history *)self;
    void *block = history->curve;
    bool kept =
        reserve(history, &block, &history->curve_cap, history->n_curve + 1, sizeof *history->curve);
    history->curve = block;
    if (kept)
        history->curve[history->n_curve++] = *point;
}

static void add_registration(struct rmap_recorder *self,
                             const struct rmap_registration *registration)
{
    struct rmap_history *history = (struct rmap_history *)self;
    void *block = history->registration;
    bool kept = reserve(history, &block, &history->registration_cap, history->n_registration + 1,
                        sizeof *history->registration);
    history->registration = block;
    if (kept)
        history->registration[history->n_registration++] = *registration;
}

static void end(struct rmap_recorder *self, const struct rmap_ending *ending)
{
    struct rmap_history *history = (struct rmap_history *)self;
    history->ending = *ending;
    if (!history->colour)
        return;
    history->emission.colour = history->colour;
    for (size_t i = 0; i < history->n_step; i++)
        history->step[i].colour = history->colour + (i + 1) * (size_t)history->n_channel;
}

void rmap_history_init(struct rmap_history *history, int n_channel)
{
    *history = (struct rmap_history){.base = {.emit = emit,
                                              .step = add_step,
                                              .curve = add_curve,
                                              .registration = add_registration,
                                              .end = end},
                                     .n_channel = n_channel};
}

void rmap_history_fini(struct rmap_history *history)
{
    rmap_free(history->step);
    rmap_free(history->registration);
    rmap_free(history->curve);
    rmap_free(history->colour);
    *history = (struct rmap_history){0};
}

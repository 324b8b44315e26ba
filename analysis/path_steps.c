/* SPDX-License-Identifier: MIT */
#include "analysis/path_steps.h"

#include <string.h>

#include "base/alloc.h"

/* A small block, then a huge page. */
enum { WORDS_FEW = 1 << 12, WORDS_MOST = 1 << 19 };

void rmap_path_steps_fini(struct rmap_path_steps *steps)
{
    rmap_free(steps->word);
    *steps = (struct rmap_path_steps){.is_closed = steps->is_closed};
}

const rmap_path_step *rmap_path_steps_of(const struct rmap_path_steps *steps, size_t class,
                                         size_t *n_ret)
{
    *n_ret = 0;
    if (class >= steps->n)
        return NULL;
    const size_t first = rmap_path_steps_end(steps, class);
    *n_ret = rmap_path_steps_end(steps, class + 1) - first;
    return steps->word + first;
}

static enum rmap_status grow(struct rmap_path_steps *steps, size_t n_word, struct rmap_error *err)
{
    uint32_t *word = rmap_alloc_unset(n_word, sizeof *word);
    if (!word)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    if (steps->n > 0) {
        memcpy(word, steps->word, rmap_path_steps_end(steps, steps->n) * sizeof *word);
        memcpy(word + n_word - steps->n, steps->word + steps->n_word - steps->n,
               steps->n * sizeof *word);
    }
    rmap_free(steps->word);
    steps->word = word;
    steps->n_word = n_word;
    return RMAP_OK;
}

enum rmap_status rmap_path_steps_make_room(struct rmap_path_steps *steps, size_t n,
                                           rmap_path_step **step_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t used = rmap_path_steps_end(steps, steps->n) + steps->n + 1;
    *step_ret = NULL;
    if (used + n > WORDS_MOST) {
        steps->is_closed = true;
        return RMAP_OK;
    }
    if (used + n > steps->n_word)
        st = grow(steps, used + n > WORDS_FEW ? WORDS_MOST : WORDS_FEW, err);
    if (st == RMAP_OK)
        *step_ret = steps->word + rmap_path_steps_end(steps, steps->n);
    return st;
}

void rmap_path_steps_end_class(struct rmap_path_steps *steps, size_t n)
{
    const size_t end = rmap_path_steps_end(steps, steps->n) + n;
    steps->n++;
    steps->word[steps->n_word - steps->n] = (uint32_t)end;
}

enum rmap_status rmap_path_steps_add(struct rmap_path_steps *steps, const rmap_path_step *step,
                                     size_t n, struct rmap_error *err)
{
    rmap_path_step *to;
    enum rmap_status st = rmap_path_steps_make_room(steps, n, &to, err);
    if (!to)
        return st;
    if (n > 0)
        memcpy(to, step, n * sizeof *step);
    rmap_path_steps_end_class(steps, n);
    return RMAP_OK;
}

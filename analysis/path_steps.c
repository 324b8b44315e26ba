/* SPDX-License-Identifier: MIT */
#include "analysis/path_steps.h"

#include <string.h>

#include "base/alloc.h"

enum { WORDS_FIRST = 1 << 12 };

void rmap_path_steps_fini(struct rmap_path_steps *steps)
{
    rmap_free(steps->word);
    *steps = (struct rmap_path_steps){.is_closed = steps->is_closed};
}

/* Two words at the end of the block say of the k-th of the classes its number and its end. */
static size_t number_of(const struct rmap_path_steps *steps, size_t k)
{
    return steps->word[steps->n_word - 2 * k - 1];
}

/* Behind the steps of the first k of them. */
static size_t end_of(const struct rmap_path_steps *steps, size_t k)
{
    return k > 0 ? steps->word[steps->n_word - 2 * k] : 0;
}

const rmap_path_step *rmap_path_steps_of(const struct rmap_path_steps *steps, size_t class,
                                         size_t *n_ret)
{
    size_t low = 0, high = steps->n;
    *n_ret = 0;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (number_of(steps, middle) < class)
            low = middle + 1;
        else
            high = middle;
    }
    if (low == steps->n || number_of(steps, low) != class)
        return NULL;
    *n_ret = end_of(steps, low + 1) - end_of(steps, low);
    return steps->word + end_of(steps, low);
}

static enum rmap_status grow(struct rmap_path_steps *steps, size_t need, struct rmap_error *err)
{
    const size_t n_own = 2 * steps->n;
    size_t n_word = WORDS_FIRST;
    while (n_word < need)
        n_word *= 2;
    uint32_t *word = rmap_alloc_unset(n_word, sizeof *word);
    if (!word)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    if (steps->n > 0) {
        memcpy(word, steps->word, end_of(steps, steps->n) * sizeof *word);
        memcpy(word + n_word - n_own, steps->word + steps->n_word - n_own, n_own * sizeof *word);
    }
    rmap_free(steps->word);
    steps->word = word;
    steps->n_word = n_word;
    return RMAP_OK;
}

enum rmap_status rmap_path_steps_make_room(struct rmap_path_steps *steps, size_t n, size_t most,
                                           rmap_path_step **step_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t end = end_of(steps, steps->n), used = end + 2 * (steps->n + 1);
    *step_ret = NULL;
    if (n > most || used > most - n)
        return RMAP_OK;
    if (used + n > steps->n_word)
        st = grow(steps, used + n, err);
    if (st == RMAP_OK)
        *step_ret = steps->word + end;
    return st;
}

void rmap_path_steps_end_class(struct rmap_path_steps *steps, size_t class, size_t n)
{
    const size_t end = end_of(steps, steps->n) + n;
    steps->n++;
    steps->word[steps->n_word - 2 * steps->n + 1] = (uint32_t) class;
    steps->word[steps->n_word - 2 * steps->n] = (uint32_t)end;
}

enum rmap_status rmap_path_steps_add(struct rmap_path_steps *steps, size_t class,
                                     const rmap_path_step *step, size_t n, struct rmap_error *err)
{
    rmap_path_step *to;
    enum rmap_status st = rmap_path_steps_make_room(steps, n, RMAP_PATH_STEPS_MOST, &to, err);
    if (!to)
        return st;
    if (n > 0)
        memcpy(to, step, n * sizeof *step);
    rmap_path_steps_end_class(steps, class, n);
    return RMAP_OK;
}

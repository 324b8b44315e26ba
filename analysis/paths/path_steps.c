/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_steps.h"

#include <string.h>

#include "base/alloc.h"

enum { WORDS_FIRST = 1 << 12 };

void rmap_path_steps_fini(struct rmap_path_steps *steps)
{
    rmap_free(steps->word);
    *steps = (struct rmap_path_steps){.is_closed = steps->is_closed, .is_full = steps->is_full};
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

enum rmap_status rmap_path_steps_index(const struct rmap_path_steps *steps, size_t n_class,
                                       uint32_t **of_class_ret, struct rmap_error *err)
{
    uint32_t *of_class = rmap_alloc(n_class + 1, sizeof *of_class);
    if (!of_class)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    for (size_t k = 0; k < steps->n; k++)
        of_class[number_of(steps, k)] = (uint32_t)(k + 1);
    *of_class_ret = of_class;
    return RMAP_OK;
}

const rmap_path_step *rmap_path_steps_at(const struct rmap_path_steps *steps, uint32_t number,
                                         size_t *n_ret)
{
    *n_ret = 0;
    if (number == 0)
        return NULL;
    *n_ret = end_of(steps, number) - end_of(steps, number - 1);
    return steps->word + end_of(steps, number - 1);
}

void rmap_path_steps_find(const struct rmap_path_steps *steps, const size_t *class, size_t n,
                          uint32_t *number)
{
    uint64_t some[16] = {0}; /* by ten bits of its number: whether a class may be wanted */
    for (size_t i = 0; i < n; i++) {
        some[class[i] >> 6 & 15] |= UINT64_C(1) << (class[i] & 63);
        number[i] = 0;
    }
    for (size_t k = 0; n > 0 && k < steps->n; k++) {
        const size_t its = number_of(steps, k);
        for (size_t i = 0; some[its >> 6 & 15] >> (its & 63) & 1 && i < n; i++)
            number[i] = class[i] == its ? (uint32_t)(k + 1) : number[i];
    }
}

static enum rmap_status grow(struct rmap_path_steps *steps, size_t need, struct rmap_error *err)
{
    const size_t n_own = 2 * steps->n;
    size_t n_word = WORDS_FIRST;
    while (n_word < need && n_word < RMAP_PATH_STEPS_SCANNED)
        n_word *= 2;
    if (n_word < need)
        n_word = RMAP_PATH_STEPS_MOST; /* a huge page */
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

static enum rmap_status make_room(struct rmap_path_steps *steps, size_t n, size_t most,
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

enum rmap_status rmap_path_steps_make_room(struct rmap_path_steps *steps, size_t n, uint64_t after,
                                           rmap_path_step **step_ret, struct rmap_error *err)
{
    const bool first = after < 2;
    enum rmap_status st =
        make_room(steps, n, first ? RMAP_PATH_STEPS_FIRST : RMAP_PATH_STEPS_SCANNED, step_ret, err);
    steps->is_closed |= !*step_ret;
    steps->is_full |= !*step_ret && !first;
    return st;
}

void rmap_path_steps_end_class(struct rmap_path_steps *steps, size_t class, size_t n)
{
    const size_t end = end_of(steps, steps->n) + n;
    steps->n++;
    steps->n_first += class == steps->n_first;
    steps->word[steps->n_word - 2 * steps->n + 1] = (uint32_t) class;
    steps->word[steps->n_word - 2 * steps->n] = (uint32_t)end;
}

enum rmap_status rmap_path_steps_add(struct rmap_path_steps *steps, size_t class,
                                     const rmap_path_step *step, size_t n, struct rmap_error *err)
{
    rmap_path_step *to;
    enum rmap_status st = make_room(steps, n, RMAP_PATH_STEPS_MOST, &to, err);
    if (!to)
        return st;
    if (n > 0)
        memcpy(to, step, n * sizeof *step);
    rmap_path_steps_end_class(steps, class, n);
    return RMAP_OK;
}

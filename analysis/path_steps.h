/* SPDX-License-Identifier: MIT
 *
 * The steps of classes, as long as they are few: what is shown then need not be read again.
 */
#ifndef RMAP_PATH_STEPS_H
#define RMAP_PATH_STEPS_H

#include "analysis/path_key.h"

/* Those of classes 0 to n - 1, in the order in which they came. All zero is empty. */
struct rmap_path_steps {
    uint32_t
        *word; /* [n_word] steps one behind the other; from the end on, where each class's end */
    size_t n_word, n;
    bool is_closed; /* no more are taken */
};
void rmap_path_steps_fini(struct rmap_path_steps *steps);

/* Behind the steps of the first n classes. */
static inline size_t rmap_path_steps_end(const struct rmap_path_steps *steps, size_t n)
{
    return n > 0 ? steps->word[steps->n_word - n] : 0;
}

/* Those of a class; *n_ret 0: it has none, or they are not there. */
const rmap_path_step *rmap_path_steps_of(const struct rmap_path_steps *steps, size_t class,
                                         size_t *n_ret);

/* Room for the next class's steps, of which there are at most n: NULL when they are too many, which
 * closes them. RMAP_SYSTEM. */
enum rmap_status rmap_path_steps_make_room(struct rmap_path_steps *steps, size_t n,
                                           rmap_path_step **step_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* n steps of the next class stand in the room. */
void rmap_path_steps_end_class(struct rmap_path_steps *steps, size_t n);

/* Both. */
enum rmap_status rmap_path_steps_add(struct rmap_path_steps *steps, const rmap_path_step *step,
                                     size_t n, struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * The steps of classes, as long as they are few: what is shown then need not be read again.
 */
#ifndef RMAP_PATH_STEPS_H
#define RMAP_PATH_STEPS_H

#include "analysis/paths/path_key.h"

/* Words that a thread's steps of the classes that come first may take, those of all that it keeps,
 * and those of all threads. */
enum {
    RMAP_PATH_STEPS_FIRST = 1 << 14,
    RMAP_PATH_STEPS_SCANNED = 1 << 15,
    RMAP_PATH_STEPS_MOST = 1 << 19
};

/* Those of the classes that come first, of one ray or more; then those of classes that a second ray
 * has taken: what is shown is mostly among these. All zero is empty. */
struct rmap_path_steps {
    uint32_t *word;   /* [n_word] steps one behind the other; from the end on, of each class its
                         number and where its steps end */
    size_t n_word, n; /* n: classes */
    size_t n_first;   /* classes below this number are there */
    bool is_closed;   /* no more are kept of one ray; */
    bool is_full;     /* of any */
};
void rmap_path_steps_fini(struct rmap_path_steps *steps);

/* Whether those of a class are to be kept now that it has `after` rays, and had `before`. */
static inline bool rmap_path_steps_want(const struct rmap_path_steps *steps, size_t class,
                                        uint64_t before, uint64_t after)
{
    return before < 2 && class >= steps->n_first &&
           (after >= 2 ? !steps->is_full : !steps->is_closed);
}

/* A thread's room for at most n steps of one more class of `after` rays: NULL when there is none,
 * nor will be. RMAP_SYSTEM. */
enum rmap_status rmap_path_steps_make_room(struct rmap_path_steps *steps, size_t n, uint64_t after,
                                           rmap_path_step **step_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* n steps of the class stand in the room. */
void rmap_path_steps_end_class(struct rmap_path_steps *steps, size_t class, size_t n);

/* Takes another thread's over, if they fit. */
enum rmap_status rmap_path_steps_add(struct rmap_path_steps *steps, size_t class,
                                     const rmap_path_step *step, size_t n,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* of_class: [n_class] 1 + number of those kept of the class; 0: none are. rmap_free. */
enum rmap_status rmap_path_steps_index(const struct rmap_path_steps *steps, size_t n_class,
                                       uint32_t **of_class_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* By that number: 0 is NULL. */
const rmap_path_step *rmap_path_steps_at(const struct rmap_path_steps *steps, uint32_t number,
                                         size_t *n_ret);

/* Without the index: number[i] of class[i], of some n classes. */
void rmap_path_steps_find(const struct rmap_path_steps *steps, const size_t *class, size_t n,
                          uint32_t *number);

#endif

/* SPDX-License-Identifier: MIT
 *
 * The steps of classes, as long as they are few: what is shown then need not be read again.
 */
#ifndef RMAP_PATH_STEPS_H
#define RMAP_PATH_STEPS_H

#include "analysis/path_key.h"

/* Room that a thread takes while it scans, and that all of them may take; in words. What is shown
 * is mostly among the classes that come first. */
enum { RMAP_PATH_STEPS_SCAN = 1 << 15, RMAP_PATH_STEPS_MOST = 1 << 19 };

/* Those of some classes, in the order of their numbers. All zero is empty. */
struct rmap_path_steps {
    uint32_t *word;   /* [n_word] steps one behind the other; from the end on, of each class the
                         number and where its steps end */
    size_t n_word, n; /* n: classes */
    bool is_closed;   /* no more are taken from rays */
};
void rmap_path_steps_fini(struct rmap_path_steps *steps);

/* Those of a class; *n_ret 0: it has none, or they are not there. */
const rmap_path_step *rmap_path_steps_of(const struct rmap_path_steps *steps, size_t class,
                                         size_t *n_ret);

/* Room for at most n steps of one more class: NULL when more than `most` words would be taken.
 * RMAP_SYSTEM. */
enum rmap_status rmap_path_steps_make_room(struct rmap_path_steps *steps, size_t n, size_t most,
                                           rmap_path_step **step_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

/* n steps of the class stand in the room. Its number is above those before. */
void rmap_path_steps_end_class(struct rmap_path_steps *steps, size_t class, size_t n);

/* Both, as long as there is room. */
enum rmap_status rmap_path_steps_add(struct rmap_path_steps *steps, size_t class,
                                     const rmap_path_step *step, size_t n,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif

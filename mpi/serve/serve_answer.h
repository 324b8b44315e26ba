/* SPDX-License-Identifier: MIT
 *
 * What requests can be, and their answers.
 */
#ifndef RMAP_SERVE_ANSWER_H
#define RMAP_SERVE_ANSWER_H

#include "mpi/serve/serve_state.h"

/* Collective. Answers the request that the text is, on rank 0 the one in hand. RMAP_OK also where
 * the answer is that it is wrong. */
enum rmap_status rmap_serve_answer_one(struct rmap_serve *self, const char *text,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

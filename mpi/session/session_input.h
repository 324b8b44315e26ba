/* SPDX-License-Identifier: MIT
 *
 * Lines of a session: typed at a terminal, with editing, history and completion, or from a pipe.
 */
#ifndef RMAP_SESSION_INPUT_H
#define RMAP_SESSION_INPUT_H

#include <stdbool.h>
#include <stdio.h>

#include "base/status.h"

struct rmap_session_input;

/* Reads `in`. With words, which are copied, it is a terminal: the tabulator completes to one of
 * them ([n_word], any order), and what was typed is kept in the user's state directory. With NULL
 * it is a pipe. */
enum rmap_status rmap_session_input_create(FILE *in, const char *const *word, size_t n_word,
                                           struct rmap_session_input **input_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;
void rmap_session_input_destroy(struct rmap_session_input *input);

/* The next line without its end, borrowed until the next call; NULL: there is none.
 * RMAP_INPUT: a line of more than RMAP_SESSION_LINE bytes, which was skipped, or one that holds a
 * zero byte. RMAP_SYSTEM: no memory, or reading failed. */
#define RMAP_SESSION_LINE (16u << 20)
enum rmap_status rmap_session_input_next(struct rmap_session_input *input, const char **line_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif

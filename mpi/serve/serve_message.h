/* SPDX-License-Identifier: MIT
 *
 * What goes over the line: {"id", "command", ...} comes, {"id", "ok", "result"} or {"id", "ok",
 * "error"} goes.
 */
#ifndef RMAP_SERVE_MESSAGE_H
#define RMAP_SERVE_MESSAGE_H

#include <jansson.h>

#include "base/status.h"

#define RMAP_SERVE_LINE ((size_t)16 << 20) /* the longest request */

/* A request; NULL: it is none, and *refusal_ret says so to who sent it. */
json_t *rmap_serve_parse(const char *line, size_t nbytes, json_t **refusal_ret);

/* Whether a command's own keys are those, and what they are to be: "file:s force:b". s: a text, b:
 * true or false, n: a whole number from 0 on, p: from 1 on, o: an object, l: a list, x: anything.
 * `null` is as good as none. RMAP_USAGE. */
enum rmap_status rmap_serve_check_keys(const json_t *message, const char *keys,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Answers to a request (NULL: to what was none). The result is taken over. */
json_t *rmap_serve_result(const json_t *request, json_t *result);
json_t *rmap_serve_error(const json_t *request, enum rmap_status status, const char *text);

/* On one line; rmap_free. NULL when memory is short. */
char *rmap_serve_text(const json_t *document);

#endif

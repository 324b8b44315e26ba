/* SPDX-License-Identifier: MIT
 *
 * What commands print, as a document in place of text on standard output.
 */
#ifndef RMAP_SERVE_CAPTURE_H
#define RMAP_SERVE_CAPTURE_H

#include <jansson.h>

#include "base/status.h"

/* From now on standard output is a file in memory, *capture_ret; what it was is *out_ret. Both are
 * the caller's. */
enum rmap_status rmap_serve_capture_begin(int *capture_ret, int *out_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* What was printed since the last time, as one JSON document; null where that was nothing, or text
 * (command's talk). NULL when memory is short. */
json_t *rmap_serve_capture_take(int capture);

#endif

/* SPDX-License-Identifier: MIT
 *
 * The JSON documents that commands print.
 */
#ifndef RMAP_JSON_OUT_H
#define RMAP_JSON_OUT_H

#include <jansson.h>
#include <stdio.h>

#include "base/status.h"
#include "io/export/json_number.h"
#include "io/file/diagnostics.h"

/* Of the shapes of all documents (docs/schemas): raised when a key changes its meaning or goes. */
#define RMAP_JSON_VERSION 1

/* Takes an object, or a list of such, and gives it back with a key `version` first in each. NULL:
 * memory was short. */
json_t *rmap_json_versioned(json_t *document);

/* Writes rmap_json_versioned of it. Takes the document over (NULL: memory was short). Reals with 17
 * digits, keys as inserted. */
enum rmap_status rmap_json_print(json_t *document, FILE *out, struct rmap_error *err) RMAP_MUST_USE;

/* What was found in a file: [{"line", "text"}, ...]. */
json_t *rmap_json_findings(const struct rmap_diagnostics *findings);

/* What a scene's reader found: [{"severity", "line", "column", "text", "file"}, ...]. */
json_t *rmap_json_diagnostics(const struct rmap_diagnostics *diagnostics);

/* A document on one line, for a stream of documents. */
enum rmap_status rmap_json_line(json_t *document, FILE *out, struct rmap_error *err) RMAP_MUST_USE;

#endif

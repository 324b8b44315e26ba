/* SPDX-License-Identifier: MIT */
#include "mpi/json_out.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>

#include "io/json_memory.h"

static enum rmap_status write_document(json_t *document, size_t flags, FILE *out,
                                       struct rmap_error *err)
{
    bool whole = document && !rmap_json_memory_failed();
    errno = 0;
    int failed = whole ? json_dumpf(document, out, flags | JSON_REAL_PRECISION(17)) : 0;
    json_decref(document);
    if (!whole || rmap_json_memory_failed())
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the JSON document");
    if (failed || fputc('\n', out) == EOF)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write the JSON document: %s",
                              errno != 0 ? strerror(errno) : "the output failed");
    return RMAP_OK;
}

enum rmap_status rmap_json_print(json_t *document, FILE *out, struct rmap_error *err)
{
    return write_document(document, JSON_INDENT(2), out, err);
}

enum rmap_status rmap_json_line(json_t *document, FILE *out, struct rmap_error *err)
{
    return write_document(document, JSON_COMPACT, out, err);
}

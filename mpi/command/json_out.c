/* SPDX-License-Identifier: MIT
 *
 * The JSON documents that commands print.
 */
#include "mpi/command/json_out.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>

#include "io/export/json_memory.h"

/* Each object at the top says which shape it has, first. */
static json_t *versioned(json_t *object)
{
    json_t *with = json_pack("{s:i}", "version", RMAP_JSON_VERSION);
    if (json_object_update(with, object) != 0) { /* out of memory: reported by the watch */
        json_decref(with);
        with = NULL;
    }
    json_decref(object);
    return with;
}

json_t *rmap_json_versioned(json_t *document)
{
    if (json_is_object(document))
        return versioned(document);
    for (size_t i = 0; i < json_array_size(document); i++) {
        json_t *item = json_array_get(document, i);
        if (json_is_object(item))
            (void)json_array_set_new(document, i, versioned(json_incref(item)));
    }
    return document;
}

static enum rmap_status write_document(json_t *document, size_t flags, FILE *out,
                                       struct rmap_error *err)
{
    document = rmap_json_versioned(document);
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

json_t *rmap_json_findings(const struct rmap_diagnostics *findings)
{
    json_t *list = json_array();
    for (size_t i = 0; i < findings->n; i++)
        (void)json_array_append_new(list, json_pack("{s:i, s:s}", "line", findings->item[i].line,
                                                    "text", findings->item[i].text));
    return list;
}

json_t *rmap_json_diagnostics(const struct rmap_diagnostics *diagnostics)
{
    json_t *list = json_array();
    for (size_t i = 0; i < diagnostics->n; i++) {
        const struct rmap_diagnostic *item = &diagnostics->item[i];
        int line;
        const char *part = rmap_diagnostics_place(diagnostics, item->line, &line);
        json_t *told = json_pack("{s:s, s:i, s:i, s:s}", "severity",
                                 item->severity == RMAP_SEVERITY_ERROR ? "error" : "warning",
                                 "line", line, "column", item->column, "text", item->text);
        if (told && part)
            (void)json_object_set_new(told, "file", json_string(part));
        (void)json_array_append_new(list, told);
    }
    return list;
}

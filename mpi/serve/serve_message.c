/* SPDX-License-Identifier: MIT
 *
 * What goes over the line.
 */
#include "mpi/serve/serve_message.h"

#include <stdio.h>
#include <string.h>

json_t *rmap_serve_result(const json_t *request, json_t *result)
{
    json_t *id = json_object_get(request, "id");
    return json_pack("{s:O?, s:b, s:o}", "id", id, "ok", 1, "result", result);
}

/* Messages about texts name the place: "scene.yaml:12:5: error: ...", "1:5: ...". */
static void put_place(json_t *error, const char *text)
{
    int line = 0, column = 0;
    for (const char *at = text; *at && *at != '\n'; at++) {
        const char before = at == text ? ':' : at[-1];
        if ((before == ':' || before == ' ') && sscanf(at, "%d:%d: ", &line, &column) == 2 &&
            line > 0 && column > 0) {
            (void)json_object_set_new(error, "line", json_integer(line));
            (void)json_object_set_new(error, "column", json_integer(column));
            return;
        }
    }
}

json_t *rmap_serve_error(const json_t *request, enum rmap_status status, const char *text)
{
    json_t *told = json_pack("{s:i, s:s?}", "status", (int)status, "message", text);
    if (told && !json_object_get(told, "message")) /* not UTF-8 */
        (void)json_object_set_new(told, "message", json_string("wrong"));
    put_place(told, text);
    return json_pack("{s:O?, s:b, s:o}", "id", json_object_get(request, "id"), "ok", 0, "error",
                     told);
}

json_t *rmap_serve_parse(const char *line, size_t nbytes, json_t **refusal_ret)
{
    json_error_t error;
    json_t *message = json_loadb(line, nbytes, JSON_REJECT_DUPLICATES, &error);
    char text[JSON_ERROR_TEXT_LENGTH + 64];
    *refusal_ret = NULL;
    if (!message) {
        (void)snprintf(text, sizeof text, "a request is one JSON object: column %d: %s",
                       error.column, error.text);
        *refusal_ret = rmap_serve_error(NULL, RMAP_USAGE, text);
    } else if (!json_is_string(json_object_get(message, "command"))) {
        *refusal_ret = rmap_serve_error(
            message, RMAP_USAGE, "a request is an object with a 'command', such as \"status\"");
        json_decref(message);
        message = NULL;
    }
    return message;
}

char *rmap_serve_text(const json_t *document)
{
    return json_dumps(document, JSON_COMPACT | JSON_REAL_PRECISION(17));
}

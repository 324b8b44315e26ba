/* SPDX-License-Identifier: MIT
 *
 * What goes over the line.
 */
#include "mpi/serve/serve_message.h"

#include <stdint.h>
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
    (void)json_object_del(message, "begun"); /* the server's own, of what comes again */
    return message;
}

/* What a value of that kind is called; NULL: it is one. */
static const char *wanted(char kind, const json_t *value)
{
    if (json_is_null(value))
        return NULL;
    switch (kind) {
    case 's':
        return json_is_string(value) ? NULL : "a text";
    case 'b':
        return json_is_boolean(value) ? NULL : "true or false";
    case 'n':
        return json_is_integer(value) && json_integer_value(value) >= 0
                   ? NULL
                   : "a whole number from 0 on";
    case 'p':
        return json_is_integer(value) && json_integer_value(value) > 0 ? NULL
                                                                       : "a whole number from 1 on";
    case 'o':
        return json_is_object(value) ? NULL : "an object";
    case 'l':
        return json_is_array(value) ? NULL : "a list";
    default:
        return NULL;
    }
}

static enum rmap_status refuse_key(const char *command, const char *key, const char *keys,
                                   struct rmap_error *err)
{
    char takes[200] = "";
    size_t n = 0;
    for (const char *at = keys; *at; at += strcspn(at, " "), at += *at == ' ')
        n += (size_t)snprintf(takes + n, sizeof takes - n, " %.*s", (int)strcspn(at, ":"), at);
    return rmap_error_set(err, RMAP_USAGE, "'%.20s' has no '%.60s'; it takes:%s", command, key,
                          n > 0 ? takes : " nothing");
}

enum rmap_status rmap_serve_check_keys(const json_t *message, const char *keys,
                                       struct rmap_error *err)
{
    const char *command = json_string_value(json_object_get(message, "command")), *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)message, key, value)
    {
        const size_t n = strlen(key);
        const char *at = keys;
        if (strcmp(key, "id") == 0 || strcmp(key, "command") == 0 || strcmp(key, "begun") == 0)
            continue;
        while (*at && (strncmp(at, key, n) != 0 || at[n] != ':')) {
            at += strcspn(at, " ");
            at += *at == ' ';
        }
        if (!*at)
            return refuse_key(command, key, keys, err);
        const char *what = wanted(at[n + 1], value);
        if (what)
            return rmap_error_set(err, RMAP_USAGE, "'%.60s' of '%.20s' is %s", key, command, what);
    }
    return RMAP_OK;
}

char *rmap_serve_text(const json_t *document)
{
    return json_dumps(document, JSON_COMPACT | JSON_REAL_PRECISION(17));
}

/* SPDX-License-Identifier: MIT
 *
 * Answers that commands write as files, in a folder of the server's own.
 */
#include "mpi/serve/serve_picture.h"

#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/base64.h"
#include "io/file/publish.h"
#include "mpi/parallel/agree.h"

static const struct {
    const char *format, *type;
    bool is_text;
} known[] = {
    {"svg", "image/svg+xml", true},      {"png", "image/png", false},
    {"glb", "model/gltf-binary", false}, {"html", "text/html", true},
    {"exr", "image/x-exr", false},       {"json", "application/json", true},
};

static bool has_word(const char *words, const char *word)
{
    const size_t n = strlen(word);
    for (const char *at = words; n > 0 && (at = strstr(at, word)); at += n)
        if ((at == words || at[-1] == ' ') && (at[n] == ' ' || !at[n]))
            return true;
    return false;
}

/* Collective. Other ranks need no folder, but commands look at the name. */
static enum rmap_status find_scratch(struct rmap_serve *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *base = getenv("TMPDIR");
    if (self->scratch)
        return RMAP_OK;
    self->scratch = rmap_path_format("%s/raymap-serve-XXXXXX", base && *base ? base : "/tmp");
    if (!self->scratch)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
    else if (self->context.rank == 0 && !mkdtemp(self->scratch))
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: no folder can be made there: %s", self->scratch,
                            strerror(errno));
    if (st != RMAP_OK) {
        rmap_free(self->scratch);
        self->scratch = NULL;
    }
    return st;
}

enum rmap_status rmap_serve_picture_name(struct rmap_serve *self, const char *formats,
                                         const json_t *message, char **path_ret,
                                         const char **type_ret, struct rmap_error *err)
{
    const json_t *asked = json_object_get(message, "format");
    const char *format = json_string_value(asked);
    char first[16] = "";
    (void)snprintf(first, sizeof first, "%.*s", (int)strcspn(formats, " "), formats);
    if (!asked)
        format = first;
    if (!format || !has_word(formats, format))
        return rmap_error_set(err, RMAP_USAGE, "'format' is one of: %s", formats);
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        if (strcmp(known[i].format, format) == 0)
            *type_ret = known[i].type;
    const enum rmap_status st = find_scratch(self, err);
    if (st != RMAP_OK)
        return st;
    *path_ret =
        rmap_path_format("%s/answer.%s", self->context.rank == 0 ? self->scratch : "/tmp", format);
    return *path_ret ? RMAP_OK : rmap_error_set(err, RMAP_SYSTEM, "out of memory for a name");
}

static char *encode(const char *bytes, size_t n)
{
    char *text = rmap_alloc((n + 2) / 3 * 4 + 1, 1);
    for (size_t i = 0; text && i < n; i += 3)
        rmap_base64_four((const uint8_t *)bytes + i, n - i < 3 ? n - i : 3, text + i / 3 * 4);
    return text;
}

static json_t *document_of(const char *type, const char *bytes, size_t n)
{
    bool is_text = false;
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        is_text = is_text || (strcmp(known[i].type, type) == 0 && known[i].is_text);
    if (strcmp(type, "application/json") == 0)
        return json_loadb(bytes, n, 0, NULL);
    if (is_text)
        return json_pack("{s:s, s:s%}", "type", type, "text", bytes, n);
    char *text = encode(bytes, n);
    json_t *document = json_pack("{s:s, s:s?}", "type", type, "base64", text);
    rmap_free(text);
    return document;
}

static char *read_bytes(const char *path, size_t *n_ret)
{
    FILE *file = fopen(path, "rb");
    char *bytes = NULL;
    long n = -1;
    if (file && fseek(file, 0, SEEK_END) == 0)
        n = ftell(file);
    if (n >= 0)
        bytes = rmap_alloc((size_t)n + 1, 1);
    if (file)
        rewind(file);
    if (bytes && fread(bytes, 1, (size_t)n, file) != (size_t)n) {
        rmap_free(bytes);
        bytes = NULL;
    }
    if (file)
        (void)fclose(file);
    *n_ret = bytes ? (size_t)n : 0;
    return bytes;
}

enum rmap_status rmap_serve_picture_take(const char *path, const char *type, const json_t *printed,
                                         json_t **result_ret, struct rmap_error *err)
{
    size_t n = 0;
    char *bytes = read_bytes(path, &n);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "%s cannot be read", path);
    json_t *document = document_of(type, bytes, n);
    rmap_free(bytes);
    if (!document)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an answer");
    if (json_is_object(printed) && strcmp(type, "application/json") != 0)
        (void)json_object_update_missing(document, (json_t *)(uintptr_t)printed);
    (void)json_object_del(document, "output"); /* a file that is gone */
    *result_ret = document;
    return RMAP_OK;
}

void rmap_serve_picture_fini(struct rmap_serve *self)
{
    if (self->scratch && self->context.rank == 0)
        (void)rmdir(self->scratch);
    rmap_free(self->scratch);
    self->scratch = NULL;
}

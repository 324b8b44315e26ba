/* SPDX-License-Identifier: MIT
 *
 * Of lamp makers' files what does not depend on the format.
 */
#include "io/lamp/lamp_file.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lamp/lamp_reader.h"

enum rmap_status rmap_lamp_file_read(const char *text, size_t nbytes, enum rmap_lamp_format format,
                                     const struct rmap_lamp_choice *choice,
                                     struct rmap_lamp_file *file, struct rmap_error *err)
{
    struct rmap_lamp_text scan = {.at = text, .end = text + nbytes, .line = 1};
    *file = (struct rmap_lamp_file){.along = 2,
                                    .axis = {{1.0, 0.0, 0.0}, {0.0, -1.0, 0.0}, {0.0, 0.0, 1.0}}};
    if (memchr(text, 0, nbytes))
        return rmap_error_set(err, RMAP_INPUT, "it is no text: a byte 0 stands in it");
    if (format == RMAP_LAMP_EULUMDAT)
        return rmap_lamp_eulumdat_read(&scan, choice, file, err);
    if (choice->set > 1)
        return rmap_error_set(err, RMAP_INPUT, "set %zu is not there: an IES file has one",
                              choice->set);
    return rmap_lamp_ies_read(&scan, choice, file, err);
}

void rmap_lamp_file_fini(struct rmap_lamp_file *file)
{
    rmap_free(file->around_deg);
    rmap_free(file->polar_deg);
    rmap_free(file->candela);
    *file = (struct rmap_lamp_file){.n_around = 0};
}

/* ---- text ---- */

size_t rmap_lamp_line(struct rmap_lamp_text *scan, const char **line)
{
    const char *end = memchr(scan->at, '\n', (size_t)(scan->end - scan->at));
    end = end ? end : scan->end;
    *line = scan->at;
    size_t n = (size_t)(end - scan->at);
    scan->line += end < scan->end;
    scan->at = end < scan->end ? end + 1 : end;
    while (n > 0 && strchr(" \t\r", (*line)[n - 1]))
        n--;
    return n;
}

enum rmap_status rmap_lamp_number(struct rmap_lamp_text *scan, const char *what,
                                  const struct rmap_lamp_range *range, double *value,
                                  struct rmap_error *err)
{
    char word[32], *stop = NULL;
    size_t n = 0;
    while (scan->at < scan->end && strchr(scan->commas ? " \t\r" : " \t\r\n,", *scan->at))
        scan->line += *scan->at++ == '\n';
    for (; scan->at < scan->end && !strchr(scan->commas ? " \t\r\n" : " \t\r\n,", *scan->at);
         scan->at++)
        if (n + 1 < sizeof word)
            word[n++] = *scan->at == ',' ? '.' : *scan->at;
    word[n] = 0;
    if (n == 0 && scan->at == scan->end)
        return rmap_error_set(err, RMAP_INPUT, "line %zu: it ends before %s", scan->line, what);
    *value = strtod(word, &stop);
    if (n == 0 || *stop || !(*value >= range->low && *value <= range->high) ||
        (range->whole && *value != floor(*value)))
        return rmap_error_set(err, RMAP_INPUT, "line %zu: '%s': %s is a %snumber from %g to %g",
                              scan->line, word, what, range->whole ? "whole " : "", range->low,
                              range->high);
    return RMAP_OK;
}

static bool is_utf8(const char *text, size_t nbytes)
{
    size_t due = 0;
    for (size_t i = 0; i < nbytes; i++) {
        const unsigned char c = (unsigned char)text[i];
        if ((due > 0) != ((c & 0xc0) == 0x80))
            return false;
        if (due > 0)
            due--;
        else if (c >= 0x80)
            due = c >= 0xf8 || c < 0xc2 ? nbytes : c >= 0xf0 ? 3 : c >= 0xe0 ? 2 : 1;
    }
    return due == 0;
}

void rmap_lamp_title(struct rmap_lamp_file *file, const char *text, size_t nbytes)
{
    const bool utf8 = is_utf8(text, nbytes);
    size_t n = strlen(file->title);
    if (n > 0 && nbytes > 0 && n + 1 < sizeof file->title)
        file->title[n++] = ' ';
    for (size_t i = 0; i < nbytes; i++) {
        const unsigned char c = (unsigned char)text[i];
        const size_t need = c < 0x80   ? 1
                            : !utf8    ? 2
                            : c < 0xc0 ? 0
                            : c < 0xe0 ? 2
                            : c < 0xf0 ? 3
                                       : 4;
        if (n + need >= sizeof file->title)
            break;
        if (c >= 0x80 && !utf8)
            file->title[n++] = (char)(0xc0 | c >> 6);
        file->title[n++] = (char)(c < 0x20 || c == 0x7f ? ' '
                                  : c < 0x80 || utf8    ? c
                                                        : 0x80 | (c & 0x3f));
    }
    file->title[n] = 0;
}

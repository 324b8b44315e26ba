/* SPDX-License-Identifier: MIT
 *
 * Where a mesh that is text is wrong.
 */
#include "io/mesh/text_fault.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct line {
    const char *text, *end; /* without the line's end */
    size_t number;
};

/* The next line; false: there is none. Begin with text at the file's first byte, end and number 0.
 */
static bool next_line(struct line *line, const char *file_end)
{
    if (line->number++ > 0) {
        line->text = line->end + (*line->end == '\r' && line->end[1] == '\n' ? 2 : 1);
    }
    if (line->text >= file_end || *line->text == 0)
        return false;
    line->end = line->text + strcspn(line->text, "\r\n");
    return true;
}

static const char *skip_blanks(const char *at)
{
    return at + strspn(at, " \t");
}

/* What follows the keyword; NULL: the line has another one. */
static const char *behind(const struct line *line, const char *keyword)
{
    const char *at = skip_blanks(line->text);
    const size_t n = strlen(keyword);
    return strncmp(at, keyword, n) == 0 && (at[n] == ' ' || at[n] == '\t') ? at + n : NULL;
}

static bool is_point(const char *at, const char *end)
{
    for (int k = 0; k < 3; k++) {
        char *stop;
        at = skip_blanks(at);
        (void)strtod(at, &stop);
        if (stop == at || stop > end)
            return false;
        at = stop;
    }
    return true;
}

static bool tell_point(const struct line *line, char *why, size_t why_nbytes)
{
    enum { MOST = 60 };
    const char *at = skip_blanks(line->text);
    const int n = (int)(line->end - at < MOST ? line->end - at : MOST);
    (void)snprintf(why, why_nbytes, "line %zu: '%.*s' is no point of three numbers", line->number,
                   n, at);
    return true;
}

bool rmap_stl_fault(const uint8_t *bytes, size_t nbytes, char *why, size_t why_nbytes)
{
    struct line line = {(const char *)bytes, NULL, 0};
    while (next_line(&line, (const char *)bytes + nbytes)) {
        const char *at = behind(&line, "vertex");
        if (at && !is_point(at, line.end))
            return tell_point(&line, why, why_nbytes);
    }
    return false;
}

/* The first corner of an `f` line that is no vertex; false: all are. n: vertices of the file,
 * n_before: up to the line, from which negative numbers count. */
static bool is_bad_face(const char *at, const char *end, long n, long n_before, long *bad)
{
    for (at = skip_blanks(at); at < end; at = skip_blanks(at)) {
        char *stop;
        const long index = strtol(at, &stop, 10);
        *bad = index;
        if (stop == at)
            return false; /* no number: assimp has its own words */
        if (index == 0 || index > n || (index < 0 && -index > n_before))
            return true;
        at += strcspn(at, " \t\r\n");
    }
    return false;
}

bool rmap_obj_fault(const uint8_t *bytes, size_t nbytes, char *why, size_t why_nbytes)
{
    const char *const end = (const char *)bytes + nbytes;
    struct line line = {(const char *)bytes, NULL, 0};
    long n = 0, n_before = 0, bad = 0;
    size_t n_face = 0;
    while (next_line(&line, end)) {
        const char *at = behind(&line, "v");
        if (at && !is_point(at, line.end))
            return tell_point(&line, why, why_nbytes);
        n += at != NULL;
    }
    line = (struct line){(const char *)bytes, NULL, 0};
    while (next_line(&line, end)) {
        const char *at = behind(&line, "f");
        n_before += behind(&line, "v") != NULL;
        n_face += at != NULL;
        if (!at || !is_bad_face(at, line.end, n, n_before, &bad))
            continue;
        (void)snprintf(why, why_nbytes, "line %zu: face %zu has vertex %ld, and there are 1 to %ld",
                       line.number, n_face, bad, n);
        return true;
    }
    return false;
}

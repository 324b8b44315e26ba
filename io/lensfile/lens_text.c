/* SPDX-License-Identifier: MIT
 *
 * Texts of lens files: encodings, lines, words; and surfaces as readers add to them.
 */
#include "io/lensfile/lens_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"

/* ---- encodings ---- */

static size_t put_utf8(char *to, unsigned c)
{
    if (c < 0x80) {
        to[0] = (char)c;
        return 1;
    }
    if (c < 0x800) {
        to[0] = (char)(0xc0 | c >> 6);
        to[1] = (char)(0x80 | (c & 0x3f));
        return 2;
    }
    if (c < 0x10000) {
        to[0] = (char)(0xe0 | c >> 12);
        to[1] = (char)(0x80 | (c >> 6 & 0x3f));
        to[2] = (char)(0x80 | (c & 0x3f));
        return 3;
    }
    to[0] = (char)(0xf0 | c >> 18);
    to[1] = (char)(0x80 | (c >> 12 & 0x3f));
    to[2] = (char)(0x80 | (c >> 6 & 0x3f));
    to[3] = (char)(0x80 | (c & 0x3f));
    return 4;
}

static unsigned unit(const unsigned char *at, bool big)
{
    return (unsigned)at[!big] << 8 | at[big];
}

static size_t from_utf16(const unsigned char *bytes, size_t nbytes, bool big, char *to)
{
    size_t n = 0;
    for (size_t i = 0; i + 1 < nbytes; i += 2) {
        unsigned c = unit(bytes + i, big);
        if (c >= 0xd800 && c < 0xdc00 && i + 3 < nbytes) {
            const unsigned low = unit(bytes + i + 2, big);
            if (low >= 0xdc00 && low < 0xe000) {
                c = 0x10000 + ((c - 0xd800) << 10) + (low - 0xdc00);
                i += 2;
            }
        }
        n += put_utf8(to + n, c >= 0xd800 && c < 0xe000 ? 0xfffd : c);
    }
    return n;
}

/* The character at a place and its bytes; 0 bytes: it is no UTF-8. */
static size_t get_utf8(const unsigned char *at, size_t nbytes, unsigned *c)
{
    static const unsigned least[] = {0, 0, 0x80, 0x800, 0x10000};
    const size_t n = at[0] < 0x80 ? 1 : at[0] < 0xc0 ? 0 : at[0] < 0xe0 ? 2 : at[0] < 0xf0 ? 3 : 4;
    if (n == 0 || n > nbytes || at[0] >= 0xf8)
        return 0;
    *c = n == 1 ? at[0] : at[0] & (0x7fu >> n);
    for (size_t i = 1; i < n; i++) {
        if ((at[i] & 0xc0) != 0x80)
            return 0;
        *c = *c << 6 | (at[i] & 0x3fu);
    }
    return *c >= least[n] && *c < 0x110000 && (*c < 0xd800 || *c > 0xdfff) ? n : 0;
}

static bool is_utf8(const unsigned char *text, size_t nbytes)
{
    unsigned c = 0;
    for (size_t i = 0, n; i < nbytes; i += n)
        if ((n = get_utf8(text + i, nbytes - i, &c)) == 0)
            return false;
    return true;
}

enum rmap_status rmap_lens_decode(const char *bytes, size_t nbytes, char **text_ret,
                                  struct rmap_error *err)
{
    const unsigned char *b = (const unsigned char *)bytes;
    const bool little = nbytes >= 2 && b[0] == 0xff && b[1] == 0xfe;
    const bool big = nbytes >= 2 && b[0] == 0xfe && b[1] == 0xff;
    const size_t mark = little || big                                                 ? 2
                        : nbytes >= 3 && b[0] == 0xef && b[1] == 0xbb && b[2] == 0xbf ? 3
                                                                                      : 0;
    char *text = rmap_alloc_unset(nbytes + 1, 2);
    size_t n = 0;
    b += mark;
    nbytes -= mark;
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a text of %zu bytes", nbytes);
    if (little || big) {
        n = from_utf16(b, nbytes, big, text);
    } else if (is_utf8(b, nbytes)) {
        memcpy(text, b, nbytes);
        n = nbytes;
    } else {
        for (size_t i = 0; i < nbytes; i++)
            n += put_utf8(text + n, b[i]);
    }
    if (memchr(text, 0, n)) {
        rmap_free(text);
        return rmap_error_set(err, RMAP_INPUT, "it is no text: a byte 0 stands in it");
    }
    text[n] = 0;
    *text_ret = text;
    return RMAP_OK;
}

/* ---- lines and words ---- */

bool rmap_lens_next_line(struct rmap_lens_lines *lines)
{
    if (!*lines->at)
        return false;
    char *end = lines->at + strcspn(lines->at, "\n");
    lines->line = lines->at;
    lines->at = *end ? end + 1 : end;
    lines->number++;
    while (end > lines->line && strchr(" \t\r", end[-1]))
        end--;
    *end = 0;
    return true;
}

size_t rmap_lens_words(char *text, const char *more, char *word[RMAP_LENS_WORDS_MAX])
{
    size_t n = 0;
    for (char *at = text; *at && n < RMAP_LENS_WORDS_MAX;) {
        if (strchr(" \t\r", *at) || strchr(more, *at)) {
            at++;
            continue;
        }
        const char quote = *at == '"' || *at == '\'' ? *at : 0;
        at += quote != 0;
        word[n++] = at;
        while (*at && (quote ? *at != quote : !strchr(" \t\r", *at) && !strchr(more, *at)))
            at++;
        if (*at)
            *at++ = 0;
    }
    return n;
}

bool rmap_lens_is(const char *word, const char *other)
{
    return strcasecmp(word, other) == 0;
}

bool rmap_lens_number(const char *word, double *value)
{
    char *end = NULL;
    if (!strchr("+-.0123456789", *word))
        return false;
    const double number = strtod(word, &end);
    if (end == word || *end || !isfinite(number) || fabs(number) > 1e100)
        return false;
    *value = number;
    return true;
}

double rmap_lens_value(char *const *word, size_t n_word, size_t k, double other)
{
    double value = other;
    if (k < n_word)
        (void)rmap_lens_number(word[k], &value);
    return value;
}

void rmap_lens_expect_number(struct rmap_prescription *lens, size_t line,
                             struct rmap_lens_surface *surface, const char *keys, const char *key,
                             char *const *word, size_t n_word)
{
    double value = 0;
    const size_t n = strlen(key);
    for (const char *at = keys; *at; at += strcspn(at, " "), at += strspn(at, " ")) {
        if (strcspn(at, " :") != n || strncasecmp(at, key, n) != 0)
            continue;
        const bool last = at[n] == ':' && at[n + 1] == '$';
        const unsigned long most = at[n] == ':' && !last ? strtoul(at + n + 1, NULL, 10) : 1;
        for (size_t k = last && n_word > 1 ? n_word - 1 : 1; k < n_word && (last || k <= most); k++)
            if (!rmap_lens_number(word[k], &value))
                rmap_lens_lost(lens, line, surface, "%.8s %.40s is no number and is left out", key,
                               word[k]);
    }
}

double rmap_lens_nm(double um)
{
    const double digits = 1e7; /* of a nm */
    return fabs(um) < 1e3 ? rint(1e3 * digits * um) / digits : 1e3 * um;
}

/* Marks of direction: what is read would be another text than what stands there (CVE-2021-42574).
 */
static bool turns(unsigned c)
{
    return c == 0x61c || c == 0x200e || c == 0x200f || (c >= 0x202a && c <= 0x202e) ||
           (c >= 0x2066 && c <= 0x2069);
}

/* Cut before a character that has no room. What would end a line of YAML, or may not stand in it,
 * becomes a blank. */
void rmap_lens_copy(char *to, size_t cap, const char *text)
{
    size_t n = 0, nbytes = strlen(text);
    const unsigned char *at = (const unsigned char *)text;
    while (nbytes > 0) {
        unsigned c = 0;
        const size_t width = get_utf8(at, nbytes, &c);
        const bool bad = width == 0 || c < 0x20 || (c >= 0x7f && c < 0xa0) || c == 0x2028 ||
                         c == 0x2029 || c == 0xfeff || c == 0xfffe || c == 0xffff;
        char escape[8];
        const int n_escape = turns(c) ? snprintf(escape, sizeof escape, "\\u%04x", c) : 0;
        const size_t room = bad ? 1 : n_escape > 0 ? (size_t)n_escape : width;
        if (n + room >= cap)
            break;
        if (n_escape > 0)
            memcpy(to + n, escape, room);
        else if (bad)
            to[n] = ' ';
        else
            memcpy(to + n, at, width);
        n += room;
        at += width ? width : 1;
        nbytes -= width ? width : 1;
    }
    to[n] = 0;
}

/* ---- what readers share ---- */

static void add_remark(struct rmap_lens_surface *surface, const char *text)
{
    const size_t n = strlen(surface->remark), cap = sizeof surface->remark;
    if (strstr(surface->remark, text) || n + 4 >= cap)
        return;
    if (n > 0)
        memcpy(surface->remark + n, "; ", 3);
    const size_t at = strlen(surface->remark);
    rmap_lens_copy(surface->remark + at, cap - at, text);
}

void rmap_lens_remark(struct rmap_lens_surface *surface, const char *format, ...)
{
    char text[200];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    add_remark(surface, text);
}

void rmap_lens_lost(struct rmap_prescription *lens, size_t line, struct rmap_lens_surface *surface,
                    const char *format, ...)
{
    char text[300];
    va_list args;
    va_start(args, format);
    (void)vsnprintf(text, sizeof text, format, args);
    va_end(args);
    if (surface)
        add_remark(surface, text);
    if (surface)
        rmap_diagnostics_add(lens->findings, RMAP_SEVERITY_WARNING, (int)line, 0, "surface %d: %s",
                             surface->number, text);
    else
        rmap_diagnostics_add(lens->findings, RMAP_SEVERITY_WARNING, (int)line, 0, "%s", text);
}

struct rmap_lens_surface *rmap_lens_add(struct rmap_prescription *lens, size_t line,
                                        struct rmap_error *err)
{
    if (lens->n_surface >= RMAP_PRESCRIPTION_SURFACES_MAX) {
        (void)rmap_error_set(err, RMAP_INPUT, "line %zu: more than %d surfaces", line,
                             RMAP_PRESCRIPTION_SURFACES_MAX);
        return NULL;
    }
    if (RMAP_RESERVE(lens->surface, lens->cap_surface, lens->n_surface + 1, err) != RMAP_OK)
        return NULL;
    struct rmap_lens_surface *surface = &lens->surface[lens->n_surface];
    memset(surface, 0, sizeof *surface); /* padding, too: shapes are compared as bytes */
    surface->line = line;
    surface->number = (int)lens->n_surface;
    surface->before = surface->after = rmap_affine_identity();
    lens->n_surface++;
    return surface;
}

enum rmap_status rmap_lens_note(struct rmap_prescription *lens, const char *text,
                                struct rmap_error *err)
{
    enum { NOTES_MAX = 16384 };
    const size_t n = strlen(text);
    if (n == 0 || lens->notes_nbytes + n + 2 > NOTES_MAX)
        return RMAP_OK;
    if (RMAP_RESERVE(lens->notes, lens->cap_notes, lens->notes_nbytes + n + 2, err) != RMAP_OK)
        return RMAP_SYSTEM;
    rmap_lens_copy(lens->notes + lens->notes_nbytes, n + 1, text);
    lens->notes_nbytes += n;
    lens->notes[lens->notes_nbytes++] = '\n';
    lens->notes[lens->notes_nbytes] = 0;
    return RMAP_OK;
}

enum rmap_status rmap_lens_add_glass(struct rmap_prescription *lens, size_t line, const char *name,
                                     const double *um, const double *index, size_t n,
                                     struct rmap_error *err)
{
    if (n == 0 || lens->n_glass >= RMAP_PRESCRIPTION_GLASSES_MAX)
        return RMAP_OK;
    if (RMAP_RESERVE(lens->glass, lens->cap_glass, lens->n_glass + 1, err) != RMAP_OK)
        return RMAP_SYSTEM;
    struct rmap_agf_glass *glass = &lens->glass[lens->n_glass++];
    *glass = (struct rmap_agf_glass){.line = line, .from_um = HUGE_VAL};
    rmap_lens_copy(glass->name, sizeof glass->name, name);
    for (; glass->n_row < n && glass->n_row < RMAP_AGF_ROWS; glass->n_row++) {
        glass->row_um[glass->n_row] = um[glass->n_row];
        glass->row_index[glass->n_row] = index[glass->n_row];
        glass->from_um = fmin(glass->from_um, um[glass->n_row]);
        glass->to_um = fmax(glass->to_um, um[glass->n_row]);
    }
    return RMAP_OK;
}

bool rmap_lens_set_asphere(struct rmap_lens_surface *surface, int power, double value)
{
    if (value == 0)
        return true;
    if (power < 1 || power > RMAP_LENS_POWER_MAX)
        return false;
    surface->asphere[power] = value;
    surface->n_asphere = power > surface->n_asphere ? power : surface->n_asphere;
    return true;
}

bool rmap_lens_add_term(struct rmap_lens_surface *surface, enum rmap_lens_terms kind, int i, int j,
                        double value)
{
    struct rmap_lens_figure *figure = &surface->figure;
    int at = figure->terms == kind ? figure->n_term : 0; /* of another kind they are given up */
    if (value == 0)
        return true;
    figure->terms = kind;
    figure->n_term = at;
    if (!(figure->norm > 0))
        figure->norm = 1;
    for (; at > 0 && (figure->term[at - 1].i > i ||
                      (figure->term[at - 1].i == i && figure->term[at - 1].j >= j));
         at--)
        if (figure->term[at - 1].i == i && figure->term[at - 1].j == j) {
            figure->term[at - 1].value = value; /* given again */
            return true;
        }
    if (figure->n_term >= RMAP_LENS_TERMS_MAX)
        return false;
    memmove(&figure->term[at + 1], &figure->term[at],
            (size_t)(figure->n_term - at) * sizeof *figure->term);
    figure->term[at] = (struct rmap_lens_term){i, j, value};
    figure->n_term++;
    return true;
}

void rmap_lens_xy_powers(int k, int *i, int *j)
{
    int degree = 1;
    for (; k > degree; degree++)
        k -= degree + 1;
    *i = degree - k;
    *j = k;
}

struct rmap_affine rmap_lens_turn(const double shift[3], const double tilt_deg[3])
{
    const struct rmap_vec3 one = rmap_vec3(1, 1, 1), none = rmap_vec3(0, 0, 0);
    struct rmap_affine turn =
        rmap_affine_placement(one, none, rmap_vec3(shift[0], shift[1], shift[2]));
    for (int axis = 0; axis < 3; axis++) {
        const struct rmap_affine next = rmap_affine_placement(
            one,
            rmap_vec3(axis == 0 ? tilt_deg[0] : 0, axis == 1 ? tilt_deg[1] : 0,
                      axis == 2 ? tilt_deg[2] : 0),
            none);
        turn = rmap_affine_compose(&turn, &next);
    }
    return turn;
}

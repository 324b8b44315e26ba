/* SPDX-License-Identifier: MIT
 *
 * One pass, recursive descent: ! binds closest, then &, ^, |.
 */
#include "analysis/zemax_filter.h"

#include <stdarg.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion_lex.h"
#include "base/alloc.h"

enum { NBYTES_MAX = 1 << 20, DEPTH_MAX = 500, ANY = 0 };

struct translation {
    const struct rmap_scene *scene;
    const char *text;
    size_t at;
    int depth;
    struct rmap_error *err;
};

/* A text that grows. */
struct draft {
    char *text;
    size_t nbytes, cap;
};

#define FAIL(t, from, to, ...) rmap_criterion_fail((t)->text, from, to, (t)->err, __VA_ARGS__)

static enum rmap_status put(struct translation *t, struct draft *draft, const char *text)
{
    size_t nbytes = strlen(text);
    void *block = draft->text;
    if (draft->nbytes + nbytes > NBYTES_MAX)
        return FAIL(t, t->at, t->at, "the filter's translation is too long");
    enum rmap_status st = rmap_reserve(&block, &draft->cap, draft->nbytes + nbytes + 1, 1, t->err);
    if (st != RMAP_OK)
        return st;
    draft->text = block;
    memcpy(draft->text + draft->nbytes, text, nbytes + 1);
    draft->nbytes += nbytes;
    return RMAP_OK;
}

/* Each piece in turn, up to a NULL. */
static enum rmap_status put_all(struct translation *t, struct draft *draft, ...)
{
    enum rmap_status st = RMAP_OK;
    va_list pieces;
    va_start(pieces, draft);
    for (const char *piece = va_arg(pieces, const char *); piece && st == RMAP_OK;
         piece = va_arg(pieces, const char *))
        st = put(t, draft, piece);
    va_end(pieces);
    return st;
}

/* A name in single quotes. */
static enum rmap_status put_name(struct translation *t, struct draft *draft, const char *name)
{
    enum rmap_status st = RMAP_OK;
    char one[2] = {0};
    RMAP_TRY(put(t, draft, "'"));
    for (; *name; name++) {
        one[0] = *name;
        RMAP_TRY(put_all(t, draft, one, *name == '\'' ? "'" : "", (char *)NULL));
    }
    RMAP_TRY(put(t, draft, "'"));
out:
    return st;
}

/* A flag's number: of an object, a source, a wavelength; ANY (0) where that is allowed. */
struct flag {
    char letter;
    size_t begin, end;
    bool has_number;
    size_t number;
};

static enum rmap_status check_number(const struct translation *t, const struct flag *flag,
                                     const char *noun, size_t n)
{
    if (flag->has_number && flag->number == ANY)
        return FAIL(t, flag->begin, flag->end, "%ss are numbered from 1", noun);
    if (!flag->has_number)
        return FAIL(t, flag->begin, flag->end, "flag %c needs the number of %s %s", flag->letter,
                    noun[0] == 'o' ? "an" : "a", noun);
    if (flag->number > n)
        return FAIL(t, flag->begin, flag->end, "there is no %s %zu: the scene has %zu", noun,
                    flag->number, n);
    return RMAP_OK;
}

/* True for partial reflection at a surface that light also passes: both media known, unequal. */
static bool is_refractive(const struct rmap_scene *scene, size_t object)
{
    const struct rmap_object *it = &scene->object[object];
    return scene->surface[it->surface_front].type == RMAP_SURFACE_FRESNEL ||
           scene->surface[it->surface_back].type == RMAP_SURFACE_FRESNEL;
}

/* `hit(NAME, EVENT)` for an object, or for 0 any of those. */
static enum rmap_status put_hit(struct translation *t, const struct flag *flag, const char *event,
                                struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    if (flag->number == ANY)
        return put_all(t, draft, "hit(*, ", event, ")", (char *)NULL);
    RMAP_TRY(check_number(t, flag, "object", t->scene->n_object));
    RMAP_TRY(put(t, draft, "hit("));
    RMAP_TRY(put_name(t, draft, t->scene->object[flag->number - 1].name));
    RMAP_TRY(put_all(t, draft, event ? ", " : "", event ? event : "", ")", (char *)NULL));
out:
    return st;
}

/* Ghosts: specular reflection where an object refracts. */
static enum rmap_status put_ghost(struct translation *t, const struct flag *flag,
                                  struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0, first = 0, last = t->scene->n_object;
    if (flag->number != ANY) {
        RMAP_TRY(check_number(t, flag, "object", t->scene->n_object));
        first = flag->number - 1;
        last = flag->number;
    }
    for (size_t o = first; o < last; o++)
        if (is_refractive(t->scene, o)) {
            RMAP_TRY(put(t, draft, n++ ? " or hit(" : "(hit("));
            RMAP_TRY(put_name(t, draft, t->scene->object[o].name));
            RMAP_TRY(put(t, draft, ", reflect_specular)"));
        }
    st = put(t, draft, n ? ")" : "(not all)");
out:
    return st;
}

static enum rmap_status put_last(struct translation *t, const struct flag *flag,
                                 struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(check_number(t, flag, "object", t->scene->n_object));
    const char *name = t->scene->object[flag->number - 1].name;
    if (strchr(name, '"'))
        return FAIL(t, flag->begin, flag->end, "a path cannot name an object with a double quote");
    RMAP_TRY(put(t, draft, "path(\".* [^V]@"));
    RMAP_TRY(put_name(t, draft, name));
    RMAP_TRY(put(t, draft, " V*\")"));
out:
    return st;
}

static enum rmap_status put_source(struct translation *t, const struct flag *flag,
                                   struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    if (flag->has_number && flag->number == ANY)
        return put(t, draft, "all");
    RMAP_TRY(check_number(t, flag, "source", t->scene->n_source));
    RMAP_TRY(put(t, draft, "source("));
    RMAP_TRY(put_name(t, draft, t->scene->source[flag->number - 1].name));
    RMAP_TRY(put(t, draft, ")"));
out:
    return st;
}

static enum rmap_status put_wavelength(struct translation *t, const struct flag *flag,
                                       struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    char text[64];
    if (t->scene->channels.mode != RMAP_COLOUR_SPECTRAL)
        return FAIL(t, flag->begin, flag->end, "the scene has colours, no wavelengths to number");
    RMAP_TRY(check_number(t, flag, "wavelength", (size_t)t->scene->channels.n));
    (void)snprintf(text, sizeof text, "wavelength == %.17g",
                   t->scene->channels.wavelength_nm[flag->number - 1]);
    st = put(t, draft, text);
out:
    return st;
}

/* Flags that select by what no map records, or whose meaning is another one than a selection. */
static enum rmap_status fail_unsupported(const struct translation *t, const struct flag *flag)
{
    static const struct {
        char letter;
        const char *why;
    } reason[] = {
        {'B', "volume scattering is recorded without an object (B0, any, can be said)"},
        {'D', "diffraction is no event here"},
        {'E', "diffraction is no event here"},
        {'J', "it changes intensities; G selects the same rays"},
        {'X', "extended flags have no translation but X_HITFACE(n,f)"},
        {'Z', "it has no translation"},
    };
    const char *why = "it has no translation";
    for (size_t i = 0; i < sizeof reason / sizeof *reason; i++)
        if (reason[i].letter == flag->letter)
            why = reason[i].why;
    return FAIL(t, flag->begin, flag->end, "flag %.*s cannot be said: %s",
                (int)(flag->end - flag->begin), t->text + flag->begin, why);
}

static enum rmap_status put_flag(struct translation *t, const struct flag *flag,
                                 struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    switch (flag->letter) {
    case 'H':
        RMAP_TRY(check_number(t, flag, "object", t->scene->n_object));
        return put_hit(t, flag, NULL, draft);
    case 'M':
        RMAP_TRY(check_number(t, flag, "object", t->scene->n_object));
        RMAP_TRY(put(t, draft, "not "));
        return put_hit(t, flag, NULL, draft);
    case 'R':
        return put_hit(t, flag, "reflect", draft);
    case 'T':
        return put_hit(t, flag, "transmit", draft);
    case 'S':
    case 'F':
        return put_hit(t, flag, "diffuse", draft);
    case 'G':
        return put_ghost(t, flag, draft);
    case 'L':
        return put_last(t, flag, draft);
    case 'O':
        return put_source(t, flag, draft);
    case 'W':
        return put_wavelength(t, flag, draft);
    case 'B':
        if (flag->number == ANY)
            return put(t, draft, "event(scatter_volume)");
        return fail_unsupported(t, flag);
    default:
        return fail_unsupported(t, flag);
    }
out:
    return st;
}

static char peek(struct translation *t)
{
    t->at += strspn(t->text + t->at, " \t\r\n");
    return t->text[t->at];
}

static bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/* Digits; any number beyond a scene's is one. */
static size_t read_number(struct translation *t)
{
    size_t number = 0;
    for (; is_digit(t->text[t->at]); t->at++)
        if (number < 1000000000)
            number = number * 10 + (size_t)(t->text[t->at] - '0');
    return number;
}

/* X_HITFACE(n, f): the face of a CAD object. */
static enum rmap_status read_extended(struct translation *t, size_t begin, struct draft *draft)
{
    static const char word[] = "X_HITFACE(";
    enum rmap_status st = RMAP_OK;
    struct flag flag = {.letter = 'X', .begin = begin};
    char face[32];
    bool known = strncmp(t->text + begin, word, sizeof word - 1) == 0;
    flag.end = begin + strcspn(t->text + begin, " \t\r\n&|^!)");
    if (!known)
        return fail_unsupported(t, &flag);
    t->at = begin + sizeof word - 1;
    flag.has_number = is_digit(peek(t));
    flag.number = read_number(t);
    bool comma = peek(t) == ',';
    t->at += comma;
    if (!flag.has_number || !comma || !is_digit(peek(t)))
        return FAIL(t, begin, t->at, "expected X_HITFACE(object, face)");
    (void)snprintf(face, sizeof face, "face %zu", read_number(t));
    if (peek(t) != ')')
        return FAIL(t, begin, t->at, "expected X_HITFACE(object, face)");
    t->at++;
    flag.end = t->at;
    RMAP_TRY(check_number(t, &flag, "object", t->scene->n_object));
    st = put_hit(t, &flag, face, draft);
out:
    return st;
}

static enum rmap_status read_flag(struct translation *t, struct draft *draft)
{
    char c = peek(t);
    size_t begin = t->at;
    if (!c)
        return FAIL(t, begin, begin, "expected a flag such as H3, found the end");
    bool lower = c >= 'a' && c <= 'z';
    struct flag flag = {.letter = lower ? (char)(c - 'a' + 'A') : c, .begin = begin};
    if (flag.letter < 'A' || flag.letter > 'Z')
        return FAIL(t, begin, begin + 1, "expected a flag such as H3, '!' or '('");
    if (strncmp(t->text + begin, "X_", 2) == 0)
        return read_extended(t, begin, draft);
    t->at++;
    flag.has_number = is_digit(t->text[t->at]);
    flag.number = read_number(t);
    flag.end = t->at;
    return put_flag(t, &flag, draft);
}

static enum rmap_status read_level(struct translation *t, int level, struct draft *draft);

static enum rmap_status read_not(struct translation *t, struct draft *draft)
{
    enum rmap_status st = RMAP_OK;
    bool negate = false;
    for (; peek(t) == '!'; t->at++)
        negate = !negate;
    if (negate)
        RMAP_TRY(put(t, draft, "not "));
    if (peek(t) != '(') {
        RMAP_TRY(read_flag(t, draft));
        return RMAP_OK;
    }
    size_t open = t->at++;
    if (++t->depth > DEPTH_MAX)
        return FAIL(t, open, open + 1, "more than %d nested parentheses", DEPTH_MAX);
    RMAP_TRY(put(t, draft, "("));
    RMAP_TRY(read_level(t, 0, draft));
    RMAP_TRY(put(t, draft, ")"));
    if (peek(t) != ')')
        return FAIL(t, open, open + 1, "this parenthesis is never closed");
    t->at++;
    t->depth--;
out:
    return st;
}

/* draft = (draft and not other) or (not draft and other), in parentheses */
static enum rmap_status put_either(struct translation *t, struct draft *draft,
                                   const struct draft *other)
{
    enum rmap_status st = RMAP_OK;
    struct draft both = {0};
    RMAP_TRY(put_all(t, &both, "((", draft->text, ") and not (", other->text, ") or not (",
                     draft->text, ") and (", other->text, "))", (char *)NULL));
    rmap_free(draft->text);
    *draft = both;
    both = (struct draft){0};
out:
    rmap_free(both.text);
    return st;
}

/* Levels 0, 1, 2: chains of |, ^ and &. */
static enum rmap_status read_level(struct translation *t, int level, struct draft *draft)
{
    static const char sign[] = "|^&";
    enum rmap_status st = RMAP_OK;
    struct draft own = {0}, next = {0};
    if (level == 3)
        return read_not(t, draft);
    RMAP_TRY(read_level(t, level + 1, &own));
    while (peek(t) == sign[level]) {
        t->at++;
        t->at += t->text[t->at] == sign[level]; /* && and || too */
        if (level != 1)
            RMAP_TRY(put(t, &own, level ? " and " : " or "));
        RMAP_TRY(read_level(t, level + 1, level == 1 ? &next : &own));
        if (level == 1)
            RMAP_TRY(put_either(t, &own, &next));
        next.nbytes = 0;
    }
    RMAP_TRY(put(t, draft, own.text));
out:
    rmap_free(next.text);
    rmap_free(own.text);
    return st;
}

enum rmap_status rmap_zemax_translate(const char *filter, const struct rmap_scene *scene,
                                      char **criterion_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct draft draft = {0};
    struct translation t = {.scene = scene, .text = filter, .err = err};
    RMAP_TRY(rmap_criterion_check_utf8(filter, err));
    if (!peek(&t)) {
        st = FAIL(&t, 0, 0, "the filter is empty");
        goto out;
    }
    RMAP_TRY(read_level(&t, 0, &draft));
    if (peek(&t)) {
        st = FAIL(&t, t.at, t.at + 1, "expected '&', '|', '^' or the end");
        goto out;
    }
    *criterion_ret = draft.text;
    draft.text = NULL;
out:
    if (st == RMAP_INPUT)
        rmap_criterion_relabel("zemax", err);
    rmap_free(draft.text);
    return st;
}

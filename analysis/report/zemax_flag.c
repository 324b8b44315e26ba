/* SPDX-License-Identifier: MIT
 *
 * What each flag of a filter string says in the criterion language.
 */
#include "analysis/report/zemax_flag.h"

#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

enum { NBYTES_MAX = 1 << 20 };

enum rmap_status rmap_zemax_put(struct rmap_zemax_translation *t, struct rmap_zemax_draft *draft,
                                const char *text)
{
    size_t nbytes = strlen(text);
    if (draft->nbytes + nbytes > NBYTES_MAX)
        return RMAP_ZEMAX_FAIL(t, t->at, t->at, "the filter's translation is too long");
    enum rmap_status st = RMAP_RESERVE(draft->text, draft->cap, draft->nbytes + nbytes + 1, t->err);
    if (st != RMAP_OK)
        return st;
    memcpy(draft->text + draft->nbytes, text, nbytes + 1);
    draft->nbytes += nbytes;
    return RMAP_OK;
}

enum rmap_status rmap_zemax_put_all(struct rmap_zemax_translation *t,
                                    struct rmap_zemax_draft *draft, ...)
{
    enum rmap_status st = RMAP_OK;
    va_list pieces;
    va_start(pieces, draft);
    for (const char *piece = va_arg(pieces, const char *); piece && st == RMAP_OK;
         piece = va_arg(pieces, const char *))
        st = rmap_zemax_put(t, draft, piece);
    va_end(pieces);
    return st;
}

/* A name in single quotes. */
static enum rmap_status put_name(struct rmap_zemax_translation *t, struct rmap_zemax_draft *draft,
                                 const char *name)
{
    enum rmap_status st = RMAP_OK;
    char one[2] = {0};
    RMAP_TRY(rmap_zemax_put(t, draft, "'"));
    for (; *name; name++) {
        one[0] = *name;
        RMAP_TRY(rmap_zemax_put_all(t, draft, one, *name == '\'' ? "'" : "", (char *)NULL));
    }
    RMAP_TRY(rmap_zemax_put(t, draft, "'"));
out:
    return st;
}

enum rmap_status rmap_zemax_check_number(const struct rmap_zemax_translation *t,
                                         const struct rmap_zemax_flag *flag, const char *noun,
                                         size_t n)
{
    if (flag->has_number && flag->number == RMAP_ZEMAX_ANY)
        return RMAP_ZEMAX_FAIL(t, flag->begin, flag->end, "%ss are numbered from 1", noun);
    if (!flag->has_number)
        return RMAP_ZEMAX_FAIL(t, flag->begin, flag->end, "flag %c needs the number of %s %s",
                               flag->letter, noun[0] == 'o' ? "an" : "a", noun);
    if (flag->number > n)
        return RMAP_ZEMAX_FAIL(t, flag->begin, flag->end, "there is no %s %zu: the scene has %zu",
                               noun, flag->number, n);
    return RMAP_OK;
}

/* True for partial reflection at a surface that light also passes: both media known, unequal. */
static bool is_refractive(const struct rmap_scene *scene, size_t object)
{
    const struct rmap_object *it = &scene->object[object];
    return rmap_surface_look(&scene->surface[it->surface_front]) == RMAP_LOOK_REFRACTING ||
           rmap_surface_look(&scene->surface[it->surface_back]) == RMAP_LOOK_REFRACTING;
}

enum rmap_status rmap_zemax_put_hit(struct rmap_zemax_translation *t,
                                    const struct rmap_zemax_flag *flag, const char *event,
                                    struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    if (flag->number == RMAP_ZEMAX_ANY)
        return rmap_zemax_put_all(t, draft, "hit(*, ", event, ")", (char *)NULL);
    RMAP_TRY(rmap_zemax_check_number(t, flag, "object", t->scene->n_object));
    RMAP_TRY(rmap_zemax_put(t, draft, "hit("));
    RMAP_TRY(put_name(t, draft, t->scene->object[flag->number - 1].name));
    RMAP_TRY(
        rmap_zemax_put_all(t, draft, event ? ", " : "", event ? event : "", ")", (char *)NULL));
out:
    return st;
}

/* Ghosts: specular reflection where an object refracts. */
static enum rmap_status put_ghost(struct rmap_zemax_translation *t,
                                  const struct rmap_zemax_flag *flag,
                                  struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0, first = 0, last = t->scene->n_object;
    if (flag->number != RMAP_ZEMAX_ANY) {
        RMAP_TRY(rmap_zemax_check_number(t, flag, "object", t->scene->n_object));
        first = flag->number - 1;
        last = flag->number;
    }
    for (size_t o = first; o < last; o++)
        if (is_refractive(t->scene, o)) {
            RMAP_TRY(rmap_zemax_put(t, draft, n++ ? " or hit(" : "(hit("));
            RMAP_TRY(put_name(t, draft, t->scene->object[o].name));
            RMAP_TRY(rmap_zemax_put(t, draft, ", reflect_specular)"));
        }
    st = rmap_zemax_put(t, draft, n ? ")" : "(not all)");
out:
    return st;
}

static enum rmap_status put_last(struct rmap_zemax_translation *t,
                                 const struct rmap_zemax_flag *flag, struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_zemax_check_number(t, flag, "object", t->scene->n_object));
    const char *name = t->scene->object[flag->number - 1].name;
    if (strchr(name, '"'))
        return RMAP_ZEMAX_FAIL(t, flag->begin, flag->end,
                               "a path cannot name an object with a double quote");
    RMAP_TRY(rmap_zemax_put(t, draft, "path(\".* [^V]@"));
    RMAP_TRY(put_name(t, draft, name));
    RMAP_TRY(rmap_zemax_put(t, draft, " V*\")"));
out:
    return st;
}

static enum rmap_status put_source(struct rmap_zemax_translation *t,
                                   const struct rmap_zemax_flag *flag,
                                   struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    if (flag->has_number && flag->number == RMAP_ZEMAX_ANY)
        return rmap_zemax_put(t, draft, "all");
    RMAP_TRY(rmap_zemax_check_number(t, flag, "source", t->scene->n_source));
    RMAP_TRY(rmap_zemax_put(t, draft, "source("));
    RMAP_TRY(put_name(t, draft, t->scene->source[flag->number - 1].name));
    RMAP_TRY(rmap_zemax_put(t, draft, ")"));
out:
    return st;
}

static enum rmap_status put_wavelength(struct rmap_zemax_translation *t,
                                       const struct rmap_zemax_flag *flag,
                                       struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    char text[64];
    if (t->scene->channels.mode != RMAP_COLOUR_SPECTRAL)
        return RMAP_ZEMAX_FAIL(t, flag->begin, flag->end,
                               "the scene has colours, no wavelengths to number");
    RMAP_TRY(rmap_zemax_check_number(t, flag, "wavelength", (size_t)t->scene->channels.n));
    (void)snprintf(text, sizeof text, "wavelength == %.17g",
                   t->scene->channels.wavelength_nm[flag->number - 1]);
    st = rmap_zemax_put(t, draft, text);
out:
    return st;
}

/* Flags that select by what no map records, or whose meaning is another one than a selection. */
enum rmap_status rmap_zemax_fail_unsupported(const struct rmap_zemax_translation *t,
                                             const struct rmap_zemax_flag *flag)
{
    static const struct {
        char letter;
        const char *why;
    } reason[] = {
        {'B', "volume scattering is recorded without an object (B0, any, can be said)"},
        {'D', "diffraction is no event here"},
        {'E', "diffraction is no event here"},
        {'J', "it changes intensities; G selects the same rays"},
        {'X', "of the extended flags X_HIT(n,b) and X_HITFACE(n,f) can be said"},
        {'Z', "it has no translation"},
    };
    const char *why = "it has no translation";
    for (size_t i = 0; i < sizeof reason / sizeof *reason; i++)
        if (reason[i].letter == flag->letter)
            why = reason[i].why;
    return RMAP_ZEMAX_FAIL(t, flag->begin, flag->end, "flag %.*s cannot be said: %s",
                           (int)(flag->end - flag->begin), t->text + flag->begin, why);
}

enum rmap_status rmap_zemax_put_flag(struct rmap_zemax_translation *t,
                                     const struct rmap_zemax_flag *flag,
                                     struct rmap_zemax_draft *draft)
{
    enum rmap_status st = RMAP_OK;
    switch (flag->letter) {
    case 'H':
        RMAP_TRY(rmap_zemax_check_number(t, flag, "object", t->scene->n_object));
        return rmap_zemax_put_hit(t, flag, NULL, draft);
    case 'M':
        RMAP_TRY(rmap_zemax_check_number(t, flag, "object", t->scene->n_object));
        RMAP_TRY(rmap_zemax_put(t, draft, "not "));
        return rmap_zemax_put_hit(t, flag, NULL, draft);
    case 'R':
        return rmap_zemax_put_hit(t, flag, "reflect", draft);
    case 'T':
        return rmap_zemax_put_hit(t, flag, "transmit", draft);
    case 'S':
    case 'F':
        return rmap_zemax_put_hit(t, flag, "diffuse", draft);
    case 'G':
        return put_ghost(t, flag, draft);
    case 'L':
        return put_last(t, flag, draft);
    case 'O':
        return put_source(t, flag, draft);
    case 'W':
        return put_wavelength(t, flag, draft);
    case 'B':
        if (flag->number == RMAP_ZEMAX_ANY)
            return rmap_zemax_put(t, draft, "event(scatter_volume)");
        return rmap_zemax_fail_unsupported(t, flag);
    default:
        return rmap_zemax_fail_unsupported(t, flag);
    }
out:
    return st;
}

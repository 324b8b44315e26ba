/* SPDX-License-Identifier: MIT
 *
 * What no scene can have, made plainer.
 */
#include "io/lensfile/lens_plain.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lensfile/lens_text.h"

static const double widest = 1e9; /* in any unit of a lens: a scene's reach is 1e15 mm */

static void limit(struct rmap_prescription *lens, struct rmap_lens_surface *surface,
                  const char *what, double *value)
{
    if (fabs(*value) <= widest)
        return;
    rmap_lens_lost(lens, surface->line, surface, "its %s %.6g is no length of a lens: 0 is taken",
                   what, *value);
    *value = 0;
}

static bool is_straight(const struct rmap_affine *a)
{
    return hypot(a->m[0][2], a->m[1][2]) < 1e-9 && a->m[2][2] > 0 && a->t.z == 0;
}

/* Through glass no light goes back without a mirror. */
static void limit_signs(struct rmap_prescription *lens)
{
    bool backwards = false, in_glass = false;
    for (size_t i = 1; i + 1 < lens->n_surface; i++) {
        struct rmap_lens_surface *s = &lens->surface[i], *next = s + 1;
        backwards ^= s->is_mirror;
        if (!s->is_break && !s->is_mirror)
            in_glass = s->glass[0] && !rmap_lens_is(s->glass, "AIR");
        if (!in_glass || (backwards ? s->thickness <= 0 : s->thickness >= 0) || s->is_break ||
            next->is_break || !is_straight(&s->after) || !is_straight(&next->before))
            continue;
        rmap_lens_lost(lens, s->line, s,
                       "its thickness %.6g leads back through the glass: %.6g stands there",
                       s->thickness, -s->thickness);
        s->thickness = -s->thickness;
    }
}

/* A conic that ends well within the light is a slip of the pen. */
static void limit_conic(struct rmap_prescription *lens, struct rmap_lens_surface *s)
{
    const double wide = s->semi > 0                          ? s->semi
                        : lens->pupil == RMAP_PUPIL_DIAMETER ? 0.5 * lens->pupil_value
                                                             : 0;
    const double reach = rmap_lens_reach(s), much = 0.1;
    if (s->conic == 0 || !(reach < much * wide || reach * fabs(s->curvature) < 1e-3))
        return;
    rmap_lens_lost(lens, s->line, s, "with its conic %.6g it ends at radius %.3g: 0 is taken",
                   s->conic, reach);
    s->conic = 0;
}

void rmap_lens_limit(struct rmap_prescription *lens)
{
    limit_signs(lens);
    for (size_t i = 1; i + 1 < lens->n_surface; i++)
        limit_conic(lens, &lens->surface[i]);
    for (size_t i = 1; i < lens->n_surface; i++) {
        struct rmap_lens_surface *s = &lens->surface[i];
        limit(lens, s, "semi-diameter", &s->semi);
        limit(lens, s, "thickness", &s->thickness);
        for (int k = 0; k < 2; k++) {
            struct rmap_vec3 *t = k ? &s->after.t : &s->before.t;
            limit(lens, s, "shift", &t->x);
            limit(lens, s, "shift", &t->y);
            limit(lens, s, "shift", &t->z);
            struct rmap_lens_opening *o = k ? &s->aperture : &s->obscuration;
            limit(lens, s, "aperture's place", &o->centre[0]);
            limit(lens, s, "aperture's place", &o->centre[1]);
            if (o->shape && fmax(o->half[0], o->half[1]) > widest) {
                rmap_lens_lost(lens, s->line, s, "its aperture %.6g is no length of a lens",
                               fmax(o->half[0], o->half[1]));
                o->shape = RMAP_OPENING_NONE;
            }
        }
    }
}

bool rmap_lens_limit_light(struct rmap_prescription *lens, const struct rmap_lens_media *media)
{
    const size_t before = lens->n_wavelength;
    size_t n = 0;
    for (size_t i = 0; i < before; i++) {
        const double nm = lens->wavelength_nm[i];
        const struct rmap_lens_medium *bad = NULL;
        for (size_t m = 1; m < media->n && !bad; m++) {
            const double index = rmap_glass_index(&media->medium[m].glass, nm);
            if (!(index > 0 && isfinite(index)))
                bad = &media->medium[m];
        }
        if (bad)
            rmap_lens_lost(lens, 0, NULL, "wavelength %.7g nm is left out: %s has no index there",
                           nm, bad->name);
        if (lens->primary == i)
            lens->primary = bad ? 0 : n;
        if (bad)
            continue;
        lens->wavelength_nm[n] = nm;
        lens->wavelength_weight[n++] = lens->wavelength_weight[i];
    }
    if (n == 0) {
        lens->wavelength_nm[n] = 587.5618;
        lens->wavelength_weight[n++] = 1;
        rmap_lens_lost(lens, 0, NULL, "no wavelength is left: 587.5618 nm is taken");
    }
    lens->n_wavelength = n;
    return n < before;
}

static bool is_plain(const struct rmap_lens_surface *s)
{
    static const struct rmap_lens_figure none = {.n_term = 0};
    return s->n_asphere == 0 && memcmp(&s->figure, &none, sizeof none) == 0;
}

bool rmap_lens_make_plainer(struct rmap_prescription *lens, size_t surface, const char *why)
{
    for (size_t i = surface; i > 0 && i + 1 < lens->n_surface && i + 2 > surface; i--) {
        struct rmap_lens_surface *s = &lens->surface[i];
        if (s->is_break)
            continue;
        const bool plain = is_plain(s);
        if (plain && s->curvature == 0 && s->aperture.shape == RMAP_OPENING_NONE)
            continue;
        memset(s->asphere, 0, sizeof s->asphere);
        memset(&s->figure, 0, sizeof s->figure);
        s->n_asphere = 0;
        if (plain) {
            s->curvature = s->conic = 0;
            memset(&s->aperture, 0, sizeof s->aperture);
        }
        rmap_lens_lost(lens, s->line, s, "%s in its place, as a scene cannot have it (%.160s)",
                       plain ? "a plane stands" : "its sphere or conic alone stands", why);
        return true;
    }
    return false;
}

bool rmap_lens_move_source(struct rmap_prescription *lens, size_t field, const char *why)
{
    struct rmap_lens_surface *object = &lens->surface[0];
    if (isfinite(object->thickness)) {
        rmap_lens_lost(lens, object->line, object,
                       "%.6g before surface 1 no light can begin: it comes from far away instead "
                       "(%.160s)",
                       object->thickness, why);
        object->thickness = HUGE_VAL;
        return true;
    }
    if (field >= lens->n_field || lens->n_field < 2)
        return false;
    rmap_lens_lost(lens, 0, NULL, "field x %.6g, y %.6g is left out (%.160s)", lens->field[field].x,
                   lens->field[field].y, why);
    memmove(&lens->field[field], &lens->field[field + 1],
            (lens->n_field - field - 1) * sizeof *lens->field);
    lens->n_field--;
    return true;
}

enum rmap_status rmap_lens_keep(const struct rmap_prescription *lens, struct rmap_lens_kept *kept,
                                struct rmap_error *err)
{
    const size_t nbytes = lens->n_surface * sizeof *lens->surface;
    if (!kept->surface)
        kept->surface = rmap_alloc_unset(lens->n_surface, sizeof *kept->surface);
    if (!kept->surface)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the surfaces of a lens");
    memcpy(kept->surface, lens->surface, nbytes);
    kept->lens = *lens;
    kept->n_finding = lens->findings->n;
    return RMAP_OK;
}

void rmap_lens_put_back(struct rmap_prescription *lens, const struct rmap_lens_kept *kept)
{
    *lens = kept->lens;
    memcpy(lens->surface, kept->surface, lens->n_surface * sizeof *lens->surface);
    rmap_diagnostics_cut(lens->findings, kept->n_finding);
}

void rmap_lens_kept_fini(struct rmap_lens_kept *kept)
{
    rmap_free(kept->surface);
    kept->surface = NULL;
}

/* SPDX-License-Identifier: MIT
 *
 * Shapes of Zemax's surfaces. The formulas are those of the OpticStudio user's guide, "Sequential
 * surfaces"; where terms are normalised, XDAT 1 is their number and XDAT 2 the radius.
 */
#include "io/lensfile/lens_zmx_shape.h"

#include <math.h>
#include <string.h>

#include "base/count.h"
#include "io/lensfile/lens_text.h"

struct shape {
    struct rmap_prescription *lens;
    struct rmap_lens_surface *surface;
    const double *p, *x; /* PARM, XDAT */
};

static void lose(const struct shape *s, const char *what)
{
    rmap_lens_lost(s->lens, s->surface->line, s->surface, "%s", what);
}

/* PARM first, first + 1 ... are of r^step, r^(2 step) ... */
static void set_powers(const struct shape *s, int step, int first, int n)
{
    for (int i = 1; i <= n; i++)
        (void)rmap_lens_set_asphere(s->surface, step * i, s->p[first + i - 1]);
}

/* How many terms there are, as far as they can be held. */
static int count_terms(const struct shape *s, double said)
{
    const int n = said >= 1 ? (int)fmin(said, RMAP_LENS_TERMS_MAX) : 0;
    if (said > n && said >= 1)
        rmap_lens_lost(s->lens, s->surface->line, s->surface, "terms beyond %d are left out", n);
    return n;
}

static void set_norm(const struct shape *s, double radius)
{
    s->surface->figure.norm = radius > 0 ? radius : 1;
}

static void coordinate_break(const struct shape *s)
{
    const double *p = s->p;
    const double shift[3] = {p[1], p[2], 0}, tilt[3] = {p[3], p[4], p[5]};
    struct rmap_lens_surface *surface = s->surface;
    surface->is_break = true;
    surface->before = rmap_lens_turn(shift, tilt);
    if (p[6] != 0) { /* about z, the new y and the new x; then the shift */
        const double back_shift[3] = {-p[1], -p[2], 0}, back[3] = {-p[3], -p[4], -p[5]};
        const struct rmap_affine inverse = rmap_lens_turn(back_shift, back);
        (void)rmap_affine_invert(&inverse, &surface->before);
    }
}

static void even_asphere(const struct shape *s)
{
    set_powers(s, 2, 1, 8);
}

static void odd_asphere(const struct shape *s)
{
    set_powers(s, 1, 1, 8);
}

/* a_i rho^(step i) with rho = r / XDAT 2. */
static void extended_asphere(const struct shape *s, int step)
{
    const double radius = s->x[2] > 0 ? s->x[2] : 1;
    const int n = count_terms(s, s->x[1]);
    for (int i = 1; i <= n; i++)
        if (!rmap_lens_set_asphere(s->surface, step * i, s->x[2 + i] / pow(radius, step * i)))
            rmap_lens_lost(s->lens, s->surface->line, s->surface,
                           "the term of r^%d of its extended asphere is left out", step * i);
}

static void extended_even(const struct shape *s)
{
    extended_asphere(s, 2);
}

static void extended_odd(const struct shape *s)
{
    extended_asphere(s, 1);
}

/* The profile of y turns about an axis parallel to y at z = PARM 1; 0: it is drawn along x. */
static void toroid(const struct shape *s)
{
    s->surface->figure.is_toroid = true;
    s->surface->figure.turn = s->p[1] != 0 ? s->p[1] : HUGE_VAL;
    set_powers(s, 2, 2, 7);
    if (s->x[1] >= 1)
        lose(s, "Zernike terms of its toroid are left out");
}

static void biconic(const struct shape *s)
{
    s->surface->figure.is_biconic = true;
    s->surface->figure.curvature_x = s->p[1] != 0 ? 1 / s->p[1] : 0;
    s->surface->figure.conic_x = s->p[2];
}

static void polynomial(const struct shape *s)
{
    const int n = count_terms(s, s->x[1]);
    set_norm(s, s->x[2]);
    for (int k = 0, i = 0, j = 0; k < n; k++) {
        rmap_lens_xy_powers(k, &i, &j);
        (void)rmap_lens_add_term(s->surface, RMAP_TERMS_XY, i, j, s->x[3 + k]);
    }
}

static void zernike(const struct shape *s, enum rmap_lens_terms kind)
{
    const int n = count_terms(s, s->x[1]);
    even_asphere(s);
    set_norm(s, s->x[2]);
    for (int k = 1; k <= n; k++)
        (void)rmap_lens_add_term(s->surface, kind, k, 0, s->x[2 + k]);
    if (s->p[9] != 0 || s->p[10] != 0)
        lose(s, "the decentre of its Zernike terms is left out");
}

static void zernike_standard(const struct shape *s)
{
    zernike(s, RMAP_TERMS_NOLL);
}

static void zernike_fringe(const struct shape *s)
{
    zernike(s, RMAP_TERMS_FRINGE);
}

/* XDAT: 0 (Qbfs) or 1 (Qcon), how many terms, the radius, the terms. */
static void q_type(const struct shape *s)
{
    const int n = count_terms(s, s->x[2]);
    set_norm(s, s->x[3]);
    for (int k = 0; k < n; k++)
        (void)rmap_lens_add_term(s->surface, s->x[1] != 0 ? RMAP_TERMS_QCON : RMAP_TERMS_QBFS, k, 0,
                                 s->x[4 + k]);
}

static void fresnel(const struct shape *s)
{
    s->surface->figure.is_fresnel = true;
    even_asphere(s);
}

/* z = x PARM 1 + y PARM 2 */
static void tilted(const struct shape *s)
{
    s->surface->curvature = 0;
    (void)rmap_lens_add_term(s->surface, RMAP_TERMS_XY, 1, 0, s->p[1]);
    (void)rmap_lens_add_term(s->surface, RMAP_TERMS_XY, 0, 1, s->p[2]);
}

/* Phases on a surface of the even asphere's shape. */
static void phase(const struct shape *s)
{
    even_asphere(s);
    rmap_lens_lost(s->lens, s->surface->line, s->surface,
                   "the phase of %s is not understood: diffraction is no part of a scene; its "
                   "shape is there",
                   s->surface->type);
}

static void grating(const struct shape *s)
{
    rmap_lens_lost(s->lens, s->surface->line, s->surface,
                   "diffraction grating %s is not understood: a conic of its curvature stands in "
                   "its place",
                   s->surface->type);
}

/* "GRINSUR5", "GRINSU10": PARM 1 is a step, PARM 2 and so on the model's numbers. */
static bool gradient(const struct shape *s)
{
    static const char known[] = {1, 2, 3, 4, 5, 7, 10};
    const size_t n_digit = strspn(s->surface->type + 6, "R0123456789");
    if (strncmp(s->surface->type, "GRINSU", 6) != 0 || s->surface->type[6 + n_digit])
        return false;
    double number = 0;
    if (!rmap_lens_number(s->surface->type + 6 + (s->surface->type[6] == 'R'), &number))
        return false;
    for (size_t i = 0; i < RMAP_COUNT(known); i++)
        if (number == known[i])
            s->surface->gradient = known[i];
    for (int i = 0; i + 2 <= RMAP_ZMX_PARAMETERS && i < RMAP_LENS_GRADIENT_MAX; i++)
        s->surface->gradient_value[i] = s->p[2 + i];
    return s->surface->gradient != 0;
}

static const struct {
    const char *type;
    void (*fill)(const struct shape *s);
} shapes[] = {
    {"STANDARD", NULL},
    {"COORDBRK", coordinate_break},
    {"EVENASPH", even_asphere},
    {"ODDASPHE", odd_asphere},
    {"XASPHERE", extended_even},
    {"XOSPHERE", extended_odd},
    {"TOROIDAL", toroid},
    {"BICONICX", biconic},
    {"XPOLYNOM", polynomial},
    {"FRESNELS", fresnel},
    {"SZERNSAG", zernike_standard},
    {"FZERNSAG", zernike_fringe},
    {"QED_TYPE", q_type},
    {"TILTSURF", tilted},
    {"SZERNPHA", phase},
    {"FZERNPHA", phase},
    {"BINARY_1", phase},
    {"BINARY_2", phase},
    {"DGRATING", grating},
    {"TOROGRAT", grating},
};

/* Names of others, for people. */
static const struct {
    const char *type, *name;
} others[] = {
    {"PARAXIAL", "ideal lens"},
    {"CYLINDRI", "cylinder Fresnel"},
    {"IRREGULA", "irregular surface"},
    {"NONSEQCO", "non-sequential component"},
    {"GRADIUM_", "gradient-index surface"},
};

void rmap_zmx_shape(struct rmap_prescription *lens, struct rmap_lens_surface *surface,
                    const struct rmap_zmx_numbers *numbers)
{
    const struct shape s = {lens, surface, numbers->parameter, numbers->extra};
    const char *name = strncmp(surface->type, "GRI", 3) == 0 ? "gradient-index surface" : "surface";
    if (!surface->type[0] || gradient(&s))
        return;
    for (size_t i = 0; i < RMAP_COUNT(shapes); i++)
        if (strcmp(shapes[i].type, surface->type) == 0) {
            if (shapes[i].fill)
                shapes[i].fill(&s);
            return;
        }
    for (size_t i = 0; i < RMAP_COUNT(others); i++)
        if (strcmp(others[i].type, surface->type) == 0)
            name = others[i].name;
    rmap_lens_lost(lens, surface->line, surface,
                   "%s %s is not understood: a conic of its curvature stands in its place", name,
                   surface->type);
}

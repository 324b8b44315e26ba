/* SPDX-License-Identifier: MIT
 *
 * Shapes of CODE V, by the lens system setup reference manual's names: AAS (anamorphic asphere),
 * CYL, YTO, XTO (toroids), SPS XYP, ZRN, ZFR, ODD, QCN, QBF (special surfaces), whose coefficients
 * SCO gives by number or by name.
 */
#include "io/lensfile/lens_seq_shape.h"

#include <ctype.h>
#include <math.h>
#include <string.h>

#include "base/count.h"
#include "io/lensfile/lens_text.h"

struct command {
    struct rmap_prescription *lens;
    size_t line;
    struct rmap_lens_surface *surface;
    struct rmap_seq_shape *shape;
};

/* By number: conic and radius of the terms, the first term, and what it counts from. */
static const struct special {
    const char *word;
    enum rmap_seq_form form;
    int conic, norm, first, from;
} specials[] = {
    {"ODD", RMAP_SEQ_ODD, 1, 33, 2, 1},    {"XYP", RMAP_SEQ_XY, 1, 67, 2, 0},
    {"ZRN", RMAP_SEQ_ZERNIKE, 1, 3, 4, 1}, {"ZFR", RMAP_SEQ_FRINGE, 1, 3, 4, 1},
    {"QCN", RMAP_SEQ_QCON, 17, 2, 4, 0},   {"QBF", RMAP_SEQ_QBFS, 17, 2, 3, 0},
};

static const struct special *special_of(enum rmap_seq_form form)
{
    for (size_t i = 0; i < RMAP_COUNT(specials); i++)
        if (specials[i].form == form)
            return &specials[i];
    return NULL;
}

/* CODE V's Zernike polynomials: n from 0, in each from cos(n t) over steps of 2 to sin(n t), with
 * unit amplitude at the rim; Noll's are larger by sqrt(n + 1), sqrt(2 (n + 1)) off the axis (R. J.
 * Noll, JOSA 66, 207 (1976), eq. 1 and 2, with his numbers: cosines even). */
static bool add_zernike(struct rmap_lens_surface *surface, int number, double value)
{
    int n = 0, at = number - 1;
    for (; at > n; n++)
        at -= n + 1;
    const int m = n - 2 * at, order = m < 0 ? -m : m;
    int noll = n * (n + 1) / 2 + order;
    if (order == 0)
        noll += 1;
    else if ((noll % 2 == 0) != (m > 0))
        noll += 1;
    return rmap_lens_add_term(surface, RMAP_TERMS_NOLL, noll, 0,
                              value / sqrt((order ? 2 : 1) * (n + 1.0)));
}

static bool add_term(const struct command *c, int k, double value)
{
    int i = 0, j = 0;
    switch (c->shape->form) {
    case RMAP_SEQ_ODD:
        return rmap_lens_set_asphere(c->surface, k, value);
    case RMAP_SEQ_XY:
        rmap_lens_xy_powers(k, &i, &j);
        return rmap_lens_add_term(c->surface, RMAP_TERMS_XY, i, j, value);
    case RMAP_SEQ_ZERNIKE:
        return add_zernike(c->surface, k, value);
    case RMAP_SEQ_FRINGE:
        return rmap_lens_add_term(c->surface, RMAP_TERMS_FRINGE, k, 0, value);
    case RMAP_SEQ_QCON:
        return rmap_lens_add_term(c->surface, RMAP_TERMS_QCON, k, 0, value);
    case RMAP_SEQ_QBFS:
        return rmap_lens_add_term(c->surface, RMAP_TERMS_QBFS, k, 0, value);
    case RMAP_SEQ_PLAIN:
    case RMAP_SEQ_ANAMORPHIC:
    case RMAP_SEQ_CYLINDER:
    case RMAP_SEQ_Y_TOROID:
    case RMAP_SEQ_X_TOROID:
    case RMAP_SEQ_FORMS:
        break;
    }
    return false;
}

/* "X2Y1", "X2Y", "XY2", "Y": powers of an xy polynomial. */
static bool read_powers(const char *name, int power[2])
{
    static const char letters[] = "XY";
    for (int k = 0; k < 2; k++) {
        power[k] = 0;
        if (toupper((unsigned char)*name) != letters[k])
            continue;
        name++;
        power[k] = 1;
        if (isdigit((unsigned char)*name))
            for (power[k] = 0; isdigit((unsigned char)*name) && power[k] < 100; name++)
                power[k] = 10 * power[k] + (*name - '0');
    }
    return *name == 0 && power[0] + power[1] > 0;
}

/* Names of terms: AR3 of r^3, QC4, QB0, Z5; the term's number, or -1. */
static int number_of(const struct command *c, const char *name)
{
    static const char *const prefix[RMAP_SEQ_FORMS] = {[RMAP_SEQ_ODD] = "AR",
                                                       [RMAP_SEQ_ZERNIKE] = "Z",
                                                       [RMAP_SEQ_FRINGE] = "Z",
                                                       [RMAP_SEQ_QCON] = "QC",
                                                       [RMAP_SEQ_QBFS] = "QB"};
    const struct special *special = special_of(c->shape->form);
    const char *word = prefix[c->shape->form];
    double number = 0;
    if (toupper((unsigned char)name[0]) == 'C' && rmap_lens_number(name + 1, &number))
        return number >= special->first && number < 1000
                   ? (int)number - special->first + special->from
                   : -1;
    if (!word || strncmp(name, word, strlen(word)) != 0 ||
        !rmap_lens_number(name + strlen(word), &number) || number < 0 || number > 1000)
        return -1;
    return c->shape->form == RMAP_SEQ_QCON ? ((int)number - 4) / 2 : (int)number;
}

static void read_coefficient(const struct command *c, const char *name, double value)
{
    const struct special *special = special_of(c->shape->form);
    double number = 0;
    int power[2], k = -1;
    if (!special)
        return; /* told with its SPS */
    const bool by_number =
        toupper((unsigned char)name[0]) == 'C' && rmap_lens_number(name + 1, &number);
    if (rmap_lens_is(name, "K") || (by_number && number == special->conic))
        c->surface->conic = value;
    else if (rmap_lens_is(name, "NRADIUS") || (by_number && number == special->norm))
        c->shape->norm = fabs(value);
    else if (c->shape->form == RMAP_SEQ_XY && read_powers(name, power)
                 ? !rmap_lens_add_term(c->surface, RMAP_TERMS_XY, power[0], power[1], value)
                 : ((k = number_of(c, name)) < special->from || !add_term(c, k, value)))
        rmap_lens_lost(c->lens, c->line, c->surface, "coefficient %.20s of its shape is left out",
                       name);
}

static void set_form(const struct command *c, const char *word, char *const *values, size_t n)
{
    for (size_t i = 0; i < RMAP_COUNT(specials); i++)
        if (rmap_lens_is(word, specials[i].word)) {
            c->shape->form = specials[i].form;
            c->shape->norm = fabs(rmap_lens_value(values, n, 2, 0));
            return;
        }
    rmap_lens_copy(c->surface->type, sizeof c->surface->type, word);
    rmap_lens_lost(c->lens, c->line, c->surface,
                   "special surface %.10s is not understood: a conic of its curvature stands in "
                   "its place",
                   word);
}

bool rmap_seq_shape_command(struct rmap_prescription *lens, size_t line,
                            struct rmap_lens_surface *surface, struct rmap_seq_shape *shape,
                            const char *key, char *const *word, size_t n)
{
    static const struct {
        const char *word;
        enum rmap_seq_form form;
    } forms[] = {{"AAS", RMAP_SEQ_ANAMORPHIC}, {"ANA", RMAP_SEQ_ANAMORPHIC},
                 {"BIC", RMAP_SEQ_ANAMORPHIC}, {"CYL", RMAP_SEQ_CYLINDER},
                 {"YTO", RMAP_SEQ_Y_TOROID},   {"XTO", RMAP_SEQ_X_TOROID}};
    const struct command c = {lens, line, surface, shape};
    const double value = rmap_lens_value(word, n, 1, 0);
    const char *letter = strlen(key) == 2 ? strchr("ABCD", key[0]) : NULL;
    for (size_t i = 0; i < RMAP_COUNT(forms); i++)
        if (strcmp(key, forms[i].word) == 0) {
            shape->form = forms[i].form;
            return true;
        }
    if (strcmp(key, "SPS") == 0 && n > 1)
        set_form(&c, word[1], word, n);
    else if (strcmp(key, "SCO") == 0 && n > 2)
        read_coefficient(&c, word[1], rmap_lens_value(word, n, 2, 0));
    else if (strcmp(key, "CUX") == 0)
        shape->curvature_x = value;
    else if (strcmp(key, "RDX") == 0)
        shape->curvature_x = value != 0 ? 1 / value : 0;
    else if (strcmp(key, "KX") == 0)
        shape->conic_x = value;
    else if (strcmp(key, "KY") == 0)
        surface->conic = value;
    else if (letter && *letter && (key[1] == 'R' || key[1] == 'P'))
        shape->anamorphic[key[1] == 'P'][letter - "ABCD"] = value;
    else
        return false;
    return true;
}

/* A ((1 - P) x^2 + (1 + P) y^2)^m by powers of x and y. */
static void expand(struct rmap_lens_surface *surface, double a, double p, int m)
{
    double binomial = 1;
    for (int k = 0; k <= m; k++) { /* (x^2)^(m - k) (y^2)^k */
        (void)rmap_lens_add_term(surface, RMAP_TERMS_XY, 2 * (m - k), 2 * k,
                                 a * binomial * pow(1 - p, m - k) * pow(1 + p, k));
        binomial *= (double)(m - k) / (k + 1);
    }
}

void rmap_seq_shape_end(struct rmap_lens_surface *surface, const struct rmap_seq_shape *shape,
                        bool *turned)
{
    struct rmap_lens_figure *figure = &surface->figure;
    const double turn = shape->curvature_x != 0 ? 1 / shape->curvature_x : HUGE_VAL;
    *turned = false;
    switch (shape->form) {
    case RMAP_SEQ_ANAMORPHIC:
        figure->is_biconic = true;
        figure->curvature_x = shape->curvature_x;
        figure->conic_x = shape->conic_x;
        for (int k = 0; k < 4; k++)
            if (shape->anamorphic[0][k] != 0)
                expand(surface, shape->anamorphic[0][k], shape->anamorphic[1][k], k + 2);
        break;
    case RMAP_SEQ_CYLINDER:
        *turned = surface->curvature == 0 && shape->curvature_x != 0;
        figure->is_toroid = true;
        figure->turn = HUGE_VAL;
        if (*turned)
            surface->curvature = shape->curvature_x;
        break;
    case RMAP_SEQ_Y_TOROID:
        figure->is_toroid = true;
        figure->turn = turn;
        break;
    case RMAP_SEQ_X_TOROID: /* its profile lies in the plane of x and z */
        *turned = true;
        figure->is_toroid = true;
        figure->turn = surface->curvature != 0 ? 1 / surface->curvature : HUGE_VAL;
        surface->curvature = shape->curvature_x;
        break;
    case RMAP_SEQ_ODD:
        for (int i = 1; i <= surface->n_asphere && shape->norm > 0; i++)
            surface->asphere[i] /= pow(shape->norm, i);
        break;
    case RMAP_SEQ_PLAIN:
    case RMAP_SEQ_XY:
    case RMAP_SEQ_ZERNIKE:
    case RMAP_SEQ_FRINGE:
    case RMAP_SEQ_QCON:
    case RMAP_SEQ_QBFS:
    case RMAP_SEQ_FORMS:
        if (shape->norm > 0)
            figure->norm = shape->norm;
        break;
    }
}

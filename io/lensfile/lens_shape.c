/* SPDX-License-Identifier: MIT
 *
 * Surfaces of a prescription as shapes that rays can be traced through, for places and sizes.
 */
#include <math.h>

#include "base/alloc.h"
#include "io/lensfile/lens_layout.h"

struct rmap_shape rmap_lens_shape(const struct rmap_lens_surface *surface, double semi)
{
    struct rmap_shape shape = {.type = RMAP_SHAPE_CONIC,
                               .curvature = surface->curvature,
                               .conic = surface->conic,
                               .n_asphere = surface->n_asphere / 2,
                               .aperture = semi};
    for (int i = 2; i <= surface->n_asphere; i += 2)
        shape.asphere[i / 2 - 1] = surface->asphere[i];
    return shape;
}

static double reach(double curvature, double conic)
{
    const double c2 = (1 + conic) * curvature * curvature;
    return c2 > 0 ? 0.9999 / sqrt(c2) : HUGE_VAL;
}

double rmap_lens_reach(const struct rmap_lens_surface *surface)
{
    const struct rmap_lens_figure *f = &surface->figure;
    double least = reach(surface->curvature, surface->conic);
    if (f->is_biconic)
        least = fmin(least, reach(f->curvature_x, f->conic_x));
    if (f->is_toroid)
        least = fmin(least, reach(1 / f->turn, 0));
    return least;
}

bool rmap_lens_is_revolved(const struct rmap_lens_surface *surface)
{
    const struct rmap_lens_figure *f = &surface->figure;
    return !f->is_biconic && !f->is_toroid &&
           (f->n_term == 0 || f->terms == RMAP_TERMS_QCON || f->terms == RMAP_TERMS_QBFS);
}

static bool is_conic(const struct rmap_lens_surface *surface)
{
    const struct rmap_lens_figure *f = &surface->figure;
    for (int i = 1; i <= surface->n_asphere; i += 2)
        if (surface->asphere[i] != 0)
            return false;
    return !f->is_biconic && !f->is_toroid && !f->is_fresnel && f->n_term == 0;
}

static void set_zernike(const struct rmap_lens_figure *f, struct rmap_sag *sag)
{
    const enum rmap_zernike_order order =
        f->terms == RMAP_TERMS_NOLL ? RMAP_ZERNIKE_NOLL : RMAP_ZERNIKE_FRINGE;
    sag->zernike_norm = f->norm;
    for (int k = 0; k < f->n_term; k++) {
        int n = 0, m = 0;
        double norm = 1;
        if (!rmap_zernike_term(order, f->term[k].i, &n, &m, &norm) || n > RMAP_SAG_DEGREE)
            continue;
        sag->zernike[rmap_sag_term(n, (n + m) / 2)] += norm * f->term[k].value;
        sag->n_zernike = n + 1 > sag->n_zernike ? n + 1 : sag->n_zernike;
    }
}

static void set_terms(const struct rmap_lens_figure *f, struct rmap_sag *sag)
{
    switch (f->n_term > 0 ? f->terms : RMAP_TERMS_NONE) {
    case RMAP_TERMS_NONE:
        break;
    case RMAP_TERMS_FRINGE:
    case RMAP_TERMS_NOLL:
        set_zernike(f, sag);
        break;
    case RMAP_TERMS_XY:
        sag->xy_norm = f->norm;
        for (int k = 0; k < f->n_term; k++) {
            const int degree = f->term[k].i + f->term[k].j;
            if (degree > RMAP_SAG_DEGREE)
                continue;
            sag->xy[rmap_sag_term(degree, f->term[k].j)] = f->term[k].value;
            sag->n_xy = degree + 1 > sag->n_xy ? degree + 1 : sag->n_xy;
        }
        break;
    case RMAP_TERMS_QCON:
    case RMAP_TERMS_QBFS: {
        const bool con = f->terms == RMAP_TERMS_QCON;
        *(con ? &sag->qcon_norm : &sag->qbfs_norm) = f->norm;
        for (int k = 0; k < f->n_term && f->term[k].i < RMAP_SAG_Q; k++) {
            (con ? sag->qcon : sag->qbfs)[f->term[k].i] = f->term[k].value;
            *(con ? &sag->n_qcon : &sag->n_qbfs) = f->term[k].i + 1;
        }
        break;
    }
    }
}

static void make_sag(const struct rmap_lens_surface *surface, struct rmap_sag *sag)
{
    const struct rmap_lens_figure *f = &surface->figure;
    *sag = (struct rmap_sag){.base = f->is_biconic  ? RMAP_SAG_BICONIC
                                     : f->is_toroid ? RMAP_SAG_TOROID
                                                    : RMAP_SAG_CONIC,
                             .curvature = {surface->curvature, surface->curvature},
                             .conic = {surface->conic, surface->conic},
                             .n_power = surface->n_asphere,
                             .fresnel = f->is_fresnel};
    for (int i = 1; i <= surface->n_asphere; i++)
        sag->power[i - 1] = surface->asphere[i];
    if (f->is_biconic) {
        sag->curvature[0] = f->curvature_x;
        sag->conic[0] = f->conic_x;
    } else if (f->is_toroid) {
        sag->curvature[0] = 1 / f->turn; /* infinite: 0 */
        sag->conic[0] = 0;
    }
    set_terms(f, sag);
}

/* A circle about the axis, as wide as the surface is defined for; false: it is none at all. */
static bool fit_sag(const struct rmap_lens_surface *surface, double semi, struct rmap_sag *sag,
                    struct rmap_shape *shape)
{
    double radius = fmin(semi, rmap_lens_reach(surface));
    for (int i = 0; i < 10; i++, radius *= 0.7) {
        const struct rmap_aperture circle = {.half = {radius, radius}};
        make_sag(surface, sag);
        if (!rmap_shape_of_sag(shape, sag, &circle))
            return true;
    }
    return false;
}

/* Curvatures at the vertex along x and y: what bends rays near the axis. The r^2 terms and those of
 * sums count, too. */
static void set_vertex(const struct rmap_lens_surface *surface, const struct rmap_sag *sag,
                       double vertex[2])
{
    const struct rmap_lens_figure *f = &surface->figure;
    const double a2 = 2 * surface->asphere[2];
    vertex[1] = surface->curvature + a2;
    vertex[0] = f->is_biconic ? f->curvature_x + a2 : f->is_toroid ? 1 / f->turn : vertex[1];
    if (f->n_term == 0 || !sag)
        return;
    const double h = 1e-4 * f->norm;
    vertex[0] = (rmap_sag_profile(sag, h, 0).x - rmap_sag_profile(sag, -h, 0).x) / (2 * h);
    vertex[1] = (rmap_sag_profile(sag, 0, h).y - rmap_sag_profile(sag, 0, -h).y) / (2 * h);
}

enum rmap_status rmap_lens_shapes(struct rmap_lens_plan *plan, struct rmap_error *err)
{
    for (size_t i = 1; i < plan->lens->n_surface; i++) {
        const struct rmap_lens_surface *surface = &plan->lens->surface[i];
        struct rmap_lens_place *place = &plan->place[i];
        const double widest = surface->semi > 0 ? 1.5 * surface->semi : 3 * surface->figure.norm;
        place->shape = rmap_lens_shape(surface, 0);
        if (!is_conic(surface)) {
            place->sag = rmap_alloc(1, sizeof *place->sag);
            if (!place->sag)
                return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the shape of a surface");
            if (!fit_sag(surface, widest > 0 ? widest : plan->widest, place->sag, &place->shape)) {
                rmap_free(place->sag);
                place->sag = NULL;
                place->shape = rmap_lens_shape(surface, 0);
            }
        }
        set_vertex(surface, place->sag, place->vertex);
    }
    return RMAP_OK;
}

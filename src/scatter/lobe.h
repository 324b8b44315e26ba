/* SPDX-License-Identifier: MIT
 *
 * What draws and totals of lobes share.
 */
#ifndef RMAP_LOBE_H
#define RMAP_LOBE_H

#include <math.h>

#include "scatter/scatter.h"

static inline double rmap_lobe_number(const struct rmap_scattering *at, int k)
{
    return at->scatter->shape[k][at->channel];
}

/* beta0, shortened to the horizon. */
static inline struct rmap_vec3 rmap_lobe_centre(const struct rmap_scattering *at)
{
    double scale = at->scatter->model == RMAP_SCATTER_RETRO ? -1.0
                   : at->passes                             ? at->n1 / at->n2
                                                            : 1.0;
    struct rmap_vec3 beta = {scale * at->in.x, scale * at->in.y, 0.0};
    double square = beta.x * beta.x + beta.y * beta.y;
    return square < 1.0 ? beta : rmap_scale(beta, 1.0 / sqrt(square));
}

static inline double rmap_lobe_side(const struct rmap_scattering *at)
{
    return at->passes ? -1.0 : 1.0;
}

static inline double rmap_lift(double square)
{
    return square < 1.0 ? sqrt(1.0 - square) : 0.0;
}

/* The specular direction on the side that the lobe is on. */
static inline struct rmap_vec3 rmap_lobe_axis(const struct rmap_scattering *at)
{
    struct rmap_vec3 c = rmap_lobe_centre(at);
    return rmap_vec3(c.x, c.y, rmap_lobe_side(at) * rmap_lift(c.x * c.x + c.y * c.y));
}

/* Rayleigh and Rice's obliquity of reflected light. */
static inline bool rmap_lobe_is_oblique(const struct rmap_scattering *at)
{
    return at->scatter->model == RMAP_SCATTER_K_CORRELATION && !at->passes;
}

/* GAUSSIAN, RETRO, ABG, HARVEY, K_CORRELATION: the shape at x. What directions and their totals
 * depend on is portable; a BSDF need not be, and is cheaper. */
double rmap_lobe_radial(const struct rmap_scattering *at, double x, bool portable);

/* rmap_lobe_total of those, and of COSINE. */
double rmap_radial_total(const struct rmap_scattering *at);
double rmap_cosine_total(const struct rmap_scattering *at);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Light scattered by many spheres, each by itself (Bohren & Huffman 1983, section 13.1): all of one
 * diameter, or of diameters whose logarithm is normally distributed.
 */
#ifndef RMAP_SUSPENSION_H
#define RMAP_SUSPENSION_H

#include "optics/mie.h"

struct rmap_suspension {
    double diameter; /* median, > 0 */
    double sigma;    /* geometric standard deviation: 1 (all alike) to RMAP_SUSPENSION_SIGMA_MAX */
};
#define RMAP_SUSPENSION_SIGMA_MAX 4.0

/* Cross-sections over the mean geometric one. area, volume: means of a sphere's, in the diameter's
 * unit. */
struct rmap_suspended {
    struct rmap_mie mie;
    double area, volume;
};

/* The largest sphere that is looked at. */
double rmap_suspension_largest(const struct rmap_suspension *its);

/* wavelength: in the medium around, in the diameter's unit; n + i k relative to that. intensity:
 * [n_angle] as rmap_mie_scatter has it, the mean over the spheres, of any unit. pi x largest over
 * the wavelength is at most RMAP_MIE_SIZE_MAX. RMAP_SYSTEM. Of +, -, x, / and square roots alone.
 */
enum rmap_status rmap_suspension_scatter(const struct rmap_suspension *its, double wavelength,
                                         double n, double k, size_t n_angle, const double *cosine,
                                         double *intensity, struct rmap_suspended *suspended,
                                         struct rmap_error *err) RMAP_MUST_USE;

#endif

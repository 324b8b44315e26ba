/* SPDX-License-Identifier: MIT
 *
 * Light scattered by a sphere (G. Mie 1908, doi:10.1002/andp.19083300302; Bohren & Huffman,
 * Absorption and Scattering of Light by Small Particles, 1983, sections 4.4 and 4.8).
 */
#ifndef RMAP_MIE_H
#define RMAP_MIE_H

#include <stddef.h>

#include "base/status.h"

/* Cross-sections over the geometric one; `back`: 4 pi times that per solid angle straight back.
 * cosine: mean of the angle that light is turned by. */
struct rmap_mie {
    double scattered, extinct, back, cosine;
};

/* Size parameter x = pi d / lambda > 0, at most RMAP_MIE_SIZE_MAX, of index n + i k relative to the
 * medium around. cosine: [n_angle] of the angle by which light is turned. intensity: [n_angle], of
 * unpolarised light, per solid angle, so that its integral over the sphere is `scattered` x pi x^2.
 * RMAP_SYSTEM when memory is short. Of +, -, x, / and square roots alone. */
#define RMAP_MIE_SIZE_MAX 1e5
enum rmap_status rmap_mie_scatter(double x, double n, double k, size_t n_angle,
                                  const double *cosine, double *intensity, struct rmap_mie *mie,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

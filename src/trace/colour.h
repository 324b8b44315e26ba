/* SPDX-License-Identifier: MIT
 *
 * The colour of the ray in hand: shares of its flux per channel, summing to 1. An event of
 * probability p_i on channel i turns them into c_i p_i / sum c p (Bayes), so a path's
 * probability stays its share of the flux.
 */
#ifndef RMAP_COLOUR_H
#define RMAP_COLOUR_H

#include <stdbool.h>

#include "scene/scene.h"

struct rmap_colour {
    int n;          /* channels */
    int begin, end; /* the live ones lie in [begin, end); both ends of the range are live */
    double share[RMAP_CHANNEL_MAX]; /* [n]; 0 outside the range */
};

static inline bool rmap_colour_single(const struct rmap_colour *colour)
{
    return colour->end - colour->begin == 1;
}

/* Copies n shares. */
void rmap_colour_set(struct rmap_colour *colour, const double *share, int n);

/* All of it on one channel. */
void rmap_colour_collapse(struct rmap_colour *colour, int channel);

/* sum c_i p_i. p: [n], read on the live range. */
double rmap_colour_sum(const struct rmap_colour *colour, const double *p);

/* c_i <- c_i p_i / sum c p; false: all p are alike, and every bit is as it was. The sum must be >
 * 0.
 */
bool rmap_colour_weigh(struct rmap_colour *colour, const double *p);

/* A channel drawn with probability c_i p_i / sum c p by the uniform number u in (0, 1); p NULL:
 * with probability c_i. */
int rmap_colour_pick(const struct rmap_colour *colour, const double *p, double u);

#endif

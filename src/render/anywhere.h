/* SPDX-License-Identifier: MIT
 *
 * Ways that light goes and paths drawn backwards would miss.
 */
#ifndef RMAP_ANYWHERE_H
#define RMAP_ANYWHERE_H

#include "trace/scattering.h"
#include "trace/walk.h"

/* The side of the surface of a hit that light from the front, or from the back, meets. */
struct rmap_scatter_side rmap_walk_side_met(const struct rmap_walk *walk,
                                            const struct rmap_hit *hit, bool front,
                                            struct rmap_vec3 normal);
void rmap_walk_side_on_channel(int channel, struct rmap_scatter_side *side);

/* Some models send light to where they let none of it back from: measured ones, and unified facets
 * between two media, which are drawn so that light could both reflect and pass. A path that a model
 * draws backwards would miss such ways, so a share of the paths takes any direction (one sample of
 * a mixture: Veach 1997, section 9.2.4). */
struct rmap_anywhere {
    double share; /* 0: not at this surface */
    bool may[2];  /* reflected, passing */
};

void rmap_anywhere_find(const struct rmap_walk *walk, const struct rmap_hit *hit, bool front,
                        struct rmap_anywhere *any);

/* True: the path goes anywhere, as the decision says. */
bool rmap_anywhere_go(const struct rmap_walk *walk, const struct rmap_arrival *arrival, bool front,
                      const struct rmap_anywhere *any, struct rmap_decision *decision);

/* Paths go from the eye to the light: what a model sends the one way, over what it would send the
 * other, which the path was drawn by. */
double rmap_anywhere_way_back(const struct rmap_walk *walk, const struct rmap_hit *hit,
                              struct rmap_vec3 in, const struct rmap_anywhere *any,
                              const struct rmap_decision *decision);

#endif

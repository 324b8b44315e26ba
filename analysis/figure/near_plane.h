/* SPDX-License-Identifier: MIT
 *
 * Of many rays those that a section shows as they ran: all their way near its plane.
 */
#ifndef RMAP_NEAR_PLANE_H
#define RMAP_NEAR_PLANE_H

#include "analysis/figure/figure_view.h"
#include "portion/portion.h"

/* How near, and what came of it. */
struct rmap_near_plane {
    double distance;       /* scene units, above 0 */
    uint64_t most;         /* rays to keep */
    uint64_t looked, near; /* out: rays that were looked at, those of them that are near */
};

/* Keeps the first rays of which no point, from the start to the last event, is further from the
 * section's plane. rays: all columns; *rays is replaced. */
enum rmap_status rmap_near_plane_keep(const struct rmap_view *view, struct rmap_near_plane *near,
                                      struct rmap_portion **rays,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * The picture of a surface: which shares of the light it reflects, lets through and absorbs, over
 * the angle and, where the scene has light of several, over wavelength.
 */
#ifndef RMAP_FIGURE_SURFACE_H
#define RMAP_FIGURE_SURFACE_H

#include "io/export/svg.h"
#include "trace/surface_shares.h"

enum { RMAP_SURFACE_SIDES_MAX = 2, RMAP_FIGURE_INCIDENCES = 3 };
/* Angles of incidence, in degrees, at which a BSDF is shown. */
static const double rmap_figure_incidence[RMAP_FIGURE_INCIDENCES] = {0.0, 30.0, 60.0};

/* What is drawn. between: the scene once more with more channels, for smooth curves over
 * wavelength, on which the channels of `scene` are marked, and the same sides in it; NULL: of
 * `scene` alone. */
struct rmap_surface_picture {
    const struct rmap_scene *scene, *between;
    const struct rmap_surface_side *side, *side_between; /* [n], of one surface */
    size_t n;                                            /* 1 or 2 */
    int channel;                                         /* of the curves over the angle */
    const char *title;
};
enum rmap_status rmap_figure_surface(const struct rmap_surface_picture *its,
                                     struct rmap_svg **svg_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif

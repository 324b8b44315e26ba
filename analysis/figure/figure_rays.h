/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion as lines in the colour of their light, darkened to show on white paper, or in
 * the ink of their group.
 */
#ifndef RMAP_FIGURE_RAYS_H
#define RMAP_FIGURE_RAYS_H

#include "analysis/figure/figure_solid.h"
#include "analysis/figure/ray_paint.h"
#include "analysis/overlay/light_times.h"
#include "io/map/map_reader.h"
#include "portion/portion.h"

/* The light that is under way between two times, ns. */
struct rmap_time_window {
    const struct rmap_light_times *times; /* borrowed */
    double from, until;
};

/* How rays are drawn; all borrowed. */
struct rmap_ray_lines {
    const struct rmap_map *map; /* as in struct rmap_figure_draw */
    const struct rmap_view_frame *frame;
    const struct rmap_ray_paint *paint; /* NULL: in the colour of their light, all alike strong */
    const struct rmap_solid *solid;     /* what hides them, drawn faint then; NULL: nothing */
    double opacity;                     /* of the strongest; 0: by the number of rays */
    const struct rmap_time_window *window; /* NULL: whole rays */
};

/* Between two recorded points a curve is drawn in so many strokes. */
#define RMAP_RAY_CURVE_STROKES 4

/* rays has all columns; curved segments follow their points, and what leaves the scene goes on to
 * the edge of the picture. */
enum rmap_status rmap_rays_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                                const struct rmap_ray_lines *lines, struct rmap_svg *svg,
                                struct rmap_error *err) RMAP_MUST_USE;

/* Opacity of the strongest of so many rays. */
double rmap_ray_opacity(double n_ray);

/* "#rrggbb" of a colour, darkened until it shows on white paper; of light with these shares. */
void rmap_paper_ink(const double linear[3], char ink[8]);
void rmap_ray_ink(const struct rmap_scene *scene, const double *share, char ink[8]);

/* The ink of a segment, a row of /segment, of its light as it arrives or of the ray's group; its
 * dash, NULL: solid. */
const char *rmap_segment_ink(const struct rmap_scene *scene, const struct rmap_portion *rays,
                             const struct rmap_ray_paint *paint, size_t ray, size_t segment,
                             char ink[8]);

#endif

/* SPDX-License-Identifier: MIT
 *
 * The picture of a scene with rays: a section through it, or a view from above.
 */
#ifndef RMAP_FIGURE_DRAW_H
#define RMAP_FIGURE_DRAW_H

#include "analysis/detector/irradiance_cells.h"
#include "analysis/figure/figure_rays.h"
#include "analysis/figure/figure_view.h"
#include "analysis/figure/near_plane.h"
#include "analysis/figure/ray_paint.h"
#include "analysis/table/figure_axes.h"
#include "io/map/map_reader.h"
#include "portion/portion.h"

/* Objects in false colours of what their cells have, with a scale. */
struct rmap_figure_cells {
    const struct rmap_irradiance_cells *cells;
    const double *value;        /* [n_cell] */
    enum rmap_side side;        /* from which they are shown */
    struct rmap_colour_bar bar; /* without its place; the label is the quantity */
    const char *caption;
};

/* What all pictures of the same view share, made with the first. Zero, and not moved, before. */
struct rmap_figure_bodies {
    struct rmap_mesh **mesh; /* [n] */
    size_t n;
    struct rmap_solid *solid; /* NULL: a section */
    struct rmap_view view;
    struct rmap_view_frame frame; /* of `view` */
};
void rmap_figure_bodies_fini(struct rmap_figure_bodies *bodies);

struct rmap_figure_draw {
    const char *title;
    const char *criterion; /* NULL: all rays */
    uint64_t n_matched;    /* rays that match, of which `rays` holds some */
    enum rmap_view_kind kind;
    const double *eye;                /* [2] azimuth and elevation of a view of solids, degrees;
                                         NULL: as suits */
    const struct rmap_camera *camera; /* that sees the scene, in perspective; NULL: none */
    const double *cut;                /* place of a section along its axis; NULL: as suits */
    double stretch; /* of a section, upwards over to the right; 0: 1, or so that long ones fill the
                       picture */
    const struct rmap_near_plane *near;      /* what chose the rays; NULL: nothing of the sort */
    bool *misses_ret;                        /* or NULL: whether that is beside all objects */
    const struct rmap_ray_paint *paint;      /* of the rays; NULL: in the colour of their light */
    double opacity;                          /* of the strongest ray; 0: by their number */
    const struct rmap_figure_cells *painted; /* in a view of solids, large, in place of rays; NULL:
                                                none */
    const struct rmap_time_window *window;   /* the light under way then, and what was registered
                                                until then; NULL: whole rays */
    struct rmap_figure_bodies *bodies;       /* kept for the next picture; NULL: for none */
    const struct rmap_map *map; /* whose colour spaces the rays are in; NULL: that of the scene */
};

/* Segments, and strokes of curved ones, that are drawn unless more rays are asked for: more is a
 * blot that takes a renderer minutes. */
#define RMAP_FIGURE_STROKES 20000

/* Keeps the first rays whose strokes are RMAP_FIGURE_STROKES at most, one of them at least. rays:
 * has all columns; ids ascend. */
void rmap_figure_draw_thin(struct rmap_portion *rays);

/* Keeps rays that run near the plane of the section that the options, of which `kind` and `cut`
 * count, and these rays lead to; *kind becomes that section. RMAP_USAGE when it is a view of
 * solids.
 */
enum rmap_status rmap_figure_draw_near(const struct rmap_scene *scene, enum rmap_view_kind *kind,
                                       const double *cut, struct rmap_near_plane *near,
                                       struct rmap_portion **rays,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* rays: the rays to draw, all columns; NULL where objects are painted. */
enum rmap_status rmap_figure_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                                  const struct rmap_figure_draw *options, struct rmap_svg **svg_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

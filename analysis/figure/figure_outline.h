/* SPDX-License-Identifier: MIT
 *
 * Lines of a figure in view coordinates: where a plane cuts a mesh, chained into long runs.
 */
#ifndef RMAP_FIGURE_OUTLINE_H
#define RMAP_FIGURE_OUTLINE_H

#include "analysis/figure/figure_view.h"

struct rmap_outline {
    double (*point)[2]; /* [n_point] */
    size_t n_point, point_cap;
    struct rmap_outline_run {
        size_t first, n; /* points */
        bool closed;     /* the last point is the first again */
    } * run;             /* [n_run] */
    size_t n_run, run_cap;
};

void rmap_outline_fini(struct rmap_outline *outline);

/* A point of the last run. */
enum rmap_status rmap_outline_add(struct rmap_outline *outline, double u, double v,
                                  struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_outline_begin(struct rmap_outline *outline,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Appends the cut of an instance of a welded mesh by the view's plane. */
enum rmap_status rmap_outline_cut(struct rmap_outline *outline, const struct rmap_mesh *mesh,
                                  const struct rmap_affine *to_world, const struct rmap_view *view,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Draws runs [first, first + n_run) into a frame, as one path. */
enum rmap_status rmap_outline_draw(const struct rmap_outline *outline, size_t first, size_t n_run,
                                   const struct rmap_view_frame *frame, struct rmap_svg *svg,
                                   const struct rmap_svg_style *style,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * What a lighting plan has over an image: lines of equal value, and values in the cells.
 */
#ifndef RMAP_FIGURE_ISOLINES_H
#define RMAP_FIGURE_ISOLINES_H

#include "analysis/table/figure_axes.h"

/* Values at the middles of cells that fill the axes, lower left first. */
struct rmap_cell_grid {
    uint32_t n[2]; /* to the right, upwards */
    double (*value)(const void *context, uint32_t i, uint32_t j);
    const void *context;
};

struct rmap_isolines {
    const struct rmap_colour_bar *bar;
    const double *level; /* [n_level]; 0: round values between those of the bar */
    size_t n_level;
    bool labelled; /* each line with its value */
};

/* By linear interpolation between the middles of four cells. RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_isolines_draw(struct rmap_svg *svg, const struct rmap_axes *axes,
                                    const struct rmap_cell_grid *grid,
                                    const struct rmap_isolines *which,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Pixels that a cell must be wide and high for its value to be read. */
#define RMAP_CELL_WIDTH  30.0
#define RMAP_CELL_HEIGHT 14.0
void rmap_cell_values_draw(struct rmap_svg *svg, const struct rmap_axes *axes,
                           const struct rmap_cell_grid *grid);

#endif

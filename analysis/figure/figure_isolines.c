/* SPDX-License-Identifier: MIT
 *
 * What a lighting plan has over an image: lines of equal value, and values in the cells.
 */
#include "analysis/figure/figure_isolines.h"

#include <math.h>
#include <stdio.h>

#include "analysis/detector/lux_table.h"
#include "base/alloc.h"

enum { LEVELS = 9, LABELS = 200, SAME_APART = 170, LABEL_WIDTH = 44, LABEL_HEIGHT = 18 };

/* Of a cell's side; a line about one cell has pieces of 0.71 at most. */
static const double PIECE_LEAST = 0.75;

struct labels {
    size_t n;
    struct label {
        double at[2], level;
    } label[LABELS];
};

struct lines {
    const struct rmap_axes *axes;
    const struct rmap_cell_grid *grid;
    double (*point)[2]; /* pieces of two points, and one with a NaN behind each */
    size_t n, cap;
};

/* The middle of a cell; i and j may lie between two. */
static void middle(const struct rmap_axes *axes, const struct rmap_cell_grid *grid, double i,
                   double j, double at[2])
{
    at[0] = axes->x + axes->width * (i + 0.5) / grid->n[0];
    at[1] = axes->y + axes->height * (1.0 - (j + 0.5) / grid->n[1]);
}

static enum rmap_status add_piece(struct lines *lines, const double from[2], const double to[2],
                                  struct rmap_error *err)
{
    const enum rmap_status st = RMAP_RESERVE(lines->point, lines->cap, lines->n + 3, err);
    if (st != RMAP_OK)
        return st;
    for (int k = 0; k < 2; k++) {
        lines->point[lines->n][k] = from[k];
        lines->point[lines->n + 1][k] = to[k];
        lines->point[lines->n + 2][k] = (double)NAN;
    }
    lines->n += 3;
    return RMAP_OK;
}

/* Between the middles of four cells, of which (i, j) is the lower left one: where the value passes
 * the level on their sides, in turn; two or four places. Of four, those are joined between which
 * the mean lies on the other side. */
static enum rmap_status add_square(struct lines *lines, uint32_t i, uint32_t j, double level,
                                   struct rmap_error *err)
{
    static const double corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    const struct rmap_cell_grid *grid = lines->grid;
    enum rmap_status st = RMAP_OK;
    double value[5], place[4][2], mean = 0.0;
    int n = 0;
    for (int k = 0; k < 4; k++) {
        value[k] =
            grid->value(grid->context, i + (uint32_t)corner[k][0], j + (uint32_t)corner[k][1]);
        mean += 0.25 * value[k];
    }
    value[4] = value[0];
    for (int k = 0; k < 4; k++) {
        if ((value[k] < level) == (value[k + 1] < level))
            continue;
        const double t = (level - value[k]) / (value[k + 1] - value[k]);
        middle(lines->axes, grid, i + corner[k][0] + t * (corner[k + 1][0] - corner[k][0]),
               j + corner[k][1] + t * (corner[k + 1][1] - corner[k][1]), place[n++]);
    }
    const int shift = n == 4 && (value[0] < level) != (mean < level) ? 3 : 0;
    for (int k = 0; k + 1 < n; k += 2)
        RMAP_TRY(add_piece(lines, place[(k + shift) % n], place[(k + 1 + shift) % n], err));
out:
    return st;
}

/* Far from those of the same level, beside those of others. */
static bool has_room(const struct labels *labels, double level, const double at[2])
{
    for (size_t k = 0; k < labels->n; k++) {
        const struct label *other = &labels->label[k];
        const double x = fabs(other->at[0] - at[0]), y = fabs(other->at[1] - at[1]);
        const bool same = !(other->level < level) && !(other->level > level);
        if (same ? hypot(x, y) < SAME_APART : x < LABEL_WIDTH && y < LABEL_HEIGHT)
            return false;
    }
    return true;
}

/* From the middle of its pieces on, wherever there is room, so that separate lines have theirs.
 * Pieces at least that long: those about a single cell, which a number would hide, are shorter. */
static size_t label(struct rmap_svg *svg, const struct lines *lines, double level, double least,
                    struct labels *labels)
{
    const size_t n_piece = lines->n / 3, before = labels->n;
    char text[32];
    (void)snprintf(text, sizeof text, "%.6g", level);
    for (size_t k = 0; k < n_piece && labels->n < LABELS; k++) {
        const size_t first = (n_piece / 2 + k) % n_piece * 3;
        const double *at = lines->point[first], *end = lines->point[first + 1];
        if (hypot(end[0] - at[0], end[1] - at[1]) < least || !has_room(labels, level, at))
            continue;
        labels->label[labels->n++] = (struct label){{at[0], at[1]}, level};
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = at[0],
                                                .y = at[1] + 4.0,
                                                .size = RMAP_TICK_SIZE,
                                                .anchor = RMAP_SVG_MIDDLE,
                                                .halo = "#ffffff"},
                        text);
    }
    return labels->n - before;
}

enum rmap_status rmap_isolines_draw(struct rmap_svg *svg, const struct rmap_axes *axes,
                                    const struct rmap_cell_grid *grid,
                                    const struct rmap_isolines *which, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct lines lines = {.axes = axes, .grid = grid};
    struct labels labels = {.n = 0};
    struct rmap_ticks ticks;
    const struct rmap_colour_bar *bar = which->bar;
    if (bar->logarithmic)
        rmap_ticks_powers(bar->range[0], bar->range[1], LEVELS, &ticks);
    else
        rmap_ticks_linear(bar->range[0], bar->range[1], LEVELS, &ticks);
    const double least = PIECE_LEAST * fmin(axes->width / grid->n[0], axes->height / grid->n[1]);
    const double *level = which->n_level > 0 ? which->level : ticks.value;
    const size_t n_level = which->n_level > 0 ? which->n_level : (size_t)ticks.n;
    for (size_t k = 0; k < n_level; k++) {
        lines.n = 0;
        for (uint32_t j = 0; j + 1 < grid->n[1]; j++)
            for (uint32_t i = 0; i + 1 < grid->n[0]; i++)
                RMAP_TRY(add_square(&lines, i, j, level[k], err));
        if (lines.n == 0)
            continue;
        rmap_svg_path(svg, (const double(*)[2])lines.point, lines.n,
                      &(struct rmap_svg_style){.stroke = "#ffffff", .width = 2.4, .opacity = 0.6});
        rmap_svg_path(svg, (const double(*)[2])lines.point, lines.n,
                      &(struct rmap_svg_style){.stroke = "#000000", .width = 1.0});
        if (which->labelled && label(svg, &lines, level[k], least, &labels) == 0)
            (void)label(svg, &lines, level[k], 0.0, &labels);
    }
out:
    rmap_free(lines.point);
    return st;
}

void rmap_cell_values_draw(struct rmap_svg *svg, const struct rmap_axes *axes,
                           const struct rmap_cell_grid *grid)
{
    char text[32];
    double at[2];
    for (uint32_t j = 0; j < grid->n[1]; j++)
        for (uint32_t i = 0; i < grid->n[0]; i++) {
            middle(axes, grid, i, j, at);
            rmap_lux_text(grid->value(grid->context, i, j), text);
            rmap_svg_string(svg,
                            &(struct rmap_svg_text){.x = at[0],
                                                    .y = at[1] + 4.0,
                                                    .size = 11.0,
                                                    .anchor = RMAP_SVG_MIDDLE,
                                                    .halo = "#ffffff"},
                            text);
        }
}

/* SPDX-License-Identifier: MIT
 *
 * The picture of materials over wavelength.
 */
#include "analysis/figure/figure_glass.h"

#include <math.h>
#include <stdio.h>

#include "analysis/table/figure_axes.h"
#include "analysis/table/line_mark.h"

enum { LEFT = 92, TOP = 72, RIGHT = 30, GAP = 62, BOTTOM = 62, WIDTH = 720 };
enum { INDEX_HEIGHT = 300, LOSS_HEIGHT = 200, SAMPLES = 600 };
enum { LEGEND_GAP = 18, LEGEND_RIGHT = 210, LEGEND_ROW = 20 };
#define PATH_MM 10.0

enum curve { INDEX, TRANSMITTANCE, EXTINCTION };

struct plot {
    const struct rmap_glass *glass;
    size_t n;
    struct rmap_axes axes[2]; /* of the index; of what is below it */
    enum curve lower;
    bool has_lower;
    struct rmap_svg *svg;
};

static double value_of(const struct rmap_glass *glass, enum curve curve, double nm)
{
    if (curve == INDEX)
        return nm >= glass->from_nm && nm <= glass->to_nm ? rmap_glass_index(glass, nm)
                                                          : (double)NAN;
    double transmittance = rmap_glass_transmittance(glass, nm, PATH_MM);
    return curve == TRANSMITTANCE || isnan(transmittance) ? transmittance
                                                          : rmap_glass_extinction(glass, nm);
}

/* The k-th wavelength across the axes. */
static double sample_nm(const struct rmap_axes *axes, size_t k)
{
    double at = axes->x_range[0] +
                (axes->x_range[1] - axes->x_range[0]) * (double)k / (double)(SAMPLES - 1);
    return axes->x_powers ? pow(10.0, at) : at;
}

static void range_of(const struct plot *plot, enum curve curve, double range[2])
{
    range[0] = (double)INFINITY;
    range[1] = -(double)INFINITY;
    for (size_t g = 0; g < plot->n; g++)
        for (size_t k = 0; k < SAMPLES; k++) {
            double value = value_of(&plot->glass[g], curve, sample_nm(&plot->axes[0], k));
            range[0] = fmin(range[0], value); /* a NaN is no number to fmin */
            range[1] = fmax(range[1], value);
        }
}

static void set_axes(struct plot *plot)
{
    /* Beyond that ratio the visible is a sliver of a linear axis. */
    const double MOST_LINEAR = 12.0, TRANSPARENT = 0.01;
    double from = (double)INFINITY, to = 0.0, range[2];
    for (size_t g = 0; g < plot->n; g++) {
        from = fmin(from, plot->glass[g].from_nm);
        to = fmax(to, plot->glass[g].to_nm);
    }
    const bool powers = to > MOST_LINEAR * from;
    for (int i = 0; i < 2; i++)
        plot->axes[i] =
            (struct rmap_axes){.x = LEFT,
                               .y = i ? TOP + INDEX_HEIGHT + GAP : TOP,
                               .width = WIDTH,
                               .height = i ? LOSS_HEIGHT : INDEX_HEIGHT,
                               .x_range = {powers ? log10(from) : from, powers ? log10(to) : to},
                               .x_powers = powers,
                               .x_label = "wavelength",
                               .x_unit = "nm",
                               .y_label = "refractive index n",
                               .y_unit = ""};
    range_of(plot, INDEX, range);
    const double margin = fmax(0.05 * (range[1] - range[0]), 1e-4);
    plot->axes[0].y_range[0] = fmax(0.0, range[0] - margin);
    plot->axes[0].y_range[1] = range[1] + margin;
    range_of(plot, TRANSMITTANCE, range);
    plot->has_lower = range[1] >= range[0];
    plot->lower = range[1] < TRANSPARENT ? EXTINCTION : TRANSMITTANCE;
    plot->axes[1].y_range[1] = 1.02;
    plot->axes[1].y_label = "transmittance of 10 mm";
    if (plot->lower == EXTINCTION) {
        range_of(plot, EXTINCTION, range);
        plot->axes[1].y_range[1] = 1.05 * range[1];
        plot->axes[1].y_label = "extinction k";
    }
}

static void draw_curves(const struct plot *plot, const struct rmap_axes *axes, enum curve curve)
{
    double point[SAMPLES][2];
    rmap_svg_open_clip(plot->svg, axes->x, axes->y, axes->width, axes->height);
    for (size_t g = 0; g < plot->n; g++) {
        const struct rmap_line_mark mark = rmap_line_mark(g);
        for (size_t k = 0; k < SAMPLES; k++) {
            const double nm = sample_nm(axes, k);
            point[k][0] = rmap_axes_x(axes, axes->x_powers ? log10(nm) : nm);
            point[k][1] = rmap_axes_y(axes, value_of(&plot->glass[g], curve, nm));
        }
        rmap_svg_path(
            plot->svg, (const double(*)[2])point, SAMPLES,
            &(struct rmap_svg_style){.stroke = mark.ink, .width = 1.8, .dash = mark.dash});
    }
    rmap_svg_close(plot->svg);
    rmap_axes_draw(plot->svg, axes);
}

static void draw_captions(const struct plot *plot)
{
    char title[600], line[600];
    const struct rmap_glass *glass = plot->glass;
    (void)snprintf(title, sizeof title, "%s %s", glass->group, glass->name);
    if (plot->n > 1)
        (void)snprintf(title, sizeof title, "%zu materials", plot->n);
    (void)snprintf(line, sizeof line, "nd %.5f, vd %.2f; %s", glass->nd, glass->vd, glass->source);
    const char *const row[] = {title, isnan(glass->nd + glass->vd) ? glass->source : line};
    rmap_captions(plot->svg, 16, row, plot->n == 1 ? 2 : 1);
    for (size_t g = 0; plot->n > 1 && g < plot->n; g++) {
        const struct rmap_line_mark mark = rmap_line_mark(g);
        const double x = LEFT + WIDTH + LEGEND_GAP, y = TOP + 12 + (double)(LEGEND_ROW * g);
        rmap_svg_line(
            plot->svg, x, y - 4, x + 22, y - 4,
            &(struct rmap_svg_style){.stroke = mark.ink, .width = 2.4, .dash = mark.dash});
        (void)snprintf(line, sizeof line, "%s %s", glass[g].group, glass[g].name);
        const struct rmap_svg_text name = {.x = x + 29, .y = y, .size = RMAP_TICK_SIZE};
        rmap_caption(plot->svg, &name, LEGEND_RIGHT - LEGEND_GAP - 37, line);
    }
}

enum rmap_status rmap_figure_glass(const struct rmap_glass *glass, size_t n,
                                   struct rmap_svg **svg_ret, struct rmap_error *err)
{
    struct plot plot = {.glass = glass, .n = n};
    set_axes(&plot);
    const double width = LEFT + WIDTH + (n > 1 ? LEGEND_RIGHT : RIGHT);
    const double height = TOP + INDEX_HEIGHT + BOTTOM + (plot.has_lower ? GAP + LOSS_HEIGHT : 0);
    enum rmap_status st = rmap_svg_create(width, height, "materials", &plot.svg, err);
    if (st != RMAP_OK)
        return st;
    draw_curves(&plot, &plot.axes[0], INDEX);
    if (plot.has_lower)
        draw_curves(&plot, &plot.axes[1], plot.lower);
    draw_captions(&plot);
    *svg_ret = plot.svg;
    return RMAP_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * The curves of a spot: encircled energy over the radius, and the MTF beside it, with bands of one
 * standard error.
 */
#include "analysis/figure/figure_spot.h"

#include <math.h>
#include <stdio.h>

#include "analysis/table/figure_axes.h"

enum { LEFT = 82, TOP = 84, GAP = 110, RIGHT = 30, BOTTOM = 60, WIDTH = 480, HEIGHT = 360 };

#define POINTS_MAX 512

struct curve {
    const struct rmap_estimate *estimate;
    size_t n;
    const double *at; /* NULL: multiples of step */
    double step;
    const char *colour, *dash;
};

static void draw_curve(struct rmap_svg *svg, const struct rmap_axes *axes,
                       const struct curve *curve)
{
    double line[POINTS_MAX][2], band[2 * POINTS_MAX][2];
    size_t n = 0, n_band = 0;
    for (size_t i = 0; i < curve->n && i < POINTS_MAX; i++) {
        const double x = curve->at ? curve->at[i] : curve->step * (double)i;
        const struct rmap_estimate e = curve->estimate[i];
        if (!isfinite(x) || !isfinite(e.value))
            continue;
        line[n][0] = rmap_axes_x(axes, x);
        line[n++][1] = rmap_axes_y(axes, e.value);
    }
    for (size_t i = 0; i < 2 * curve->n && curve->n <= POINTS_MAX; i++) {
        const size_t k = i < curve->n ? i : 2 * curve->n - 1 - i;
        const struct rmap_estimate e = curve->estimate[k];
        const double x = curve->at ? curve->at[k] : curve->step * (double)k;
        if (!isfinite(x) || !isfinite(e.value) || !isfinite(e.standard_error))
            continue;
        band[n_band][0] = rmap_axes_x(axes, x);
        band[n_band++][1] =
            rmap_axes_y(axes, e.value + (i < curve->n ? 1.0 : -1.0) * e.standard_error);
    }
    rmap_svg_path(svg, (const double(*)[2])band, n_band,
                  &(struct rmap_svg_style){.fill = curve->colour, .opacity = 0.2});
    rmap_svg_path(
        svg, (const double(*)[2])line, n,
        &(struct rmap_svg_style){.stroke = curve->colour, .width = 2.0, .dash = curve->dash});
}

static void draw_key(struct rmap_svg *svg, double x, double y, const struct curve *curve,
                     const char *text)
{
    rmap_svg_line(
        svg, x, y, x + 28, y,
        &(struct rmap_svg_style){.stroke = curve->colour, .width = 2.0, .dash = curve->dash});
    rmap_svg_string(svg,
                    &(struct rmap_svg_text){.x = x + 34,
                                            .y = y + 0.35 * RMAP_TICK_SIZE,
                                            .size = RMAP_TICK_SIZE,
                                            .fill = "#222222",
                                            .halo = "#ffffff"},
                    text);
}

static struct rmap_axes panel(double x, double longest, const char *label, const char *unit,
                              const char *value)
{
    return (struct rmap_axes){.x = x,
                              .y = TOP,
                              .width = WIDTH,
                              .height = HEIGHT,
                              .x_range = {0.0, longest > 0.0 ? longest : 1.0},
                              .y_range = {0.0, 1.0},
                              .x_label = label,
                              .y_label = value,
                              .x_unit = unit,
                              .y_unit = ""};
}

static void draw_energy(struct rmap_svg *svg, const struct rmap_spot *spot)
{
    struct rmap_axes axes = panel(LEFT, spot->curve_radius[RMAP_SPOT_CURVE - 1], "radius",
                                  spot->unit, "encircled energy");
    const struct curve curve = {spot->curve, RMAP_SPOT_CURVE, spot->curve_radius,
                                0.0,         "#1f77b4",       NULL};
    rmap_svg_open_clip(svg, axes.x, axes.y, axes.width, axes.height);
    draw_curve(svg, &axes, &curve);
    rmap_svg_close(svg);
    for (int i = 0; i < RMAP_SPOT_FRACTIONS; i++) {
        const double radius = spot->radius[i].value;
        char text[64];
        if (!isfinite(radius) || radius > axes.x_range[1])
            continue;
        const double x = rmap_axes_x(&axes, radius), y = rmap_axes_y(&axes, spot->fraction[i]);
        rmap_svg_circle(svg, x, y, 3.5, &(struct rmap_svg_style){.fill = "#1f77b4"});
        (void)snprintf(text, sizeof text, "%.0f %%: %.4g %s", 100.0 * spot->fraction[i], radius,
                       spot->unit);
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = x + 8,
                                                .y = y + 16,
                                                .size = RMAP_TICK_SIZE,
                                                .fill = "#222222",
                                                .halo = "#ffffff"},
                        text);
    }
    rmap_axes_draw(svg, &axes);
}

static void draw_mtf(struct rmap_svg *svg, const struct rmap_spot *spot)
{
    const size_t n = spot->n_frequency;
    char unit[32];
    (void)snprintf(unit, sizeof unit, "cycles/%.20s", spot->unit);
    struct rmap_axes axes =
        panel(LEFT + WIDTH + GAP, spot->frequency_step * (double)(n - 1), "frequency", unit, "MTF");
    const struct curve curve[2] = {
        {spot->mtf, n, NULL, spot->frequency_step, "#d62728", NULL},
        {spot->mtf + n, n, NULL, spot->frequency_step, "#2ca02c", "6 4"}};
    rmap_svg_open_clip(svg, axes.x, axes.y, axes.width, axes.height);
    for (int i = 0; i < 2; i++)
        draw_curve(svg, &axes, &curve[i]);
    rmap_svg_close(svg);
    draw_key(svg, axes.x + axes.width - 130, axes.y + 22, &curve[0], "tangential");
    draw_key(svg, axes.x + axes.width - 130, axes.y + 42, &curve[1], "sagittal");
    rmap_axes_draw(svg, &axes);
}

static void draw_captions(struct rmap_svg *svg, const struct rmap_spot *spot, const char *detector,
                          const char *criterion)
{
    char title[256], asked[1024], line[1024];
    (void)snprintf(title, sizeof title, "%.200s: spot", detector);
    rmap_which_caption(spot->which, criterion, asked, sizeof asked);
    if (isfinite(spot->rms_radius.value))
        (void)snprintf(
            line, sizeof line,
            "centroid x %.4g ± %.2g, y %.4g ± %.2g %s; RMS radius %.4g ± %.2g %s; bands: "
            "one standard error",
            spot->centroid[0].value, spot->centroid[0].standard_error, spot->centroid[1].value,
            spot->centroid[1].standard_error, spot->unit, spot->rms_radius.value,
            spot->rms_radius.standard_error, spot->unit);
    else
        (void)snprintf(line, sizeof line, "nothing was registered");
    rmap_captions(svg, 16, (const char *const[]){title, asked, line}, 3);
}

enum rmap_status rmap_figure_spot(const struct rmap_spot *spot, const char *detector,
                                  const char *criterion, struct rmap_svg **svg_ret,
                                  struct rmap_error *err)
{
    const double width = LEFT + WIDTH + RIGHT + (spot->n_frequency ? GAP + WIDTH : 0);
    struct rmap_svg *svg = NULL;
    enum rmap_status st = rmap_svg_create(width, TOP + HEIGHT + BOTTOM, detector, &svg, err);
    if (st != RMAP_OK)
        return st;
    draw_energy(svg, spot);
    if (spot->n_frequency)
        draw_mtf(svg, spot);
    draw_captions(svg, spot, detector, criterion);
    *svg_ret = svg;
    return RMAP_OK;
}

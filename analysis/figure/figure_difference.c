/* SPDX-License-Identifier: MIT
 *
 * The picture of what differs where. Of an image: the difference, and beside it z, blue where the
 * first sample has less and red where it has more. Of a number: both samples with bands of one
 * standard error, and z below.
 */
#include <math.h>
#include <stdio.h>

#include "analysis/compare/compare_bins.h"
#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_difference.h"
#include "analysis/table/figure_axes.h"
#include "base/alloc.h"
#include "io/export/raster.h"

enum { LEFT = 88, TOP = 104, BOTTOM = 60, GAP = 150, LONGEST = 460, SHORTEST = 60 };
enum { BAR_GAP = 18, BAR_WIDTH = 18, BAR_SHORTEST = 160, PROFILE = 760, HIGH = 330, LOW = 170 };

/* z beyond this is drawn as this: 4 is 1 in 16,000. */
static const double Z_MOST = 4.0;

/* Oklab: lightness and chroma of the ends, and their hues (blue, red); white between them. */
static const double END_LIGHTNESS = 0.48, END_CHROMA = 0.15, BLUE_DEG = 260.0, RED_DEG = 25.0;

static const char *const ink[2] = {"#0072b2", "#d55e00"};

static void set_diverging(struct rmap_colour_map *map)
{
    for (int i = 0; i < RMAP_COLOUR_MAP_STEPS; i++) {
        const double t = 2.0 * i / (RMAP_COLOUR_MAP_STEPS - 1) - 1.0, size = fabs(t);
        const double hue = (t < 0.0 ? BLUE_DEG : RED_DEG) * RMAP_PI / 180.0;
        const double lab[3] = {0.98 + size * (END_LIGHTNESS - 0.98), size * END_CHROMA * cos(hue),
                               size * END_CHROMA * sin(hue)};
        double rgb[3];
        rmap_oklab_to_rgb(lab, rgb);
        rmap_srgb_encode(rgb, map->rgb[i]);
    }
}

/* One panel of an image. */
struct panel {
    const struct rmap_compare_bins *bins;
    const double *value;
    struct rmap_axes axes;
    struct rmap_colour_bar bar;
};

static void set_axes(const struct rmap_compare_bins *bins, struct rmap_axes *axes)
{
    const struct rmap_detector_bins *grid = &bins->grid;
    const double degree = 180.0 / RMAP_PI;
    *axes = (struct rmap_axes){.x = LEFT, .y = TOP, .x_label = "x", .y_label = "y"};
    for (int k = 0; k < 2; k++) {
        axes->x_range[k] = k == 0 ? grid->low[0] : grid->high[0];
        axes->y_range[k] = k == 0 ? grid->low[1] : grid->high[1];
        if (grid->directions) {
            axes->x_range[k] = (k == 0 ? grid->low[1] : grid->high[1]) * degree;
            axes->y_range[k] = (k == 0 ? grid->low[0] : grid->high[0]) * degree;
        }
    }
    if (grid->directions) {
        axes->x_label = "φ";
        axes->y_label = "θ";
    }
    axes->x_unit = axes->y_unit = bins->axis_unit;
    const double aspect =
        (axes->x_range[1] - axes->x_range[0]) / (axes->y_range[1] - axes->y_range[0]);
    axes->width = fmax(rint(fmin(LONGEST, LONGEST * aspect)), SHORTEST);
    axes->height = fmax(rint(fmin(LONGEST, LONGEST / aspect)), SHORTEST);
}

static double largest(const double *value, size_t n)
{
    double most = 0.0;
    for (size_t b = 0; b < n; b++)
        if (isfinite(value[b]))
            most = fmax(most, fabs(value[b]));
    return most > 0.0 ? most : 1.0;
}

static size_t cell_at(uint32_t pixel, uint32_t n_pixel, size_t n)
{
    return (size_t)((uint64_t)pixel * n / n_pixel);
}

static enum rmap_status draw_panel(const struct panel *panel, struct rmap_svg *svg,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_axes *axes = &panel->axes;
    const struct rmap_compare_bins *bins = panel->bins;
    const bool directions = bins->grid.directions;
    const uint32_t width = (uint32_t)(axes->width * RMAP_FIGURE_SCALE);
    const uint32_t height = (uint32_t)(axes->height * RMAP_FIGURE_SCALE);
    struct rmap_colour_map map;
    uint8_t *rgb = rmap_alloc((size_t)width * height, 3), *png = NULL;
    size_t nbytes = 0;
    set_diverging(&map);
    if (!rgb)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            const size_t across = cell_at(x, width, bins->n[directions ? 1 : 0]);
            const size_t up = cell_at(height - 1 - y, height, bins->n[directions ? 0 : 1]);
            const double value =
                panel->value[directions ? up + across * bins->n[0] : across + up * bins->n[0]];
            /* where nothing can be said, nothing differs */
            rmap_colour_map_at(&map,
                               rmap_colour_bar_place(&panel->bar, isfinite(value) ? value : 0.0),
                               rgb + 3 * ((size_t)y * width + x));
        }
    RMAP_TRY(rmap_png_encode(rgb, width, height, &png, &nbytes, err));
    rmap_svg_image(svg, axes->x, axes->y, axes->width, axes->height, png, nbytes);
    rmap_axes_draw(svg, axes);
    st = rmap_colour_bar_draw(svg, &panel->bar, &map, err);
out:
    rmap_free(rgb);
    rmap_free(png);
    return st;
}

static void set_panel(const struct rmap_compare_bins *bins, bool of_z, struct panel *panel)
{
    const size_t n = bins->n[0] * bins->n[1];
    const double most = of_z ? Z_MOST : largest(bins->difference, n);
    *panel = (struct panel){.bins = bins, .value = of_z ? bins->z : bins->difference};
    set_axes(bins, &panel->axes);
    if (of_z)
        panel->axes.x += panel->axes.width + GAP + BAR_GAP + BAR_WIDTH;
    panel->bar = (struct rmap_colour_bar){.x = panel->axes.x + panel->axes.width + BAR_GAP,
                                          .y = panel->axes.y,
                                          .width = BAR_WIDTH,
                                          .height = fmax(panel->axes.height, BAR_SHORTEST),
                                          .range = {-most, most},
                                          .label = of_z ? "z" : "A - B",
                                          .unit = of_z ? "" : bins->unit};
}

static void draw_captions(const struct rmap_comparison *comparison,
                          const struct rmap_compare_bins *bins, struct rmap_svg *svg)
{
    char title[1024], sample[2][1024];
    bool light = false;
    (void)snprintf(title, sizeof title, "%s: difference of %s", bins->name, bins->quantity);
    for (int k = 0; k < 2; k++) {
        char *line = sample[k];
        const int n =
            snprintf(line, sizeof sample[k], "%c: %.300s, ", 'A' + k, comparison->path[k]);
        rmap_which_caption(comparison->which[k], comparison->criterion[k], line + n,
                           sizeof sample[k] - (size_t)n);
        for (size_t b = 0; b < bins->n[0] * bins->n[1]; b++)
            light = light || bins->value[k][b] != 0.0;
    }
    rmap_captions(svg, 16,
                  (const char *const[]){title, sample[0], sample[1],
                                        "nothing to compare: no light in any bin of either sample"},
                  light ? 3 : 4);
}

static enum rmap_status draw_image(const struct rmap_comparison *comparison,
                                   const struct rmap_compare_bins *bins, struct rmap_svg **svg_ret,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    struct panel panel[2];
    for (int k = 0; k < 2; k++)
        set_panel(bins, k == 1, &panel[k]);
    RMAP_TRY(rmap_svg_create(panel[1].bar.x + BAR_WIDTH + GAP / 2.0,
                             TOP + fmax(panel[0].axes.height, BAR_SHORTEST) + BOTTOM, bins->name,
                             &svg, err));
    for (int k = 0; k < 2; k++)
        RMAP_TRY(draw_panel(&panel[k], svg, err));
    draw_captions(comparison, bins, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    rmap_svg_destroy(svg);
    return st;
}

/* ---- a number ---- */

static double known(double value)
{
    return isfinite(value) ? value : 0.0;
}

/* Steps along the bins: a closed band between two heights, or one line (upper NULL). point: room
 * for 4 n. */
static void draw_steps(const struct rmap_axes *axes, const struct rmap_compare_bins *bins,
                       const double *height, const double *error, const struct rmap_svg_style *as,
                       double (*point)[2], struct rmap_svg *svg)
{
    const size_t n = bins->n[0];
    for (size_t k = 0; k < n; k++)
        for (size_t e = 0; e < 2; e++) {
            const double x = rmap_axes_x(axes, bins->edge[k + e]), own = known(height[k]);
            const double wide = error ? known(error[k]) : 0.0;
            const size_t at = 2 * k + e, back = 4 * n - 1 - at;
            point[at][0] = x;
            point[at][1] = rmap_axes_y(axes, own + wide);
            point[back][0] = x;
            point[back][1] = rmap_axes_y(axes, own - wide);
        }
    rmap_svg_path(svg, (const double(*)[2])point, error ? 4 * n : 2 * n, as);
}

/* Above the frame, where no line can run. */
static void draw_key(const struct rmap_axes *axes, struct rmap_svg *svg)
{
    for (int k = 0; k < 2; k++) {
        const double x = axes->x + axes->width - 96 + 58 * k, y = axes->y - 10;
        rmap_svg_rect(svg, x, y - 8, 18, 8,
                      &(struct rmap_svg_style){.fill = ink[k], .opacity = 0.8});
        rmap_svg_string(svg, &(struct rmap_svg_text){.x = x + 25, .y = y, .size = RMAP_TICK_SIZE},
                        k ? "B" : "A");
    }
}

static void draw_samples(const struct rmap_axes *axes, const struct rmap_compare_bins *bins,
                         double (*point)[2], struct rmap_svg *svg)
{
    rmap_svg_open_clip(svg, axes->x, axes->y, axes->width, axes->height);
    for (int k = 0; k < 2; k++) {
        draw_steps(axes, bins, bins->value[k], bins->error[k],
                   &(struct rmap_svg_style){.fill = ink[k], .opacity = 0.25}, point, svg);
        draw_steps(axes, bins, bins->value[k], NULL,
                   &(struct rmap_svg_style){.stroke = ink[k], .width = 1.6}, point, svg);
    }
    rmap_svg_close(svg);
    draw_key(axes, svg);
    rmap_axes_draw(svg, axes);
}

/* z, with the lines between which 68 and 99.7 of 100 lie. */
static void draw_z(const struct rmap_axes *axes, const struct rmap_compare_bins *bins,
                   double (*point)[2], struct rmap_svg *svg)
{
    static const struct {
        double z;
        const char *text;
    } label[] = {{-3.0, "−3"}, {3.0, "+3"}, {-1.0, "−1"}, {1.0, "+1"}};
    const double apart = rmap_axes_y(axes, 0.0) - rmap_axes_y(axes, 1.0);
    /* those that have room between them: all, the outer two, or none */
    const size_t n_label = 2.0 * apart > RMAP_TICK_SIZE ? 4 : 6.0 * apart > RMAP_TICK_SIZE ? 2 : 0;
    rmap_svg_open_clip(svg, axes->x, axes->y, axes->width, axes->height);
    for (int s = -3; s <= 3; s++) {
        const double y = rmap_axes_y(axes, s);
        if (s == -2 || s == 2)
            continue;
        rmap_svg_line(svg, axes->x, y, axes->x + axes->width, y,
                      &(struct rmap_svg_style){.stroke = s == 0 ? "#444444" : "#b0b0b0",
                                               .dash = s == 0 ? NULL : "4 3"});
    }
    draw_steps(axes, bins, bins->z, NULL,
               &(struct rmap_svg_style){.stroke = "#333333", .width = 1.4}, point, svg);
    rmap_svg_close(svg);
    rmap_axes_draw(svg, axes);
    for (size_t k = 0; k < n_label; k++)
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = axes->x + axes->width + 6,
                                                .y = rmap_axes_y(axes, label[k].z) + 4,
                                                .size = RMAP_TICK_SIZE,
                                                .fill = "#777777"},
                        label[k].text);
}

static enum rmap_status draw_profile(const struct rmap_comparison *comparison,
                                     const struct rmap_compare_bins *bins,
                                     struct rmap_svg **svg_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = bins->n[0];
    struct rmap_svg *svg = NULL;
    double most = 0.0, z = fmax(largest(bins->z, n) * 1.1, Z_MOST);
    double(*point)[2] = rmap_alloc(4 * n + 4, sizeof *point);
    if (!point)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (int k = 0; k < 2; k++)
        for (size_t b = 0; b < n; b++)
            most = fmax(most, bins->value[k][b] + known(bins->error[k][b]));
    const struct rmap_axes upper = {.x = LEFT,
                                    .y = TOP,
                                    .width = PROFILE,
                                    .height = HIGH,
                                    .x_range = {bins->edge[0], bins->edge[n]},
                                    .y_range = {0.0, most > 0.0 ? 1.05 * most : 1.0},
                                    .x_label = bins->name,
                                    .y_label = "flux per bin",
                                    .x_unit = bins->axis_unit,
                                    .y_unit = bins->unit};
    struct rmap_axes lower = upper;
    lower.y += HIGH + BOTTOM + 10;
    lower.height = LOW;
    lower.y_range[0] = -z;
    lower.y_range[1] = z;
    lower.y_label = "z of A - B";
    lower.y_unit = "";
    RMAP_TRY(rmap_svg_create(LEFT + PROFILE + 40, lower.y + LOW + BOTTOM, bins->name, &svg, err));
    draw_samples(&upper, bins, point, svg);
    draw_z(&lower, bins, point, svg);
    draw_captions(comparison, bins, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    rmap_free(point);
    rmap_svg_destroy(svg);
    return st;
}

enum rmap_status rmap_figure_difference(const struct rmap_comparison *comparison,
                                        const struct rmap_compare_bins *bins,
                                        struct rmap_svg **svg_ret, struct rmap_error *err)
{
    return bins->is_image ? draw_image(comparison, bins, svg_ret, err)
                          : draw_profile(comparison, bins, svg_ret, err);
}

/* SPDX-License-Identifier: MIT */
#include "analysis/sweep/sweep_figure.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/table/figure_axes.h"
#include "analysis/table/line_mark.h"
#include "base/alloc.h"
#include "base/grouped.h"

enum { LEFT = 104, TOP = 78, WIDTH = 520, HEIGHT = 230, GAP = 74, BOTTOM = 66 };
enum { BARS_GAP = 44, BARS = 270, BAR_ROW = 50, BARS_MAX = 5, RIGHT = 30 };
enum { LEGEND_ROW = 19, LINES_MAX = 14, ANSWERS_MAX = 12, DOTS_MAX = 80 };

static const char faint[] = "#b9bfc6", limit_ink[] = "#c2392b", bar_ink[] = "#0072b2";

struct plot {
    const struct rmap_sweep_table *table;
    struct rmap_svg *svg;
    size_t answer, n_answer;
    struct rmap_axes axes;
    char x_label[160];
    size_t parameter; /* along x; n_parameter: the number of the variant */
    uint64_t stride;  /* of GRID: from a value of it to the next, in variants */
    size_t n_line;
    double (*point)[2]; /* [2 n_variant + 2] */
    struct point {
        double x, y, error, difference_error;
    } * of; /* [n_variant] in the order of x */
    struct rmap_sweep_effect *effect;
};

static double value_at(const struct plot *plot, uint64_t variant, size_t parameter)
{
    const char *text;
    return rmap_sweep_value(plot->table->sweep, variant, parameter, &text);
}

/* Some parameter whose values are numbers, that with most of them. */
static void choose_x(struct plot *plot)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    size_t most = 1;
    plot->parameter = sweep->n_parameter;
    for (size_t i = 0; i < sweep->n_parameter; i++) {
        const struct rmap_sweep_parameter *p = &sweep->parameter[i];
        bool numbers = p->spread == RMAP_SWEEP_VALUES;
        for (size_t k = 0; k < p->n_value; k++)
            numbers = numbers && isfinite(p->value[k]);
        if (numbers && p->n_value > most) {
            most = p->n_value;
            plot->parameter = i;
        }
    }
    plot->stride = 1;
    for (size_t i = plot->parameter + 1; i < sweep->n_parameter; i++)
        plot->stride *= sweep->parameter[i].n_value;
    plot->n_line = 1;
    if (sweep->mode == RMAP_SWEEP_GRID && plot->parameter < sweep->n_parameter)
        plot->n_line = (size_t)(sweep->n_variant - 1) / sweep->parameter[plot->parameter].n_value;
}

/* The k-th variant of a line. */
static uint64_t variant_of(const struct plot *plot, size_t line, size_t k)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    if (sweep->mode != RMAP_SWEEP_GRID || plot->parameter == sweep->n_parameter)
        return 1 + k;
    const uint64_t n = sweep->parameter[plot->parameter].n_value;
    return 1 + line / plot->stride * plot->stride * n + line % plot->stride + k * plot->stride;
}

static int by_x(const void *a, const void *b)
{
    const struct point *p = a, *q = b;
    return (p->x > q->x) - (p->x < q->x);
}

static double or_zero(double error)
{
    return isfinite(error) ? error : 0.0;
}

/* Points of a line that are known, in the order of x: how many. */
static size_t find_line(struct plot *plot, size_t line)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    const size_t all = (size_t)(sweep->n_variant - 1) / plot->n_line;
    size_t n = 0;
    for (size_t k = 0; k < all; k++) {
        const uint64_t v = variant_of(plot, line, k);
        const struct rmap_sweep_result *result =
            &rmap_sweep_table_row(plot->table, v)[plot->answer];
        if (!plot->table->is_known[v] || !isfinite(result->value))
            continue;
        const double x =
            plot->parameter < sweep->n_parameter ? value_at(plot, v, plot->parameter) : (double)v;
        plot->of[n++] = (struct point){x, result->value, or_zero(result->standard_error),
                                       or_zero(result->difference_error)};
    }
    qsort(plot->of, n, sizeof *plot->of, by_x);
    return n;
}

static void widen(double range[2], double value)
{
    if (isfinite(value)) {
        range[0] = fmin(range[0], value);
        range[1] = fmax(range[1], value);
    }
}

static void round_off(double range[2])
{
    if (range[0] > range[1])
        range[0] = range[1] = 0.0;
    double margin = 0.06 * (range[1] - range[0]);
    if (!(margin > 1e-9 * fmax(fabs(range[0]), fabs(range[1]))))
        margin = range[0] != 0.0 ? 0.05 * fabs(range[0]) : 1.0;
    range[0] -= margin;
    range[1] += margin;
}

/* A band of so many errors to either side. */
static void draw_band(const struct plot *plot, size_t n, bool of_difference, const char *ink,
                      double opacity)
{
    for (size_t i = 0; i < n; i++) {
        const struct point *p = &plot->of[i];
        const double error = of_difference ? p->difference_error : p->error;
        const double x = rmap_axes_x(&plot->axes, p->x);
        plot->point[i][0] = plot->point[2 * n - 1 - i][0] = x;
        plot->point[i][1] = rmap_axes_y(&plot->axes, p->y + error);
        plot->point[2 * n - 1 - i][1] = rmap_axes_y(&plot->axes, p->y - error);
    }
    rmap_svg_path(plot->svg, (const double(*)[2])plot->point, 2 * n,
                  &(struct rmap_svg_style){.fill = ink, .opacity = opacity});
}

static void draw_line(const struct plot *plot, size_t n, struct rmap_line_mark mark)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    for (size_t i = 0; i < n; i++) {
        plot->point[i][0] = rmap_axes_x(&plot->axes, plot->of[i].x);
        plot->point[i][1] = rmap_axes_y(&plot->axes, plot->of[i].y);
        if (n * plot->n_line <= DOTS_MAX || plot->parameter == sweep->n_parameter)
            rmap_svg_circle(plot->svg, plot->point[i][0], plot->point[i][1], 2.6,
                            &(struct rmap_svg_style){.fill = mark.ink});
    }
    if (plot->parameter < sweep->n_parameter)
        rmap_svg_path(
            plot->svg, (const double(*)[2])plot->point, n,
            &(struct rmap_svg_style){.stroke = mark.ink, .width = 1.6, .dash = mark.dash});
}

/* Limits of requirements across the plot, and the answer as it is. */
static void draw_levels(const struct plot *plot, bool upright)
{
    const struct rmap_axes *axes = &plot->axes;
    const struct rmap_sweep *sweep = plot->table->sweep;
    for (size_t i = 0; i <= sweep->n_require; i++) {
        const bool nominal = i == sweep->n_require;
        if (!nominal && sweep->require[i].answer != plot->answer)
            continue;
        const double value = nominal ? rmap_sweep_table_row(plot->table, 0)[plot->answer].value
                                     : sweep->require[i].limit;
        const struct rmap_svg_style style = {
            .stroke = nominal ? faint : limit_ink, .width = 1.4, .dash = nominal ? NULL : "6 4"};
        const double x = rmap_axes_x(axes, value), y = rmap_axes_y(axes, value);
        if (!isfinite(value))
            continue;
        if (upright)
            rmap_svg_line(plot->svg, x, axes->y, x, axes->y + axes->height, &style);
        else
            rmap_svg_line(plot->svg, axes->x, y, axes->x + axes->width, y, &style);
    }
}

static void level_range(const struct plot *plot, double range[2])
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    widen(range, rmap_sweep_table_row(plot->table, 0)[plot->answer].value);
    for (size_t i = 0; i < sweep->n_require; i++)
        if (sweep->require[i].answer == plot->answer)
            widen(range, sweep->require[i].limit);
}

static void draw_curves(struct plot *plot)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    struct rmap_axes *axes = &plot->axes;
    double x[2] = {HUGE_VAL, -HUGE_VAL}, y[2] = {HUGE_VAL, -HUGE_VAL};
    for (size_t line = 0; line < plot->n_line; line++)
        for (size_t i = 0, n = find_line(plot, line); i < n; i++) {
            widen(x, plot->of[i].x);
            widen(y, plot->of[i].y + plot->of[i].error);
            widen(y, plot->of[i].y - plot->of[i].error);
        }
    level_range(plot, y);
    round_off(y);
    if (!(x[0] < x[1]))
        round_off(x);
    memcpy(axes->x_range, x, sizeof x);
    memcpy(axes->y_range, y, sizeof y);
    axes->x_label = "variant";
    if (plot->parameter < sweep->n_parameter) {
        axes->x_label = sweep->parameter[plot->parameter].name;
        axes->x_unit = sweep->parameter[plot->parameter].unit;
    }
    axes->y_label = sweep->answer[plot->answer].name;
    axes->y_unit = rmap_sweep_table_row(plot->table, 0)[plot->answer].unit;
    rmap_svg_open_clip(plot->svg, axes->x, axes->y, axes->width, axes->height);
    draw_levels(plot, false);
    for (size_t line = 0; line < plot->n_line && line < 4 * LINES_MAX; line++) {
        const struct rmap_line_mark mark = rmap_line_mark(line);
        const size_t n = find_line(plot, line);
        draw_band(plot, n, false, mark.ink, plot->n_line > 1 ? 0.08 : 0.18);
        draw_band(plot, n, true, mark.ink, 0.35);
        draw_line(plot, n, mark);
    }
    rmap_svg_close(plot->svg);
}

/* Which share of the variants lies below a value, with the error of a binomial share. */
static void draw_shares(struct plot *plot)
{
    struct rmap_axes *axes = &plot->axes;
    const struct rmap_sweep *sweep = plot->table->sweep;
    double range[2] = {HUGE_VAL, -HUGE_VAL};
    plot->parameter = sweep->n_parameter;
    const size_t n = find_line(plot, 0);
    for (size_t i = 0; i < n; i++) {
        plot->of[i].x = plot->of[i].y;
        widen(range, plot->of[i].y);
    }
    qsort(plot->of, n, sizeof *plot->of, by_x);
    for (size_t i = 0; i < n; i++) {
        const double share = ((double)i + 1.0) / (double)n;
        plot->of[i].y = share;
        plot->of[i].error = sqrt(share * (1.0 - share) / (double)n);
    }
    level_range(plot, range);
    round_off(range);
    memcpy(axes->x_range, range, sizeof range);
    axes->y_range[0] = 0.0;
    axes->y_range[1] = 1.04;
    axes->x_label = sweep->answer[plot->answer].name;
    axes->x_unit = rmap_sweep_table_row(plot->table, 0)[plot->answer].unit;
    axes->y_label = "share of variants below";
    axes->y_unit = "";
    rmap_svg_open_clip(plot->svg, axes->x, axes->y, axes->width, axes->height);
    draw_levels(plot, true);
    draw_band(plot, n, false, rmap_line_mark(0).ink, 0.22);
    plot->parameter = 0; /* a line, no dots alone */
    draw_line(plot, n, rmap_line_mark(0));
    rmap_svg_close(plot->svg);
}

static enum rmap_status draw_bars(struct plot *plot, struct rmap_error *err)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    const double x = LEFT + WIDTH + BARS_GAP;
    double explained, y = plot->axes.y + 12.0;
    char line[200];
    enum rmap_status st =
        rmap_sweep_effects(plot->table, plot->answer, plot->effect, &explained, err);
    for (size_t i = 0; st == RMAP_OK && i < sweep->n_parameter && i < BARS_MAX; i++) {
        const struct rmap_sweep_effect *effect = &plot->effect[i];
        if (!isfinite(effect->share))
            break;
        const struct rmap_svg_text name = {.x = x, .y = y, .size = RMAP_TICK_SIZE};
        const struct rmap_svg_text share = {
            .x = x + BARS, .y = y, .size = RMAP_TICK_SIZE, .anchor = RMAP_SVG_END};
        const struct rmap_svg_text slope = {.x = x, .y = y + 28.0, .size = 11.0, .fill = "#555555"};
        rmap_caption(plot->svg, &name, BARS - 50.0, sweep->parameter[effect->parameter].name);
        (void)snprintf(line, sizeof line, "%.1f %%", 100.0 * effect->share);
        rmap_svg_string(plot->svg, &share, line);
        (void)snprintf(line, sizeof line, "slope %.3g ± %.2g", effect->slope, effect->slope_error);
        if (!isfinite(effect->slope_error))
            (void)snprintf(line, sizeof line, "slope %.3g", effect->slope);
        rmap_svg_string(plot->svg, &slope, line);
        rmap_svg_rect(plot->svg, x, y + 5.0, BARS, 9.0,
                      &(struct rmap_svg_style){.fill = "#e9ecef"});
        rmap_svg_rect(plot->svg, x, y + 5.0, BARS * fmin(fmax(effect->share, 0.0), 1.0), 9.0,
                      &(struct rmap_svg_style){.fill = bar_ink});
        y += BAR_ROW;
    }
    return st;
}

/* Under the first row's bars. */
static void draw_legend(const struct plot *plot)
{
    const struct rmap_sweep *sweep = plot->table->sweep;
    const size_t bars = sweep->n_parameter < BARS_MAX ? sweep->n_parameter : BARS_MAX;
    const double x = LEFT + WIDTH + BARS_GAP, end = TOP + HEIGHT + 30.0;
    double y = TOP + 16.0 + (double)(bars * BAR_ROW);
    for (size_t k = 0; plot->n_line > 1 && k < plot->n_line; k++, y += LEGEND_ROW) {
        const struct rmap_line_mark mark = rmap_line_mark(k);
        char line[240];
        size_t used = 0;
        const bool last = y + LEGEND_ROW > end && k + 1 < plot->n_line;
        line[0] = 0;
        for (size_t i = 0; i < sweep->n_parameter && used < sizeof line; i++) {
            const char *text;
            const double value = rmap_sweep_value(sweep, variant_of(plot, k, 0), i, &text);
            if (i == plot->parameter)
                continue;
            used += (size_t)(text ? snprintf(line + used, sizeof line - used, "%s%s %s",
                                             used ? ", " : "", sweep->parameter[i].name, text)
                                  : snprintf(line + used, sizeof line - used, "%s%s %.6g %s",
                                             used ? ", " : "", sweep->parameter[i].name, value,
                                             sweep->parameter[i].unit));
        }
        if (last)
            (void)snprintf(line, sizeof line, "and %zu more", plot->n_line - k);
        else
            rmap_svg_line(
                plot->svg, x, y - 4, x + 22, y - 4,
                &(struct rmap_svg_style){.stroke = mark.ink, .width = 2.4, .dash = mark.dash});
        const struct rmap_svg_text name = {.x = x + 29, .y = y, .size = RMAP_TICK_SIZE};
        rmap_caption(plot->svg, &name, BARS - 29, line);
        if (last)
            return;
    }
}

static void draw_captions(const struct plot *plot)
{
    char title[300], line[300];
    const struct rmap_sweep *sweep = plot->table->sweep;
    const struct rmap_sweep_yield yield = rmap_sweep_yield_of(plot->table);
    (void)snprintf(title, sizeof title, "%s of %s", rmap_counted(yield.n, "variant").text,
                   sweep->scene_path);
    if (sweep->n_require)
        (void)snprintf(line, sizeof line,
                       "yield %.1f %% ± %.1f %%; grey: the scene as it is; dashed: requirements",
                       100.0 * yield.share, 100.0 * yield.standard_error);
    else
        (void)snprintf(line, sizeof line,
                       sweep->mode == RMAP_SWEEP_RANDOM
                           ? "grey: the scene as it is; band: standard error of the share"
                           : "grey: the scene as it is; bands: standard error, and (dark) that of "
                             "the difference to it");
    const char *const row[] = {title, line};
    rmap_captions(plot->svg, 16, row, 2);
}

static enum rmap_status draw(struct plot *plot, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < plot->n_answer; i++) {
        plot->answer = i;
        plot->axes = (struct rmap_axes){.x = LEFT,
                                        .y = TOP + (double)(i * (HEIGHT + GAP)),
                                        .width = WIDTH,
                                        .height = HEIGHT,
                                        .x_unit = ""};
        if (plot->table->sweep->mode == RMAP_SWEEP_RANDOM)
            draw_shares(plot);
        else
            draw_curves(plot);
        rmap_axes_draw(plot->svg, &plot->axes);
        RMAP_TRY(draw_bars(plot, err));
    }
    if (plot->table->sweep->mode != RMAP_SWEEP_RANDOM)
        draw_legend(plot);
    draw_captions(plot);
out:
    return st;
}

enum rmap_status rmap_figure_sweep(const struct rmap_sweep_table *table, struct rmap_svg **svg_ret,
                                   struct rmap_error *err)
{
    const struct rmap_sweep *sweep = table->sweep;
    const size_t n = sweep->n_answer < ANSWERS_MAX ? sweep->n_answer : ANSWERS_MAX;
    const size_t n_variant = (size_t)sweep->n_variant;
    struct plot plot = {.table = table,
                        .n_answer = n,
                        .point = rmap_alloc(2 * n_variant + 2, sizeof *plot.point),
                        .of = rmap_alloc(n_variant + 1, sizeof *plot.of),
                        .effect = rmap_alloc(sweep->n_parameter, sizeof *plot.effect)};
    const double width = LEFT + WIDTH + BARS_GAP + BARS + RIGHT;
    const double height = TOP + (double)(n * HEIGHT + (n - 1) * GAP) + BOTTOM;
    enum rmap_status st = RMAP_OK;
    if (!plot.point || !plot.of || !plot.effect)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture"));
    RMAP_TRY(rmap_svg_create(width, height, "sweep", &plot.svg, err));
    choose_x(&plot);
    RMAP_TRY(draw(&plot, err));
    *svg_ret = plot.svg;
    plot.svg = NULL;
out:
    rmap_svg_destroy(plot.svg);
    rmap_free(plot.point);
    rmap_free(plot.of);
    rmap_free(plot.effect);
    return st;
}

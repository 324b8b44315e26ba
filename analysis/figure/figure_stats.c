/* SPDX-License-Identifier: MIT
 *
 * The picture of a histogram: of one number a step line per group with a band of one standard
 * error to either side; of two numbers the flux in false colours.
 */
#include "analysis/figure/figure_stats.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/table/figure_axes.h"
#include "analysis/table/line_mark.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/raster.h"

enum { LEFT = 92, TOP = 86, RIGHT = 30, BOTTOM = 62, WIDTH = 760, HEIGHT = 440, SQUARE = 520 };
enum { BAR_GAP = 22, BAR_WIDTH = 22, BAR_RIGHT = 150 };
enum { LEGEND_GAP = 18, LEGEND_RIGHT = 190, LEGEND_WIDEST = 420, LEGEND_ROW = 20, LEGEND_MAX = 20 };

struct plot {
    const struct rmap_stats *stats;
    const struct rmap_stats_labels *labels;
    struct rmap_axes axes;
    char y_label[160];
    bool density;  /* flux per unit: the bins differ in width */
    bool log_flux; /* a logarithmic scale of it */
    double legend_right;
    double least_high; /* what is lower stands there on that */
    struct rmap_svg *svg;
};

/* Where a value stands along an axis: logarithmic bins have a logarithmic one. */
static double place(const struct rmap_bins *bins, double value)
{
    return bins->logarithmic ? log10(value) : value;
}

static void set_x(struct plot *plot)
{
    const struct rmap_bins *bins = &plot->stats->plan->bins[0];
    const struct rmap_quantity *of = &plot->stats->setup->quantities->of[0];
    plot->axes.x_label = of->name;
    plot->axes.x_unit = of->unit;
    plot->axes.x_powers = bins->logarithmic;
    plot->axes.x_range[0] = place(bins, bins->edge[0]);
    plot->axes.x_range[1] = place(bins, bins->edge[bins->n]);
}

static double height_of(const struct plot *plot, double flux, size_t k)
{
    const double *edge = plot->stats->plan->bins[0].edge;
    return plot->density ? flux / (edge[k + 1] - edge[k]) : flux;
}

/* Where it stands along the axis of flux. */
static double y_of(const struct plot *plot, double flux, size_t k)
{
    const double high = height_of(plot, flux, k);
    return rmap_axes_y(&plot->axes,
                       plot->log_flux ? log10(fmax(high, plot->least_high)) : fmax(high, 0.0));
}

/* Below this part of the brightest a logarithmic scale shows more. */
static const double DARK_PART = 0.03, LOG_DEPTH = 1e-5;

/* Groups that differ much in their peaks are seen on a logarithmic scale alone. */
static void set_y(struct plot *plot)
{
    const struct rmap_stats *stats = plot->stats;
    const struct rmap_bins *bins = &stats->plan->bins[0];
    double most = 0.0, least = (double)INFINITY, lowest_peak = (double)INFINITY;
    plot->density = !bins->uniform && !bins->logarithmic;
    for (size_t g = 0; g < stats->n_group; g++) {
        double peak = 0.0;
        for (size_t k = 0; k < bins->n; k++) {
            struct rmap_stats_estimate flux = stats->group[g].cell[k];
            double error = isfinite(flux.standard_error) ? flux.standard_error : 0.0;
            double high = height_of(plot, flux.value, k);
            peak = fmax(peak, high);
            least = high > 0.0 ? fmin(least, high) : least;
            most = fmax(most, height_of(plot, flux.value + error, k));
        }
        lowest_peak = peak > 0.0 ? fmin(lowest_peak, peak) : lowest_peak;
    }
    plot->log_flux = plot->axes.y_powers = lowest_peak < DARK_PART * most;
    plot->axes.y_range[1] = most > 0.0 ? 1.05 * most : 1.0;
    if (plot->log_flux) {
        plot->least_high = fmax(0.5 * least, LOG_DEPTH * most);
        plot->axes.y_range[0] = log10(plot->least_high);
        plot->axes.y_range[1] = log10(1.5 * most);
    }
    (void)snprintf(plot->y_label, sizeof plot->y_label,
                   plot->density ? "flux per %s" : "flux per bin",
                   *plot->axes.x_unit ? plot->axes.x_unit : "unit");
    plot->axes.y_label = plot->y_label;
    plot->axes.y_unit = rmap_stats_flux_unit(stats);
}

/* Up and down the steps: the band of errors, closed, and the line. point: [4 n + 4]. */
static void draw_steps(const struct plot *plot, const struct rmap_stats_group *group,
                       struct rmap_line_mark mark, double (*point)[2])
{
    const struct rmap_bins *bins = &plot->stats->plan->bins[0];
    const size_t n = bins->n;
    for (size_t k = 0; k < n; k++) {
        double error = isfinite(group->cell[k].standard_error) ? group->cell[k].standard_error : 0;
        double x[2], upper = y_of(plot, group->cell[k].value + error, k);
        double lower = y_of(plot, group->cell[k].value - error, k);
        for (size_t e = 0; e < 2; e++) {
            x[e] = rmap_axes_x(&plot->axes, place(bins, bins->edge[k + e]));
            point[2 * k + e][0] = point[4 * n - 1 - 2 * k - e][0] = x[e];
            point[2 * k + e][1] = upper;
            point[4 * n - 1 - 2 * k - e][1] = lower;
        }
    }
    rmap_svg_path(plot->svg, (const double(*)[2])point, 4 * n,
                  &(struct rmap_svg_style){.fill = mark.ink, .opacity = 0.25});
    point[0][0] = rmap_axes_x(&plot->axes, place(bins, bins->edge[0]));
    point[0][1] = point[2 * n + 1][1] = y_of(plot, 0.0, 0);
    for (size_t k = 0; k < n; k++)
        for (size_t e = 0; e < 2; e++) {
            point[2 * k + e + 1][0] = rmap_axes_x(&plot->axes, place(bins, bins->edge[k + e]));
            point[2 * k + e + 1][1] = y_of(plot, group->cell[k].value, k);
        }
    point[2 * n + 1][0] = rmap_axes_x(&plot->axes, place(bins, bins->edge[n]));
    rmap_svg_path(plot->svg, (const double(*)[2])point, 2 * n + 2,
                  &(struct rmap_svg_style){.stroke = mark.ink, .width = 1.6, .dash = mark.dash});
}

/* Beside the frame, where no line can run. */
/* Criteria and paths may be told apart by how they end. */
static double legend_right(const struct rmap_stats *stats)
{
    size_t longest = 0;
    const bool is_long = stats->setup->criteria || stats->setup->paths;
    for (size_t g = 0; is_long && g < stats->n_group; g++) {
        const size_t length = strlen(stats->group[g].name);
        longest = length > longest ? length : longest;
    }
    return fmin(fmax(66.0 + 8.0 * (double)longest, LEGEND_RIGHT), LEGEND_WIDEST);
}

static void draw_legend(const struct plot *plot, const char *name, size_t row)
{
    const double x = plot->axes.x + plot->axes.width + LEGEND_GAP, y = plot->axes.y + 12;
    const double at = y + (double)(LEGEND_ROW * row);
    if (row >= LEGEND_MAX)
        return;
    const struct rmap_line_mark mark = rmap_line_mark(row);
    rmap_svg_line(plot->svg, x, at - 4, x + 22, at - 4,
                  &(struct rmap_svg_style){.stroke = mark.ink, .width = 2.4, .dash = mark.dash});
    const struct rmap_svg_text text = {.x = x + 29, .y = at, .size = RMAP_TICK_SIZE};
    const struct rmap_stats_paths *paths = plot->stats->setup->paths;
    char label[256]; /* paths begin alike: their ranks tell them apart */
    if (paths && row < paths->n)
        (void)snprintf(label, sizeof label, "%zu  %s", row + 1, name);
    else
        (void)snprintf(label, sizeof label, "%s", name);
    rmap_caption(plot->svg, &text, plot->legend_right - LEGEND_GAP - 37,
                 row + 1 < LEGEND_MAX ? label : "…");
}

static void draw_note(const struct plot *plot)
{
    for (size_t g = 0; g < plot->stats->n_group; g++)
        if (plot->stats->group[g].n_reading > 0)
            return;
    rmap_svg_string(plot->svg,
                    &(struct rmap_svg_text){.x = plot->axes.x + 0.5 * plot->axes.width,
                                            .y = plot->axes.y + 0.5 * plot->axes.height,
                                            .size = RMAP_LABEL_SIZE,
                                            .anchor = RMAP_SVG_MIDDLE,
                                            .fill = "#444444",
                                            .halo = "white"},
                    "no ray has a value here");
}

static enum rmap_status draw_lines(struct plot *plot, struct rmap_error *err)
{
    const struct rmap_stats *stats = plot->stats;
    double(*point)[2] = rmap_alloc(4 * stats->plan->bins[0].n + 4, sizeof *point);
    if (!point)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    rmap_svg_open_clip(plot->svg, plot->axes.x, plot->axes.y, plot->axes.width, plot->axes.height);
    size_t shown = 0;
    for (size_t g = 0; g < stats->n_group; g++)
        if (rmap_stats_shows(stats, g))
            draw_steps(plot, &stats->group[g], rmap_line_mark(shown++), point);
    rmap_svg_close(plot->svg);
    shown = 0;
    for (size_t g = 0; g < stats->n_group && stats->group[g].name; g++)
        if (rmap_stats_shows(stats, g))
            draw_legend(plot, stats->group[g].name, shown++);
    rmap_axes_draw(plot->svg, &plot->axes);
    rmap_free(point);
    return RMAP_OK;
}

/* Sum over all groups. */
static double cell_flux(const struct rmap_stats *stats, size_t cell)
{
    double flux = 0.0;
    for (size_t g = 0; g < stats->n_group; g++)
        flux += stats->group[g].cell[cell].value;
    return flux;
}

static size_t bin_at(const struct rmap_bins *bins, double part)
{
    double low = place(bins, bins->edge[0]), high = place(bins, bins->edge[bins->n]);
    double at = low + (high - low) * part;
    size_t k = rmap_bin_of(bins, bins->logarithmic ? pow(10.0, at) : at);
    return k < bins->n ? k : bins->n - 1;
}

static enum rmap_status draw_cells(struct plot *plot, struct rmap_colour_bar *bar,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_bins *bins = plot->stats->plan->bins;
    struct rmap_colour_map map;
    const uint32_t width = (uint32_t)(2 * plot->axes.width),
                   height = (uint32_t)(2 * plot->axes.height);
    uint8_t *rgb = rmap_alloc((size_t)width * height, 3), *png = NULL;
    size_t nbytes = 0;
    if (!rgb)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    rmap_colour_map_init(&map);
    for (uint32_t y = 0; y < height; y++) {
        size_t j = bin_at(&bins[1], (height - 1 - y + 0.5) / height);
        for (uint32_t x = 0; x < width; x++) {
            size_t i = bin_at(&bins[0], (x + 0.5) / width);
            double flux = cell_flux(plot->stats, i + j * bins[0].n);
            rmap_colour_map_at(&map, rmap_colour_bar_place(bar, flux),
                               rgb + 3 * ((size_t)y * width + x));
        }
    }
    RMAP_TRY(rmap_png_encode(rgb, width, height, &png, &nbytes, err));
    rmap_svg_image(plot->svg, plot->axes.x, plot->axes.y, plot->axes.width, plot->axes.height, png,
                   nbytes);
    rmap_axes_draw(plot->svg, &plot->axes);
    st = rmap_colour_bar_draw(plot->svg, bar, &map, err);
out:
    rmap_free(rgb);
    rmap_free(png);
    return st;
}

/* Logarithmic where half the lit cells are dark. */
static void set_bar(struct plot *plot, struct rmap_colour_bar *bar)
{
    const size_t n = plot->stats->plan->n_cell;
    double most = 0.0, least = (double)INFINITY;
    size_t n_lit = 0, n_dark = 0;
    for (size_t c = 0; c < n; c++)
        most = fmax(most, cell_flux(plot->stats, c));
    for (size_t c = 0; c < n; c++) {
        double flux = cell_flux(plot->stats, c);
        n_lit += flux > 0.0;
        n_dark += flux > 0.0 && flux < DARK_PART * most;
        least = flux > 0.0 ? fmin(least, flux) : least;
    }
    *bar = (struct rmap_colour_bar){.x = plot->axes.x + plot->axes.width + BAR_GAP,
                                    .y = plot->axes.y,
                                    .width = BAR_WIDTH,
                                    .height = plot->axes.height,
                                    .range = {0.0, most > 0.0 ? most : 1.0},
                                    .logarithmic = 2 * n_dark > n_lit,
                                    .label = "flux per bin",
                                    .unit = rmap_stats_flux_unit(plot->stats)};
    plot->log_flux = bar->logarithmic;
    if (bar->logarithmic) /* empty cells are darker than any that has a ray */
        bar->range[0] = fmax(0.5 * least, LOG_DEPTH * most);
}

/* Flux of readings that the bins do not hold, of all groups. */
static double flux_outside(const struct rmap_stats *stats)
{
    double flux = 0.0;
    for (size_t g = 0; g < stats->n_group; g++)
        for (size_t k = 0; k < RMAP_STATS_BEYOND; k++)
            flux += stats->group[g].cell[stats->plan->n_cell + k].value;
    return flux;
}

static const char *space_before(const char *unit)
{
    return *unit ? " " : "";
}

/* "; mean 1.5 ± 0.1 mm", without an error that is not defined; the length of it. */
static int describe_value(char *text, size_t nbytes, const char *what, const char *unit,
                          struct rmap_stats_estimate of)
{
    char error[48] = "";
    if (isfinite(of.standard_error))
        (void)snprintf(error, sizeof error, " ± %.2g", of.standard_error);
    return snprintf(text, nbytes, "%s%.5g%s%s%s", what, of.value, error, space_before(unit), unit);
}

/* "1,234 values, 0.5 ± 0.002 W; mean ..." of the only group; the length of it. */
static int describe_only(const struct plot *plot, char *line, size_t nbytes)
{
    const struct rmap_stats *stats = plot->stats;
    const struct rmap_stats_group *group = &stats->group[0];
    const struct rmap_stats_moment_estimates *moment = &group->of[0].moment;
    const char *unit = stats->setup->quantities->of[0].unit;
    int n = snprintf(line, nbytes, "%s", rmap_counted(group->n_reading, "value").text);
    n += describe_value(line + n, nbytes - (size_t)n, ", ", rmap_stats_flux_unit(stats),
                        group->flux);
    if (stats->setup->quantities->n == 1) {
        n += describe_value(line + n, nbytes - (size_t)n, "; mean ", unit, moment->mean);
        n += describe_value(line + n, nbytes - (size_t)n, ", standard deviation ", unit,
                            moment->deviation);
    }
    return n;
}

/* And what all groups have in common. Nothing where there is no value. */
static void describe(const struct plot *plot, char *line, size_t nbytes)
{
    const struct rmap_stats *stats = plot->stats;
    const double outside = flux_outside(stats);
    uint64_t n_reading = 0;
    line[0] = 0;
    for (size_t g = 0; g < stats->n_group; g++)
        n_reading += stats->group[g].n_reading;
    if (n_reading == 0)
        return;
    int n = stats->group[0].name
                ? snprintf(line, nbytes, "%s by %s", rmap_counted(n_reading, "value").text,
                           rmap_stats_by_word(stats->setup->by))
                : describe_only(plot, line, nbytes);
    if (outside > 0.0 && n > 0 && (size_t)n < nbytes)
        n += snprintf(line + n, nbytes - (size_t)n, "; %.3g %s outside the picture", outside,
                      rmap_stats_flux_unit(stats));
    if (plot->log_flux && n > 0 && (size_t)n < nbytes)
        (void)snprintf(line + n, nbytes - (size_t)n, "; logarithmic scale");
}

static void draw_captions(const struct plot *plot)
{
    const struct rmap_stats *stats = plot->stats;
    char title[256], asked[1024], line[1024];
    int n = snprintf(title, sizeof title, "%s", stats->setup->quantities->of[0].name);
    if (stats->setup->quantities->n == 2 && n > 0)
        (void)snprintf(title + n, sizeof title - (size_t)n, " and %s",
                       stats->setup->quantities->of[1].name);
    n = (int)strlen(title);
    if (plot->labels->detector)
        (void)snprintf(title + n, sizeof title - (size_t)n, " at %s", plot->labels->detector);
    rmap_which_caption(plot->labels->which, plot->labels->criterion, asked, sizeof asked);
    describe(plot, line, sizeof line);
    char part[RMAP_MAP_PART_LEN];
    rmap_map_part_text(plot->labels->part, part);
    if (part[0] && line[0])
        (void)snprintf(line + strlen(line), sizeof line - strlen(line), "; %s", part);
    rmap_captions(plot->svg, 16, (const char *const[]){title, asked, line}, 3);
}

/* Two lengths, or two angles, to one scale unless that is too long or too flat. */
static void set_square(struct plot *plot)
{
    struct rmap_axes *axes = &plot->axes;
    const double x = axes->x_range[1] - axes->x_range[0], y = axes->y_range[1] - axes->y_range[0];
    const double aspect = *axes->x_unit && strcmp(axes->x_unit, axes->y_unit) == 0 ? x / y : 1.0;
    axes->width = axes->height = SQUARE;
    if (aspect > 1.0 && aspect < 3.0) {
        axes->width = fmin(WIDTH, rint(SQUARE * aspect));
        axes->height = rint(axes->width / aspect);
    } else if (aspect < 1.0 && aspect > 1.0 / 3.0) {
        axes->width = rint(SQUARE * aspect);
    }
}

enum rmap_status rmap_figure_stats(const struct rmap_stats *stats,
                                   const struct rmap_stats_labels *labels,
                                   struct rmap_svg **svg_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const bool two = stats->setup->quantities->n == 2;
    struct plot plot = {.stats = stats,
                        .labels = labels,
                        .legend_right = legend_right(stats),
                        .axes = {.x = LEFT, .y = TOP, .width = WIDTH, .height = HEIGHT}};
    struct rmap_colour_bar bar;
    set_x(&plot);
    if (two) {
        const struct rmap_bins *bins = &stats->plan->bins[1];
        const struct rmap_quantity *of = &stats->setup->quantities->of[1];
        plot.axes.y_label = of->name;
        plot.axes.y_unit = of->unit;
        plot.axes.y_powers = bins->logarithmic;
        plot.axes.y_range[0] = place(bins, bins->edge[0]);
        plot.axes.y_range[1] = place(bins, bins->edge[bins->n]);
        set_square(&plot);
        set_bar(&plot, &bar);
    } else {
        set_y(&plot);
    }
    const bool named = !two && stats->n_group > 0 && stats->group[0].name;
    const double width = LEFT + plot.axes.width +
                         (two     ? BAR_RIGHT
                          : named ? plot.legend_right
                                  : RIGHT);
    RMAP_TRY(rmap_svg_create(width, TOP + plot.axes.height + BOTTOM,
                             stats->setup->quantities->of[0].name, &plot.svg, err));
    if (two)
        RMAP_TRY(draw_cells(&plot, &bar, err));
    else
        RMAP_TRY(draw_lines(&plot, err));
    draw_note(&plot);
    draw_captions(&plot);
    *svg_ret = plot.svg;
    plot.svg = NULL;
out:
    rmap_svg_destroy(plot.svg);
    return st;
}

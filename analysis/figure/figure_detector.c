/* SPDX-License-Identifier: MIT
 *
 * The picture of a detector: its image in false colour with a scale, or in true colour, with axes
 * in the detector's own units.
 */
#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_isolines.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/table/figure_axes.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/raster.h"

enum { LEFT = 82, TOP = 84, RIGHT = 150, BOTTOM = 60, IMAGE_WIDTH = 720, IMAGE_HEIGHT = 560 };
enum { PANELS_MOST = 9, PANEL_GAP = 84, PANEL_ROW = 76, PANEL_TITLE = 20 };
enum { BAR_GAP = 22, BAR_WIDTH = 22, SHORTEST_BAR = 160, NARROWEST = 24, FIGURE_NARROWEST = 640 };
enum { BLANK = 236 /* grey of what is no cell */ };

/* Colours brighter than all but this part of the lit cells are white or clipped. */
static const double BRIGHTEST_PART = 0.005;

struct picture {
    const struct rmap_detector_image *image;
    const struct rmap_figure_detector *options;
    struct rmap_axes axes;
    struct rmap_colour_bar bar;
    struct rmap_colour_map map;
    bool logarithmic;
    double top;                    /* value at the upper end of the scale */
    double white;                  /* true colour: value that is shown as 1 */
    size_t n_panel;                /* channels, each by itself; 0: their sum */
    uint32_t first_theta, n_theta; /* of directions, the rows that are shown */
};

static bool is_plane(const struct rmap_detector_image *image)
{
    return !image->bins.directions;
}

/* In the world, where an axis of the detector lies along one of it. */
static void move_to_world(const struct rmap_detector *detector, int axis, double range[2],
                          const char **label)
{
    static const char *const name[] = {"x", "y", "z"};
    const int along = rmap_detector_along(detector, axis);
    if (along < 0)
        return;
    const double zero = rmap_detector_from_world(detector, axis, 0.0);
    const double sign = rmap_detector_from_world(detector, axis, 1.0) > zero ? 1.0 : -1.0;
    *label = name[along];
    for (int k = 0; k < 2; k++)
        range[k] = sign * (range[k] - zero);
}

static bool is_lit(const struct rmap_detector_image *image, uint32_t theta)
{
    for (uint32_t phi = 0; phi < image->n[1]; phi++)
        if (image->value[theta + (size_t)phi * image->n[0]] > 0.0)
            return true;
    return false;
}

/* Of all angles theta those with light, up to round ones; of a region that was asked for, all. */
static void find_lit(struct picture *picture)
{
    const struct rmap_detector_image *image = picture->image;
    const struct rmap_detector_bins *bins = &image->bins;
    const double whole = bins->high[0] / (0.5 * RMAP_PI);
    uint32_t low = 0, high = image->n[0];
    picture->first_theta = 0;
    picture->n_theta = high;
    while (low < high && !is_lit(image, low))
        low++;
    while (high > low && !is_lit(image, high - 1))
        high--;
    if (low == high || bins->low[0] != 0.0 || fabs(whole - rint(whole)) > 1e-9)
        return;
    const double step = bins->high[0] * 180.0 / RMAP_PI / image->n[0];
    const double span = step * (high - low), round = span > 20.0 ? 10.0 : span > 5.0 ? 5.0 : 1.0;
    picture->first_theta = (uint32_t)floor(floor(step * low / round) * round / step + 1e-9);
    high = (uint32_t)ceil(ceil(step * high / round - 1e-9) * round / step - 1e-9);
    picture->n_theta = (high < image->n[0] ? high : image->n[0]) - picture->first_theta;
}

static void lay_out(struct picture *picture)
{
    const struct rmap_detector_image *image = picture->image;
    struct rmap_axes *axes = &picture->axes;
    *axes = (struct rmap_axes){.x = LEFT, .y = TOP};
    if (is_plane(image)) {
        const struct rmap_detector_bins *bins = &image->bins;
        bool turned = bins->rotate_rad != 0.0;
        for (int k = 0; k < 2; k++) {
            axes->x_range[k] = k == 0 ? bins->low[0] : bins->high[0];
            axes->y_range[k] = k == 0 ? bins->low[1] : bins->high[1];
        }
        axes->x_label = turned ? "x′" : "x";
        axes->y_label = turned ? "y′" : "y";
        axes->x_unit = axes->y_unit = rmap_detector_image_coordinate_unit(image);
        if (picture->options->uv) {
            axes->x_label = "u";
            axes->y_label = "v";
            axes->x_unit = axes->y_unit = "";
        } else if (image->world && !turned) {
            axes->x_label = "x (detector)";
            axes->y_label = "y (detector)";
            move_to_world(image->detector, 0, axes->x_range, &axes->x_label);
            move_to_world(image->detector, 1, axes->y_range, &axes->y_label);
        }
    } else {
        const struct rmap_detector_bins *bins = &image->bins;
        const double degree = 180.0 / RMAP_PI;
        axes->x_range[0] = (bins->low[1] + bins->rotate_rad) * degree;
        axes->x_range[1] = (bins->high[1] + bins->rotate_rad) * degree;
        const double step = (bins->high[0] - bins->low[0]) * degree / image->n[0];
        find_lit(picture);
        axes->y_range[0] = bins->low[0] * degree + step * picture->first_theta;
        axes->y_range[1] = axes->y_range[0] + step * picture->n_theta;
        axes->x_label = "φ";
        axes->y_label = "θ";
        axes->x_unit = axes->y_unit = "deg";
    }
    double aspect =
        fabs((axes->x_range[1] - axes->x_range[0]) / (axes->y_range[1] - axes->y_range[0]));
    if (!is_plane(image)) /* two angles that are not alike */
        aspect = fmin(aspect, 2.0);
    axes->width = fmax(rint(fmin(IMAGE_WIDTH, IMAGE_HEIGHT * aspect)), NARROWEST);
    axes->height = fmax(rint(fmin(IMAGE_HEIGHT, IMAGE_WIDTH / aspect)), NARROWEST);
}

static enum rmap_status choose_white(struct picture *picture, struct rmap_error *err)
{
    const struct rmap_detector_image *image = picture->image;
    const size_t n_cell = (size_t)image->n[0] * image->n[1];
    picture->white = picture->options->white;
    if (picture->white > 0.0)
        return RMAP_OK;
    double *brightness = rmap_alloc(n_cell, sizeof *brightness);
    if (!brightness)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (size_t c = 0; c < n_cell; c++) {
        const double *rgb = image->rgb + 3 * c;
        brightness[c] = fmax(rgb[0], fmax(rgb[1], rgb[2]));
    }
    picture->white = rmap_value_quantile(brightness, n_cell, 1.0 - BRIGHTEST_PART);
    if (!(picture->white > 0.0))
        picture->white = 1.0;
    rmap_free(brightness);
    return RMAP_OK;
}

/* Cells near the poles of directions are small. */
static enum rmap_status choose_scale(struct picture *picture, struct rmap_error *err)
{
    const struct rmap_detector_image *image = picture->image;
    const size_t n_cell = (size_t)image->n[0] * image->n[1];
    enum rmap_figure_scale asked = picture->options->scale;
    if (asked == RMAP_SCALE_AUTO && picture->options->true_colour)
        asked = RMAP_SCALE_LINEAR;
    picture->top = is_plane(image) ? image->peak
                                   : rmap_value_scale_sure(image->value, image->standard_error,
                                                           n_cell, image->peak);
    return rmap_value_scale_choose(image->value, n_cell, picture->top, asked, &picture->logarithmic,
                                   err);
}

static void choose_range(struct picture *picture)
{
    const struct rmap_detector_image *image = picture->image;
    struct rmap_colour_bar *bar = &picture->bar;
    *bar = (struct rmap_colour_bar){.x = picture->axes.x + picture->axes.width + BAR_GAP,
                                    .y = picture->axes.y,
                                    .width = BAR_WIDTH,
                                    .height = picture->axes.height,
                                    .logarithmic = picture->logarithmic,
                                    .label = image->quantity,
                                    .unit = image->unit};
    bar->height = fmax(bar->height, SHORTEST_BAR);
    rmap_value_scale_find(image->value, (size_t)image->n[0] * image->n[1], picture->top,
                          picture->logarithmic, bar->range);
}

/* Cells [first, last) that output pixel p of n_pixel covers, of n_cell. */
static void covered(uint32_t p, uint32_t n_pixel, uint32_t n_cell, uint32_t *first, uint32_t *last)
{
    *first = (uint32_t)((uint64_t)p * n_cell / n_pixel);
    *last = (uint32_t)((uint64_t)(p + 1) * n_cell / n_pixel);
    if (*last <= *first)
        *last = *first + 1;
}

/* Colour of the cells [i0, i1) x [j0, j1), averaged as light, not as colours. */
static void paint(const struct picture *picture, const uint32_t i[2], const uint32_t j[2],
                  uint8_t rgb[3])
{
    const struct rmap_detector_image *image = picture->image;
    const uint8_t *there = picture->options->there;
    double value = 0.0, colour[3] = {0.0, 0.0, 0.0}, shown = 0.0;
    double part = 1.0 / ((double)(i[1] - i[0]) * (j[1] - j[0]));
    for (uint32_t row = j[0]; row < j[1]; row++)
        for (uint32_t column = i[0]; column < i[1]; column++) {
            size_t c = column + (size_t)row * image->n[0];
            if (there && !there[c])
                continue;
            shown += part;
            value += part * image->value[c];
            for (size_t k = 0; k < 3 && picture->options->true_colour; k++)
                colour[k] += part * image->rgb[3 * c + k];
        }
    if (!(shown > 0.0)) {
        memset(rgb, BLANK, 3);
        return;
    }
    if (!picture->options->true_colour) {
        if (there)
            value /= shown;
        rmap_colour_map_at(&picture->map, rmap_colour_bar_place(&picture->bar, value), rgb);
        return;
    }
    double gain = 1.0 / picture->white;
    double most = fmax(colour[0], fmax(colour[1], colour[2]));
    if (picture->logarithmic && most > 0.0)
        gain = fmax(1.0 - log(most / picture->white) / log(RMAP_LOG_DEPTH), 0.0) / most;
    for (int k = 0; k < 3; k++)
        colour[k] *= gain;
    rmap_srgb_encode(colour, rgb);
}

static enum rmap_status draw_image(const struct picture *picture, struct rmap_svg *svg,
                                   struct rmap_error *err)
{
    const struct rmap_detector_image *image = picture->image;
    const struct rmap_axes *axes = &picture->axes;
    uint32_t width = (uint32_t)(axes->width * RMAP_FIGURE_SCALE);
    uint32_t height = (uint32_t)(axes->height * RMAP_FIGURE_SCALE);
    uint8_t *rgb = rmap_alloc((size_t)width * height, 3), *png = NULL;
    size_t nbytes = 0;
    if (!rgb)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (uint32_t y = 0; y < height; y++)
        for (uint32_t x = 0; x < width; x++) {
            uint32_t across[2], up[2];
            bool plane = is_plane(image);
            covered(x, width, image->n[plane ? 0 : 1], &across[0], &across[1]);
            covered(height - 1 - y, height, plane ? image->n[1] : picture->n_theta, &up[0], &up[1]);
            for (int k = 0; k < 2; k++)
                up[k] += picture->first_theta;
            paint(picture, plane ? across : up, plane ? up : across,
                  rgb + 3 * ((size_t)y * width + x));
        }
    enum rmap_status st = rmap_png_encode(rgb, width, height, &png, &nbytes, err);
    rmap_free(rgb);
    if (st == RMAP_OK)
        rmap_svg_image(svg, axes->x, axes->y, axes->width, axes->height, png, nbytes);
    rmap_free(png);
    return st;
}

static void draw_captions(const struct picture *picture, struct rmap_svg *svg)
{
    const struct rmap_detector_image *image = picture->image;
    const char *criterion = picture->options->criterion;
    char title[1024], asked[1024], line[1024], error[64] = "";
    (void)snprintf(title, sizeof title, "%s: %s", image->detector->name, image->quantity);
    rmap_which_caption(image->which, criterion, asked, sizeof asked);
    const char *none = image->registrations > 0.0 ? "" : " (nothing was registered)";
    if (isfinite(image->flux_error))
        (void)snprintf(error, sizeof error, " ± %.2g", image->flux_error);
    int n =
        picture->options->sums
            ? snprintf(line, sizeof line, "%s", picture->options->sums)
            : snprintf(line, sizeof line, "%s, %.4g%s %s%s",
                       rmap_counted((uint64_t)llround(image->registrations), "registration").text,
                       image->flux, error, image->flux_unit, none);
    if (picture->options->true_colour && n > 0)
        (void)snprintf(line + n, sizeof line - (size_t)n, "; true colour, white at %.3g %s%s",
                       picture->white, rmap_unit_text(image->unit).text,
                       picture->logarithmic ? ", logarithmic" : "");
    else if (picture->logarithmic && n > 0)
        (void)snprintf(line + n, sizeof line - (size_t)n, "; logarithmic scale");
    size_t len = strlen(line);
    char part[RMAP_MAP_PART_LEN];
    rmap_map_part_text(image->part, part);
    if (part[0])
        len += (size_t)snprintf(line + len, sizeof line - len, "; %s", part);
    if (image->dimmed[0])
        (void)snprintf(line + len, sizeof line - len, "; %s", image->dimmed);
    if (picture->top < image->peak && !picture->options->true_colour && picture->n_panel == 0)
        (void)snprintf(line + len, sizeof line - len, "; cells of few rays go beyond the scale");
    len = strlen(line);
    if (picture->n_panel > 0)
        (void)snprintf(line + len, sizeof line - len,
                       picture->n_panel < image->n_channel ? "; %zu of %zu channels"
                                                           : "; part of each channel",
                       picture->n_panel, image->n_channel);
    const double turned = is_plane(image) ? image->bins.rotate_rad * 180.0 / RMAP_PI : 0.0;
    len = strlen(line);
    if (turned != 0.0) /* what the dashes at the axes mean */
        (void)snprintf(line + len, sizeof line - len, "; axes turned by %s%.6g°",
                       turned < 0.0 ? "−" : "", fabs(turned));
    rmap_captions(svg, 16, (const char *const[]){title, asked, line}, 3);
}

/* The channel that panel k of n shows: the first, the last, and an even choice between. */
static size_t channel_of(const struct picture *picture, size_t k)
{
    const size_t n = picture->n_panel, n_channel = picture->image->n_channel;
    return n > 1 ? k * (n_channel - 1) / (n - 1) : 0;
}

/* One scale for all panels. part: the image, to be given each channel's values. */
static void choose_common_range(struct picture *panel, struct rmap_detector_image *part)
{
    const size_t n_cell = (size_t)part->n[0] * part->n[1];
    double least = (double)INFINITY;
    part->peak = 0.0;
    for (size_t i = 0; i < n_cell * part->n_channel; i++)
        part->peak = fmax(part->peak, part->cube[i]);
    panel->top = part->peak;
    for (size_t c = 0; c < part->n_channel; c++) {
        part->value = part->cube + c * n_cell;
        choose_range(panel);
        least = fmin(least, panel->bar.range[0]);
    }
    panel->bar.range[0] = least;
}

static enum rmap_status draw_panel(struct picture *panel, const char *title, struct rmap_svg *svg,
                                   struct rmap_error *err)
{
    const struct rmap_axes *axes = &panel->axes;
    enum rmap_status st = draw_image(panel, svg, err);
    if (st != RMAP_OK)
        return st;
    rmap_axes_draw(svg, axes);
    rmap_svg_string(svg,
                    &(struct rmap_svg_text){.x = axes->x + 0.5 * axes->width,
                                            .y = axes->y - 6,
                                            .size = RMAP_TICK_SIZE,
                                            .anchor = RMAP_SVG_MIDDLE},
                    title);
    return RMAP_OK;
}

/* What each channel has, panel by panel. */
static enum rmap_status draw_channels(const struct picture *picture, struct rmap_svg **svg_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = picture->n_panel, across = n == 4 ? 2 : n < 3 ? n : 3;
    const size_t down = (n + across - 1) / across;
    struct rmap_svg *svg = NULL;
    struct rmap_detector_image part = *picture->image;
    struct picture panel = *picture;
    panel.image = &part;
    panel.axes.width = fmax(rint(panel.axes.width / 2.2), NARROWEST);
    panel.axes.height = fmax(rint(panel.axes.height / 2.2), NARROWEST);
    const double column = panel.axes.width + PANEL_GAP, row = panel.axes.height + PANEL_ROW;
    choose_common_range(&panel, &part);
    panel.bar.x = LEFT + column * (double)across - PANEL_GAP + BAR_GAP;
    panel.bar.y = TOP + PANEL_TITLE;
    RMAP_TRY(rmap_svg_create(fmax(panel.bar.x - BAR_GAP + RIGHT, FIGURE_NARROWEST),
                             TOP + PANEL_TITLE +
                                 fmax(row * (double)down - PANEL_ROW, panel.bar.height) + BOTTOM,
                             part.detector->name, &svg, err));
    for (size_t k = 0; k < n; k++) {
        const size_t c = channel_of(picture, k);
        char title[32];
        part.value = part.cube + c * (size_t)part.n[0] * part.n[1];
        panel.axes.x = LEFT + column * (double)(k % across);
        panel.axes.y = TOP + PANEL_TITLE + row * (double)(k / across);
        rmap_detector_image_channel(&part, c, title);
        RMAP_TRY(draw_panel(&panel, title, svg, err));
    }
    RMAP_TRY(rmap_colour_bar_draw(svg, &panel.bar, &panel.map, err));
    draw_captions(picture, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    rmap_svg_destroy(svg);
    return st;
}

/* Of the picture, whose columns are those of a plane, or the phi of directions. */
static double value_of(const void *context, uint32_t i, uint32_t j)
{
    const struct picture *picture = context;
    const struct rmap_detector_image *image = picture->image;
    j += picture->first_theta;
    const size_t column = is_plane(image) ? i : j, row = is_plane(image) ? j : i;
    return image->value[column + row * image->n[0]];
}

static enum rmap_status draw_plan(const struct picture *picture, struct rmap_svg *svg,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector_image *image = picture->image;
    const struct rmap_axes *axes = &picture->axes;
    const bool plane = is_plane(image);
    const struct rmap_cell_grid grid = {
        {image->n[plane ? 0 : 1], plane ? image->n[1] : picture->n_theta}, value_of, picture};
    const double most[] = {floor(axes->width / RMAP_CELL_WIDTH),
                           floor(axes->height / RMAP_CELL_HEIGHT)};
    if (picture->options->values && (grid.n[0] > most[0] || grid.n[1] > most[1]))
        return rmap_error_set(err, RMAP_USAGE,
                              "--values: %u x %u cells are too many to be read; --cells %.0fx%.0f "
                              "or fewer",
                              image->n[0], image->n[1], most[plane ? 0 : 1], most[plane ? 1 : 0]);
    if (picture->options->isolines)
        RMAP_TRY(rmap_isolines_draw(svg, axes, &grid,
                                    &(struct rmap_isolines){&picture->bar, picture->options->level,
                                                            picture->options->n_level,
                                                            !picture->options->values},
                                    err));
    if (picture->options->values)
        rmap_cell_values_draw(svg, axes, &grid);
out:
    return st;
}

enum rmap_status rmap_figure_detector(const struct rmap_detector_image *image,
                                      const struct rmap_figure_detector *options,
                                      struct rmap_svg **svg_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    struct picture picture = {.image = image, .options = options};
    rmap_colour_map_init(&picture.map);
    lay_out(&picture);
    RMAP_TRY(choose_scale(&picture, err));
    if (image->cube && image->n_channel > 1 && !options->true_colour) {
        picture.n_panel = image->n_channel < PANELS_MOST ? image->n_channel : PANELS_MOST;
        return draw_channels(&picture, svg_ret, err);
    }
    choose_range(&picture);
    if (options->true_colour)
        RMAP_TRY(choose_white(&picture, err));
    double right = options->true_colour ? 30 : RIGHT;
    double height = TOP + fmax(picture.axes.height, options->true_colour ? 0 : picture.bar.height);
    RMAP_TRY(rmap_svg_create(fmax(LEFT + picture.axes.width + right, FIGURE_NARROWEST),
                             height + BOTTOM, image->detector->name, &svg, err));
    RMAP_TRY(draw_image(&picture, svg, err));
    RMAP_TRY(draw_plan(&picture, svg, err));
    rmap_axes_draw(svg, &picture.axes);
    if (!options->true_colour)
        RMAP_TRY(rmap_colour_bar_draw(svg, &picture.bar, &picture.map, err));
    draw_captions(&picture, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    rmap_svg_destroy(svg);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * The intensity over the direction as a polar diagram.
 */
#include "analysis/figure/figure_polar.h"

#include <math.h>
#include <stdio.h>

#include "analysis/table/figure_axes.h"
#include "base/alloc.h"
#include "base/vec.h"

enum { RADIUS = 250, LEFT = 70, TOP = 92, BOTTOM = 60, SPOKES = 24, PLANES = 2 };

static const char *const colour[PLANES] = {"#0072b2", "#d55e00"};
static const char *const dash[PLANES] = {NULL, "7 4"};
static const char *const name[PLANES] = {"C0 – C180", "C90 – C270"};

struct polar {
    const struct rmap_detector_image *image;
    struct rmap_svg *svg;
    double centre[2]; /* in the picture */
    double top;       /* value at the rim */
    double (*point)[2];
    size_t n;
};

/* Cell column whose middle in phi is nearest. */
static uint32_t column_of(const struct rmap_detector_image *image, double phi)
{
    uint32_t nearest = 0;
    double least = HUGE_VAL, theta, middle;
    for (uint32_t j = 0; j < image->n[1]; j++) {
        rmap_detector_image_centre(image, 0, j, &theta, &middle);
        const double apart = fabs(remainder(middle - phi, 360.0));
        if (apart < least - 1e-9) {
            least = apart;
            nearest = j;
        }
    }
    return nearest;
}

static void place(const struct polar *polar, double theta, double value, double to[2])
{
    const double r = RADIUS * fmax(value, 0.0) / polar->top;
    to[0] = polar->centre[0] + r * sin(theta);
    to[1] = polar->centre[1] + r * cos(theta);
}

/* Middles of the cells of one half plane, `side` 1 or -1, from the axis outwards or back to it;
 * shifted by that many standard errors. */
static void add_half(struct polar *polar, uint32_t j, double side, bool outwards, double errors)
{
    const struct rmap_detector_image *image = polar->image;
    for (uint32_t k = 0; k < image->n[0]; k++) {
        const uint32_t i = outwards ? k : image->n[0] - 1 - k;
        const size_t c = i + (size_t)j * image->n[0];
        const double error = isfinite(image->standard_error[c]) ? image->standard_error[c] : 0.0;
        double theta, phi;
        rmap_detector_image_centre(image, i, j, &theta, &phi);
        place(polar, side * theta * RMAP_PI / 180.0, image->value[c] + errors * error,
              polar->point[polar->n++]);
    }
}

/* From one end of the plane over the axis to the other; C goes against phi, and C 0 and C 90 are
 * on the right. */
static void add_plane(struct polar *polar, int plane, bool forth, double errors)
{
    const uint32_t right = column_of(polar->image, -90.0 * plane);
    const uint32_t left = column_of(polar->image, 180.0 - 90.0 * plane);
    add_half(polar, forth ? left : right, forth ? -1.0 : 1.0, false, errors);
    add_half(polar, forth ? right : left, forth ? 1.0 : -1.0, true, errors);
}

static void draw_plane(struct polar *polar, int plane)
{
    polar->n = 0;
    add_plane(polar, plane, true, 1.0);
    add_plane(polar, plane, false, -1.0);
    rmap_svg_path(polar->svg, (const double(*)[2])polar->point, polar->n,
                  &(struct rmap_svg_style){.fill = colour[plane], .opacity = 0.2});
    polar->n = 0;
    add_plane(polar, plane, true, 0.0);
    rmap_svg_path(
        polar->svg, (const double(*)[2])polar->point, polar->n,
        &(struct rmap_svg_style){.stroke = colour[plane], .width = 2.0, .dash = dash[plane]});
}

/* Circles at round values, spokes every 15 degrees. */
static void draw_grid(const struct polar *polar)
{
    const struct rmap_svg_style line = {.stroke = "#cccccc", .width = 1.0};
    struct rmap_ticks ticks;
    char text[64];
    rmap_ticks_linear(0.0, polar->top, 5, &ticks);
    for (int k = 0; k < SPOKES; k++) {
        const double theta = 2.0 * RMAP_PI * k / SPOKES;
        const int degrees = k <= SPOKES / 2 ? 15 * k : 360 - 15 * k;
        double rim[2], label[2];
        place(polar, theta, polar->top, rim);
        place(polar, theta, 1.07 * polar->top, label);
        rmap_svg_line(polar->svg, polar->centre[0], polar->centre[1], rim[0], rim[1], &line);
        if (k % 2 == 0) {
            (void)snprintf(text, sizeof text, "%d°", degrees);
            rmap_svg_string(polar->svg,
                            &(struct rmap_svg_text){.x = label[0],
                                                    .y = label[1] + 4.0,
                                                    .size = RMAP_TICK_SIZE,
                                                    .anchor = RMAP_SVG_MIDDLE},
                            text);
        }
    }
    for (int i = 0; i < ticks.n; i++) {
        if (!(ticks.value[i] > 0.0))
            continue;
        const double r = RADIUS * ticks.value[i] / polar->top;
        rmap_svg_circle(polar->svg, polar->centre[0], polar->centre[1], r, &line);
        (void)snprintf(text, sizeof text, "%g", ticks.value[i]);
        rmap_svg_string(polar->svg,
                        &(struct rmap_svg_text){.x = polar->centre[0] + 4.0,
                                                .y = polar->centre[1] + r - 4.0,
                                                .size = RMAP_TICK_SIZE,
                                                .fill = "#444444",
                                                .halo = "#ffffff"},
                        text);
    }
}

static void draw_words(const struct polar *polar, const char *criterion)
{
    const struct rmap_detector_image *image = polar->image;
    char line[400];
    const double width = 2.0 * (LEFT + RADIUS) - 40.0;
    (void)snprintf(line, sizeof line, "%.80s: %s, %s", image->detector->name, image->quantity,
                   rmap_unit_text(image->unit).text);
    rmap_caption(polar->svg,
                 &(struct rmap_svg_text){.x = 20.0, .y = 30.0, .size = RMAP_TITLE_SIZE, .bold = 1},
                 width, line);
    rmap_which_caption(image->which, criterion, line, sizeof line);
    rmap_caption(
        polar->svg,
        &(struct rmap_svg_text){.x = 20.0, .y = 52.0, .size = RMAP_LABEL_SIZE, .fill = "#444444"},
        width, line);
    for (int k = 0; k < PLANES; k++) {
        const double x = 20.0 + 190.0 * k, y = TOP + 2.0 * RADIUS + BOTTOM + 20.0;
        rmap_svg_line(polar->svg, x, y - 5.0, x + 34.0, y - 5.0,
                      &(struct rmap_svg_style){.stroke = colour[k], .width = 2.0, .dash = dash[k]});
        rmap_svg_string(polar->svg,
                        &(struct rmap_svg_text){.x = x + 42.0, .y = y, .size = RMAP_LABEL_SIZE},
                        name[k]);
    }
}

enum rmap_status rmap_figure_polar(const struct rmap_detector_image *image, const char *criterion,
                                   struct rmap_svg **svg_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct polar polar = {.image = image, .centre = {LEFT + RADIUS, TOP + RADIUS + 10.0}};
    polar.point = rmap_alloc(4 * (size_t)image->n[0] + 1, sizeof *polar.point);
    if (!polar.point)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    for (int plane = 0; plane < 2 * PLANES; plane++) {
        const uint32_t j = column_of(image, 90.0 * plane);
        for (uint32_t i = 0; i < image->n[0]; i++)
            polar.top = fmax(polar.top, image->value[i + (size_t)j * image->n[0]]);
    }
    polar.top = polar.top > 0.0 ? 1.05 * polar.top : 1.0;
    RMAP_TRY(rmap_svg_create(2.0 * (LEFT + RADIUS), TOP + 2.0 * RADIUS + BOTTOM + 40.0,
                             image->detector->name, &polar.svg, err));
    draw_grid(&polar);
    for (int plane = 0; plane < PLANES; plane++)
        draw_plane(&polar, plane);
    draw_words(&polar, criterion);
    *svg_ret = polar.svg;
out:
    rmap_free(polar.point);
    return st;
}

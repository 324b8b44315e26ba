/* SPDX-License-Identifier: MIT
 *
 * The picture of a surface over angle and wavelength.
 */
#include "analysis/figure/figure_surface.h"

#include <math.h>
#include <stdio.h>

#include "analysis/table/figure_axes.h"
#include "analysis/table/line_mark.h"

enum { LEFT = 92, TOP = 72, GAP = 70, BOTTOM = 62, WIDTH = 640, HEIGHT = 280 };
enum { LEGEND_GAP = 18, LEGEND_RIGHT = 300, LEGEND_ROW = 20 };
enum { ANGLES = 181, SAMPLES = ANGLES > RMAP_CHANNEL_MAX ? ANGLES : RMAP_CHANNEL_MAX };
enum { BSDF_POINTS = 719 }; /* a quarter of a degree: lobes are narrow */

enum share { REFLECTED, TRANSMITTED, ABSORBED, SHARES };
static const char *const share_name[SHARES] = {"reflected", "transmitted", "absorbed"};

struct plot {
    const struct rmap_scene *scene;
    const struct rmap_surface_side *side;
    size_t n;
    int channel;
    struct rmap_svg *svg;
};

static void shares_of(const struct plot *plot, size_t side, int channel, double angle_deg,
                      double share[SHARES])
{
    const struct rmap_surface_shares its =
        rmap_side_shares(plot->scene, plot->side[side], channel, angle_deg);
    share[REFLECTED] = its.reflect_specular + its.reflect_diffuse;
    share[TRANSMITTED] = its.transmit_specular + its.transmit_diffuse;
    share[ABSORBED] = its.absorb;
}

/* What is not let through, straight on, where that is little everywhere: an anti-reflection coat is
 * looked at for its reflectance. Else 1. */
static double most_lost(const struct plot *plot)
{
    const double few = 0.2;
    double most = 0.0, least = 1.0, share[SHARES];
    for (size_t s = 0; s < plot->n; s++)
        for (int i = 0; i < plot->scene->channels.n; i++) {
            shares_of(plot, s, i, 0.0, share);
            most = fmax(most, fmax(share[REFLECTED], share[ABSORBED]));
            least = fmin(least, share[TRANSMITTED]);
        }
    return most > 0.0 && least > 1.0 - few ? most : 1.0;
}

/* Of the second side dashed. */
static struct rmap_line_mark mark_of(size_t side, enum share share)
{
    return rmap_line_mark((size_t)share + (side > 0 ? RMAP_LINE_INKS : 0));
}

/* by_angle: over the angle, on the channel; else over wavelength, straight on. */
static void draw_panel(const struct plot *plot, const struct rmap_axes *axes, bool by_angle)
{
    double point[SHARES][SAMPLES][2], share[SHARES];
    const int n = by_angle ? ANGLES : plot->scene->channels.n;
    rmap_svg_open_clip(plot->svg, axes->x, axes->y, axes->width, axes->height);
    for (size_t s = 0; s < plot->n; s++) {
        for (int k = 0; k < n; k++) {
            const double angle = by_angle ? 90.0 * k / (ANGLES - 1) : 0.0;
            const double x = by_angle ? angle : plot->scene->channels.wavelength_nm[k];
            shares_of(plot, s, by_angle ? plot->channel : k, angle, share);
            for (int i = 0; i < SHARES; i++) {
                point[i][k][0] = rmap_axes_x(axes, x);
                point[i][k][1] = rmap_axes_y(axes, share[i]);
            }
        }
        for (int i = 0; i < SHARES; i++) {
            const struct rmap_line_mark mark = mark_of(s, (enum share)i);
            rmap_svg_path(
                plot->svg, (const double(*)[2])point[i], (size_t)n,
                &(struct rmap_svg_style){.stroke = mark.ink, .width = 1.8, .dash = mark.dash});
        }
    }
    rmap_svg_close(plot->svg);
    rmap_axes_draw(plot->svg, axes);
}

/* The channels on curves of more of them, those that are in the panel. */
static void draw_channels(const struct plot *plot, const struct rmap_axes *axes)
{
    const double radius = 2.8;
    double share[SHARES];
    for (size_t s = 0; s < plot->n; s++)
        for (int k = 0; k < plot->scene->channels.n; k++) {
            shares_of(plot, s, k, 0.0, share);
            for (int i = 0; i < SHARES; i++)
                if (share[i] <= axes->y_range[1])
                    rmap_svg_circle(
                        plot->svg, rmap_axes_x(axes, plot->scene->channels.wavelength_nm[k]),
                        rmap_axes_y(axes, share[i]), radius,
                        &(struct rmap_svg_style){.fill = mark_of(s, (enum share)i).ink});
        }
}

/* Straight on. curves: of the same surface, with the channels of `plot` and maybe more. */
static void draw_wavelengths(const struct plot *plot, const struct plot *curves,
                             struct rmap_axes axes)
{
    const struct rmap_channels *channels = &curves->scene->channels;
    axes.x_range[0] = channels->wavelength_nm[0];
    axes.x_range[1] = channels->wavelength_nm[channels->n - 1];
    axes.x_label = "wavelength, straight on";
    axes.x_unit = "nm";
    axes.y_range[1] = 1.02 * most_lost(curves);
    if (axes.y_range[1] < 1.0)
        axes.y_label = "share; the rest is transmitted";
    draw_panel(curves, &axes, false);
    if (curves->scene != plot->scene)
        draw_channels(plot, &axes);
}

static double scatter_angle(int k)
{
    return 90.0 * (2.0 * (k + 1) / (BSDF_POINTS + 1) - 1.0);
}

/* Least and greatest power of ten of the BSDF of the first side; false: nothing of it is above 0.
 */
static bool bsdf_range(const struct plot *plot, double range[2])
{
    const double decades = 8.0;
    double least = HUGE_VAL, most = 0.0;
    for (size_t i = 0; i < RMAP_FIGURE_INCIDENCES; i++)
        for (int k = 0; k < BSDF_POINTS; k++)
            for (int way = 0; way < 2; way++) {
                const double f =
                    rmap_side_bsdf(plot->scene, plot->side[0], plot->channel,
                                   rmap_figure_incidence[i], scatter_angle(k), way == 1);
                most = fmax(most, f);
                least = f > 0.0 ? fmin(least, f) : least;
            }
    if (!(most > 0.0))
        return false;
    range[1] = ceil(log10(most) + 0.05);
    range[0] = fmax(floor(log10(least)), range[1] - decades);
    range[0] = fmin(range[0], range[1] - 2.0);
    return true;
}

/* In the plane of incidence, of the first side; what passes is dashed. */
static void draw_bsdf(const struct plot *plot, const struct rmap_axes *axes)
{
    double point[BSDF_POINTS][2];
    char line[60];
    rmap_svg_open_clip(plot->svg, axes->x, axes->y, axes->width, axes->height);
    for (size_t i = 0; i < RMAP_FIGURE_INCIDENCES; i++)
        for (int way = 0; way < 2; way++) {
            size_t n = 0;
            const struct rmap_line_mark mark =
                rmap_line_mark(SHARES + i + (way ? RMAP_LINE_INKS : 0));
            for (int k = 0; k < BSDF_POINTS; k++) {
                const double f =
                    rmap_side_bsdf(plot->scene, plot->side[0], plot->channel,
                                   rmap_figure_incidence[i], scatter_angle(k), way == 1);
                if (!(f > 0.0))
                    continue;
                point[n][0] = rmap_axes_x(axes, scatter_angle(k));
                point[n++][1] = rmap_axes_y(axes, fmax(log10(f), axes->y_range[0] - 1.0));
            }
            rmap_svg_path(
                plot->svg, (const double(*)[2])point, n,
                &(struct rmap_svg_style){.stroke = mark.ink, .width = 1.8, .dash = mark.dash});
        }
    rmap_svg_close(plot->svg);
    rmap_axes_draw(plot->svg, axes);
    for (size_t i = 0; i < RMAP_FIGURE_INCIDENCES; i++) {
        const struct rmap_line_mark mark = rmap_line_mark(SHARES + i);
        const double x = LEFT + WIDTH + LEGEND_GAP, y = axes->y + 12 + (double)(LEGEND_ROW * i);
        rmap_svg_line(plot->svg, x, y - 4, x + 22, y - 4,
                      &(struct rmap_svg_style){.stroke = mark.ink, .width = 2.4});
        (void)snprintf(line, sizeof line, "incidence %g\u00b0", rmap_figure_incidence[i]);
        const struct rmap_svg_text name = {.x = x + 29, .y = y, .size = RMAP_TICK_SIZE};
        rmap_caption(plot->svg, &name, LEGEND_RIGHT - LEGEND_GAP - 37, line);
    }
}

/* Where light comes from: a medium, where the other side's is another. */
static const char *side_name(const struct plot *plot, size_t s)
{
    const struct rmap_surface_side *side = &plot->side[s];
    const int32_t front = side->object->medium_front, back = side->object->medium_back,
                  near = side->front ? front : back;
    if (near >= 0 && (plot->n < 2 || front != back))
        return plot->scene->medium[near].name;
    return side->front ? "the front" : "the back";
}

static void draw_legend(const struct plot *plot)
{
    char line[300];
    for (size_t k = 0; k < plot->n * SHARES; k++) {
        const struct rmap_line_mark mark = mark_of(k / SHARES, (enum share)(k % SHARES));
        const double x = LEFT + WIDTH + LEGEND_GAP, y = TOP + 12 + (double)(LEGEND_ROW * k);
        rmap_svg_line(
            plot->svg, x, y - 4, x + 22, y - 4,
            &(struct rmap_svg_style){.stroke = mark.ink, .width = 2.4, .dash = mark.dash});
        (void)snprintf(line, sizeof line, "%s, from %s", share_name[k % SHARES],
                       side_name(plot, k / SHARES));
        const struct rmap_svg_text name = {.x = x + 29, .y = y, .size = RMAP_TICK_SIZE};
        rmap_caption(plot->svg, &name, LEGEND_RIGHT - LEGEND_GAP - 37, line);
    }
}

enum rmap_status rmap_figure_surface(const struct rmap_surface_picture *its,
                                     struct rmap_svg **svg_ret, struct rmap_error *err)
{
    struct plot plot = {
        .scene = its->scene, .side = its->side, .n = its->n, .channel = its->channel};
    const struct rmap_channels *channels = &its->scene->channels;
    const bool spectral = channels->mode == RMAP_COLOUR_SPECTRAL;
    const bool several = spectral && (its->between || channels->n > 1);
    char line[160];
    struct rmap_axes axes = {.x = LEFT,
                             .y = TOP,
                             .width = WIDTH,
                             .height = HEIGHT,
                             .x_range = {0.0, 90.0},
                             .y_range = {0.0, 1.02},
                             .x_label = "angle of incidence",
                             .x_unit = "deg",
                             .y_label = "share of the light",
                             .y_unit = ""};
    double powers[2];
    const struct rmap_surface *surface =
        &its->scene->surface[its->side[0].front ? its->side[0].object->surface_front
                                                : its->side[0].object->surface_back];
    const bool scatters = rmap_surface_scatters(surface) && bsdf_range(&plot, powers);
    enum rmap_status st = rmap_svg_create(
        LEFT + WIDTH + LEGEND_RIGHT, TOP + HEIGHT + BOTTOM + (several + scatters) * (GAP + HEIGHT),
        "surface", &plot.svg, err);
    if (st != RMAP_OK)
        return st;
    draw_panel(&plot, &axes, true);
    if (several) {
        struct plot curves = plot;
        if (its->between) {
            curves.scene = its->between;
            curves.side = its->side_between;
        }
        axes.y += HEIGHT + GAP;
        draw_wavelengths(&plot, &curves, axes);
    }
    if (scatters) {
        axes = (struct rmap_axes){.x = LEFT,
                                  .y = axes.y + HEIGHT + GAP,
                                  .width = WIDTH,
                                  .height = HEIGHT,
                                  .x_range = {-90.0, 90.0},
                                  .y_range = {powers[0], powers[1]},
                                  .x_label = "angle from the normal, in the plane of incidence",
                                  .x_unit = "deg",
                                  .y_label = "BSDF",
                                  .y_unit = "1/sr",
                                  .y_powers = true};
        draw_bsdf(&plot, &axes);
    }
    draw_legend(&plot);
    (void)snprintf(line, sizeof line, "over the angle at %g nm; unpolarised light%s%s%s%s",
                   channels->wavelength_nm[its->channel],
                   its->between ? "; dots: the scene's wavelengths" : "",
                   scatters ? "; BSDF of light from " : "", scatters ? side_name(&plot, 0) : "",
                   scatters ? ", what passes is dashed" : "");
    rmap_captions(plot.svg, 16, (const char *const[]){its->title, line}, 2);
    *svg_ret = plot.svg;
    return RMAP_OK;
}

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
enum { ANGLES = 361, SAMPLES = ANGLES > RMAP_CHANNEL_MAX ? ANGLES : RMAP_CHANNEL_MAX };

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
    double most = 0.0, share[SHARES];
    for (size_t s = 0; s < plot->n; s++)
        for (int i = 0; i < plot->scene->channels.n; i++) {
            shares_of(plot, s, i, 0.0, share);
            most = fmax(most, fmax(share[REFLECTED], share[ABSORBED]));
        }
    return most > 0.0 && most < few ? most : 1.0;
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

static void draw_legend(const struct plot *plot)
{
    char line[300];
    for (size_t k = 0; k < plot->n * SHARES; k++) {
        const struct rmap_surface_side *side = &plot->side[k / SHARES];
        const struct rmap_line_mark mark = mark_of(k / SHARES, (enum share)(k % SHARES));
        const double x = LEFT + WIDTH + LEGEND_GAP, y = TOP + 12 + (double)(LEGEND_ROW * k);
        const int32_t near = side->front ? side->object->medium_front : side->object->medium_back;
        rmap_svg_line(
            plot->svg, x, y - 4, x + 22, y - 4,
            &(struct rmap_svg_style){.stroke = mark.ink, .width = 2.4, .dash = mark.dash});
        (void)snprintf(line, sizeof line, "%s, from %s", share_name[k % SHARES],
                       near >= 0 ? plot->scene->medium[near].name : "the front");
        const struct rmap_svg_text name = {.x = x + 29, .y = y, .size = RMAP_TICK_SIZE};
        rmap_caption(plot->svg, &name, LEGEND_RIGHT - LEGEND_GAP - 37, line);
    }
}

enum rmap_status rmap_figure_surface(const struct rmap_scene *scene,
                                     const struct rmap_surface_side *side, size_t n, int channel,
                                     const char *title, struct rmap_svg **svg_ret,
                                     struct rmap_error *err)
{
    struct plot plot = {.scene = scene, .side = side, .n = n, .channel = channel};
    const struct rmap_channels *channels = &scene->channels;
    const bool spectral = channels->mode == RMAP_COLOUR_SPECTRAL;
    const bool several = spectral && channels->n > 1;
    char line[120];
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
    enum rmap_status st = rmap_svg_create(LEFT + WIDTH + LEGEND_RIGHT,
                                          TOP + HEIGHT + BOTTOM + (several ? GAP + HEIGHT : 0),
                                          "surface", &plot.svg, err);
    if (st != RMAP_OK)
        return st;
    draw_panel(&plot, &axes, true);
    if (several) {
        axes.y += HEIGHT + GAP;
        axes.x_range[0] = channels->wavelength_nm[0];
        axes.x_range[1] = channels->wavelength_nm[channels->n - 1];
        axes.x_label = "wavelength, straight on";
        axes.x_unit = "nm";
        axes.y_range[1] = 1.02 * most_lost(&plot);
        draw_panel(&plot, &axes, false);
    }
    draw_legend(&plot);
    (void)snprintf(line, sizeof line, "over the angle at %g nm; unpolarised light",
                   channels->wavelength_nm[channel]);
    rmap_captions(plot.svg, 16, (const char *const[]){title, line}, 2);
    *svg_ret = plot.svg;
    return RMAP_OK;
}

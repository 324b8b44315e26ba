/* SPDX-License-Identifier: MIT */
#include "analysis/figure_rays.h"

#include <stdio.h>
#include <string.h>

#include "analysis/colour_map.h"
#include "base/alloc.h"
#include "optics/spectrum.h"
#include "trace/event.h"

/* Lightness (Oklab) that still shows on white: of grey, and of a saturated colour. */
static const double GREY_LIGHTNESS = 0.45, COLOUR_LIGHTNESS = 0.72, SATURATED = 0.12;

/* So many rays are drawn nearly opaque; more of them fainter, as the inverse square root. */
static const double OPAQUE_RAYS = 60.0, OPACITY = 0.8, FAINTEST = 0.08;

void rmap_ray_ink(const struct rmap_scene *scene, const double *share, char ink[8])
{
    double rgb[3], lab[3];
    uint8_t byte[3];
    rmap_colour_display(&scene->channels, share, scene->flux_unit == RMAP_FLUX_LM, rgb);
    for (int k = 0; k < 3; k++)
        rgb[k] = fmax(rgb[k], 0.0);
    rmap_rgb_to_oklab(rgb, lab);
    double chroma = hypot(lab[1], lab[2]);
    double most =
        GREY_LIGHTNESS + (COLOUR_LIGHTNESS - GREY_LIGHTNESS) * fmin(chroma / SATURATED, 1.0);
    lab[0] = fmin(lab[0], most);
    for (int tries = 0; tries < 40; tries++) { /* until it lies in the gamut */
        rmap_oklab_to_rgb(lab, rgb);
        if (fmin(rgb[0], fmin(rgb[1], rgb[2])) >= 0.0 && fmax(rgb[0], fmax(rgb[1], rgb[2])) <= 1.0)
            break;
        lab[1] *= 0.96;
        lab[2] *= 0.96;
    }
    rmap_srgb_encode(rgb, byte);
    (void)snprintf(ink, 8, "#%02x%02x%02x", byte[0], byte[1], byte[2]);
}

struct pen {
    const struct rmap_scene *scene;
    const struct rmap_portion *rays;
    const struct rmap_view_frame *frame;
    struct rmap_svg *svg;
    double leaving;
    struct rmap_svg_style style;
    char ink[8];
    double (*pixel)[2]; /* [points of the longest ray + 1] */
    size_t n_pixel;
};

static void put_point(struct pen *pen, struct rmap_vec3 point)
{
    struct rmap_vec3 p = rmap_view_project(pen->frame->view, point);
    rmap_view_pixel(pen->frame, (const double[2]){p.x, p.y}, pen->pixel[pen->n_pixel++]);
}

static void finish_line(struct pen *pen)
{
    if (pen->n_pixel > 1)
        rmap_svg_path(pen->svg, (const double(*)[2])pen->pixel, pen->n_pixel, &pen->style);
    pen->n_pixel = 0;
}

static struct rmap_vec3 place(const float v[3])
{
    return rmap_vec3((double)v[0], (double)v[1], (double)v[2]);
}

/* A curved leg: its ends and the points between them. */
struct curved_leg {
    struct rmap_vec3 from, to;
    const float *point; /* [n][3] */
    size_t n;
};

/* Between two recorded points a curve is drawn in so many strokes. */
enum { STROKES = 4 };

static struct rmap_vec3 node(const struct curved_leg *leg, size_t k)
{
    return k == 0 ? leg->from : k > leg->n ? leg->to : place(leg->point + 3 * (k - 1));
}

/* Direction at a node, times so much: of the parabola through it and its neighbours, by length of
 * chord. */
static struct rmap_vec3 slope(const struct curved_leg *leg, size_t k, double times)
{
    size_t middle = k == 0 ? 1 : k > leg->n ? leg->n : k;
    struct rmap_vec3 before = rmap_sub(node(leg, middle), node(leg, middle - 1));
    struct rmap_vec3 behind = rmap_sub(node(leg, middle + 1), node(leg, middle));
    double h = rmap_length(before), g = rmap_length(behind);
    if (!(h > 0.0 && g > 0.0))
        return rmap_vec3(0, 0, 0);
    before = rmap_scale(before, 1.0 / h);
    behind = rmap_scale(behind, 1.0 / g);
    struct rmap_vec3 mean = rmap_scale(rmap_axpy(h, behind, rmap_scale(before, g)), 1.0 / (h + g));
    if (k < middle)
        mean = rmap_axpy(2.0, before, rmap_scale(mean, -1.0));
    else if (k > middle)
        mean = rmap_axpy(2.0, behind, rmap_scale(mean, -1.0));
    return rmap_scale(mean, times);
}

/* Cubics through the nodes, up to the last one, which stays to be put. */
static void put_curve(struct pen *pen, const struct curved_leg *leg)
{
    for (size_t k = 0; k <= leg->n; k++) {
        struct rmap_vec3 p = node(leg, k), q = node(leg, k + 1), chord = rmap_sub(q, p);
        double h = rmap_length(chord);
        struct rmap_vec3 u = slope(leg, k, h), v = slope(leg, k + 1, h);
        for (int s = 1; s <= STROKES && k + (s == STROKES) <= leg->n; s++) {
            double t = (double)s / STROKES, r = 1.0 - t;
            struct rmap_vec3 at = rmap_axpy(t * t * (3.0 - 2.0 * t), chord, p);
            put_point(pen, rmap_axpy(t * r * r, u, rmap_axpy(-t * t * r, v, at)));
        }
    }
}

/* One line per run of legs with the same colour. */
static void draw_ray(struct pen *pen, size_t ray, size_t segment)
{
    const struct rmap_portion *rays = pen->rays;
    size_t n_channel = (size_t)rays->n_channel;
    const uint16_t *last = NULL;
    size_t point, n_point = rmap_portion_curve_of(rays, rays->ray.id[ray], &point);
    struct rmap_vec3 from = place(rays->ray.start + 3 * ray);
    for (size_t i = segment; i < segment + rays->ray.segment_count[ray]; i++) {
        const uint16_t *colour = rays->colour + i * n_channel;
        if (!last || memcmp(last, colour, n_channel * sizeof *colour) != 0) {
            double share[RMAP_CHANNEL_MAX];
            for (size_t c = 0; c < (size_t)pen->scene->channels.n; c++)
                share[c] = c < n_channel ? colour[c] / 65535.0 : 0.0;
            finish_line(pen);
            rmap_ray_ink(pen->scene, share, pen->ink);
            put_point(pen, from);
            last = colour;
        }
        struct rmap_vec3 to = place(rays->segment.position + 3 * i);
        struct curved_leg leg = {.from = from, .to = to, .point = rays->curve.position + 3 * point};
        while (leg.n < n_point && rays->curve.segment[point + leg.n] == i - segment)
            leg.n++;
        if (leg.n > 0)
            put_curve(pen, &leg);
        point += leg.n;
        n_point -= leg.n;
        if ((rays->segment.event[i] & (RMAP_EVENT_LEFT | RMAP_EVENT_GRADIENT)) == RMAP_EVENT_LEFT)
            to = rmap_axpy(pen->leaving, place(rays->ray.end_direction + 3 * ray), from);
        put_point(pen, to);
        from = to;
    }
    finish_line(pen);
}

enum rmap_status rmap_rays_draw(const struct rmap_scene *scene, const struct rmap_map *map,
                                const struct rmap_portion *rays,
                                const struct rmap_view_frame *frame, double leaving,
                                struct rmap_svg *svg, struct rmap_error *err)
{
    size_t n_ray = rays->n_row[RMAP_TABLE_RAY], longest = 0, segment = 0, point;
    for (size_t i = 0; i < n_ray; i++) {
        size_t n_point = rmap_portion_curve_of(rays, rays->ray.id[i], &point);
        size_t n = rays->ray.segment_count[i] * (n_point ? 1 + STROKES : 1) + n_point * STROKES;
        longest = n > longest ? n : longest;
    }
    struct pen pen = {.scene = scene,
                      .rays = rays,
                      .frame = frame,
                      .svg = svg,
                      .leaving = leaving,
                      .pixel = rmap_alloc(longest + 2, sizeof *pen.pixel)};
    if (!pen.pixel)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    pen.style = (struct rmap_svg_style){
        .stroke = pen.ink,
        .width = (double)n_ray > OPAQUE_RAYS ? 0.7 : 0.9,
        .opacity =
            fmax(OPACITY * fmin(sqrt(OPAQUE_RAYS / fmax((double)n_ray, 1.0)), 1.0), FAINTEST)};
    for (size_t i = 0; i < n_ray; i++) {
        if (map)
            pen.scene = rmap_map_scene_of(map, rmap_map_space_of_ray(map, rays->ray.id[i]));
        draw_ray(&pen, i, segment);
        segment += rays->ray.segment_count[i];
    }
    rmap_free(pen.pixel);
    return RMAP_OK;
}

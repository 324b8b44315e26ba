/* SPDX-License-Identifier: MIT */
#include "analysis/figure_marks.h"

#include <stdio.h>

const char rmap_source_ink[] = "#c2410c";
const char rmap_detector_ink[] = "#0f766e";

enum { ROUND = 96 };
static const char faint_ink[] = "#e3b7a4";

static void pixel_of(const struct rmap_view_frame *frame, struct rmap_vec3 point, double pixel[2])
{
    struct rmap_vec3 p = rmap_view_project(frame->view, point);
    rmap_view_pixel(frame, (const double[2]){p.x, p.y}, pixel);
}

/* A rectangle about a point along two half edges: a parallelogram, seen edge-on a line. */
static void draw_parallelogram(const struct rmap_view_frame *frame, struct rmap_vec3 centre,
                               struct rmap_vec3 x, struct rmap_vec3 y, struct rmap_svg *svg,
                               const struct rmap_svg_style *style)
{
    double pixel[5][2];
    for (int k = 0; k < 5; k++)
        pixel_of(frame,
                 rmap_axpy((k + 1) / 2 % 2 ? 1.0 : -1.0, x,
                           rmap_axpy(k / 2 % 2 ? 1.0 : -1.0, y, centre)),
                 pixel[k]);
    rmap_svg_path(svg, (const double(*)[2])pixel, 5, style);
}

static void draw_circle(const struct rmap_view_frame *frame, const struct rmap_affine *place,
                        double radius, struct rmap_svg *svg, const struct rmap_svg_style *style)
{
    double pixel[ROUND + 1][2];
    for (int k = 0; k <= ROUND; k++) {
        double angle = 2.0 * RMAP_PI * k / ROUND;
        pixel_of(frame,
                 rmap_affine_point(place, rmap_vec3(radius * cos(angle), radius * sin(angle), 0)),
                 pixel[k]);
    }
    rmap_svg_path(svg, (const double(*)[2])pixel, ROUND + 1, style);
}

/* An arrow of about 26 pixels from a point along a direction; nothing when it points at the eye. */
static void draw_arrow(const struct rmap_view_frame *frame, struct rmap_vec3 from,
                       struct rmap_vec3 direction, const char *ink, struct rmap_labels *labels,
                       struct rmap_svg *svg)
{
    double a[2], b[2];
    pixel_of(frame, from, a);
    pixel_of(frame, rmap_axpy(26.0 / frame->scale, direction, from), b);
    double dx = b[0] - a[0], dy = b[1] - a[1], length = hypot(dx, dy);
    if (length < 8.0)
        return;
    dx /= length;
    dy /= length;
    const double line[][2] = {
        {a[0], a[1]},     {b[0], b[1]},
        {(double)NAN, 0}, {b[0] - 7 * dx + 3.5 * dy, b[1] - 7 * dy - 3.5 * dx},
        {b[0], b[1]},     {b[0] - 7 * dx - 3.5 * dy, b[1] - 7 * dy + 3.5 * dx}};
    rmap_label_reserve(labels, a, b);
    rmap_svg_path(svg, line, 6, &(struct rmap_svg_style){.stroke = ink, .width = 1.4});
}

static void mark_source(const struct rmap_view_frame *frame, const struct rmap_source *source,
                        const char *ink, struct rmap_labels *labels, struct rmap_svg *svg)
{
    const struct rmap_svg_style line = {.stroke = ink, .width = ink == rmap_source_ink ? 2 : 1.2};
    const struct rmap_affine *place = &source->frame;
    double dot[2];
    pixel_of(frame, place->t, dot);
    if (source->type == RMAP_SOURCE_RAYS)
        return;
    if (source->shape == RMAP_EMITTER_DISC)
        draw_circle(frame, place, source->shape_size[0], svg, &line);
    else if (source->shape == RMAP_EMITTER_RECTANGLE)
        draw_parallelogram(frame, place->t,
                           rmap_affine_vector(place, rmap_vec3(0.5 * source->shape_size[0], 0, 0)),
                           rmap_affine_vector(place, rmap_vec3(0, 0.5 * source->shape_size[1], 0)),
                           svg, &line);
    else
        rmap_svg_circle(svg, dot[0], dot[1], 3.5, &(struct rmap_svg_style){.fill = ink});
    if (source->type == RMAP_SOURCE_COLLIMATED ||
        source->distribution != RMAP_DISTRIBUTION_ISOTROPIC)
        draw_arrow(frame, place->t, rmap_affine_vector(place, rmap_vec3(0, 0, 1)), ink, labels,
                   svg);
}

static const char *source_ink(const struct rmap_portion *rays, size_t source)
{
    size_t n_ray = rays->n_row[RMAP_TABLE_RAY];
    for (size_t i = 0; i < n_ray; i++)
        if ((size_t)rays->ray.source[i] == source)
            return rmap_source_ink;
    return n_ray > 0 ? faint_ink : rmap_source_ink;
}

void rmap_marks_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                     const struct rmap_view_frame *frame, struct rmap_labels *labels,
                     struct rmap_svg *svg)
{
    double at[2];
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct rmap_detector *detector = &scene->detector[d];
        if (detector->type == RMAP_DETECTOR_PLANE)
            draw_parallelogram(frame, detector->origin,
                               rmap_scale(detector->x, 0.5 * detector->size[0]),
                               rmap_scale(detector->y, 0.5 * detector->size[1]), svg,
                               &(struct rmap_svg_style){.stroke = rmap_detector_ink, .width = 2});
    }
    for (size_t s = 0; s < scene->n_source; s++)
        mark_source(frame, &scene->source[s], source_ink(rays, s), labels, svg);
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct rmap_source *source = &scene->source[s];
        bool listed = source->type == RMAP_SOURCE_RAYS && source->n_list > 0;
        pixel_of(frame, listed ? source->list[0].origin : source->frame.t, at);
        rmap_label_place(labels, svg, at, source_ink(rays, s), source->name);
    }
    for (size_t d = 0; d < scene->n_detector; d++)
        if (scene->detector[d].type == RMAP_DETECTOR_PLANE) {
            pixel_of(frame, scene->detector[d].origin, at);
            rmap_label_place(labels, svg, at, rmap_detector_ink, scene->detector[d].name);
        }
}

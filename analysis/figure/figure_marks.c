/* SPDX-License-Identifier: MIT
 *
 * Sources and detectors of a scene, marked and named.
 */
#include "analysis/figure/figure_marks.h"

#include <math.h>
#include <stdio.h>

#include "analysis/figure/detector_faces.h"
#include "base/alloc.h"

const char rmap_source_ink[] = "#c2410c";
const char rmap_detector_ink[] = "#0f766e";

enum { ROUND = 96 };
static const char faint_ink[] = "#e3b7a4";

static void pixel_of(const struct rmap_view_frame *frame, struct rmap_vec3 point, double pixel[2])
{
    struct rmap_vec3 p = rmap_view_project(frame->view, point);
    rmap_view_pixel(frame, (const double[2]){p.x, p.y}, pixel);
}

/* Draws a line through points, n of them at most ROUND + 1, as far as it is seen. */
static void draw_line(const struct rmap_view_frame *frame, const struct rmap_vec3 *point, size_t n,
                      struct rmap_svg *svg, const struct rmap_svg_style *style)
{
    double pixel[3 * ROUND][2];
    size_t n_pixel = 0;
    for (size_t k = 0; k < n && !frame->view->perspective; k++)
        pixel_of(frame, point[k], pixel[n_pixel++]);
    for (size_t k = 1; k < n && frame->view->perspective; k++) {
        struct rmap_vec3 from = point[k - 1], to = point[k];
        if (!rmap_view_clip(frame->view, &from, &to))
            continue;
        if (n_pixel > 0)
            pixel[n_pixel++][0] = (double)NAN;
        pixel_of(frame, from, pixel[n_pixel++]);
        pixel_of(frame, to, pixel[n_pixel++]);
    }
    if (n_pixel > 0)
        rmap_svg_path(svg, (const double(*)[2])pixel, n_pixel, style);
}

/* A rectangle about a point along two half edges: a parallelogram, seen edge-on a line. */
static void draw_parallelogram(const struct rmap_view_frame *frame, struct rmap_vec3 centre,
                               struct rmap_vec3 x, struct rmap_vec3 y, struct rmap_svg *svg,
                               const struct rmap_svg_style *style)
{
    struct rmap_vec3 corner[5];
    for (int k = 0; k < 5; k++)
        corner[k] = rmap_axpy((k + 1) / 2 % 2 ? 1.0 : -1.0, x,
                              rmap_axpy(k / 2 % 2 ? 1.0 : -1.0, y, centre));
    draw_line(frame, corner, 5, svg, style);
}

static void draw_circle(const struct rmap_view_frame *frame, const struct rmap_affine *place,
                        double radius, struct rmap_svg *svg, const struct rmap_svg_style *style)
{
    struct rmap_vec3 point[ROUND + 1];
    for (int k = 0; k <= ROUND; k++) {
        double angle = 2.0 * RMAP_PI * k / ROUND;
        point[k] = rmap_affine_point(place, rmap_vec3(radius * cos(angle), radius * sin(angle), 0));
    }
    draw_line(frame, point, ROUND + 1, svg, style);
}

/* An arrow of about 26 pixels from a point along a direction; nothing when it points at the eye. */
static void draw_arrow(const struct rmap_view_frame *frame, struct rmap_vec3 from,
                       struct rmap_vec3 direction, const char *ink, struct rmap_labels *labels,
                       struct rmap_svg *svg)
{
    const double aside = rmap_dot(direction, frame->view->right);
    const double above = rmap_dot(direction, frame->view->up);
    double a[2], b[2], reach = 26.0 / frame->scale;
    if (frame->stretch != 1.0)
        reach *= hypot(aside, above) / hypot(aside, frame->stretch * above);
    if (!rmap_view_sees(frame->view, from))
        return;
    if (frame->view->perspective)
        reach *= -rmap_view_place(frame->view, from).z;
    pixel_of(frame, from, a);
    const struct rmap_vec3 tip = rmap_axpy(reach, direction, from);
    if (!rmap_view_sees(frame->view, tip))
        return;
    pixel_of(frame, tip, b);
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
    if (rmap_source_is_of_rays(source))
        return;
    if (source->sky) { /* from its pole down, at the middle of what it lights */
        const struct rmap_vec3 down = rmap_affine_vector(place, rmap_vec3(0, 0, -1));
        draw_arrow(frame, rmap_axpy(-0.5 * source->shape_size[0], down, place->t), down, ink,
                   labels, svg);
        return;
    }
    const struct rmap_vec3 half = rmap_source_half_size(source);
    const bool round = source->shape == RMAP_EMITTER_DISC || source->type == RMAP_SOURCE_BEAM ||
                       (source->shape == RMAP_EMITTER_BODY && source->lamp->body != RMAP_LAMP_BOX &&
                        half.x == half.y);
    if (round && half.x > 0)
        draw_circle(frame, place, half.x, svg, &line);
    else if (half.x > 0 || half.y > 0)
        draw_parallelogram(frame, place->t, rmap_affine_vector(place, rmap_vec3(half.x, 0, 0)),
                           rmap_affine_vector(place, rmap_vec3(0, half.y, 0)), svg, &line);
    else if (rmap_view_sees(frame->view, place->t)) {
        pixel_of(frame, place->t, dot);
        rmap_svg_circle(svg, dot[0], dot[1], 3.5, &(struct rmap_svg_style){.fill = ink});
    }
    if (source->type == RMAP_SOURCE_COLLIMATED || source->type == RMAP_SOURCE_BEAM ||
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

static void put_name(const struct rmap_view_frame *frame, struct rmap_vec3 point, const char *ink,
                     const char *name, struct rmap_labels *labels, struct rmap_svg *svg)
{
    double at[2];
    if (isnan(point.x) || !rmap_view_sees(frame->view, point))
        return;
    pixel_of(frame, point, at);
    rmap_label_place(labels, svg, at, ink, name);
}

/* Its rectangle, or the faces on which it counts light, and where its name belongs. */
static enum rmap_status mark_detector(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                      const struct rmap_view_frame *frame, size_t index,
                                      struct rmap_svg *svg, struct rmap_vec3 *at,
                                      struct rmap_error *err)
{
    const struct rmap_detector *detector = &scene->detector[index];
    const struct rmap_svg_style style = {.stroke = rmap_detector_ink, .width = 2};
    bool flat;
    *at = detector->origin;
    const enum rmap_status st =
        rmap_detector_faces_draw(scene, mesh, frame, index, &style, svg, &flat, at, err);
    if (st == RMAP_OK && flat)
        draw_parallelogram(frame, detector->origin,
                           rmap_scale(detector->x, 0.5 * detector->size[0]),
                           rmap_scale(detector->y, 0.5 * detector->size[1]), svg, &style);
    return st;
}

enum rmap_status rmap_marks_draw(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                 const struct rmap_portion *rays,
                                 const struct rmap_view_frame *frame, struct rmap_labels *labels,
                                 struct rmap_svg *svg, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_vec3 *at = rmap_alloc(scene->n_detector + 1, sizeof *at);
    if (!at)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    for (size_t d = 0; d < scene->n_detector; d++)
        if (scene->detector[d].type == RMAP_DETECTOR_PLANE)
            RMAP_TRY(mark_detector(scene, mesh, frame, d, svg, &at[d], err));
    for (size_t s = 0; s < scene->n_source; s++)
        mark_source(frame, &scene->source[s], source_ink(rays, s), labels, svg);
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct rmap_source *source = &scene->source[s];
        put_name(frame, rmap_source_place(scene, source), source_ink(rays, s), source->name, labels,
                 svg);
    }
    for (size_t d = 0; d < scene->n_detector; d++)
        if (scene->detector[d].type == RMAP_DETECTOR_PLANE)
            put_name(frame, at[d], rmap_detector_ink, scene->detector[d].name, labels, svg);
out:
    rmap_free(at);
    return st;
}

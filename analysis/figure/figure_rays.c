/* SPDX-License-Identifier: MIT
 *
 * Rays of a portion as lines in the colour of their light, darkened to show on white paper, or in
 * the ink of their group.
 */
#include "analysis/figure/figure_rays.h"

#include <stdio.h>
#include <string.h>

#include "analysis/table/colour_map.h"
#include "base/alloc.h"
#include "optics/spectrum.h"
#include "portion/event.h"

/* Lightness (Oklab) that still shows on white: of grey, and of a saturated colour. */
static const double GREY_LIGHTNESS = 0.45, COLOUR_LIGHTNESS = 0.72, SATURATED = 0.12;

/* So many rays are drawn nearly opaque; more of them fainter, as the inverse square root. */
static const double OPAQUE_RAYS = 60.0, OPACITY = 0.8, FAINTEST = 0.08;

/* Of that: rays without flux to speak of, and what lies behind bodies. */
static const double WEAKEST = 0.35, HIDDEN = 0.16;

/* Between two looks at what hides a line, in pixels. */
static const double LOOK = 1.5;

void rmap_paper_ink(const double linear[3], char ink[8])
{
    double rgb[3], lab[3];
    uint8_t byte[3];
    for (int k = 0; k < 3; k++)
        rgb[k] = fmax(linear[k], 0.0);
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

void rmap_ray_ink(const struct rmap_scene *scene, const double *share, char ink[8])
{
    double rgb[3];
    rmap_colour_display(&scene->channels, share, scene->flux_unit == RMAP_FLUX_LM, rgb);
    rmap_paper_ink(rgb, ink);
}

/* A line being drawn; NaN lifts the pen. */
struct stroke {
    double (*pixel)[2];
    size_t n, cap;
};

struct pen {
    const struct rmap_scene *scene;
    const struct rmap_portion *rays;
    const struct rmap_ray_lines *lines;
    struct rmap_svg *svg;
    double opacity; /* of the ray in hand */
    struct rmap_svg_style style;
    char ink[8];
    struct stroke seen, hidden;
    struct rmap_vec3 last;  /* pixel and depth of the point before */
    struct rmap_vec3 place; /* of it, for a camera */
    bool down;              /* there is one */
    struct {
        struct rmap_vec3 place;
        double time; /* ns, with a window */
        bool begun;
    } passed; /* where the light came from, drawn or not */
    enum rmap_status status;
    struct rmap_error *err;
};

static void stroke_add(struct pen *pen, struct stroke *stroke, double x, double y)
{
    if (pen->status == RMAP_OK)
        pen->status = RMAP_RESERVE(stroke->pixel, stroke->cap, stroke->n + 1, pen->err);
    if (pen->status != RMAP_OK)
        return;
    stroke->pixel[stroke->n][0] = x;
    stroke->pixel[stroke->n++][1] = y;
}

/* From the point before to this one, in parts that are seen and parts that bodies hide. */
static void put_parts(struct pen *pen, struct rmap_vec3 to)
{
    const struct rmap_vec3 from = pen->last;
    const double length = hypot(to.x - from.x, to.y - from.y);
    const int n = length < 1e5 ? (int)ceil(length / LOOK) + 1 : 1;
    struct stroke *before = NULL;
    for (int k = 0; k < n; k++) {
        const double a = (double)k / n, b = (k + 1.0) / n, middle = 0.5 * (a + b);
        const struct rmap_vec3 along = rmap_sub(to, from), at = rmap_axpy(middle, along, from);
        struct stroke *stroke =
            rmap_solid_hides(pen->lines->solid, at.x, at.y, at.z) ? &pen->hidden : &pen->seen;
        if (stroke != before) {
            if (stroke->n > 0)
                stroke_add(pen, stroke, (double)NAN, 0.0);
            stroke_add(pen, stroke, from.x + a * along.x, from.y + a * along.y);
        }
        if (stroke != before && before)
            stroke_add(pen, before, from.x + a * along.x, from.y + a * along.y);
        before = stroke;
    }
    stroke_add(pen, before, to.x, to.y);
}

/* Pixel and depth. */
static struct rmap_vec3 projected(const struct pen *pen, struct rmap_vec3 point)
{
    struct rmap_vec3 p = rmap_view_project(pen->lines->frame->view, point);
    double pixel[2];
    rmap_view_pixel(pen->lines->frame, (const double[2]){p.x, p.y}, pixel);
    return rmap_vec3(pixel[0], pixel[1], p.z);
}

/* The part of a line that a camera sees. */
static void put_seen(struct pen *pen, struct rmap_vec3 point)
{
    struct rmap_vec3 from = pen->place, to = point;
    const bool draws = pen->down && rmap_view_clip(pen->lines->frame->view, &from, &to);
    pen->place = point;
    pen->down = true;
    if (!draws)
        return;
    pen->last = projected(pen, from);
    put_parts(pen, projected(pen, to));
}

static void draw_to(struct pen *pen, struct rmap_vec3 point)
{
    if (pen->lines->frame->view->perspective) {
        put_seen(pen, point);
        return;
    }
    const struct rmap_vec3 to = projected(pen, point);
    if (!pen->lines->solid)
        stroke_add(pen, &pen->seen, to.x, to.y);
    else if (pen->down)
        put_parts(pen, to);
    pen->last = to;
    pen->down = true;
}

static void lift(struct pen *pen)
{
    struct stroke *const stroke[] = {&pen->seen, &pen->hidden};
    for (int k = 0; k < 2; k++)
        if (stroke[k]->n > 0)
            stroke_add(pen, stroke[k], (double)NAN, 0.0);
    pen->down = false;
}

/* The light comes to a point at a time, which counts with a window alone. */
static void put_point(struct pen *pen, struct rmap_vec3 point, double time)
{
    const struct rmap_time_window *window = pen->lines->window;
    if (!window) {
        draw_to(pen, point);
        return;
    }
    const struct rmap_vec3 from = pen->passed.place, way = rmap_sub(point, from);
    const double begin = pen->passed.time, took = time - begin;
    const double a = fmax((window->from - begin) / took, 0.0);
    const double b = fmin((window->until - begin) / took, 1.0);
    if (pen->passed.begun && took > 0.0 && a < b) {
        if (a > 0.0 || !pen->down) {
            lift(pen);
            draw_to(pen, rmap_axpy(a, way, from));
        }
        draw_to(pen, rmap_axpy(b, way, from));
    }
    pen->passed.place = point;
    pen->passed.time = time;
    pen->passed.begun = true;
}

/* Points of one path at most: filling in pixels takes time with the square of its length. */
enum { PATH_POINTS = 32 };

static void put_line(struct pen *pen, const struct stroke *stroke)
{
    for (size_t i = 0; i + 1 < stroke->n; i += PATH_POINTS - 1) {
        const size_t n = stroke->n - i < PATH_POINTS ? stroke->n - i : PATH_POINTS;
        rmap_svg_path(pen->svg, (const double(*)[2])stroke->pixel + i, n, &pen->style);
    }
}

static void finish_line(struct pen *pen)
{
    const struct {
        struct stroke *stroke;
        double opacity;
    } part[] = {{&pen->hidden, HIDDEN * pen->opacity}, {&pen->seen, pen->opacity}};
    for (int k = 0; k < 2; k++) {
        pen->style.opacity = part[k].opacity;
        put_line(pen, part[k].stroke);
        part[k].stroke->n = 0;
    }
    pen->down = pen->passed.begun = false;
}

/* A curved segment: its ends and the points between them. */
struct curved_segment {
    struct rmap_vec3 from, to;
    const float *point; /* [n][3] */
    size_t n;
    double begin, end; /* times */
};

static struct rmap_vec3 node(const struct curved_segment *segment, size_t k)
{
    return k == 0           ? segment->from
           : k > segment->n ? segment->to
                            : rmap_vec3_of(segment->point + 3 * (k - 1));
}

/* Direction at a node, times so much: of the parabola through it and its neighbours, by length of
 * chord. */
static struct rmap_vec3 slope(const struct curved_segment *segment, size_t k, double times)
{
    size_t middle = k == 0 ? 1 : k > segment->n ? segment->n : k;
    struct rmap_vec3 before = rmap_sub(node(segment, middle), node(segment, middle - 1));
    struct rmap_vec3 behind = rmap_sub(node(segment, middle + 1), node(segment, middle));
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
static void put_curve(struct pen *pen, const struct curved_segment *segment)
{
    double whole = 0.0, before = 0.0; /* time is shared out by length of chord */
    for (size_t k = 0; pen->lines->window && k <= segment->n; k++)
        whole += rmap_length(rmap_sub(node(segment, k + 1), node(segment, k)));
    const double pace = whole > 0.0 ? (segment->end - segment->begin) / whole : 0.0;
    for (size_t k = 0; k <= segment->n; k++) {
        struct rmap_vec3 p = node(segment, k), q = node(segment, k + 1), chord = rmap_sub(q, p);
        double h = rmap_length(chord);
        struct rmap_vec3 u = slope(segment, k, h), v = slope(segment, k + 1, h);
        for (int s = 1;
             s <= RMAP_RAY_CURVE_STROKES && k + (s == RMAP_RAY_CURVE_STROKES) <= segment->n; s++) {
            double t = (double)s / RMAP_RAY_CURVE_STROKES, r = 1.0 - t;
            struct rmap_vec3 at = rmap_axpy(t * t * (3.0 - 2.0 * t), chord, p);
            put_point(pen, rmap_axpy(t * r * r, u, rmap_axpy(-t * t * r, v, at)),
                      segment->begin + pace * (before + t * h));
        }
        before += h;
    }
}

const char *rmap_segment_ink(const struct rmap_scene *scene, const struct rmap_portion *rays,
                             const struct rmap_ray_paint *paint, size_t ray, size_t segment,
                             char ink[8])
{
    const int n_channel = rays->n_channel;
    const uint16_t *colour = rays->colour + segment * (size_t)n_channel;
    double share[RMAP_CHANNEL_MAX];
    if (paint && paint->of_ray) {
        memcpy(ink, paint->group[paint->of_ray[ray]].ink, 8);
        return paint->group[paint->of_ray[ray]].dash;
    }
    for (int c = 0; c < scene->channels.n; c++)
        share[c] = c < n_channel ? colour[c] / 65535.0 : 0.0;
    rmap_ray_ink(scene, share, ink);
    return NULL;
}

/* A point of a ray, further on, that lies outside the picture or, of one that runs towards the eye
 * or away from it, very far off. */
static struct rmap_vec3 beyond_edge(const struct rmap_view_frame *frame, struct rmap_vec3 from,
                                    struct rmap_vec3 direction)
{
    static const double FAR = 1e3;
    const struct rmap_view *view = frame->view;
    if (view->perspective)
        return rmap_axpy(FAR * rmap_length(rmap_sub(from, view->eye)), direction, from);
    const struct rmap_vec3 at = rmap_view_place(view, from);
    const double aside = hypot(rmap_dot(direction, view->right), rmap_dot(direction, view->up));
    const double reach =
        hypot(at.x - frame->centre[0], at.y - frame->centre[1]) +
        0.5 * hypot(frame->width, frame->height) / (frame->scale * fmin(frame->stretch, 1.0));
    return rmap_axpy(reach / fmax(aside, 1.0 / FAR), direction, from);
}

/* One line per run of segments with the same colour. */
static void draw_ray(struct pen *pen, size_t ray, size_t first)
{
    const struct rmap_portion *rays = pen->rays;
    size_t n_channel = (size_t)rays->n_channel;
    const uint16_t *last = NULL;
    size_t point, n_point = rmap_portion_curve_of(rays, rays->ray.id[ray], &point);
    struct rmap_vec3 from = rmap_vec3_of(rays->ray.start + 3 * ray);
    const struct rmap_light_times *times = pen->lines->window ? pen->lines->window->times : NULL;
    for (size_t i = first; i < first + rays->ray.segment_count[ray]; i++) {
        const uint16_t *colour = rays->colour + i * n_channel;
        const double begin = times ? times->begin[i] : 0.0, end = times ? times->end[i] : 0.0;
        pen->passed.time = begin; /* fluorescence may have waited */
        if (!last || memcmp(last, colour, n_channel * sizeof *colour) != 0) {
            finish_line(pen);
            pen->style.dash =
                rmap_segment_ink(pen->scene, rays, pen->lines->paint, ray, i, pen->ink);
            put_point(pen, from, begin);
            last = colour;
        }
        struct rmap_vec3 to = rmap_vec3_of(rays->segment.position + 3 * i);
        struct curved_segment segment = {.from = from,
                                         .to = to,
                                         .point = rays->curve.position + 3 * point,
                                         .begin = begin,
                                         .end = end};
        while (segment.n < n_point && rays->curve.segment[point + segment.n] == i - first)
            segment.n++;
        if (segment.n > 0)
            put_curve(pen, &segment);
        point += segment.n;
        n_point -= segment.n;
        const uint32_t event = rays->segment.event[i];
        if (!(event & RMAP_EVENT_LEFT) || event & RMAP_EVENT_GRADIENT)
            put_point(pen, from = to, end);
        if (event & RMAP_EVENT_LEFT) {
            const struct rmap_vec3 direction = rmap_vec3_of(rays->ray.end_direction + 3 * ray);
            to = beyond_edge(pen->lines->frame, from, direction);
            put_point(pen, to,
                      end + (times ? times->leaving[ray] : 0.0) * rmap_length(rmap_sub(to, from)));
        }
    }
    finish_line(pen);
}

double rmap_ray_opacity(double n_ray)
{
    return fmax(OPACITY * fmin(sqrt(OPAQUE_RAYS / fmax(n_ray, 1.0)), 1.0), FAINTEST);
}

/* Rays of one group; of all without groups. */
static void draw_group(struct pen *pen, uint32_t group)
{
    const struct rmap_ray_lines *lines = pen->lines;
    const struct rmap_portion *rays = pen->rays;
    const struct rmap_ray_paint *paint = lines->paint;
    const double most = lines->opacity > 0.0
                            ? lines->opacity
                            : rmap_ray_opacity((double)rays->n_row[RMAP_TABLE_RAY]);
    for (size_t i = 0, segment = 0; i < rays->n_row[RMAP_TABLE_RAY];
         segment += rays->ray.segment_count[i++]) {
        if (paint && paint->of_ray && paint->of_ray[i] != group)
            continue;
        if (lines->map)
            pen->scene =
                rmap_map_scene_of(lines->map, rmap_map_space_of_ray(lines->map, rays->ray.id[i]));
        pen->opacity = most * (paint ? WEAKEST + (1.0 - WEAKEST) * paint->strength[i] : 1.0);
        draw_ray(pen, i, segment);
    }
}

enum rmap_status rmap_rays_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                                const struct rmap_ray_lines *lines, struct rmap_svg *svg,
                                struct rmap_error *err)
{
    struct pen pen = {.scene = scene, .rays = rays, .lines = lines, .svg = svg, .err = err};
    const size_t n_group = lines->paint ? lines->paint->n_group : 0;
    pen.style = (struct rmap_svg_style){
        .stroke = pen.ink, .width = (double)rays->n_row[RMAP_TABLE_RAY] > OPAQUE_RAYS ? 0.7 : 0.9};
    /* What belongs to no group of note lies below, then the largest groups: rare rays on top. */
    for (size_t k = 0; k < n_group; k++)
        draw_group(&pen, (uint32_t)((k + n_group - 1) % n_group));
    if (n_group == 0)
        draw_group(&pen, 0);
    rmap_free(pen.seen.pixel);
    rmap_free(pen.hidden.pixel);
    return pen.status;
}

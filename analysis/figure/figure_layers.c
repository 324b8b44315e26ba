/* SPDX-License-Identifier: MIT
 *
 * Hidden surfaces by a depth buffer. Lines are drawn where the object changes between neighbouring
 * pixels or the normal turns by more than 20 degrees, then two by two pixels are averaged. The
 * result goes into the picture as one image.
 */
#include "analysis/figure/figure_layers.h"

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_section.h"
#include "base/alloc.h"
#include "io/export/raster.h"

enum { OVERSAMPLING = 2 };

static const uint32_t NOTHING = UINT32_MAX;

static const double CREASE_COS = 0.9397; /* cos 20 degrees */

/* A face of glass covers what is behind it so far; and a point is behind a body when it is by more
 * than this part of the scene's depth: rays end on surfaces. */
static const double GLASS_COVER = 0.45, BEHIND = 0.006;

static bool is_glass(const struct rmap_scene *scene, size_t object)
{
    return rmap_object_look(scene, object) == RMAP_LOOK_REFRACTING;
}

static enum rmap_solid_layer layer_of(const struct rmap_scene *scene, size_t object)
{
    return is_glass(scene, object) ? RMAP_LAYER_GLASS : RMAP_LAYER_BODY;
}

static double edge(struct rmap_vec3 a, struct rmap_vec3 b, double x, double y)
{
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

static int within(double pixel, int most)
{
    return (int)fmin(fmax(pixel, -1.0), most);
}

void rmap_solid_fill(struct rmap_solid *canvas, const struct rmap_vec3 c[3],
                     const struct rmap_solid_pixel *kind)
{
    const enum rmap_solid_layer layer = layer_of(canvas->scene, kind->object);
    double area = edge(c[0], c[1], c[2].x, c[2].y);
    if (!(fabs(area) > 0.0) || !isfinite(area))
        return;
    int x0 = within(floor(fmin(c[0].x, fmin(c[1].x, c[2].x))), canvas->width);
    int x1 = within(ceil(fmax(c[0].x, fmax(c[1].x, c[2].x))), canvas->width - 1);
    int y0 = within(floor(fmin(c[0].y, fmin(c[1].y, c[2].y))), canvas->height);
    int y1 = within(ceil(fmax(c[0].y, fmax(c[1].y, c[2].y))), canvas->height - 1);
    for (int y = y0 < 0 ? 0 : y0; y <= y1; y++)
        for (int x = x0 < 0 ? 0 : x0; x <= x1; x++) {
            double u = edge(c[1], c[2], x + 0.5, y + 0.5) / area;
            double v = edge(c[2], c[0], x + 0.5, y + 0.5) / area;
            if (u < 0.0 || v < 0.0 || u + v > 1.0)
                continue;
            float depth = (float)(u * c[0].z + v * c[1].z + (1.0 - u - v) * c[2].z);
            struct rmap_solid_pixel *at =
                &canvas->pixel[layer][(size_t)y * (size_t)canvas->width + (size_t)x];
            if (at->object != NOTHING && at->depth >= depth)
                continue;
            *at = *kind;
            at->depth = depth;
        }
}

static enum rmap_status clear_layers(struct rmap_solid *canvas, struct rmap_error *err)
{
    const size_t n_pixel = (size_t)canvas->width * (size_t)canvas->height;
    bool any[RMAP_LAYER_COUNT] = {[RMAP_LAYER_BODY] = true};
    for (size_t o = 0; o < canvas->scene->n_object; o++)
        any[layer_of(canvas->scene, o)] = true;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++) {
        if (!any[layer])
            continue;
        canvas->pixel[layer] = rmap_alloc(n_pixel, sizeof(struct rmap_solid_pixel));
        if (!canvas->pixel[layer])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
        for (size_t i = 0; i < n_pixel; i++)
            canvas->pixel[layer][i].object = NOTHING;
    }
    return RMAP_OK;
}

enum rmap_status rmap_solid_init(const struct rmap_scene *scene,
                                 const struct rmap_view_frame *frame, struct rmap_solid *canvas,
                                 struct rmap_error *err)
{
    *canvas = (struct rmap_solid){
        .scene = scene, .frame = frame, .scale = RMAP_FIGURE_SCALE * OVERSAMPLING};
    canvas->width = OVERSAMPLING * (int)(frame->width * RMAP_FIGURE_SCALE);
    canvas->height = OVERSAMPLING * (int)(frame->height * RMAP_FIGURE_SCALE);
    return clear_layers(canvas, err);
}

void rmap_solid_find_depths(struct rmap_solid *canvas)
{
    const size_t n_pixel = (size_t)canvas->width * (size_t)canvas->height;
    canvas->nearest = -INFINITY;
    canvas->farthest = INFINITY;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++)
        for (size_t i = 0; canvas->pixel[layer] && i < n_pixel; i++)
            if (canvas->pixel[layer][i].object != NOTHING) {
                canvas->nearest = fmaxf(canvas->nearest, canvas->pixel[layer][i].depth);
                canvas->farthest = fminf(canvas->farthest, canvas->pixel[layer][i].depth);
            }
}

/* Distance between the nearest and the farthest that is seen. */
static double range_of(const struct rmap_solid *canvas)
{
    const struct rmap_view *view = canvas->frame->view;
    return rmap_view_distance(view, (double)canvas->farthest) -
           rmap_view_distance(view, (double)canvas->nearest);
}

/* Does a line run between two neighbouring pixels? */
static bool parted(const struct rmap_solid_pixel *a, const struct rmap_solid_pixel *b)
{
    if (a->object != b->object)
        return true;
    if (a->object == NOTHING)
        return false;
    double cosine =
        (a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1] + a->normal[2] * b->normal[2]) /
        (127.0 * 127.0);
    return cosine < CREASE_COS;
}

/* Face or line of one layer over what is there; what is far is lighter. */
static void cover(const struct rmap_solid *canvas, enum rmap_solid_layer layer, size_t x, size_t y,
                  double rgb[3])
{
    const size_t width = (size_t)canvas->width;
    const struct rmap_solid_pixel *at = &canvas->pixel[layer][y * width + x];
    const struct rmap_solid_pixel *right = x + 1 < width ? at + 1 : at;
    const struct rmap_solid_pixel *below = y + 1 < (size_t)canvas->height ? at + width : at;
    const struct rmap_solid_pixel *front =
        at->object == NOTHING ? right->object == NOTHING ? below : right : at;
    const struct rmap_solid_pixel *wall = &canvas->pixel[RMAP_LAYER_BODY][y * width + x];
    if (layer == RMAP_LAYER_GLASS && wall->object != NOTHING && wall->depth > front->depth)
        return;
    if (parted(at, right) || parted(at, below)) {
        const struct rmap_view *view = canvas->frame->view;
        double range = range_of(canvas);
        double far = range > 0.0 ? (rmap_view_distance(view, (double)front->depth) -
                                    rmap_view_distance(view, (double)canvas->nearest)) /
                                       range
                                 : 0.0;
        for (int k = 0; k < 3; k++)
            rgb[k] = 0.35 + 0.33 * fmin(fmax(far, 0.0), 1.0);
        return;
    }
    if (at->object == NOTHING)
        return;
    const double *tint = rmap_look_style[rmap_object_look(canvas->scene, at->object)].tint;
    const double part = layer == RMAP_LAYER_GLASS ? GLASS_COVER : 1.0;
    for (int k = 0; k < 3; k++)
        rgb[k] += part * (tint[k] * (0.80 + 0.20 * at->shade / 255.0) - rgb[k]);
}

/* sRGB of a pixel of the layers on white paper. */
static void colour_of(const struct rmap_solid *canvas, size_t x, size_t y, double rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = 1.0;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++)
        if (canvas->pixel[layer])
            cover(canvas, (enum rmap_solid_layer)layer, x, y, rgb);
}

enum rmap_status rmap_solid_draw(const struct rmap_solid *canvas, struct rmap_svg *svg,
                                 struct rmap_error *err)
{
    const struct rmap_view_frame *frame = canvas->frame;
    size_t width = (size_t)canvas->width / OVERSAMPLING;
    size_t height = (size_t)canvas->height / OVERSAMPLING, nbytes = 0;
    uint8_t *rgb = rmap_alloc(width * height, 3), *png = NULL;
    if (!rgb)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    for (size_t i = 0; i < width * height; i++) {
        double sum[3] = {0.0, 0.0, 0.0}, part[3];
        for (size_t s = 0; s < OVERSAMPLING * OVERSAMPLING; s++) {
            colour_of(canvas, OVERSAMPLING * (i % width) + s % OVERSAMPLING,
                      OVERSAMPLING * (i / width) + s / OVERSAMPLING, part);
            for (int k = 0; k < 3; k++)
                sum[k] += part[k] / (OVERSAMPLING * OVERSAMPLING);
        }
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = (uint8_t)(255.0 * sum[k] + 0.5);
    }
    enum rmap_status st =
        rmap_png_encode(rgb, (uint32_t)width, (uint32_t)height, &png, &nbytes, err);
    if (st == RMAP_OK)
        rmap_svg_image(svg, frame->x, frame->y, frame->width, frame->height, png, nbytes);
    rmap_free(png);
    rmap_free(rgb);
    return st;
}

bool rmap_solid_hides(const struct rmap_solid *canvas, double x, double y, double depth)
{
    const struct rmap_view *view = canvas->frame->view;
    const double i = floor((x - canvas->frame->x) * canvas->scale);
    const double j = floor((y - canvas->frame->y) * canvas->scale);
    if (!(i >= 0.0 && i < canvas->width && j >= 0.0 && j < canvas->height))
        return false;
    const struct rmap_solid_pixel *at =
        &canvas->pixel[RMAP_LAYER_BODY][(size_t)j * (size_t)canvas->width + (size_t)i];
    return at->object != NOTHING &&
           rmap_view_distance(view, depth) >
               rmap_view_distance(view, (double)at->depth) + BEHIND * range_of(canvas);
}

/* SPDX-License-Identifier: MIT
 *
 * The picture of a scene with rays: a section through it, or a view from above.
 */
#include "analysis/figure/figure_draw.h"

#include <math.h>
#include <stdio.h>

#include "analysis/figure/figure_legend.h"
#include "analysis/figure/figure_marks.h"
#include "analysis/figure/figure_parts.h"
#include "analysis/figure/figure_rays.h"
#include "analysis/figure/figure_registered.h"
#include "analysis/figure/figure_section.h"
#include "analysis/figure/figure_solid.h"
#include "analysis/figure/object_colour.h"
#include "analysis/figure/scene_mesh.h"
#include "analysis/table/figure_axes.h"
#include "base/alloc.h"
#include "base/grouped.h"

enum { MARGIN = 24, TOP = 84, BELOW = 22, WIDEST = 1040, HIGHEST = 660, NARROWEST = 620 };
enum { LOWEST = 200, SCALE_BAR = 34 /* with its text */ };
enum {
    COLOUR_BAR_GAP = 22,
    COLOUR_BAR_WIDTH = 22,
    COLOUR_BAR_ROOM = 140,
    COLOUR_BAR_LONGEST = 480
};

/* White around the scene, as a part of its size. */
static const double BORDER = 0.08;

/* Scenes that are so many times longer one way than the other are stretched, to this ratio. */
static const double SLENDER = 20.0, STRETCHED = 4.0;

static double fitting_stretch(const struct rmap_view *view, double width, double height)
{
    if (!view->section || !(width > 0.0 && height > 0.0))
        return 1.0;
    if (width > SLENDER * height)
        return rmap_round_below(width / height / STRETCHED);
    return height > SLENDER * width ? 1.0 / rmap_round_below(height / width / STRETCHED) : 1.0;
}

/* stretch: 0: as suits. */
static void fit(const struct rmap_scene *scene, const struct rmap_view *view, double stretch,
                const struct rmap_figure_cells *painted, struct rmap_view_frame *frame)
{
    struct rmap_view_box box = RMAP_VIEW_BOX_EMPTY;
    if (!painted)
        rmap_view_bounds(scene, view, &box);
    for (size_t p = 0; painted && p < painted->cells->n_part; p++)
        rmap_view_cover_object(scene, view, (size_t)painted->cells->part[p].object, &box);
    double w = box.high[0] - box.low[0], h = box.high[1] - box.low[1];
    if (stretch == 0.0)
        stretch = fitting_stretch(view, w, h);
    h *= stretch;
    double size = fmax(w, h);
    if (!(size > 0.0))
        size = 1.0;
    w = fmax(w, 0.01 * size) + 2.0 * BORDER * size;
    h = fmax(h, 0.01 * size) + 2.0 * BORDER * size;
    double scale = fmin(WIDEST / w, HIGHEST / h);
    *frame = (struct rmap_view_frame){
        .view = view,
        .x = MARGIN,
        .y = TOP,
        .width = fmax(rint(w * scale), NARROWEST),
        .height = fmax(rint(h * scale), LOWEST),
        .scale = scale,
        .stretch = stretch,
        .centre = {0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1])}};
}

/* What the camera sees, as large as there is room; narrow pictures show more at their sides. */
static void fit_camera(struct rmap_view *view, struct rmap_view_frame *frame)
{
    const double height = fmin(HIGHEST, WIDEST * view->slope[1] / view->slope[0]);
    *frame = (struct rmap_view_frame){
        .view = view,
        .x = MARGIN,
        .y = TOP,
        .width = fmax(rint(height * view->slope[0] / view->slope[1]), NARROWEST),
        .height = fmax(rint(height), LOWEST),
        .scale = 0.5 * height / view->slope[1],
        .stretch = 1.0};
    view->slope[0] = 0.5 * frame->width / frame->scale;
    view->slope[1] = 0.5 * frame->height / frame->scale;
}

/* Of objects in false colours. */
static void draw_painted_captions(const struct rmap_figure_draw *options,
                                  const struct rmap_view_frame *frame, struct rmap_svg *svg)
{
    char asked[1024], line[1024];
    (void)snprintf(asked, sizeof asked, "rays: %s",
                   options->criterion ? options->criterion : "all");
    (void)snprintf(line, sizeof line, "%s; %s", options->painted->caption,
                   frame->view->description);
    rmap_captions(svg, MARGIN, (const char *const[]){options->title, asked, line}, 3);
}

static void draw_captions(const struct rmap_scene *scene, const struct rmap_portion *rays,
                          const struct rmap_figure_draw *options,
                          const struct rmap_view_frame *frame, uint64_t registered,
                          struct rmap_svg *svg)
{
    char asked[1024], line[1024], shown[2048], drawn[RMAP_GROUPED_LEN], matched[RMAP_GROUPED_LEN],
        kept[RMAP_GROUPED_LEN];
    (void)snprintf(asked, sizeof asked, "rays: %s",
                   options->criterion ? options->criterion : "all");
    const uint64_t n_drawn = rays->n_row[RMAP_TABLE_RAY];
    const struct rmap_near_plane *near = options->near;
    int n = snprintf(line, sizeof line, "%s", options->n_matched > 0 ? "" : "no ray matches");
    if (n == 0 && !near && n_drawn < options->n_matched)
        n = snprintf(line, sizeof line, "%s of %s rays drawn, those with the smallest ids%s",
                     rmap_grouped(n_drawn, drawn), rmap_grouped(options->n_matched, matched),
                     options->paint && options->paint->dealt ? " of each criterion" : "");
    else if (n == 0)
        n = snprintf(line, sizeof line, "%s ray%s drawn", rmap_grouped(n_drawn, drawn),
                     n_drawn == 1 ? "" : "s");
    n += snprintf(line + n, sizeof line - (size_t)n, "; %s", frame->view->description);
    if (frame->stretch != 1.0)
        n += snprintf(line + n, sizeof line - (size_t)n, ", %s %.4g times",
                      frame->stretch > 1.0 ? "stretched upwards" : "stretched to the right",
                      fmax(frame->stretch, 1.0 / frame->stretch));
    if (options->paint && options->paint->note)
        n += snprintf(line + n, sizeof line - (size_t)n, "; paths: %s", options->paint->note);
    if (near)
        (void)snprintf(
            line + n, sizeof line - (size_t)n,
            "; of the first %s of %s rays %s run within %.4g %s of its plane all their way",
            rmap_grouped(near->looked, drawn), rmap_grouped(options->n_matched, matched),
            rmap_grouped(near->near, kept), near->distance, scene->unit);
    if (options->window)
        (void)snprintf(
            shown, sizeof shown, "light from %.6g to %.6g ns; registered by then: %s; %s",
            options->window->from, options->window->until, rmap_grouped(registered, drawn), line);
    rmap_captions(svg, MARGIN,
                  (const char *const[]){options->title, asked, options->window ? shown : line}, 3);
}

static void choose_view(const struct rmap_scene *scene, const struct rmap_portion *rays,
                        const struct rmap_figure_draw *options, struct rmap_view *view)
{
    if (options->camera) {
        rmap_view_camera(scene, options->camera, view);
        return;
    }
    rmap_view_choose(scene, options->kind, rays, view);
    if (options->eye && !view->section)
        rmap_view_turn(scene, options->eye[0], options->eye[1], view);
    if (options->cut && view->section)
        rmap_view_move(scene, *options->cut, view);
    if (options->misses_ret)
        *options->misses_ret =
            options->cut && view->section && !rmap_view_meets_objects(scene, view);
}

/* Bodies in false colours of their cells, and the scale beside them. */
static enum rmap_status draw_painted(const struct rmap_scene *scene,
                                     const struct rmap_figure_cells *painted,
                                     const struct rmap_view_frame *frame, struct rmap_svg *svg,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = painted->cells->n_cell;
    struct rmap_mesh **mesh = NULL;
    struct rmap_solid *solid = NULL;
    struct rmap_colour_map map;
    struct rmap_colour_bar bar = painted->bar;
    struct rmap_painted faces = {painted->cells, rmap_alloc(n + 1, sizeof *faces.rgb),
                                 painted->side};
    if (!faces.rgb)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    rmap_colour_map_init(&map);
    for (size_t c = 0; c < n; c++)
        rmap_colour_map_at(&map, rmap_colour_bar_place(&bar, painted->value[c]), faces.rgb[c]);
    RMAP_TRY(rmap_scene_meshes_create(scene, &mesh, err));
    RMAP_TRY(rmap_solid_create(scene, mesh, &faces, frame, &solid, err));
    RMAP_TRY(rmap_solid_draw(solid, svg, err));
    bar.x = frame->x + frame->width + COLOUR_BAR_GAP;
    bar.height = fmin(frame->height, COLOUR_BAR_LONGEST);
    bar.y = frame->y + 0.5 * (frame->height - bar.height);
    bar.width = COLOUR_BAR_WIDTH;
    st = rmap_colour_bar_draw(svg, &bar, &map, err);
out:
    rmap_solid_destroy(solid);
    rmap_scene_meshes_destroy(mesh, scene->n_geometry);
    rmap_free(faces.rgb);
    return st;
}

void rmap_figure_bodies_fini(struct rmap_figure_bodies *bodies)
{
    rmap_solid_destroy(bodies->solid);
    rmap_scene_meshes_destroy(bodies->mesh, bodies->n);
    bodies->solid = NULL;
    bodies->mesh = NULL;
}

static enum rmap_status make_bodies(const struct rmap_scene *scene,
                                    const struct rmap_view_frame *frame,
                                    struct rmap_figure_bodies *bodies, struct rmap_error *err)
{
    if (bodies->mesh)
        return RMAP_OK;
    enum rmap_status st = rmap_scene_meshes_create(scene, &bodies->mesh, err);
    bodies->n = scene->n_geometry;
    bodies->view = *frame->view;
    bodies->frame = *frame;
    bodies->frame.view = &bodies->view;
    if (st == RMAP_OK && !frame->view->section)
        st = rmap_solid_create(scene, bodies->mesh, NULL, &bodies->frame, &bodies->solid, err);
    return st;
}

/* Scene, rays and marks, inside the frame. */
static enum rmap_status draw_inside(const struct rmap_scene *scene, const struct rmap_portion *rays,
                                    const struct rmap_figure_draw *options,
                                    struct rmap_ray_lines *lines, uint64_t *registered,
                                    struct rmap_svg *svg, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_view_frame *frame = lines->frame;
    struct rmap_figure_bodies own = {0}, *bodies = options->bodies ? options->bodies : &own;
    RMAP_TRY(make_bodies(scene, frame, bodies, err));
    rmap_svg_open_clip(svg, frame->x, frame->y, frame->width, frame->height);
    if (frame->view->section) {
        RMAP_TRY(rmap_section_draw(scene, bodies->mesh, frame, svg, err));
    } else {
        RMAP_TRY(rmap_solid_draw(bodies->solid, svg, err));
    }
    lines->solid = bodies->solid;
    lines->map = options->map;
    lines->paint = options->paint;
    lines->opacity = options->opacity;
    lines->window = options->window;
    RMAP_TRY(rmap_rays_draw(scene, rays, lines, svg, err));
    if (lines->window)
        *registered = rmap_registered_draw(scene, rays, lines, svg);
    struct rmap_labels labels = {.area = {frame->x, frame->y, frame->width, frame->height}};
    const double foot = frame->y + frame->height; /* where the axes' arrows stand */
    rmap_label_reserve(&labels, (const double[2]){frame->x, foot - 86},
                       (const double[2]){frame->x + 96, foot});
    RMAP_TRY(rmap_marks_draw(scene, bodies->mesh, rays, frame, &labels, svg, err));
    RMAP_TRY(rmap_parts_name(scene, frame, &labels, svg, err));
    rmap_svg_close(svg);
out:
    rmap_figure_bodies_fini(&own);
    return st;
}

enum rmap_status rmap_figure_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                                  const struct rmap_figure_draw *options, struct rmap_svg **svg_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    struct rmap_view view;
    struct rmap_view_frame frame;
    const bool mixed = options->map && rmap_map_n_space(options->map) > 1;
    choose_view(scene, rays, options, &view);
    struct rmap_ray_lines lines = {.frame = &frame};
    if (view.perspective)
        fit_camera(&view, &frame);
    else
        fit(scene, &view, options->stretch, options->painted, &frame);
    double marks = RMAP_LEGEND_ROW;
    double(*colour)[3] = rmap_object_colours(scene);
    if (!colour)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    const double(*tint)[3] = (const double(*)[3])colour;
    const double legend = options->painted ? 0.0
                                           : rmap_legend_draw(scene, rays, &frame, options->paint,
                                                              tint, mixed, &marks, NULL);
    RMAP_TRY(rmap_svg_create(frame.width + 2 * MARGIN + (options->painted ? COLOUR_BAR_ROOM : 0),
                             TOP + frame.height +
                                 fmax(legend, marks + SCALE_BAR - RMAP_LEGEND_ROW) + BELOW,
                             options->title, &svg, err));
    uint64_t registered = 0;
    RMAP_TRY(options->painted ? draw_painted(scene, options->painted, &frame, svg, err)
                              : draw_inside(scene, rays, options, &lines, &registered, svg, err));
    rmap_svg_rect(svg, frame.x, frame.y, frame.width, frame.height,
                  &(struct rmap_svg_style){.stroke = "#b0b0b0"});
    rmap_axis_cross_draw(&frame, svg);
    if (!options->painted)
        (void)rmap_legend_draw(scene, rays, &frame, options->paint, tint, mixed, &marks, svg);
    if (!view.perspective)
        rmap_scale_bar_draw(scene, &frame, marks, svg);
    if (options->painted)
        draw_painted_captions(options, &frame, svg);
    else
        draw_captions(scene, rays, options, &frame, registered, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    rmap_free(colour);
    rmap_svg_destroy(svg);
    return st;
}

enum rmap_status rmap_figure_draw_near(const struct rmap_scene *scene, enum rmap_view_kind *kind,
                                       const double *cut, struct rmap_near_plane *near,
                                       struct rmap_portion **rays, struct rmap_error *err)
{
    struct rmap_view view;
    *kind = rmap_view_resolve(scene, *kind, *rays);
    if (*kind == RMAP_VIEW_3D)
        return rmap_error_set(err, RMAP_USAGE,
                              "--near chooses rays of a section: say --view yz, xz or xy");
    choose_view(scene, *rays, &(struct rmap_figure_draw){.kind = *kind, .cut = cut}, &view);
    return rmap_near_plane_keep(&view, near, rays, err);
}

void rmap_figure_draw_thin(struct rmap_portion *rays)
{
    size_t n[RMAP_TABLE_COUNT] = {0}, strokes = 0;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        size_t first, points = rmap_portion_curve_of(rays, rays->ray.id[i], &first);
        strokes += rays->ray.segment_count[i] + RMAP_RAY_CURVE_STROKES * points;
        if (strokes > RMAP_FIGURE_STROKES && i > 0)
            break;
        n[RMAP_TABLE_RAY]++;
        n[RMAP_TABLE_SEGMENT] += rays->ray.segment_count[i];
        n[RMAP_TABLE_REGISTRATION] += rays->ray.registration_count[i];
        n[RMAP_TABLE_CURVE] += points;
    }
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rays->n_row[t] = n[t];
}

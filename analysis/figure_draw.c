/* SPDX-License-Identifier: MIT */
#include "analysis/figure_draw.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "analysis/figure_axes.h"
#include "analysis/figure_legend.h"
#include "analysis/figure_marks.h"
#include "analysis/figure_rays.h"
#include "analysis/figure_section.h"
#include "analysis/figure_solid.h"
#include "analysis/tessellation.h"
#include "base/alloc.h"

enum { MARGIN = 24, TOP = 84, BOTTOM = 56, WIDEST = 1040, HIGHEST = 660, NARROWEST = 620 };
enum { LOWEST = 200, LEGEND_LENGTH = 1500 /* of all its samples, about */ };

/* White around the scene, and length of a leg that leaves, as parts of the scene's size. */
static const double BORDER = 0.08, LEAVING = 0.12;

static void destroy_meshes(struct rmap_mesh **mesh, size_t n)
{
    for (size_t g = 0; mesh && g < n; g++)
        rmap_mesh_destroy(mesh[g]);
    rmap_free(mesh);
}

static enum rmap_status make_meshes(const struct rmap_scene *scene, struct rmap_mesh ***mesh_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh **mesh = rmap_alloc(scene->n_geometry + 1, sizeof *mesh);
    if (!mesh)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    for (size_t g = 0; g < scene->n_geometry; g++) {
        const struct rmap_geometry *geometry = &scene->geometry[g];
        if (geometry->kind == RMAP_GEOMETRY_SHAPE)
            RMAP_TRY(rmap_shape_tessellate(&geometry->shape, &mesh[g], err));
        else
            RMAP_TRY(rmap_mesh_weld(geometry->mesh, &mesh[g], err));
    }
    *mesh_ret = mesh;
    mesh = NULL;
out:
    destroy_meshes(mesh, scene->n_geometry);
    return st;
}

static double fit(const struct rmap_scene *scene, const struct rmap_view *view,
                  struct rmap_view_frame *frame)
{
    struct rmap_view_box box;
    rmap_view_bounds(scene, view, &box);
    double w = box.high[0] - box.low[0], h = box.high[1] - box.low[1], size = fmax(w, h);
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
        .centre = {0.5 * (box.low[0] + box.high[0]), 0.5 * (box.low[1] + box.high[1])}};
    return size;
}

/* 1234567 as 1,234,567. */
static void grouped(uint64_t value, char *text, size_t size)
{
    char digits[32];
    size_t n = (size_t)snprintf(digits, sizeof digits, "%" PRIu64, value), at = 0;
    for (size_t i = 0; i < n && at + 2 < size; i++) {
        if (i > 0 && (n - i) % 3 == 0)
            text[at++] = ',';
        text[at++] = digits[i];
    }
    text[at] = 0;
}

static void draw_captions(const struct rmap_portion *rays, const struct rmap_figure_draw *options,
                          const struct rmap_view *view, struct rmap_svg *svg)
{
    double room = rmap_svg_width(svg) - 2 * MARGIN;
    char line[1024], drawn[32], matched[32];
    rmap_caption(svg,
                 &(struct rmap_svg_text){.x = MARGIN, .y = 30, .size = RMAP_TITLE_SIZE, .bold = 1},
                 room, options->title);
    struct rmap_svg_text text = {.x = MARGIN, .y = 50, .size = RMAP_TICK_SIZE, .fill = "#444444"};
    (void)snprintf(line, sizeof line, "rays: %s", options->criterion ? options->criterion : "all");
    rmap_caption(svg, &text, room, line);
    uint64_t n_drawn = rays->n_row[RMAP_TABLE_RAY];
    grouped(n_drawn, drawn, sizeof drawn);
    grouped(options->n_matched, matched, sizeof matched);
    if (n_drawn == 0)
        (void)snprintf(line, sizeof line, "no ray matches; %s", view->description);
    else if (n_drawn < options->n_matched)
        (void)snprintf(line, sizeof line, "%s of %s rays drawn, those with the smallest ids; %s",
                       drawn, matched, view->description);
    else
        (void)snprintf(line, sizeof line, "%s ray%s drawn; %s", drawn, n_drawn == 1 ? "" : "s",
                       view->description);
    text.y = 68;
    rmap_caption(svg, &text, room, line);
}

enum rmap_status rmap_figure_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                                  const struct rmap_figure_draw *options, struct rmap_svg **svg_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    struct rmap_mesh **mesh = NULL;
    struct rmap_view view;
    struct rmap_view_frame frame;
    rmap_view_choose(scene, options->kind, rays, &view);
    double size = fit(scene, &view, &frame);
    RMAP_TRY(make_meshes(scene, &mesh, err));
    double bottom = BOTTOM + RMAP_LEGEND_ROW * floor(LEGEND_LENGTH / frame.width);
    RMAP_TRY(rmap_svg_create(frame.width + 2 * MARGIN, TOP + frame.height + bottom, options->title,
                             &svg, err));
    rmap_svg_open_clip(svg, frame.x, frame.y, frame.width, frame.height);
    if (view.section)
        RMAP_TRY(rmap_section_draw(scene, mesh, &frame, svg, err));
    else
        RMAP_TRY(rmap_solid_draw(scene, mesh, &frame, svg, err));
    RMAP_TRY(rmap_rays_draw(scene, options->map, rays, &frame, LEAVING * size, svg, err));
    struct rmap_labels labels = {.area = {frame.x, frame.y, frame.width, frame.height}};
    rmap_marks_draw(scene, rays, &frame, &labels, svg);
    rmap_svg_close(svg);
    rmap_svg_rect(svg, frame.x, frame.y, frame.width, frame.height,
                  &(struct rmap_svg_style){.stroke = "#b0b0b0"});
    rmap_axis_cross_draw(&frame, svg);
    rmap_legend_draw(scene, rays, &frame, options->map && rmap_map_n_space(options->map) > 1, svg);
    rmap_scale_bar_draw(scene, &frame, svg);
    draw_captions(rays, options, &view, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    destroy_meshes(mesh, scene->n_geometry);
    rmap_svg_destroy(svg);
    return st;
}

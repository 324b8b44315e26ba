/* SPDX-License-Identifier: MIT
 *
 * What the lines of a drawing mean, and how long they are.
 */
#include "analysis/figure/figure_legend.h"

#include <stdio.h>
#include <string.h>

#include "analysis/figure/figure_marks.h"
#include "analysis/figure/figure_rays.h"
#include "analysis/figure/figure_section.h"
#include "analysis/figure/figure_solid.h"
#include "analysis/figure/object_colour.h"
#include "analysis/table/figure_axes.h"
#include "base/grouped.h"

enum { SAMPLE = 22, GAP = 14, WAVELENGTHS_SHOWN = 8, MIXTURES_SHOWN = 3, BAR_ROOM = 230 };
static const char ink[] = "#222222";

struct legend {
    struct rmap_svg *svg; /* NULL: nothing is drawn, to see how long it becomes */
    double x, y, left, right;
};

static void add_sample(struct legend *legend, const char *colour, double width, const char *word)
{
    double length = SAMPLE + 6 + rmap_svg_string_width(word, RMAP_TICK_SIZE);
    if (legend->x + length > legend->right && legend->x > legend->left) {
        legend->x = legend->left;
        legend->y += RMAP_LEGEND_ROW;
    }
    if (legend->svg) {
        const struct rmap_svg_text text = {
            .x = legend->x + SAMPLE + 6, .y = legend->y, .size = RMAP_TICK_SIZE, .fill = ink};
        rmap_svg_rect(legend->svg, legend->x, legend->y - 4.5 - 0.5 * width, SAMPLE, width,
                      &(struct rmap_svg_style){.fill = colour});
        rmap_caption(legend->svg, &text, legend->right - text.x, word);
    }
    legend->x += length + GAP;
}

/* Which channels are left alone on some segment, and whether any segment carries several. */
static void channels_in_use(const struct rmap_portion *rays, bool *alone, bool *several)
{
    size_t n_channel = (size_t)rays->n_channel;
    *several = false;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_SEGMENT]; i++) {
        size_t n_live = 0, last = 0;
        for (size_t c = 0; c < n_channel; c++)
            if (rays->colour[i * n_channel + c] > 0) {
                n_live++;
                last = c;
            }
        if (n_live == 1)
            alone[last] = true;
        *several = *several || n_live > 1;
    }
}

/* Light of several wavelengths has the colour of its source's: of each, where they differ. */
static void add_mixtures(struct legend *legend, const struct rmap_scene *scene,
                         const struct rmap_portion *rays)
{
    char ink_of[MIXTURES_SHOWN][8], word[256];
    size_t source[MIXTURES_SHOWN], n = 0;
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t s = (size_t)rays->ray.source[i];
        char colour[8];
        size_t k = 0;
        rmap_ray_ink(scene, scene->source[s].colour, colour);
        while (k < n && strcmp(ink_of[k], colour) != 0)
            k++;
        if (k < n)
            continue;
        if (n == MIXTURES_SHOWN) {
            add_sample(legend, "#808080", 1.0, "several wavelengths, in their colour");
            return;
        }
        source[n] = s;
        memcpy(ink_of[n++], colour, sizeof colour);
    }
    for (size_t k = 0; k < n; k++) {
        (void)snprintf(word, sizeof word,
                       n > 1 ? "several wavelengths of %.200s" : "several wavelengths",
                       scene->source[source[k]].name);
        add_sample(legend, ink_of[k], 2.0, word);
    }
}

static void add_wavelengths(struct legend *legend, const struct rmap_scene *scene,
                            const struct rmap_portion *rays)
{
    bool alone[RMAP_CHANNEL_MAX] = {false}, several = false;
    int n_alone = 0, seen = 0, shown = 0;
    channels_in_use(rays, alone, &several);
    for (int c = 0; c < scene->channels.n; c++)
        n_alone += alone[c];
    int wanted = n_alone < WAVELENGTHS_SHOWN ? n_alone : WAVELENGTHS_SHOWN;
    for (int c = 0; c < scene->channels.n; c++) {
        /* Of many, an even choice that has the first and the last. */
        if (!alone[c] || seen++ != (wanted > 1 ? shown * (n_alone - 1) / (wanted - 1) : 0))
            continue;
        double share[RMAP_CHANNEL_MAX] = {0.0};
        char colour[8], word[64];
        share[c] = 1.0;
        rmap_ray_ink(scene, share, colour);
        (void)snprintf(word, sizeof word, "%.4g nm", scene->channels.wavelength_nm[c]);
        add_sample(legend, colour, 2.0, word);
        shown++;
    }
    if (several)
        add_mixtures(legend, scene, rays);
}

/* Of a section: of what it cuts. */
static bool is_shown(const struct rmap_scene *scene, const struct rmap_view *view, size_t object,
                     enum rmap_look wanted)
{
    return rmap_object_look(scene, object) == wanted &&
           (!view->section || rmap_view_meets(scene, view, object));
}

/* Lines in a section, faces in a view of solids: as all objects of the look have them, or else as
 * it is without colours. False: none is shown. */
static bool sample_of(const struct rmap_scene *scene, const struct rmap_view *view,
                      enum rmap_look look, const double (*colour)[3], char face[8], bool *alike)
{
    bool any = false;
    *alike = true;
    for (size_t o = 0; o < scene->n_object; o++) {
        double tint[3];
        char its[8];
        if (!is_shown(scene, view, o, look))
            continue;
        rmap_object_tint(look, colour[o], tint);
        (void)snprintf(its, sizeof its, "#%02x%02x%02x", (int)(240 * tint[0]), (int)(240 * tint[1]),
                       (int)(240 * tint[2]));
        if (view->section)
            rmap_object_ink(look, colour[o], its);
        *alike = *alike && (!any || strcmp(its, face) == 0);
        if (!any)
            memcpy(face, its, sizeof its);
        any = true;
    }
    if (!*alike)
        (void)snprintf(face, 8, "%s", view->section ? rmap_look_style[look].ink : "#c4c4c4");
    return any;
}

static void add_surfaces(struct legend *legend, const struct rmap_scene *scene,
                         const struct rmap_view *view, const double (*colour)[3])
{
    for (int k = 0; k < RMAP_LOOK_COUNT; k++) {
        char face[8] = "", word[64];
        bool alike;
        if (!sample_of(scene, view, (enum rmap_look)k, colour, face, &alike))
            continue;
        (void)snprintf(word, sizeof word, "%s%s", rmap_look_style[k].word,
                       alike ? "" : ", each in its colour");
        add_sample(legend, face, view->section ? 1.3 : 8.0, word);
    }
}

/* A sample with a text that may take some lines, as wide as the frame. */
static void add_paragraph(struct legend *legend, const struct rmap_paint_group *group, double right,
                          const char *word)
{
    struct rmap_svg_text text = {
        .x = legend->left + SAMPLE + 6, .size = RMAP_TICK_SIZE, .fill = ink};
    const double room = right - text.x;
    if (legend->svg)
        rmap_svg_line(
            legend->svg, legend->left + 1.0, legend->y - 4.5, legend->left + SAMPLE - 1.0,
            legend->y - 4.5,
            &(struct rmap_svg_style){.stroke = group->ink, .width = 2.4, .dash = group->dash});
    while (*word) {
        const size_t len = rmap_line_nbytes(word, text.size, room);
        char part[512];
        (void)snprintf(part, sizeof part, "%.*s", (int)len, word);
        text.y = legend->y;
        if (legend->svg)
            rmap_svg_string(legend->svg, &text, part);
        legend->y += RMAP_LEGEND_ROW;
        word += len;
        word += *word == ' ';
    }
}

/* Groups of rays that there are or that were asked for, each in rows of its own. */
static void add_groups(struct legend *legend, const struct rmap_ray_paint *paint, double right)
{
    char word[512], n[RMAP_GROUPED_LEN];
    for (size_t k = 0; k < paint->n_group; k++) {
        const struct rmap_paint_group *group = &paint->group[k];
        if (group->rays == 0 && !group->asked)
            continue;
        int len = snprintf(word, sizeof word, "%s", rmap_grouped(group->rays, n));
        const bool some = group->matching > group->rays; /* others too many, or an earlier one's */
        if (some && (group->rays == 0 || paint->dealt))
            len += snprintf(word + len, sizeof word - (size_t)len, " of %s matching",
                            rmap_grouped(group->matching, n));
        len += snprintf(word + len, sizeof word - (size_t)len, " ray%s",
                        group->rays == 1 && !some ? "" : "s");
        if (!paint->dealt)
            len += snprintf(word + len, sizeof word - (size_t)len, ", %.3g %% of flux",
                            paint->flux > 0.0 ? 100.0 * group->flux / paint->flux : 0.0);
        (void)snprintf(word + len, sizeof word - (size_t)len, ": %.400s", group->label);
        add_paragraph(legend, group, right, word);
    }
}

double rmap_legend_draw(const struct rmap_scene *scene, const struct rmap_portion *rays,
                        const struct rmap_view_frame *frame, const struct rmap_ray_paint *paint,
                        const double (*colour)[3], bool mixed, double *marks_ret,
                        struct rmap_svg *svg)
{
    struct legend legend = {.svg = svg,
                            .x = frame->x,
                            .y = frame->y + frame->height + RMAP_LEGEND_ROW,
                            .left = frame->x,
                            .right = frame->x + frame->width - BAR_ROOM};
    bool plane = false;
    for (size_t d = 0; d < scene->n_detector; d++)
        plane = plane || scene->detector[d].type == RMAP_DETECTOR_PLANE;
    const bool grouped = paint && paint->of_ray;
    if (grouped)
        add_groups(&legend, paint, frame->x + frame->width);
    *marks_ret = legend.y - frame->y - frame->height;
    if (!grouped && scene->channels.mode == RMAP_COLOUR_SPECTRAL && !mixed)
        add_wavelengths(&legend, scene, rays);
    else if (!grouped && rays->n_row[RMAP_TABLE_RAY] > 0)
        add_sample(&legend, "#808080", 1.0, "rays, in the colour of their light");
    if (scene->n_source > 0)
        add_sample(&legend, rmap_source_ink, 2.0, "source");
    if (plane)
        add_sample(&legend, rmap_detector_ink, 2.0, "detector");
    add_surfaces(&legend, scene, frame->view, colour);
    return legend.y - frame->y - frame->height;
}

/* From one point to another along an axis, with its length. */
static void draw_bar(const struct rmap_scene *scene, const double from[2], const double to[2],
                     double length, const struct rmap_svg_text *text, struct rmap_svg *svg)
{
    const double x = from[1] == to[1] ? 0.0 : 5.0, y = 5.0 - x; /* half a crossbar */
    const double bar[][2] = {{from[0] - x, from[1] - y},
                             {from[0] + x, from[1] + y},
                             {(double)NAN, 0},
                             {from[0], from[1]},
                             {to[0], to[1]},
                             {(double)NAN, 0},
                             {to[0] - x, to[1] - y},
                             {to[0] + x, to[1] + y}};
    char word[64];
    rmap_svg_path(svg, bar, sizeof bar / sizeof *bar,
                  &(struct rmap_svg_style){.stroke = ink, .width = 1.6});
    (void)snprintf(word, sizeof word, "%g %s", length, scene->unit);
    rmap_svg_string(svg, text, word);
}

void rmap_scale_bar_draw(const struct rmap_scene *scene, const struct rmap_view_frame *frame,
                         double row, struct rmap_svg *svg)
{
    const bool stretched = frame->stretch != 1.0;
    const double length = rmap_round_below((stretched ? 110.0 : 170.0) / frame->scale);
    const double right = frame->x + frame->width, y = frame->y + frame->height + row - 4;
    const double left = right - length * frame->scale;
    struct rmap_svg_text text = {.x = 0.5 * (left + right),
                                 .y = y + 19,
                                 .size = RMAP_TICK_SIZE,
                                 .anchor = RMAP_SVG_MIDDLE,
                                 .fill = ink};
    draw_bar(scene, (const double[2]){left, y}, (const double[2]){right, y}, length, &text, svg);
    if (!stretched)
        return;
    const double scale = frame->scale * frame->stretch, height = rmap_round_below(24.0 / scale);
    text.x = left - 26;
    text.y = y + 10;
    text.anchor = RMAP_SVG_END;
    draw_bar(scene, (const double[2]){left - 18, y - 5},
             (const double[2]){left - 18, y - 5 + height * scale}, height, &text, svg);
}

void rmap_axis_cross_draw(const struct rmap_view_frame *frame, struct rmap_svg *svg)
{
    static const char *const name[] = {"x", "y", "z"};
    const double length = 32.0, x = frame->x + 46, y = frame->y + frame->height - 34;
    for (int k = 0; k < 3; k++) {
        struct rmap_vec3 axis = rmap_vec3(k == 0, k == 1, k == 2);
        double dx = rmap_dot(axis, frame->view->right), dy = -rmap_dot(axis, frame->view->up);
        double shown = hypot(dx, dy);
        if (shown < 0.1)
            continue;
        double ex = dx / shown, ey = dy / shown, tip[2] = {x + length * dx, y + length * dy};
        const double arrow[][2] = {
            {x, y},           {tip[0], tip[1]},
            {(double)NAN, 0}, {tip[0] - 6 * ex + 3 * ey, tip[1] - 6 * ey - 3 * ex},
            {tip[0], tip[1]}, {tip[0] - 6 * ex - 3 * ey, tip[1] - 6 * ey + 3 * ex}};
        rmap_svg_path(svg, arrow, 6, &(struct rmap_svg_style){.stroke = ink, .width = 1.2});
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = tip[0] + 9 * ex,
                                                .y = tip[1] + 9 * ey + 4.5,
                                                .size = RMAP_TICK_SIZE,
                                                .anchor = RMAP_SVG_MIDDLE,
                                                .fill = ink,
                                                .halo = "#ffffff"},
                        name[k]);
    }
}

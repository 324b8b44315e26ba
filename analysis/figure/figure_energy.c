/* SPDX-License-Identifier: MIT
 *
 * The picture of an energy balance: light from its sources over groups of the scene to what
 * absorbed it, and beside it what detectors registered.
 */
#include "analysis/figure/figure_energy.h"

#include <math.h>
#include <stdio.h>

#include "analysis/energy/energy_flow.h"
#include "analysis/table/figure_axes.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "portion/weight.h"

enum { MARGIN = 16, TOP = 92, WIDTH = 1040, FLOW_HEIGHT = 380, LOWEST = 60 };
enum { BAR_ROW = 22, BAR_NAME = 190, BAR_LENGTH = 340, DETECTOR_MAX = 12 };

static void draw_captions(const struct rmap_energy *energy, struct rmap_svg *svg)
{
    const struct rmap_energy_table *table = &energy->table[0];
    char title[1024], asked[1024], line[1024], rays[RMAP_GROUPED_LEN];
    (void)snprintf(title, sizeof title, "%s: where the light went", energy->map);
    rmap_which_caption(energy->which, energy->criterion, asked, sizeof asked);
    int at = snprintf(line, sizeof line, "%s", rmap_grouped(rmap_weight_whole(table->rays), rays));
    if (at > 0 && energy->criterion)
        (void)snprintf(line + at, sizeof line - (size_t)at, " of %s rays match, %.6g of %.6g %s",
                       rmap_grouped(rmap_weight_whole(energy->map_rays), rays), table->flux,
                       energy->map_flux, energy->unit);
    else if (at > 0)
        (void)snprintf(line + at, sizeof line - (size_t)at, " ray%s emitted, %.6g %s%s",
                       table->rays > 1.0 ? "s" : "", table->flux, energy->unit,
                       table->exact ? "; what they ended in adds up to that, exactly" : "");
    const char *const row[] = {title, asked,
                               table->rays > 0.0 ? line : "no ray matches: nothing to share out"};
    rmap_captions(svg, MARGIN, row, 3);
}

/* Room for the labels of the first and the last column, and where the columns stand. */
static void place_columns(struct rmap_sankey *sankey)
{
    double widest[2] = {60.0, 60.0};
    for (size_t i = 0; i < sankey->n_node; i++) {
        const struct rmap_sankey_node *node = &sankey->node[i];
        int side = node->column == 0 ? 0 : 1;
        if (node->column == 0 || node->column == sankey->n_column - 1)
            widest[side] =
                fmax(widest[side], rmap_svg_string_width(node->label, RMAP_TICK_SIZE) + 4);
    }
    double left = MARGIN + widest[0] + 6;
    double right = WIDTH - MARGIN - widest[1] - 6 - RMAP_SANKEY_BOX;
    sankey->label_width[0] = widest[0];
    sankey->label_width[1] = widest[1];
    for (int c = 0; c < sankey->n_column; c++)
        sankey->x[c] = left + (right - left) * c / (sankey->n_column - 1);
}

/* Bars, beside the balance: a ray may be registered on its way, by several detectors. All of its
 * light is the pale bar behind each. */
static double draw_detectors(const struct rmap_energy *energy, double y, struct rmap_svg *svg)
{
    const struct rmap_energy_table *table = &energy->table[0];
    const size_t n = table->n_detector < DETECTOR_MAX ? table->n_detector : DETECTOR_MAX;
    double most = table->flux;
    if (n == 0)
        return y;
    for (size_t d = 0; d < table->n_detector; d++)
        most = fmax(most, table->row[table->n_row + d].flux);
    struct rmap_svg_text text = {.x = MARGIN, .y = y + 36, .size = RMAP_LABEL_SIZE, .bold = 1};
    char line[256];
    (void)snprintf(line, sizeof line,
                   "registered on the way, beside the balance, of all its light%s",
                   n < table->n_detector ? " (the first detectors)" : "");
    rmap_svg_string(svg, &text, line);
    y += 46;
    for (size_t d = 0; d < n; d++, y += BAR_ROW) {
        const struct rmap_energy_row *row = &table->row[table->n_row + d];
        const double length = most > 0.0 ? BAR_LENGTH * row->flux / most : 0.0;
        const double whole = most > 0.0 ? BAR_LENGTH * table->flux / most : 0.0;
        text = (struct rmap_svg_text){.x = MARGIN + BAR_NAME,
                                      .y = y + 0.68 * BAR_ROW,
                                      .size = RMAP_TICK_SIZE,
                                      .anchor = RMAP_SVG_END};
        rmap_caption(svg, &text, BAR_NAME, row->name);
        rmap_svg_rect(svg, MARGIN + BAR_NAME + 8, y + 4, whole, BAR_ROW - 8,
                      &(struct rmap_svg_style){.fill = "#dfeaec"});
        rmap_svg_rect(svg, MARGIN + BAR_NAME + 8, y + 4, fmax(length, 0.7), BAR_ROW - 8,
                      &(struct rmap_svg_style){.fill = "#2b8c9e"});
        int at = snprintf(line, sizeof line, "%.4g", row->flux);
        if (isfinite(row->flux_error) && at > 0)
            at += snprintf(line + at, sizeof line - (size_t)at, " ± %.2g", row->flux_error);
        if (at > 0)
            at += snprintf(line + at, sizeof line - (size_t)at, " %s", energy->unit);
        if (isfinite(row->share) && at > 0)
            (void)snprintf(line + at, sizeof line - (size_t)at, ", %.3g %%", 100.0 * row->share);
        text.anchor = RMAP_SVG_START;
        text.x = MARGIN + BAR_NAME + 16 + fmax(length, whole);
        rmap_svg_string(svg, &text, line);
    }
    return y + 6;
}

enum rmap_status rmap_figure_energy(const struct rmap_energy *energy, struct rmap_svg **svg_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_svg *svg = NULL;
    const struct rmap_energy_table *table = &energy->table[0];
    struct rmap_sankey *sankey = rmap_alloc(1, sizeof *sankey);
    double height = LOWEST;
    if (!sankey)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a picture");
    const bool any = table->flux > 0.0;
    if (any) {
        RMAP_TRY(rmap_energy_flow(energy, sankey, err));
        sankey->y = TOP;
        sankey->pixels_per_unit = FLOW_HEIGHT / table->flux;
        place_columns(sankey);
        height = rmap_sankey_lay_out(sankey);
    }
    size_t n = table->n_detector < DETECTOR_MAX ? table->n_detector : DETECTOR_MAX;
    double below = n > 0 ? 56.0 + (double)n * BAR_ROW : 0.0;
    char title[RMAP_ERROR_TEXT_LEN];
    (void)snprintf(title, sizeof title, "energy of %s", energy->map);
    RMAP_TRY(rmap_svg_create(WIDTH, TOP + height + below + MARGIN, title, &svg, err));
    draw_captions(energy, svg);
    if (any)
        rmap_sankey_draw(sankey, svg);
    (void)draw_detectors(energy, TOP + height, svg);
    *svg_ret = svg;
    svg = NULL;
out:
    rmap_svg_destroy(svg);
    rmap_free(sankey);
    return st;
}

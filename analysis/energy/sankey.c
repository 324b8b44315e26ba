/* SPDX-License-Identifier: MIT
 *
 * A flow picture (H. R. Sankey, 1898): boxes in columns from left to right, joined by bands as
 * thick as what flows.
 */
#include "analysis/energy/sankey.h"

#include <math.h>

#include "analysis/table/figure_axes.h"

enum { STEPS = 24 /* of a band's edge */ };

/* Boxes keep so far apart, and take at least so much room, that labels do not touch. */
static const double GAP = 5.0, SLOT = 17.0, THINNEST = 0.7, OPACITY = 0.45;

bool rmap_sankey_link_add(struct rmap_sankey *self, const struct rmap_sankey_link *link)
{
    if (!(link->value > 0.0))
        return true;
    if (self->n_link == RMAP_SANKEY_LINKS)
        return false;
    self->link[self->n_link++] = *link;
    return true;
}

static double slot_of(const struct rmap_sankey_node *node)
{
    return node->passing ? node->height : fmax(node->height, SLOT);
}

double rmap_sankey_lay_out(struct rmap_sankey *self)
{
    double height[RMAP_SANKEY_COLUMNS] = {0.0}, tallest = 0.0;
    for (size_t i = 0; i < self->n_node; i++) {
        struct rmap_sankey_node *node = &self->node[i];
        node->height = node->value * self->pixels_per_unit;
        height[node->column] += slot_of(node) + GAP;
        tallest = fmax(tallest, height[node->column]);
    }
    double at[RMAP_SANKEY_COLUMNS];
    for (int c = 0; c < RMAP_SANKEY_COLUMNS; c++)
        at[c] = self->y + 0.5 * (tallest - height[c]);
    for (size_t i = 0; i < self->n_node; i++) {
        struct rmap_sankey_node *node = &self->node[i];
        node->y = at[node->column] + 0.5 * (slot_of(node) - node->height);
        at[node->column] += slot_of(node) + GAP;
    }
    return tallest;
}

/* One edge of a band, a cubic Bezier curve that leaves and arrives level. */
static void bend(double (*point)[2], const double from[2], const double to[2])
{
    for (int i = 0; i <= STEPS; i++) {
        double t = (double)i / STEPS, middle = 1.5 * t * (1.0 - t), ahead = t * t * (3.0 - 2.0 * t);
        point[i][0] = from[0] + (to[0] - from[0]) * (middle + t * t * t);
        point[i][1] = from[1] + (to[1] - from[1]) * ahead;
    }
}

static void draw_band(const struct rmap_sankey *self, const struct rmap_sankey_link *link,
                      const double y[2], struct rmap_svg *svg)
{
    const struct rmap_sankey_node *from = &self->node[link->from], *to = &self->node[link->to];
    double point[2 * (STEPS + 1)][2], thick = fmax(link->value * self->pixels_per_unit, THINNEST);
    double left = self->x[from->column] + RMAP_SANKEY_BOX, right = self->x[to->column];
    if (to->passing) /* on to where the next band begins */
        right += RMAP_SANKEY_BOX;
    bend(point, (const double[2]){left, y[0]}, (const double[2]){right, y[1]});
    bend(point + STEPS + 1, (const double[2]){right, y[1] + thick},
         (const double[2]){left, y[0] + thick});
    rmap_svg_path(svg, (const double(*)[2])point, 2 * (STEPS + 1),
                  &(struct rmap_svg_style){.fill = link->colour, .opacity = OPACITY});
}

static void draw_node(const struct rmap_sankey *self, const struct rmap_sankey_node *node,
                      struct rmap_svg *svg)
{
    const double x = self->x[node->column];
    const bool first = node->column == 0, last = node->column == self->n_column - 1;
    struct rmap_svg_text text = {.x = x + RMAP_SANKEY_BOX + 6,
                                 .y = node->y + 0.5 * node->height + 0.36 * RMAP_TICK_SIZE,
                                 .size = RMAP_TICK_SIZE,
                                 .halo = last || first ? NULL : "#ffffff"};
    double room = last ? self->label_width[1] : self->x[node->column + 1] - x;
    if (first) {
        text.x = x - 6;
        text.anchor = RMAP_SVG_END;
        room = self->label_width[0];
    }
    rmap_svg_rect(svg, x, node->y, RMAP_SANKEY_BOX, fmax(node->height, THINNEST),
                  &(struct rmap_svg_style){.fill = node->colour});
    rmap_caption(svg, &text, room, node->label);
}

void rmap_sankey_draw(const struct rmap_sankey *self, struct rmap_svg *svg)
{
    double out[RMAP_SANKEY_NODES], in[RMAP_SANKEY_NODES];
    for (size_t i = 0; i < self->n_node; i++)
        out[i] = in[i] = self->node[i].y;
    for (size_t i = 0; i < self->n_link; i++) {
        const struct rmap_sankey_link *link = &self->link[i];
        draw_band(self, link, (const double[2]){out[link->from], in[link->to]}, svg);
        out[link->from] += link->value * self->pixels_per_unit;
        in[link->to] += link->value * self->pixels_per_unit;
    }
    for (size_t i = 0; i < self->n_node; i++)
        if (!self->node[i].passing)
            draw_node(self, &self->node[i], svg);
}

/* SPDX-License-Identifier: MIT
 *
 * A flow picture (H. R. Sankey, 1898): boxes in columns from left to right, joined by bands as
 * thick as what flows. What enters a box of a middle column leaves it again.
 */
#ifndef RMAP_SANKEY_H
#define RMAP_SANKEY_H

#include <stdbool.h>

#include "io/export/svg.h"

#define RMAP_SANKEY_NODES   96
#define RMAP_SANKEY_LINKS   1024
#define RMAP_SANKEY_COLUMNS 3
#define RMAP_SANKEY_BOX     14.0 /* width of a box, in pixels */

struct rmap_sankey_node {
    char label[160]; /* UTF-8 */
    const char *colour;
    int column;
    bool passing; /* a band goes through: no box, no label */
    double value;
    double y, height; /* set by rmap_sankey_lay_out, in pixels */
};

struct rmap_sankey_link {
    size_t from, to; /* nodes; from lies left of to */
    double value;
    const char *colour;
};

/* Nodes of a column stand in their order, from above; links of a node leave and enter in theirs. */
struct rmap_sankey {
    int n_column;
    double x[RMAP_SANKEY_COLUMNS]; /* left edges of the columns' boxes */
    double label_width[2];         /* room left of the first and right of the last column */
    double y;                      /* upper edge */
    double pixels_per_unit;        /* height of a band of value 1 */
    size_t n_node, n_link;
    struct rmap_sankey_node node[RMAP_SANKEY_NODES];
    struct rmap_sankey_link link[RMAP_SANKEY_LINKS];
};

/* False when there is no room for one more; value 0 adds nothing. */
bool rmap_sankey_link_add(struct rmap_sankey *sankey, const struct rmap_sankey_link *link);

/* Places the nodes; the height of the whole. */
double rmap_sankey_lay_out(struct rmap_sankey *sankey);

void rmap_sankey_draw(const struct rmap_sankey *sankey, struct rmap_svg *svg);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Names beside the things they name, kept apart from each other.
 */
#ifndef RMAP_FIGURE_LABELS_H
#define RMAP_FIGURE_LABELS_H

#include "analysis/figure/figure_view.h"

#define RMAP_LABELS_MAX 64

struct rmap_labels {
    double area[4]; /* x, y, width, height that labels stay within */
    size_t n;
    double box[RMAP_LABELS_MAX][4]; /* x, y, width, height of those placed */
};

/* Keeps labels off a rectangle between two corners. */
void rmap_label_reserve(struct rmap_labels *labels, const double a[2], const double b[2]);

/* Writes `string` near the point where it covers no other label; not at all when there is no
 * such place, or no room for more labels. */
void rmap_label_place(struct rmap_labels *labels, struct rmap_svg *svg, const double pixel[2],
                      const char *ink, const char *string);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Names beside the things they name, kept apart from each other.
 */
#include "analysis/figure/figure_labels.h"

#include <math.h>
#include <string.h>

#include "analysis/table/figure_axes.h"

static bool overlap(const double a[4], const double b[4])
{
    return a[0] < b[0] + b[2] && b[0] < a[0] + a[2] && a[1] < b[1] + b[3] && b[1] < a[1] + a[3];
}

static bool is_free(const struct rmap_labels *labels, const double box[4])
{
    const double *area = labels->area;
    if (box[0] < area[0] || box[1] < area[1] || box[0] + box[2] > area[0] + area[2] ||
        box[1] + box[3] > area[1] + area[3])
        return false;
    for (size_t i = 0; i < labels->n; i++)
        if (overlap(box, labels->box[i]))
            return false;
    return true;
}

void rmap_label_reserve(struct rmap_labels *labels, const double a[2], const double b[2])
{
    if (labels->n == RMAP_LABELS_MAX)
        return;
    double *box = labels->box[labels->n++];
    for (int k = 0; k < 2; k++) {
        box[k] = fmin(a[k], b[k]) - 2.0;
        box[k + 2] = fabs(a[k] - b[k]) + 4.0;
    }
}

/* From the point to the nearest place of the label's box. */
static void draw_leader(struct rmap_svg *svg, const double pixel[2], const double box[4],
                        const char *ink)
{
    const double x = fmin(fmax(pixel[0], box[0]), box[0] + box[2]);
    const double y = fmin(fmax(pixel[1], box[1]), box[1] + box[3]);
    rmap_svg_line(svg, pixel[0], pixel[1], x, y,
                  &(struct rmap_svg_style){.stroke = ink, .width = 0.6});
}

enum { BESIDE = 6 }; /* of the places for a label: those at the point */

void rmap_label_place(struct rmap_labels *labels, struct rmap_svg *svg, const double pixel[2],
                      const char *ink, const char *string)
{
    double width = rmap_svg_string_width(string, RMAP_TICK_SIZE) + 4, height = RMAP_TICK_SIZE + 4;
    /* Where the label's box begins, relative to the point: beside, above, below, further out. */
    const double offset[][2] = {{6, -height - 2},
                                {-width - 6, -height - 2},
                                {6, 4},
                                {-width - 6, 4},
                                {-0.5 * width, -height - 8},
                                {-0.5 * width, 10},
                                {10, -2.4 * height},
                                {-width - 10, -2.4 * height},
                                {10, 1.6 * height},
                                {-width - 10, 1.6 * height},
                                {-0.5 * width, -4 * height},
                                {-0.5 * width, 3 * height}};
    for (size_t i = 0; i < sizeof offset / sizeof *offset && labels->n < RMAP_LABELS_MAX; i++) {
        double box[4] = {pixel[0] + offset[i][0], pixel[1] + offset[i][1], width, height};
        if (!is_free(labels, box))
            continue;
        memcpy(labels->box[labels->n++], box, sizeof box);
        if (i >= BESIDE) /* further out: whose it is */
            draw_leader(svg, pixel, box, ink);
        rmap_svg_string(svg,
                        &(struct rmap_svg_text){.x = box[0] + 2,
                                                .y = box[1] + RMAP_TICK_SIZE,
                                                .size = RMAP_TICK_SIZE,
                                                .fill = ink,
                                                .halo = "#ffffff"},
                        string);
        return;
    }
}

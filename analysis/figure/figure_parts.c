/* SPDX-License-Identifier: MIT
 *
 * Names of a scene's parts in its picture.
 */
#include "analysis/figure/figure_parts.h"

#include <stdlib.h>

#include "base/alloc.h"

/* Parts that are named, and their least size in pixels. */
enum { MOST = 12, SMALLEST = 14 };

struct part {
    const char *name;
    size_t place;             /* in the scene file */
    struct rmap_view_box box; /* of its largest object */
};

static double extent(const struct rmap_view_box *box)
{
    return fmax(box->high[0] - box->low[0], box->high[1] - box->low[1]);
}

static double size_of(const struct part *part)
{
    return part->name ? extent(&part->box) : 0.0;
}

static int largest_first(const void *a, const void *b)
{
    const struct part *left = a, *right = b;
    const double u = size_of(left), v = size_of(right);
    return u != v ? (u < v) - (u > v) : (left->place > right->place) - (left->place < right->place);
}

/* The entry that an object belongs to, or itself, where it is the largest of that. part: [n_group +
 * n_object]. */
static void offer(const struct rmap_scene *scene, const struct rmap_view *view, size_t object,
                  struct part *part)
{
    struct rmap_view_box box = RMAP_VIEW_BOX_EMPTY;
    int32_t group = scene->object[object].parent;
    while (group >= 0 && scene->group[group].parent >= 0)
        group = scene->group[group].parent;
    struct part *of = &part[group >= 0 ? (size_t)group : scene->n_group + object];
    rmap_view_cover_object(scene, view, object, &box);
    if (extent(&box) > size_of(of))
        *of = (struct part){.name =
                                group >= 0 ? scene->group[group].name : scene->object[object].name,
                            .place = (size_t)(of - part),
                            .box = box};
}

/* Above it. */
static void name_part(const struct rmap_view_frame *frame, const struct part *part,
                      struct rmap_labels *labels, struct rmap_svg *svg)
{
    const double at[2] = {0.5 * (part->box.low[0] + part->box.high[0]), part->box.high[1]};
    double pixel[2];
    rmap_view_pixel(frame, at, pixel);
    rmap_label_place(labels, svg, pixel, "#555555", part->name);
}

enum rmap_status rmap_parts_name(const struct rmap_scene *scene,
                                 const struct rmap_view_frame *frame, struct rmap_labels *labels,
                                 struct rmap_svg *svg, struct rmap_error *err)
{
    const size_t n = scene->n_group + scene->n_object;
    if (!frame->view->section)
        return RMAP_OK;
    struct part *part = rmap_alloc(n + 1, sizeof *part);
    if (!part)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of %zu parts", n);
    for (size_t o = 0; o < scene->n_object; o++)
        if (rmap_view_meets(scene, frame->view, o))
            offer(scene, frame->view, o, part);
    qsort(part, n, sizeof *part, largest_first);
    for (size_t k = 0; k < n && k < MOST && frame->scale * size_of(&part[k]) > SMALLEST; k++)
        name_part(frame, &part[k], labels, svg);
    rmap_free(part);
    return RMAP_OK;
}

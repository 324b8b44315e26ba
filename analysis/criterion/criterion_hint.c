/* SPDX-License-Identifier: MIT
 *
 * Why no ray matches a criterion, where a test that must hold cannot, or reads like another.
 */
#include "analysis/criterion/criterion_hint.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_tree.h"

enum { SHOWN = 160 };

struct hinting {
    const struct rmap_criterion *criterion;
    const struct rmap_map *map;
    char *hint;
};

static const struct rmap_criterion_node *node_of(const struct hinting *self, int32_t index)
{
    return &self->criterion->node[index];
}

static int shown_nbytes(const struct rmap_criterion_node *node)
{
    const size_t nbytes = node->end - node->begin;
    return (int)(nbytes < SHOWN ? nbytes : SHOWN);
}

/* Least and greatest coordinate that a region has along an axis. */
static void region_extent(const struct rmap_registration_test *test, int axis, double extent[2])
{
    const double *b = test->bound;
    extent[0] = INFINITY;
    extent[1] = -INFINITY;
    for (size_t i = 0; i < test->n_corner; i++) {
        extent[0] = fmin(extent[0], test->corner[i][axis]);
        extent[1] = fmax(extent[1], test->corner[i][axis]);
    }
    if (test->region == RMAP_REGION_RECT) {
        extent[0] = fmin(b[axis], b[axis + 2]);
        extent[1] = fmax(b[axis], b[axis + 2]);
    } else if (test->region == RMAP_REGION_ELLIPSE) {
        const double own = b[axis + 2] * test->cosine, other = b[3 - axis] * test->sine;
        extent[0] = b[axis] - hypot(own, other);
        extent[1] = b[axis] + hypot(own, other);
    }
}

static bool is_outside(const struct rmap_registration_test *test,
                       const struct rmap_detector *detector, size_t index)
{
    bool outside = false;
    for (int axis = 0; axis < 2; axis++) {
        double extent[2];
        if (test->region == RMAP_REGION_CELLS) {
            outside |= test->box[index].low[axis] >= detector->cells[axis];
            continue;
        }
        region_extent(test, axis, extent);
        outside |= extent[1] < rmap_detector_coordinate(detector, 0, axis, test->relative) ||
                   extent[0] > rmap_detector_coordinate(detector, UINT16_MAX, axis, test->relative);
    }
    return outside;
}

/* A region outside of all detectors that are asked. */
static void hint_region(const struct hinting *self, const struct rmap_criterion_node *node)
{
    const struct rmap_registration_test *test = &node->registrations;
    const struct rmap_scene *scene = self->criterion->scene;
    const struct rmap_detector *detector = NULL;
    for (size_t d = 0; test->region != RMAP_REGION_ALL && d < scene->n_detector; d++) {
        if (!rmap_index_set_has(&test->detector, (int32_t)d))
            continue;
        if (!is_outside(test, &scene->detector[d], d))
            return;
        detector = &scene->detector[d];
    }
    if (!detector)
        return;
    if (test->region == RMAP_REGION_CELLS)
        (void)snprintf(self->hint, RMAP_CRITERION_HINT_NBYTES,
                       "the cells of %.*s lie outside: '%.64s' has cells 0..%u, 0..%u",
                       shown_nbytes(node), self->criterion->text + node->begin, detector->name,
                       detector->cells[0] - 1, detector->cells[1] - 1);
    else
        (void)snprintf(
            self->hint, RMAP_CRITERION_HINT_NBYTES,
            "the region of %.*s lies outside: '%.64s' reaches from %.6g to %.6g and from "
            "%.6g to %.6g",
            shown_nbytes(node), self->criterion->text + node->begin, detector->name,
            rmap_detector_coordinate(detector, 0, 0, test->relative),
            rmap_detector_coordinate(detector, UINT16_MAX, 0, test->relative),
            rmap_detector_coordinate(detector, 0, 1, test->relative),
            rmap_detector_coordinate(detector, UINT16_MAX, 1, test->relative));
}

/* A path that leaves nothing open in front or behind; below `where` a registration is its end.
 * Names of definitions stand for others. */
static void hint_path(const struct hinting *self, const struct rmap_criterion_node *node,
                      bool is_where)
{
    const char *begin = self->criterion->text + node->begin;
    const char *end = self->criterion->text + node->end;
    const char *first = memchr(begin, '"', (size_t)(end - begin)), *last = end;
    if (!first)
        return;
    first += 1 + strspn(first + 1, " \t\r\n");
    while (last > first && *last != '"')
        last--;
    while (last > first && strchr(" \t\r\n", last[-1]))
        last--;
    const bool opens = last - first >= 2 && memcmp(first, ".*", 2) == 0;
    const bool closes = is_where || (last - first >= 2 && memcmp(last - 2, ".*", 2) == 0);
    if ((opens && closes) || last - first > SHOWN)
        return;
    (void)snprintf(self->hint, RMAP_CRITERION_HINT_NBYTES,
                   "path(\"%.*s\") says the whole history, from the ray's first step to its %s; "
                   "wherever in it: path(\"%s%.*s%s\")",
                   (int)(last - first), first, is_where ? "registration" : "last",
                   opens ? "" : ".* ", (int)(last - first), first, closes ? "" : " .*");
}

/* Above what any registration has, in seconds: as many segments as a ray of the portion may have,
 * each through the box of all its points and at most of this index. */
static double latest_s(const struct hinting *self)
{
    const double light_speed_m_per_s = 299792458.0, greatest_index = 10.0;
    double latest = 0.0;
    for (size_t i = 0; i < rmap_map_n_portion(self->map); i++) {
        const struct rmap_portion_info *info = rmap_map_portion(self->map, i);
        const struct rmap_portion_summary *summary = &info->summary;
        double square = 0.0;
        for (int axis = 0; axis < 3; axis++) {
            const double side = (double)summary->box_max[axis] - (double)summary->box_min[axis];
            square += side * side;
        }
        const double n_segment =
            (double)(info->n_row[RMAP_TABLE_SEGMENT] - info->n_row[RMAP_TABLE_RAY]) + 1.0;
        latest = fmax(latest, n_segment * sqrt(square));
    }
    return latest * greatest_index * self->criterion->scene->unit_m / light_speed_m_per_s;
}

static void hint_time(const struct hinting *self, const struct rmap_criterion_node *node)
{
    if ((node->its_number != RMAP_REGISTRATION_TIME &&
         node->its_number != RMAP_REGISTRATION_ARRIVAL) ||
        node->interval.outside)
        return;
    const double latest = latest_s(self);
    if (node->its_number == RMAP_REGISTRATION_TIME && latest > 0.0 && node->interval.low > latest)
        (void)snprintf(self->hint, RMAP_CRITERION_HINT_NBYTES,
                       "no light of this map takes as long as %.6g s; a time without a unit is in "
                       "seconds (ns, ps are understood)",
                       node->interval.low);
    else if (node->interval.high < 0.0)
        (void)snprintf(self->hint, RMAP_CRITERION_HINT_NBYTES,
                       "no light registers before its emission, at %.6g s", node->interval.high);
}

/* Tests that the answer cannot do without, and those of OR, of which each would do. */
static void look(const struct hinting *self, int32_t index, bool is_where)
{
    const struct rmap_criterion_node *node = node_of(self, index);
    if (self->hint[0])
        return;
    switch (node->kind) {
    case RMAP_CRITERION_AND:
    case RMAP_CRITERION_OR:
        for (int32_t child = node->first; child >= 0; child = node_of(self, child)->next)
            look(self, child, is_where);
        break;
    case RMAP_CRITERION_REGISTRATIONS:
        if (rmap_interval_holds(&node->interval, 0.0))
            break; /* none is what it asks for */
        hint_region(self, node);
        if (node->registrations.where >= 0)
            look(self, node->registrations.where, true);
        break;
    case RMAP_CRITERION_PATH:
        if (!rmap_interval_holds(&node->interval, 0.0))
            hint_path(self, node, is_where);
        break;
    case RMAP_CRITERION_ITS_NUMBER:
        hint_time(self, node);
        break;
    default:
        break;
    }
}

void rmap_criterion_hint(const struct rmap_criterion *criterion, const struct rmap_map *map,
                         char hint[RMAP_CRITERION_HINT_NBYTES])
{
    const struct hinting self = {criterion, map, hint};
    hint[0] = 0;
    look(&self, criterion->root, false);
}

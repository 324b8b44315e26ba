/* SPDX-License-Identifier: MIT
 *
 * Which of the parts that have one value are the same: by what a pair has in common, the nearest
 * first.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/assembly/assembly_match.h"
#include "io/assembly/matching.h"

/* ---- what a pair has in common ---- */

static bool same_name(const struct rmap_matching *m, int32_t from, int32_t to)
{
    if (m->side[0].id[from] == 0 && m->side[1].id[to] == 0)
        return true; /* a count is no name */
    return strcmp(rmap_match_part(m, 0, (size_t)from)->name,
                  rmap_match_part(m, 1, (size_t)to)->name) == 0;
}

static bool same_content(const struct rmap_matching *m, int32_t from, int32_t to)
{
    return m->side[0].content[from] == m->side[1].content[to];
}

static bool same_place(const struct rmap_matching *m, int32_t from, int32_t to, bool world)
{
    return !rmap_assembly_is_apart(rmap_match_place(m, 0, (size_t)from, world),
                                   rmap_match_place(m, 1, (size_t)to, world));
}

/* The middle of its shape's box, since many parts are turned about one origin. */
static struct rmap_vec3 middle_of(const struct rmap_matching *m, int side, int32_t i, bool world)
{
    const struct rmap_assembly *a = m->side[side].assembly;
    struct rmap_vec3 middle = rmap_vec3(0, 0, 0);
    if (a->part[i].shape >= 0) {
        const struct rmap_assembly_shape *shape = &a->shape[a->part[i].shape];
        middle = rmap_vec3(0.5 * (shape->lower[0] + shape->upper[0]),
                           0.5 * (shape->lower[1] + shape->upper[1]),
                           0.5 * (shape->lower[2] + shape->upper[2]));
    }
    return rmap_affine_point(rmap_match_place(m, side, (size_t)i, world), middle);
}

/* ---- the nearest ---- */

void rmap_match_in_order(struct rmap_matching *m, const struct rmap_match_run *run)
{
    for (size_t k = 0; run->first[0] + k < run->end[0] && run->first[1] + k < run->end[1]; k++)
        rmap_match_join(m, m->side[0].key[run->first[0] + k].part,
                        m->side[1].key[run->first[1] + k].part);
}

enum { NAME = 1, CONTENT = 2, PLACE = 4 };

static bool agree(const struct rmap_matching *m, int32_t from, int32_t to, unsigned wanted,
                  bool world)
{
    return (!(wanted & CONTENT) || same_content(m, from, to)) &&
           (!(wanted & NAME) || same_name(m, from, to)) &&
           (!(wanted & PLACE) || same_place(m, from, to, world));
}

static int by_along(const void *a, const void *b)
{
    const struct rmap_match_stand *x = a, *y = b;
    if (x->along < y->along || x->along > y->along)
        return x->along < y->along ? -1 : 1;
    return (x->part > y->part) - (x->part < y->part);
}

/* Of a stranger's numbers any may be infinite. */
static double component(struct rmap_vec3 v, int axis)
{
    const double its = axis == 0 ? v.x : axis == 1 ? v.y : v.z;
    return isfinite(its) ? its : 0;
}

/* Those of the old side that are left, in a row; its axis. */
static size_t line_up(struct rmap_matching *m, const struct rmap_match_run *run, bool world,
                      int *axis_ret)
{
    struct rmap_vec3 lower = {0, 0, 0}, upper = {0, 0, 0};
    size_t n = 0;
    for (size_t k = run->first[0]; k < run->end[0]; k++) {
        const int32_t part = m->side[0].key[k].part;
        if (m->side[0].known[part] >= 0)
            continue;
        const struct rmap_vec3 at = middle_of(m, 0, part, world);
        lower = n ? rmap_least(lower, at) : at;
        upper = n ? rmap_greatest(upper, at) : at;
        m->stand[n++] = (struct rmap_match_stand){0, at, part};
    }
    const struct rmap_vec3 size = rmap_sub(upper, lower);
    *axis_ret = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    for (size_t i = 0; i < n; i++)
        m->stand[i].along = component(m->stand[i].at, *axis_ret);
    if (n > 0)
        qsort(m->stand, n, sizeof *m->stand, by_along);
    return n;
}

/* The nearest of n that agrees, from the place in the row outwards; -1: there is none. */
static int32_t nearest_of(const struct rmap_matching *m, size_t n, int axis, int32_t to,
                          unsigned wanted, bool world, double *away_ret)
{
    enum { LOOKS = 8192 };     /* a stranger's file may have any number at one place */
    const double close = 1e-3; /* more than places of one part differ by */
    const struct rmap_vec3 at = middle_of(m, 1, to, world);
    const double along = component(at, axis);
    double least = wanted & PLACE ? close : HUGE_VAL;
    int32_t nearest = -1;
    size_t low = 0, high = n, looks = 0;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (m->stand[middle].along < along)
            low = middle + 1;
        else
            high = middle;
    }
    for (size_t up = low, down = low; (up < n || down > 0) && looks++ < LOOKS;) {
        const double above = up < n ? m->stand[up].along - along : HUGE_VAL,
                     below = down > 0 ? along - m->stand[down - 1].along : HUGE_VAL;
        const bool go_up = down == 0 || (up < n && above <= below);
        const struct rmap_match_stand *stand = go_up ? &m->stand[up++] : &m->stand[--down];
        if (fmin(above, below) > least)
            break;
        const double away = rmap_length(rmap_sub(stand->at, at));
        if (m->side[0].known[stand->part] < 0 && away < least &&
            agree(m, stand->part, to, wanted, world)) {
            least = away;
            nearest = stand->part;
        }
    }
    *away_ret = least;
    return nearest;
}

/* Each takes the nearest that is left and has all that is wanted: those first that have not far, so
 * that one that is new takes nobody's. */
static void join_nearest(struct rmap_matching *m, const struct rmap_match_run *run, unsigned wanted,
                         bool world)
{
    int axis;
    double away;
    const size_t n = line_up(m, run, world, &axis);
    size_t n_seeker = 0;
    for (size_t k = run->first[1]; n > 0 && k < run->end[1]; k++) {
        const int32_t to = m->side[1].key[k].part;
        if (m->side[1].known[to] < 0 && nearest_of(m, n, axis, to, wanted, world, &away) >= 0)
            m->seeker[n_seeker++] = (struct rmap_match_stand){.along = away, .part = to};
    }
    if (n_seeker > 0)
        qsort(m->seeker, n_seeker, sizeof *m->seeker, by_along);
    for (size_t k = 0; k < n_seeker; k++) {
        const int32_t to = m->seeker[k].part,
                      from = nearest_of(m, n, axis, to, wanted, world, &away);
        if (from >= 0)
            rmap_match_join(m, from, to);
    }
}

/* The one of a run that is left; -1: none, or several. */
static int32_t left_of(const struct rmap_matching *m, const struct rmap_match_run *run, int side)
{
    int32_t left = -1;
    for (size_t k = run->first[side]; k < run->end[side]; k++) {
        const int32_t i = m->side[side].key[k].part;
        if (m->side[side].known[i] >= 0)
            continue;
        if (left >= 0)
            return -1;
        left = i;
    }
    return left;
}

/* Of one id, or one name: those that stand where they stood first, so that what is new takes
 * nobody's place. */
void rmap_match_siblings(struct rmap_matching *m, const struct rmap_match_run *run)
{
    static const unsigned standing[] = {NAME | CONTENT | PLACE, CONTENT | PLACE, NAME | PLACE},
                          elsewhere[] = {NAME | CONTENT, CONTENT, NAME};
    if (run->end[0] - run->first[0] > 1 || run->end[1] - run->first[1] > 1)
        for (size_t k = 0; k < sizeof standing / sizeof *standing; k++)
            join_nearest(m, run, standing[k], false);
    const int32_t from = left_of(m, run, 0), to = left_of(m, run, 1);
    if (from >= 0 && to >= 0) {
        if (same_name(m, from, to) || same_content(m, from, to))
            rmap_match_join(m, from, to);
        return;
    }
    for (size_t k = 0; k < sizeof elsewhere / sizeof *elsewhere; k++)
        join_nearest(m, run, elsewhere[k], false);
}

void rmap_match_alike(struct rmap_matching *m, const struct rmap_match_run *run)
{
    static const unsigned wanted[] = {CONTENT | PLACE, NAME | CONTENT, CONTENT};
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
        join_nearest(m, run, wanted[k], true);
}

void rmap_match_pair(struct rmap_matching *m, const struct rmap_match_run *run)
{
    if (run->end[0] - run->first[0] == 1 && run->end[1] - run->first[1] == 1)
        rmap_match_in_order(m, run);
}

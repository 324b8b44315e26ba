/* SPDX-License-Identifier: MIT
 *
 * Which part of a revision is which part of the one before.
 */
#include "io/assembly/assembly_match.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/assembly/match_side.h"

struct matching {
    struct rmap_match_side side[2]; /* before, after */
    int depth;                      /* that is looked at */
    int32_t *votes;                 /* [parts of the old one] */
    struct stand {
        double along;
        struct rmap_vec3 at;
        int32_t part;
    } * stand;            /* [the same] of those of a run, along the axis on which they are farthest
                             apart */
    struct stand *seeker; /* [parts of the new one] of a run, by how far their nearest is */
};

typedef uint64_t value_of(const struct matching *m, int side, size_t i); /* 0: it takes no part */

static const struct rmap_assembly_part *part_of(const struct matching *m, int side, size_t i)
{
    return &m->side[side].assembly->part[i];
}

/* ---- what a pair has in common ---- */

static bool is_group(const struct matching *m, int side, int32_t i)
{
    return part_of(m, side, (size_t)i)->shape < 0;
}

static bool same_name(const struct matching *m, int32_t from, int32_t to)
{
    if (m->side[0].id[from] == 0 && m->side[1].id[to] == 0)
        return true; /* a count is no name */
    return strcmp(part_of(m, 0, (size_t)from)->name, part_of(m, 1, (size_t)to)->name) == 0;
}

static bool same_content(const struct matching *m, int32_t from, int32_t to)
{
    return m->side[0].content[from] == m->side[1].content[to];
}

/* In the parent's frame or in the world. */
static const struct rmap_affine *place_of(const struct matching *m, int side, int32_t i, bool world)
{
    return world ? &m->side[side].world[i] : &part_of(m, side, (size_t)i)->place;
}

static bool same_place(const struct matching *m, int32_t from, int32_t to, bool world)
{
    return !rmap_assembly_is_apart(place_of(m, 0, from, world), place_of(m, 1, to, world));
}

/* The middle of its shape's box, since many parts are turned about one origin. */
static struct rmap_vec3 middle_of(const struct matching *m, int side, int32_t i, bool world)
{
    const struct rmap_assembly *a = m->side[side].assembly;
    struct rmap_vec3 middle = rmap_vec3(0, 0, 0);
    if (a->part[i].shape >= 0) {
        const struct rmap_assembly_shape *shape = &a->shape[a->part[i].shape];
        middle = rmap_vec3(0.5 * (shape->lower[0] + shape->upper[0]),
                           0.5 * (shape->lower[1] + shape->upper[1]),
                           0.5 * (shape->lower[2] + shape->upper[2]));
    }
    return rmap_affine_point(place_of(m, side, i, world), middle);
}

static void join(struct matching *m, int32_t from, int32_t to)
{
    m->side[1].known[to] = from;
    m->side[0].known[from] = to;
}

/* ---- runs of one value ---- */

/* Those of one value on either side, [first, end) of the keys. */
struct run {
    size_t first[2], end[2];
};

static size_t collect(struct matching *m, int side, value_of *value)
{
    struct rmap_match_side *s = &m->side[side];
    size_t n = 0;
    for (size_t i = 0; i < s->assembly->n_part; i++) {
        const uint64_t its = s->known[i] < 0 ? value(m, side, i) : 0;
        if (its)
            s->key[n++] = (struct rmap_part_key){its, (int32_t)i};
    }
    if (n > 0)
        qsort(s->key, n, sizeof *s->key, rmap_part_key_compare);
    return n;
}

static void each_run(struct matching *m, value_of *value,
                     void visit(struct matching *m, const struct run *run))
{
    const size_t n[2] = {collect(m, 0, value), collect(m, 1, value)};
    struct run run = {0};
    while (run.first[0] < n[0] && run.first[1] < n[1]) {
        const uint64_t a = m->side[0].key[run.first[0]].value,
                       b = m->side[1].key[run.first[1]].value, least = a < b ? a : b;
        for (int side = 0; side < 2; side++) {
            run.end[side] = run.first[side];
            while (run.end[side] < n[side] && m->side[side].key[run.end[side]].value == least)
                run.end[side]++;
        }
        if (a == b)
            visit(m, &run);
        memcpy(run.first, run.end, sizeof run.first);
    }
}

/* ---- values ---- */

/* Of one depth, whose parents are the same. */
static uint64_t under_parent(const struct matching *m, int side, size_t i)
{
    const struct rmap_match_side *s = &m->side[side];
    const int32_t up = s->assembly->part[i].parent;
    const int32_t old = up < 0 || side == 0 ? up : s->known[up];
    if (s->depth[i] != m->depth || (up >= 0 && s->known[up] < 0))
        return 0;
    return rmap_match_mix((uint64_t)(old + 2), s->assembly->part[i].shape < 0);
}

static uint64_t with(uint64_t scope, uint64_t value)
{
    return scope ? rmap_match_mix(scope, value) : 0;
}

/* Of numbers that are the same but for rounding; that they fall apart at a step costs time only. */
static uint64_t place_hash(const struct rmap_affine *place)
{
    const double t[3] = {place->t.x, place->t.y, place->t.z}, most = 1e12;
    int64_t step[12];
    for (int k = 0; k < 9; k++)
        step[k] = (int64_t)llround(fmin(fmax(place->m[k / 3][k % 3] * 1e6, -most), most));
    for (int k = 0; k < 3; k++)
        step[9 + k] = (int64_t)llround(fmin(fmax(t[k] * 1e4, -most), most));
    return XXH3_64bits(step, sizeof step);
}

static uint64_t name_value(const struct matching *m, int side, size_t i)
{
    return m->side[side].id[i] == 0 ? 0 : rmap_match_text(part_of(m, side, i)->name);
}

static uint64_t sibling_id(const struct matching *m, int side, size_t i)
{
    return with(under_parent(m, side, i), m->side[side].id[i]);
}

static uint64_t sibling_name(const struct matching *m, int side, size_t i)
{
    return with(under_parent(m, side, i), name_value(m, side, i));
}

/* Its shape as it lies in its frame, and where this is. */
static uint64_t stands(const struct matching *m, int side, size_t i, bool world)
{
    const struct rmap_assembly *a = m->side[side].assembly;
    const int32_t shape = a->part[i].shape;
    const uint64_t content =
        shape < 0 ? m->side[side].content[i] : rmap_match_text(a->shape[shape].hash);
    return rmap_match_mix(content, place_hash(place_of(m, side, (int32_t)i, world)));
}

static uint64_t sibling_place(const struct matching *m, int side, size_t i)
{
    return with(under_parent(m, side, i), stands(m, side, i, false));
}

static uint64_t untouched_id(const struct matching *m, int side, size_t i)
{
    return with(with(sibling_place(m, side, i), m->side[side].id[i]), name_value(m, side, i));
}

static uint64_t untouched_name(const struct matching *m, int side, size_t i)
{
    return with(sibling_place(m, side, i), name_value(m, side, i));
}

static uint64_t world_name(const struct matching *m, int side, size_t i)
{
    return rmap_match_mix(rmap_match_mix(name_value(m, side, i), m->side[side].content[i]),
                          part_of(m, side, i)->shape < 0);
}

static uint64_t world_untouched(const struct matching *m, int side, size_t i)
{
    return rmap_match_mix(world_name(m, side, i), stands(m, side, i, true));
}

static size_t count_named(const struct rmap_match_side *s, uint64_t name, size_t *first_ret)
{
    size_t low = 0, high = s->assembly->n_part, n = 0;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (s->name[middle].value < name)
            low = middle + 1;
        else
            high = middle;
    }
    *first_ret = low;
    while (low + n < s->assembly->n_part && s->name[low + n].value == name)
        n++;
    return n;
}

static uint64_t unique_name(const struct matching *m, int side, size_t i)
{
    size_t first;
    const uint64_t name = name_value(m, side, i);
    const bool unique =
        count_named(&m->side[0], name, &first) == 1 && count_named(&m->side[1], name, &first) == 1;
    return unique ? rmap_match_mix(name, part_of(m, side, i)->shape < 0) : 0;
}

static uint64_t shape_value(const struct matching *m, int side, size_t i)
{
    return part_of(m, side, i)->shape < 0 ? 0 : rmap_match_mix(m->side[side].content[i], 0);
}

static uint64_t id_alone(const struct matching *m, int side, size_t i)
{
    return rmap_match_mix(rmap_match_text(part_of(m, side, i)->id), part_of(m, side, i)->shape < 0);
}

/* ---- the rules ---- */

static void join_in_order(struct matching *m, const struct run *run)
{
    for (size_t k = 0; run->first[0] + k < run->end[0] && run->first[1] + k < run->end[1]; k++)
        join(m, m->side[0].key[run->first[0] + k].part, m->side[1].key[run->first[1] + k].part);
}

enum { NAME = 1, CONTENT = 2, PLACE = 4 };

static bool agree(const struct matching *m, int32_t from, int32_t to, unsigned wanted, bool world)
{
    return (!(wanted & CONTENT) || same_content(m, from, to)) &&
           (!(wanted & NAME) || same_name(m, from, to)) &&
           (!(wanted & PLACE) || same_place(m, from, to, world));
}

static int by_along(const void *a, const void *b)
{
    const struct stand *x = a, *y = b;
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
static size_t line_up(struct matching *m, const struct run *run, bool world, int *axis_ret)
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
        m->stand[n++] = (struct stand){0, at, part};
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
static int32_t nearest_of(const struct matching *m, size_t n, int axis, int32_t to, unsigned wanted,
                          bool world, double *away_ret)
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
        const struct stand *stand = go_up ? &m->stand[up++] : &m->stand[--down];
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
static void join_nearest(struct matching *m, const struct run *run, unsigned wanted, bool world)
{
    int axis;
    double away;
    const size_t n = line_up(m, run, world, &axis);
    size_t n_seeker = 0;
    for (size_t k = run->first[1]; n > 0 && k < run->end[1]; k++) {
        const int32_t to = m->side[1].key[k].part;
        if (m->side[1].known[to] < 0 && nearest_of(m, n, axis, to, wanted, world, &away) >= 0)
            m->seeker[n_seeker++] = (struct stand){.along = away, .part = to};
    }
    if (n_seeker > 0)
        qsort(m->seeker, n_seeker, sizeof *m->seeker, by_along);
    for (size_t k = 0; k < n_seeker; k++) {
        const int32_t to = m->seeker[k].part,
                      from = nearest_of(m, n, axis, to, wanted, world, &away);
        if (from >= 0)
            join(m, from, to);
    }
}

/* The one of a run that is left; -1: none, or several. */
static int32_t left_of(const struct matching *m, const struct run *run, int side)
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
static void join_siblings(struct matching *m, const struct run *run)
{
    static const unsigned standing[] = {NAME | CONTENT | PLACE, CONTENT | PLACE, NAME | PLACE},
                          elsewhere[] = {NAME | CONTENT, CONTENT, NAME};
    if (run->end[0] - run->first[0] > 1 || run->end[1] - run->first[1] > 1)
        for (size_t k = 0; k < sizeof standing / sizeof *standing; k++)
            join_nearest(m, run, standing[k], false);
    const int32_t from = left_of(m, run, 0), to = left_of(m, run, 1);
    if (from >= 0 && to >= 0) {
        if (same_name(m, from, to) || same_content(m, from, to))
            join(m, from, to);
        return;
    }
    for (size_t k = 0; k < sizeof elsewhere / sizeof *elsewhere; k++)
        join_nearest(m, run, elsewhere[k], false);
}

static void join_alike(struct matching *m, const struct run *run)
{
    static const unsigned wanted[] = {CONTENT | PLACE, NAME | CONTENT, CONTENT};
    for (size_t k = 0; k < sizeof wanted / sizeof *wanted; k++)
        join_nearest(m, run, wanted[k], true);
}

static void join_pair(struct matching *m, const struct run *run)
{
    if (run->end[0] - run->first[0] == 1 && run->end[1] - run->first[1] == 1)
        join_in_order(m, run);
}

/* ---- groups ---- */

/* The next child of a part behind child `at` (or behind the part itself); n_part: none. */
static size_t next_child(const struct rmap_match_side *s, size_t group, size_t at)
{
    const size_t n = s->assembly->n_part;
    for (at++; at < n && s->depth[at] > s->depth[group]; at++)
        if (s->depth[at] == s->depth[group] + 1)
            return at;
    return n;
}

static size_t count_children(const struct rmap_match_side *s, size_t group)
{
    size_t n = 0;
    for (size_t i = next_child(s, group, group); i < s->assembly->n_part;
         i = next_child(s, group, i))
        n++;
    return n;
}

static void vote(struct matching *m, int32_t child, int way, int32_t *best)
{
    const int32_t up = child < 0 ? -1 : part_of(m, 0, (size_t)child)->parent;
    if (up < 0 || m->side[0].known[up] >= 0)
        return;
    m->votes[up] += way;
    if (way > 0 && (*best < 0 || m->votes[up] > m->votes[*best]))
        *best = up;
}

/* For the groups that a child, or one of its name, was in. */
static void vote_of(struct matching *m, size_t child, int way, int32_t *best)
{
    enum { MOST = 64 };
    size_t first;
    if (m->side[1].known[child] >= 0) {
        vote(m, m->side[1].known[child], way, best);
        return;
    }
    const size_t n = count_named(&m->side[0], name_value(m, 1, child), &first);
    for (size_t k = first; n <= MOST && k < first + n; k++)
        if (m->side[0].known[m->side[0].name[k].part] < 0)
            vote(m, m->side[0].name[k].part, way, best);
}

/* A group is the old one that has half of what is in it, or more, and of which it has half. */
static void join_group(struct matching *m, size_t group)
{
    const struct rmap_match_side *s = &m->side[1];
    const size_t n_part = s->assembly->n_part;
    int32_t best = -1, unheard = 0;
    for (size_t i = next_child(s, group, group); i < n_part; i = next_child(s, group, i))
        vote_of(m, i, 1, &best);
    const size_t most = best < 0 ? 0 : (size_t)m->votes[best];
    for (size_t i = next_child(s, group, group); i < n_part; i = next_child(s, group, i))
        vote_of(m, i, -1, &unheard);
    if (best >= 0 && 2 * most >= count_children(s, group) &&
        2 * most >= count_children(&m->side[0], (size_t)best))
        join(m, best, (int32_t)group);
}

static int deepest(const struct matching *m)
{
    int most = 0;
    for (size_t i = 0; i < m->side[1].assembly->n_part; i++)
        most = m->side[1].depth[i] > most ? m->side[1].depth[i] : most;
    return most;
}

static void join_groups_of(struct matching *m, int depth)
{
    for (size_t i = 0; i < m->side[1].assembly->n_part; i++)
        if (m->side[1].depth[i] == depth && m->side[1].known[i] < 0 && is_group(m, 1, (int32_t)i))
            join_group(m, i);
}

static void join_from_the_root(struct matching *m)
{
    const int most = deepest(m);
    for (m->depth = 0; m->depth <= most; m->depth++) {
        each_run(m, untouched_id, join_in_order);
        each_run(m, sibling_id, join_siblings);
        each_run(m, untouched_name, join_in_order);
        each_run(m, sibling_name, join_siblings);
        each_run(m, sibling_place, join_in_order);
        join_groups_of(m, m->depth);
    }
}

/* ---- the whole ---- */

static enum rmap_status begin(struct matching *m, struct rmap_assembly_match *match,
                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_after = m->side[1].assembly->n_part;
    const bool by_form = rmap_assembly_has_forms(m->side[0].assembly) &&
                         rmap_assembly_has_forms(m->side[1].assembly);
    for (int side = 0; side < 2 && st == RMAP_OK; side++)
        st = rmap_match_side_begin(&m->side[side], by_form, err);
    match->to = m->side[0].known;
    match->from = m->side[1].known;
    match->change = rmap_alloc(n_after, sizeof *match->change);
    match->motion = rmap_alloc(n_after, sizeof *match->motion);
    match->kept = rmap_alloc(m->side[1].assembly->n_shape, sizeof *match->kept);
    m->votes = rmap_alloc(m->side[0].assembly->n_part, sizeof *m->votes);
    m->stand = rmap_alloc(m->side[0].assembly->n_part, sizeof *m->stand);
    m->seeker = rmap_alloc(n_after, sizeof *m->seeker);
    if (st == RMAP_OK &&
        (!match->change || !match->motion || !match->kept || !m->votes || !m->stand || !m->seeker))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", n_after);
    return st;
}

enum rmap_status rmap_assembly_match(const struct rmap_assembly *before,
                                     const struct rmap_assembly *after,
                                     struct rmap_assembly_match *match, struct rmap_error *err)
{
    struct matching m = {.side = {{.assembly = before}, {.assembly = after}}};
    const enum rmap_status st = begin(&m, match, err);
    if (st == RMAP_OK) {
        join_from_the_root(&m);
        each_run(&m, world_untouched, join_in_order);
        each_run(&m, world_name, join_alike);
        each_run(&m, unique_name, join_pair);
        each_run(&m, shape_value, join_alike);
        for (int depth = deepest(&m); depth >= 0; depth--)
            join_groups_of(&m, depth);
        join_from_the_root(&m);
        each_run(&m, id_alone, join_pair);
        rmap_assembly_find_changes(before, after, match);
    }
    for (int side = 0; side < 2; side++)
        rmap_match_side_fini(&m.side[side]);
    rmap_free(m.votes);
    rmap_free(m.stand);
    rmap_free(m.seeker);
    return st;
}

void rmap_assembly_match_fini(struct rmap_assembly_match *match)
{
    rmap_free(match->from);
    rmap_free(match->change);
    rmap_free(match->motion);
    rmap_free(match->to);
    rmap_free(match->kept);
    *match = (struct rmap_assembly_match){0};
}

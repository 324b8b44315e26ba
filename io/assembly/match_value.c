/* SPDX-License-Identifier: MIT
 *
 * The values that parts are brought together by, and the runs of one value.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "io/assembly/matching.h"

typedef uint64_t value_of(const struct rmap_matching *m, int side,
                          size_t i); /* 0: it takes no part */

/* Of one depth, whose parents are the same. */
static uint64_t under_parent(const struct rmap_matching *m, int side, size_t i)
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

uint64_t rmap_match_name(const struct rmap_matching *m, int side, size_t i)
{
    return m->side[side].id[i] == 0 ? 0 : rmap_match_text(rmap_match_part(m, side, i)->name);
}

static uint64_t sibling_id(const struct rmap_matching *m, int side, size_t i)
{
    return with(under_parent(m, side, i), m->side[side].id[i]);
}

static uint64_t sibling_name(const struct rmap_matching *m, int side, size_t i)
{
    return with(under_parent(m, side, i), rmap_match_name(m, side, i));
}

/* Its shape as it lies in its frame, and where this is. */
static uint64_t stands(const struct rmap_matching *m, int side, size_t i, bool world)
{
    const struct rmap_assembly *a = m->side[side].assembly;
    const int32_t shape = a->part[i].shape;
    const uint64_t content =
        shape < 0 ? m->side[side].content[i] : rmap_match_text(a->shape[shape].hash);
    return rmap_match_mix(content, place_hash(rmap_match_place(m, side, i, world)));
}

static uint64_t sibling_place(const struct rmap_matching *m, int side, size_t i)
{
    return with(under_parent(m, side, i), stands(m, side, i, false));
}

static uint64_t untouched_id(const struct rmap_matching *m, int side, size_t i)
{
    return with(with(sibling_place(m, side, i), m->side[side].id[i]), rmap_match_name(m, side, i));
}

static uint64_t untouched_name(const struct rmap_matching *m, int side, size_t i)
{
    return with(sibling_place(m, side, i), rmap_match_name(m, side, i));
}

static uint64_t world_name(const struct rmap_matching *m, int side, size_t i)
{
    return rmap_match_mix(rmap_match_mix(rmap_match_name(m, side, i), m->side[side].content[i]),
                          rmap_match_part(m, side, i)->shape < 0);
}

static uint64_t world_untouched(const struct rmap_matching *m, int side, size_t i)
{
    return rmap_match_mix(world_name(m, side, i), stands(m, side, i, true));
}

size_t rmap_match_named(const struct rmap_match_side *s, uint64_t name, size_t *first_ret)
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

static uint64_t unique_name(const struct rmap_matching *m, int side, size_t i)
{
    size_t first;
    const uint64_t name = rmap_match_name(m, side, i);
    const bool unique = rmap_match_named(&m->side[0], name, &first) == 1 &&
                        rmap_match_named(&m->side[1], name, &first) == 1;
    return unique ? rmap_match_mix(name, rmap_match_part(m, side, i)->shape < 0) : 0;
}

static uint64_t shape_value(const struct rmap_matching *m, int side, size_t i)
{
    return rmap_match_part(m, side, i)->shape < 0 ? 0 : rmap_match_mix(m->side[side].content[i], 0);
}

static uint64_t id_alone(const struct rmap_matching *m, int side, size_t i)
{
    return rmap_match_mix(rmap_match_text(rmap_match_part(m, side, i)->id),
                          rmap_match_part(m, side, i)->shape < 0);
}

/* ---- runs of one value ---- */

static value_of *const value_table[RMAP_MATCH_VALUE_COUNT] = {
    [RMAP_MATCH_UNTOUCHED_ID] = untouched_id,
    [RMAP_MATCH_SIBLING_ID] = sibling_id,
    [RMAP_MATCH_UNTOUCHED_NAME] = untouched_name,
    [RMAP_MATCH_SIBLING_NAME] = sibling_name,
    [RMAP_MATCH_SIBLING_PLACE] = sibling_place,
    [RMAP_MATCH_WORLD_UNTOUCHED] = world_untouched,
    [RMAP_MATCH_WORLD_NAME] = world_name,
    [RMAP_MATCH_UNIQUE_NAME] = unique_name,
    [RMAP_MATCH_SHAPE] = shape_value,
    [RMAP_MATCH_ID] = id_alone,
};

static size_t collect(struct rmap_matching *m, int side, value_of *value)
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

void rmap_match_each_run(struct rmap_matching *m, enum rmap_match_value value,
                         rmap_match_visit *visit)
{
    const size_t n[2] = {collect(m, 0, value_table[value]), collect(m, 1, value_table[value])};
    struct rmap_match_run run = {0};
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

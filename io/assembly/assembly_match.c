/* SPDX-License-Identifier: MIT
 *
 * Which part of a revision is which part of the one before.
 */
#include "io/assembly/assembly_match.h"

#include <stdlib.h>

#include "base/alloc.h"
#include "io/assembly/matching.h"

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

static void vote(struct rmap_matching *m, int32_t child, int way, int32_t *best)
{
    const int32_t up = child < 0 ? -1 : rmap_match_part(m, 0, (size_t)child)->parent;
    if (up < 0 || m->side[0].known[up] >= 0)
        return;
    m->votes[up] += way;
    if (way > 0 && (*best < 0 || m->votes[up] > m->votes[*best]))
        *best = up;
}

/* For the groups that a child, or one of its name, was in. */
static void vote_of(struct rmap_matching *m, size_t child, int way, int32_t *best)
{
    enum { MOST = 64 };
    size_t first;
    if (m->side[1].known[child] >= 0) {
        vote(m, m->side[1].known[child], way, best);
        return;
    }
    const size_t n = rmap_match_named(&m->side[0], rmap_match_name(m, 1, child), &first);
    for (size_t k = first; n <= MOST && k < first + n; k++)
        if (m->side[0].known[m->side[0].name[k].part] < 0)
            vote(m, m->side[0].name[k].part, way, best);
}

/* A group is the old one that has half of what is in it, or more, and of which it has half. */
static void join_group(struct rmap_matching *m, size_t group)
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
        rmap_match_join(m, best, (int32_t)group);
}

static int deepest(const struct rmap_matching *m)
{
    int most = 0;
    for (size_t i = 0; i < m->side[1].assembly->n_part; i++)
        most = m->side[1].depth[i] > most ? m->side[1].depth[i] : most;
    return most;
}

static void join_groups_of(struct rmap_matching *m, int depth)
{
    for (size_t i = 0; i < m->side[1].assembly->n_part; i++)
        if (m->side[1].depth[i] == depth && m->side[1].known[i] < 0 &&
            rmap_match_part(m, 1, i)->shape < 0)
            join_group(m, i);
}

static void join_from_the_root(struct rmap_matching *m)
{
    const int most = deepest(m);
    for (m->depth = 0; m->depth <= most; m->depth++) {
        rmap_match_each_run(m, RMAP_MATCH_UNTOUCHED_ID, rmap_match_in_order);
        rmap_match_each_run(m, RMAP_MATCH_SIBLING_ID, rmap_match_siblings);
        rmap_match_each_run(m, RMAP_MATCH_UNTOUCHED_NAME, rmap_match_in_order);
        rmap_match_each_run(m, RMAP_MATCH_SIBLING_NAME, rmap_match_siblings);
        rmap_match_each_run(m, RMAP_MATCH_SIBLING_PLACE, rmap_match_in_order);
        join_groups_of(m, m->depth);
    }
}

/* ---- the whole ---- */

static enum rmap_status begin(struct rmap_matching *m, struct rmap_assembly_match *match,
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
    struct rmap_matching m = {.side = {{.assembly = before}, {.assembly = after}}};
    const enum rmap_status st = begin(&m, match, err);
    if (st == RMAP_OK) {
        join_from_the_root(&m);
        rmap_match_each_run(&m, RMAP_MATCH_WORLD_UNTOUCHED, rmap_match_in_order);
        rmap_match_each_run(&m, RMAP_MATCH_WORLD_NAME, rmap_match_alike);
        rmap_match_each_run(&m, RMAP_MATCH_UNIQUE_NAME, rmap_match_pair);
        rmap_match_each_run(&m, RMAP_MATCH_SHAPE, rmap_match_alike);
        for (int depth = deepest(&m); depth >= 0; depth--)
            join_groups_of(&m, depth);
        join_from_the_root(&m);
        rmap_match_each_run(&m, RMAP_MATCH_ID, rmap_match_pair);
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

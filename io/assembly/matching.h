/* SPDX-License-Identifier: MIT
 *
 * A matching of parts at work: what is known by now, the values that parts are brought together by,
 * and how those of one value are.
 */
#ifndef RMAP_MATCHING_H
#define RMAP_MATCHING_H

#include "io/assembly/match_side.h"

struct rmap_match_stand;

struct rmap_matching {
    struct rmap_match_side side[2];  /* before, after */
    int depth;                       /* that is looked at */
    int32_t *votes;                  /* [parts of the old one] */
    struct rmap_match_stand *stand;  /* [the same] of those of a run, along the axis on which they
                                        are farthest apart */
    struct rmap_match_stand *seeker; /* [parts of the new one] of a run, by how far their nearest
                                        is */
};

/* Where a part of a run is, for rmap_match_siblings and rmap_match_alike. */
struct rmap_match_stand {
    double along;
    struct rmap_vec3 at;
    int32_t part;
};

static inline const struct rmap_assembly_part *rmap_match_part(const struct rmap_matching *m,
                                                               int side, size_t i)
{
    return &m->side[side].assembly->part[i];
}

/* In the parent's frame or in the world. */
static inline const struct rmap_affine *rmap_match_place(const struct rmap_matching *m, int side,
                                                         size_t i, bool world)
{
    return world ? &m->side[side].world[i] : &rmap_match_part(m, side, i)->place;
}

static inline void rmap_match_join(struct rmap_matching *m, int32_t from, int32_t to)
{
    m->side[1].known[to] = from;
    m->side[0].known[from] = to;
}

/* ---- values ---- */

/* By what parts that are not matched yet are brought together. Those of the first five are of
 * m->depth and under parents that are the same. */
enum rmap_match_value {
    RMAP_MATCH_UNTOUCHED_ID, /* id, name, shape and place */
    RMAP_MATCH_SIBLING_ID,
    RMAP_MATCH_UNTOUCHED_NAME, /* name, shape and place */
    RMAP_MATCH_SIBLING_NAME,
    RMAP_MATCH_SIBLING_PLACE,   /* shape and place */
    RMAP_MATCH_WORLD_UNTOUCHED, /* name, shape and place in the world */
    RMAP_MATCH_WORLD_NAME,      /* name and shape */
    RMAP_MATCH_UNIQUE_NAME,     /* that one part on either side has */
    RMAP_MATCH_SHAPE,
    RMAP_MATCH_ID,
    RMAP_MATCH_VALUE_COUNT
};

/* Those of one value on either side: [first, end) of the keys. */
struct rmap_match_run {
    size_t first[2], end[2];
};

typedef void rmap_match_visit(struct rmap_matching *m, const struct rmap_match_run *run);

/* Visits the runs that both sides have. */
void rmap_match_each_run(struct rmap_matching *m, enum rmap_match_value value,
                         rmap_match_visit *visit);

/* Of its name; 0: it is only counted. */
uint64_t rmap_match_name(const struct rmap_matching *m, int side, size_t i);

/* How many parts of the side have the name; *first_ret: of its names. */
size_t rmap_match_named(const struct rmap_match_side *side, uint64_t name, size_t *first_ret);

/* ---- those of one run ---- */

/* As they come. */
rmap_match_visit rmap_match_in_order;

/* If it is one on either side. */
rmap_match_visit rmap_match_pair;

/* Of one id or one name under one parent: those that stand where they stood first, so that what is
 * new takes nobody's place. */
rmap_match_visit rmap_match_siblings;

/* Of one shape, wherever they are: the nearest first. */
rmap_match_visit rmap_match_alike;

#endif

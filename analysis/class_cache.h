/* SPDX-License-Identifier: MIT
 *
 * Classes that a thread meets often, so few that they fit into its first cache: rays of theirs are
 * counted here, without a branch, and taken to the table of all classes when another class needs
 * the line, or at the end.
 */
#ifndef RMAP_CLASS_CACHE_H
#define RMAP_CLASS_CACHE_H

#include "analysis/class_sums.h"

enum { RMAP_CLASS_CACHE_BITS = 10, RMAP_CLASS_CACHE_LINES = 1 << RMAP_CLASS_CACHE_BITS };

/* What was counted in a line. */
struct rmap_class_line {
    uint64_t first_ray; /* of the class, as far as it is known here */
    uint64_t rays;      /* not in the table yet */
};

/* All zero is empty. Rays have weight 1, and those of a class are alike. Keys stand by themselves:
 * a ray need not wait for what was written for the one before. */
struct rmap_class_cache {
    struct rmap_key key[RMAP_CLASS_CACHE_LINES]; /* high 0: of none */
    struct rmap_class_line line[RMAP_CLASS_CACHE_LINES];
    uint32_t class[RMAP_CLASS_CACHE_LINES]; /* in the table */
};

static inline size_t rmap_class_cache_at(uint64_t mixed)
{
    return (size_t)(mixed >> (64 - RMAP_CLASS_CACHE_BITS));
}

/* Counts a ray if its class is here. */
static inline bool rmap_class_cache_count(struct rmap_class_cache *cache, struct rmap_key key,
                                          uint64_t mixed, uint64_t id)
{
    const size_t at = rmap_class_cache_at(mixed);
    const struct rmap_key its = cache->key[at];
    struct rmap_class_line *line = &cache->line[at];
    const bool is_here = ((its.low ^ key.low) | (its.high ^ key.high)) == 0;
    const bool is_first = is_here & (id < line->first_ray); /* rare, as ids mostly ascend */
    line->rays += is_here;
    if (is_first)
        line->first_ray = id;
    return is_here;
}

/* To the table. */
static inline void rmap_class_cache_flush(struct rmap_class_cache *cache, size_t at,
                                          struct rmap_class_sums *classes)
{
    struct rmap_class_line *line = &cache->line[at];
    if (line->rays > 0)
        rmap_class_sums_add_rays(classes, cache->class[at], line -> rays, line -> first_ray);
    line->rays = 0;
}

/* A class was met that has other rays: it gets the line, unless more than a few rays of the class
 * that has it were counted. */
static inline void rmap_class_cache_meet(struct rmap_class_cache *cache, struct rmap_key key,
                                         uint64_t mixed, size_t class,
                                         struct rmap_class_sums *classes)
{
    enum { FEW = 3 };
    const size_t at = rmap_class_cache_at(mixed);
    if (cache->line[at].rays > FEW)
        return;
    rmap_class_cache_flush(cache, at, classes);
    cache->line[at] = (struct rmap_class_line){classes->entry[class].first_ray, 0};
    cache->class[at] = (uint32_t) class;
    cache->key[at] = key;
}

#endif

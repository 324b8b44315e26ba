/* SPDX-License-Identifier: MIT
 *
 * Classes that a thread meets often, so few that they fit into its second cache: rays of theirs are
 * counted here, without a branch, and taken to the table of all classes when another class needs
 * the line, or at the end. Their ids ascend, so that the class's first ray is known to the table.
 */
#ifndef RMAP_CLASS_CACHE_H
#define RMAP_CLASS_CACHE_H

#include <string.h>

#include "analysis/table/class_sums.h"

enum { RMAP_CLASS_CACHE_BITS = 12, RMAP_CLASS_CACHE_LINES = 1 << RMAP_CLASS_CACHE_BITS };

/* All zero is empty. Rays have weight 1, and those of a class are alike. Keys stand by themselves:
 * a ray need not wait for what was written for the one before. */
struct rmap_class_cache {
    struct rmap_key key[RMAP_CLASS_CACHE_LINES]; /* high 0: of none */
    uint64_t rays[RMAP_CLASS_CACHE_LINES];       /* not in the table yet */
    uint32_t class[RMAP_CLASS_CACHE_LINES];      /* in the table */
    uint64_t end;                                /* behind the last id that came */
};

static inline size_t rmap_class_cache_at(uint64_t mixed)
{
    return (size_t)(mixed >> (64 - RMAP_CLASS_CACHE_BITS));
}

/* Counts a ray if its class is here. */
static inline bool rmap_class_cache_count(struct rmap_class_cache *cache, struct rmap_key key,
                                          uint64_t mixed)
{
    const size_t at = rmap_class_cache_at(mixed);
    const struct rmap_key its = cache->key[at];
    const bool is_here = ((its.low ^ key.low) | (its.high ^ key.high)) == 0;
    cache->rays[at] += is_here;
    return is_here;
}

/* To the table. */
static inline void rmap_class_cache_flush(struct rmap_class_cache *cache, size_t at,
                                          struct rmap_class_sums *classes)
{
    if (cache->rays[at] > 0)
        rmap_class_sums_add_rays(classes, cache->class[at], cache -> rays[at]);
    cache->rays[at] = 0;
}

/* Empties all lines: ids will not ascend from here. */
static inline void rmap_class_cache_empty(struct rmap_class_cache *cache,
                                          struct rmap_class_sums *classes)
{
    for (size_t at = 0; at < RMAP_CLASS_CACHE_LINES; at++)
        rmap_class_cache_flush(cache, at, classes);
    memset(cache, 0, sizeof *cache);
}

/* A class was met that has other rays: it gets the line, unless more than a few rays of the class
 * that has it were counted. */
static inline void rmap_class_cache_meet(struct rmap_class_cache *cache, struct rmap_key key,
                                         uint64_t mixed, size_t class,
                                         struct rmap_class_sums *classes)
{
    enum { FEW = 3 };
    const size_t at = rmap_class_cache_at(mixed);
    if (cache->rays[at] > FEW)
        return;
    rmap_class_cache_flush(cache, at, classes);
    cache->class[at] = (uint32_t) class;
    cache->key[at] = key;
}

#endif

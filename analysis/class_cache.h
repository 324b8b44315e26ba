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

struct rmap_class_line {
    struct rmap_key key; /* high 0: of none */
    uint64_t first_ray;  /* smallest id of the rays counted here */
    uint32_t rays;       /* not in the table yet */
    uint32_t class;      /* in the table */
};

/* All zero is empty. Rays have weight 1, and those of a class are alike. */
struct rmap_class_cache {
    struct rmap_class_line line[RMAP_CLASS_CACHE_LINES];
};

static inline struct rmap_class_line *rmap_class_cache_line(struct rmap_class_cache *cache,
                                                            uint64_t mixed)
{
    return &cache->line[mixed >> (64 - RMAP_CLASS_CACHE_BITS)];
}

/* Counts a ray if its class is here. */
static inline bool rmap_class_cache_count(struct rmap_class_cache *cache, struct rmap_key key,
                                          uint64_t mixed, uint64_t id)
{
    struct rmap_class_line *line = rmap_class_cache_line(cache, mixed);
    const bool is_here = ((line->key.low ^ key.low) | (line->key.high ^ key.high)) == 0;
    const uint64_t first = id < line->first_ray ? id : line->first_ray;
    line->first_ray = is_here ? first : line->first_ray;
    line->rays += is_here;
    return is_here;
}

/* To the table. */
static inline void rmap_class_line_flush(struct rmap_class_line *line,
                                         struct rmap_class_sums *classes)
{
    if (line->rays > 0)
        rmap_class_sums_add_rays(classes, line->class, line->rays, line->first_ray);
    line->rays = 0;
    line->first_ray = UINT64_MAX;
}

/* A class was met that has other rays: it gets the line, unless rays of the class that has it were
 * counted since the last time. */
static inline void rmap_class_cache_meet(struct rmap_class_cache *cache, struct rmap_key key,
                                         uint64_t mixed, size_t class,
                                         struct rmap_class_sums *classes)
{
    struct rmap_class_line *line = rmap_class_cache_line(cache, mixed);
    const bool stays = line->rays > 0;
    rmap_class_line_flush(line, classes);
    if (!stays)
        *line = (struct rmap_class_line){key, UINT64_MAX, 0, (uint32_t) class};
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * When the light of a timed run was where: arrival times at the ends of stored segments, from
 * their lengths, the group indices of their media and the delays of fluorescence, which are drawn
 * again. The rest of a ray's stored delay is that of its emission.
 */
#ifndef RMAP_LIGHT_TIMES_H
#define RMAP_LIGHT_TIMES_H

#include "io/map/map_reader.h"
#include "portion/portion.h"

struct rmap_light_times {
    double *begin, *end; /* [n_segment] ns; the end of a leg that leaves the scene: as its begin */
    double *leaving;     /* [n_ray] ns per length along such a leg */
};

/* RMAP_USAGE where the map has no arrival times. */
enum rmap_status rmap_light_times_check(const struct rmap_map *map,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Of a portion with all columns that may hold rays of several colour spaces. RMAP_FORMAT where rows
 * do not fit together. */
enum rmap_status rmap_light_times_create(const struct rmap_map *map,
                                         const struct rmap_portion *rays,
                                         struct rmap_light_times **times_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_light_times_destroy(struct rmap_light_times *times); /* NULL is fine */

#endif

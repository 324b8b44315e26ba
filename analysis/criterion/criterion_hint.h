/* SPDX-License-Identifier: MIT
 *
 * Why no ray matches a criterion, where a test that must hold cannot, or reads like another.
 */
#ifndef RMAP_CRITERION_HINT_H
#define RMAP_CRITERION_HINT_H

#include "analysis/criterion/criterion.h"
#include "io/map/map_reader.h"

enum { RMAP_CRITERION_HINT_NBYTES = 1024 };

/* Of a criterion that matched nothing: one line for people, "" when nothing is to be said. From the
 * scene and what the map's index says of its portions; reads no rays. */
void rmap_criterion_hint(const struct rmap_criterion *criterion, const struct rmap_map *map,
                         char hint[RMAP_CRITERION_HINT_NBYTES]);

#endif

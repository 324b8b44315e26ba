/* SPDX-License-Identifier: MIT
 *
 * Statistics of classes of paths, as `raymap paths` ranks them: a group each, and the others.
 */
#ifndef RMAP_STATS_PATHS_H
#define RMAP_STATS_PATHS_H

#include "analysis/paths/path_key.h"
#include "analysis/query/fold.h"
#include "analysis/stats/stats_groups.h"

struct rmap_stats_paths {
    struct rmap_path_keys *keys; /* their view says whether paths end with registrations */
    size_t n;                    /* classes; group n: the others */
    struct rmap_key *key;        /* [n] */
    char **name;                 /* [n] "sun: T@lens.1 R@lens.2" */
};
void rmap_stats_paths_fini(struct rmap_stats_paths *paths);

const char *rmap_stats_path_name(const struct rmap_stats_paths *paths, size_t group);

/* Whether groups are of registrations: of their paths until then. */
bool rmap_stats_paths_of_registrations(const struct rmap_stats_paths *paths);

/* marks->group: of the rays that match, or of their registrations that count. The portion has the
 * columns of the keys. */
enum rmap_status rmap_stats_paths_mark(const struct rmap_stats_paths *paths,
                                       const struct rmap_matched *rays,
                                       struct rmap_stats_marks *marks,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

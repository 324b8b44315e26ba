/* SPDX-License-Identifier: MIT
 *
 * A test path("...") on a portion of which the history index has the rows: only rays that have
 * all the steps and registrations without which none matches are run through the automaton.
 */
#ifndef RMAP_QUERY_PATH_H
#define RMAP_QUERY_PATH_H

#include "analysis/criterion/criterion_tree.h"
#include "history/history_index.h"

/* Memory to be used again. All zero at first. */
struct rmap_query_path {
    uint64_t *may;                         /* bits of rays that may match; more, for the way */
    struct rmap_history_place_of_ray *ray; /* [n] that may match */
    uint16_t *row_class;                   /* of their segments */
    uint8_t *match;                        /* [n] that do */
    uint8_t *wanted;                       /* per class of segments, or of registrations */
    size_t may_cap, ray_cap, row_class_cap, match_cap, wanted_cap;
    struct rmap_portion *rays; /* these, side by side */
};
void rmap_query_path_fini(struct rmap_query_path *self);

/* bits: of the rays whose whole history is such a path. symbol: of each class of the index, as
 * rmap_path_symbol has it. */
enum rmap_status rmap_query_path_mark(struct rmap_query_path *self,
                                      const struct rmap_history_view *view,
                                      const struct rmap_criterion_node *node,
                                      const uint16_t *symbol, uint64_t *bits,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif

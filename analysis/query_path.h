/* SPDX-License-Identifier: MIT
 *
 * A test path("...") on a portion of which the history index has the rows: only rays that have
 * every step without which none matches are run through the automaton.
 */
#ifndef RMAP_QUERY_PATH_H
#define RMAP_QUERY_PATH_H

#include "analysis/criterion_tree.h"
#include "history/history_index.h"

/* Memory to be used again. All zero at first. */
struct rmap_query_path {
    uint8_t *begins;                       /* [n_ray] 1: as a match may */
    struct rmap_history_place_of_ray *ray; /* [n] that may match */
    uint16_t *row_class;                   /* of their legs */
    uint8_t *match;                        /* [n] that do */
    uint8_t *wanted;                       /* per class of legs, or of registrations */
    size_t begins_cap, ray_cap, row_class_cap, match_cap, wanted_cap;
    struct rmap_portion *rays; /* these, side by side */
};
void rmap_query_path_fini(struct rmap_query_path *self);

/* count [n_ray]: 1 where the whole history is such a path, or 0. symbol: of each class of the
 * index, as rmap_path_symbol has it. */
enum rmap_status rmap_query_path_count(struct rmap_query_path *self,
                                       const struct rmap_history_view *view,
                                       const struct rmap_criterion_node *node,
                                       const uint16_t *symbol, uint32_t *count,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

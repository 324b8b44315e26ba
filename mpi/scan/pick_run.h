/* SPDX-License-Identifier: MIT
 *
 * Rays that a question picks, written as a map of their own: every rank writes shards of it.
 */
#ifndef RMAP_PICK_RUN_H
#define RMAP_PICK_RUN_H

#include "analysis/query/query_mark.h"
#include "io/map/map_content.h"
#include "io/map/map_writer.h"
#include "mpi/command/command.h"
#include "mpi/parallel/deal.h"

struct rmap_pick_plan {
    const struct rmap_map *map;
    const struct rmap_pick *pick;
    enum rmap_deal_kind deal;
    const char *to;                         /* directory of the map, which exists */
    enum rmap_encoding encoding;            /* of the pieces to be written */
    const struct rmap_selection *selection; /* what the pieces say of their rays */
};

/* Collective. On rank 0 the pieces of all ranks are appended to *content, and *tally (of the map's
 * scene) becomes the sum of the picked rays: energy balance and images. RMAP_FORMAT names what
 * cannot be read. */
enum rmap_status rmap_pick_run(const struct rmap_context *context,
                               const struct rmap_pick_plan *plan, struct rmap_map_content *content,
                               struct rmap_tally *tally, struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Ranks of one node, and memory that they share.
 */
#ifndef RMAP_NODE_H
#define RMAP_NODE_H

#include "base/status.h"
#include "mpi/parallel/context.h"

struct rmap_node {
    bool is_first;              /* of the ranks that share memory; who shares none is, too */
    int memory;                 /* of io/file/shared_memory.h, empty; -1: this rank shares none */
    struct rmap_context firsts; /* where is_first: those ranks, rank 0 the first of them */
};

/* Collective. Ranks of a node that cannot all reach its first one's memory share none. *node is to
 * be released whatever comes. RMAP_SYSTEM. */
enum rmap_status rmap_node_init(struct rmap_node *node, const struct rmap_context *context,
                                struct rmap_error *err) RMAP_MUST_USE;

/* What was mapped of the memory stays. Collective. */
void rmap_node_fini(struct rmap_node *node);

#endif

/* SPDX-License-Identifier: MIT
 *
 * What every collective function is handed: the ranks, the threads of this one, and how the user
 * wants to be talked to.
 */
#ifndef RMAP_CONTEXT_H
#define RMAP_CONTEXT_H

#include <mpi.h>
#include <stdbool.h>

struct rmap_watchdog;
struct rmap_at_hand; /* mpi/parallel/at_hand.h */

struct rmap_context {
    MPI_Comm comm; /* the program's own duplicate of the world */
    int rank, size;
    int n_thread;                       /* worker threads of this rank, >= 1 */
    bool json;                          /* --json: exactly one JSON document on stdout */
    bool quiet;                         /* --quiet: no talk but errors */
    struct rmap_watchdog *watchdog;     /* tells of ranks that do not answer; NULL: nobody does */
    const struct rmap_at_hand *at_hand; /* of a server; NULL: files are opened */
    const char *cache;                  /* folder of meshes that scenes' files gave; NULL: none */
};

#endif

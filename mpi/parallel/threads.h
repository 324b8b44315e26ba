/* SPDX-License-Identifier: MIT
 *
 * How many worker threads a rank starts when nobody says.
 */
#ifndef RMAP_THREADS_H
#define RMAP_THREADS_H

#include <mpi.h>

/* Collective. This rank's share of the cores that the ranks of its node may use together; at
 * most the cores it may use itself and, where it is not bound, the cores that a batch system gives
 * each task; at least 1. */
int rmap_threads_share(MPI_Comm comm);

#endif

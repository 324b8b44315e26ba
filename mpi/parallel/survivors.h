/* SPDX-License-Identifier: MIT
 *
 * When a rank does not answer, the others leave it behind and go on among themselves. What is
 * collective on the program's communicator waits for ever from then on: the run ends by MPI_Abort.
 */
#ifndef RMAP_SURVIVORS_H
#define RMAP_SURVIVORS_H

#include "base/status.h"
#include "mpi/parallel/context.h"

struct rmap_survivors {          /* zeroed: all ranks answer */
    struct rmap_context context; /* of those that answer */
    int missing;                 /* the first that does not; 0: none */
    const char *host;            /* its host, the watchdog's; on rank 0 */
};

/* Rank 0: goes on without the ranks that are silent, of whom `missing` is the first, once all
 * others have done their part and heed. They must be through within `seconds`, or the run ends
 * there. */
enum rmap_status rmap_survivors_gather(const struct rmap_context *context, int missing,
                                       const char *host, double seconds,
                                       struct rmap_survivors *self,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Other ranks, often, while they wait: whether rank 0 goes on without somebody. */
enum rmap_status rmap_survivors_heed(const struct rmap_context *context,
                                     struct rmap_survivors *self,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif

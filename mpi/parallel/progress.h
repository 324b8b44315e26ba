/* SPDX-License-Identifier: MIT
 *
 * How far long work has come: one line kept up to date on a terminal; elsewhere a line with the
 * clock every 10 s, then more and more seldom, to one in a quarter of an hour; nothing with
 * --quiet. Rank 0 alone shows anything.
 */
#ifndef RMAP_PROGRESS_H
#define RMAP_PROGRESS_H

#include <stdbool.h>

#include <stdint.h>

#include "base/clock.h"
#include "base/grouped.h"
#include "base/status.h"
#include "mpi/parallel/context.h"

struct rmap_progress {
    const char *what; /* "rays" */
    uint64_t total;
    double begun, last; /* monotonic seconds */
    double interval;    /* between two lines; 0: shows nothing */
    bool terminal;
    bool shown;
    const struct rmap_at_hand *at_hand; /* who is told besides; NULL: nobody */
    double told;                        /* when */
};

void rmap_progress_init(struct rmap_progress *progress, const struct rmap_context *context,
                        const char *what, uint64_t total);
void rmap_progress_show(struct rmap_progress *progress, uint64_t done); /* cheap when not due */
void rmap_progress_fini(struct rmap_progress *progress);                /* ends a terminal's line */

#endif

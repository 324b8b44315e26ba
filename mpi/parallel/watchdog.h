/* SPDX-License-Identifier: MIT
 *
 * Telling of ranks that do not answer: stopped, or on a host that died. A thread of each rank says
 * to rank 0 that it lives, whatever its main thread computes or waits for; rank 0's tells on
 * standard error which ranks have been silent for long, and when they answer again.
 */
#ifndef RMAP_WATCHDOG_H
#define RMAP_WATCHDOG_H

#include <stdbool.h>

#include "base/status.h"
#include "mpi/parallel/context.h"

struct rmap_watchdog;

/* seconds until silence is reported, and those that a trace waits for silent ranks beyond its time
 * limit. A test shortens all times here by the factor RAYMAP_TEST_PACE. */
double rmap_watchdog_silence_s(void);
double rmap_watchdog_grace_s(void);

/* Collective. One for each run of the program. */
enum rmap_status rmap_watchdog_start(const struct rmap_context *context,
                                     struct rmap_watchdog **watchdog_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_watchdog_end(struct rmap_watchdog *watchdog); /* Collective. NULL is fine. */

/* This rank has done its part, and waits for the others; or no longer. NULL is fine. */
void rmap_watchdog_set_done(struct rmap_watchdog *watchdog, bool done);

/* Rank 0: the first silent rank, when there is one and all that are not silent have done their
 * part; else -1, as for NULL. *host_ret: its host, the watchdog's. */
int rmap_watchdog_missing(struct rmap_watchdog *watchdog, const char **host_ret);
bool rmap_watchdog_is_silent(struct rmap_watchdog *watchdog, int rank);

/* Rank 0: the run ends with RMAP_STOPPED when it still goes on after these seconds. */
void rmap_watchdog_end_in(struct rmap_watchdog *watchdog, double seconds);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Threads of one process that run the same function, while the caller goes on with its own work
 * (MPI, storing chunks) until they are done.
 */
#ifndef RMAP_WORKERS_H
#define RMAP_WORKERS_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_workers;

/* Starts n threads; each runs work(context, thread) once, thread in [0, n). */
enum rmap_status rmap_workers_start(int n, void (*work)(void *context, int thread), void *context,
                                    struct rmap_workers **workers_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

bool rmap_workers_done(const struct rmap_workers *workers); /* all have returned */
/* The same, as soon as they have, or after so many nanoseconds. */
bool rmap_workers_wait(struct rmap_workers *workers, int64_t most_ns);
void rmap_workers_join(struct rmap_workers *workers); /* waits, and releases */

/* Whether so many threads can be there at once, as of now: they are started, and end. */
bool rmap_workers_can_start(int n);

/* Cores that this process may use. */
int rmap_workers_available(void);

#endif

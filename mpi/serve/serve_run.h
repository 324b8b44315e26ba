/* SPDX-License-Identifier: MIT
 *
 * A server: requests of many clients, answered one after the other by all ranks.
 */
#ifndef RMAP_SERVE_RUN_H
#define RMAP_SERVE_RUN_H

#include <stdbool.h>
#include <stdint.h>

#include "mpi/command/command.h"

/* Which ways lead in; the same on every rank. */
struct rmap_serve_ways {
    const char *socket; /* path; NULL: none */
    bool http, lines;   /* lines: of standard input */
    uint16_t port;      /* of http; 0: a free one */
    bool browser;       /* is started with the address */
};

/* Collective. Until someone says quit, a signal comes, or, with no other way in, the input has
 * ended. RMAP_STOPPED: by a signal. */
enum rmap_status rmap_serve_run(const struct rmap_context *context, const char *path,
                                const struct rmap_serve_ways *ways,
                                struct rmap_error *err) RMAP_MUST_USE;

#endif

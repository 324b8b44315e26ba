/* SPDX-License-Identifier: MIT
 *
 * Requests as lines: from standard input, and of who connects to a Unix socket.
 */
#ifndef RMAP_SERVE_LINES_H
#define RMAP_SERVE_LINES_H

#include "mpi/serve/serve_queue.h"

struct rmap_serve_lines;

/* One client, of two descriptors, which stay the caller's. */
enum rmap_status rmap_serve_lines_start(struct rmap_serve_queue *queue, int in, int out,
                                        struct rmap_serve_lines **lines_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Everyone who connects to a socket that is made at the path, for the user alone. One that nobody
 * listens at any more is replaced. RMAP_USAGE: another server is there, or another file. */
enum rmap_status rmap_serve_socket_start(struct rmap_serve_queue *queue, const char *path,
                                         struct rmap_serve_lines **lines_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Whether the input has ended and all of it is answered. */
bool rmap_serve_lines_done(const struct rmap_serve_lines *lines);

/* Once the queue is closed. NULL is fine. */
void rmap_serve_lines_stop(struct rmap_serve_lines *lines);

#endif

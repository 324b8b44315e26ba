/* SPDX-License-Identifier: MIT
 *
 * Requests by HTTP on the loopback address, for who has the token.
 */
#ifndef RMAP_SERVE_HTTP_H
#define RMAP_SERVE_HTTP_H

#include <stdint.h>

#include "mpi/serve/serve_queue.h"

struct rmap_serve_http;

/* port 0: one that is free. RMAP_SYSTEM, RMAP_USAGE: another program has it. */
enum rmap_status rmap_serve_http_start(struct rmap_serve_queue *queue, uint16_t port,
                                       struct rmap_serve_http **http_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* "http://127.0.0.1:40123", "4c1f...". Borrowed. */
const char *rmap_serve_http_address(const struct rmap_serve_http *http);
const char *rmap_serve_http_token(const struct rmap_serve_http *http);

/* Once the queue is closed. NULL is fine. */
void rmap_serve_http_stop(struct rmap_serve_http *http);

#endif

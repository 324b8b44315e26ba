/* SPDX-License-Identifier: MIT
 *
 * Between those who bring requests, each in threads of its own, and the one thread that answers:
 * clients, their requests, and lines on their way to them. Requests are taken from one client after
 * the other.
 */
#ifndef RMAP_SERVE_QUEUE_H
#define RMAP_SERVE_QUEUE_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

struct rmap_serve_queue;
struct rmap_serve_client;

struct rmap_serve_request {
    struct rmap_serve_client *client; /* held until it is answered */
    json_t *message;                  /* an object with a `command` */
    void *state;                      /* of one that is answered in steps; the server's */
    _Atomic bool cancelled;
    struct rmap_serve_request *next;
};

enum rmap_status rmap_serve_queue_create(struct rmap_serve_queue **queue_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
/* Nobody waits any longer; clients are told to go. */
void rmap_serve_queue_close(struct rmap_serve_queue *queue);
/* Once all clients have left. */
void rmap_serve_queue_destroy(struct rmap_serve_queue *queue);

/* ---- for who brings requests */

/* group: clients of one number may cancel each other's requests; 0: each its own alone. watches:
 * gets events. NULL: too many, or no memory. */
struct rmap_serve_client *rmap_serve_client_join(struct rmap_serve_queue *queue, int group,
                                                 bool watches);
/* What it asked and has not been answered is cancelled. The client is gone. */
void rmap_serve_client_leave(struct rmap_serve_client *client);

/* A line of a client. What is no request is answered at once, as is `cancel`. */
void rmap_serve_client_ask(struct rmap_serve_client *client, const char *line, size_t nbytes);

/* The next line to the client, without its end; rmap_free. NULL: none within that time, or there
 * will be none (*over_ret). finished: so, too, once all that was asked is answered. */
char *rmap_serve_client_next(struct rmap_serve_client *client, int milliseconds, bool finished,
                             bool *over_ret);

/* ---- for who answers */

/* The next request, or NULL after that time. */
struct rmap_serve_request *rmap_serve_queue_next(struct rmap_serve_queue *queue, int milliseconds);

/* Sends a line about the request to who asked, or where clients have a group to those of it that
 * watch; takes the document over. */
void rmap_serve_tell(struct rmap_serve_request *request, json_t *document);

/* The same, and the request is done. */
void rmap_serve_answer(struct rmap_serve_request *request, json_t *document);

/* Not done yet: comes again when it is its client's turn, before what that has asked later. */
void rmap_serve_again(struct rmap_serve_request *request);

/* To all who watch; takes the document over. */
void rmap_serve_event(struct rmap_serve_queue *queue, json_t *document);

#endif

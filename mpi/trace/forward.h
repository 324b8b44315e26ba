/* SPDX-License-Identifier: MIT
 *
 * Few writers for many ranks: on each node the first ranks write shards, the others send them
 * their traced blocks. Memory is bounded on both sides: a block is sent only when the writer takes
 * it, and workers wait while too many wait to be sent.
 *
 * Workers put blocks in; MPI is called by one thread of each rank, which must call
 * rmap_forward_work often.
 */
#ifndef RMAP_FORWARD_H
#define RMAP_FORWARD_H

#include "mpi/command/command.h"
#include "mpi/parallel/message.h"

struct rmap_forward;

/* Collective. per_node: writers of a node, at most (0: every rank writes, *forward_ret is NULL).
 * The ranks of a node are dealt to its writers in turn. */
enum rmap_status rmap_forward_create(const struct rmap_context *context, uint64_t per_node,
                                     struct rmap_forward **forward_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_forward_destroy(struct rmap_forward *forward); /* Collective. NULL is fine. */

/* Whether this rank writes a shard. True for NULL. */
bool rmap_forward_writes(const struct rmap_forward *forward);

/* On a rank that does not write. Any thread: full says that a worker had better wait; put takes a
 * block over, also when it fails. */
bool rmap_forward_full(const struct rmap_forward *forward);
enum rmap_status rmap_forward_put(struct rmap_forward *forward, struct rmap_message *message,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* The MPI thread's part, which never waits. A sender: sends what waits; `last` says that no more
 * will be put. A writer: *message_ret is a block that came (owned by the caller), or NULL; while
 * `hold` is set no new one is begun. */
enum rmap_status rmap_forward_send(struct rmap_forward *forward, bool last,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_forward_receive(struct rmap_forward *forward, bool hold,
                                      struct rmap_message **message_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* A writer that failed takes what still comes, so that senders do not wait, and throws it away. It
 * needs no memory. */
enum rmap_status rmap_forward_discard(struct rmap_forward *forward,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* A sender: everything was taken, and the writer knows that nothing follows. A writer: every
 * sender has said so. True for NULL. */
bool rmap_forward_done(const struct rmap_forward *forward);

#endif

/* SPDX-License-Identifier: MIT
 *
 * A portion as one block of bytes that travels between ranks of one program.
 */
#ifndef RMAP_MESSAGE_H
#define RMAP_MESSAGE_H

#include <stdbool.h>

#include "portion/portion.h"

struct rmap_message {
    uint8_t *bytes;
    size_t nbytes;
};

/* Copies those columns of a portion, which has them. */
enum rmap_status rmap_message_pack(const struct rmap_portion *portion, rmap_column_set columns,
                                   struct rmap_message **message_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Room for bytes that are to come. */
enum rmap_status rmap_message_create(size_t nbytes, struct rmap_message **message_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_message_destroy(struct rmap_message *message); /* NULL is fine */

/* The portion, its columns lying in the message, the others NULL. RMAP_INTERNAL when the bytes are
 * none. */
enum rmap_status rmap_message_view(const struct rmap_message *message, struct rmap_portion *view,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif

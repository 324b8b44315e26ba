/* SPDX-License-Identifier: MIT
 *
 * Portions on their way to a shard: the rows of its encoding. Plain ones are the portion's own
 * columns, or copies of its parts'; compact ones are encoded outside the shard's lock and finished
 * under it.
 */
#ifndef RMAP_ROW_ENCODER_H
#define RMAP_ROW_ENCODER_H

#include "compact/compact.h"
#include "io/map/map_writer.h"

struct rmap_row_pool; /* of a shard: what its threads share */
struct rmap_row_slot; /* a portion in hand */

/* The run's scene is borrowed. RMAP_USAGE: this program does not write its encoding. */
enum rmap_status rmap_row_pool_create(const struct rmap_run *run, struct rmap_row_pool **pool_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_row_pool_destroy(struct rmap_row_pool *pool); /* no slot may be in hand */

/* A book for a new piece; NULL in encodings that have none. */
enum rmap_status rmap_row_pool_book(const struct rmap_row_pool *pool,
                                    struct rmap_path_book **book_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Outside every lock. The portion must stay until the slot is given back, on every path. */
enum rmap_status rmap_row_pool_encode(struct rmap_row_pool *pool,
                                      const struct rmap_portion *portion,
                                      struct rmap_row_slot **slot_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* The same in parts that need not stay, as rmap_compact_encode_part, where the pool takes them.
 * The slot is given back by the caller, on every path once there is one. */
bool rmap_row_pool_in_parts(const struct rmap_row_pool *pool);
enum rmap_status rmap_row_pool_begin(struct rmap_row_pool *pool, uint64_t first_ray,
                                     struct rmap_row_slot **slot_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_row_slot_part(struct rmap_row_slot *slot, const struct rmap_portion *part,
                                    bool *whole_ret, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_row_slot_end(struct rmap_row_slot *slot, bool *whole_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The slot's rows come in so many pieces, which follow each other. */
size_t rmap_row_slot_count(const struct rmap_row_slot *slot);

/* Piece i of them. Under the piece's lock, with its book. rows: borrowed until the slot is given
 * back. */
enum rmap_status rmap_row_slot_rows(struct rmap_row_slot *slot, struct rmap_path_book *book,
                                    size_t i, struct rmap_rows *rows,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_row_slot_give_back(struct rmap_row_slot *slot); /* NULL is fine */

#endif

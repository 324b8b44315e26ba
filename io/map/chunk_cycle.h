/* SPDX-License-Identifier: MIT
 *
 * Chunks that are elements in a cycle, as sources of rays are: one that has the stored bytes of
 * another need not be decoded to know. All memory is the struct's own; all zero is empty.
 */
#ifndef RMAP_CHUNK_CYCLE_H
#define RMAP_CHUNK_CYCLE_H

#include "io/map/map_reader.h"

/* Chunks with more stored bytes are not remembered; so many others are. */
enum { RMAP_CYCLE_STORED_MOST = 2048, RMAP_CYCLES_KNOWN = 4 };

struct rmap_cycle_chunk {
    uint8_t stored[RMAP_CYCLE_STORED_MOST];
    size_t nbytes, n_row;
    struct rmap_cycle cycle; /* that was asked about, from its first row on */
    bool follows;
};

struct rmap_cycle_chunks {
    struct rmap_cycle_chunk chunk[RMAP_CYCLES_KNOWN]; /* a ring */
    size_t n;                                         /* ever */
};

/* Same elements at the same address, same phase. */
bool rmap_cycle_is(const struct rmap_cycle *a, const struct rmap_cycle *b);

/* What is remembered of a chunk with these stored bytes and rows; NULL: nothing. */
struct rmap_cycle_chunk *rmap_cycle_chunks_find(struct rmap_cycle_chunks *chunks,
                                                const uint8_t *stored, size_t nbytes, size_t n_row,
                                                const struct rmap_cycle *cycle);

/* Remembers it, with `follows` false. nbytes <= RMAP_CYCLE_STORED_MOST. */
struct rmap_cycle_chunk *rmap_cycle_chunks_add(struct rmap_cycle_chunks *chunks,
                                               const uint8_t *stored, size_t nbytes, size_t n_row,
                                               const struct rmap_cycle *cycle);

/* *follows_ret: the first n_row elements of the planes [n_lead][stride], of which those behind
 * n_lead are 0, follow the cycle. RMAP_SYSTEM. */
enum rmap_status rmap_cycle_compare(const struct rmap_cycle *cycle, size_t element_nbytes,
                                    const uint8_t *plane, size_t stride, size_t n_lead,
                                    size_t n_row, bool *follows_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif

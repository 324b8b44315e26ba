/* SPDX-License-Identifier: MIT
 *
 * Verifying a map: its files, the tables of its pieces against the index, every stored chunk, every
 * ray, the sums. Each step may be done for any part of the map by any process: what they find comes
 * together as findings and flags. A step returns a failure only when it could not be done (memory);
 * what is wrong with the map is a finding.
 */
#ifndef RMAP_VERIFY_H
#define RMAP_VERIFY_H

#include <pthread.h>

#include "io/file/findings.h"
#include "io/map/map_content.h"
#include "io/map/map_directory.h"
#include "trace/tally.h"

enum rmap_piece_flag {
    RMAP_PIECE_GONE = 1, /* missing or another piece: none of it is usable */
    RMAP_PIECE_TORN = 2  /* cut off, or damaged outside its chunks: these are found through the
                            index alone */
};

enum rmap_portion_flag {
    RMAP_PORTION_UNSURE = 1, /* index and piece tell different things of it */
    RMAP_PORTION_LOST = 2    /* its rays cannot be read right */
};

struct rmap_verification {
    char *path;
    struct rmap_map *map;                   /* NULL: the index is unusable */
    const struct rmap_map_content *content; /* what is verified: the index's, or what pieces say */
    const struct rmap_map_content *claimed; /* what the index says, as far as it can be read */
    struct rmap_map_content disk, raw;      /* hold these without a map */
    uint8_t *mode;                          /* [content->n_piece] enum rmap_colour_mode */
    pthread_mutex_t lock;                   /* of the flags */
    uint8_t *piece_flag;                    /* [content->n_piece] enum rmap_piece_flag */
    uint8_t *portion_flag;                  /* [content->n_portion] enum rmap_portion_flag */
    /* [n_owner] pieces that have chunks, in the order of these. */
    struct rmap_chunk_owner {
        uint64_t first_chunk;
        size_t piece;
    } * owner;
    size_t n_owner;
};

/* Opens a map, damaged or not. Findings: what of the index does not hold, files that are missing or
 * that it does not know. RMAP_INPUT, RMAP_SYSTEM; RMAP_FORMAT when it is no map at all. */
enum rmap_status rmap_verification_open(const char *path, struct rmap_verification **self_ret,
                                        struct rmap_findings *findings,
                                        struct rmap_error *err) RMAP_MUST_USE;
void rmap_verification_close(struct rmap_verification *self);

/* Rays of all portions of a piece of a content. */
void rmap_finding_add_piece(struct rmap_finding *finding, const struct rmap_map_content *content,
                            size_t piece);
void rmap_finding_add_portion(struct rmap_finding *finding,
                              const struct rmap_portion_info *portion);

/* Sets flags of a piece, of a portion. Any thread. */
void rmap_verification_flag_piece(struct rmap_verification *self, size_t piece, int flag);
void rmap_verification_flag_portion(struct rmap_verification *self, size_t portion, int flag);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Writing a ray map: shards of pieces, one writer per shard, and the index.
 *
 * Workers append traced blocks and encode full chunks; one thread (the one that talks MPI)
 * stores encoded chunks. Only the append is synchronised.
 */
#ifndef RMAP_MAP_WRITER_H
#define RMAP_MAP_WRITER_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "compact/layout.h"
#include "io/map/map_reader.h"
#include "io/map/selection.h"
#include "io/mesh/bundle.h"
#include "portion/portion.h"
#include "trace/tally.h"

struct rmap_map_lock;

/* What every file of a map says about the run. Borrowed by the writers. */
struct rmap_run {
    const struct rmap_bundle *bundle;
    const struct rmap_scene *scene;
    uint64_t seed;
    int n_rank;
    enum rmap_encoding encoding;
    int32_t space;                          /* colour space: row of the map's spaces */
    const char *isa;                        /* instruction set that decides ties */
    const char *embree_version;             /* or NULL */
    int32_t tracer_revision;                /* that made the rays; 0: this program's */
    const struct rmap_selection *selection; /* of rays that a query picked; NULL: as traced */
};

/* Makes the directory NAME.raymap. RMAP_USAGE when it exists (and force is false; force removes a
 * ray map that stands there, and nothing else), RMAP_SYSTEM when it cannot be made. The caller
 * has the lock from here on, if not before, and releases it; `command` as in io/map/map_lock.h.
 * NULL: for whoever has the map to himself. */
enum rmap_status rmap_map_create(const char *path, bool force, const char *command,
                                 struct rmap_map_lock *lock, struct rmap_error *err) RMAP_MUST_USE;

/* Takes a map away again whose making failed; what is no part of a map stays, and is an error. */
enum rmap_status rmap_map_remove(const char *path, struct rmap_error *err) RMAP_MUST_USE;

struct rmap_shard_writer;

/* Rays are flushed this often unless told otherwise: a kill costs what was traced since. */
#define RMAP_FLUSH_SECONDS 10.0

struct rmap_shard_options {
    /* A piece is closed once it holds that much before compression, so that where it ends does not
     * hang on which chunk was encoded when. 0: 512 MiB, about 256 MiB stored. */
    size_t piece_nbytes;
    /* What was appended is made safe when either has passed since the last time; 0: not by this.
     * With flush_seconds the first time comes after one second at most. */
    double flush_seconds;
    uint64_t flush_portions;
    /* Where the pieces belong, borrowed for the call; NULL: found from the run. */
    const struct rmap_piece_origin *origin;
    /* Number of the first piece, where others of the shard are known; 0: behind those that its
     * folder has. One that is taken after all is passed over. */
    int first_piece;
};

/* directory: the map's, or another that exists, say on a disk of the node; shard-RRRRR is made in
 * it. options: NULL for 512 MiB and RMAP_FLUSH_SECONDS. run is copied, what it points to borrowed.
 */
enum rmap_status rmap_shard_writer_create(const char *directory, int shard,
                                          const struct rmap_run *run,
                                          const struct rmap_shard_options *options,
                                          struct rmap_shard_writer **writer_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Copies a block's rows to the shard's column buffers. Thread-safe; any thread. */
enum rmap_status rmap_shard_writer_append(struct rmap_shard_writer *writer,
                                          const struct rmap_portion *portion,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* A block that is appended in parts of up to RMAP_PART_RAYS rays, which need not stay: each is
 * taken while it is in a cache. One per thread; the writer is borrowed. NULL: this shard takes
 * whole blocks alone. RMAP_SYSTEM: memory. */
struct rmap_shard_block;
enum rmap_status rmap_shard_block_create(struct rmap_shard_writer *writer,
                                         struct rmap_shard_block **block_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_shard_block_destroy(struct rmap_shard_block *block);

/* In the order of the ids, which are consecutive. *whole_ret: nothing of the block has been
 * appended, and it must be by rmap_shard_writer_append. The block is empty then, and on failure. */
enum rmap_status rmap_shard_block_add(struct rmap_shard_block *block,
                                      const struct rmap_portion *part, bool *whole_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Appends the parts added so far as one portion, if any were; the block is empty then. */
enum rmap_status rmap_shard_block_append(struct rmap_shard_block *block, bool *whole_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Encodes one full chunk if there is one; *did_ret says whether. Thread-safe; any thread. */
enum rmap_status rmap_shard_writer_encode(struct rmap_shard_writer *writer, bool *did_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* Stores the chunks encoded so far, and flushes when it is time. The writing thread alone. */
enum rmap_status rmap_shard_writer_store(struct rmap_shard_writer *writer,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Bytes waiting to be encoded or stored: workers help out rather than run ahead. Any thread. */
size_t rmap_shard_writer_backlog(const struct rmap_shard_writer *writer);

/* Makes safe all that was appended before the call, helping to encode and waiting for the threads
 * that do. The writing thread alone. */
enum rmap_status rmap_shard_writer_flush(struct rmap_shard_writer *writer,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Nothing more will be appended: buffers are handed over as they are, for any thread to encode.
 * One thread, after the last append; nothing to do is fine. */
enum rmap_status rmap_shard_writer_end(struct rmap_shard_writer *writer,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Flushes, publishes the last piece, and closes. The writing thread, after all others are done. */
enum rmap_status rmap_shard_writer_finish(struct rmap_shard_writer *writer,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* How often it was flushed. The writing thread alone. */
uint64_t rmap_shard_writer_flushes(const struct rmap_shard_writer *writer);

/* The pieces published so far, for the index; borrowed. The writing thread alone. */
const struct rmap_map_content *rmap_shard_writer_content(const struct rmap_shard_writer *writer);

/* Drops what is unfinished and was never flushed; what was flushed stays for the map's reader. */
void rmap_shard_writer_destroy(struct rmap_shard_writer *writer);

/* What map.h5 is made of; all borrowed. */
struct rmap_index {
    const struct rmap_run *run;     /* that writes it */
    const struct rmap_map *before;  /* the map as it was, whose spaces and rows of /run stay; NULL:
                                       a new map */
    const struct rmap_run_row *row; /* this run's, to be added to /run; NULL: none */
    const struct rmap_map_content *content; /* of the map, in any order (open pieces are left out);
                                               NULL: none yet */
    const struct rmap_tally *tally;         /* of the content's rays; NULL: of none */
    bool complete;                          /* every ray asked for is there */
};

/* Writes map.h5, over an old one if there is one: at the start of a trace (incomplete, without
 * pieces), so that what a killed trace leaves is a map, and at its end. run->space must be the
 * number that rmap_map_admit gave (0 in a new map). RMAP_FORMAT: pieces share some rays. */
enum rmap_status rmap_index_write_content(const char *map_path, const struct rmap_index *index,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* The same for a map of one run, from the shards that stand in the map's directory and the merged
 * tally: for those who have no content at hand. Reads every piece's tables. RMAP_FORMAT also when
 * one is damaged or foreign. */
enum rmap_status rmap_index_write(const char *map_path, const struct rmap_run *run,
                                  const struct rmap_tally *tally, bool complete,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Whether a run may add rays to a map: same scene, seed and instruction set. RMAP_INPUT says what
 * differs. *space_ret: number of the run's colour space in the map, for run->space; one more than
 * the map has if it is new. */
enum rmap_status rmap_map_admit(const struct rmap_map *map, const struct rmap_run *run,
                                int32_t *space_ret, struct rmap_error *err) RMAP_MUST_USE;

#endif

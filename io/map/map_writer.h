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
    const char *parent;                     /* digest of the map that rays were taken over from;
                                               NULL or "": none were */
    const struct rmap_selection *selection; /* of rays that a query picked; NULL: as traced */
};

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

/* A block that is appended in parts of up to RMAP_PART_RAYS rays, which need not stay: each is
 * taken while it is in a cache. One per thread; the writer is borrowed. NULL: this shard takes
 * whole blocks alone. RMAP_SYSTEM: memory. */
struct rmap_shard_block;

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

#endif

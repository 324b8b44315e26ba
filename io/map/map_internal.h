/* SPDX-License-Identifier: MIT
 *
 * An open map, for the files that make up its reader.
 */
#ifndef RMAP_MAP_INTERNAL_H
#define RMAP_MAP_INTERNAL_H

#include <pthread.h>
#include <stdatomic.h>

#include "compact/compact.h"
#include "io/map/column_store.h"
#include "io/map/map_directory.h"
#include "io/map/map_scan.h"
#include "io/map/selection.h"

/* Chunks of one piece per stream, in order; put in order and checked when first needed. */
struct rmap_piece_chunks {
    bool loaded;
    const struct rmap_chunk_entry *entry; /* of the content, by stream */
    size_t first[RMAP_STREAM_MAX + 1];    /* stream s has entries [first[s], first[s + 1]) */
};

/* Paths of a compact piece, while they are kept. */
struct rmap_kept_paths {
    struct rmap_path_table *table[2]; /* heads alone, whole; NULL: not now */
    uint64_t stored_nbytes[2];        /* in the file */
    size_t n_user, nbytes;
    uint64_t tick;                /* when they were asked for last */
    bool names_nothing;           /* some value of them is none of the scene's */
    bool knows_sums[2];           /* without lengths, with them */
    struct rmap_path_sum *sum[2]; /* [its paths], NULL: the piece does not say */
};

void rmap_kept_paths_fini(struct rmap_kept_paths *kept); /* map_paths.c */

struct rmap_map {
    char *path;
    struct rmap_map_content content;
    struct rmap_map_summary summary;
    uint64_t index_nbytes;
    struct rmap_bundle *bundle;
    char scene_digest[33];
    struct rmap_map_spaces spaces;
    struct rmap_scene **scene; /* [spaces.n] */
    int n_channel_max;         /* of all colour spaces */
    struct rmap_run_row *run;  /* [n_run] */
    size_t n_run;
    uint64_t n_asked; /* rays of the runs, each once */
    char **trouble;   /* [n_trouble] */
    size_t n_trouble, cap_trouble;
    bool takes_cut; /* pieces that were cut off are read as far as they go */
    struct rmap_tally *tally;
    struct rmap_selection *selection; /* or NULL */
    double *flux_per_weight;          /* [n_source] */
    double *dim, maintenance;         /* map_dim.h: [n_source], NULL: nothing is dimmed */

    pthread_mutex_t lock;              /* of chunks and models */
    struct rmap_piece_chunks *chunks;  /* [n_piece] */
    struct rmap_compact_model **model; /* [spaces.n] */
    pthread_mutex_t paths_lock;        /* taken before `lock` */
    struct rmap_kept_paths *paths;     /* [n_piece] */
    size_t paths_nbytes, paths_budget; /* of all of them; RMAP_PATHS_NBYTES */
    uint64_t paths_tick;
    _Atomic int n_reader;            /* chunk readers that are there; they share the bytes */
    struct rmap_column_store *store; /* NULL: nothing is kept */
    pthread_mutex_t hdf5_lock;       /* of files that are opened late; taken after all others */
    struct rmap_column_files *_Atomic column_files; /* beside pieces; NULL: none looked for yet */
    struct rmap_kept_rays *kept_rays;               /* what criteria of its scenes may name */
    struct rmap_portion **held; /* [n_portion] in memory (map_held.h); NULL: it lies on disk */
    size_t held_nbytes;         /* of them */
    struct rmap_held_elsewhere *held_elsewhere; /* what brings those of other ranks */
    unsigned n_lent;                            /* users beside the first (rmap_map_lend) */
};

/* How many runs `later` knows of beyond all those of `map`, which is 0 if it does not know these,
 * too: that many began after map's index was written. */
size_t rmap_map_n_run_after(const struct rmap_map *map, const struct rmap_map *later);

/* Takes note of what rmap_map_trouble tells. */
enum rmap_status rmap_map_note_trouble(struct rmap_map *map, const char *text,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Adds to the content of an incomplete map what stands beside its index: what a listing says that
 * is as good as new, as no writer is at work; NULL: what is found now. Nothing of that is fatal but
 * RMAP_SYSTEM; of blocks that share some rays one is left out. */
enum rmap_status rmap_map_add_found(struct rmap_map *map, const struct rmap_map_listing *given,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Lets go what was read of the content, which is about to change. */
void rmap_map_forget(struct rmap_map *map);

/* Sums over the content, once it is whole; flux per weight, from the tally. */
enum rmap_status rmap_map_sum_up(struct rmap_map *map, struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_derive_flux(struct rmap_map *map);

#endif

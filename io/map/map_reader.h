/* SPDX-License-Identifier: MIT
 *
 * Reading a ray map. Opening reads the index alone; columns are read portion by portion through
 * a cursor, one per thread, with pread and our own inflate, never through HDF5's global lock.
 */
#ifndef RMAP_MAP_READER_H
#define RMAP_MAP_READER_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "compact/layout.h"
#include "io/mesh/bundle.h"
#include "portion/portion.h"

struct rmap_map;
struct rmap_selection;   /* io/map/selection.h */
struct rmap_map_content; /* io/map/map_content.h */
struct rmap_map_listing; /* io/map/map_directory.h */

struct rmap_portion_info {
    int32_t shard, piece; /* piece: index in rmap_map_piece */
    int32_t space;        /* colour space, as its piece has it */
    int32_t is_added;     /* 1: not in the index, found beside it; not in its tally either */
    uint64_t first_ray;
    uint64_t last_ray;                /* of a portion with gaps; else it may be anything below */
    uint64_t n_row[RMAP_TABLE_COUNT]; /* of the columns */
    /* Where it stands in the stored tables of the piece's layout; 0 behind the last of them. */
    uint64_t stored_first[RMAP_STORED_TABLE_MAX];
    uint64_t stored_rows[RMAP_STORED_TABLE_MAX];
    struct rmap_digest digest;
    struct rmap_portion_summary summary;
    /* Of this portion and all before it in the map: rays and segments, largest rmap_portion_end. */
    uint64_t work, reach;
};

/* Ids of a portion ascend. In a traced one they are consecutive; one that a query picked may have
 * gaps: then id i is not first_ray + i, and other portions may have rays in between. */
bool rmap_portion_has_gaps(const struct rmap_portion_info *portion);
uint64_t rmap_portion_end(const struct rmap_portion_info *portion); /* behind the last id */

struct rmap_piece_info {
    int32_t shard, number;
    char name[288];   /* "shard-00000/piece-00000.h5"; of a journal's piece, its .part file */
    uint64_t nbytes;  /* of the file; a journal's piece may have grown since */
    int32_t encoding; /* enum rmap_encoding */
    int32_t space;    /* colour space: row of the map's spaces */
    int32_t is_open;  /* 1: unfinished, known by its journal */
    uint64_t n_row[RMAP_TABLE_COUNT];            /* of the columns, summed over its portions */
    uint64_t stored_rows[RMAP_STORED_TABLE_MAX]; /* in the stored tables of its layout */
    uint64_t first_chunk, n_chunk;               /* rows of the map's chunks */
};

/* A trace that wrote to the map: which rays it was asked for. */
struct rmap_run_row {
    uint64_t first_ray, n_ray;
    uint64_t seed;
    int32_t space; /* colour space */
    int32_t n_rank;
};

/* Of a map whose index says that it is complete, the index alone is believed. Otherwise pieces on
 * disk that the index does not list, and what the journals of unfinished pieces commit, are part of
 * the map, too (their portions have is_added set): a killed or running trace. Portions that hold
 * the same rays count once. Of the added ones the tally is made from their columns, which reads
 * them: rmap_map_open_untallied leaves that to the caller, so that its tally and flux per weight
 * are those of the index. What cannot be used of them is left out and reported by rmap_map_trouble.
 *
 * RMAP_INPUT: nothing there; RMAP_FORMAT: no map, a damaged or too new one (says which file and
 * what to do); RMAP_SYSTEM: no permission, no memory. */
enum rmap_status rmap_map_open(const char *path, struct rmap_map **map_ret,
                               struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_map_open_untallied(const char *path, struct rmap_map **map_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
/* The same for who writes to the map, alone: what stands beside the index was found already. */
enum rmap_status rmap_map_open_found(const char *path, const struct rmap_map_listing *found,
                                     struct rmap_map **map_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
/* What the index lists and nothing beside it, complete or not. */
enum rmap_status rmap_map_open_listed(const char *path, struct rmap_map **map_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
/* The scene, spaces and runs that an index file of the map states ("map.h5"), with nothing of its
 * content and no sums: for making it again, or for who gets these from another process. */
enum rmap_status rmap_map_open_bare(const char *path, const char *name, struct rmap_map **map_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
void rmap_map_close(struct rmap_map *map);

/* The same map for one more user, who closes it, too. Of one thread. */
struct rmap_map *rmap_map_lend(struct rmap_map *map);

/* What was wrong with pieces and journals beside an incomplete index: one line each. Borrowed. */
size_t rmap_map_n_trouble(const struct rmap_map *map);
const char *rmap_map_trouble(const struct rmap_map *map, size_t i);

/* Compares a map with its directory, and adds a line of trouble for every piece that is missing,
 * has not its size, or is not in the index of a complete map. Opens none of them. RMAP_SYSTEM. */
enum rmap_status rmap_map_compare_directory(struct rmap_map *map,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* All borrowed until close. */
const struct rmap_scene *rmap_map_scene(const struct rmap_map *map); /* in colour space 0 */
size_t rmap_map_n_space(const struct rmap_map *map);
/* In another colour space: objects, media, sources and detectors are the same. */
const struct rmap_scene *rmap_map_scene_of(const struct rmap_map *map, size_t space);
/* What chooses that space: a bundle with options and nothing else; the caller destroys it. */
/* Portions that may hold the ray, the last one first: *portion is the number of portions, or what
 * the call before gave. False: there is none left. More than one only where portions have gaps. */
bool rmap_map_find_ray(const struct rmap_map *map, uint64_t ray, size_t *portion);
/* Space of the first of them; 0 when there is none. */
size_t rmap_map_space_of_ray(const struct rmap_map *map, uint64_t ray);
int rmap_map_n_channel(const struct rmap_map *map); /* of the space that has most */
size_t rmap_map_n_run(const struct rmap_map *map);
const struct rmap_run_row *rmap_map_run(const struct rmap_map *map, size_t run); /* oldest first */
const struct rmap_map_content *rmap_map_contents(const struct rmap_map *map);
const struct rmap_bundle *rmap_map_bundle(const struct rmap_map *map);
const struct rmap_tally *rmap_map_tally(const struct rmap_map *map); /* balance and images */
/* What picked the map's rays; NULL: they are as they were traced. */
const struct rmap_selection *rmap_map_selection(const struct rmap_map *map);
/* Rays that the flux of each source is shared out over [n_source]: those in the map, or of a map of
 * picked rays those of the map that was traced. */
const double *rmap_map_emitted(const struct rmap_map *map);
size_t rmap_map_n_portion(const struct rmap_map *map);
const struct rmap_portion_info *rmap_map_portion(const struct rmap_map *map, size_t portion);
size_t rmap_map_n_piece(const struct rmap_map *map);
const struct rmap_piece_info *rmap_map_piece(const struct rmap_map *map, size_t piece);

struct rmap_map_summary {
    uint64_t n_row[RMAP_TABLE_COUNT];
    uint64_t nbytes; /* on disk, index included */
    uint64_t seed;
    int n_rank, n_shard;
    bool complete;
    struct rmap_digest digest;
    char program_version[64], git_revision[64], isa[32], hdf5_version[32], embree_version[32];
    int32_t tracer_revision; /* src/trace/tracer_revision.h */
    char parent[33];         /* digest of the map that rays were taken over from; "": none were */
};
void rmap_map_summarise(const struct rmap_map *map, struct rmap_map_summary *summary);

/* Flux that one unit of weight stands for, per source: Phi_s / N_s; 0 where N_s = 0. [n_source] */
const double *rmap_map_flux_per_weight(const struct rmap_map *map);

/* Flux of rays of one source that weigh so much together; of all of them exactly the source's. */
double rmap_map_flux(const struct rmap_map *map, size_t source, double weight);

/* Portions are in the order of their first ray id.
 *
 * Splitting a scan: part `part` of n_part holds portions [split(part), split(part + 1)), about the
 * same number of segments each; split(n_part) is the number of portions. Two neighbouring parts
 * decode at most two chunks per column and shard twice, so a part should be long:
 * RMAP_PART_PORTIONS portions or more (a chunk of /ray is 16 of them). Give whole parts to threads.
 */
#define RMAP_PART_PORTIONS 64
size_t rmap_map_split(const struct rmap_map *map, size_t n_part, size_t part);

struct rmap_cursor;
struct rmap_step_classes;

/* A portion by the paths of its rays: those that refer to the same one are alike in
 * RMAP_COLUMNS_DISCRETE. All borrowed until the cursor takes another portion in hand. */
struct rmap_path_summary {
    const struct rmap_portion *paths; /* the piece's paths as rays, with those columns; NULL: the
                                         portion is not summed up so */
    const uint32_t *first_segment, *first_registration; /* [its rays] of each one's rows */
    const uint32_t *path;                    /* [n_ray] 1 + row of `paths`; 0: one of its own */
    size_t n_own;                            /* rays with such */
    size_t n_own_segment;                    /* theirs */
    const struct rmap_step_classes *classes; /* of the piece's steps; NULL: theirs are not stored */
};

#endif

/* SPDX-License-Identifier: MIT
 *
 * Classes of paths over a whole map, as a fold (fold.h). As long as there are no more classes than
 * `most_classes`, all are counted exactly. Beyond, the fold ends with a sketch of how many rays
 * each path had; folded again with that sketch, it counts exactly those of which the sketch says
 * that they may have `least` rays. Either way the totals are exact.
 */
#ifndef RMAP_PATH_COUNT_H
#define RMAP_PATH_COUNT_H

#include "analysis/paths/path_dictionary.h"
#include "analysis/paths/path_key.h"
#include "analysis/paths/path_sketch.h"
#include "analysis/query/fold.h"
#include "analysis/query/query.h"

/* Numbers of a class's entry. */
enum {
    RMAP_PATH_CLASS_RAYS,
    RMAP_PATH_CLASS_FIRST_RAY, /* the smallest id */
    RMAP_PATH_CLASS_SEGMENTS,
    RMAP_PATH_CLASS_REGISTRATIONS,
    RMAP_PATH_CLASS_TIME, /* sum of weight x time, two's complement of 128 bits, the low ones first:
                             whole numbers, so that the order is no matter */
    RMAP_PATH_CLASS_TIME_HIGH
};

/* Mean arrival time of a class, ns, weighted by flux: of its registrations where paths end at a
 * detector, else of its rays' ends. */
double rmap_path_class_time(const struct rmap_key_sum *sum);

/* An entry of cells: what of a class was registered in a cell; a ray's registrations in it are one
 * contribution. */
struct rmap_path_cell {
    uint64_t class_low; /* of the class's key */
    int32_t detector;
    uint32_t cell; /* i + j * cells[0] */
};
struct rmap_path_cell rmap_path_cell_of(const struct rmap_key_sum *entry);

/* Context of the fold: all borrowed. */
struct rmap_path_counting {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay;    /* NULL: none */
    const struct rmap_path_keys *keys;     /* of rmap_scene_with(map, overlay) */
    int32_t detector;                      /* registrations on it alone count; -1: on any */
    size_t most_classes, most_cells;       /* 0 cells: none are wanted */
    const struct rmap_path_sketch *sketch; /* NULL: count all */
    const uint32_t *least;                 /* [n_source] with a sketch */
    const struct rmap_key_sums *chosen;    /* NULL, or keys of the only classes that count */
    bool timed;                            /* mean times are wanted, which the map has */
};

/* State of the fold. */
struct rmap_path_counts {
    struct rmap_count total; /* of all rays that have a path; portions and bytes are 0 */
    struct {
        uint64_t rays, segments;
    } again;            /* further paths of rays that have several */
    double most_weight; /* of a ray */
    struct rmap_key_sums classes, cells;
    bool is_full, cells_full;       /* more than `most`: without entries then */
    struct rmap_path_sketch sketch; /* when is_full without a sketch to begin with */
    const struct rmap_path_counting *context;
    /* Of the portion in hand. */
    struct rmap_path_dictionary dictionary;
    rmap_path_step *step;
    struct rmap_key *of_ray; /* keys of a ray's paths so far */
    size_t step_cap, of_ray_cap;
};

/* The fold is to defer them all: paths may make them unnecessary. */
rmap_column_set rmap_path_count_columns(const struct rmap_path_counting *context);
extern const struct rmap_fold_kind rmap_path_count_kind;

#endif

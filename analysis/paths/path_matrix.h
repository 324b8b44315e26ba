/* SPDX-License-Identifier: MIT
 *
 * What detectors registered, by how the light came there: by ghost and scatter order
 * (path_order.h), by the pair of surfaces that made a ghost, by source and object. A fold (fold.h);
 * sums over registrations, a ray's several ones in one place being one contribution.
 *
 * Objects count that were met before the detector; not that on which it lies.
 */
#ifndef RMAP_PATH_MATRIX_H
#define RMAP_PATH_MATRIX_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/criterion/path_order.h"
#include "analysis/paths/path_key.h"
#include "analysis/query/fold.h"
#include "analysis/table/key_sums.h"

/* What a sum is of, and what its two numbers are. */
enum rmap_path_part {
    RMAP_PATH_ALL,    /* all light: 0, 0 */
    RMAP_PATH_STRAY,  /* light of any order but 0, 0 */
    RMAP_PATH_ORDERS, /* ghost order, scatter order; from RMAP_PATH_ORDER_MOST on as that */
    RMAP_PATH_GHOSTS, /* labels of the first and second reflection; ghost order 2, scatter order 0
                       */
    RMAP_PATH_LAST,   /* 1 + label of the last object met, or 0 for none */
    RMAP_PATH_MET,    /* 1 + label of each object met */
    RMAP_PATH_PART_COUNT
};
#define RMAP_PATH_PART_BIT(part) (1u << (part))
enum { RMAP_PATH_ORDER_MOST = 9 };

/* Sums that are kept at most, per thread: 64 MiB. More are refused: RMAP_SYSTEM. */
#define RMAP_PATH_MATRIX_MOST ((size_t)3 << 18)

/* Context of the fold: all borrowed. */
struct rmap_path_matrix {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay; /* NULL: none */
    const struct rmap_path_keys *keys;  /* whose labels count */
    const struct rmap_path_order *order;
    const char *criterion; /* that picked the rays; NULL: none did */
    int32_t detector;      /* -1: each */
    unsigned parts;        /* bits: ORDERS, GHOSTS, MET (which brings LAST); ALL and STRAY always */
};

/* The state is a struct rmap_path_matrix_sums. */
struct rmap_path_matrix_sums {
    const struct rmap_path_matrix *context;
    struct rmap_key_sums sums;
    uint64_t *met; /* [n_label] number of the last registration that had met it */
    uint64_t n_registration;
};
extern const struct rmap_fold_kind rmap_path_matrix_kind;
rmap_column_set rmap_path_matrix_columns(const struct rmap_path_matrix *matrix);

/* A sum over sources, or of one source where the part tells them apart. */
struct rmap_path_cellsum {
    enum rmap_path_part part;
    int32_t detector, source; /* source: -1 but of LAST and MET */
    uint32_t a, b;
    uint64_t rays;
    double flux, standard_error;
};

/* Sorted by part, detector, then most flux first, then source, a, b; ORDERS by a and b. rmap_free.
 */
enum rmap_status rmap_path_matrix_list(const struct rmap_path_matrix_sums *sums,
                                       struct rmap_path_cellsum **list_ret, size_t *n_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* For people: at most `top` rows of a ranking. */
/* Sets "orders", "ghosts" and "contribution" as asked for. */

#endif

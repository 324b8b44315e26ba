/* SPDX-License-Identifier: MIT
 *
 * A scan of a fold, for the files that do it.
 */
#ifndef RMAP_FOLD_INTERNAL_H
#define RMAP_FOLD_INTERNAL_H

#include "analysis/query/crossing.h"
#include "analysis/query/fold.h"

struct rmap_fold_scanner {
    const struct rmap_fold *fold;
    struct rmap_query_marker *marker; /* NULL: all rays match, or receivers are laid over the map */
    struct rmap_cursor *cursor;       /* NULL: the marker reads */
    struct rmap_overlay_view *view;   /* NULL: no receivers */
    uint8_t *match;                   /* [n_match] */
    size_t n_match;
    struct rmap_crossing_filter crossing; /* of the only detector */
    const struct rmap_which *which;       /* NULL: all registrations count */
    uint8_t *chosen, *open;               /* [registrations of the portion] as rmap_which_bound */
    size_t chosen_cap, open_cap;
    /* Columns of the portion in hand that tell of those which choosing reads; 0: it has these. */
    rmap_column_set bounding;
    bool narrows;        /* rays that arrive are enough, and their places and paths; */
    bool is_narrow;      /* the portion in hand is these */
    const uint32_t *row; /* [rays of the portion] which of its rays they are; NULL: all */
    uint8_t *unsure; /* [unsure_cap] rays with open registrations; rmap_matched.match of a portion
                        that was read whole after a selection */
    uint8_t *exact;  /* [exact_cap] of registrations of rays that were traced again: chosen */
    size_t unsure_cap, exact_cap;
};

/* Columns that the portion needs, whatever else decides which rays match. */
rmap_column_set rmap_fold_columns(const struct rmap_fold *fold);

/* Columns of the portion in hand; and its cursor, entered. */
enum rmap_status rmap_fold_read(struct rmap_fold_scanner *self, rmap_column_set columns,
                                const struct rmap_portion **portion_ret,
                                struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_fold_enter(struct rmap_fold_scanner *self, struct rmap_cursor **cursor_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* The registrations of the portion that count: rays->chosen. */
enum rmap_status rmap_fold_choose(struct rmap_fold_scanner *self, struct rmap_matched *rays,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

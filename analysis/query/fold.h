/* SPDX-License-Identifier: MIT
 *
 * One sum over the rays of a map that match: portions are added to states, one per thread, states
 * are merged, and the whole is what a command shows. What a sum is, its kind says
 * (struct rmap_fold_kind); histograms, moments, classes of paths, images are kinds.
 *
 * The same answer for any number of ranks and threads: adding and merging must give the same bits
 * in any order. Sums of weights do (whole numbers in double); sums of other numbers go through
 * base/exact_sum.h.
 */
#ifndef RMAP_FOLD_H
#define RMAP_FOLD_H

#include "analysis/criterion/criterion.h"
#include "analysis/overlay/overlay.h"
#include "analysis/query/fold_blocks.h"
#include "analysis/query/which.h"
#include "compact/path_sum.h"
#include "io/map/map_reader.h"

struct rmap_fold_scanner;

/* The matching rays of a portion. */
struct rmap_matched {
    const struct rmap_portion *portion; /* has the fold's columns */
    const uint8_t *match;               /* [rays of the portion] 1 or 0; NULL: all match */
    size_t n_match;
    const uint8_t *chosen; /* [registrations of the portion] 1: it counts; NULL: those that were
                              registered do */
    size_t index;          /* portion of the map */
    size_t space;          /* colour space: the portion has its channels */
    struct rmap_fold_scanner *scanner; /* that reads the portion; NULL: it has all it may have */
};

/* [registrations of the portion] not 0: it is to be counted, where its ray matches. */
static inline const uint8_t *rmap_registrations_counted(const struct rmap_matched *rays)
{
    return rays->chosen ? rays->chosen : rays->portion->registration.registered;
}

/* Makes sure that the portion has deferred columns of the fold, too. */
enum rmap_status rmap_fold_fetch(const struct rmap_matched *rays, rmap_column_set columns,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* *are_one_ret: all rays of the portion, whether they match or not, weigh 1. The column need not be
 * there: it is read where the stored bytes do not tell. */
enum rmap_status rmap_fold_weights(const struct rmap_matched *rays, bool *are_one_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* The portion by the paths of its rays, as rmap_cursor_path_summary has it; known NULL also where
 * receivers are laid over the map. And those of its rays that have paths of their own, where it is
 * summed up so. */
enum rmap_status rmap_fold_path_summary(const struct rmap_matched *rays,
                                        struct rmap_path_summary *paths,
                                        struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_fold_own_paths(const struct rmap_matched *rays,
                                     const struct rmap_portion **own_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The same, and between which numbers lie those of the rays with each path [paths] and of the rays
 * with paths of their own [paths->n_own], these NULL where nothing is known. */
enum rmap_status rmap_fold_path_bounds(const struct rmap_matched *rays,
                                       struct rmap_path_summary *paths,
                                       const struct rmap_path_sum **sum_ret,
                                       const struct rmap_path_sum **own_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Functions of one kind of sum. context: the fold's, shared by all threads and only read. */
struct rmap_fold_kind {
    /* An empty state. */
    enum rmap_status (*create)(const void *context, void **state_ret, struct rmap_error *err);
    void (*destroy)(void *state); /* NULL is fine */
    enum rmap_status (*add)(void *state, const struct rmap_matched *rays, struct rmap_error *err);
    /* Takes rays out of match [rays of the portion] that can add nothing, before anything of them
     * is read: by rmap_fold_path_bounds. NULL: all are read. */
    enum rmap_status (*narrow)(void *state, const struct rmap_matched *rays, uint8_t *match,
                               struct rmap_error *err);
    /* `from` may hand over what it holds: it can only be destroyed then. */
    enum rmap_status (*merge)(void *into, void *from, struct rmap_error *err);
    /* The arrays that a state is, as long as the context says: how many. NULL: instead, the state
     * as bytes for another rank (rmap_free), and from them. */
    size_t (*blocks)(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX]);
    enum rmap_status (*pack)(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                             struct rmap_error *err);
    enum rmap_status (*unpack)(const void *context, const uint8_t *bytes, size_t nbytes,
                               void **state_ret, struct rmap_error *err);
    /* False: no ray of this portion can count, whatever matches. NULL: any can. */
    bool (*may_count)(const void *context, const struct rmap_portion_info *portion);
};

/* All borrowed. */
struct rmap_fold {
    const struct rmap_fold_kind *kind;
    const void *context;
    const struct rmap_map *map;
    const struct rmap_criterion *criterion; /* NULL: all rays */
    const struct rmap_which *which;         /* registrations that count; NULL: all */
    rmap_column_set columns;                /* that the kind reads */
    rmap_column_set deferred; /* those of them that it asks for itself where it needs them */
    int32_t only_detector;    /* 1 + the detector without rows of which in /registration a ray adds
                                 nothing; 0: any may add */
    bool registered_alone;    /* a ray without rows there adds nothing, either */
    uint64_t *nbytes_ret; /* where rank 0 is told the stored bytes that were read; NULL: nowhere */
    const struct rmap_overlay *overlay; /* receivers, whose registrations portions then have; the
                                           criterion is compiled against its scene. NULL: none */
};

/* Adds portions [first, last) to one state, on one thread; threads may scan ranges of their own at
 * the same time. RMAP_FORMAT when stored rows do not fit together. */
enum rmap_status rmap_fold_scanner_create(const struct rmap_fold *fold,
                                          struct rmap_fold_scanner **scanner_ret,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_fold_scanner_destroy(struct rmap_fold_scanner *scanner); /* NULL is fine */
enum rmap_status rmap_fold_scanner_add(struct rmap_fold_scanner *scanner, void *state, size_t first,
                                       size_t last, struct rmap_error *err) RMAP_MUST_USE;

/* Stored bytes of the rows that it has read. */
uint64_t rmap_fold_scanner_nbytes(const struct rmap_fold_scanner *scanner);

#endif

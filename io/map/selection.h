/* SPDX-License-Identifier: MIT
 *
 * Where the rays of a map of a query come from: which questions picked them, out of which map, and
 * how many rays that map had, over which the flux of its sources stays shared out.
 */
#ifndef RMAP_SELECTION_H
#define RMAP_SELECTION_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* One question; texts are owned. */
struct rmap_selection_step {
    int32_t part;    /* of merged maps, which one's rays it picked from; 0 where none were */
    char *map;       /* name of the map that was asked, without its path */
    char *criterion; /* as it was written */
    char *answer;    /* "all", "limit 10", "sample 100 seed 1" */
};

struct rmap_selection {
    struct rmap_selection_step *step; /* [n], by part, the first question of each first */
    size_t n;
    char digest[33];  /* of the map whose rays were traced, as it was then */
    int32_t complete; /* 1: that map was */
    uint64_t n_ray;   /* that it held */
    double *emitted;  /* [n_source] of them, per source */
    size_t n_source;
};

/* A selection without steps; one more step. *selection_ret: rmap_selection_destroy. */
enum rmap_status rmap_selection_create(size_t n_source, struct rmap_selection **selection_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_selection_add(struct rmap_selection *selection,
                                    const struct rmap_selection_step *step,
                                    struct rmap_error *err) RMAP_MUST_USE;
/* One more question, asked of all that was picked so far; step->part is not looked at. */
enum rmap_status rmap_selection_ask(struct rmap_selection *selection,
                                    const struct rmap_selection_step *step,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_selection_copy(const struct rmap_selection *from,
                                     struct rmap_selection **selection_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_selection_destroy(struct rmap_selection *selection); /* NULL is fine */

/* Whether rays of both were picked out of one traced map, so that they may stand in one. */
bool rmap_selection_same_origin(const struct rmap_selection *a, const struct rmap_selection *b);

/* /selection of an index. Reading gives NULL when it has none. RMAP_FORMAT. */
struct rmap_h5;
enum rmap_status rmap_selection_write(struct rmap_h5 *h5, const struct rmap_selection *selection,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_selection_read(struct rmap_h5 *h5, size_t n_source,
                                     struct rmap_selection **selection_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif

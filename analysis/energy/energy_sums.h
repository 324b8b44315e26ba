/* SPDX-License-Identifier: MIT
 *
 * Where the light of matching rays ended and which detectors registered it, as sums of weights
 * per source: a kind of fold. Analog weights are 1, so that all sums are whole numbers.
 */
#ifndef RMAP_ENERGY_SUMS_H
#define RMAP_ENERGY_SUMS_H

#include "analysis/query/fold.h"
#include "trace/tally.h"

/* What is added up. */
struct rmap_energy_scope {
    const struct rmap_scene *scene; /* borrowed */
    bool ends;                      /* where rays ended; else what detectors registered alone */
    bool counts; /* how many rays match, their segments and weights; not with ends */
};

/* Ends of a source's rays, in this order: objects, media, left, limit, error. */
struct rmap_energy_sums {
    const struct rmap_energy_scope *scope; /* borrowed */
    size_t n_source, n_end, n_detector;
    size_t n_value;
    double *value;    /* everything below, in one block */
    double *rays;     /* [n_source] that match; 0 without ends or counts */
    double *segments; /* [n_source] of these; 0 without counts, as are the next two */
    double *weight, *weight_squared; /* [n_source] sums over these */
    double *ended;                   /* [n_source][n_end] sum of weights w */
    double *ended_squared;           /* [n_source][n_end] sum of w^2 */
    double *caught; /* [n_source][n_detector] sum of q, w times the ray's registrations */
    double *caught_squared;
    double *pending;                 /* [n_detector] q of the ray in hand */
    struct rmap_path_shares *shares; /* NULL: no portion was summed up by its paths */
};

/* Reads no weight of the ends without them. The fold is to defer them all: paths that rays share
 * may make them unnecessary. */
rmap_column_set rmap_energy_columns(const struct rmap_energy_scope *scope);

/* The context is a struct rmap_energy_scope. */
extern const struct rmap_fold_kind rmap_energy_kind;

enum rmap_status rmap_energy_sums_create(const struct rmap_energy_scope *scope,
                                         struct rmap_energy_sums **sums_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_energy_sums_destroy(struct rmap_energy_sums *sums); /* NULL is fine */

/* Sets the ends of all rays of a map, and the registrations of intensity grids: each ray leaves
 * once at most. */
void rmap_energy_sums_take_tally(struct rmap_energy_sums *sums, const struct rmap_tally *tally);

/* The same of what planes registered, whose squares a tally does not know: NaN. */
void rmap_energy_sums_take_planes(struct rmap_energy_sums *sums, const struct rmap_tally *tally);

/* Whether a tally leaves a detector's standard error open: a ray may cross a plane several times.
 */
bool rmap_energy_needs_scan(const struct rmap_scene *scene);

#endif

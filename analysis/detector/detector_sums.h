/* SPDX-License-Identifier: MIT
 *
 * What a detector caught, as sums that do not depend on the order of adding: of weights and
 * squared weights per source and cell (analog weights are 1, so these are exact integers in
 * double), of colour and of shares of the channels in fixed point. One per thread and rank; merged
 * at the end. Several registrations of one ray in one cell are summed before they are squared.
 */
#ifndef RMAP_DETECTOR_SUMS_H
#define RMAP_DETECTOR_SUMS_H

#include <stdbool.h>
#include <stdint.h>

#include "analysis/detector/detector_bins.h"
#include "analysis/detector/image_unit.h"
#include "analysis/query/fold.h"
#include "base/exact_sum.h"

struct rmap_tally;

/* What is summed; all borrowed. */
struct rmap_detector_ask {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay; /* receivers, or NULL */
    int32_t detector;                   /* in rmap_scene_with(map, overlay) */
    struct rmap_detector_bins bins;
    const struct rmap_image_unit *unit; /* of values, NULL: the usual one */
    bool colour;                        /* per cell, as light looks */
    bool channels;                      /* per cell and channel of colour space 0 */
    bool luminous; /* per cell, weighted by V(lambda): of fluxes in W; not with `channels` */
    bool weighed;  /* per cell, by the detector's response */
    bool xyz;      /* tristimulus values per cell, and the spectrum of all of it */
    bool centre;   /* where the light falls, of planes */
};

/* X, Y, Z, X + Y, Y + Z, Z + X: the squares of these say how the three vary together; and what Y is
 * at the channels' wavelengths themselves, by which light is counted in lm. */
enum { RMAP_XYZ_SUMS = 7 };

/* Fluxes are in lm. */
bool rmap_detector_ask_lumens(const struct rmap_detector_ask *ask);

struct rmap_detector_hit; /* of the ray in hand */

struct rmap_detector_sums {
    struct rmap_detector_ask ask;
    size_t n_source, n_cell;
    size_t n_weight; /* 2 * n_source * n_cell */
    double *weight;  /* [n_source][n_cell] sums, then [n_source][n_cell] of squares; cells row by
                        row, least v first, u fastest */
    double *total;   /* [2][n_source]: of all cells, and of its squares, per ray */
    size_t n_colour; /* 3 * n_cell, or 0: no colour wanted */
    int64_t *colour; /* [n_cell][3] CIE XYZ (spectral) or linear RGB, in units of quantum */
    double quantum;  /* flux */
    size_t n_channel, n_share; /* 0: none wanted; first the spectrum, then what `luminous` and
                                  `weighed` make of all light, then what `xyz` does */
    size_t n_spectral, n_seen, n_xyz;
    double seen_unit, xyz_unit;    /* what a share of all stands for: lm/W, or response */
    uint64_t *share;               /* [2][n_source][n_channel][n_cell + 1] sums of shares of
                                      RMAP_SHARE_UNIT and of their squares per ray, of 65535^2; behind
                                      the cells their total, of the spectrum of `xyz` that alone */
    struct rmap_exact_sum *centre; /* [n_source][4]: weight, times x, y, x^2 + y^2; or NULL */

    struct rmap_detector_hit *hit;
    size_t cap_hit;
    int32_t space; /* of the colours below; -1: none yet */
    double channel_colour[RMAP_CHANNEL_MAX][3];
    double channel_luminous[RMAP_CHANNEL_MAX];           /* lm/W over seen_unit */
    double channel_xyz[RMAP_CHANNEL_MAX][RMAP_XYZ_SUMS]; /* over xyz_unit */
    const struct rmap_scene *scene;                      /* whose detector it is there */
};

/* Of a ray's weight: 2^32 rays of 1 fit into a sum, as do their squares. */
#define RMAP_SHARE_UNIT (65535.0 * 65536.0)

/* What one state may take; more is refused. */
#define RMAP_DETECTOR_SUMS_NBYTES_MAX ((size_t)1 << 30)

/* Of a detector of the map's scene, in its own cells. */
enum rmap_status rmap_detector_sums_init(struct rmap_detector_sums *sums,
                                         const struct rmap_map *map, int32_t detector, bool colour,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_USAGE when it would take too much memory. */
enum rmap_status rmap_detector_sums_init_as(struct rmap_detector_sums *sums,
                                            const struct rmap_detector_ask *ask,
                                            struct rmap_error *err) RMAP_MUST_USE;
void rmap_detector_sums_fini(struct rmap_detector_sums *sums);

/* Adds the image that was accumulated during the trace, in the detector's own cells: each
 * registration is then taken for a ray of its own. */
void rmap_detector_sums_add_tally(struct rmap_detector_sums *sums, const struct rmap_tally *tally);

/* Flux of sources [first, last) that a channel has in a cell (n_cell: in all), and its error. */
void rmap_detector_sums_channel(const struct rmap_detector_sums *sums, size_t first, size_t last,
                                size_t channel, size_t cell, double *flux_ret, double *error_ret);

/* A source's part of a flux and of its variance, of the sums of weights and of their squares. */
void rmap_detector_sums_add_flux(const struct rmap_map *map, size_t source, double w, double w2,
                                 double *flux, double *variance);

/* How many registrations a cell of an evenly lit part holds: with how many others one shares its
 * cell, in the mean, and at least the mean of all cells. 0: nothing was registered. */
double rmap_detector_sums_crowd(const struct rmap_detector_sums *sums);

/* The same detector's sums of other rays. */
void rmap_detector_sums_merge(struct rmap_detector_sums *into,
                              const struct rmap_detector_sums *from);

/* As a fold (fold.h): context a struct rmap_detector_ask, states struct rmap_detector_sums. */
extern const struct rmap_fold_kind rmap_detector_sums_kind;
rmap_column_set rmap_detector_sums_columns(const struct rmap_detector_ask *ask);

#endif

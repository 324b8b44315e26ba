/* SPDX-License-Identifier: MIT
 *
 * The classes of paths as people want them: ranked, with errors, peaks and texts, and what is left.
 */
#ifndef RMAP_PATH_REPORT_H
#define RMAP_PATH_REPORT_H

#include "analysis/paths/path_count.h"

enum rmap_path_sort {
    RMAP_PATH_BY_FLUX,
    RMAP_PATH_BY_RAYS,
    RMAP_PATH_BY_LENGTH, /* segments per ray */
    RMAP_PATH_SORT_COUNT
};

/* On the detector on which the class registered most flux: flux per cell over the cell's area or
 * solid angle. */
struct rmap_path_peak {
    int32_t detector;             /* -1: nothing was registered, or it is not known */
    double value, standard_error; /* W/m2, lx, W/sr or cd */
    double x, y;                  /* centre of the cell, in the detector's coordinates */
};

struct rmap_path_row {
    struct rmap_key key;
    int32_t source;
    uint64_t rays, segments, registrations, first_ray;
    double flux, share, standard_error;
    double mean_time; /* ns; of a report with times */
    struct rmap_path_peak peak;
    char *sequence, *criterion; /* criterion NULL: none can be written */
};

/* Flux of rays: as `raymap query --count` has it. */
struct rmap_path_total {
    uint64_t rays, segments;
    double flux, standard_error;
};

struct rmap_path_report {
    const struct rmap_map *map; /* borrowed, as are all behind it */
    const struct rmap_overlay *overlay;
    const struct rmap_scene *scene; /* with the overlay's receivers */
    const struct rmap_path_keys *keys;
    const char *criterion;          /* NULL: all rays */
    const struct rmap_which *which; /* NULL: all registrations count */
    struct rmap_path_view view;
    struct rmap_path_total total, rest; /* of rays that have a path; of those in no row */
    uint64_t n_path;                    /* of these rays: until a detector, some have several */
    size_t n_class;                     /* that are known */
    bool exact;                         /* these are all; else those above `bound`, and some */
    double bound;                       /* share of the flux from which on all are known */
    bool peaks_missing;                 /* of some rows */
    bool timed;                         /* rows have mean times */
    size_t n_row;
    struct rmap_path_row *row;
};

/* The first `top` classes. bound: 0 when all are there. */
enum rmap_status rmap_path_report_create(const struct rmap_path_counts *counts,
                                         enum rmap_path_sort sort, uint64_t top, double bound,
                                         struct rmap_path_report **report_ret,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_report_destroy(struct rmap_path_report *report);

/* Peaks of the rows that have cells. */
enum rmap_status rmap_path_report_add_peaks(struct rmap_path_report *report,
                                            const struct rmap_key_sums *cells,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Flux and standard error of one source's sums of weights, with the variance in docs/physics.md;
 * the error is NaN where the source has fewer than 2 rays. */
void rmap_path_flux(const struct rmap_map *map, size_t source, double weight, double weight_squared,
                    double *flux_ret, double *standard_error_ret);

#endif

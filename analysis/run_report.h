/* SPDX-License-Identifier: MIT
 *
 * A page about a whole map, to be sent by mail: where it comes from, where its light went, what its
 * detectors saw, the paths that carried most, the scene with rays. The same bytes for the same map.
 */
#ifndef RMAP_RUN_REPORT_H
#define RMAP_RUN_REPORT_H

#include <stdio.h>

#include "analysis/energy.h"
#include "io/map_reader.h"

/* One class of paths, as the page lists it. */
struct rmap_report_path {
    const char *text;      /* "lamp: T@lens.1 R@lens.3" */
    const char *criterion; /* that selects it; NULL: none does */
    double rays, flux, flux_error, share, share_error;
    uint64_t first_ray;
};

struct rmap_report_paths {
    size_t n;
    const struct rmap_report_path *path; /* [n] most flux first */
    size_t n_class;                      /* in all; 0: not known */
    double rest_flux, rest_share;
    const char *note; /* which rays these are of, and what is not exact; NULL: nothing to say */
};

/* All borrowed. */
struct rmap_run_report {
    const struct rmap_map *map;
    const char *name; /* of the map */
    const struct rmap_energy *energy;
    const char *energy_note;               /* NULL: nothing to say */
    const struct rmap_portion *rays;       /* to draw, all columns */
    const struct rmap_report_paths *paths; /* NULL: no such section */
};

/* RMAP_SYSTEM when memory is short; errors of the stream are the caller's to see. */
enum rmap_status rmap_run_report_write(const struct rmap_run_report *report, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

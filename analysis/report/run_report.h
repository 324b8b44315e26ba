/* SPDX-License-Identifier: MIT
 *
 * A page about a whole map, to be sent by mail: where it comes from, where its light went, what its
 * detectors saw, the paths that carried most, the scene with rays. The same bytes for the same map.
 */
#ifndef RMAP_RUN_REPORT_H
#define RMAP_RUN_REPORT_H

#include <stdio.h>

#include "analysis/detector/detector_sums.h"
#include "analysis/energy/energy.h"
#include "analysis/report/report_paths.h"
#include "io/map/map_reader.h"

/* All borrowed. */
struct rmap_run_report {
    const struct rmap_map *map;
    const char *name; /* of the map */
    const struct rmap_energy *energy;
    const char *energy_note;                /* NULL: nothing to say */
    const struct rmap_portion *rays;        /* to draw, all columns */
    const struct rmap_report_paths *paths;  /* NULL: no such section */
    const struct rmap_detector_sums *image; /* [the first RMAP_REPORT_PICTURES detectors]; NULL:
                                               those of the map's tally */
    const struct rmap_which *which;         /* registrations that they count; NULL: all */
};

/* Pictures of detectors: a page that is sent by mail must not grow without bound. */
enum { RMAP_REPORT_PICTURES = 12 };

/* RMAP_SYSTEM when memory is short; errors of the stream are the caller's to see. */
enum rmap_status rmap_run_report_write(const struct rmap_run_report *report, FILE *out,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * What `raymap detector` is asked for, and what of it the scene can give.
 */
#ifndef RMAP_DETECTOR_REQUEST_H
#define RMAP_DETECTOR_REQUEST_H

#include "analysis/detector/detector_bins.h"
#include "analysis/detector/detector_sums.h"
#include "analysis/detector/image_unit.h"
#include "analysis/figure/figure_detector.h"
#include "mpi/answer/lamp_sheet_out.h"
#include "mpi/command/arguments.h"
#include "mpi/command/until.h"

struct rmap_detector_request {
    const char *map_path, *detector, *where, *unit;
    char **output; /* [n_output] */
    size_t n_output;
    struct rmap_detector_bins_asked bins;
    bool tally, channels, force, by_source, world, auto_cells, lamp_file, xyz;
    bool grid, table, daylight;     /* EN 12464-1's cells; values as a table; against the sky */
    struct rmap_image_unit percent; /* of the horizontal illuminance by the sky */
    bool spot, mtf, moments_alone;  /* moments_alone: of a spot, as in struct rmap_spot_ask */
    struct rmap_until until;
    double frequency;      /* 0: by the size of the spot */
    const char *plot_path; /* of the curves */
    double *level;         /* of isolines, or NULL */
    bool photometry;
    struct rmap_lamp_sheet_ask sheet;
    struct rmap_figure_detector figure;
};

/* RMAP_USAGE; rmap_detector_request_fini whatever happened. */
enum rmap_status rmap_detector_request_read(const struct rmap_arguments *given,
                                            struct rmap_detector_request *request,
                                            struct rmap_error *err) RMAP_MUST_USE;

void rmap_detector_request_fini(struct rmap_detector_request *request);

/* Of `--quantity daylight_factor`: all but the sky put out, and the unit. RMAP_USAGE, RMAP_INPUT.
 */
enum rmap_status rmap_detector_request_daylight(struct rmap_map *map,
                                                struct rmap_detector_request *request,
                                                struct rmap_error *err) RMAP_MUST_USE;

/* What is to be summed; remarks on rank 0. *ask refers to map, overlay and request. RMAP_USAGE,
 * RMAP_INPUT where the detector or the scene has none of it. */
enum rmap_status rmap_detector_request_ask(const struct rmap_context *context,
                                           const struct rmap_detector_request *request,
                                           const struct rmap_map *map,
                                           const struct rmap_overlay *overlay,
                                           struct rmap_detector_ask *ask,
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * What verifying a map finds wrong: the place, and the rays that it costs.
 */
#ifndef RMAP_FINDINGS_H
#define RMAP_FINDINGS_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

#define RMAP_FINDING_RANGES 16

/* Plain bytes, so that ranks can send it to each other. */
struct rmap_finding {
    char file[288];   /* from the map's directory on: "shard-00000/piece-00000.h5"; "": the map */
    char dataset[64]; /* "": the file as a whole, or not known */
    int64_t chunk;    /* of the dataset; -1: none in particular */
    uint64_t first_row, n_row;              /* of the dataset; n_row 0: none in particular */
    uint64_t n_ray;                         /* hit by it */
    uint64_t range[RMAP_FINDING_RANGES][2]; /* their ids, [first, last] each, ascending; with more
                                               ranges than fit the last one spans the rest */
    int32_t n_range;
    char text[512];
};

/* Zeroed: empty. */
struct rmap_findings {
    struct rmap_finding *row;
    size_t n, cap;
};

void rmap_findings_fini(struct rmap_findings *findings);

/* A finding without chunk, rows and rays; long names are cut. */
void rmap_finding_set(struct rmap_finding *finding, const char *file, const char *dataset,
                      const char *format, ...) RMAP_PRINTF(4, 5);

/* Rays [first, first + n) in addition; ids must ascend from call to call. */
void rmap_finding_add_rays(struct rmap_finding *finding, uint64_t first, uint64_t n);

/* RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_findings_add(struct rmap_findings *findings,
                                   const struct rmap_finding *finding,
                                   struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_findings_append(struct rmap_findings *findings,
                                      const struct rmap_finding *row, size_t n,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* A finding of a whole file: nothing more is known than the text. */
enum rmap_status rmap_findings_note(struct rmap_findings *findings, const char *file,
                                    const char *text, struct rmap_error *err) RMAP_MUST_USE;

/* What reading a file came to: damage is found in it, a system that fails is handed on. */
enum rmap_status rmap_findings_take(struct rmap_findings *findings, const char *file,
                                    const char *dataset, enum rmap_status st,
                                    const struct rmap_error *why,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* By file (the map's own first), dataset, chunk, ray and text: whoever found what. Those that say
 * the same stay once. */
void rmap_findings_sort(struct rmap_findings *findings);

#endif

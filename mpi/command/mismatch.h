/* SPDX-License-Identifier: MIT
 *
 * Rays that end in an error tell of media that do not fit: a surface whose near side is not the
 * medium that the light is in; rays that meet nothing, of light that is sent in vain.
 */
#ifndef RMAP_MISMATCH_H
#define RMAP_MISMATCH_H

#include "accel/accel.h"
#include "io/file/diagnostics.h"
#include "scene/scene.h"
#include "trace/tracer.h"

struct rmap_mismatch_effort {
    uint64_t n_ray;  /* at most so many rays */
    double seconds;  /* and so long, but for the ray in hand */
    uint64_t n_sent; /* returned */
    bool cut;        /* returned: time was up before n_ray */
};

/* Traces ray ids [0, n_ray) and adds each distinct pair (object left, object met) whose media do
 * not match to the diagnostics, where the object met stands in the file. Behind a mismatch a ray
 * is followed straight on: one mistake does not hide the next. Where media match, warns of sources
 * whose light meets nothing, and of detectors that none reaches. */
enum rmap_status rmap_mismatch_probe(const struct rmap_tracer *tracer,
                                     struct rmap_mismatch_effort *effort,
                                     struct rmap_diagnostics *diagnostics,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* What went wrong with one ray that ended in an error: one sentence and the remedy. */
void rmap_mismatch_describe(const struct rmap_tracer *tracer, uint64_t ray, char *text,
                            size_t text_nbytes);

#endif

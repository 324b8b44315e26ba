/* SPDX-License-Identifier: MIT
 *
 * The tracer of one ray: emission, segments, surfaces, media, detectors, limits. A ray is a pure
 * function of (scene, seed, ray id). Analog Monte Carlo: a ray keeps its weight, and at each
 * event one outcome is drawn with its physical probability.
 */
#ifndef RMAP_TRACER_H
#define RMAP_TRACER_H

#include <stdint.h>

#include "accel/accel.h"
#include "portion/recorder.h"
#include "scene/scene.h"

struct rmap_tracer {
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_accel *accel; /* borrowed */
    uint64_t seed;
};

/* Traces ray id `ray` into the recorder. Thread-safe; allocates nothing. */
void rmap_trace_ray(const struct rmap_tracer *tracer, uint64_t ray, struct rmap_recorder *recorder);

#endif

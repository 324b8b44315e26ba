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
#include "accel/accel_places.h"
#include "portion/recorder.h"
#include "scene/scene.h"

struct rmap_tracer {
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_accel *accel; /* borrowed */
    uint64_t seed;
};

/* Traces ray id `ray` into the recorder. Thread-safe; allocates nothing. */
void rmap_trace_ray(const struct rmap_tracer *tracer, uint64_t ray, struct rmap_recorder *recorder);

/* What a ray is known to meet first, from an older version of the scene: nothing of it has changed,
 * nor anything that the ray meets, unless its way leads through one of the places. Borrowed. */
struct rmap_known_way {
    size_t n;                          /* segments */
    const int32_t *object, *primitive; /* [n] at their ends, by numbers of the older scene; -1 */
    const int32_t *number;             /* of its objects, in this one */
    const struct rmap_places *places;
};

/* The same ray, with less searching. */
void rmap_trace_known(const struct rmap_tracer *tracer, uint64_t ray,
                      const struct rmap_known_way *way, struct rmap_recorder *recorder);

#endif

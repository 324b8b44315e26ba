/* SPDX-License-Identifier: MIT
 *
 * The reference that recording and querying are measured against: ray histories stored and
 * searched in the way of the program that this one follows. Records of 36 bytes per segment end,
 * device records and colours beside them, each compressed by zlib level 1 per portion of rays,
 * one synchronised writer to one file; a question inflates everything and tests every ray.
 */
#ifndef RMAP_BENCH_SEED_H
#define RMAP_BENCH_SEED_H

#include <stdbool.h>

#include "accel/accel.h"
#include "scene/scene.h"

struct rmap_seed_result {
    double seconds;
    uint64_t nbytes; /* of the file */
    uint64_t n_segment;
};

/* Traces ray ids [0, n_ray) with n_thread workers and stores them at `path`. */
enum rmap_status rmap_seed_record(const struct rmap_scene *scene, const struct rmap_accel *accel,
                                  uint64_t n_ray, int n_thread, const char *path,
                                  struct rmap_seed_result *result,
                                  struct rmap_error *err) RMAP_MUST_USE;

enum { RMAP_SEED_ELEMENT_MAX = 4 };

/* One of some events on an object of a set, or (events 0) a registration on a detector. */
struct rmap_seed_element {
    uint32_t events;
    const bool *in_set;
    int32_t detector;
};

/* The rays of one source that met objects of a set with one of some events so many times, were
 * registered on a detector within a rectangle of relative coordinates and an angle of its normal,
 * went no farther than a length, and did certain things in order, the first at once. */
struct rmap_seed_question {
    int32_t source;     /* -1: any */
    const bool *in_set; /* [n_object] */
    size_t n_object;
    uint32_t events;
    int at_least, at_most;
    int32_t detector; /* -1: none */
    double from[2], to[2];
    double least_cosine;
    double longest; /* path */
    struct rmap_seed_element element[RMAP_SEED_ELEMENT_MAX];
    int n_element;
};

/* Counts them with n_thread readers; seconds of it. */
enum rmap_status rmap_seed_query(const char *path, const struct rmap_seed_question *question,
                                 int n_thread, uint64_t *n_ray_ret, double *seconds_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Inflates all of the file with n_thread readers and libdeflate, and does nothing with it. */
enum rmap_status rmap_seed_inflate(const char *path, int n_thread, double *seconds_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Sums kept while tracing, per source: the energy balance (emitted = absorbed by each object +
 * absorbed in each medium + left + limits + errors, exact in rays) and the detectors' images.
 * Analog weights are 1, or multiples of 2^-21 where light is given back at other wavelengths, so
 * every sum is exact in double and does not depend on the order of adding. A registration counts
 * with the weight that its ray ends with. One tally per thread; merged at the end.
 */
#ifndef RMAP_TALLY_H
#define RMAP_TALLY_H

#include "portion/portion.h"
#include "portion/recorder.h"
#include "scene/scene.h"

struct rmap_tally {
    const struct rmap_scene *scene; /* borrowed */
    size_t n_value;
    double *value; /* everything below, in one block [n_value] that can be summed and sent */

    double *emitted;         /* [n_source] rays */
    double *absorbed_object; /* [n_source][n_object] */
    double *absorbed_medium; /* [n_source][n_medium] */
    double *left;            /* [n_source] */
    double *limit;           /* [n_source] */
    double *error;           /* [n_source] */
    double *segments;        /* [1] segments in all */
    double *image;           /* sum of weights per detector, source, cell; see rmap_tally_image */
    double *image_squared;   /* sum of squared weights, of each up to 1024, same layout */
    double *image_squared_rest; /* sum of what they are above that, same layout: weights of light
                                   given back go up to 1024; NULL where weights are 1 */
    double *left_elsewhere; /* [n_medium] of `left`, of rays that ended in another medium than they
                               began in; of what was traced or read, not kept in maps */
    size_t *image_offset;   /* [n_detector + 1], in cells x sources */

    uint64_t first_error_ray; /* smallest ray id that ended with an error; UINT64_MAX: none */
};

enum rmap_status rmap_tally_create(const struct rmap_scene *scene, struct rmap_tally **tally_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_tally_destroy(struct rmap_tally *tally);
void rmap_tally_merge(struct rmap_tally *into, const struct rmap_tally *from);

/* Sums of detector d from source s: cells[1] rows of cells[0] values, least y first. */
const double *rmap_tally_image(const struct rmap_tally *tally, size_t detector, size_t source);

/* Sum of squared weights, whole, of value `at` of the images. */
static inline double rmap_tally_squared(const struct rmap_tally *tally, size_t at)
{
    const double *rest = tally->image_squared_rest;
    return tally->image_squared[at] + (rest ? rest[at] : 0.0);
}

/* One registered hit of a cell; the end of a ray. The caller has checked every index. */
struct rmap_tally_ending {
    uint64_t ray;
    int32_t source, object, medium; /* object met last, or -1; medium travelled last */
    enum rmap_stop stop;
    double weight;
};

/* What a portion must have to be added up. */
#define RMAP_TALLY_COLUMNS                                                                         \
    (RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |                             \
     RMAP_COLUMN_BIT(RMAP_RAY_stop) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |                           \
     RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |      \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) |                 \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) |       \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered))

/* Adds what the recorder below would have added while the portion's rays were traced. Nothing in
 * the portion is trusted: RMAP_FORMAT, with the tally unchanged, when counts do not add up to the
 * rows, or a source, stop, object, medium, detector or cell is none of the scene. */
enum rmap_status rmap_tally_add_portion(struct rmap_tally *tally,
                                        const struct rmap_portion *portion,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* The same for the rays behind so many rows of each table. */
enum rmap_status rmap_tally_add_rows(struct rmap_tally *tally, const struct rmap_portion *portion,
                                     const size_t first[RMAP_TABLE_COUNT],
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Records into the tally, and passes every call on to `next` (NULL: nowhere). */
struct rmap_tally_recorder {
    struct rmap_recorder base;
    struct rmap_recorder *next;
    struct rmap_tally *tally;
    int32_t source; /* of the ray in hand */
    uint64_t ray;
    int32_t last_object, last_medium;
    size_t *hit; /* [n_hit] cells of the ray in hand, where weights change on the way */
    size_t n_hit, cap_hit;
    enum rmap_status status; /* RMAP_SYSTEM once there was no memory for them */
};
void rmap_tally_recorder_init(struct rmap_tally_recorder *recorder, struct rmap_tally *tally,
                              struct rmap_recorder *next);
void rmap_tally_recorder_fini(struct rmap_tally_recorder *recorder);

#endif

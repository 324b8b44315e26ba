/* SPDX-License-Identifier: MIT
 *
 * What the rays of a sample (a map's rays that match) add up to, per source: their flux, what
 * each detector registered, what each object and medium absorbed, how they ended; and the
 * detectors' images. Sums of weights: whole numbers, exact in any order.
 */
#ifndef RMAP_COMPARE_SUMS_H
#define RMAP_COMPARE_SUMS_H

#include "analysis/query/fold.h"

/* Where things stand in the sums of one map. Plain data; rmap_free(first_cell). */
struct rmap_compare_layout {
    const struct rmap_map *map;     /* borrowed */
    const struct rmap_scene *scene; /* with receivers; borrowed */
    size_t n_source, n_detector, n_object, n_medium;
    size_t n_scalar;          /* selected; detectors; objects; media; stops */
    size_t n_cell;            /* of all detectors */
    size_t *first_cell;       /* [n_detector + 1] */
    size_t n_value;           /* of struct rmap_compare_sums */
    bool registrations_alone; /* how rays ended is another sample's */
};

/* Scalars. */
#define RMAP_COMPARE_SELECTED ((size_t)0)
size_t rmap_compare_detector(const struct rmap_compare_layout *layout, size_t detector);
size_t rmap_compare_object(const struct rmap_compare_layout *layout, size_t object);
size_t rmap_compare_medium(const struct rmap_compare_layout *layout, size_t medium);
size_t rmap_compare_stop(const struct rmap_compare_layout *layout, int stop);

/* RMAP_SYSTEM, with the reason, also where the sums would be too large to hold. */
enum rmap_status rmap_compare_layout_init(struct rmap_compare_layout *layout,
                                          const struct rmap_map *map,
                                          const struct rmap_overlay *overlay,
                                          struct rmap_error *err) RMAP_MUST_USE;
void rmap_compare_layout_fini(struct rmap_compare_layout *layout);

struct rmap_compare_sums {
    const struct rmap_compare_layout *layout; /* borrowed */
    double *value;                            /* all that follows [n_value] */
    /* Per ray q is its weight times how often; sums of q, of q squared, of rays with q > 0. */
    double *sum, *square, *rays; /* [n_source][n_scalar] */
    double *cell;                /* [n_source][n_cell] */
    double *repeated; /* [n_detector] rays that count in an image more than once, or not as 1 */
    uint32_t *hits;   /* [n_detector] of the ray in hand */
};

/* context: struct rmap_compare_layout; state: struct rmap_compare_sums. */
extern const struct rmap_fold_kind rmap_compare_sums_kind;
#define RMAP_COMPARE_SUMS_COLUMNS                                                                  \
    (RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |                             \
     RMAP_COLUMN_BIT(RMAP_RAY_stop) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |                           \
     RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |      \
     RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) |                 \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) |       \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered))

#endif

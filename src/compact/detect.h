/* SPDX-License-Identifier: MIT
 *
 * Points on a detector as they are recorded, without branches: where light
 * comes down is anybody's guess.
 */
#ifndef RMAP_COMPACT_DETECT_H
#define RMAP_COMPACT_DETECT_H

#include "compact/model.h"

/* A plane detector that lies on objects: a segment's end is where it is met. */
static inline bool rmap_detect_lies_on(const struct rmap_detector *detector)
{
    return detector->type == RMAP_DETECTOR_PLANE &&
           (detector->on_object >= 0 || detector->on_group >= 0);
}

/* Of a plane. */
static inline void rmap_detect_point(const struct rmap_detector *detector, struct rmap_vec3 point,
                                     double relative[2])
{
    struct rmap_vec3 offset = rmap_sub(point, detector->origin);
    relative[0] = rmap_dot(offset, detector->x) / detector->size[0] + 0.5;
    relative[1] = rmap_dot(offset, detector->y) / detector->size[1] + 0.5;
}

/* The cell that a recorded place is most likely in; 0 for an unknown detector. */
static inline void rmap_detect_cell(const struct rmap_compact_model *model, int32_t detector,
                                    const uint16_t recorded[2], uint16_t cell[2])
{
    const bool known = detector >= 0 && (size_t)detector < model->n_detector;
    for (int k = 0; k < 2; k++) {
        const uint64_t n = known ? model->scene->detector[detector].cells[k] : 1;
        const uint64_t at = recorded[k] * n / UINT16_MAX;
        cell[k] = (uint16_t)(at < n ? at : n - 1);
    }
}

typedef double rmap_pair __attribute__((vector_size(16)));
typedef int64_t rmap_pair_order __attribute__((vector_size(16)));

/* Into cells and relative coordinates; what is no number is 0. */
static inline void rmap_detect_record(const struct rmap_detector *detector,
                                      const double relative[2], uint16_t cell[2],
                                      uint16_t recorded[2])
{
    const rmap_pair zero = {0.0, 0.0}, one = {1.0, 1.0};
    const rmap_pair n = {(double)detector->cells[0], (double)detector->cells[1]};
    const rmap_pair x = {relative[0], relative[1]}, its = x * n;
    rmap_pair last = n - one, above = (rmap_pair)((rmap_pair_order)its & (its > zero));
    rmap_pair positive = (rmap_pair)((rmap_pair_order)x & (x > zero));
    rmap_pair_order inside = above < last, below = positive < one;
    last = (rmap_pair)((rmap_pair_order)last & (last > zero));
    above = (rmap_pair)(((rmap_pair_order)above & inside) | ((rmap_pair_order)last & ~inside));
    rmap_pair bounded =
        (rmap_pair)(((rmap_pair_order)positive & below) | ((rmap_pair_order)one & ~below));
    rmap_pair scaled = 65535.0 * bounded + 0.5;
    for (int k = 0; k < 2; k++) {
        cell[k] = (uint16_t)(int64_t)above[k];
        recorded[k] = (uint16_t)(int32_t)scaled[k];
    }
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of light that it registered: its response, from the light's colour and
 * angle as they are stored, and whether a detector that counts by chance detects it. Nothing of it
 * is stored: the draw is a function of seed, ray, segment and detector.
 */
#ifndef RMAP_REGISTRATION_RESPONSE_H
#define RMAP_REGISTRATION_RESPONSE_H

#include "analysis/criterion/criterion_tree.h"

/* A row of /registration, its row of /ray, and where that ray's rows of /segment begin. */
struct rmap_registration_place {
    size_t row, ray, first_segment;
};

/* Columns that both read. */
#define RMAP_RESPONSE_COLUMNS                                                                      \
    (RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |                             \
     RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |      \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |    \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction) | RMAP_COLUMN_BIT(RMAP_SEGMENT_colour))

/* 1 where the detector has none. scene: of the colour space that the portion is in. */
double rmap_registration_response(const struct rmap_scene *scene,
                                  const struct rmap_portion *portion,
                                  const struct rmap_registration_place *place);

/* To that part of the light which is on one channel. */
double rmap_registration_response_to(const struct rmap_scene *scene,
                                     const struct rmap_portion *portion,
                                     const struct rmap_registration_place *place, int channel);

/* True where the detector does not count by chance. */
bool rmap_registration_detected(const struct rmap_scene *scene, const struct rmap_portion *portion,
                                const struct rmap_registration_place *place);

static inline bool rmap_detector_chances(const struct rmap_detector *detector)
{
    return detector->response && detector->response->detect == RMAP_DETECT_CHANCE;
}

static inline bool rmap_detector_weighs(const struct rmap_detector *detector)
{
    return detector->response && detector->response->detect == RMAP_DETECT_WEIGHT;
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * Records rays into a portion: float positions, int16 normals, 16-bit colours.
 */
#ifndef RMAP_PORTION_RECORDER_H
#define RMAP_PORTION_RECORDER_H

#include "portion/portion.h"
#include "portion/recorder.h"
#include "scene/scene.h"

/* A colour and what it became. */
struct rmap_known_colour {
    double share[RMAP_CHANNEL_MAX];
    uint16_t quantised[RMAP_CHANNEL_MAX];
};

struct rmap_portion_recorder {
    struct rmap_recorder base;
    struct rmap_portion *portion; /* borrowed */
    enum rmap_status status;      /* RMAP_SYSTEM once memory ran short: the portion is unusable */

    /* The last two colours: most segments keep that of the one before, and most rays begin alike.
     */
    struct rmap_known_colour colour[2];
    struct rmap_known_colour *last;
    size_t first_segment;                /* of the ray in hand */
    struct rmap_unpredicted unpredicted; /* so far; its seed is the caller's to set */
};

void rmap_portion_recorder_init(struct rmap_portion_recorder *recorder,
                                struct rmap_portion *portion);

/* Empties the portion, whose next ray will be first_ray, and forgets the unpredicted; the portion's
 * are the recorder's from now on. */
void rmap_portion_recorder_restart(struct rmap_portion_recorder *recorder, uint64_t first_ray);

/* Shares of 65535 that sum to exactly 65535, by largest remainder (ties: lowest channel). */
void rmap_colour_quantise(const double *colour, int n_channel, uint16_t *quantised);

#endif

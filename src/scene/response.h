/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of the light that it registers: so much of it by wavelength and angle
 * (quantum efficiency, A/W, V(lambda)).
 */
#ifndef RMAP_RESPONSE_H
#define RMAP_RESPONSE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum rmap_detect {
    RMAP_DETECT_WEIGHT, /* what is registered counts with the response */
    RMAP_DETECT_CHANCE  /* it counts in whole or not at all; the response is the chance */
};

struct rmap_response {
    enum rmap_detect detect;
    bool lumens;    /* V(lambda): it answers in lm */
    bool xyz;       /* and its colour is told */
    size_t n_angle; /* 1: alike at all angles */
    int n_channel;
    double *angle_deg; /* [n_angle] increasing, from the detector's axis; linear in between,
                          constant beyond the ends */
    double *value;     /* [n_angle][n_channel] */
};

struct rmap_response *rmap_response_create(size_t n_angle, int n_channel); /* NULL: no memory */
void rmap_response_destroy(struct rmap_response *response);                /* NULL is fine */

/* Of light with these shares (of 65535) of the channels. share: [n_channel]. */
double rmap_response_at(const struct rmap_response *response, const uint16_t *share,
                        double angle_deg);

/* The most of any channel and angle. */
double rmap_response_most(const struct rmap_response *response);

#endif

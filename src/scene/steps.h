/* SPDX-License-Identifier: MIT
 *
 * Steps of charged particles and the light that they make along them: how many photons, and which
 * one a ray is.
 */
#ifndef RMAP_STEPS_H
#define RMAP_STEPS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"
#include "optics/scintillation.h"

enum rmap_photon_kind { RMAP_PHOTON_SCINTILLATION, RMAP_PHOTON_CHERENKOV, RMAP_PHOTON_KINDS };

struct rmap_track_step {
    struct rmap_vec3 position, direction; /* of its begin, in the world; unit */
    double length;
    double energy_mev; /* left in the medium */
    double time_ns;    /* at its begin */
    double charge;     /* in elementary charges */
    double beta;       /* speed over that of light in vacuum */
    uint64_t event;
};

struct rmap_steps {
    size_t n;
    struct rmap_track_step *step; /* [n] by event, those of one as they came */
    double *photons; /* [n][RMAP_PHOTON_KINDS] photons up to and with each step's of each kind:
                      expected or, `counted`, drawn */
    double cherenkov[RMAP_CHANNEL_MAX]; /* photons per length of unit strength, per channel */
    double range_nm[2];                 /* Cherenkov light of these wavelengths alone */
    bool emits[RMAP_PHOTON_KINDS];
    bool counted;         /* each ray is a photon */
    uint64_t seed;        /* of their numbers */
    double ns_per_length; /* of light in vacuum */
};

/* n steps without a number in them, range without ends. RMAP_SYSTEM. */
enum rmap_status rmap_steps_create(size_t n, struct rmap_steps **steps_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_steps_destroy(struct rmap_steps *steps); /* NULL is fine */

/* What the light is made in. */
struct rmap_steps_medium {
    const double *n;                                /* [n_channel] */
    const struct rmap_scintillation *scintillation; /* NULL: none */
    const struct rmap_channels *channels;
    double unit_m;
};

/* Brings the steps in order and fills what is derived; in share[n_channel] how all photons that are
 * expected lie on the channels. RMAP_INPUT with the step (from 1) that is none, or where there is
 * no light; RMAP_SYSTEM. */
enum rmap_status rmap_steps_prepare(struct rmap_steps *steps,
                                    const struct rmap_steps_medium *medium, double *share,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Of all: expected, or drawn. */
double rmap_steps_photons(const struct rmap_steps *steps);

/* How many photons there are of those `counted`; 0 of others, and where a damaged map says what is
 * no number of them. */
uint64_t rmap_steps_n_counted(const struct rmap_steps *steps);

/* Which step the ordinal-th ray is of, and of which kind its light: photon `ordinal` of those
 * counted; else by u in (0, 1). */
size_t rmap_steps_find(const struct rmap_steps *steps, uint64_t ordinal, double u,
                       enum rmap_photon_kind *kind_ret);

struct rmap_photon {
    struct rmap_vec3 position, direction;
    int channel;
    double delay_ns; /* from the event's beginning to its emission */
    size_t step;
    enum rmap_photon_kind kind;
};

/* The photon that is the ordinal-th ray, by eight numbers in (0, 1): step and kind, channel, place;
 * direction and delay. By portable operations. */
void rmap_steps_draw(const struct rmap_steps *steps, const struct rmap_steps_medium *medium,
                     uint64_t ordinal, const double place[4], const double way[4],
                     struct rmap_photon *photon);

#endif

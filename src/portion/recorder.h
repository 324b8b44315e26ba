/* SPDX-License-Identifier: MIT
 *
 * Where the tracer tells a ray's history. Everything here is double precision; what a recorder
 * keeps of it is its own affair (a portion keeps float columns, a report keeps all digits).
 */
#ifndef RMAP_RECORDER_H
#define RMAP_RECORDER_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"
#include "portion/event.h"

struct rmap_emission {
    uint64_t ray;
    int32_t source;
    int32_t object, primitive; /* emitted from; -1: none */
    struct rmap_vec3 position, direction, normal;
    int32_t medium;
    const double *colour; /* [n_channel], borrowed during the call */
    double delay_ns;      /* after the time 0 of the source; arrival times have it */
    bool predicted;       /* as in struct rmap_hit */
    double loose;         /* how far the start may be off, as its file rounds it; 0: not at all */
};

/* The end of a segment. */
struct rmap_step {
    int32_t object, primitive; /* -1: none */
    uint32_t events;
    int32_t medium; /* travelled */
    struct rmap_vec3 position, normal;
    struct rmap_vec3 direction;       /* of the segment */
    struct rmap_vec3 first_direction; /* where a curved segment begins; 0 for straight ones */
    double length;                    /* of the segment, geometric; 0 when it left the scene */
    double optical_path;              /* from emission to here */
    const double *colour;             /* [n_channel], on arrival; borrowed during the call */
};

/* A point of a curved segment between its ends, thinned to the medium's polyline tolerance. */
struct rmap_curve_point {
    uint32_t segment; /* segment, from 0 */
    struct rmap_vec3 position;
    struct rmap_vec3 direction; /* unit */
    double index;               /* of the field there */
    double length;              /* of the segment up to here, geometric */
    double optical_path;        /* from emission to here */
};

struct rmap_registration {
    int32_t detector;
    uint32_t segment; /* segment, from 0 */
    uint32_t cell[2];
    double relative[2]; /* 0..1 */
    bool registered;
    struct rmap_vec3 position, direction;
    double cosine; /* PLANE: of the angle between the reversed ray and the detector's axis;
                      INTENSITY: of theta, between the ray and the axis */
    double optical_path;
    double group_path, delay_ns; /* of timed scenes, else 0; arrival time: delay and group path / c
                                  */
};

/* The angle whose cosine is given; one a little beyond 1 is rounding. */
static inline double rmap_angle_of(double cosine)
{
    return acos(fmax(-1.0, fmin(1.0, cosine)));
}

struct rmap_ending {
    enum rmap_stop stop;
    double weight;
    double wavelength_nm; /* NaN where more than one channel is left */
    double path_length, optical_path;
    double group_path, delay_ns; /* as in struct rmap_registration */
    struct rmap_vec3 direction;  /* where it left; 0 otherwise */
    bool predicted; /* src/compact finds every number of the ray from its path, bit by bit; false
                      where that is not certain */
};

/* Calls come in the order of the ray's history: emit, then registrations and steps as they
 * happen, then end. A failing recorder (memory) keeps its first error for itself. */
struct rmap_recorder {
    void (*emit)(struct rmap_recorder *self, const struct rmap_emission *emission);
    void (*step)(struct rmap_recorder *self, const struct rmap_step *step);
    /* Points of a curved segment, before its step. NULL: not wanted. */
    void (*curve)(struct rmap_recorder *self, const struct rmap_curve_point *point);
    void (*registration)(struct rmap_recorder *self, const struct rmap_registration *registration);
    void (*end)(struct rmap_recorder *self, const struct rmap_ending *ending);
};

#endif

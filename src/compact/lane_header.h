/* SPDX-License-Identifier: MIT
 *
 * What a portion says of its lanes, before them: how each is stored.
 */
#ifndef RMAP_COMPACT_LANE_HEADER_H
#define RMAP_COMPACT_LANE_HEADER_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "compact/angles.h"
#include "portion/columns.h"

/* Columns and roles, in the order in which the header and the pools have them. */
#define RMAP_LANES(X)                                                                              \
    X(RAY_id, SIMPLE)                                                                              \
    X(RAY_weight, SIMPLE)                                                                          \
    X(RAY_wavelength, SIMPLE)                                                                      \
    X(RAY_path_length, FOLLOWS)                                                                    \
    X(RAY_optical_path, FOLLOWS)                                                                   \
    X(RAY_start, LEADS)                                                                            \
    X(RAY_start_primitive, SIMPLE)                                                                 \
    X(RAY_start_normal, FOLLOWS)                                                                   \
    X(RAY_end_direction, FOLLOWS)                                                                  \
    X(SEGMENT_primitive, SIMPLE)                                                                   \
    X(SEGMENT_medium, SIMPLE)                                                                      \
    X(SEGMENT_position, LEADS)                                                                     \
    X(SEGMENT_normal, FOLLOWS)                                                                     \
    X(SEGMENT_colour, LEADS)                                                                       \
    X(REGISTRATION_cell, PLACED)                                                                   \
    X(REGISTRATION_relative, PLACED)                                                               \
    X(REGISTRATION_direction, FOLLOWS)                                                             \
    X(REGISTRATION_optical_path, FOLLOWS)                                                          \
    X(RAY_group_path, FOLLOWS)                                                                     \
    X(RAY_delay, FOLLOWS)                                                                          \
    X(REGISTRATION_group_path, FOLLOWS)                                                            \
    X(REGISTRATION_delay, FOLLOWS)

#define RMAP_CROSSING_LANES                                                                        \
    (RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_relative) |       \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_direction) |                                                \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path) |                                             \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay))

enum rmap_lane_id {
#define RMAP_ENUM(column, role) RMAP_LANE_##column,
    RMAP_LANES(RMAP_ENUM)
#undef RMAP_ENUM
        RMAP_LANE_COUNT
};

/* Lanes of a portion: all where it is of a timed run. */
enum { RMAP_LANE_UNTIMED = RMAP_LANE_RAY_group_path };
static inline int rmap_lane_count(bool timed)
{
    return timed ? RMAP_LANE_COUNT : RMAP_LANE_UNTIMED;
}

/* What a lane is predicted from: its like before it (SIMPLE), or segments that are traced again;
 * then whether later predictions depend on it (LEADS) or not (FOLLOWS). PLACED: `relative` stands
 * as it is, and `cell` is predicted from it; in portions of programs before format 5 both follow
 * from segments. */
enum rmap_lane_role { RMAP_LANE_SIMPLE, RMAP_LANE_LEADS, RMAP_LANE_FOLLOWS, RMAP_LANE_PLACED };

/* How a portion stores a lane. */
enum rmap_lane_mode {
    RMAP_LANE_PREDICTED, /* nothing: every prediction is right */
    RMAP_LANE_PATCHED,   /* differences where there are any */
    RMAP_LANE_RESIDUAL,  /* a difference for every number */
    RMAP_LANE_VERBATIM   /* the numbers as they are */
};

/* What this program predicts, and what older portions, without its flag, may have stored. */
struct rmap_predicted {
    bool weighed; /* colours beside scatter models */
    bool metals;  /* and those of metals, and of facets, with models */
    bool films;   /* and those at films */
    bool turbid;  /* what happens inside media: some medium scatters, or gives light back */
};

struct rmap_lane_header {
    uint64_t seed, first_ray;
    bool one_by_one; /* every ray is to be followed by itself */
    bool placed;     /* lanes of that role stand by themselves */
    bool classed;    /* segments of own paths are stored as classes of steps, */
    uint8_t n_code;  /* which have so many codes (src/compact/step_codes.h); 0: none */
    struct rmap_predicted predicted;
    bool angled;        /* angles of registrations stand behind the lanes (src/compact/angles.h), */
    bool arrives;       /* then the paths of rays that arrive (src/compact/arrivals.h), */
    uint16_t n_arrival; /* of so many, */
    bool measured;      /* and lengths of own paths behind these (src/compact/own_lengths.h) */
    struct rmap_angle_rows angles; /* decoding: borrowed; NULL: not there */
    int n_lane;                    /* rmap_lane_count; of others, nothing is stored */
    uint8_t mode[RMAP_LANE_COUNT];
    uint64_t n_patch[RMAP_LANE_COUNT];
};

/* Rows of pool64 that a header takes, at most; and one of so many lanes. */
enum { RMAP_LANE_HEADER_ROWS = 4 + RMAP_LANE_COUNT };
static inline size_t rmap_lane_header_rows(int n_lane)
{
    return 4 + (size_t)n_lane;
}

void rmap_lane_header_write(const struct rmap_lane_header *header,
                            uint64_t row[RMAP_LANE_HEADER_ROWS]);

/* Says afterwards that segments of own paths are stored as classes of steps, with so many codes. */
void rmap_lane_header_set_classed(uint64_t row[RMAP_LANE_HEADER_ROWS], size_t n_code);

/* Says afterwards that angles, paths of n rays that arrive, or lengths of own paths, stand behind
 * the lanes. */
void rmap_lane_header_set_angled(uint64_t row[RMAP_LANE_HEADER_ROWS]);
void rmap_lane_header_set_arrivals(uint64_t row[RMAP_LANE_HEADER_ROWS], uint16_t n);
void rmap_lane_header_set_measured(uint64_t row[RMAP_LANE_HEADER_ROWS]);

/* row: [n] the portion's rows of pool64. *n_used_ret: those of the header. RMAP_FORMAT where there
 * is none, or one of lanes that this program does not know. */
enum rmap_status rmap_lane_header_read(const uint64_t *row, size_t n,
                                       struct rmap_lane_header *header, size_t *n_used_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

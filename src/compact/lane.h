/* SPDX-License-Identifier: MIT
 *
 * A lane is a column whose numbers are predicted. The same code runs in both directions: it
 * offers a prediction and gets the true number back. Encoding, the truth is in the portion, and
 * differences are noted; decoding, the notes correct the prediction.
 *
 * A difference is that of the bits taken as an integer of the number's width (those of floats so
 * ordered that the next float is the next integer), modulo 2^width, sign in the lowest bit.
 */
#ifndef RMAP_COMPACT_LANE_H
#define RMAP_COMPACT_LANE_H

#include <stdbool.h>
#include <string.h>

#include "base/status.h"
#include "compact/layout.h"
#include "portion/portion.h"

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
    X(REGISTRATION_cell, FOLLOWS)                                                                  \
    X(REGISTRATION_relative, FOLLOWS)                                                              \
    X(REGISTRATION_direction, FOLLOWS)                                                             \
    X(REGISTRATION_optical_path, FOLLOWS)

enum rmap_lane_id {
#define RMAP_ENUM(column, role) RMAP_LANE_##column,
    RMAP_LANES(RMAP_ENUM)
#undef RMAP_ENUM
        RMAP_LANE_COUNT
};

/* What a lane is predicted from: its like before it (SIMPLE), or segments that are traced again;
 * then whether later predictions depend on it (LEADS) or not (FOLLOWS). */
enum rmap_lane_role { RMAP_LANE_SIMPLE, RMAP_LANE_LEADS, RMAP_LANE_FOLLOWS };

/* How a portion stores a lane; two bits of its header. */
enum rmap_lane_mode {
    RMAP_LANE_PREDICTED, /* nothing: every prediction is right */
    RMAP_LANE_PATCHED,   /* differences where there are any */
    RMAP_LANE_RESIDUAL,  /* a difference for every number */
    RMAP_LANE_VERBATIM   /* the numbers as they are */
};

struct rmap_lane {
    enum rmap_column column;
    enum rmap_element element;
    size_t element_nbytes;
    size_t n;            /* numbers */
    size_t before;       /* encoding: of them, those of the parts before */
    const uint8_t *from; /* encoding: the column, of this part; NULL: decoding */
    uint8_t *to;         /* decoding: the column, or NULL when it is not asked for */

    /* Encoding: the differences. */
    uint32_t *skip;
    uint64_t *value;
    size_t n_patch, cap_patch, cap_value;
    size_t last; /* number after the last patch, counted from the first part on */
    enum rmap_status status;

    /* Decoding: the first number that may differ. */
    enum rmap_lane_mode mode;
    size_t next;
    const uint8_t *dense;
    const uint32_t *patch_skip;
    const uint64_t *patch_value;
    size_t patches_left;
};

/* Number i of a column of numbers of 2, 4 or 8 bytes. */
static inline void rmap_put_bits(uint8_t *data, size_t i, size_t nbytes, uint64_t bits)
{
    uint16_t two = (uint16_t)bits;
    uint32_t four = (uint32_t)bits;
    switch (nbytes) {
    case 2:
        memcpy(data + 2 * i, &two, 2);
        break;
    case 4:
        memcpy(data + 4 * i, &four, 4);
        break;
    default:
        memcpy(data + 8 * i, &bits, 8);
    }
}

/* Slow sides of rmap_lane_offer: *value becomes the truth. rmap_lane_correct: true when it was, as
 * numbers of a lane that is stored whole may be. */
void rmap_lane_note(struct rmap_lane *lane, size_t first, size_t count, void *value);
bool rmap_lane_correct(struct rmap_lane *lane, size_t first, size_t count, void *value);

/* Encoding: as rmap_lane_offer, but the predictions stay. */
bool rmap_lane_match(struct rmap_lane *lane, size_t first, size_t count, const void *predicted);

/* Decoding: corrects numbers [first, end) of the column in place. */
void rmap_lane_amend(struct rmap_lane *lane, size_t first, size_t end);

/* Offers predictions for `count` numbers from `first` on; *value becomes the truth. True when
 * they are right. Numbers must be offered in order, each once. */
static inline bool rmap_lane_offer(struct rmap_lane *lane, size_t first, size_t count,
                                   size_t element_nbytes, void *value)
{
    if (lane->from) {
        if (memcmp(lane->from + first * element_nbytes, value, count * element_nbytes) == 0)
            return true;
        rmap_lane_note(lane, first, count, value);
        return false;
    }
    if (first + count <= lane->next) {
        if (lane->to)
            memcpy(lane->to + first * element_nbytes, value, count * element_nbytes);
        return true;
    }
    return rmap_lane_correct(lane, first, count, value);
}

/* Decoding: numbers [first, end) stand in the column as predicted (or it is not asked for); makes
 * them the truth. Encoding: offers predictions for them. */
static inline void rmap_lane_settle(struct rmap_lane *lane, size_t first, size_t end,
                                    const void *predicted)
{
    if (lane->from)
        (void)rmap_lane_match(lane, first, end - first, predicted);
    else if (end > lane->next)
        rmap_lane_amend(lane, first, end);
}

/* Numbers of each width that the streams of a portion take. */
struct rmap_lane_store {
    uint16_t *pool16;
    uint32_t *pool32;
    uint64_t *pool64;
    uint32_t *skip;
    uint64_t *value;
    size_t n16, n32, n64, n_patch;
    size_t cap16, cap32, cap64, cap_skip, cap_value;
};

/* Rows of pool64 before the lanes: modes, seed, first id, then the patches of each lane that is
 * patched. */
#define RMAP_HEADER_ONE_BY_ONE (UINT64_C(1) << (2 * RMAP_LANE_COUNT)) /* in the modes */
enum { RMAP_HEADER_MODES, RMAP_HEADER_SEED, RMAP_HEADER_FIRST, RMAP_HEADER_COUNT };

void rmap_lanes_init(struct rmap_lane *lane);
void rmap_lanes_fini(struct rmap_lane *lane);

/* Encoding: lanes without numbers, and over the columns of the next part of a portion; the first
 * may be all of it. */
void rmap_lanes_begin(struct rmap_lane *lane);
void rmap_lanes_continue(struct rmap_lane *lane, const struct rmap_portion *part);

/* Encoding: whether the lanes can be stored without a look at their numbers, which only the last
 * part has at hand. */
bool rmap_lanes_sparse(const struct rmap_lane *lane);

/* Encoding: empties the store and writes header and lanes into it. start: of the header, the modes
 * with flags alone. RMAP_SYSTEM when memory is, or was, short. */
enum rmap_status rmap_lanes_store(const struct rmap_lane *lane,
                                  const uint64_t start[RMAP_HEADER_COUNT],
                                  struct rmap_lane_store *store,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_lane_store_fini(struct rmap_lane_store *store);

/* Decoding: the streams of a portion's rows, borrowed. */
struct rmap_lane_store rmap_lane_store_of(const struct rmap_rows *rows);

/* Decoding: lanes from the stores' rows (borrowed), for columns with n numbers each; verbatim
 * columns are copied. RMAP_FORMAT when the rows are not exactly what the header says. */
enum rmap_status rmap_lanes_load(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                 rmap_column_set columns, struct rmap_portion *portion,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Decoding: the true ids of n rays, of a portion whose header says `first`. */
void rmap_lane_fill_ids(struct rmap_lane *lane, uint64_t first, size_t n, uint64_t *out);

#endif

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
#include "compact/lane_header.h"
#include "compact/layout.h"
#include "portion/portion.h"

struct rmap_lane {
    enum rmap_column column;
    enum rmap_lane_role role;
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
    uint8_t *whole; /* the numbers of all parts, of a lane that is stored as it is whatever they
                       are; NULL: of others */
    size_t cap_whole;

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
    size_t n16_behind; /* rows of pool16 that lengths of own paths take, where there are any */
    size_t cap16, cap32, cap64, cap_skip, cap_value;
};

void rmap_lanes_init(struct rmap_lane *lane);
void rmap_lanes_fini(struct rmap_lane *lane);

/* Encoding: lanes without numbers, and over the columns of the next part of a portion; the first
 * may be all of it. */
void rmap_lanes_begin(struct rmap_lane *lane);
void rmap_lanes_continue(struct rmap_lane *lane, const struct rmap_portion *part);

/* Encoding: whether the lanes can be stored without a look at their numbers, which only the last
 * part has at hand. */
bool rmap_lanes_sparse(const struct rmap_lane *lane);

/* Encoding: empties the store and writes header and lanes into it. header: all but the lanes, which
 * are set. RMAP_SYSTEM when memory is, or was, short. */
enum rmap_status rmap_lanes_store(const struct rmap_lane *lane, struct rmap_lane_header *header,
                                  struct rmap_lane_store *store,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_lane_store_fini(struct rmap_lane_store *store);

/* Decoding: the streams of a portion's rows, borrowed. */
struct rmap_lane_store rmap_lane_store_of(const struct rmap_rows *rows);

/* Decoding: lanes from the stores' rows (borrowed), for columns with n numbers each. used: columns
 * whose lanes are looked at; rows that only others have may be missing (NULL). RMAP_FORMAT when the
 * rows are not exactly what the header says. */
enum rmap_status rmap_lanes_load(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                 rmap_column_set columns, rmap_column_set used,
                                 struct rmap_portion *portion, struct rmap_lane_header *header,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Decoding: numbers that stand in the lane's column, which is asked for, as predicted become the
 * truth. */
void rmap_lane_finish(struct rmap_lane *lane);

/* Decoding: the true ids of n rays, of a portion whose header says `first`. */
void rmap_lane_fill_ids(struct rmap_lane *lane, uint64_t first, size_t n, uint64_t *out);

#endif

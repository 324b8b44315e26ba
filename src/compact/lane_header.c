/* SPDX-License-Identifier: MIT
 *
 * What a portion says of its lanes, before them: how each is stored.
 */
#include "compact/lane_header.h"

#include "compact/damaged.h"

/* Row 0. Without TABLE, as formats 2 to 4 have it: two bits of mode for each lane, and ONE_BY_ONE
 * behind them; the numbers of patches follow, of patched lanes alone. */
#define TABLE          (UINT64_C(1) << 63)
#define ONE_BY_ONE     UINT64_C(1)
#define PLACED         UINT64_C(2)
#define CLASSED        UINT64_C(4)
#define MEASURED       UINT64_C(8)
#define WEIGHED        UINT64_C(16)
#define TURBID         UINT64_C(32)
#define METALS         UINT64_C(64)
#define FILMS          UINT64_C(128)
#define ANGLED         (UINT64_C(1) << 16)
#define ARRIVES        (UINT64_C(1) << 17)
#define ARRIVALS       (UINT64_C(0xffff) << ARRIVALS_AT)
#define CODES          (UINT64_C(255) << CODES_AT)
#define OLD_ONE_BY_ONE (UINT64_C(1) << (2 * RMAP_LANE_UNTIMED))

enum {
    ROW_FLAGS,
    ROW_SEED,
    ROW_FIRST,
    ROW_LANES,
    OLD_ROWS = ROW_LANES,
    MODE_BITS = 8,
    CODES_AT = 8,
    ARRIVALS_AT = 32
};

_Static_assert(ROW_LANES + 1 + RMAP_LANE_COUNT == RMAP_LANE_HEADER_ROWS, "rows of a header");

void rmap_lane_header_write(const struct rmap_lane_header *header,
                            uint64_t row[RMAP_LANE_HEADER_ROWS])
{
    row[ROW_FLAGS] =
        TABLE | (header->one_by_one ? ONE_BY_ONE : 0) | (header->placed ? PLACED : 0) |
        (header->predicted.weighed ? WEIGHED : 0) | (header->predicted.turbid ? TURBID : 0) |
        (header->predicted.metals ? METALS : 0) | (header->predicted.films ? FILMS : 0) |
        (header->classed ? CLASSED | (uint64_t)header->n_code << CODES_AT : 0);
    row[ROW_SEED] = header->seed;
    row[ROW_FIRST] = header->first_ray;
    row[ROW_LANES] = (uint64_t)header->n_lane;
    for (int i = 0; i < header->n_lane; i++)
        row[ROW_LANES + 1 + i] = header->n_patch[i] << MODE_BITS | header->mode[i];
}

void rmap_lane_header_set_classed(uint64_t row[RMAP_LANE_HEADER_ROWS], size_t n_code)
{
    row[ROW_FLAGS] |= CLASSED | (uint64_t)n_code << CODES_AT;
}

void rmap_lane_header_set_angled(uint64_t row[RMAP_LANE_HEADER_ROWS])
{
    row[ROW_FLAGS] |= ANGLED;
}

void rmap_lane_header_set_arrivals(uint64_t row[RMAP_LANE_HEADER_ROWS], uint16_t n)
{
    row[ROW_FLAGS] |= ARRIVES | (uint64_t)n << ARRIVALS_AT;
}

void rmap_lane_header_set_measured(uint64_t row[RMAP_LANE_HEADER_ROWS])
{
    row[ROW_FLAGS] |= MEASURED;
}

static enum rmap_status read_table(const uint64_t *row, size_t n, struct rmap_lane_header *header,
                                   size_t *n_used_ret, struct rmap_error *err)
{
    const uint64_t flags = row[ROW_FLAGS];
    const uint64_t n_lane = n > ROW_LANES ? row[ROW_LANES] : 0;
    if (n <= ROW_LANES || n - ROW_LANES - 1 < n_lane)
        return rmap_portion_damaged("its header is cut off", err);
    if ((flags & ~(TABLE | ONE_BY_ONE | PLACED | CLASSED | MEASURED | WEIGHED | TURBID | METALS |
                   FILMS | CODES | ANGLED | ARRIVES | ARRIVALS)) ||
        ((flags & CODES) && !(flags & CLASSED)) || ((flags & ARRIVALS) && !(flags & ARRIVES)) ||
        (n_lane != RMAP_LANE_UNTIMED && n_lane != RMAP_LANE_COUNT))
        return rmap_portion_damaged("its header has unknown lanes", err);
    header->one_by_one = flags & ONE_BY_ONE;
    header->placed = flags & PLACED;
    header->classed = flags & CLASSED;
    header->angled = flags & ANGLED;
    header->arrives = flags & ARRIVES;
    header->n_arrival = (uint16_t)((flags & ARRIVALS) >> ARRIVALS_AT);
    header->measured = flags & MEASURED;
    header->predicted.weighed = flags & WEIGHED;
    header->predicted.turbid = flags & TURBID;
    header->predicted.metals = flags & METALS;
    header->predicted.films = flags & FILMS;
    header->n_code = (uint8_t)((flags & CODES) >> CODES_AT);
    header->n_lane = (int)n_lane;
    *n_used_ret = rmap_lane_header_rows(header->n_lane);
    for (int i = 0; i < header->n_lane; i++) {
        const uint64_t lane = row[ROW_LANES + 1 + i];
        header->mode[i] = (uint8_t)(lane & ((1 << MODE_BITS) - 1));
        header->n_patch[i] = lane >> MODE_BITS;
        if (header->mode[i] > RMAP_LANE_VERBATIM ||
            (header->n_patch[i] > 0) != (header->mode[i] == RMAP_LANE_PATCHED))
            return rmap_portion_damaged("its header has a lane stored in no known way", err);
    }
    if (header->placed && header->mode[RMAP_LANE_REGISTRATION_relative] != RMAP_LANE_VERBATIM)
        return rmap_portion_damaged("places of its registrations do not stand by themselves", err);
    return RMAP_OK;
}

static enum rmap_status read_modes(const uint64_t *row, size_t n, struct rmap_lane_header *header,
                                   size_t *n_used_ret, struct rmap_error *err)
{
    const uint64_t modes = row[ROW_FLAGS];
    if (modes >= OLD_ONE_BY_ONE << 1)
        return rmap_portion_damaged("its header has unknown lanes", err);
    header->one_by_one = modes & OLD_ONE_BY_ONE;
    *n_used_ret = OLD_ROWS;
    header->n_lane = RMAP_LANE_UNTIMED;
    for (int i = 0; i < header->n_lane; i++) {
        header->mode[i] = modes >> (2 * i) & 3;
        if (header->mode[i] != RMAP_LANE_PATCHED)
            continue;
        if (*n_used_ret == n)
            return rmap_portion_damaged("its header is cut off", err);
        header->n_patch[i] = row[(*n_used_ret)++];
        if (header->n_patch[i] == 0)
            return rmap_portion_damaged("it has other patches than its header says", err);
    }
    return RMAP_OK;
}

enum rmap_status rmap_lane_header_read(const uint64_t *row, size_t n,
                                       struct rmap_lane_header *header, size_t *n_used_ret,
                                       struct rmap_error *err)
{
    if (n < OLD_ROWS)
        return rmap_portion_damaged("it has no header", err);
    *header = (struct rmap_lane_header){.seed = row[ROW_SEED], .first_ray = row[ROW_FIRST]};
    return row[ROW_FLAGS] & TABLE ? read_table(row, n, header, n_used_ret, err)
                                  : read_modes(row, n, header, n_used_ret, err);
}

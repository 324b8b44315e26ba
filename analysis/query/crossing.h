/* SPDX-License-Identifier: MIT
 *
 * Which rays of a portion come to a detector.
 */
#ifndef RMAP_CROSSING_H
#define RMAP_CROSSING_H

#include "io/map/map_reader.h"

/* One per thread and detector. */
struct rmap_crossing_filter {
    int32_t detector;
    size_t piece;     /* whose paths `crosses` is of, where there are any */
    uint8_t *crosses; /* [its paths] 1: a registration of it names the detector */
    uint8_t *own;     /* [rays of the portion that tell it themselves] */
    size_t cap, cap_own;
};
void rmap_crossing_fini(struct rmap_crossing_filter *self);

/* Clears the marks of rays without a registration of the detector: by their paths where these tell,
 * else by columns. rays: the portion that the cursor has in hand. match: [its rays]. Errors as of
 * rmap_cursor_fetch. */
enum rmap_status rmap_crossing_keep(struct rmap_crossing_filter *self, struct rmap_cursor *cursor,
                                    const struct rmap_portion *rays, size_t piece, uint8_t *match,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * The paths of the rays that may arrive at a detector, so that questions about registrations leave
 * those of all others unread.
 *
 * A ray arrives whose path has registrations, registered or not, and every ray with a path of its
 * own. Their references, as /ray/path has them, stand in order behind the lanes of pool16 and what
 * else is said of registrations there, before lengths of own paths; the header says how many.
 */
#ifndef RMAP_COMPACT_ARRIVALS_H
#define RMAP_COMPACT_ARRIVALS_H

#include <stdbool.h>

#include "compact/lane_header.h"
#include "compact/paths.h"

/* Where more than one of so many rays arrive, the portion does not say which. */
enum { RMAP_ARRIVALS_SHARE = 2 };

/* Whether rays with this reference do, whose path has so many registrations. */
static inline bool rmap_arrives(uint32_t path, size_t n_registration)
{
    return path == 0 || n_registration > 0;
}

/* Whether paths and places are all that a portion stores of its registrations: else it need not say
 * which rays arrive, for nobody asks. */
bool rmap_arrivals_suffice(const struct rmap_lane_header *header);

/* A portion's rays that arrive, as rows of a portion of them alone. */
struct rmap_arrivals {
    uint32_t *path; /* [cap] references of n rays, which have so many segments */
    size_t cap, n, n_segment;
    uint16_t *place; /* [n_place] rows of pool16: of registrations */
    size_t n_place, n_header;
    uint64_t header[RMAP_LANE_HEADER_ROWS]; /* [n_header] */
};
void rmap_arrivals_fini(struct rmap_arrivals *self); /* zeroed: fine */

/* The references of a portion whose header says that they are there: path [header->n_arrival].
 * RMAP_FORMAT where they are not, or refer to no path. rows: with pool16. */
enum rmap_status rmap_arrivals_read(const struct rmap_rows *rows,
                                    const struct rmap_compact_summary *header,
                                    const struct rmap_path_table *table, uint32_t *path,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Finds the rays that arrive. rows: pool16, pool64, counts of own paths, borrowed as long as what
 * is found; summary: of their header; n_row: as the index promises. *told_ret: false where the
 * portion does not tell. RMAP_FORMAT as of decoding, but for whether paths add up to the rows of
 * registrations. */
enum rmap_status rmap_arrivals_find(struct rmap_arrivals *self, const struct rmap_path_table *table,
                                    bool timed, const struct rmap_rows *rows,
                                    const struct rmap_compact_summary *summary,
                                    const size_t n_row[RMAP_TABLE_COUNT], bool *told_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Turns any rows of that portion, and what the index promises, into those of the rays found, with
 * places of registrations and what paths say; borrowed from self. */
void rmap_arrivals_narrow(struct rmap_arrivals *self, struct rmap_rows *rows,
                          size_t n_row[RMAP_TABLE_COUNT]);

#endif

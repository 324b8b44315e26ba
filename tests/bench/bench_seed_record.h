/* SPDX-License-Identifier: MIT
 *
 * The reference's file, which its writer and its reader share: portions, each a header and three
 * zlib streams.
 */
#ifndef RMAP_BENCH_SEED_RECORD_H
#define RMAP_BENCH_SEED_RECORD_H

#include <stdint.h>

/* One end of a segment: a ray of n segments has n + 1, the last one for where it ended. */
struct rmap_seed_segment {
    float point[3];
    uint32_t event;
    int32_t triangle;
    uint32_t first_device; /* of the device records, within the portion */
    int16_t source;
    int16_t object;
    int16_t normal[3];
    uint16_t n_device;
};

struct rmap_seed_device {
    int16_t device;
    uint16_t cell[2];
    int16_t cosine; /* x 32767 */
    uint16_t relative[2];
    uint16_t registered;
};

_Static_assert(sizeof(struct rmap_seed_segment) == 36, "the reference's records have 36 bytes");
_Static_assert(sizeof(struct rmap_seed_device) == 14, "no padding");

enum rmap_seed_stream { RMAP_SEED_SEGMENT, RMAP_SEED_DEVICE, RMAP_SEED_COLOUR, RMAP_SEED_STREAMS };

/* What the event of a ray's last record is: no event bit of a segment. */
#define RMAP_SEED_END 0x80000000u

struct rmap_seed_header {
    uint64_t stored[RMAP_SEED_STREAMS], raw[RMAP_SEED_STREAMS]; /* bytes */
};

#endif

/* SPDX-License-Identifier: MIT
 *
 * About how long the rays with paths of their own are.
 */
#include "compact/own_lengths.h"

#include <math.h>
#include <string.h>

#include "compact/damaged.h"
#include "compact/streams.h"

enum { CODE_BITS = 8, HEAD = 3 };

static const uint32_t infinite = UINT32_C(0x7f800000);

/* Of a length that is none: beyond the infinite. */
static uint32_t bits_of(double length)
{
    float down = (float)length;
    uint32_t bits;
    if ((double)down > length)
        down = nextafterf(down, 0.0f);
    memcpy(&bits, &down, sizeof bits);
    return length >= 0.0 && !signbit(length) ? bits : UINT32_MAX;
}

static float float_of(uint64_t bits)
{
    const uint32_t few = bits < infinite ? (uint32_t)bits : infinite;
    float x;
    memcpy(&x, &few, sizeof x);
    return x;
}

bool rmap_own_lengths_make(const double *length, size_t n, uint16_t *row)
{
    uint32_t least = UINT32_MAX, most = 0, shift = 0;
    for (size_t i = 0; i < n; i++) {
        const uint32_t bits = bits_of(length[i]);
        least = bits < least ? bits : least;
        most = bits > most ? bits : most;
    }
    if (n == 0 || most >= infinite)
        return false;
    while ((most - least) >> shift >= 1u << CODE_BITS)
        shift++;
    memset(row, 0, rmap_own_length_rows(n) * sizeof *row);
    row[0] = (uint16_t)(least & 0xffff);
    row[1] = (uint16_t)(least >> 16);
    row[2] = (uint16_t)shift;
    for (size_t i = 0; i < n; i++)
        row[HEAD + i / 2] |=
            (uint16_t)((bits_of(length[i]) - least) >> shift << CODE_BITS * (i % 2));
    return true;
}

enum rmap_status rmap_own_lengths_read(const struct rmap_rows *rows, struct rmap_path_sum *sum,
                                       struct rmap_error *err)
{
    const size_t n = rows->n_row[RMAP_COMPACT_OWN], n16 = rows->n_row[RMAP_COMPACT_POOL16];
    float edge[(1 << CODE_BITS) + 1];
    if (n16 < rmap_own_length_rows(n))
        return rmap_portion_damaged("it has fewer lengths than paths of its own", err);
    const uint16_t *row =
        (const uint16_t *)rows->data[RMAP_STREAM_pool16] + (n16 - rmap_own_length_rows(n));
    if (row[2] >= 32)
        return rmap_portion_damaged("lengths of its own paths are none", err);
    const uint64_t least = row[0] | (uint64_t)row[1] << 16;
    for (uint64_t k = 0; k < sizeof edge / sizeof *edge; k++)
        edge[k] = float_of(least + (k << row[2]));
    for (size_t i = 0; i < n; i++) {
        const unsigned code = row[HEAD + i / 2] >> CODE_BITS * (i % 2) & ((1 << CODE_BITS) - 1);
        sum[i] = (struct rmap_path_sum){.path_length = {edge[code], edge[code + 1]},
                                        .optical_path = {NAN, NAN}};
    }
    return RMAP_OK;
}

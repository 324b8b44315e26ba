/* SPDX-License-Identifier: MIT
 *
 * Zemax's archives (.zar): a lens, its glass catalogues, coatings and settings, one after another,
 * each behind a head with its size and name; names that end in .LZW are packed.
 *
 * Heads, as open readers have them (zmxtools): of 0x14c bytes, beginning 0xea, with the size as 4
 * bytes at 0x0c and the name at 0x20; or of 0x288 bytes, beginning 0xec, with the size as 8 bytes
 * at 0x10 and the name in UTF-16 at 0x30. Numbers are little-endian.
 */
#ifndef RMAP_LENS_ZAR_H
#define RMAP_LENS_ZAR_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_zar_file {
    char name[128]; /* letters beyond ASCII as '?' */
    size_t nbytes;
    uint8_t *bytes; /* unpacked, with a 0 behind them; rmap_free */
};

/* The next file at *at of an archive; *at goes behind it. `suffix` ".zmx": those of other names are
 * passed over; NULL: all count. False in *found: there is none any more. RMAP_INPUT: it is no such
 * archive, or is cut off, or unpacks to more than 256 MiB; RMAP_SYSTEM. */
enum rmap_status rmap_zar_next(const uint8_t *archive, size_t nbytes, size_t *at,
                               const char *suffix, struct rmap_zar_file *file, bool *found,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * The seal behind the last byte that HDF5 knows of: a hash of everything in the file but stored
 * chunks, which have checksums of their own. HDF5 1.10 may crash on damaged metadata, so a file is
 * opened with it only after its seal held. HDF5 itself and its tools pass over trailing bytes.
 *
 *   ranges  n x {u64 first byte, u64 bytes}   the chunks, by place, not overlapping
 *   footer  u64 n, u64 XXH3-64 of all other bytes before the seal, u64 XXH3-64 of the ranges and
 *           the two words before, 8 bytes "rmapseal"; all little-endian
 */
#ifndef RMAP_SEAL_H
#define RMAP_SEAL_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_range {
    uint64_t offset, nbytes;
};

/* Appends the seal to a closed file. Sorts the ranges by offset. RMAP_SYSTEM. */
enum rmap_status rmap_seal_write(const char *path, struct rmap_range *range, size_t n,
                                 struct rmap_error *err) RMAP_MUST_USE;
/* The same, through a descriptor that reads and writes. */
enum rmap_status rmap_seal_append(int fd, const char *path, struct rmap_range *range, size_t n,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_FORMAT when there is no seal (cut off, or no file of a map) or it does not hold. */
enum rmap_status rmap_seal_check(const char *path, struct rmap_error *err) RMAP_MUST_USE;

#endif

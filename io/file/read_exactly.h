/* SPDX-License-Identifier: MIT
 *
 * Bytes at a place of a file, all of them or a failure.
 */
#ifndef RMAP_READ_EXACTLY_H
#define RMAP_READ_EXACTLY_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* RMAP_FORMAT when the file ends before, RMAP_SYSTEM when it cannot be read. */
enum rmap_status rmap_read_exactly(int fd, uint8_t *to, size_t nbytes, uint64_t offset,
                                   struct rmap_error *err) RMAP_MUST_USE;

#endif

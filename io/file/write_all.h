/* SPDX-License-Identifier: MIT
 *
 * Bytes into a file or to who listens, all of them or a failure.
 */
#ifndef RMAP_WRITE_ALL_H
#define RMAP_WRITE_ALL_H

#include <stdbool.h>
#include <stddef.h>

/* Where the descriptor stands. False: errno says why; some may have been written. */
bool rmap_write_all(int fd, const void *from, size_t nbytes);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Bytes at a place of a file, all of them or a failure.
 */
#include "io/file/read_exactly.h"

#include <errno.h>
#include <string.h>
#include <unistd.h>

enum rmap_status rmap_read_exactly(int fd, uint8_t *to, size_t nbytes, uint64_t offset,
                                   struct rmap_error *err)
{
    while (nbytes > 0) {
        ssize_t got = pread(fd, to, nbytes, (off_t)offset);
        if (got < 0 && errno == EINTR)
            continue;
        if (got < 0)
            return rmap_error_set(err, RMAP_SYSTEM, "reading failed: %s", strerror(errno));
        if (got == 0)
            return rmap_error_set(err, RMAP_FORMAT, "the file ends before its rows do");
        to += got;
        nbytes -= (size_t)got;
        offset += (uint64_t)got;
    }
    return RMAP_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * Bytes into a file or to who listens, all of them or a failure.
 */
#include "io/file/write_all.h"

#include <errno.h>
#include <unistd.h>

bool rmap_write_all(int fd, const void *from, size_t nbytes)
{
    const char *at = from;
    while (nbytes > 0) {
        const ssize_t written = write(fd, at, nbytes);
        if (written < 0 && errno == EINTR)
            continue;
        if (written == 0)
            errno = EIO;
        if (written <= 0)
            return false;
        at += written;
        nbytes -= (size_t)written;
    }
    return true;
}

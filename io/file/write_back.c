/* SPDX-License-Identifier: MIT
 *
 * Files on their way to the disk.
 */
#define _GNU_SOURCE /* sync_file_range */
#include "io/file/write_back.h"

#include <fcntl.h>

void rmap_write_back_begin(int fd)
{
#ifdef SYNC_FILE_RANGE_WRITE
    (void)sync_file_range(fd, 0, 0, SYNC_FILE_RANGE_WRITE);
#else
    (void)fd;
#endif
}

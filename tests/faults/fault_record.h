/* SPDX-License-Identifier: MIT
 *
 * The recorder: every change of a file or directory below FAULTS_DIR, in the order in which it was
 * made, so that a script can replay any prefix and lose what was not yet synced.
 *
 * One record, all numbers little-endian: struct fault_record_head, then path_nbytes bytes of the
 * path, other_nbytes of the second path (link, rename), data_nbytes of what was written. Times are
 * of the monotonic clock, at the end of the call, and order the records of several ranks.
 */
#ifndef FAULT_RECORD_H
#define FAULT_RECORD_H

#include <stddef.h>
#include <stdint.h>
#include <sys/types.h>

enum fault_operation {
    FAULT_OPERATION_CREATE = 1, /* or opened for writing; offset: flags of open */
    FAULT_OPERATION_WRITE,
    FAULT_OPERATION_TRUNCATE, /* offset: new length */
    FAULT_OPERATION_SYNC,     /* fsync or fdatasync, of a file or a directory */
    FAULT_OPERATION_LINK,
    FAULT_OPERATION_RENAME,
    FAULT_OPERATION_UNLINK,
    FAULT_OPERATION_MKDIR,
    FAULT_OPERATION_RMDIR
};

struct fault_record_head {
    uint64_t time_ns;
    uint64_t offset;
    uint32_t operation;
    uint32_t path_nbytes, other_nbytes, data_nbytes;
};

/* A change and its record are one: nobody else's change comes between. */
void fault_record_begin(void);
void fault_record_end(void);

/* Between begin and end, after a call that succeeded. */
void fault_record_path(enum fault_operation operation, const char *path, const char *other,
                       uint64_t offset);
void fault_record_write(const char *path, off_t offset, const void *data, size_t nbytes);

#endif

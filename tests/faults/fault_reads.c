/* SPDX-License-Identifier: MIT
 *
 * The calls that read files.
 */
#include <dirent.h>
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "fault_plan.h"

#define REAL(name)                                                                                 \
    static __typeof__(name) *real;                                                                 \
    if (!real) {                                                                                   \
        void *found = dlsym(RTLD_NEXT, #name);                                                     \
        memcpy(&real, &found, sizeof found);                                                       \
    }

ssize_t pread(int fd, void *data, size_t nbytes, off_t offset)
{
    REAL(pread)
    char path[FAULT_PATH_CAP];
    enum fault_outcome outcome =
        fault_watches_file(fd, path) ? fault_decide("read:pread", path) : FAULT_NONE;
    if (outcome == FAULT_ERROR)
        return -1;
    return real(fd, data, outcome == FAULT_NONE || nbytes < 2 ? nbytes : nbytes / 2, offset);
}

ssize_t read(int fd, void *data, size_t nbytes)
{
    REAL(read)
    char path[FAULT_PATH_CAP];
    enum fault_outcome outcome =
        fault_watches_file(fd, path) ? fault_decide("read:read", path) : FAULT_NONE;
    if (outcome == FAULT_ERROR)
        return -1;
    return real(fd, data, outcome == FAULT_NONE || nbytes < 2 ? nbytes : nbytes / 2);
}

int stat(const char *path, struct stat *info)
{
    REAL(stat)
    if (fault_watches(path) && fault_decide("read:stat", path) != FAULT_NONE)
        return -1;
    return real(path, info);
}

int fstat(int fd, struct stat *info)
{
    REAL(fstat)
    char path[FAULT_PATH_CAP];
    if (fault_watches_file(fd, path) && fault_decide("read:fstat", path) != FAULT_NONE)
        return -1;
    return real(fd, info);
}

DIR *opendir(const char *path)
{
    REAL(opendir)
    if (fault_watches(path) && fault_decide("read:opendir", path) != FAULT_NONE)
        return NULL;
    return real(path);
}

struct dirent *readdir(DIR *directory)
{
    REAL(readdir)
    char path[FAULT_PATH_CAP];
    if (fault_watches_file(dirfd(directory), path) &&
        fault_decide("read:readdir", path) != FAULT_NONE)
        return NULL;
    return real(directory);
}

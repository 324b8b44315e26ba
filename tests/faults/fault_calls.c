/* SPDX-License-Identifier: MIT
 *
 * The C library's calls that change files, as the program and HDF5 see them.
 */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include "fault_plan.h"
#include "fault_record.h"

/* The function that this library hides; POSIX allows the cast that ISO C does not. */
#define REAL(name)                                                                                 \
    static __typeof__(name) *real;                                                                 \
    if (!real) {                                                                                   \
        void *found = dlsym(RTLD_NEXT, #name);                                                     \
        memcpy(&real, &found, sizeof found);                                                       \
    }

static bool changes(int flags)
{
    return (flags & O_ACCMODE) != O_RDONLY || (flags & O_CREAT);
}

int open(const char *path, int flags, ...)
{
    REAL(open)
    va_list rest;
    va_start(rest, flags);
    mode_t mode = flags & O_CREAT ? va_arg(rest, mode_t) : 0;
    va_end(rest);
    if (!fault_watches(path))
        return real(path, flags, mode);
    if (fault_decide(changes(flags) ? "open" : "read:open", path) != FAULT_NONE)
        return -1;
    fault_record_begin();
    int fd = real(path, flags, mode);
    if (fd >= 0 && changes(flags))
        fault_record_path(FAULT_OPERATION_CREATE, path, "", (uint64_t)flags);
    fault_record_end();
    return fd;
}

ssize_t pwrite(int fd, const void *data, size_t nbytes, off_t offset)
{
    REAL(pwrite)
    char path[FAULT_PATH_CAP];
    if (!fault_watches_file(fd, path))
        return real(fd, data, nbytes, offset);
    enum fault_outcome outcome = fault_decide("pwrite", path);
    if (outcome == FAULT_ERROR)
        return -1;
    if (outcome != FAULT_NONE && nbytes > 1)
        nbytes /= 2;
    fault_record_begin();
    ssize_t n = real(fd, data, nbytes, offset);
    if (n > 0)
        fault_record_write(path, offset, data, (size_t)n);
    fault_record_end();
    if (outcome == FAULT_TEAR)
        fault_die();
    return n;
}

ssize_t write(int fd, const void *data, size_t nbytes)
{
    REAL(write)
    char path[FAULT_PATH_CAP];
    if (!fault_watches_file(fd, path))
        return real(fd, data, nbytes);
    enum fault_outcome outcome = fault_decide("write", path);
    if (outcome == FAULT_ERROR)
        return -1;
    if (outcome != FAULT_NONE && nbytes > 1)
        nbytes /= 2;
    fault_record_begin();
    ssize_t n = real(fd, data, nbytes);
    if (n > 0)
        fault_record_write(path, lseek(fd, 0, SEEK_CUR) - n, data, (size_t)n);
    fault_record_end();
    if (outcome == FAULT_TEAR)
        fault_die();
    return n;
}

int ftruncate(int fd, off_t length)
{
    REAL(ftruncate)
    char path[FAULT_PATH_CAP];
    if (!fault_watches_file(fd, path))
        return real(fd, length);
    if (fault_decide("ftruncate", path) != FAULT_NONE)
        return -1;
    fault_record_begin();
    int st = real(fd, length);
    if (st == 0)
        fault_record_path(FAULT_OPERATION_TRUNCATE, path, "", (uint64_t)length);
    fault_record_end();
    return st;
}

static int sync_file(int (*real)(int), const char *call, int fd)
{
    char path[FAULT_PATH_CAP];
    if (!fault_watches_file(fd, path))
        return real(fd);
    if (fault_decide(call, path) != FAULT_NONE)
        return -1;
    fault_record_begin();
    int st = real(fd);
    if (st == 0)
        fault_record_path(FAULT_OPERATION_SYNC, path, "", 0);
    fault_record_end();
    return st;
}

int fsync(int fd)
{
    REAL(fsync)
    return sync_file(real, "fsync", fd);
}

int fdatasync(int fd)
{
    REAL(fdatasync)
    return sync_file(real, "fdatasync", fd);
}

/* Changes nothing, so it is counted only where it is asked for by name. */
int flock(int fd, int operation)
{
    char path[FAULT_PATH_CAP];
    REAL(flock)
    if (fault_watches_file(fd, path) && fault_decide("lock:flock", path) != FAULT_NONE)
        return -1;
    return real(fd, operation);
}

/* A failed close of a file has closed it all the same. */
int close(int fd)
{
    REAL(close)
    char path[FAULT_PATH_CAP];
    bool failed = fault_watches_file(fd, path) && fault_decide("close", path) != FAULT_NONE;
    int error = errno, st = real(fd);
    if (!failed)
        return st;
    errno = error;
    return -1;
}

static int change_names(int (*real)(const char *, const char *), const char *call,
                        enum fault_operation operation, const char *from, const char *to)
{
    if (!fault_watches(to))
        return real(from, to);
    if (fault_decide(call, to) != FAULT_NONE)
        return -1;
    fault_record_begin();
    int st = real(from, to);
    if (st == 0)
        fault_record_path(operation, from, to, 0);
    fault_record_end();
    return st;
}

int link(const char *from, const char *to)
{
    REAL(link)
    return change_names(real, "link", FAULT_OPERATION_LINK, from, to);
}

int rename(const char *from, const char *to)
{
    REAL(rename)
    return change_names(real, "rename", FAULT_OPERATION_RENAME, from, to);
}

static int change_name(int (*real)(const char *), const char *call, enum fault_operation operation,
                       const char *path)
{
    if (!fault_watches(path))
        return real(path);
    if (fault_decide(call, path) != FAULT_NONE)
        return -1;
    fault_record_begin();
    int st = real(path);
    if (st == 0)
        fault_record_path(operation, path, "", 0);
    fault_record_end();
    return st;
}

int unlink(const char *path)
{
    REAL(unlink)
    return change_name(real, "unlink", FAULT_OPERATION_UNLINK, path);
}

int rmdir(const char *path)
{
    REAL(rmdir)
    return change_name(real, "rmdir", FAULT_OPERATION_RMDIR, path);
}

int mkdir(const char *path, mode_t mode)
{
    REAL(mkdir)
    if (!fault_watches(path))
        return real(path, mode);
    if (fault_decide("mkdir", path) != FAULT_NONE)
        return -1;
    fault_record_begin();
    int st = real(path, mode);
    if (st == 0)
        fault_record_path(FAULT_OPERATION_MKDIR, path, "", 0);
    fault_record_end();
    return st;
}

/* As a call by the whole path, which the plan and the record know. */
int unlinkat(int directory, const char *name, int flags)
{
    REAL(unlinkat)
    char path[FAULT_PATH_CAP];
    if (!fault_watches_file(directory, path))
        return real(directory, name, flags);
    size_t n = strlen(path);
    (void)snprintf(path + n, sizeof path - n, "/%s", name);
    return flags & AT_REMOVEDIR ? rmdir(path) : unlink(path);
}

/* SPDX-License-Identifier: MIT
 *
 * Files appear under their final names whole or not at all: written under a temporary name that
 * carries job, restart count, host and process, synced, then linked without overwriting.
 */
#include "io/file/publish.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

#define HOST_LEN 256

char *rmap_path_format(const char *format, ...)
{
    va_list args, again;
    va_start(args, format);
    va_copy(again, args);
    int length = vsnprintf(NULL, 0, format, args);
    char *path = length < 0 ? NULL : rmap_alloc((size_t)length + 1, 1);
    if (path)
        (void)vsnprintf(path, (size_t)length + 1, format, again);
    va_end(again);
    va_end(args);
    return path;
}

enum rmap_status rmap_path_check_folder(const char *path, struct rmap_error *err)
{
    struct stat info;
    enum rmap_status st = RMAP_OK;
    size_t len = strlen(path);
    while (len > 1 && path[len - 1] == '/')
        len--;
    while (len > 0 && path[len - 1] != '/')
        len--;
    char *folder = len > 1 ? rmap_path_format("%.*s", (int)len - 1, path) : NULL;
    if (folder && stat(folder, &info) != 0 && errno == ENOENT)
        st = rmap_error_set(err, RMAP_INPUT,
                            "cannot write '%s': there is no folder '%s'; make it first", path,
                            folder);
    rmap_free(folder);
    return st;
}

static const char *environment(const char *name, const char *otherwise)
{
    const char *value = getenv(name);
    return value && *value && !strchr(value, '/') ? value : otherwise;
}

char *rmap_temporary_path(const char *directory, const char *name)
{
    char host[HOST_LEN] = "host";
    (void)gethostname(host, sizeof host - 1);
    return rmap_path_format("%s/.%s.%s.%s.%s.%ld.part", directory, name,
                            environment("SLURM_JOB_ID", "0"),
                            environment("SLURM_RESTART_COUNT", "0"), host, (long)getpid());
}

static enum rmap_status system_error(struct rmap_error *err, const char *path, const char *what)
{
    return rmap_error_set(err, RMAP_SYSTEM, "%s: %s: %s", path, what, strerror(errno));
}

/* replaced: a file whose mode this one takes over; or NULL. */
static enum rmap_status sync_path(const char *path, int flags, const struct stat *replaced,
                                  struct rmap_error *err)
{
    int fd = open(path, flags | O_CLOEXEC);
    if (fd < 0)
        return system_error(err, path, "cannot open for syncing");
    int failed = replaced ? fchmod(fd, replaced->st_mode & 0777) : 0;
    failed = failed || fsync(fd);
    int reason = errno;
    if (close(fd) != 0 && !failed)
        return system_error(err, path, "closing");
    errno = reason;
    return failed ? system_error(err, path, "syncing to disk") : RMAP_OK;
}

/* File systems without hard links (some FUSE and object stores): the name is taken first with
 * O_EXCL, then the file is moved over the empty one. */
static int reserve_and_rename(const char *temporary, const char *final)
{
    int fd = open(final, O_CREAT | O_EXCL | O_WRONLY | O_CLOEXEC, 0666);
    if (fd < 0 || close(fd) != 0)
        return -1;
    if (rename(temporary, final) == 0)
        return 0;
    int reason = errno;
    (void)unlink(final);
    errno = reason;
    return -1;
}

static int link_new(const char *temporary, const char *final)
{
    if (link(temporary, final) == 0)
        return 0;
    if (errno == EPERM || errno == EOPNOTSUPP || errno == ENOSYS || errno == EMLINK)
        return reserve_and_rename(temporary, final);
    return -1;
}

enum rmap_status rmap_sync_directory(const char *directory, struct rmap_error *err)
{
    return sync_path(directory, O_RDONLY | O_DIRECTORY, NULL, err);
}

enum rmap_status rmap_sync_parent(const char *path, struct rmap_error *err)
{
    size_t n = strlen(path);
    while (n > 1 && path[n - 1] == '/')
        n--;
    while (n > 0 && path[n - 1] != '/')
        n--;
    while (n > 1 && path[n - 1] == '/')
        n--;
    char *parent = n > 0 ? rmap_path_format("%.*s", (int)n, path) : rmap_strdup(".");
    enum rmap_status st = parent ? rmap_sync_directory(parent, err)
                                 : rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    rmap_free(parent);
    return st;
}

enum rmap_status rmap_publish_new(const char *directory, const char *temporary, const char *final,
                                  bool *taken_ret, struct rmap_error *err)
{
    *taken_ret = false;
    enum rmap_status st = sync_path(temporary, O_RDWR | O_NOFOLLOW, NULL, err);
    if (st != RMAP_OK)
        return st;
    if (link_new(temporary, final) != 0) {
        *taken_ret = errno == EEXIST;
        return *taken_ret ? RMAP_OK : system_error(err, final, "cannot be published");
    }
    st = rmap_sync_directory(directory, err);
    if (st == RMAP_OK)
        (void)unlink(temporary); /* a second name harms nobody */
    return st;
}

enum rmap_status rmap_publish_over(const char *directory, const char *temporary, const char *final,
                                   struct rmap_error *err)
{
    struct stat old;
    const bool replaces = lstat(final, &old) == 0 && S_ISREG(old.st_mode);
    enum rmap_status st = sync_path(temporary, O_RDWR | O_NOFOLLOW, replaces ? &old : NULL, err);
    if (st == RMAP_OK && rename(temporary, final) != 0)
        st = system_error(err, final, "cannot be published");
    if (st == RMAP_OK)
        return rmap_sync_directory(directory, err);
    (void)unlink(temporary);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Files that who talks to a server may write. Every part of a path is opened in the one before, and
 * none that is a link, so that nobody can change the way while it is gone.
 */
#include "mpi/serve/save_below.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/file/write_all.h"

enum { PART_LEN = 256 };

static enum rmap_status outside(const char *path, const char *why, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_USAGE,
                          "%s: %s; files are saved below the folder that the server was started in",
                          path, why);
}

/* The path from the folder on; NULL: it leads elsewhere. */
static const char *from_folder(const char *folder, const char *path)
{
    const size_t n = strlen(folder);
    if (path[0] != '/')
        return path;
    return strncmp(path, folder, n) == 0 && path[n] == '/' ? path + n + 1 : NULL;
}

/* Opens the folder of the last part, which *part begins with. */
static enum rmap_status descend(const char *folder, const char *path, int *at_ret,
                                const char **last, struct rmap_error *err)
{
    const char *rest = from_folder(folder, path), *slash = NULL;
    char part[PART_LEN];
    if (!rest)
        return outside(path, "it is elsewhere", err);
    int at = open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    for (; at >= 0 && (slash = strchr(rest, '/')); rest = slash + 1) {
        const size_t n = (size_t)(slash - rest);
        if (n == 0 || (n == 1 && rest[0] == '.'))
            continue;
        if (n >= sizeof part || (n == 2 && rest[0] == '.' && rest[1] == '.')) {
            (void)close(at);
            return outside(path, "'..' leads out", err);
        }
        (void)snprintf(part, sizeof part, "%.*s", (int)n, rest);
        const int next = openat(at, part, O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
        const int code = errno;
        (void)close(at);
        if (next < 0 && (code == ELOOP || code == ENOTDIR))
            return outside(path, "a link or a file stands in the way", err);
        errno = code;
        at = next;
    }
    if (at < 0 && slash && errno == ENOENT)
        return rmap_error_set(err, RMAP_INPUT, "%s: the folder %.*s is not there", path,
                              (int)(slash - path), path);
    if (at < 0)
        return rmap_error_set(err, RMAP_SYSTEM, "%s: %s", path, strerror(errno));
    *at_ret = at;
    *last = rest;
    return RMAP_OK;
}

static enum rmap_status check_last(int at, const char *path, const char *last, bool force,
                                   mode_t *mode, struct rmap_error *err)
{
    struct stat info;
    if (!*last || strcmp(last, ".") == 0 || strcmp(last, "..") == 0 || strlen(last) >= PART_LEN)
        return outside(path, "it names no file", err);
    if (fstatat(at, last, &info, AT_SYMLINK_NOFOLLOW) != 0)
        return RMAP_OK;
    if (!S_ISREG(info.st_mode))
        return outside(path, "a link or a folder stands there", err);
    *mode = info.st_mode & 07777;
    return force ? RMAP_OK
                 : rmap_error_set(err, RMAP_USAGE, "%s exists; 'force': true replaces it", path);
}

enum rmap_status rmap_save_below(const char *folder, const char *path, const char *text, bool force,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char temporary[64];
    const char *last = NULL;
    int at = -1, file = -1;
    mode_t mode = 0;
    RMAP_TRY(descend(folder, path, &at, &last, err));
    RMAP_TRY(check_last(at, path, last, force, &mode, err));
    (void)snprintf(temporary, sizeof temporary, ".raymap-save.%ld.part", (long)getpid());
    (void)unlinkat(at, temporary, 0);
    file = openat(at, temporary, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, 0666);
    bool done = file >= 0 && rmap_write_all(file, text, strlen(text)) && fsync(file) == 0 &&
                (mode == 0 || fchmod(file, mode) == 0);
    int code = errno;
    if (file >= 0 && close(file) != 0 && done) {
        done = false;
        code = errno;
    }
    if (done && renameat(at, temporary, at, last) != 0) {
        done = false;
        code = errno;
    }
    if (!done) {
        (void)unlinkat(at, temporary, 0);
        st = rmap_error_set(err, RMAP_SYSTEM, "%s cannot be written: %s", path, strerror(code));
    }
out:
    if (at >= 0)
        (void)close(at);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * The right to write to a map: one command at a time has it, from before its first look at the map
 * until its end.
 */
#include "io/map/map_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/publish.h"

enum state { STATE_HELD, STATE_BUSY, STATE_GONE, STATE_NO_LOCKS, STATE_NO_FILE, STATE_FAILED };

static bool has_name(int fd)
{
    struct stat info;
    return fstat(fd, &info) == 0 && info.st_nlink > 0;
}

/* A holder removes the file before it lets go: what was locked may have no name any more. */
static enum state try_lock(int fd)
{
    if (flock(fd, LOCK_EX | LOCK_NB) == 0)
        return has_name(fd) ? STATE_HELD : STATE_GONE;
    if (errno == EWOULDBLOCK)
        return STATE_BUSY;
    if (errno == EINTR)
        return STATE_GONE;
    return errno == ENOLCK || errno == ENOTSUP || errno == ENOSYS || errno == EINVAL
               ? STATE_NO_LOCKS
               : STATE_FAILED;
}

/* Without locks, who made the file has the map until the file is removed. */
static enum state try_once(const char *path, int *fd_ret)
{
    const int flags = O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC;
    struct stat info;
    bool made = true;
    int fd = open(path, flags | O_CREAT | O_EXCL, 0666);
    if (fd < 0 && errno == EEXIST) {
        made = false;
        fd = open(path, flags);
    }
    *fd_ret = fd;
    if (fd < 0 && !made && errno == ENOENT)
        return STATE_GONE;
    if (fd < 0) /* a link, a folder, a socket */
        return !made && (errno == ELOOP || errno == EISDIR || errno == ENXIO) ? STATE_NO_FILE
                                                                              : STATE_FAILED;
    if (fstat(fd, &info) != 0)
        return STATE_FAILED;
    if (!S_ISREG(info.st_mode))
        return STATE_NO_FILE;
    enum state state = try_lock(fd);
    return state == STATE_NO_LOCKS && made ? STATE_HELD : state;
}

/* What the holder wrote is a stranger's data, of which one line is shown. */
static enum rmap_status busy(const char *folder, const char *path, bool is_map, int fd,
                             enum state state, struct rmap_error *err)
{
    char text[256] = "";
    ssize_t n = pread(fd, text, sizeof text - 1, 0);
    text[n > 0 ? n : 0] = 0;
    text[strcspn(text, "\n")] = 0;
    const char *shown = text[0] ? text : "it does not say which";
    if (state == STATE_BUSY)
        return rmap_error_set(err, RMAP_USAGE,
                              "%s is being written to by another raymap (%s): stop that first, or "
                              "wait for its end",
                              folder, shown);
    return rmap_error_set(err, RMAP_USAGE,
                          "%s is or was being written to by another raymap (%s), and its file "
                          "system keeps no locks: if that has ended, %s %s%s",
                          folder, shown, is_map ? "raymap repair" : "remove",
                          is_map ? folder : path, is_map ? " --break-lock" : "");
}

static void introduce(int fd, const char *command)
{
    char host[256] = "host", text[512];
    (void)gethostname(host, sizeof host - 1);
    int n = snprintf(text, sizeof text, "raymap %s, process %ld on host %s\n", command,
                     (long)getpid(), host);
    if (n > 0 && ftruncate(fd, 0) == 0)
        (void)!pwrite(fd, text, (size_t)n, 0);
}

/* Nothing stands there, or nothing that this user can write to. */
static bool needs_no_lock(const char *folder, int reason)
{
    if (reason == ENOENT || reason == ENOTDIR)
        return true;
    return (reason == EACCES || reason == EROFS || reason == EPERM) &&
           faccessat(AT_FDCWD, folder, W_OK, AT_EACCESS) != 0;
}

static enum rmap_status refuse(const char *folder, const char *path, bool is_map, int fd,
                               enum state state, struct rmap_error *err)
{
    const char *what = is_map ? "map" : "folder";
    int reason = errno;
    if (state == STATE_BUSY || state == STATE_NO_LOCKS)
        return busy(folder, path, is_map, fd, state, err);
    if (state == STATE_FAILED && needs_no_lock(folder, reason))
        return RMAP_OK;
    if (state == STATE_NO_FILE)
        return rmap_error_set(err, RMAP_SYSTEM,
                              "%s is no regular file, and no raymap made it, so that the %s cannot "
                              "be locked for writing: remove it",
                              path, what);
    return rmap_error_set(err, RMAP_SYSTEM, "%s: the %s cannot be locked for writing: %s", path,
                          what, strerror(state == STATE_GONE ? EBUSY : reason));
}

static enum rmap_status take(const char *folder, bool is_map, const char *command,
                             struct rmap_map_lock *self, struct rmap_error *err)
{
    const struct timespec nap = {.tv_nsec = 100000000};
    const int naps_max = 20; /* launchers give ranks that they end two seconds */
    enum state state = STATE_GONE;
    int fd = -1;
    if (!self || self->path)
        return RMAP_OK;
    char *path = rmap_path_format("%s/%s", folder, RMAP_MAP_LOCK_NAME);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    for (int naps = 0; naps <= naps_max; naps++) {
        state = try_once(path, &fd);
        if ((state != STATE_BUSY && state != STATE_GONE) || naps == naps_max)
            break;
        if (fd >= 0)
            (void)close(fd);
        (void)nanosleep(&nap, NULL);
    }
    if (state == STATE_HELD) {
        introduce(fd, command);
        *self = (struct rmap_map_lock){fd, path};
        return RMAP_OK;
    }
    enum rmap_status st = refuse(folder, path, is_map, fd, state, err);
    if (fd >= 0)
        (void)close(fd);
    rmap_free(path);
    return st;
}

enum rmap_status rmap_map_lock_take(const char *map_path, const char *command,
                                    struct rmap_map_lock *self, struct rmap_error *err)
{
    return take(map_path, true, command, self, err);
}

enum rmap_status rmap_folder_lock_take(const char *folder, const char *command,
                                       struct rmap_map_lock *self, struct rmap_error *err)
{
    return take(folder, false, command, self, err);
}

enum rmap_status rmap_map_lock_break(const char *map_path, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int fd = -1;
    char *path = rmap_path_format("%s/%s", map_path, RMAP_MAP_LOCK_NAME);
    if (!path)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    if (try_once(path, &fd) != STATE_BUSY && unlink(path) != 0 && errno != ENOENT)
        st = rmap_error_set(err, RMAP_SYSTEM, "%s: cannot be removed: %s", path, strerror(errno));
    if (fd >= 0)
        (void)close(fd);
    rmap_free(path);
    return st;
}

/* Removed while it is held. Gone already with its map: the name is another's then. */
void rmap_map_lock_release(struct rmap_map_lock *self)
{
    if (!self->path)
        return;
    if (has_name(self->fd))
        (void)unlink(self->path);
    (void)close(self->fd);
    rmap_free(self->path);
    *self = (struct rmap_map_lock){0};
}

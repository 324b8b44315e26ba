/* SPDX-License-Identifier: MIT
 *
 * Files that a scene names: a stranger's scene may name anything.
 */
#define _XOPEN_SOURCE 700 /* realpath */
#include "io/file/input_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/read_exactly.h"

/* The file open, or -1 and why. Without O_NONBLOCK a pipe without a writer would make us wait. */
static int open_regular(const char *path, struct stat *info, const char **trouble)
{
    const int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    const bool known = fd >= 0 && fstat(fd, info) == 0;
    if (known && S_ISREG(info->st_mode))
        return fd;
    *trouble = known ? "it is no regular file" : strerror(errno);
    if (fd >= 0)
        (void)close(fd);
    return -1;
}

const char *rmap_input_file_trouble(const char *path)
{
    struct stat info;
    const char *trouble = NULL;
    const int fd = open_regular(path, &info, &trouble);
    if (fd >= 0)
        (void)close(fd);
    return trouble;
}

enum rmap_status rmap_input_file_read(const char *path, size_t nbytes_max, uint8_t **bytes_ret,
                                      size_t *nbytes_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct stat info;
    const char *trouble = NULL;
    uint8_t *bytes = NULL;
    const int fd = open_regular(path, &info, &trouble);
    if (fd < 0)
        return rmap_error_set(err, RMAP_INPUT, "%s", trouble);
    const size_t nbytes = (size_t)info.st_size;
    if (nbytes > nbytes_max)
        st = rmap_error_set(err, RMAP_INPUT, "%zu bytes are too many: %zu are read", nbytes,
                            nbytes_max);
    else if (!(bytes = rmap_alloc_unset(nbytes + 1, 1)))
        st =
            rmap_error_set(err, RMAP_SYSTEM, "out of memory for the %zu bytes of %s", nbytes, path);
    else
        st = rmap_read_exactly(fd, bytes, nbytes, 0, err);
    (void)close(fd);
    if (st == RMAP_FORMAT) /* it was cut off meanwhile */
        st = rmap_error_set(err, RMAP_INPUT, "it cannot be read to its end");
    if (st != RMAP_OK) {
        rmap_free(bytes);
        return st;
    }
    bytes[nbytes] = 0;
    *bytes_ret = bytes;
    *nbytes_ret = nbytes;
    return RMAP_OK;
}

/* Whether a file is `entry`, or lies below it. */
static bool holds(const char *entry, const char *file)
{
    char *real = realpath(entry, NULL);
    const size_t n = real ? strlen(real) : 0;
    const bool below = real && strncmp(file, real, n) == 0 && (file[n] == '/' || file[n] == '\0');
    free(real);
    return below;
}

bool rmap_plugin_is_allowed(const char *path)
{
    const char *allowed = getenv("RAYMAP_ALLOW_PLUGINS");
    char *list = allowed ? rmap_strdup(allowed) : NULL;
    char *file = list ? realpath(path, NULL) : NULL;
    bool found = false;
    char *rest = list;
    for (char *entry; file && !found && rest && (entry = strtok_r(rest, ":", &rest));)
        found = holds(entry, file);
    free(file);
    rmap_free(list);
    return found;
}

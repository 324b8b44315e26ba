/* SPDX-License-Identifier: MIT */
#include "io/text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

/* Opens what is a regular file; says what else it is. *fd_ret: to be closed. */
static enum rmap_status open_file(const char *path, const struct rmap_text_kind *kind, int *fd_ret,
                                  size_t *nbytes_ret, struct rmap_error *err)
{
    struct stat info;
    /* Without O_NONBLOCK a pipe would wait here for a writer. */
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0) {
        bool missing = errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG;
        return rmap_error_set(err, missing ? RMAP_INPUT : RMAP_SYSTEM, "cannot open %s: %s", path,
                              strerror(errno));
    }
    enum rmap_status st = RMAP_OK;
    if (fstat(fd, &info) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM, "cannot examine %s: %s", path, strerror(errno));
    else if (S_ISDIR(info.st_mode))
        st = rmap_error_set(err, RMAP_INPUT, "%s is a directory, not %s", path, kind->noun);
    else if (!S_ISREG(info.st_mode))
        st = rmap_error_set(err, RMAP_INPUT, "%s is not a regular file", path);
    else if (info.st_size == 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s is empty: %s must stand there", path, kind->noun);
    else if ((uintmax_t)info.st_size > kind->nbytes_max)
        st = rmap_error_set(err, RMAP_INPUT, "%s has %jd bytes: %s has %zu MiB at most%s", path,
                            (intmax_t)info.st_size, kind->noun, kind->nbytes_max >> 20,
                            kind->advice);
    if (st != RMAP_OK) {
        (void)close(fd);
        return st;
    }
    *fd_ret = fd;
    *nbytes_ret = (size_t)info.st_size;
    return RMAP_OK;
}

enum rmap_status rmap_text_file_read(const char *path, const struct rmap_text_kind *kind,
                                     char **text_ret, size_t *nbytes_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int fd = -1;
    size_t nbytes = 0, got = 0;
    char *text = NULL;
    RMAP_TRY(open_file(path, kind, &fd, &nbytes, err));
    text = rmap_alloc(nbytes + 1, 1);
    if (!text) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", path);
        goto out;
    }
    while (got < nbytes) {
        ssize_t n = read(fd, text + got, nbytes - got);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0) {
            st = rmap_error_set(err, RMAP_SYSTEM, "cannot read %s: %s", path, strerror(errno));
            goto out;
        }
        if (n == 0)
            break;
        got += (size_t)n;
    }
    if (memchr(text, 0, got)) {
        st = rmap_error_set(err, RMAP_INPUT, "%s is binary, not %s (%s)", path, kind->noun,
                            kind->format);
        goto out;
    }
    *text_ret = text;
    *nbytes_ret = got;
    text = NULL;
out:
    rmap_free(text);
    if (fd >= 0)
        (void)close(fd);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * A file of text that a person wrote, read as a whole.
 */
#include "io/file/text_file.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

/* Text as it comes, of a file whose size is known or a pipe. */
struct reading {
    const char *path;
    const struct rmap_text_kind *kind;
    int fd;
    char *text;
    size_t nbytes, nbytes_max; /* so far, and what the text has room for */
};

static enum rmap_status too_long(const struct reading *self, const char *size,
                                 struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_INPUT, "%s has %s bytes: %s has %zu MiB at most%s", self->path,
                          size, self->kind->noun, self->kind->nbytes_max >> 20, self->kind->advice);
}

/* Opens a regular file, or a pipe that has a writer, such as the shell's <(...); says what else it
 * is. */
static enum rmap_status open_file(struct reading *self, struct rmap_error *err)
{
    const char *path = self->path;
    struct stat info;
    char size[24];
    /* Without O_NONBLOCK a pipe without a writer would make us wait here. */
    self->fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (self->fd < 0) {
        bool missing = errno == ENOENT || errno == ENOTDIR || errno == ENAMETOOLONG;
        return rmap_error_set(err, missing ? RMAP_INPUT : RMAP_SYSTEM, "cannot open %s: %s", path,
                              strerror(errno));
    }
    if (fstat(self->fd, &info) != 0 ||
        (S_ISFIFO(info.st_mode) && fcntl(self->fd, F_SETFL, O_RDONLY) != 0))
        return rmap_error_set(err, RMAP_SYSTEM, "cannot examine %s: %s", path, strerror(errno));
    if (S_ISDIR(info.st_mode)) {
        const bool has_scene = faccessat(self->fd, "scene.yaml", F_OK, 0) == 0;
        return rmap_error_set(err, RMAP_INPUT, "%s is a directory, not %s%s%s%s", path,
                              self->kind->noun, has_scene ? " (did you mean " : "",
                              has_scene ? path : "", has_scene ? "/scene.yaml?)" : "");
    }
    if (!S_ISREG(info.st_mode) && !S_ISFIFO(info.st_mode))
        return rmap_error_set(err, RMAP_INPUT, "%s is neither a regular file nor a pipe", path);
    if ((uintmax_t)info.st_size > self->kind->nbytes_max) {
        (void)snprintf(size, sizeof size, "%jd", (intmax_t)info.st_size);
        return too_long(self, size, err);
    }
    self->nbytes_max = S_ISREG(info.st_mode) ? (size_t)info.st_size + 1 : 0; /* 1: to see the end */
    return RMAP_OK;
}

/* Room for a final 0 is kept. */
static enum rmap_status make_room(struct reading *self, struct rmap_error *err)
{
    const size_t least = 4096;
    size_t nbytes = self->text ? 2 * self->nbytes_max : self->nbytes_max;
    nbytes = nbytes < least ? least : nbytes;
    char *text = rmap_realloc(self->text, nbytes + 1, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %s", self->path);
    self->text = text;
    self->nbytes_max = nbytes;
    return RMAP_OK;
}

static enum rmap_status read_all(struct reading *self, struct rmap_error *err)
{
    for (;;) {
        if (self->nbytes > self->kind->nbytes_max)
            return too_long(self, "too many", err);
        if (!self->text || self->nbytes == self->nbytes_max) {
            enum rmap_status st = make_room(self, err);
            if (st != RMAP_OK)
                return st;
        }
        ssize_t n = read(self->fd, self->text + self->nbytes, self->nbytes_max - self->nbytes);
        if (n < 0 && errno == EINTR)
            continue;
        if (n < 0)
            return rmap_error_set(err, RMAP_SYSTEM, "cannot read %s: %s", self->path,
                                  strerror(errno));
        if (n == 0)
            break;
        self->nbytes += (size_t)n;
    }
    self->text[self->nbytes] = 0;
    if (self->nbytes == 0)
        return rmap_error_set(err, RMAP_INPUT, "%s is empty: %s must stand there", self->path,
                              self->kind->noun);
    if (memchr(self->text, 0, self->nbytes))
        return rmap_error_set(err, RMAP_INPUT, "%s is binary, not %s (%s)", self->path,
                              self->kind->noun, self->kind->format);
    return RMAP_OK;
}

enum rmap_status rmap_text_file_read(const char *path, const struct rmap_text_kind *kind,
                                     char **text_ret, size_t *nbytes_ret, struct rmap_error *err)
{
    struct reading self = {.path = path, .kind = kind, .fd = -1};
    enum rmap_status st = open_file(&self, err);
    if (st == RMAP_OK)
        st = read_all(&self, err);
    if (self.fd >= 0)
        (void)close(self.fd);
    if (st != RMAP_OK) {
        rmap_free(self.text);
        return st;
    }
    *text_ret = self.text;
    *nbytes_ret = self.nbytes;
    return RMAP_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * A file for a result that appears whole or not at all: written under a temporary name beside its
 * own that nobody can foretell, and what had the name keeps it until then.
 */
#include "io/file/whole_file.h"

#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <string.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/file/publish.h"

static enum rmap_status cannot_write(const struct rmap_whole_file *self, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", self->path, strerror(errno));
}

enum rmap_status rmap_whole_file_name(struct rmap_whole_file *self, const char *path,
                                      struct rmap_error *err)
{
    const char *slash = strrchr(path, '/');
    uint64_t word; /* nobody can lay a file in wait at a name that cannot be foretold */
    *self = (struct rmap_whole_file){.path = path};
    if (getrandom(&word, sizeof word, 0) != (ssize_t)sizeof word)
        return cannot_write(self, err);
    self->directory = !slash          ? rmap_strdup(".")
                      : slash == path ? rmap_strdup("/")
                                      : rmap_path_format("%.*s", (int)(slash - path), path);
    self->temporary = self->directory
                          ? rmap_path_format("%s/.%s.%016" PRIx64 ".part", self->directory,
                                             slash ? slash + 1 : path, word)
                          : NULL;
    return self->temporary ? RMAP_OK
                           : rmap_error_set(err, RMAP_SYSTEM, "out of memory for '%s'", path);
}

enum rmap_status rmap_whole_file_open(struct rmap_whole_file *self, const char *path,
                                      struct rmap_error *err)
{
    enum rmap_status st = rmap_whole_file_name(self, path, err);
    if (st != RMAP_OK)
        return st;
    struct stat old; /* what replaces a file is for no more readers while it grows */
    const mode_t mode = lstat(path, &old) == 0 && S_ISREG(old.st_mode) ? 0600 : 0666;
    int fd = open(self->temporary, O_WRONLY | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode);
    self->file = fd >= 0 ? fdopen(fd, "wb") : NULL;
    if (self->file)
        return RMAP_OK;
    st = cannot_write(self, err);
    if (fd >= 0)
        (void)close(fd);
    return st;
}

enum rmap_status rmap_whole_file_finish(struct rmap_whole_file *self, struct rmap_error *err)
{
    const int failed = self->file && ferror(self->file);
    const int closed = self->file ? fclose(self->file) : 0;
    enum rmap_status st = RMAP_OK;
    self->file = NULL;
    if (failed || closed != 0) {
        st = cannot_write(self, err);
        (void)remove(self->temporary);
    } else {
        st = rmap_publish_over(self->directory, self->temporary, self->path, err);
    }
    rmap_free(self->temporary);
    self->temporary = NULL;
    return st;
}

void rmap_whole_file_fini(struct rmap_whole_file *self)
{
    if (self->file)
        (void)fclose(self->file);
    if (self->temporary)
        (void)remove(self->temporary);
    rmap_free(self->temporary);
    rmap_free(self->directory);
    *self = (struct rmap_whole_file){0};
}

enum rmap_status rmap_whole_file_put(const char *path,
                                     enum rmap_status (*put)(const void *context, FILE *file,
                                                             struct rmap_error *err),
                                     const void *context, struct rmap_error *err)
{
    struct rmap_whole_file whole = {0};
    enum rmap_status st = rmap_whole_file_open(&whole, path, err);
    if (st == RMAP_OK)
        st = put(context, whole.file, err);
    if (st == RMAP_OK)
        st = rmap_whole_file_finish(&whole, err);
    rmap_whole_file_fini(&whole);
    return st;
}

struct bytes {
    const void *data;
    size_t n;
};

static enum rmap_status put_bytes(const void *context, FILE *file, struct rmap_error *err)
{
    const struct bytes *bytes = context;
    (void)err; /* the file keeps its errors */
    (void)fwrite(bytes->data, 1, bytes->n, file);
    return RMAP_OK;
}

enum rmap_status rmap_whole_file_put_bytes(const char *path, const void *bytes, size_t nbytes,
                                           struct rmap_error *err)
{
    return rmap_whole_file_put(path, put_bytes, &(struct bytes){bytes, nbytes}, err);
}

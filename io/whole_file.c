/* SPDX-License-Identifier: MIT */
#include "io/whole_file.h"

#include <errno.h>
#include <string.h>

#include "base/alloc.h"
#include "io/publish.h"

static enum rmap_status cannot_write(const struct rmap_whole_file *self, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", self->path, strerror(errno));
}

enum rmap_status rmap_whole_file_open(struct rmap_whole_file *self, const char *path,
                                      struct rmap_error *err)
{
    const char *slash = strrchr(path, '/');
    *self = (struct rmap_whole_file){.path = path};
    self->directory = !slash          ? rmap_strdup(".")
                      : slash == path ? rmap_strdup("/")
                                      : rmap_path_format("%.*s", (int)(slash - path), path);
    self->temporary =
        self->directory ? rmap_temporary_path(self->directory, slash ? slash + 1 : path) : NULL;
    if (!self->temporary)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for '%s'", path);
    self->file = fopen(self->temporary, "wb");
    return self->file ? RMAP_OK : cannot_write(self, err);
}

enum rmap_status rmap_whole_file_finish(struct rmap_whole_file *self, struct rmap_error *err)
{
    const int failed = ferror(self->file), closed = fclose(self->file);
    self->file = NULL;
    if (!failed && closed == 0)
        return rmap_publish_over(self->directory, self->temporary, self->path, err);
    enum rmap_status st = cannot_write(self, err);
    (void)remove(self->temporary);
    return st;
}

void rmap_whole_file_fini(struct rmap_whole_file *self)
{
    if (self->file) {
        (void)fclose(self->file);
        (void)remove(self->temporary);
    }
    rmap_free(self->temporary);
    rmap_free(self->directory);
    *self = (struct rmap_whole_file){0};
}

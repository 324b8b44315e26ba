/* SPDX-License-Identifier: MIT */
#include "io/bundle.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"

#define TEXT_NBYTES_MAX ((size_t)64 << 20)

static void free_list(char **list, size_t n)
{
    for (size_t i = 0; list && i < n; i++)
        rmap_free(list[i]);
    rmap_free(list);
}

void rmap_scene_options_fini(struct rmap_scene_options *options)
{
    rmap_free(options->simulation);
    rmap_free(options->color);
    free_list(options->only, options->n_only);
    free_list(options->without, options->n_without);
    free_list(options->set, options->n_set);
    *options = (struct rmap_scene_options){0};
}

/* Opens what is a regular file; says what else it is. *fd_ret: to be closed. */
static enum rmap_status open_file(const char *path, int *fd_ret, size_t *nbytes_ret,
                                  struct rmap_error *err)
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
        st = rmap_error_set(err, RMAP_INPUT, "%s is a directory, not a scene file", path);
    else if (!S_ISREG(info.st_mode))
        st = rmap_error_set(err, RMAP_INPUT, "%s is not a regular file", path);
    else if (info.st_size == 0)
        st = rmap_error_set(err, RMAP_INPUT, "%s is empty: a scene file must stand there", path);
    else if ((uintmax_t)info.st_size > TEXT_NBYTES_MAX)
        st = rmap_error_set(err, RMAP_INPUT,
                            "%s has %jd bytes: a scene file has 64 MiB at most (meshes belong "
                            "into files of their own)",
                            path, (intmax_t)info.st_size);
    if (st != RMAP_OK) {
        (void)close(fd);
        return st;
    }
    *fd_ret = fd;
    *nbytes_ret = (size_t)info.st_size;
    return RMAP_OK;
}

static enum rmap_status read_text(const char *path, char **text_ret, size_t *nbytes_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int fd = -1;
    size_t nbytes = 0, got = 0;
    char *text = NULL;
    RMAP_TRY(open_file(path, &fd, &nbytes, err));
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
        st = rmap_error_set(err, RMAP_INPUT, "%s is binary, not a scene file (YAML text)", path);
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

enum rmap_status rmap_bundle_open(const char *path, struct rmap_scene_options *options,
                                  struct rmap_bundle **bundle_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options taken = {0};
    if (options) {
        taken = *options;
        *options = (struct rmap_scene_options){0};
    }
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    if (!bundle) {
        rmap_scene_options_fini(&taken);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
    }
    bundle->options = taken;
    bundle->path = rmap_strdup(path);
    if (!bundle->path) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scene");
        goto out;
    }
    RMAP_TRY(read_text(path, &bundle->text, &bundle->text_nbytes, err));
    *bundle_ret = bundle;
    bundle = NULL;
out:
    rmap_bundle_destroy(bundle);
    return st;
}

void rmap_bundle_destroy(struct rmap_bundle *bundle)
{
    if (!bundle)
        return;
    for (size_t i = 0; i < bundle->n_mesh; i++) {
        rmap_free(bundle->mesh[i].geometry);
        rmap_mesh_destroy(bundle->mesh[i].mesh);
    }
    rmap_free(bundle->mesh);
    rmap_free(bundle->path);
    rmap_free(bundle->text);
    rmap_scene_options_fini(&bundle->options);
    rmap_free(bundle);
}

enum rmap_status rmap_bundle_add_mesh(struct rmap_bundle *bundle, const char *geometry,
                                      struct rmap_mesh *mesh, struct rmap_error *err)
{
    char *name = rmap_strdup(geometry);
    void *grown =
        name ? rmap_realloc(bundle->mesh, bundle->n_mesh + 1, sizeof *bundle->mesh) : NULL;
    if (!grown) {
        rmap_free(name);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a mesh");
    }
    bundle->mesh = grown;
    bundle->mesh[bundle->n_mesh].geometry = name;
    bundle->mesh[bundle->n_mesh].mesh = mesh;
    bundle->n_mesh++;
    return RMAP_OK;
}

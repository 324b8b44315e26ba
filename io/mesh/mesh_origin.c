/* SPDX-License-Identifier: MIT
 *
 * Of which state of which file a mesh is.
 */
#include "io/mesh/mesh_origin.h"

#include <string.h>

#include "base/alloc.h"
#include "io/file/directory.h"

struct rmap_mesh_origin {
    char *path;
    double scale;
    unsigned keep;
    struct stat file;
    struct rmap_mesh_left_out left_out;
};

struct rmap_mesh_origin *rmap_mesh_origin_create(const char *path,
                                                 const struct rmap_mesh_reading *how)
{
    struct rmap_mesh_origin *origin = rmap_alloc(1, sizeof *origin);
    if (!origin)
        return NULL;
    origin->scale = how->scale;
    origin->keep = how->keep;
    origin->path = rmap_strdup(path);
    if (origin->path && rmap_path_look(path, &origin->file, NULL) == RMAP_OK &&
        S_ISREG(origin->file.st_mode))
        return origin;
    rmap_mesh_origin_destroy(origin);
    return NULL;
}

void rmap_mesh_origin_destroy(struct rmap_mesh_origin *origin)
{
    if (origin)
        rmap_free(origin->path);
    rmap_free(origin);
}

static bool same_time(const struct timespec *a, const struct timespec *b)
{
    return a->tv_sec == b->tv_sec && a->tv_nsec == b->tv_nsec;
}

static bool is_same(const struct rmap_mesh_origin *a, const struct rmap_mesh_origin *b)
{
    return a->file.st_dev == b->file.st_dev && a->file.st_ino == b->file.st_ino &&
           a->file.st_size == b->file.st_size && same_time(&a->file.st_mtim, &b->file.st_mtim) &&
           same_time(&a->file.st_ctim, &b->file.st_ctim) && a->scale == b->scale &&
           a->keep == b->keep && strcmp(a->path, b->path) == 0;
}

struct rmap_mesh *rmap_mesh_again(const struct rmap_bundle *before,
                                  const struct rmap_mesh_origin *origin,
                                  struct rmap_mesh_left_out *left_out_ret)
{
    for (size_t i = 0; before && origin && i < before->n_mesh; i++) {
        const struct rmap_mesh_origin *other = before->mesh[i].origin;
        if (!other || !is_same(other, origin))
            continue;
        *left_out_ret = other->left_out;
        return rmap_mesh_hold(before->mesh[i].mesh);
    }
    return NULL;
}

void rmap_mesh_origin_keep(struct rmap_bundle *bundle, struct rmap_mesh_origin *origin,
                           const struct rmap_mesh_left_out *left_out)
{
    if (origin)
        origin->left_out = *left_out;
    bundle->mesh[bundle->n_mesh - 1].origin = origin;
}

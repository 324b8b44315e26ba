/* SPDX-License-Identifier: MIT
 *
 * The camera that a command line names.
 */
#include "mpi/command/find_camera.h"

#include <string.h>

#include "base/alloc.h"
#include "io/file/diagnostics.h"

enum rmap_status rmap_find_camera(const struct rmap_scene *scene, const char *path,
                                  const char *name, const struct rmap_camera **camera_ret,
                                  struct rmap_error *err)
{
    if (scene->n_camera == 0)
        return rmap_error_set(
            err, RMAP_INPUT,
            "%s has no camera: add one, as in cameras: [{name: front, at: [0, -9, "
            "2], look_at: [0, 0, 0]}]",
            path);
    const char **known = rmap_alloc(scene->n_camera, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the cameras' names");
    enum rmap_status st = RMAP_INPUT;
    for (size_t i = 0; i < scene->n_camera && st != RMAP_OK; i++) {
        known[i] = scene->camera[i].name;
        if (name && strcmp(known[i], name) != 0)
            continue;
        *camera_ret = &scene->camera[i];
        st = RMAP_OK;
    }
    const char *nearest = st == RMAP_OK ? NULL : rmap_nearest_word(name, known, scene->n_camera);
    if (st != RMAP_OK)
        (void)rmap_error_set(err, st, "no camera named '%s' in %s; did you mean '%s'?", name, path,
                             nearest ? nearest : known[0]);
    rmap_free(known);
    return st;
}

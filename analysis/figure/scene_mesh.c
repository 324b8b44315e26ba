/* SPDX-License-Identifier: MIT
 *
 * Every geometry of a scene as a mesh to look at.
 */
#include "analysis/figure/scene_mesh.h"

#include "analysis/figure/tessellation.h"
#include "base/alloc.h"

void rmap_scene_meshes_destroy(struct rmap_mesh **mesh, size_t n_geometry)
{
    for (size_t g = 0; mesh && g < n_geometry; g++)
        rmap_mesh_destroy(mesh[g]);
    rmap_free(mesh);
}

enum rmap_status rmap_scene_meshes_create(const struct rmap_scene *scene,
                                          struct rmap_mesh ***mesh_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh **mesh = rmap_alloc(scene->n_geometry + 1, sizeof *mesh);
    if (!mesh)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    for (size_t g = 0; g < scene->n_geometry; g++) {
        const struct rmap_geometry *geometry = &scene->geometry[g];
        if (geometry->kind == RMAP_GEOMETRY_SHAPE)
            RMAP_TRY(rmap_shape_tessellate(&geometry->shape, &mesh[g], err));
        else
            RMAP_TRY(rmap_mesh_weld(geometry->mesh, &mesh[g], err));
    }
    *mesh_ret = mesh;
    mesh = NULL;
out:
    rmap_scene_meshes_destroy(mesh, scene->n_geometry);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * A triangle mesh in its own frame.
 */
#include "geometry/mesh.h"

#include "base/alloc.h"

enum rmap_status rmap_mesh_create(size_t n_vertex, size_t n_triangle, size_t n_face,
                                  struct rmap_mesh **mesh_ret, struct rmap_error *err)
{
    struct rmap_mesh *mesh = rmap_alloc(1, sizeof(*mesh));
    if (!mesh || n_vertex >= UINT32_MAX || n_triangle >= UINT32_MAX)
        goto fail;
    mesh->n_vertex = n_vertex;
    mesh->n_triangle = n_triangle;
    mesh->n_face = n_face;
    mesh->vertex = rmap_alloc(n_vertex, sizeof(*mesh->vertex));
    mesh->triangle = rmap_alloc(n_triangle, sizeof(*mesh->triangle));
    mesh->face = rmap_alloc(n_triangle, sizeof(*mesh->face));
    mesh->face_name = rmap_alloc(n_face, sizeof(*mesh->face_name));
    if (!mesh->vertex || !mesh->triangle || !mesh->face || !mesh->face_name)
        goto fail;
    *mesh_ret = mesh;
    return RMAP_OK;
fail:
    rmap_mesh_destroy(mesh);
    return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu vertices, %zu triangles",
                          n_vertex, n_triangle);
}

struct rmap_mesh *rmap_mesh_hold(struct rmap_mesh *mesh)
{
    mesh->n_more++;
    return mesh;
}

void rmap_mesh_destroy(struct rmap_mesh *mesh)
{
    if (!mesh || mesh->n_more-- > 0)
        return;
    if (mesh->face_name)
        for (size_t i = 0; i < mesh->n_face; i++)
            rmap_free(mesh->face_name[i]);
    rmap_free(mesh->face_name);
    rmap_free(mesh->tangent);
    rmap_free(mesh->uv);
    rmap_free(mesh->surface);
    rmap_free(mesh->face);
    rmap_free(mesh->triangle);
    rmap_free(mesh->vertex);
    rmap_free(mesh);
}

void rmap_mesh_bounds(const struct rmap_mesh *mesh, struct rmap_vec3 *lower,
                      struct rmap_vec3 *upper)
{
    *lower = *upper = rmap_vec3(0, 0, 0);
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        struct rmap_vec3 p = rmap_vec3((double)v[0], (double)v[1], (double)v[2]);
        *lower = i == 0 ? p : rmap_least(*lower, p);
        *upper = i == 0 ? p : rmap_greatest(*upper, p);
    }
    double bulge = 0;
    for (size_t i = 0; mesh->surface && i < mesh->n_triangle; i++)
        bulge = rmap_max(bulge, rmap_mesh_bulge(mesh, i));
    *lower = rmap_sub(*lower, rmap_vec3(bulge, bulge, bulge));
    *upper = rmap_add(*upper, rmap_vec3(bulge, bulge, bulge));
}

/* SPDX-License-Identifier: MIT
 *
 * Some faces of a mesh as a mesh of their own.
 */
#include "geometry/mesh_part.h"

#include <string.h>

#include "base/alloc.h"

/* What was left out has no number. */
struct numbers {
    uint32_t *vertex, *face; /* in the part, + 1 */
    size_t n_vertex, n_triangle, n_face;
};

static void count(const struct rmap_mesh *mesh, const uint8_t *wanted, struct numbers *to)
{
    for (size_t f = 0; f < mesh->n_face; f++)
        if (wanted[f])
            to->face[f] = (uint32_t)++to->n_face;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        if (!wanted[mesh->face[t]])
            continue;
        to->n_triangle++;
        for (int k = 0; k < 3; k++)
            if (!to->vertex[mesh->triangle[t][k]])
                to->vertex[mesh->triangle[t][k]] = (uint32_t)++to->n_vertex;
    }
}

static void fill(const struct rmap_mesh *mesh, const struct numbers *numbers,
                 struct rmap_mesh *part)
{
    size_t n = 0;
    for (size_t v = 0; v < mesh->n_vertex; v++)
        if (numbers->vertex[v])
            memcpy(part->vertex[numbers->vertex[v] - 1], mesh->vertex[v], sizeof *part->vertex);
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        if (!numbers->face[mesh->face[t]])
            continue;
        for (int k = 0; k < 3; k++)
            part->triangle[n][k] = numbers->vertex[mesh->triangle[t][k]] - 1;
        if (part->tangent)
            memcpy(part->tangent[n], mesh->tangent[t], sizeof *part->tangent);
        part->face[n++] = numbers->face[mesh->face[t]] - 1;
    }
}

enum rmap_status rmap_mesh_part(const struct rmap_mesh *mesh, const uint8_t *wanted,
                                struct rmap_mesh **part_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh *part = NULL;
    struct numbers numbers = {.vertex = rmap_alloc(mesh->n_vertex, sizeof *numbers.vertex),
                              .face = rmap_alloc(mesh->n_face, sizeof *numbers.face)};
    if (!numbers.vertex || !numbers.face)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a mesh"));
    count(mesh, wanted, &numbers);
    RMAP_TRY(rmap_mesh_create(numbers.n_vertex, numbers.n_triangle, numbers.n_face, &part, err));
    if (mesh->tangent)
        part->tangent = rmap_alloc(numbers.n_triangle, sizeof *part->tangent);
    if (mesh->surface)
        part->surface = rmap_alloc(numbers.n_face, sizeof *part->surface);
    if ((mesh->tangent && !part->tangent) || (mesh->surface && !part->surface))
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a mesh"));
    for (size_t f = 0; part->surface && f < mesh->n_face; f++)
        if (wanted[f])
            part->surface[numbers.face[f] - 1] = mesh->surface[f];
    for (size_t f = 0; f < mesh->n_face; f++) {
        if (!wanted[f] || !mesh->face_name[f])
            continue;
        char *name = rmap_strdup(mesh->face_name[f]);
        if (!name)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a mesh"));
        part->face_name[numbers.face[f] - 1] = name;
    }
    fill(mesh, &numbers, part);
    *part_ret = part;
    part = NULL;
out:
    rmap_mesh_destroy(part);
    rmap_free(numbers.vertex);
    rmap_free(numbers.face);
    return st;
}

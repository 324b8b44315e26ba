/* SPDX-License-Identifier: MIT
 *
 * Some faces of a mesh as a mesh of their own.
 */
#include "geometry/mesh_part.h"

#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"

/* What is of the part, then what lies beyond its rim: triangles that have a corner on it. */
struct choice {
    const struct rmap_mesh *mesh;
    const uint8_t *wanted;
    uint32_t *vertex, *face; /* numbers in the part, + 1; 0: left out */
    size_t n_vertex, n_triangle, n_face;
};

static bool is_own(const struct choice *c, size_t t)
{
    return c->wanted[c->mesh->face[t]];
}

/* rim: [n_vertex] corners of the part. */
static bool lies_beyond(const struct choice *c, const uint8_t *rim, size_t t)
{
    const uint32_t *corner = c->mesh->triangle[t];
    return c->mesh->surface && !is_own(c, t) && (rim[corner[0]] | rim[corner[1]] | rim[corner[2]]);
}

static void take(struct choice *c, size_t t)
{
    const struct rmap_mesh *mesh = c->mesh;
    c->n_triangle++;
    if (!c->face[mesh->face[t]])
        c->face[mesh->face[t]] = (uint32_t)++c->n_face;
    for (int k = 0; k < 3; k++)
        if (!c->vertex[mesh->triangle[t][k]])
            c->vertex[mesh->triangle[t][k]] = (uint32_t)++c->n_vertex;
}

static void put(const struct choice *c, size_t t, struct rmap_mesh *part, size_t *n)
{
    for (int k = 0; k < 3; k++)
        part->triangle[*n][k] = c->vertex[c->mesh->triangle[t][k]] - 1;
    if (part->tangent)
        memcpy(part->tangent[*n], c->mesh->tangent[t], sizeof *part->tangent);
    if (part->uv)
        memcpy(part->uv[*n], c->mesh->uv[t], sizeof *part->uv);
    part->face[(*n)++] = c->face[c->mesh->face[t]] - 1;
}

static void fill(const struct choice *c, const uint8_t *rim, struct rmap_mesh *part)
{
    const struct rmap_mesh *mesh = c->mesh;
    size_t n = 0;
    for (size_t v = 0; v < mesh->n_vertex; v++)
        if (c->vertex[v])
            memcpy(part->vertex[c->vertex[v] - 1], mesh->vertex[v], sizeof *part->vertex);
    for (size_t t = 0; t < mesh->n_triangle; t++)
        if (is_own(c, t))
            put(c, t, part, &n);
    for (size_t t = 0; t < mesh->n_triangle; t++)
        if (lies_beyond(c, rim, t))
            put(c, t, part, &n);
    for (size_t f = 0; part->surface && f < mesh->n_face; f++)
        if (c->face[f])
            part->surface[c->face[f] - 1] = mesh->surface[f];
}

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a part of a mesh");
}

static enum rmap_status name_faces(const struct choice *c, struct rmap_mesh *part,
                                   struct rmap_error *err)
{
    for (size_t f = 0; f < c->mesh->n_face; f++) {
        if (!c->wanted[f] || !c->face[f] || !c->mesh->face_name[f])
            continue;
        char *name = rmap_strdup(c->mesh->face_name[f]);
        if (!name)
            return no_memory(err);
        part->face_name[c->face[f] - 1] = name;
    }
    return RMAP_OK;
}

static enum rmap_status make(struct choice *c, uint8_t *rim, struct rmap_mesh **part_ret,
                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_mesh *mesh = c->mesh;
    struct rmap_mesh *part = NULL;
    for (size_t f = 0; f < mesh->n_face; f++) /* in their order */
        if (c->wanted[f])
            c->face[f] = (uint32_t)++c->n_face;
    for (size_t t = 0; t < mesh->n_triangle; t++)
        if (is_own(c, t))
            take(c, t);
    const struct choice own = *c;
    for (size_t v = 0; v < mesh->n_vertex; v++)
        rim[v] = c->vertex[v] != 0;
    for (size_t t = 0; t < mesh->n_triangle; t++)
        if (lies_beyond(c, rim, t))
            take(c, t);
    RMAP_TRY(rmap_mesh_create(c->n_vertex, c->n_triangle, c->n_face, &part, err));
    if (mesh->tangent)
        part->tangent = rmap_alloc(c->n_triangle, sizeof *part->tangent);
    if (mesh->uv)
        part->uv = rmap_alloc(c->n_triangle, sizeof *part->uv);
    if (mesh->surface)
        part->surface = rmap_alloc(c->n_face, sizeof *part->surface);
    if ((mesh->tangent && !part->tangent) || (mesh->uv && !part->uv) ||
        (mesh->surface && !part->surface))
        RMAP_TRY(no_memory(err));
    fill(c, rim, part);
    RMAP_TRY(name_faces(c, part, err));
    part->n_vertex = own.n_vertex;
    part->n_triangle = own.n_triangle;
    part->n_face = own.n_face;
    part->n_vertex_beyond = c->n_vertex - own.n_vertex;
    part->n_triangle_beyond = c->n_triangle - own.n_triangle;
    part->n_face_beyond = c->n_face - own.n_face;
    *part_ret = part;
    part = NULL;
out:
    rmap_mesh_destroy(part);
    return st;
}

enum rmap_status rmap_mesh_part(const struct rmap_mesh *mesh, const uint8_t *wanted,
                                struct rmap_mesh **part_ret, struct rmap_error *err)
{
    struct choice choice = {.mesh = mesh,
                            .wanted = wanted,
                            .vertex = rmap_alloc(mesh->n_vertex, sizeof *choice.vertex),
                            .face = rmap_alloc(mesh->n_face, sizeof *choice.face)};
    uint8_t *rim = rmap_alloc(mesh->n_vertex, 1);
    const enum rmap_status st =
        choice.vertex && choice.face && rim ? make(&choice, rim, part_ret, err) : no_memory(err);
    rmap_free(choice.vertex);
    rmap_free(choice.face);
    rmap_free(rim);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * A mesh made triangle by triangle.
 */
#include "io/mesh/mesh_builder.h"

#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"

#define TRIANGLES_MAX ((size_t)1 << 31)

static uint32_t *find_slot(const struct rmap_mesh_builder *b, const float key[3])
{
    size_t mask = b->n_slot - 1, slot = (size_t)XXH3_64bits(key, 3 * sizeof *key) & mask;
    while (b->slot[slot] && memcmp(b->vertex[b->slot[slot] - 1], key, 3 * sizeof *key) != 0)
        slot = (slot + 1) & mask;
    return &b->slot[slot];
}

static enum rmap_status grow_slots(struct rmap_mesh_builder *b)
{
    size_t n_slot = b->n_slot ? 2 * b->n_slot : 1024;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return rmap_error_set(b->err, RMAP_SYSTEM, "out of memory: %zu vertices", b->n_vertex);
    rmap_free(b->slot);
    b->slot = slot;
    b->n_slot = n_slot;
    for (size_t i = 0; i < b->n_vertex; i++)
        *find_slot(b, b->vertex[i]) = (uint32_t)(i + 1);
    return RMAP_OK;
}

static enum rmap_status vertex_index(struct rmap_mesh_builder *b, const float position[3],
                                     uint32_t *index_ret)
{
    enum rmap_status st = RMAP_OK;
    if (2 * (b->n_vertex + 1) > b->n_slot)
        RMAP_TRY(grow_slots(b));
    uint32_t *slot = find_slot(b, position);
    if (!*slot) {
        RMAP_TRY(RMAP_RESERVE(b->vertex, b->cap_vertex, b->n_vertex + 1, b->err));
        memcpy(b->vertex[b->n_vertex], position, sizeof *b->vertex);
        *slot = (uint32_t)++b->n_vertex;
    }
    *index_ret = *slot - 1;
out:
    return st;
}

/* Rounded to float, as it is stored; -0 becomes 0. */
static void round_corner(struct rmap_vec3 corner, float rounded[3])
{
    rounded[0] = (float)corner.x + 0.0f;
    rounded[1] = (float)corner.y + 0.0f;
    rounded[2] = (float)corner.z + 0.0f;
}

static struct rmap_vec3 widened(const float p[3])
{
    return rmap_vec3((double)p[0], (double)p[1], (double)p[2]);
}

/* Along which u grows on a triangle, of length 1; 0 where the texture has no area there. */
static void find_tangent(const struct rmap_vec3 corner[3], const double uv[6], float tangent[3])
{
    const double u1 = uv[2] - uv[0], v1 = uv[3] - uv[1], u2 = uv[4] - uv[0], v2 = uv[5] - uv[1],
                 area = u1 * v2 - u2 * v1;
    struct rmap_vec3 way = rmap_axpy(-v1, rmap_sub(corner[2], corner[0]),
                                     rmap_scale(rmap_sub(corner[1], corner[0]), v2));
    const double length = rmap_length(way);
    if (!(fabs(area) > 0.0 && length > 0.0) || !isfinite(area) || !isfinite(length))
        return;
    way = rmap_scale(way, (area < 0.0 ? -1.0 : 1.0) / length);
    round_corner(way, tangent);
}

static enum rmap_status add_tangent(struct rmap_mesh_builder *b, const struct rmap_vec3 corner[3],
                                    const double *uv)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(b->tangent, b->cap_tangent, b->n_triangle + 1, b->err));
    memset(b->tangent[b->n_triangle], 0, sizeof *b->tangent);
    b->has_tangents = b->has_tangents || uv;
    if (uv)
        find_tangent(corner, uv, b->tangent[b->n_triangle]);
out:
    return st;
}

static enum rmap_status add_uv(struct rmap_mesh_builder *b, const double *uv)
{
    enum rmap_status st = RMAP_OK;
    bool good = uv;
    RMAP_TRY(RMAP_RESERVE(b->uv, b->cap_uv, b->n_triangle + 1, b->err));
    memset(b->uv[b->n_triangle], 0, sizeof *b->uv);
    for (int k = 0; k < 6 && good; k++)
        good = fabs(uv[k]) < 0.5 * (double)RMAP_MESH_UV_FARTHEST;
    for (int k = 0; k < 6 && good; k++)
        b->uv[b->n_triangle][k] = (float)(b->v_down && k % 2 ? 1.0 - uv[k] : uv[k]);
    b->has_uv = b->has_uv || good;
out:
    return st;
}

enum rmap_status rmap_mesh_builder_add(struct rmap_mesh_builder *b,
                                       const struct rmap_vec3 corner[3], const double *uv)
{
    enum rmap_status st = RMAP_OK;
    float p[3][3];
    for (int k = 0; k < 3; k++)
        round_corner(corner[k], p[k]);
    struct rmap_vec3 origin = widened(p[0]);
    double area =
        rmap_length(rmap_cross(rmap_sub(widened(p[1]), origin), rmap_sub(widened(p[2]), origin)));
    if (!isfinite(area) && b->left_out.undefined++ == 0)
        b->left_out.first = b->n_triangle + b->left_out.degenerate + 1;
    else if (!(area > 0) && isfinite(area))
        b->left_out.degenerate++;
    if (!(area > 0) || !isfinite(area))
        return RMAP_OK;
    if (b->n_triangle >= TRIANGLES_MAX || b->n_vertex + 3 >= UINT32_MAX)
        return rmap_error_set(b->err, RMAP_INPUT, "it has more than 2^31 triangles");
    RMAP_TRY(RMAP_RESERVE(b->triangle, b->cap_triangle, b->n_triangle + 1, b->err));
    RMAP_TRY(RMAP_RESERVE(b->face, b->cap_face, b->n_triangle + 1, b->err));
    if (b->wants_tangents)
        RMAP_TRY(add_tangent(b, corner, uv));
    if (b->wants_uv)
        RMAP_TRY(add_uv(b, uv));
    for (int k = 0; k < 3; k++)
        RMAP_TRY(vertex_index(b, p[k], &b->triangle[b->n_triangle][k]));
    b->face[b->n_triangle++] = (uint32_t)b->n_face;
out:
    return st;
}

enum rmap_status rmap_mesh_builder_close_face(struct rmap_mesh_builder *b, const char *name)
{
    enum rmap_status st = RMAP_OK;
    if (!b->n_triangle || b->face[b->n_triangle - 1] < b->n_face)
        return RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(b->face_name, b->cap_face_name, b->n_face + 1, b->err));
    b->face_name[b->n_face] = rmap_strdup(name);
    if (name && !b->face_name[b->n_face])
        return rmap_error_set(b->err, RMAP_SYSTEM, "out of memory: %zu faces", b->n_face);
    b->n_face++;
out:
    return st;
}

enum rmap_status rmap_mesh_builder_close_surface(struct rmap_mesh_builder *b, const char *name,
                                                 const struct rmap_true_surface *surface)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = b->n_face;
    RMAP_TRY(rmap_mesh_builder_close_face(b, name));
    if (b->n_face == n)
        return RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(b->surface, b->cap_surface, b->n_face, b->err));
    b->surface[n] = *surface;
out:
    return st;
}

/* By one of the latest parts: a file has the materials of a part one after the other. */
static bool name_taken(const struct rmap_mesh_builder *b, const char *name)
{
    enum { LATEST = 64 };
    for (size_t i = b->n_face > LATEST ? b->n_face - LATEST : 0; i < b->n_face; i++)
        if (b->face_name[i] && strcmp(b->face_name[i], name) == 0)
            return true;
    return false;
}

enum rmap_status rmap_mesh_builder_close_part(struct rmap_mesh_builder *b, const char *name,
                                              const char *material)
{
    enum { LONGEST = 2050 };
    char text[LONGEST];
    if (!name[0])
        name = material;
    if (b->wants_materials && b->part >= 0)
        name = material;
    const bool taken = name != material && material[0] && name_taken(b, name);
    (void)snprintf(text, sizeof text, "%s%s%s", name, taken ? "/" : "", taken ? material : "");
    const size_t n_before = b->n_face;
    enum rmap_status st = rmap_mesh_builder_close_face(b, text[0] ? text : NULL);
    if (st != RMAP_OK || !b->wants_materials || b->n_face == n_before)
        return st;
    RMAP_TRY(rmap_mesh_builder_fill_parts(b, b->n_face));
    b->face_part[n_before] = b->part;
    b->face_material[n_before] = rmap_strdup(material);
    if (!b->face_material[n_before])
        st = rmap_error_set(b->err, RMAP_SYSTEM, "out of memory: %zu faces", b->n_face);
out:
    return st;
}

enum rmap_status rmap_mesh_builder_fill_parts(struct rmap_mesh_builder *b, size_t n)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(b->face_material, b->cap_face_material, n + 1, b->err));
    RMAP_TRY(RMAP_RESERVE(b->face_part, b->cap_face_part, n + 1, b->err));
    for (; b->n_face_material < n; b->n_face_material++) {
        b->face_material[b->n_face_material] = NULL;
        b->face_part[b->n_face_material] = -1;
    }
out:
    return st;
}

/* As a share of the mesh's size: corners lie on the surface of their face to so much, or it is not
 * theirs. */
#define UNTRUE 1e-5

static double off_surface(const struct rmap_mesh *mesh, size_t triangle)
{
    const struct rmap_true_surface *surface = rmap_mesh_surface(mesh, triangle);
    struct rmap_vec3 corner[3], normal;
    double off = 0;
    rmap_mesh_corners(mesh, triangle, corner);
    for (int k = 0; surface && k < 3; k++)
        off = fmax(off, fabs(rmap_true_distance(surface, corner[k], &normal)));
    return off;
}

static enum rmap_status set_surfaces(struct rmap_mesh_builder *b, struct rmap_mesh *mesh)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_vec3 lower, upper;
    bool any = false;
    rmap_mesh_bounds(mesh, &lower, &upper);
    const double size = rmap_length(rmap_sub(upper, lower));
    mesh->surface = b->surface; /* taken over, as the names are */
    b->surface = NULL;
    for (size_t i = 0; i < mesh->n_triangle; i++) {
        if (off_surface(mesh, i) <= UNTRUE * size)
            continue;
        mesh->surface[mesh->face[i]] = (struct rmap_true_surface){.kind = RMAP_TRUE_NONE};
        b->left_out.untrue++;
    }
    for (size_t i = 0; i < mesh->n_face; i++)
        any = any || mesh->surface[i].kind != RMAP_TRUE_NONE;
    if (any)
        RMAP_TRY(rmap_mesh_share_surfaces(mesh, b->err));
    else {
        rmap_free(mesh->surface);
        mesh->surface = NULL;
    }
out:
    return st;
}

enum rmap_status rmap_mesh_builder_finish(struct rmap_mesh_builder *b, struct rmap_mesh **mesh_ret)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh *mesh = NULL;
    if (!b->n_triangle && b->left_out.undefined > 0)
        return rmap_error_set(b->err, RMAP_INPUT,
                              "none of its %zu triangles has an area: %zu have corners that are no "
                              "numbers (NaN or infinite), triangle %zu first",
                              b->left_out.degenerate + b->left_out.undefined, b->left_out.undefined,
                              b->left_out.first);
    if (!b->n_triangle && b->left_out.degenerate + b->left_out.undefined > 0)
        return rmap_error_set(b->err, RMAP_INPUT, "none of its %zu triangles has an area",
                              b->left_out.degenerate + b->left_out.undefined);
    if (!b->n_triangle)
        return rmap_error_set(b->err, RMAP_INPUT, "it holds no triangles");
    RMAP_TRY(rmap_mesh_create(b->n_vertex, b->n_triangle, b->n_face, &mesh, b->err));
    memcpy(mesh->vertex, b->vertex, b->n_vertex * sizeof *b->vertex);
    memcpy(mesh->triangle, b->triangle, b->n_triangle * sizeof *b->triangle);
    memcpy(mesh->face, b->face, b->n_triangle * sizeof *b->face);
    if (b->has_tangents) { /* taken over, as the names are */
        mesh->tangent = b->tangent;
        b->tangent = NULL;
    }
    if (b->has_uv) {
        mesh->uv = b->uv;
        b->uv = NULL;
    }
    for (size_t i = 0; i < b->n_face; i++) {
        mesh->face_name[i] = b->face_name[i];
        b->face_name[i] = NULL;
    }
    if (b->surface)
        RMAP_TRY(set_surfaces(b, mesh));
    *mesh_ret = mesh;
    mesh = NULL;
out:
    rmap_mesh_destroy(mesh);
    return st;
}

void rmap_mesh_builder_fini(struct rmap_mesh_builder *b)
{
    for (size_t i = 0; i < b->n_face; i++)
        rmap_free(b->face_name[i]);
    for (size_t i = 0; i < b->n_face_material; i++)
        rmap_free(b->face_material[i]);
    rmap_free(b->face_material);
    rmap_free(b->face_part);
    rmap_free(b->face_name);
    rmap_free(b->tangent);
    rmap_free(b->uv);
    rmap_free(b->surface);
    rmap_free(b->vertex);
    rmap_free(b->triangle);
    rmap_free(b->face);
    rmap_free(b->slot);
}

/* SPDX-License-Identifier: MIT
 *
 * Meshes of glTF 2.0. Read here because assimp 5.2 trusts the file: it follows nodes without end,
 * makes room for as many vertices as are claimed and writes where a sparse accessor says.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/vec.h"
#include "io/mesh/gltf_numbers.h"
#include "io/mesh/mesh_builder.h"

#define NODE_DEPTH_MAX 256

enum mode { TRIANGLES = 4, STRIP = 5, FAN = 6 };

struct gatherer {
    struct rmap_gltf gltf;
    double scale;
    struct rmap_mesh_builder *builder;
    bool *visited; /* [n_node] */
    size_t n_node;
    struct rmap_gltf_numbers point, corner, texture;
};

/* ---- places ---- */

/* As many numbers of a node as there are, rounded as glTF means them. False where they are wrong.
 */
static bool numbers_of(const json_t *node, const char *key, size_t n, double *value)
{
    const json_t *list = json_object_get(node, key);
    bool good = !list || json_array_size(list) == n;
    for (size_t i = 0; good && list && i < n; i++) {
        good = json_is_number(json_array_get(list, i));
        value[i] = (double)(float)json_number_value(json_array_get(list, i));
    }
    return good;
}

static bool node_place(const json_t *node, struct rmap_affine *place)
{
    double m[16] = {0}, t[3] = {0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    if (!numbers_of(node, "matrix", 16, m) || !numbers_of(node, "translation", 3, t) ||
        !numbers_of(node, "rotation", 4, q) || !numbers_of(node, "scale", 3, s))
        return false;
    if (json_object_get(node, "matrix")) {
        *place = (struct rmap_affine){{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}},
                                      {m[12], m[13], m[14]}};
        return true;
    }
    const double x = q[0], y = q[1], z = q[2], w = q[3];
    *place = (struct rmap_affine){
        {{s[0] * (1 - 2 * (y * y + z * z)), s[1] * 2 * (x * y - z * w), s[2] * 2 * (x * z + y * w)},
         {s[0] * 2 * (x * y + z * w), s[1] * (1 - 2 * (x * x + z * z)), s[2] * 2 * (y * z - x * w)},
         {s[0] * 2 * (x * z - y * w), s[1] * 2 * (y * z + x * w),
          s[2] * (1 - 2 * (x * x + y * y))}},
        {t[0], t[1], t[2]}};
    return true;
}

/* ---- parts of meshes ---- */

/* Corners of triangle i, or none. */
static size_t corner_of(size_t mode, size_t i, size_t k)
{
    if (mode == TRIANGLES)
        return 3 * i + k;
    if (mode == FAN)
        return k == 0 ? 0 : i + k;
    return k == 0 ? i : i % 2 ? i + 3 - k : i + k; /* every other one turns the other way */
}

static enum rmap_status add_triangles(struct gatherer *g, size_t mode, size_t n_corner,
                                      bool indexed, const struct rmap_affine *place)
{
    enum rmap_status st = RMAP_OK;
    const bool mirrored = rmap_affine_determinant(place) < 0;
    const size_t n = mode == TRIANGLES ? n_corner / 3 : n_corner < 3 ? 0 : n_corner - 2;
    for (size_t i = 0; i < n; i++) {
        const bool textured = g->texture.n == g->point.n;
        struct rmap_vec3 corner[3];
        double uv[3][2];
        for (size_t k = 0; k < 3; k++) {
            /* A mirror turns the sense of rotation: two corners change places. */
            const size_t at = corner_of(mode, i, mirrored ? 2 - k : k);
            const double index = indexed ? g->corner.value[at] : (double)at;
            if (!(index >= 0 && index < (double)g->point.n))
                return rmap_gltf_refuse(&g->gltf, "a triangle has a vertex that is not there");
            const double *v = &g->point.value[3 * (size_t)index];
            if (textured)
                memcpy(uv[k], &g->texture.value[2 * (size_t)index], sizeof uv[k]);
            corner[k] = rmap_scale(rmap_affine_point(place, rmap_vec3(v[0], v[1], v[2])), g->scale);
        }
        RMAP_TRY(rmap_mesh_builder_add(g->builder, corner, textured ? uv[0] : NULL));
    }
out:
    return st;
}

static const char *name_of(const json_t *object)
{
    const char *name = json_string_value(json_object_get(object, "name"));
    return name ? name : "";
}

/* The mesh's name, or its place in the file; its parts are numbered where there are several. */
static enum rmap_status close_face(struct gatherer *g, const json_t *mesh, size_t mesh_index,
                                   size_t part, size_t n_part, const char *material)
{
    char name[1100], number[32] = "";
    if (n_part > 1)
        (void)snprintf(number, sizeof number, "-%zu", part);
    if (name_of(mesh)[0])
        (void)snprintf(name, sizeof name, "%.1000s%s", name_of(mesh), number);
    else
        (void)snprintf(name, sizeof name, "meshes[%zu]%s", mesh_index, number);
    const enum rmap_status st = rmap_gltf_charge(&g->gltf, strlen(name) + strlen(material));
    return st == RMAP_OK ? rmap_mesh_builder_close_part(g->builder, name, material) : st;
}

static enum rmap_status add_mesh(struct gatherer *g, size_t index, const struct rmap_affine *place)
{
    enum rmap_status st = RMAP_OK;
    const json_t *root = g->gltf.root;
    const json_t *mesh = json_array_get(json_object_get(root, "meshes"), index);
    const json_t *parts = json_object_get(mesh, "primitives");
    if (!json_is_array(parts))
        return rmap_gltf_refuse(&g->gltf, "its mesh %zu is not there or wrong", index);
    for (size_t i = 0; i < json_array_size(parts); i++) {
        const json_t *part = json_array_get(parts, i);
        const bool indexed = json_object_get(part, "indices");
        const json_t *attributes = json_object_get(part, "attributes");
        size_t mode, position, texture, indices, material;
        RMAP_TRY(rmap_gltf_charge(&g->gltf, 1));
        if (!rmap_gltf_count(part, "mode", TRIANGLES, &mode) ||
            !rmap_gltf_count(part, "indices", 0, &indices) ||
            !rmap_gltf_count(part, "material", SIZE_MAX, &material) ||
            !rmap_gltf_count(attributes, "POSITION", SIZE_MAX, &position) ||
            !rmap_gltf_count(attributes, "TEXCOORD_0", SIZE_MAX, &texture))
            return rmap_gltf_refuse(&g->gltf, "its mesh %zu is wrong", index);
        if (mode < TRIANGLES || mode > FAN || position == SIZE_MAX)
            continue; /* points and lines; nothing */
        RMAP_TRY(rmap_gltf_numbers(&g->gltf, position, 3, &g->point));
        g->texture.n = 0;
        if (texture != SIZE_MAX && g->builder->wants_tangents)
            RMAP_TRY(rmap_gltf_numbers(&g->gltf, texture, 2, &g->texture));
        if (indexed)
            RMAP_TRY(rmap_gltf_numbers(&g->gltf, indices, 1, &g->corner));
        RMAP_TRY(add_triangles(g, mode, indexed ? g->corner.n : g->point.n, indexed, place));
        RMAP_TRY(close_face(g, mesh, index, i, json_array_size(parts),
                            name_of(json_array_get(json_object_get(root, "materials"), material))));
    }
out:
    return st;
}

/* ---- nodes ---- */

/* Once each: glTF's nodes are trees (3.5.2), so that a file cannot unfold to more than it has. */
static enum rmap_status add_nodes(struct gatherer *g, const json_t *list,
                                  const struct rmap_affine *parent, int depth)
{
    enum rmap_status st = RMAP_OK;
    if (depth > NODE_DEPTH_MAX && json_array_size(list) > 0)
        return rmap_gltf_refuse(&g->gltf, "its nodes are nested more than %d deep", NODE_DEPTH_MAX);
    for (size_t i = 0; i < json_array_size(list); i++) {
        const json_t *number = json_array_get(list, i);
        const json_int_t index = json_integer_value(number);
        const json_t *node = json_array_get(json_object_get(g->gltf.root, "nodes"), (size_t)index);
        struct rmap_affine own;
        size_t mesh;
        if (!json_is_integer(number) || index < 0 || !json_is_object(node) ||
            !node_place(node, &own) || !rmap_gltf_count(node, "mesh", SIZE_MAX, &mesh))
            return rmap_gltf_refuse(&g->gltf, "its node %lld is not there or wrong",
                                    (long long)index);
        if (g->visited[index])
            return rmap_gltf_refuse(&g->gltf, "its node %lld stands in two places",
                                    (long long)index);
        g->visited[index] = true;
        const struct rmap_affine place = rmap_affine_compose(parent, &own);
        if (mesh != SIZE_MAX)
            RMAP_TRY(add_mesh(g, mesh, &place));
        RMAP_TRY(add_nodes(g, json_object_get(node, "children"), &place, depth + 1));
    }
out:
    return st;
}

enum rmap_status rmap_gltf_read(const char *path, const uint8_t *bytes, size_t nbytes, double scale,
                                struct rmap_mesh_builder *builder)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_affine identity = rmap_affine_identity();
    struct gatherer g = {.scale = scale, .builder = builder};
    size_t scene;
    RMAP_TRY(rmap_gltf_init(&g.gltf, path, bytes, nbytes, builder->err));
    g.n_node = json_array_size(json_object_get(g.gltf.root, "nodes"));
    g.visited = rmap_alloc(g.n_node, sizeof *g.visited);
    if (!g.visited)
        RMAP_TRY(
            rmap_error_set(builder->err, RMAP_SYSTEM, "out of memory for %zu nodes", g.n_node));
    if (!rmap_gltf_count(g.gltf.root, "scene", 0, &scene))
        RMAP_TRY(rmap_gltf_refuse(&g.gltf, "its scene is wrong"));
    const json_t *chosen = json_array_get(json_object_get(g.gltf.root, "scenes"), scene);
    if (!json_is_object(chosen))
        RMAP_TRY(rmap_gltf_refuse(&g.gltf, "it has no scene"));
    RMAP_TRY(add_nodes(&g, json_object_get(chosen, "nodes"), &identity, 1));
out:
    rmap_free(g.visited);
    rmap_free(g.point.value);
    rmap_free(g.corner.value);
    rmap_free(g.texture.value);
    rmap_gltf_fini(&g.gltf);
    return st;
}

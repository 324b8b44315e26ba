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
#include "io/mesh/gltf_tree.h"
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
    struct rmap_gltf_tree *tree; /* where nodes and materials go; NULL: all is one mesh */
    int32_t *material;           /* [builder->n_face] of the mesh in hand */
    size_t cap_material;
    size_t mesh, primitive; /* in hand */
};

/* ---- places ---- */

/* As many numbers of a node as there are, rounded as glTF means them, or, for a tree that people
 * read, as they are written. False where they are wrong. */
static bool numbers_of(const json_t *node, const char *key, size_t n, bool written, double *value)
{
    const json_t *list = json_object_get(node, key);
    bool good = !list || json_array_size(list) == n;
    for (size_t i = 0; good && list && i < n; i++) {
        good = json_is_number(json_array_get(list, i));
        const double number = json_number_value(json_array_get(list, i));
        value[i] = written ? number : (double)(float)number;
    }
    return good;
}

/* A quaternion of length 1 but for its last digits. */
static void settle_length(double q[4])
{
    const double length = sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
    for (int k = 0; k < 4 && fabs(length - 1) < 1e-4; k++)
        q[k] /= length;
}

static bool node_place(const json_t *node, bool written, struct rmap_affine *place)
{
    double m[16] = {0}, t[3] = {0}, q[4] = {0, 0, 0, 1}, s[3] = {1, 1, 1};
    if (!numbers_of(node, "matrix", 16, written, m) ||
        !numbers_of(node, "translation", 3, written, t) ||
        !numbers_of(node, "rotation", 4, written, q) || !numbers_of(node, "scale", 3, written, s))
        return false;
    if (json_object_get(node, "matrix")) {
        *place = (struct rmap_affine){{{m[0], m[4], m[8]}, {m[1], m[5], m[9]}, {m[2], m[6], m[10]}},
                                      {m[12], m[13], m[14]}};
        return true;
    }
    if (written)
        settle_length(q);
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
                return rmap_gltf_refuse(
                    &g->gltf,
                    "meshes[%zu].primitives[%zu]: triangle %zu has vertex %.0f, "
                    "a vertex that is not there: there are 0 to %.0f",
                    g->mesh, g->primitive, i + 1, index, (double)g->point.n - 1);
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

/* Of the face that was closed last, if there was one. */
static enum rmap_status note_material(struct gatherer *g, size_t n_before, size_t material)
{
    if (!g->tree || g->builder->n_face == n_before)
        return RMAP_OK;
    const enum rmap_status st =
        RMAP_RESERVE(g->material, g->cap_material, n_before + 1, g->builder->err);
    if (st == RMAP_OK)
        g->material[n_before] = material < g->tree->n_material ? (int32_t)material : -1;
    return st;
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
        const size_t n_before = g->builder->n_face;
        const json_t *attributes = json_object_get(part, "attributes");
        size_t mode, position, texture, indices, material;
        g->mesh = index;
        g->primitive = i;
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
        if (texture != SIZE_MAX && (g->builder->wants_tangents || g->builder->wants_uv))
            RMAP_TRY(rmap_gltf_numbers(&g->gltf, texture, 2, &g->texture));
        if (indexed)
            RMAP_TRY(rmap_gltf_numbers(&g->gltf, indices, 1, &g->corner));
        RMAP_TRY(add_triangles(g, mode, indexed ? g->corner.n : g->point.n, indexed, place));
        RMAP_TRY(close_face(g, mesh, index, i, json_array_size(parts),
                            name_of(json_array_get(json_object_get(root, "materials"), material))));
        RMAP_TRY(note_material(g, n_before, material));
    }
out:
    return st;
}

/* ---- nodes ---- */

static enum rmap_status note_node(struct gatherer *g, const json_t *node, size_t mesh,
                                  const struct rmap_affine *own, int32_t parent)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_gltf_tree *tree = g->tree;
    RMAP_TRY(rmap_gltf_charge(&g->gltf, 1 + strlen(name_of(node))));
    RMAP_TRY(RMAP_RESERVE(tree->node, tree->cap_node, tree->n_node + 1, g->builder->err));
    struct rmap_gltf_node *to = &tree->node[tree->n_node];
    *to = (struct rmap_gltf_node){.name = rmap_strdup(name_of(node)),
                                  .place = *own,
                                  .parent = parent,
                                  .mesh = mesh < tree->n_mesh ? (int32_t)mesh : -1};
    to->place.t = rmap_scale(own->t, g->scale);
    if (!to->name)
        return rmap_error_set(g->builder->err, RMAP_SYSTEM, "out of memory for a node");
    tree->n_node++;
out:
    return st;
}

/* Once each: glTF's nodes are trees (3.5.2), so that a file cannot unfold to more than it has. */
static enum rmap_status add_nodes(struct gatherer *g, const json_t *list,
                                  const struct rmap_affine *parent, int32_t above, int depth)
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
            !node_place(node, g->tree != NULL, &own) ||
            !rmap_gltf_count(node, "mesh", SIZE_MAX, &mesh))
            return rmap_gltf_refuse(&g->gltf, "its node %lld is not there or wrong",
                                    (long long)index);
        if (g->visited[index])
            return rmap_gltf_refuse(&g->gltf, "its node %lld stands in two places",
                                    (long long)index);
        g->visited[index] = true;
        const struct rmap_affine place = rmap_affine_compose(parent, &own);
        if (g->tree)
            RMAP_TRY(note_node(g, node, mesh, &own, above));
        else if (mesh != SIZE_MAX)
            RMAP_TRY(add_mesh(g, mesh, &place));
        RMAP_TRY(add_nodes(g, json_object_get(node, "children"), &place,
                           g->tree ? (int32_t)g->tree->n_node - 1 : -1, depth + 1));
    }
out:
    return st;
}

static enum rmap_status gather(struct gatherer *g)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_affine identity = rmap_affine_identity();
    size_t scene;
    g->builder->v_down = true; /* glTF 2.0, 3.8.2 */
    g->n_node = json_array_size(json_object_get(g->gltf.root, "nodes"));
    g->visited = rmap_alloc(g->n_node, sizeof *g->visited);
    if (!g->visited)
        RMAP_TRY(
            rmap_error_set(g->builder->err, RMAP_SYSTEM, "out of memory for %zu nodes", g->n_node));
    if (!rmap_gltf_count(g->gltf.root, "scene", 0, &scene))
        RMAP_TRY(rmap_gltf_refuse(&g->gltf, "its scene is wrong"));
    const json_t *chosen = json_array_get(json_object_get(g->gltf.root, "scenes"), scene);
    if (!json_is_object(chosen))
        RMAP_TRY(rmap_gltf_refuse(&g->gltf, "it has no scene"));
    RMAP_TRY(add_nodes(g, json_object_get(chosen, "nodes"), &identity, -1, 1));
out:
    return st;
}

static void fini(struct gatherer *g)
{
    rmap_free(g->visited);
    rmap_free(g->material);
    rmap_free(g->point.value);
    rmap_free(g->corner.value);
    rmap_free(g->texture.value);
    rmap_gltf_fini(&g->gltf);
}

enum rmap_status rmap_gltf_read(const char *path, const uint8_t *bytes, size_t nbytes, double scale,
                                struct rmap_mesh_builder *builder)
{
    struct gatherer g = {.scale = scale, .builder = builder};
    enum rmap_status st = rmap_gltf_init(&g.gltf, path, bytes, nbytes, builder->err);
    if (st == RMAP_OK)
        st = gather(&g);
    builder->left_out.elsewhere = g.gltf.elsewhere;
    fini(&g);
    return st;
}

/* ---- trees ---- */

static double factor_of(const json_t *object, const char *key, double otherwise)
{
    const json_t *value = json_object_get(object, key);
    const double number = json_is_number(value) ? json_number_value(value) : otherwise;
    return fmin(fmax(number, 0), 10);
}

/* Some programs write BLEND whatever the alpha is. */
static bool is_blended(const json_t *material, const json_t *metal, const json_t *base)
{
    const char *mode = json_string_value(json_object_get(material, "alphaMode"));
    const json_t *alpha = json_array_get(base, 3);
    const bool covers =
        alpha && json_number_value(alpha) >= 1 && !json_object_get(metal, "baseColorTexture");
    return mode && strcmp(mode, "BLEND") == 0 && !covers;
}

static enum rmap_status read_materials(struct gatherer *g)
{
    const json_t *list = json_object_get(g->gltf.root, "materials");
    const size_t n = json_array_size(list);
    g->tree->material = rmap_alloc(n, sizeof *g->tree->material);
    for (size_t i = 0; g->tree->material && i < n; i++) {
        const json_t *from = json_array_get(list, i);
        const json_t *metal = json_object_get(from, "pbrMetallicRoughness"),
                     *base = json_object_get(metal, "baseColorFactor"),
                     *more = json_object_get(from, "extensions");
        struct rmap_gltf_material *to = &g->tree->material[i];
        *to = (struct rmap_gltf_material){
            .name = rmap_strdup(name_of(from)),
            .metalness = factor_of(metal, "metallicFactor", 0),
            .roughness = factor_of(metal, "roughnessFactor", 1),
            .transmission = factor_of(json_object_get(more, "KHR_materials_transmission"),
                                      "transmissionFactor", 0),
            .index = factor_of(json_object_get(more, "KHR_materials_ior"), "ior", 1.5)};
        if (is_blended(from, metal, base))
            to->transmission = fmax(to->transmission, 1);
        for (size_t k = 0; k < 3; k++) {
            const json_t *part = json_array_get(base, k);
            to->colour[k] = part ? fmin(fmax(json_number_value(part), 0), 1) : 1;
        }
        g->tree->n_material = i + 1;
        if (!to->name)
            return rmap_error_set(g->builder->err, RMAP_SYSTEM, "out of memory for materials");
    }
    return g->tree->material
               ? RMAP_OK
               : rmap_error_set(g->builder->err, RMAP_SYSTEM, "out of memory for materials");
}

/* Each mesh once, in its own frame, if a node has it. */
static enum rmap_status read_meshes(struct gatherer *g, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_affine identity = rmap_affine_identity();
    const json_t *list = json_object_get(g->gltf.root, "meshes");
    for (size_t k = 0; k < g->tree->n_node && st == RMAP_OK; k++) {
        const int32_t i = g->tree->node[k].mesh;
        struct rmap_gltf_mesh *to = i >= 0 ? &g->tree->mesh[i] : NULL;
        struct rmap_mesh_builder builder = {.err = err};
        if (!to || to->name)
            continue;
        g->builder = &builder;
        to->name = rmap_strdup(name_of(json_array_get(list, (size_t)i)));
        st = to->name ? add_mesh(g, (size_t)i, &identity)
                      : rmap_error_set(err, RMAP_SYSTEM, "out of memory for meshes");
        to->left_out = builder.left_out;
        if (st == RMAP_OK && builder.n_triangle > 0) {
            st = rmap_mesh_builder_finish(&builder, &to->mesh);
            to->material = g->material;
            g->material = NULL;
            g->cap_material = 0;
        }
        rmap_mesh_builder_fini(&builder);
    }
    return st;
}

enum rmap_status rmap_gltf_read_tree(const char *path, const uint8_t *bytes, size_t nbytes,
                                     double scale, struct rmap_gltf_tree *tree,
                                     struct rmap_error *err)
{
    struct rmap_mesh_builder none = {.err = err};
    struct gatherer g = {.scale = scale, .builder = &none, .tree = tree};
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_gltf_init(&g.gltf, path, bytes, nbytes, err));
    tree->n_mesh = json_array_size(json_object_get(g.gltf.root, "meshes"));
    tree->mesh = rmap_alloc(tree->n_mesh, sizeof *tree->mesh);
    if (!tree->mesh) {
        tree->n_mesh = 0;
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for meshes"));
    }
    RMAP_TRY(read_materials(&g));
    RMAP_TRY(gather(&g));
    st = read_meshes(&g, err);
out:
    fini(&g);
    return st;
}

void rmap_gltf_tree_fini(struct rmap_gltf_tree *tree)
{
    for (size_t i = 0; i < tree->n_node; i++)
        rmap_free(tree->node[i].name);
    for (size_t i = 0; i < tree->n_mesh; i++) {
        rmap_free(tree->mesh[i].name);
        rmap_free(tree->mesh[i].material);
        rmap_mesh_destroy(tree->mesh[i].mesh);
    }
    for (size_t i = 0; i < tree->n_material; i++)
        rmap_free(tree->material[i].name);
    rmap_free(tree->node);
    rmap_free(tree->mesh);
    rmap_free(tree->material);
    *tree = (struct rmap_gltf_tree){0};
}

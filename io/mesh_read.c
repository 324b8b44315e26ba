/* SPDX-License-Identifier: MIT
 *
 * Meshes from files, through assimp, which is asked to triangulate and for nothing else. Equal
 * positions become one vertex, so that neighbouring triangles share their edges to the bit.
 */
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <fcntl.h>
#include <math.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/bundle.h"

#define TRIANGLES_MAX  ((uint64_t)1 << 31)
#define NODE_DEPTH_MAX 256

struct gatherer {
    const struct aiScene *scene;
    double scale;
    uint64_t n_triangle, n_face; /* first pass: room needed */
    struct rmap_mesh *mesh;      /* second pass: n_... count what is filled */
    size_t n_degenerate;
    uint32_t *slot; /* vertices by position; 0: free, else index + 1 */
    size_t n_slot;
    struct rmap_error *err;
};

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory while reading a mesh");
}

static struct rmap_affine node_place(const struct aiNode *node, const struct rmap_affine *parent)
{
    const struct aiMatrix4x4 *a = &node->mTransformation;
    const struct rmap_affine own = {
        {{(double)a->a1, (double)a->a2, (double)a->a3},
         {(double)a->b1, (double)a->b2, (double)a->b3},
         {(double)a->c1, (double)a->c2, (double)a->c3}},
        {(double)a->a4, (double)a->b4, (double)a->c4},
    };
    return rmap_affine_compose(parent, &own);
}

static bool is_triangle(const struct aiMesh *mesh, unsigned face)
{
    const struct aiFace *f = &mesh->mFaces[face];
    if (f->mNumIndices != 3)
        return false;
    for (int k = 0; k < 3; k++)
        if (f->mIndices[k] >= mesh->mNumVertices)
            return false;
    return true;
}

static uint64_t count_triangles(const struct aiMesh *mesh)
{
    uint64_t n = 0;
    for (unsigned i = 0; mesh->mVertices && mesh->mFaces && i < mesh->mNumFaces; i++)
        n += is_triangle(mesh, i);
    return n;
}

static const struct aiMesh *mesh_of(const struct gatherer *g, const struct aiNode *node, unsigned i)
{
    return node->mMeshes[i] < g->scene->mNumMeshes ? g->scene->mMeshes[node->mMeshes[i]] : NULL;
}

/* ---- first pass ---- */

static enum rmap_status count_node(struct gatherer *g, const struct aiNode *node, int depth)
{
    enum rmap_status st = RMAP_OK;
    if (depth > NODE_DEPTH_MAX)
        return rmap_error_set(g->err, RMAP_INPUT, "its parts are nested too deeply");
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        const struct aiMesh *mesh = mesh_of(g, node, i);
        uint64_t n = mesh ? count_triangles(mesh) : 0;
        g->n_triangle += n;
        g->n_face += n > 0;
        if (g->n_triangle >= TRIANGLES_MAX)
            return rmap_error_set(g->err, RMAP_INPUT, "it has 2^31 triangles or more");
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        RMAP_TRY(count_node(g, node->mChildren[i], depth + 1));
out:
    return st;
}

/* ---- second pass ---- */

static uint32_t vertex_index(struct gatherer *g, const float position[3])
{
    float key[3];
    for (int k = 0; k < 3; k++)
        key[k] = position[k] == 0.0f ? 0.0f : position[k]; /* -0 is 0 */
    size_t mask = g->n_slot - 1, slot = (size_t)XXH3_64bits(key, sizeof key) & mask;
    for (; g->slot[slot]; slot = (slot + 1) & mask)
        if (memcmp(g->mesh->vertex[g->slot[slot] - 1], key, sizeof key) == 0)
            return g->slot[slot] - 1;
    memcpy(g->mesh->vertex[g->mesh->n_vertex], key, sizeof key);
    g->slot[slot] = (uint32_t)++g->mesh->n_vertex;
    return (uint32_t)g->mesh->n_vertex - 1;
}

static bool has_area(const float corner[3][3])
{
    struct rmap_vec3 p[3];
    for (int k = 0; k < 3; k++)
        p[k] = rmap_vec3((double)corner[k][0], (double)corner[k][1], (double)corner[k][2]);
    double area = rmap_length(rmap_cross(rmap_sub(p[1], p[0]), rmap_sub(p[2], p[0])));
    return area > 0 && isfinite(area);
}

static void add_triangles(struct gatherer *g, const struct aiMesh *from,
                          const struct rmap_affine *place)
{
    struct rmap_mesh *mesh = g->mesh;
    bool mirrored = rmap_affine_determinant(place) < 0;
    for (unsigned i = 0; i < from->mNumFaces; i++) {
        if (!is_triangle(from, i))
            continue;
        float corner[3][3];
        for (int k = 0; k < 3; k++) {
            /* A mirror turns the sense of rotation: two corners change places. */
            const struct aiVector3D *v =
                &from->mVertices[from->mFaces[i].mIndices[mirrored ? 2 - k : k]];
            struct rmap_vec3 p =
                rmap_affine_point(place, rmap_vec3((double)v->x, (double)v->y, (double)v->z));
            corner[k][0] = (float)(p.x * g->scale);
            corner[k][1] = (float)(p.y * g->scale);
            corner[k][2] = (float)(p.z * g->scale);
        }
        if (!has_area((const float(*)[3])corner)) {
            g->n_degenerate++;
            continue;
        }
        for (int k = 0; k < 3; k++)
            mesh->triangle[mesh->n_triangle][k] = vertex_index(g, corner[k]);
        mesh->face[mesh->n_triangle++] = (uint32_t)mesh->n_face;
    }
}

/* By one of the latest parts: a file has the materials of a part one after the other. */
static bool face_name_taken(const struct rmap_mesh *mesh, const char *name)
{
    enum { LATEST = 64 };
    for (size_t i = mesh->n_face > LATEST ? mesh->n_face - LATEST : 0; i < mesh->n_face; i++)
        if (mesh->face_name[i] && strcmp(mesh->face_name[i], name) == 0)
            return true;
    return false;
}

/* The part's name in the file; parts of one name are told apart by their material. */
static char *face_name(const struct gatherer *g, const struct aiNode *node,
                       const struct aiMesh *mesh)
{
    enum { LONGEST = 2 * MAXLEN };
    struct aiString material = {0};
    char text[LONGEST];
    const char *name = mesh->mName.length ? mesh->mName.data : node->mName.data;
    if (mesh->mMaterialIndex < g->scene->mNumMaterials)
        (void)aiGetMaterialString(g->scene->mMaterials[mesh->mMaterialIndex], AI_MATKEY_NAME,
                                  &material);
    if (strcmp(material.data, AI_DEFAULT_MATERIAL_NAME) == 0)
        material = (struct aiString){0};
    if (!name[0])
        name = material.data;
    if (!name[0])
        return NULL;
    if (!face_name_taken(g->mesh, name) || !material.length)
        return rmap_strdup(name);
    (void)snprintf(text, sizeof text, "%s/%s", name, material.data);
    return rmap_strdup(text);
}

static void fill_node(struct gatherer *g, const struct aiNode *node,
                      const struct rmap_affine *parent)
{
    const struct rmap_affine place = node_place(node, parent);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        const struct aiMesh *from = mesh_of(g, node, i);
        if (!from || !count_triangles(from))
            continue;
        size_t before = g->mesh->n_triangle;
        add_triangles(g, from, &place);
        if (g->mesh->n_triangle == before)
            continue;
        g->mesh->face_name[g->mesh->n_face] = face_name(g, node, from);
        g->mesh->n_face++;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        fill_node(g, node->mChildren[i], &place);
}

static enum rmap_status gather(struct gatherer *g, struct rmap_mesh **mesh_ret)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_affine identity = rmap_affine_identity();
    if (!g->scene->mRootNode)
        return rmap_error_set(g->err, RMAP_INPUT, "it holds no mesh");
    RMAP_TRY(count_node(g, g->scene->mRootNode, 0));
    if (!g->n_triangle) {
        st = rmap_error_set(g->err, RMAP_INPUT, "it holds no triangles");
        goto out;
    }
    if (3 * g->n_triangle >= UINT32_MAX) {
        st = rmap_error_set(g->err, RMAP_INPUT, "it has %llu triangles, too many",
                            (unsigned long long)g->n_triangle);
        goto out;
    }
    for (g->n_slot = 64; g->n_slot < 6 * g->n_triangle; g->n_slot *= 2)
        ;
    g->slot = rmap_alloc(g->n_slot, sizeof *g->slot);
    if (!g->slot) {
        st = no_memory(g->err);
        goto out;
    }
    RMAP_TRY(rmap_mesh_create((size_t)(3 * g->n_triangle), (size_t)g->n_triangle, (size_t)g->n_face,
                              &g->mesh, g->err));
    g->mesh->n_vertex = g->mesh->n_triangle = g->mesh->n_face = 0;
    fill_node(g, g->scene->mRootNode, &identity);
    if (!g->mesh->n_triangle) {
        st = rmap_error_set(g->err, RMAP_INPUT, "none of its %llu triangles has an area",
                            (unsigned long long)g->n_triangle);
        goto out;
    }
    RMAP_TRY(rmap_mesh_copy(g->mesh, mesh_ret, g->err)); /* to size */
out:
    rmap_free(g->slot);
    rmap_mesh_destroy(g->mesh);
    return st;
}

/* ---- files ---- */

static enum rmap_status check_file(const char *path, struct rmap_error *err)
{
    static const char *const known[] = {".stl", ".obj", ".ply", ".gltf", ".glb"};
    const char *ending = strrchr(path, '.');
    struct stat info;
    bool fits = false;
    for (size_t i = 0; ending && i < sizeof known / sizeof known[0]; i++)
        fits |= strcasecmp(ending, known[i]) == 0;
    if (!fits)
        return rmap_error_set(err, RMAP_INPUT,
                              "cannot read mesh %s: its name must end in .stl, .obj, .ply, .gltf "
                              "or .glb",
                              path);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return rmap_error_set(err, RMAP_INPUT, "cannot open mesh %s: %s", path, strerror(errno));
    int failed = fstat(fd, &info);
    (void)close(fd);
    if (failed || !S_ISREG(info.st_mode))
        return rmap_error_set(err, RMAP_INPUT, "cannot read mesh %s: it is no regular file", path);
    if (info.st_size == 0)
        return rmap_error_set(err, RMAP_INPUT, "cannot read mesh %s: the file is empty", path);
    return RMAP_OK;
}

enum rmap_status rmap_mesh_read(const char *path, double scale, struct rmap_mesh **mesh_ret,
                                size_t *n_degenerate_ret, struct rmap_error *err)
{
    enum rmap_status st = check_file(path, err);
    if (st != RMAP_OK)
        return st;
    const struct aiScene *scene = aiImportFile(path, aiProcess_Triangulate);
    if (!scene) {
        const char *text = aiGetErrorString();
        return rmap_error_set(err, RMAP_INPUT, "cannot read mesh %s: %.300s (is the file whole?)",
                              path,
                              text && text[0] ? text : "it is no mesh that can be understood");
    }
    struct gatherer g = {.scene = scene, .scale = scale, .err = err};
    st = gather(&g, mesh_ret);
    aiReleaseImport(scene);
    if (st == RMAP_INPUT)
        rmap_error_context(err, "cannot read mesh %s", path);
    if (st == RMAP_OK)
        *n_degenerate_ret = g.n_degenerate;
    return st;
}

enum rmap_status rmap_mesh_copy(const struct rmap_mesh *from, struct rmap_mesh **mesh_ret,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh *mesh = NULL;
    RMAP_TRY(rmap_mesh_create(from->n_vertex, from->n_triangle, from->n_face, &mesh, err));
    memcpy(mesh->vertex, from->vertex, from->n_vertex * sizeof *from->vertex);
    memcpy(mesh->triangle, from->triangle, from->n_triangle * sizeof *from->triangle);
    memcpy(mesh->face, from->face, from->n_triangle * sizeof *from->face);
    for (size_t i = 0; i < from->n_face; i++) {
        mesh->face_name[i] = rmap_strdup(from->face_name[i]);
        if (from->face_name[i] && !mesh->face_name[i]) {
            st = no_memory(err);
            goto out;
        }
    }
    *mesh_ret = mesh;
    mesh = NULL;
out:
    rmap_mesh_destroy(mesh);
    return st;
}

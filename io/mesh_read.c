/* SPDX-License-Identifier: MIT
 *
 * Meshes from files: STL, OBJ and glTF through assimp, which is asked to triangulate and for
 * nothing else; PLY by mesh_ply.c.
 */
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/alloc.h"
#include "io/bundle.h"
#include "io/mesh_builder.h"

#define NODE_DEPTH_MAX 256

struct gatherer {
    const struct aiScene *scene;
    double scale;
    struct rmap_mesh_builder *builder;
};

/* ---- what assimp made of a file ---- */

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
    bool good = f->mNumIndices == 3;
    for (int k = 0; good && k < 3; k++)
        good = f->mIndices[k] < mesh->mNumVertices;
    return good;
}

static enum rmap_status add_triangles(struct gatherer *g, const struct aiMesh *from,
                                      const struct rmap_affine *place)
{
    enum rmap_status st = RMAP_OK;
    bool mirrored = rmap_affine_determinant(place) < 0;
    for (unsigned i = 0; from->mVertices && i < from->mNumFaces; i++) {
        struct rmap_vec3 corner[3];
        if (!is_triangle(from, i))
            continue;
        for (int k = 0; k < 3; k++) {
            /* A mirror turns the sense of rotation: two corners change places. */
            const struct aiVector3D *v =
                &from->mVertices[from->mFaces[i].mIndices[mirrored ? 2 - k : k]];
            struct rmap_vec3 local = rmap_vec3((double)v->x, (double)v->y, (double)v->z);
            corner[k] = rmap_scale(rmap_affine_point(place, local), g->scale);
        }
        RMAP_TRY(rmap_mesh_builder_add(g->builder, corner));
    }
out:
    return st;
}

/* By one of the latest parts: a file has the materials of a part one after the other. */
static bool name_taken(const struct rmap_mesh_builder *builder, const char *name)
{
    enum { LATEST = 64 };
    for (size_t i = builder->n_face > LATEST ? builder->n_face - LATEST : 0; i < builder->n_face;
         i++)
        if (builder->face_name[i] && strcmp(builder->face_name[i], name) == 0)
            return true;
    return false;
}

/* The part's name in the file, which may have none; parts of one name are told apart by their
 * material. */
static enum rmap_status close_face(struct gatherer *g, const struct aiNode *node,
                                   const struct aiMesh *mesh)
{
    enum { LONGEST = 2 * MAXLEN + 2 };
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
    bool taken = name_taken(g->builder, name) && material.length;
    (void)snprintf(text, sizeof text, "%s%s%s", name, taken ? "/" : "", taken ? material.data : "");
    return rmap_mesh_builder_close_face(g->builder, text[0] ? text : NULL);
}

static enum rmap_status gather(struct gatherer *g, const struct aiNode *node,
                               const struct rmap_affine *parent, int depth)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_affine place = node_place(node, parent);
    if (depth > NODE_DEPTH_MAX)
        return rmap_error_set(g->builder->err, RMAP_INPUT, "its parts are nested too deeply");
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= g->scene->mNumMeshes)
            continue;
        const struct aiMesh *mesh = g->scene->mMeshes[node->mMeshes[i]];
        RMAP_TRY(add_triangles(g, mesh, &place));
        RMAP_TRY(close_face(g, node, mesh));
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        RMAP_TRY(gather(g, node->mChildren[i], &place, depth + 1));
out:
    return st;
}

static enum rmap_status read_through_assimp(const char *path, double scale,
                                            struct rmap_mesh_builder *builder)
{
    const struct rmap_affine identity = rmap_affine_identity();
    const struct aiScene *scene = aiImportFile(path, aiProcess_Triangulate);
    if (!scene) {
        const char *text = aiGetErrorString();
        return rmap_error_set(builder->err, RMAP_INPUT, "%.300s (is the file whole?)",
                              text && text[0] ? text : "it is no mesh that can be understood");
    }
    struct gatherer g = {scene, scale, builder};
    enum rmap_status st = scene->mRootNode ? gather(&g, scene->mRootNode, &identity, 0) : RMAP_OK;
    aiReleaseImport(scene);
    return st;
}

/* ---- files ---- */

static bool ends_in(const char *path, const char *ending)
{
    size_t len = strlen(path), ending_len = strlen(ending);
    return len > ending_len && strcasecmp(path + len - ending_len, ending) == 0;
}

static uint32_t word_at(const uint8_t *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 |
           (uint32_t)bytes[3] << 24;
}

/* assimp makes room for whatever a GLB says its first chunk is long (glTF 2.0, 4.4). */
static bool glb_fits(int fd, off_t nbytes)
{
    uint8_t head[20] = {0};
    return read(fd, head, sizeof head) == (ssize_t)sizeof head && memcmp(head, "glTF", 4) == 0 &&
           (off_t)word_at(head + 8) <= nbytes && (off_t)word_at(head + 12) <= nbytes - 20;
}

static enum rmap_status check_file(const char *path, struct rmap_error *err)
{
    static const char *const known[] = {".stl", ".obj", ".ply", ".gltf", ".glb"};
    struct stat info;
    bool fits = false;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        fits |= ends_in(path, known[i]);
    if (!fits)
        return rmap_error_set(err, RMAP_INPUT,
                              "cannot read mesh %s: its name must end in .stl, .obj, .ply, .gltf "
                              "or .glb",
                              path);
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd < 0)
        return rmap_error_set(err, RMAP_INPUT, "cannot open mesh %s: %s", path, strerror(errno));
    const char *wrong = NULL;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        wrong = "it is no regular file";
    else if (info.st_size == 0)
        wrong = "the file is empty";
    else if (ends_in(path, ".glb") && !glb_fits(fd, info.st_size))
        wrong = "it is no GLB file, or cut off";
    (void)close(fd);
    return wrong ? rmap_error_set(err, RMAP_INPUT, "cannot read mesh %s: %s", path, wrong)
                 : RMAP_OK;
}

enum rmap_status rmap_mesh_read(const char *path, double scale, struct rmap_mesh **mesh_ret,
                                size_t *n_degenerate_ret, struct rmap_error *err)
{
    enum rmap_status st = check_file(path, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_mesh_builder builder = {.err = err};
    RMAP_TRY(ends_in(path, ".ply") ? rmap_ply_read(path, scale, &builder)
                                   : read_through_assimp(path, scale, &builder));
    RMAP_TRY(rmap_mesh_builder_finish(&builder, mesh_ret));
    *n_degenerate_ret = builder.n_degenerate;
out:
    rmap_mesh_builder_fini(&builder);
    if (st == RMAP_INPUT)
        rmap_error_context(err, "cannot read mesh %s", path);
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
        if (from->face_name[i] && !mesh->face_name[i])
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a mesh"));
    }
    *mesh_ret = mesh;
    mesh = NULL;
out:
    rmap_mesh_destroy(mesh);
    return st;
}

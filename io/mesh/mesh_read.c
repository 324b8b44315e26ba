/* SPDX-License-Identifier: MIT
 *
 * Meshes from files: STL and OBJ through assimp, which is asked to triangulate and for nothing
 * else, and is given one file's bytes; PLY and glTF by mesh_ply.c and mesh_gltf.c.
 */
#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/material.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <string.h>
#include <strings.h>

#include "base/alloc.h"
#include "base/count.h"
#include "base/late_library.h"
#include "io/file/input_file.h"
#include "io/mesh/bundle.h"
#include "io/mesh/gltf_numbers.h"
#include "io/mesh/mesh_builder.h"
#include "io/mesh/mesh_cache.h"
#include "io/mesh/mesh_read.h"
#include "io/mesh/text_fault.h"

#define NODE_DEPTH_MAX 256
#define CORNERS_MAX    4096

#define ASSIMP(X)                                                                                  \
    X(aiImportFileEx)                                                                              \
    X(aiGetMaterialString)                                                                         \
    X(aiGetErrorString)                                                                            \
    X(aiReleaseImport)

struct assimp {
    ASSIMP(RMAP_LATE_MEMBER)
};
static const char *const assimp_name[] = {ASSIMP(RMAP_LATE_NAME)};

struct gatherer {
    const struct assimp *by;
    const struct aiScene *scene;
    double scale;
    struct rmap_mesh_builder *builder;
    const struct rmap_obj_names *names; /* or NULL */
};

static bool ends_in(const char *path, const char *ending)
{
    size_t len = strlen(path), ending_len = strlen(ending);
    return len > ending_len && strcasecmp(path + len - ending_len, ending) == 0;
}

/* ---- what assimp made of a file ---- */

static bool is_triangle(const struct aiMesh *mesh, unsigned face)
{
    const struct aiFace *f = &mesh->mFaces[face];
    bool good = f->mNumIndices == 3;
    for (int k = 0; good && k < 3; k++)
        good = f->mIndices[k] < mesh->mNumVertices;
    return good;
}

static enum rmap_status add_triangles(struct gatherer *g, const struct aiMesh *from)
{
    enum rmap_status st = RMAP_OK;
    for (unsigned i = 0; from->mVertices && i < from->mNumFaces; i++) {
        const struct aiVector3D *texture = from->mTextureCoords[0];
        struct rmap_vec3 corner[3];
        double uv[3][2];
        if (!is_triangle(from, i))
            continue;
        for (int k = 0; k < 3; k++) {
            const unsigned at = from->mFaces[i].mIndices[k];
            const struct aiVector3D *v = &from->mVertices[at];
            uv[k][0] = texture ? (double)texture[at].x : 0.0;
            uv[k][1] = texture ? (double)texture[at].y : 0.0;
            corner[k] = rmap_scale(rmap_vec3((double)v->x, (double)v->y, (double)v->z), g->scale);
        }
        RMAP_TRY(rmap_mesh_builder_add(g->builder, corner, texture ? uv[0] : NULL));
    }
out:
    return st;
}

/* The part's name in the file, which may have none. */
static enum rmap_status close_face(struct gatherer *g, const struct aiNode *node,
                                   const struct aiMesh *mesh)
{
    struct aiString material = {0};
    if (mesh->mMaterialIndex < g->scene->mNumMaterials)
        (void)g->by->aiGetMaterialString(g->scene->mMaterials[mesh->mMaterialIndex], AI_MATKEY_NAME,
                                         &material);
    if (strcmp(material.data, AI_DEFAULT_MATERIAL_NAME) == 0)
        material = (struct aiString){0};
    const char *name = mesh->mName.length ? mesh->mName.data : node->mName.data;
    g->builder->part = rmap_obj_part(g->names, node->mName.data); /* meshes may be materials' */
    if (g->builder->part < 0)
        g->builder->part = rmap_obj_part(g->names, name);
    return rmap_mesh_builder_close_part(g->builder, name, material.data);
}

/* Neither STL nor OBJ places its parts. */
static enum rmap_status gather(struct gatherer *g, const struct aiNode *node, int depth)
{
    enum rmap_status st = RMAP_OK;
    if (depth > NODE_DEPTH_MAX)
        return rmap_error_set(g->builder->err, RMAP_INPUT, "its parts are nested too deeply");
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        if (node->mMeshes[i] >= g->scene->mNumMeshes)
            continue;
        const struct aiMesh *mesh = g->scene->mMeshes[node->mMeshes[i]];
        RMAP_TRY(add_triangles(g, mesh));
        RMAP_TRY(close_face(g, node, mesh));
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        RMAP_TRY(gather(g, node->mChildren[i], depth + 1));
out:
    return st;
}

/* ---- the one file that assimp sees ---- */

struct source {
    struct aiFileIO io; /* first: what assimp hands back */
    struct aiFile file;
    const char *path;
    const uint8_t *bytes;
    size_t nbytes, at;
    bool open;
};

static struct source *source_of(struct aiFile *file)
{
    return (struct source *)(void *)file->UserData;
}

static size_t read_items(struct aiFile *file, char *to, size_t size, size_t n)
{
    struct source *self = source_of(file);
    const size_t left = self->nbytes - self->at, most = size ? left / size : 0;
    n = n < most ? n : most;
    memcpy(to, self->bytes + self->at, n * size);
    self->at += n * size;
    return n;
}

static size_t write_items(struct aiFile *file, const char *from, size_t size, size_t n)
{
    (void)file, (void)from, (void)size, (void)n;
    return 0;
}

static size_t tell(struct aiFile *file)
{
    return source_of(file)->at;
}

static size_t size_of(struct aiFile *file)
{
    return source_of(file)->nbytes;
}

static enum aiReturn seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    struct source *self = source_of(file);
    const size_t from = origin == aiOrigin_SET   ? 0
                        : origin == aiOrigin_CUR ? self->at
                                                 : self->nbytes;
    if (offset > self->nbytes - from)
        return aiReturn_FAILURE;
    self->at = from + offset;
    return aiReturn_SUCCESS;
}

static void flush(struct aiFile *file)
{
    (void)file;
}

/* Materials, which an OBJ file names, are not wanted. */
static struct aiFile *open_source(struct aiFileIO *io, const char *path, const char *mode)
{
    struct source *self = (struct source *)io;
    if (self->open || mode[0] != 'r' || strcmp(path, self->path) != 0)
        return NULL;
    self->open = true;
    self->at = 0;
    return &self->file;
}

static void close_source(struct aiFileIO *io, struct aiFile *file)
{
    (void)file;
    ((struct source *)io)->open = false;
}

/* What assimp says, or the line that it does not name. */
static enum rmap_status refuse(const struct assimp *by, const char *path, const uint8_t *bytes,
                               size_t nbytes, struct rmap_error *err)
{
    char why[200];
    const char *text = by->aiGetErrorString();
    if (text && strstr(text, "bad_alloc"))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for mesh %s", path);
    if (ends_in(path, ".obj") ? rmap_obj_fault(bytes, nbytes, why, sizeof why)
                              : rmap_stl_fault(bytes, nbytes, why, sizeof why))
        return rmap_error_set(err, RMAP_INPUT, "%s", why);
    return rmap_error_set(err, RMAP_INPUT, "%.300s (is the file whole?)",
                          text && text[0] ? text : "it is no mesh that can be understood");
}

/* names: of the parts, whose text it is then; NULL: of none. */
static enum rmap_status read_through_assimp(const char *path, const uint8_t *bytes, size_t nbytes,
                                            double scale, const struct rmap_obj_names *names,
                                            struct rmap_mesh_builder *builder)
{
    struct source source = {.io = {open_source, close_source, NULL},
                            .path = path,
                            .bytes = names ? names->text : bytes,
                            .nbytes = names ? names->nbytes : nbytes};
    source.file =
        (struct aiFile){read_items, write_items, tell, size_of, seek, flush, (char *)&source};
    struct assimp by;
    enum rmap_status st =
        rmap_late_library(RMAP_LIBASSIMP, "STL and OBJ are read by assimp", assimp_name,
                          RMAP_COUNT(assimp_name), &by, builder->err);
    if (st != RMAP_OK)
        return st;
    const struct aiScene *scene = by.aiImportFileEx(path, aiProcess_Triangulate, &source.io);
    if (!scene)
        return refuse(&by, path, bytes, nbytes, builder->err);
    struct gatherer g = {&by, scene, scale, builder, names};
    st = scene->mRootNode ? gather(&g, scene->mRootNode, 0) : RMAP_OK;
    by.aiReleaseImport(scene);
    return st;
}

/* ---- files ---- */

/* assimp cuts polygons into triangles in a time that grows with the square of their corners. A line
 * that ends in a backslash goes on in the next one. */
static enum rmap_status check_polygons(const uint8_t *text, size_t nbytes, struct rmap_error *err)
{
    size_t n_word = 0, line = 1;
    bool face = false, in_word = false;
    for (size_t i = 0; i < nbytes; i++) {
        const bool goes_on = text[i] == '\\' && memchr("\n\r\f", text[i + 1], 4);
        const bool blank = goes_on || text[i] <= ' ';
        if (!blank && !in_word && n_word++ == 0)
            face = text[i] == 'f';
        in_word = !blank;
        if (face && n_word > CORNERS_MAX + 1)
            return rmap_error_set(err, RMAP_INPUT, "line %zu: a face has more than %d corners",
                                  line, CORNERS_MAX);
        while (goes_on && i < nbytes && text[i] != '\n')
            i++;
        if (!goes_on && (text[i] == '\n' || text[i] == '\r'))
            n_word = 0;
        line += text[i] == '\n';
    }
    return RMAP_OK;
}

/* names: of the parts of an OBJ file; NULL: they are not wanted. */
static enum rmap_status read_bytes(const char *path, const uint8_t *bytes, size_t nbytes,
                                   double scale, struct rmap_obj_names *names,
                                   struct rmap_mesh_builder *builder)
{
    enum rmap_status st = RMAP_OK;
    if (nbytes == 0)
        return rmap_error_set(builder->err, RMAP_INPUT, "the file is empty");
    if (ends_in(path, ".gltf") || ends_in(path, ".glb"))
        return rmap_gltf_read(path, bytes, nbytes, scale, builder);
    if (ends_in(path, ".ply"))
        return rmap_ply_read(bytes, nbytes, scale, builder);
    if (ends_in(path, ".obj"))
        st = check_polygons(bytes, nbytes, builder->err);
    if (st == RMAP_OK && names && ends_in(path, ".obj")) {
        st = rmap_obj_names_read(bytes, nbytes, names, builder->err);
        if (st == RMAP_OK && names->text)
            return read_through_assimp(path, bytes, nbytes, scale, names, builder);
    }
    return st == RMAP_OK ? read_through_assimp(path, bytes, nbytes, scale, NULL, builder) : st;
}

static bool is_known(const char *path)
{
    static const char *const known[] = {".stl", ".obj", ".ply", ".gltf", ".glb"};
    bool fits = false;
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        fits |= ends_in(path, known[i]);
    return fits;
}

static enum rmap_status open_file(const char *path, uint8_t **bytes, size_t *nbytes,
                                  struct rmap_error *err)
{
    if (!is_known(path))
        return rmap_error_set(err, RMAP_INPUT,
                              "its name must end in .stl, .obj, .ply, .gltf or .glb");
    return rmap_input_file_read(path, RMAP_MESH_NBYTES_MAX, bytes, nbytes, err);
}

static enum rmap_status build(const char *path, const struct rmap_mesh_reading *how,
                              const uint8_t *bytes, size_t nbytes, struct rmap_mesh **mesh_ret,
                              struct rmap_mesh_left_out *left_out_ret, struct rmap_error *err)
{
    struct rmap_mesh_builder builder = {.err = err,
                                        .wants_tangents = how->keep & RMAP_MESH_TANGENTS,
                                        .wants_uv = how->keep & RMAP_MESH_UV};
    enum rmap_status st = read_bytes(path, bytes, nbytes, how->scale, NULL, &builder);
    if (st == RMAP_OK)
        st = rmap_mesh_builder_finish(&builder, mesh_ret);
    *left_out_ret = builder.left_out;
    rmap_mesh_builder_fini(&builder);
    return st;
}

/* As it was read before, or else anew and kept for later. */
static enum rmap_status read_kept(const char *path, const struct rmap_mesh_reading *how,
                                  const uint8_t *bytes, size_t nbytes, struct rmap_mesh **mesh_ret,
                                  struct rmap_mesh_left_out *left_out_ret, struct rmap_error *err)
{
    struct rmap_kept kept = {0};
    struct rmap_mesh *mesh = NULL;
    struct rmap_error note = {0};
    enum rmap_status st = RMAP_OK,
                     found = rmap_mesh_kept_init(&kept, path, how, bytes, nbytes, &note);
    if (found == RMAP_OK)
        found = rmap_mesh_kept_read(&kept, &mesh, left_out_ret, &note);
    if (mesh)
        goto out;
    RMAP_TRY(build(path, how, bytes, nbytes, &mesh, left_out_ret, err));
    if (found != RMAP_SYSTEM && !left_out_ret->elsewhere)
        found = rmap_mesh_kept_write(&kept, mesh, left_out_ret, &note);
out:
    rmap_kept_fini(&kept);
    *mesh_ret = mesh;
    if (how->note)
        *how->note = note;
    return st;
}

enum rmap_status rmap_mesh_read(const char *path, const struct rmap_mesh_reading *how,
                                struct rmap_mesh **mesh_ret,
                                struct rmap_mesh_left_out *left_out_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    const char *trouble = is_known(path) ? rmap_input_file_trouble(path) : NULL;
    if (trouble)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "cannot open mesh %s: %s", path, trouble));
    RMAP_TRY(open_file(path, &bytes, &nbytes, err));
    st = (how->cache && nbytes >= RMAP_KEPT_LEAST ? read_kept : build)(path, how, bytes, nbytes,
                                                                       mesh_ret, left_out_ret, err);
    if (st == RMAP_OK && (how->keep & RMAP_MESH_FLAT)) {
        rmap_free((*mesh_ret)->surface);
        (*mesh_ret)->surface = NULL;
    }
out:
    rmap_free(bytes);
    if (st == RMAP_INPUT && !trouble)
        rmap_error_context(err, "cannot read mesh %s", path);
    return st;
}

void rmap_mesh_file_fini(struct rmap_mesh_file *file)
{
    for (size_t f = 0; file->material && f < file->mesh->n_face; f++)
        rmap_free(file->material[f]);
    rmap_free(file->material);
    rmap_free(file->part);
    rmap_mesh_destroy(file->mesh);
    rmap_obj_names_fini(&file->names);
}

enum rmap_status rmap_mesh_read_file(const char *path, double scale, struct rmap_mesh_file *file,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh_builder builder = {.err = err, .wants_materials = true};
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    const char *trouble = is_known(path) ? rmap_input_file_trouble(path) : NULL;
    if (trouble)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "cannot open mesh %s: %s", path, trouble));
    RMAP_TRY(open_file(path, &bytes, &nbytes, err));
    RMAP_TRY(read_bytes(path, bytes, nbytes, scale, &file->names, &builder));
    RMAP_TRY(rmap_mesh_builder_fill_parts(&builder, builder.n_face));
    RMAP_TRY(rmap_mesh_builder_finish(&builder, &file->mesh));
    file->left_out = builder.left_out;
    file->material = builder.face_material;
    file->part = builder.face_part;
    builder.face_material = NULL;
    builder.face_part = NULL;
    builder.n_face_material = 0;
out:
    rmap_free(bytes);
    rmap_mesh_builder_fini(&builder);
    if (st == RMAP_INPUT && !trouble)
        rmap_error_context(err, "cannot read mesh %s", path);
    return st;
}

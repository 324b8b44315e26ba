/* SPDX-License-Identifier: MIT
 *
 * Assemblies of mesh files: glTF with its tree, OBJ by its groups, STL and PLY as one part.
 */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "geometry/mesh_edges.h"
#include "geometry/mesh_part.h"
#include "io/assembly/assembly.h"
#include "io/file/input_file.h"
#include "io/file/publish.h"
#include "io/lensfile/lens_text.h"
#include "io/mesh/gltf_numbers.h"
#include "io/mesh/gltf_tree.h"
#include "io/mesh/mesh_read.h"

enum { MTL_NBYTES_MAX = 16 << 20, NAME_NBYTES = 64 };

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for an assembly");
}

/* name: of the mesh in the file; "": it is the file. */
static void tell_left_out(struct rmap_assembly *a, const char *name,
                          const struct rmap_mesh_left_out *left_out)
{
    if (left_out->undefined > 0)
        rmap_diagnostics_add(&a->findings, RMAP_SEVERITY_WARNING, 0, 0,
                             "%s%.60s%s%zu triangle%s, number %zu first, with corners that are no "
                             "numbers (NaN or infinite): left out, which leaves a hole",
                             name[0] ? "mesh '" : "", name, name[0] ? "': " : "",
                             left_out->undefined, left_out->undefined == 1 ? "" : "s",
                             left_out->first);
}

/* ---- shapes ---- */

static void set_hash(struct rmap_assembly_shape *shape)
{
    const struct rmap_mesh *mesh = shape->mesh;
    const XXH128_hash_t part[3] = {
        XXH3_128bits(mesh->vertex, mesh->n_vertex * sizeof *mesh->vertex),
        XXH3_128bits(mesh->triangle, mesh->n_triangle * sizeof *mesh->triangle),
        XXH3_128bits(mesh->face, mesh->n_triangle * sizeof *mesh->face)};
    const XXH128_hash_t hash = XXH3_128bits(part, sizeof part);
    (void)snprintf(shape->hash, sizeof shape->hash, "%016" PRIx64 "%016" PRIx64, hash.high64,
                   hash.low64);
}

/* Takes the mesh over. */
static enum rmap_status add_shape(struct rmap_assembly *a, const char *name, struct rmap_mesh *mesh,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char id[24];
    size_t n_open = 0;
    struct rmap_mesh_edge edge;
    struct rmap_vec3 lower, upper;
    (void)snprintf(id, sizeof id, "s%zu", a->n_shape + 1);
    struct rmap_assembly_shape *shape = rmap_assembly_add_shape(a, id, name, err);
    if (!shape) {
        rmap_mesh_destroy(mesh);
        return RMAP_SYSTEM;
    }
    shape->mesh = mesh;
    set_hash(shape);
    RMAP_TRY(rmap_mesh_open_edges(mesh, &n_open, &edge, err));
    shape->closed = n_open == 0;
    rmap_mesh_bounds(mesh, &lower, &upper);
    memcpy(shape->lower, (double[]){lower.x, lower.y, lower.z}, sizeof shape->lower);
    memcpy(shape->upper, (double[]){upper.x, upper.y, upper.z}, sizeof shape->upper);
    shape->face = rmap_alloc(mesh->n_face, sizeof *shape->face);
    if (!shape->face)
        return no_memory(err);
    shape->n_face = mesh->n_face;
    for (size_t i = 0; i < mesh->n_face && st == RMAP_OK; i++) {
        shape->face[i].name = rmap_strdup(mesh->face_name[i] ? mesh->face_name[i] : "");
        st = shape->face[i].name ? RMAP_OK : no_memory(err);
    }
out:
    return st;
}

/* The part's material is that of its first face; faces of another one keep theirs. */
static enum rmap_status set_materials(struct rmap_assembly *a, struct rmap_assembly_shape *shape,
                                      const char *const *material, struct rmap_error *err)
{
    for (size_t i = 0; i < shape->n_face; i++) {
        const struct rmap_assembly_material *its = rmap_assembly_material(a, material[i]);
        if (!material[i] || !material[i][0])
            continue;
        shape->face[i].material = rmap_strdup(material[i]);
        if (!shape->face[i].material)
            return no_memory(err);
        if (its)
            shape->face[i].colour = its->colour;
    }
    return RMAP_OK;
}

static enum rmap_status give_shape(struct rmap_assembly_part *part, const struct rmap_assembly *a,
                                   int32_t shape, struct rmap_error *err)
{
    const struct rmap_assembly_face *first = a->shape[shape].face;
    part->shape = shape;
    part->material = rmap_strdup(first && first->material ? first->material : "");
    if (first)
        part->colour = first->colour;
    return part->material ? RMAP_OK : no_memory(err);
}

/* ---- glTF ---- */

/* IEC 61966-2-1 */
static double encoded(double linear)
{
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1 / 2.4) - 0.055;
}

static enum rmap_status take_gltf_materials(struct rmap_assembly *a,
                                            const struct rmap_gltf_tree *tree,
                                            struct rmap_error *err)
{
    a->material = rmap_alloc(tree->n_material, sizeof *a->material);
    if (!a->material)
        return no_memory(err);
    for (size_t i = 0; i < tree->n_material; i++) {
        const struct rmap_gltf_material *from = &tree->material[i];
        struct rmap_assembly_material *to = &a->material[i];
        char number[NAME_NBYTES];
        (void)snprintf(number, sizeof number, "material %zu", i);
        const bool taken = rmap_assembly_material(a, from->name) != NULL;
        *to = (struct rmap_assembly_material){
            .name = rmap_strdup(from->name[0] && !taken ? from->name : number),
            .colour = {true,
                       {encoded(from->colour[0]), encoded(from->colour[1]),
                        encoded(from->colour[2])}},
            .metalness = from->metalness,
            .roughness = from->roughness,
            .transmission = from->transmission,
            .index = from->index};
        if (!to->name)
            return no_memory(err);
        a->n_material = i + 1;
    }
    return RMAP_OK;
}

static enum rmap_status take_gltf_mesh(struct rmap_assembly *a, struct rmap_gltf_mesh *from,
                                       struct rmap_error *err)
{
    const size_t n = from->mesh->n_face;
    const char **material = rmap_alloc(n, sizeof *material);
    if (!material)
        return no_memory(err);
    enum rmap_status st = add_shape(a, from->name, from->mesh, err);
    from->mesh = NULL;
    for (size_t i = 0; i < n; i++)
        material[i] = from->material[i] >= 0 ? a->material[from->material[i]].name : NULL;
    if (st == RMAP_OK)
        st = set_materials(a, &a->shape[a->n_shape - 1], material, err);
    rmap_free(material);
    return st;
}

/* A part for the node, and one more where it has a mesh and nodes below it. */
static enum rmap_status take_node(struct rmap_assembly *a, const struct rmap_gltf_tree *tree,
                                  size_t i, const int32_t *shape_of, bool group, int32_t *part_of,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_gltf_node *node = &tree->node[i];
    const int32_t parent = node->parent < 0 ? -1 : part_of[node->parent];
    const char *above = parent < 0 ? "" : a->part[parent].id;
    const char *of_mesh = node->mesh >= 0 ? tree->mesh[node->mesh].name : "";
    const char *name = node->name[0] ? node->name : of_mesh[0] ? of_mesh : "node";
    struct rmap_assembly_part *part = NULL;
    /* Paths of 250 nested names of any length would be long without end. */
    const size_t n_above = strlen(above), cut = n_above > 1000 ? n_above - 1000 : 0;
    char *id = rmap_path_format("%s%s%.300s", above + cut, parent < 0 ? "" : "/", name);
    if (!id)
        RMAP_TRY(no_memory(err));
    part_of[i] = (int32_t)a->n_part;
    part = rmap_assembly_add_part(a, id, name, parent, err);
    if (!part)
        RMAP_TRY(err->status);
    part->place = node->place;
    if (!group) {
        RMAP_TRY(give_shape(part, a, shape_of[node->mesh], err));
    } else if (node->mesh >= 0 && shape_of[node->mesh] >= 0) {
        rmap_free(id);
        id = rmap_path_format("%s/", a->part[part_of[i]].id);
        part = id ? rmap_assembly_add_part(a, id, name, part_of[i], err) : NULL;
        if (!part)
            RMAP_TRY(id ? err->status : no_memory(err));
        st = give_shape(part, a, shape_of[node->mesh], err);
    }
out:
    rmap_free(id);
    return st;
}

static enum rmap_status take_tree(struct rmap_assembly *a, struct rmap_gltf_tree *tree,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int32_t *shape_of = rmap_alloc(tree->n_mesh, sizeof *shape_of),
            *part_of = rmap_alloc(tree->n_node, sizeof *part_of);
    bool *wanted = rmap_alloc(tree->n_node, sizeof *wanted), /* it, or one below, has a shape */
        *group = rmap_alloc(tree->n_node, sizeof *group);
    if (!shape_of || !part_of || !wanted || !group)
        RMAP_TRY(no_memory(err));
    RMAP_TRY(take_gltf_materials(a, tree, err));
    for (size_t i = 0; i < tree->n_mesh; i++) {
        shape_of[i] = tree->mesh[i].mesh ? (int32_t)a->n_shape : -1;
        tell_left_out(a, tree->mesh[i].name ? tree->mesh[i].name : "", &tree->mesh[i].left_out);
        if (tree->mesh[i].mesh)
            RMAP_TRY(take_gltf_mesh(a, &tree->mesh[i], err));
    }
    for (size_t i = tree->n_node; i-- > 0;) {
        const struct rmap_gltf_node *node = &tree->node[i];
        wanted[i] |= node->mesh >= 0 && shape_of[node->mesh] >= 0;
        if (node->parent >= 0 && wanted[i])
            wanted[node->parent] = group[node->parent] = true;
    }
    for (size_t i = 0; i < tree->n_node; i++)
        if (wanted[i])
            RMAP_TRY(take_node(a, tree, i, shape_of, group[i], part_of, err));
    if (a->n_part == 0)
        st = rmap_error_set(err, RMAP_INPUT, "it holds no triangles");
out:
    rmap_free(shape_of);
    rmap_free(part_of);
    rmap_free(wanted);
    rmap_free(group);
    return st;
}

static enum rmap_status check_depth(const struct rmap_assembly *a, struct rmap_error *err)
{
    int *depth = rmap_alloc(a->n_part, sizeof *depth), most = 0;
    if (!depth)
        return no_memory(err);
    for (size_t i = 0; i < a->n_part; i++) {
        depth[i] = a->part[i].parent < 0 ? 1 : depth[a->part[i].parent] + 1;
        most = depth[i] > most ? depth[i] : most;
    }
    rmap_free(depth);
    return most <= RMAP_ASSEMBLY_DEPTH_MAX
               ? RMAP_OK
               : rmap_error_set(err, RMAP_INPUT, "its parts are nested more than %d deep",
                                RMAP_ASSEMBLY_DEPTH_MAX);
}

static enum rmap_status read_gltf(const char *path, double scale, struct rmap_assembly *a,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_gltf_tree tree = {0};
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    RMAP_TRY(rmap_input_file_read(path, RMAP_MESH_NBYTES_MAX, &bytes, &nbytes, err));
    RMAP_TRY(rmap_gltf_read_tree(path, bytes, nbytes, scale, &tree, err));
    RMAP_TRY(take_tree(a, &tree, err));
    st = check_depth(a, err);
out:
    rmap_free(bytes);
    rmap_gltf_tree_fini(&tree);
    return st;
}

/* ---- OBJ, STL, PLY ---- */

/* "mtllib NAME" of an OBJ file; "" : none, or one that is not beside it. */
static void find_mtl(const uint8_t *text, char name[256])
{
    const char *at = (const char *)text;
    name[0] = 0;
    while (at && strncmp(at, "mtllib ", 7) != 0) {
        at = strchr(at, '\n');
        at += at != NULL;
    }
    if (at)
        (void)sscanf(at + 7, " %255[^\r\n]", name);
    for (size_t n = strlen(name); n > 0 && name[n - 1] == ' ';)
        name[--n] = 0;
    if (strpbrk(name, "/\\") || name[0] == '.')
        name[0] = 0;
}

static enum rmap_status read_materials(const char *path, struct rmap_assembly *a,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *bytes = NULL;
    char name[256], *text = NULL, *beside = NULL;
    size_t nbytes = 0;
    const char *slash = strrchr(path, '/');
    struct rmap_error why = {0};
    RMAP_TRY(rmap_input_file_read(path, RMAP_MESH_NBYTES_MAX, &bytes, &nbytes, err));
    find_mtl(bytes, name);
    rmap_free(bytes);
    bytes = NULL;
    if (!name[0])
        return RMAP_OK;
    beside = rmap_path_format("%.*s%s", slash ? (int)(slash - path) + 1 : 0, path, name);
    if (!beside)
        RMAP_TRY(no_memory(err));
    const char *trouble = rmap_input_file_trouble(beside);
    if (trouble)
        (void)rmap_error_set(&why, RMAP_INPUT, "%s", trouble);
    else if (rmap_input_file_read(beside, MTL_NBYTES_MAX, &bytes, &nbytes, &why) == RMAP_OK &&
             rmap_lens_decode((const char *)bytes, nbytes, &text, &why) == RMAP_OK)
        st = rmap_assembly_read_mtl(text, a, &why);
    if (why.text[0]) /* the model is there without its colours */
        rmap_diagnostics_add(&a->findings, RMAP_SEVERITY_WARNING, 0, 0,
                             "materials of %.200s are not read: %.300s", beside, why.text);
    st = st == RMAP_INPUT ? RMAP_OK : st;
out:
    rmap_free(bytes);
    rmap_free(text);
    rmap_free(beside);
    return st;
}

/* The faces as a part, which are marked. */
static enum rmap_status add_marked(struct rmap_assembly *a, const struct rmap_mesh_file *file,
                                   const uint8_t *wanted, const char *name, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_mesh *mesh = file->mesh;
    struct rmap_mesh *own = NULL;
    const char **its = rmap_alloc(mesh->n_face, sizeof *its);
    size_t n = 0;
    if (!its)
        return no_memory(err);
    for (size_t f = 0; f < mesh->n_face; f++)
        if (wanted[f])
            its[n++] = file->material[f];
    RMAP_TRY(rmap_mesh_part(mesh, wanted, &own, err));
    RMAP_TRY(add_shape(a, name, own, err));
    RMAP_TRY(set_materials(a, &a->shape[a->n_shape - 1], its, err));
    struct rmap_assembly_part *part = rmap_assembly_add_part(a, name, name, -1, err);
    if (!part)
        RMAP_TRY(err->status);
    st = give_shape(part, a, (int32_t)a->n_shape - 1, err);
out:
    rmap_free(its);
    return st;
}

/* A part for each that the file names, in the order of their first faces; the rest is one of the
 * file's name. */
static enum rmap_status split(struct rmap_assembly *a, const struct rmap_mesh_file *file,
                              const char *stem, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = file->mesh->n_face;
    uint8_t *wanted = rmap_alloc(n, 1);
    bool *done = rmap_alloc(file->names.n + 1, sizeof *done);
    if (!wanted || !done)
        RMAP_TRY(no_memory(err));
    for (size_t first = 0; first < n && st == RMAP_OK; first++) {
        const int32_t part = file->part[first];
        if (done[part + 1])
            continue;
        done[part + 1] = true;
        for (size_t f = 0; f < n; f++)
            wanted[f] = file->part[f] == part;
        st = add_marked(a, file, wanted, part < 0 ? stem : file->names.name[part], err);
    }
out:
    rmap_free(wanted);
    rmap_free(done);
    return st;
}

static enum rmap_status read_plain(const char *path, double scale, bool is_obj,
                                   struct rmap_assembly *a, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh_file file = {0};
    char stem[256];
    const char *slash = strrchr(path, '/');
    (void)snprintf(stem, sizeof stem, "%s", slash ? slash + 1 : path);
    *strrchr(stem, '.') = 0;
    RMAP_TRY(rmap_mesh_read_file(path, scale, &file, err));
    tell_left_out(a, "", &file.left_out);
    if (is_obj)
        RMAP_TRY(read_materials(path, a, err));
    st = split(a, &file, stem, err);
out:
    rmap_mesh_file_fini(&file);
    return st;
}

static bool ends_in(const char *path, const char *ending)
{
    const size_t n = strlen(path), m = strlen(ending);
    return n > m && strcasecmp(path + n - m, ending) == 0;
}

enum rmap_status rmap_assembly_read_mesh(const char *path, double scale, const char *unit,
                                         struct rmap_assembly *a, struct rmap_error *err)
{
    const double mm_per_m = 1000;
    const char *slash = strrchr(path, '/');
    const bool is_gltf = ends_in(path, ".gltf") || ends_in(path, ".glb"),
               is_obj = ends_in(path, ".obj");
    const char *trouble = rmap_input_file_trouble(path);
    enum rmap_status st = trouble   ? rmap_error_set(err, RMAP_INPUT, "%s", trouble)
                          : is_gltf ? read_gltf(path, mm_per_m * scale, a, err)
                                    : read_plain(path, scale, is_obj, a, err);
    if (is_gltf)
        unit = "m";
    if (st != RMAP_OK) {
        if (is_gltf || !strstr(err->text, path)) /* rmap_mesh_read_file names it */
            rmap_error_context(err, "%s", path);
        return st;
    }
    a->source = rmap_strdup(slash ? slash + 1 : path);
    a->schema = rmap_strdup(is_gltf                 ? "glTF 2.0"
                            : is_obj                ? "Wavefront OBJ"
                            : ends_in(path, ".stl") ? "STL"
                                                    : "PLY");
    a->writer = rmap_strdup("");
    a->file_unit = rmap_strdup(unit);
    if (!a->source || !a->schema || !a->writer || !a->file_unit)
        return no_memory(err);
    st = rmap_assembly_share(a, err);
    return st == RMAP_OK ? rmap_assembly_settle_ids(a, err) : st;
}

/* SPDX-License-Identifier: MIT
 *
 * A writer of glTF 2.0 scenes in one file (Khronos Group, "glTF 2.0 Specification", 2021):
 * materials, triangle meshes, lines with a colour per point, and named nodes that place them.
 */
#include "io/export/glb.h"

#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <string.h>

#include "base/alloc.h"
#include "io/export/json_memory.h"
#include "io/file/base64.h"

/* The specification's numbers (section 5). */
enum { FLOAT = 5126, UNSIGNED_INT = 5125, UNSIGNED_BYTE = 5121, UNSIGNED_SHORT = 5123 };
enum { VERTICES = 34962, INDICES = 34963, MODE_LINES = 1 };

#define UNLIT "KHR_materials_unlit"

struct rmap_glb {
    json_t *material, *mesh, *node, *accessor, *view, *placed; /* arrays */
    uint8_t *bytes;
    size_t nbytes, cap;
    double scale;
    int z_upright, unlit;
};

static enum rmap_status no_memory(struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a glTF scene");
}

enum rmap_status rmap_glb_create(double scale, int z_upright, struct rmap_glb **glb_ret,
                                 struct rmap_error *err)
{
    struct rmap_glb *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return no_memory(err);
    *self = (struct rmap_glb){.material = json_array(),
                              .mesh = json_array(),
                              .node = json_array(),
                              .accessor = json_array(),
                              .view = json_array(),
                              .placed = json_array(),
                              .scale = scale,
                              .z_upright = z_upright};
    if (self->material && self->mesh && self->node && self->accessor && self->view &&
        self->placed) {
        *glb_ret = self;
        return RMAP_OK;
    }
    rmap_glb_destroy(self);
    return no_memory(err);
}

void rmap_glb_destroy(struct rmap_glb *self)
{
    if (!self)
        return;
    json_t *const part[] = {self->material, self->mesh, self->node,
                            self->accessor, self->view, self->placed};
    for (size_t i = 0; i < sizeof part / sizeof *part; i++)
        json_decref(part[i]);
    rmap_free(self->bytes);
    rmap_free(self);
}

/* Takes the entry over, NULL as well. */
static enum rmap_status append(json_t *array, json_t *entry, size_t *index_ret,
                               struct rmap_error *err)
{
    *index_ret = json_array_size(array);
    return json_array_append_new(array, entry) == 0 ? RMAP_OK : no_memory(err);
}

enum rmap_status rmap_glb_add_material(struct rmap_glb *self, const struct rmap_glb_material *given,
                                       size_t *index_ret, struct rmap_error *err)
{
    const double *c = given->colour;
    json_t *entry = json_pack("{s:s, s:{s:[f,f,f,f], s:f, s:f}, s:b}", "name", given->name,
                              "pbrMetallicRoughness", "baseColorFactor", c[0], c[1], c[2], c[3],
                              "metallicFactor", given->metallic, "roughnessFactor",
                              given->roughness, "doubleSided", !given->one_sided);
    if (entry && c[3] < 1.0 && json_object_set_new(entry, "alphaMode", json_string("BLEND")) != 0) {
        json_decref(entry);
        entry = NULL;
    }
    self->unlit |= given->unlit;
    if (entry && given->unlit &&
        json_object_set_new(entry, "extensions", json_pack("{s:{}}", UNLIT)) != 0) {
        json_decref(entry);
        entry = NULL;
    }
    return append(self->material, entry, index_ret, err);
}

/* Bytes behind what is there, as a view of the buffer. All rows are multiples of four bytes. */
static enum rmap_status add_view(struct rmap_glb *self, const void *bytes, size_t nbytes,
                                 int target, size_t *index_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(self->bytes, self->cap, self->nbytes + nbytes + 4, err);
    if (st != RMAP_OK)
        return st;
    if (nbytes > 0)
        memcpy(self->bytes + self->nbytes, bytes, nbytes);
    json_t *entry =
        json_pack("{s:i, s:I, s:I, s:i}", "buffer", 0, "byteOffset", (json_int_t)self->nbytes,
                  "byteLength", (json_int_t)nbytes, "target", target);
    self->nbytes += nbytes;
    return append(self->view, entry, index_ret, err);
}

struct accessor {
    int component;
    const char *type;
    int target, normalized;
    size_t row_nbytes;
};

static enum rmap_status add_accessor(struct rmap_glb *self, const struct accessor *kind,
                                     const void *rows, size_t n, json_t *bounds, size_t *index_ret,
                                     struct rmap_error *err)
{
    size_t view = 0;
    json_t *entry = NULL;
    enum rmap_status st = add_view(self, rows, n * kind->row_nbytes, kind->target, &view, err);
    if (st == RMAP_OK)
        entry = json_pack("{s:I, s:i, s:I, s:s}", "bufferView", (json_int_t)view, "componentType",
                          kind->component, "count", (json_int_t)n, "type", kind->type);
    if (st == RMAP_OK &&
        (!entry || (kind->normalized && json_object_set_new(entry, "normalized", json_true())) ||
         (bounds && json_object_update(entry, bounds))))
        st = no_memory(err);
    json_decref(bounds);
    if (st != RMAP_OK) {
        json_decref(entry);
        return st;
    }
    return append(self->accessor, entry, index_ret, err);
}

static enum rmap_status add_positions(struct rmap_glb *self, const float (*point)[3], size_t n,
                                      size_t *index_ret, struct rmap_error *err)
{
    static const struct accessor kind = {FLOAT, "VEC3", VERTICES, 0, 12};
    float low[3] = {0}, high[3] = {0};
    for (size_t i = 0; i < n; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = i == 0 ? point[i][k] : fminf(low[k], point[i][k]);
            high[k] = i == 0 ? point[i][k] : fmaxf(high[k], point[i][k]);
        }
    json_t *bounds =
        json_pack("{s:[f,f,f], s:[f,f,f]}", "min", (double)low[0], (double)low[1], (double)low[2],
                  "max", (double)high[0], (double)high[1], (double)high[2]);
    return bounds ? add_accessor(self, &kind, point, n, bounds, index_ret, err) : no_memory(err);
}

enum rmap_status rmap_glb_add_shape(struct rmap_glb *self, const float (*point)[3], size_t n_point,
                                    const uint32_t (*corner)[3], size_t n_triangle,
                                    struct rmap_glb_shape *shape_ret, struct rmap_error *err)
{
    static const struct accessor kind = {UNSIGNED_INT, "SCALAR", INDICES, 0, 4};
    enum rmap_status st = add_positions(self, point, n_point, &shape_ret->position, err);
    return st != RMAP_OK
               ? st
               : add_accessor(self, &kind, corner, 3 * n_triangle, NULL, &shape_ret->corner, err);
}

enum rmap_status rmap_glb_add_mesh(struct rmap_glb *self, const char *name,
                                   const struct rmap_glb_shape *shape, size_t material,
                                   size_t *index_ret, struct rmap_error *err)
{
    json_t *entry = json_pack("{s:s, s:[{s:{s:I}, s:I, s:I}]}", "name", name, "primitives",
                              "attributes", "POSITION", (json_int_t)shape->position, "indices",
                              (json_int_t)shape->corner, "material", (json_int_t)material);
    return append(self->mesh, entry, index_ret, err);
}

enum rmap_status rmap_glb_add_painted(struct rmap_glb *self, const char *name,
                                      const struct rmap_glb_shape *shape,
                                      const struct rmap_glb_paint *paint, size_t material,
                                      size_t *index_ret, struct rmap_error *err)
{
    static const struct accessor tint = {UNSIGNED_SHORT, "VEC4", VERTICES, 1, 8};
    static const struct accessor number = {FLOAT, "SCALAR", VERTICES, 0, 4};
    enum rmap_status st = RMAP_OK;
    size_t colour = 0, value = 0;
    RMAP_TRY(add_accessor(self, &tint, paint->colour, paint->n_point, NULL, &colour, err));
    RMAP_TRY(add_accessor(self, &number, paint->number, paint->n_point, NULL, &value, err));
    st = append(self->mesh,
                json_pack("{s:s, s:[{s:{s:I, s:I, s:I}, s:I, s:I}]}", "name", name, "primitives",
                          "attributes", "POSITION", (json_int_t)shape->position, "COLOR_0",
                          (json_int_t)colour, paint->attribute, (json_int_t)value, "indices",
                          (json_int_t)shape->corner, "material", (json_int_t)material),
                index_ret, err);
out:
    return st;
}

enum rmap_status rmap_glb_add_lines(struct rmap_glb *self, const char *name,
                                    const float (*point)[3], const uint8_t (*colour)[4],
                                    size_t n_line, size_t *index_ret, struct rmap_error *err)
{
    static const struct accessor kind = {UNSIGNED_BYTE, "VEC4", VERTICES, 1, 4};
    enum rmap_status st = RMAP_OK;
    size_t position = 0, tint = 0, material = 0;
    const struct rmap_glb_material plain = {.name = name, .colour = {1, 1, 1, 1}, .roughness = 1};
    RMAP_TRY(add_positions(self, point, 2 * n_line, &position, err));
    RMAP_TRY(add_accessor(self, &kind, colour, 2 * n_line, NULL, &tint, err));
    RMAP_TRY(rmap_glb_add_material(self, &plain, &material, err));
    st = append(self->mesh,
                json_pack("{s:s, s:[{s:{s:I, s:I}, s:i, s:I}]}", "name", name, "primitives",
                          "attributes", "POSITION", (json_int_t)position, "COLOR_0",
                          (json_int_t)tint, "mode", MODE_LINES, "material", (json_int_t)material),
                index_ret, err);
out:
    return st;
}

enum rmap_status rmap_glb_place(struct rmap_glb *self, const char *name, size_t mesh,
                                const double matrix[16], struct rmap_error *err)
{
    size_t index = 0, same = 0;
    json_t *entry = json_pack("{s:s, s:I}", "name", name, "mesh", (json_int_t)mesh);
    json_t *numbers = matrix ? json_array() : NULL;
    int failed = !entry || (matrix && !numbers);
    for (int i = 0; matrix && !failed && i < 16; i++)
        failed = json_array_append_new(numbers, json_real(matrix[i])) != 0;
    if (matrix && !failed)
        failed = json_object_set(entry, "matrix", numbers) != 0;
    json_decref(numbers);
    if (failed) {
        json_decref(entry);
        return no_memory(err);
    }
    enum rmap_status st = append(self->node, entry, &index, err);
    return st != RMAP_OK ? st
                         : append(self->placed, json_integer((json_int_t)index + 1), &same, err);
}

/* Node 0 brings everything to metres and upright; the others follow it. uri: of the buffer; NULL:
 * it is the chunk behind the document. */
static json_t *document(const struct rmap_glb *self, const char *uri)
{
    const double half = self->z_upright ? -sqrt(0.5) : 0.0, whole = self->z_upright ? sqrt(0.5) : 1;
    json_t *root = json_pack("{s:s, s:[f,f,f], s:[f,f,f,f], s:O}", "name", "raymap", "scale",
                             self->scale, self->scale, self->scale, "rotation", half, 0.0, 0.0,
                             whole, "children", self->placed);
    json_t *nodes = json_array();
    if (!root || !nodes || json_array_append_new(nodes, root) != 0 ||
        json_array_extend(nodes, self->node) != 0) {
        json_decref(nodes);
        return NULL;
    }
    if (json_array_size(self->placed) == 0)
        (void)json_object_del(root, "children");
    json_t *all =
        json_pack("{s:{s:s, s:s}, s:i, s:[{s:[i]}], s:o}", "asset", "version", "2.0", "generator",
                  "raymap", "scene", 0, "scenes", "nodes", 0, "nodes", nodes);
    const struct {
        const char *key;
        json_t *value;
    } part[] = {{"materials", self->material},
                {"meshes", self->mesh},
                {"accessors", self->accessor},
                {"bufferViews", self->view}};
    int failed = !all;
    for (size_t i = 0; i < sizeof part / sizeof *part && !failed; i++)
        if (json_array_size(part[i].value) > 0) /* the specification wants no empty arrays */
            failed = json_object_set(all, part[i].key, part[i].value);
    if (!failed && self->unlit)
        failed = json_object_set_new(all, "extensionsUsed", json_pack("[s]", UNLIT));
    json_t *buffer = json_pack("[{s:I}]", "byteLength", (json_int_t)self->nbytes);
    if (!failed && self->nbytes > 0)
        failed = !buffer || json_object_set(all, "buffers", buffer);
    if (!failed && uri)
        failed = json_object_set_new(json_array_get(buffer, 0), "uri", json_string_nocheck(uri));
    json_decref(buffer);
    if (failed) {
        json_decref(all);
        return NULL;
    }
    return all;
}

static void put_u32(uint64_t value, FILE *out)
{
    const uint8_t byte[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16),
                             (uint8_t)(value >> 24)};
    (void)fwrite(byte, 1, sizeof byte, out);
}

#define FORMAT (JSON_COMPACT | JSON_REAL_PRECISION(9))

enum rmap_status rmap_glb_write(const struct rmap_glb *self, FILE *out, struct rmap_error *err)
{
    enum { HEAD = 12, CHUNK_HEAD = 8 };
    json_t *all = document(self, NULL);
    const size_t text_nbytes = all ? json_dumpb(all, NULL, 0, FORMAT) : 0;
    char *text = text_nbytes > 0 ? rmap_alloc(text_nbytes, 1) : NULL;
    const bool whole = text && json_dumpb(all, text, text_nbytes, FORMAT) == text_nbytes;
    json_decref(all);
    if (!whole || rmap_json_memory_failed()) {
        rmap_free(text);
        return no_memory(err);
    }
    const size_t padded = (text_nbytes + 3) / 4 * 4;
    const uint64_t binary = self->nbytes > 0 ? CHUNK_HEAD + self->nbytes : 0;
    const uint64_t total = HEAD + CHUNK_HEAD + padded + binary;
    enum rmap_status st = RMAP_OK;
    if (total > UINT32_MAX) {
        st = rmap_error_set(err, RMAP_USAGE,
                            "a .glb file holds 4 GiB at most; draw fewer rays (--limit)");
        goto out;
    }
    put_u32(0x46546C67, out); /* "glTF" */
    put_u32(2, out);
    put_u32(total, out);
    put_u32(padded, out);
    put_u32(0x4E4F534A, out); /* "JSON" */
    (void)fwrite(text, 1, text_nbytes, out);
    for (size_t i = text_nbytes; i < padded; i++)
        (void)fputc(' ', out);
    if (binary > 0) {
        put_u32(self->nbytes, out);
        put_u32(0x004E4942, out); /* "BIN" */
        (void)fwrite(self->bytes, 1, self->nbytes, out);
    }
out:
    rmap_free(text);
    return st;
}

enum rmap_status rmap_gltf_write(const struct rmap_glb *self, FILE *out, struct rmap_error *err)
{
    static const char head[] = "data:application/octet-stream;base64,";
    char *uri = rmap_alloc(sizeof head + self->nbytes / 3 * 4 + 4, 1);
    if (!uri)
        return no_memory(err);
    memcpy(uri, head, sizeof head);
    for (size_t i = 0; i < self->nbytes; i += 3)
        rmap_base64_four(self->bytes + i, self->nbytes - i, uri + sizeof head - 1 + i / 3 * 4);
    json_t *all = document(self, self->nbytes > 0 ? uri : NULL);
    const int failed = !all || json_dumpf(all, out, FORMAT) != 0;
    json_decref(all);
    rmap_free(uri);
    return rmap_json_memory_failed() || (failed && !ferror(out)) ? no_memory(err) : RMAP_OK;
}

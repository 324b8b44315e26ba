/* SPDX-License-Identifier: MIT
 *
 * assembly.json, as raymap-step and we write it.
 */
#include <inttypes.h>
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/assembly/assembly.h"
#include "io/export/json_memory.h"
#include "io/export/json_number.h"

enum { TEXT_MAX = 4000, FILE_MAX = 200 };

struct reading {
    struct rmap_assembly *assembly;
    struct rmap_error *err;
    size_t n_face;
};

static enum rmap_status refuse(const struct reading *r, const char *format, ...) RMAP_PRINTF(2, 3);
static enum rmap_status refuse(const struct reading *r, const char *format, ...)
{
    char text[400];
    va_list arguments;
    va_start(arguments, format);
    (void)vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    return rmap_error_set(r->err, RMAP_INPUT, "%s", text);
}

/* ---- values ---- */

/* A copy of the text, "" where there is none (or null); cut where it is longer than texts are. */
static enum rmap_status text_of(const struct reading *r, const json_t *object, const char *key,
                                char **text)
{
    const json_t *value = json_object_get(object, key);
    if (value && !json_is_null(value) && !json_is_string(value))
        return refuse(r, "'%s' is no text", key);
    if (json_string_length(value) > TEXT_MAX)
        return refuse(r, "'%s' is longer than %d bytes", key, TEXT_MAX);
    *text = rmap_strdup(json_is_string(value) ? json_string_value(value) : "");
    return *text ? RMAP_OK : rmap_error_set(r->err, RMAP_SYSTEM, "out of memory for a text");
}

static bool numbers_of(const json_t *list, size_t n, double *value)
{
    bool good = json_array_size(list) == n;
    for (size_t i = 0; good && i < n; i++) {
        const json_t *one = json_array_get(list, i);
        value[i] = json_number_value(one);
        good = json_is_number(one) && isfinite(value[i]);
    }
    return good;
}

static double number_of(const json_t *object, const char *key)
{
    const double value = json_number_value(json_object_get(object, key));
    return isfinite(value) ? value : 0;
}

/* "0x..." of up to 16 digits; 0: it is none. */
static uint64_t hexadecimal_of(const json_t *object, const char *key)
{
    const char *text = json_string_value(json_object_get(object, key));
    return text ? strtoull(text, NULL, 16) : 0;
}

static json_t *hexadecimal_json(uint64_t value)
{
    char text[24];
    (void)snprintf(text, sizeof text, "0x%016" PRIx64, value);
    return json_string(text);
}

static enum rmap_status colour_of(const struct reading *r, const json_t *object,
                                  struct rmap_assembly_colour *colour)
{
    const json_t *list = json_object_get(object, "color");
    if (!list || json_is_null(list))
        return RMAP_OK;
    colour->given = numbers_of(list, 3, colour->rgb);
    for (int k = 0; k < 3; k++)
        colour->given &= colour->rgb[k] >= 0 && colour->rgb[k] <= 1;
    return colour->given ? RMAP_OK : refuse(r, "'color' must be three numbers from 0 to 1");
}

/* ---- shapes ---- */

static bool is_file_name(const char *name)
{
    const size_t n = strlen(name);
    bool good = n > 4 && n <= FILE_MAX && strcmp(name + n - 4, ".ply") == 0 && name[0] != '.' &&
                name[0] != '-';
    for (size_t i = 0; i < n; i++)
        good &= (unsigned char)name[i] > ' ' && (unsigned char)name[i] < 127 &&
                !strchr("/\\\"'*?:#{}[],&!|>%@`", name[i]);
    return good;
}

static enum rmap_status read_faces(struct reading *r, const json_t *list,
                                   struct rmap_assembly_shape *shape)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = json_array_size(list);
    if (n > RMAP_ASSEMBLY_FACES_MAX - r->n_face)
        return refuse(r, "it has more than %d faces", RMAP_ASSEMBLY_FACES_MAX);
    r->n_face += n;
    shape->face = rmap_alloc(n, sizeof *shape->face);
    if (!shape->face)
        return rmap_error_set(r->err, RMAP_SYSTEM, "out of memory for %zu faces", n);
    shape->n_face = n;
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        const json_t *from = json_array_get(list, i);
        if (!json_is_object(from))
            return refuse(r, "face %zu of shape '%.60s' is no object", i, shape->id);
        st = text_of(r, from, "name", &shape->face[i].name);
        if (st == RMAP_OK)
            st = text_of(r, from, "material", &shape->face[i].material);
        if (st == RMAP_OK)
            st = colour_of(r, from, &shape->face[i].colour);
        if (!numbers_of(json_object_get(from, "middle"), 3, shape->face[i].middle))
            shape->face[i].middle[0] = (double)NAN; /* of an older import */
    }
    return st;
}

static enum rmap_status read_shape(struct reading *r, const json_t *from)
{
    enum rmap_status st = RMAP_OK;
    const json_t *bounds = json_object_get(from, "bounds");
    struct rmap_assembly_shape *shape = NULL;
    if (!json_is_object(from) || !json_is_string(json_object_get(from, "id")))
        return refuse(r, "a shape has no 'id'");
    shape = rmap_assembly_add_shape(r->assembly, json_string_value(json_object_get(from, "id")),
                                    NULL, r->err);
    if (!shape)
        return RMAP_SYSTEM;
    rmap_free(shape->name);
    shape->name = NULL;
    RMAP_TRY(text_of(r, from, "name", &shape->name));
    RMAP_TRY(text_of(r, from, "file", &shape->file));
    RMAP_TRY(text_of(r, from, "file", &shape->made));
    if (!is_file_name(shape->file))
        return refuse(r, "'%.60s' is no name of a mesh file beside it: NAME.ply", shape->file);
    const char *hash = json_string_value(json_object_get(from, "hash"));
    if (!hash || strlen(hash) != 32 || strspn(hash, "0123456789abcdef") != 32)
        return refuse(r, "shape '%.60s' has no 'hash' of 32 hexadecimal digits", shape->id);
    memcpy(shape->hash, hash, 33);
    const char *form = json_string_value(json_object_get(from, "form"));
    if (form && strlen(form) == 32)
        memcpy(shape->form, form, 33);
    shape->digest = hexadecimal_of(from, "digest");
    shape->closed = json_is_true(json_object_get(from, "closed"));
    shape->chord = number_of(from, "chord");
    if (json_array_size(bounds) != 2 || !numbers_of(json_array_get(bounds, 0), 3, shape->lower) ||
        !numbers_of(json_array_get(bounds, 1), 3, shape->upper))
        return refuse(r, "shape '%.60s' has no 'bounds' [[x, y, z], [x, y, z]]", shape->id);
    st = read_faces(r, json_object_get(from, "faces"), shape);
out:
    return st;
}

/* ---- parts ---- */

struct shape_ids {
    json_t *of; /* id: number */
};

static enum rmap_status read_parts(struct reading *r, const struct shape_ids *ids,
                                   const json_t *list, int32_t parent, int depth);

static enum rmap_status read_part(struct reading *r, const struct shape_ids *ids,
                                  const json_t *from, int32_t parent, int depth)
{
    enum rmap_status st = RMAP_OK;
    const json_t *parts = json_object_get(from, "parts"), *shape = json_object_get(from, "shape");
    const size_t index = r->assembly->n_part;
    char *id = NULL, *name = NULL;
    double m[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    RMAP_TRY(text_of(r, from, "id", &id));
    RMAP_TRY(text_of(r, from, "name", &name));
    struct rmap_assembly_part *part = rmap_assembly_add_part(r->assembly, id, name, parent, r->err);
    if (!part)
        RMAP_TRY(r->err->status);
    RMAP_TRY(text_of(r, from, "material", &part->material));
    if (json_is_string(json_object_get(from, "label")))
        RMAP_TRY(text_of(r, from, "label", &part->label));
    part->number = hexadecimal_of(from, "number");
    RMAP_TRY(colour_of(r, from, &part->colour));
    if (json_object_get(from, "matrix") && !numbers_of(json_object_get(from, "matrix"), 12, m))
        RMAP_TRY(refuse(r, "the 'matrix' of part '%.60s' is not 12 numbers", name));
    part->place = (struct rmap_affine){
        {{m[0], m[1], m[2]}, {m[4], m[5], m[6]}, {m[8], m[9], m[10]}}, {m[3], m[7], m[11]}};
    if (!shape == !parts)
        RMAP_TRY(refuse(r, "part '%.60s' must have a 'shape', or 'parts'", name));
    if (shape) {
        const json_t *number =
            json_is_string(shape) ? json_object_get(ids->of, json_string_value(shape)) : NULL;
        if (!number)
            RMAP_TRY(refuse(r, "the shape of part '%.60s' is not there", name));
        part->shape = (int32_t)json_integer_value(number);
    } else {
        st = read_parts(r, ids, parts, (int32_t)index, depth + 1);
    }
out:
    rmap_free(id);
    rmap_free(name);
    return st;
}

static enum rmap_status read_parts(struct reading *r, const struct shape_ids *ids,
                                   const json_t *list, int32_t parent, int depth)
{
    enum rmap_status st = RMAP_OK;
    if (depth > RMAP_ASSEMBLY_DEPTH_MAX)
        return refuse(r, "its parts are nested more than %d deep", RMAP_ASSEMBLY_DEPTH_MAX);
    if (!json_is_array(list))
        return refuse(r, "'parts' is no list");
    for (size_t i = 0; i < json_array_size(list) && st == RMAP_OK; i++)
        st = json_is_object(json_array_get(list, i))
                 ? read_part(r, ids, json_array_get(list, i), parent, depth)
                 : refuse(r, "a part is no object");
    return st;
}

/* ---- the rest ---- */

static enum rmap_status read_materials(struct reading *r, const json_t *list)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_assembly *a = r->assembly;
    for (size_t i = 0; i < json_array_size(list) && st == RMAP_OK; i++) {
        const json_t *from = json_array_get(list, i);
        RMAP_TRY(RMAP_RESERVE(a->material, a->cap_material, a->n_material + 1, r->err));
        struct rmap_assembly_material *to = &a->material[a->n_material];
        *to = (struct rmap_assembly_material){.metalness = number_of(from, "metalness"),
                                              .roughness = number_of(from, "roughness"),
                                              .transmission = number_of(from, "transmission"),
                                              .index = number_of(from, "index")};
        RMAP_TRY(text_of(r, from, "name", &to->name));
        a->n_material++;
        st = colour_of(r, from, &to->colour);
    }
out:
    return st;
}

static enum rmap_status read_touching(struct reading *r, const json_t *list)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_assembly *a = r->assembly;
    for (size_t i = 0; i < json_array_size(list) && st == RMAP_OK; i++) {
        const json_t *from = json_array_get(list, i), *one = json_array_get(from, 0),
                     *other = json_array_get(from, 1);
        if (!json_is_string(one) || !json_is_string(other))
            return refuse(r, "an item of 'touching' is not [id, id, area]");
        RMAP_TRY(RMAP_RESERVE(a->touch, a->cap_touch, a->n_touch + 1, r->err));
        struct rmap_assembly_touch *to = &a->touch[a->n_touch++];
        to->part[0] = rmap_strdup(json_string_value(one));
        to->part[1] = rmap_strdup(json_string_value(other));
        to->area = json_number_value(json_array_get(from, 2));
        if (!to->part[0] || !to->part[1])
            st = rmap_error_set(r->err, RMAP_SYSTEM, "out of memory for touching parts");
    }
out:
    return st;
}

static void read_findings(struct rmap_assembly *a, const json_t *list)
{
    for (size_t i = 0; i < json_array_size(list); i++) {
        const char *text = json_string_value(json_object_get(json_array_get(list, i), "text")),
                   *part = json_string_value(json_object_get(json_array_get(list, i), "part"));
        if (text)
            rmap_diagnostics_add(&a->findings, RMAP_SEVERITY_WARNING, 0, 0, "%.200s%s%.700s",
                                 part ? part : "", part ? ": " : "", text);
    }
}

static enum rmap_status read_root(struct reading *r, const json_t *root)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_assembly *a = r->assembly;
    const char *format = json_string_value(json_object_get(root, "format"));
    const json_t *shapes = json_object_get(root, "shapes");
    struct shape_ids ids = {json_object()};
    if (!format || strcmp(format, "raymap-assembly") != 0)
        RMAP_TRY(refuse(r, "it is no raymap-assembly"));
    if (json_integer_value(json_object_get(root, "version")) != 1)
        RMAP_TRY(refuse(r, "its version is not 1: it is of another program than this one"));
    RMAP_TRY(text_of(r, root, "source", &a->source));
    RMAP_TRY(text_of(r, root, "schema", &a->schema));
    RMAP_TRY(text_of(r, root, "writer", &a->writer));
    RMAP_TRY(text_of(r, root, "file_unit", &a->file_unit));
    a->chord = number_of(root, "chord");
    a->angle = number_of(root, "angle");
    for (size_t i = 0; i < json_array_size(shapes); i++) {
        RMAP_TRY(read_shape(r, json_array_get(shapes, i)));
        if (json_object_get(ids.of, a->shape[i].id))
            RMAP_TRY(refuse(r, "two shapes have the id '%.60s'", a->shape[i].id));
        if (json_object_set_new(ids.of, a->shape[i].id, json_integer((json_int_t)i)) != 0)
            RMAP_TRY(rmap_error_set(r->err, RMAP_SYSTEM, "out of memory for shapes"));
    }
    RMAP_TRY(read_parts(r, &ids, json_object_get(root, "parts"), -1, 1));
    RMAP_TRY(read_materials(r, json_object_get(root, "materials")));
    RMAP_TRY(read_touching(r, json_object_get(root, "touching")));
    read_findings(a, json_object_get(root, "findings"));
out:
    json_decref(ids.of);
    return st;
}

enum rmap_status rmap_assembly_read_json(const char *text, size_t nbytes,
                                         struct rmap_assembly *assembly, struct rmap_error *err)
{
    json_error_t wrong = {0};
    struct reading reading = {.assembly = assembly, .err = err};
    json_t *root = json_loadb(text, nbytes, JSON_REJECT_DUPLICATES, &wrong);
    enum rmap_status st = RMAP_OK;
    if (!root && json_error_code(&wrong) != json_error_out_of_memory)
        st = rmap_error_set(err, RMAP_INPUT, "line %d: %s", wrong.line, wrong.text);
    if (root)
        st = read_root(&reading, root);
    /* Want of memory may look like a mistake in the text, or like a key that is not there. */
    if ((!root && st == RMAP_OK) || rmap_json_memory_failed())
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bytes of JSON", nbytes);
    json_decref(root);
    if (st == RMAP_OK)
        st = rmap_assembly_settle_ids(assembly, err);
    return st;
}

/* ---- writing ---- */

static json_t *three_json(const double value[3])
{
    return json_pack("[f, f, f]", value[0], value[1], value[2]);
}

static json_t *colour_json(const struct rmap_assembly_colour *colour)
{
    return colour->given ? three_json(colour->rgb) : json_null();
}

static json_t *text_json(const char *text)
{
    return text && text[0] ? json_string(text) : json_null();
}

static json_t *shape_json(const struct rmap_assembly_shape *shape)
{
    json_t *faces = json_array();
    for (size_t i = 0; i < shape->n_face; i++) {
        const struct rmap_assembly_face *face = &shape->face[i];
        json_t *its = json_pack("{s:s, s:o, s:o}", "name", face->name ? face->name : "", "color",
                                colour_json(&face->colour), "material", text_json(face->material));
        if (shape->form[0] && isfinite(face->middle[0]))
            (void)json_object_set_new(its, "middle", three_json(face->middle));
        (void)json_array_append_new(faces, its);
    }
    return json_pack("{s:s, s:s, s:s, s:s, s:s, s:o, s:b, s:f, s:[o, o], s:o}", "id", shape->id,
                     "name", shape->name, "file", shape->file, "hash", shape->hash, "form",
                     shape->form, "digest", hexadecimal_json(shape->digest), "closed",
                     shape->closed, "chord", shape->chord, "bounds", three_json(shape->lower),
                     three_json(shape->upper), "faces", faces);
}

static json_t *part_json(const struct rmap_assembly *a, size_t i)
{
    const struct rmap_assembly_part *part = &a->part[i];
    const struct rmap_affine *p = &part->place;
    return json_pack("{s:s, s:s, s:s, s:o, s:o, s:o, s:[f, f, f, f, f, f, f, f, f, f, f, f]}", "id",
                     part->id, "name", part->name, "label", part->label ? part->label : "",
                     "number", hexadecimal_json(part->number), "color", colour_json(&part->colour),
                     "material", text_json(part->material), "matrix", p->m[0][0], p->m[0][1],
                     p->m[0][2], p->t.x, p->m[1][0], p->m[1][1], p->m[1][2], p->t.y, p->m[2][0],
                     p->m[2][1], p->m[2][2], p->t.z);
}

/* Children hang on what was made for their parents. */
static json_t *parts_json(const struct rmap_assembly *a)
{
    json_t *root = json_array(), **list = rmap_alloc(a->n_part, sizeof *list);
    for (size_t i = 0; list && i < a->n_part; i++) {
        json_t *part = part_json(a, i),
               *above = a->part[i].parent < 0 ? root : list[a->part[i].parent];
        if (a->part[i].shape >= 0)
            (void)json_object_set_new(part, "shape", json_string(a->shape[a->part[i].shape].id));
        else
            (void)json_object_set_new(part, "parts", list[i] = json_array());
        (void)json_array_append_new(above, part);
    }
    if (!list) {
        json_decref(root);
        root = NULL;
    }
    rmap_free(list);
    return root;
}

json_t *rmap_assembly_json(const struct rmap_assembly *a)
{
    json_t *shapes = json_array(), *materials = json_array(), *touching = json_array();
    for (size_t i = 0; i < a->n_shape; i++)
        (void)json_array_append_new(shapes, shape_json(&a->shape[i]));
    for (size_t i = 0; i < a->n_material; i++) {
        const struct rmap_assembly_material *m = &a->material[i];
        (void)json_array_append_new(
            materials, json_pack("{s:s, s:o, s:f, s:f, s:f, s:f}", "name", m->name, "color",
                                 colour_json(&m->colour), "metalness", m->metalness, "roughness",
                                 m->roughness, "transmission", m->transmission, "index", m->index));
    }
    for (size_t i = 0; i < a->n_touch; i++)
        (void)json_array_append_new(touching, json_pack("[s, s, f]", a->touch[i].part[0],
                                                        a->touch[i].part[1], a->touch[i].area));
    return json_pack("{s:s, s:i, s:s, s:s, s:s, s:s, s:s, s:f, s:f, s:o, s:o, s:o, s:o}", "format",
                     "raymap-assembly", "version", 1, "source", a->source, "schema", a->schema,
                     "writer", a->writer, "unit", "mm", "file_unit", a->file_unit, "chord",
                     a->chord, "angle", a->angle, "shapes", shapes, "parts", parts_json(a),
                     "materials", materials, "touching", touching);
}

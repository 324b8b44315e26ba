/* SPDX-License-Identifier: MIT
 *
 * Stanford PLY (Turk 1994, "The PLY polygon file format"), ASCII and both binary forms. Read here
 * because assimp 5.2 trusts the header: of 60 files damaged at random it crashed on, or never
 * finished, 24. Every count is checked against the bytes that are there.
 *
 * Polygons are cut into fans about their first corner.
 */
#include <ctype.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/mesh/mesh_builder.h"

enum { ELEMENTS_MAX = 16, PROPERTIES_MAX = 64, WORDS_MAX = 6 };

enum type { I8, U8, I16, U16, I32, U32, F32, F64, TYPE_COUNT };
static const size_t type_nbytes[TYPE_COUNT] = {1, 1, 2, 2, 4, 4, 4, 8};

/* From ROLE_KIND on: columns of a surface. */
enum role {
    ROLE_NONE,
    ROLE_X,
    ROLE_Y,
    ROLE_Z,
    ROLE_U,
    ROLE_V,
    ROLE_CORNERS,
    ROLE_FACE,
    ROLE_KIND,
    ROLE_AT,
    ROLE_AXIS = ROLE_AT + 3,
    ROLE_RADIUS = ROLE_AXIS + 3,
    ROLE_SECOND,
    ROLE_COUNT
};
enum { SURFACE_COLUMNS = ROLE_COUNT - ROLE_KIND };

struct property {
    enum type type, count_type;
    bool is_list;
    enum role role;
};

struct element {
    char name[32];
    uint64_t n;
    int n_property;
    struct property property[PROPERTIES_MAX];
};

enum form { ASCII, LITTLE_ENDIAN_BYTES, BIG_ENDIAN_BYTES };

struct ply {
    const char *text; /* the file, with a NUL behind it */
    size_t nbytes, at;
    enum form form;
    int n_element;
    struct element element[ELEMENTS_MAX];
    double (*vertex)[5]; /* x, y, z, u, v */
    bool has_u, has_v;
    uint64_t n_vertex;
    uint64_t *corner; /* of the polygon being read */
    size_t cap_corner;
    bool has_surfaces;
    double (*surface)[SURFACE_COLUMNS]; /* [n_surface], one for each face */
    uint64_t n_surface;
    struct part {
        uint64_t corner[3], face;
    } * part; /* triangles of such a file, as they come */
    size_t n_part, cap_part;
    struct title {
        uint64_t face;
        char *name;
    } * title; /* names of faces */
    size_t n_title, cap_title;
    struct rmap_mesh_builder *builder;
    double scale;
};

static enum rmap_status refuse(struct ply *ply, const char *why)
{
    return rmap_error_set(ply->builder->err, RMAP_INPUT, "%s", why);
}

/* ---- header ---- */

/* Words of the next line, each ended by a NUL written into `line`. False at the file's end. */
static bool next_line(struct ply *ply, char line[256], char *word[WORDS_MAX], int *n_word)
{
    size_t left = ply->nbytes - ply->at;
    const char *start = ply->text + ply->at, *end = memchr(start, '\n', left);
    *n_word = 0;
    if (!end)
        return false;
    size_t len = (size_t)(end - start);
    ply->at += len + 1;
    if (len > 255)
        len = 255; /* a long comment */
    memcpy(line, start, len);
    line[len] = 0;
    for (char *c = line; *c && *n_word < WORDS_MAX;) {
        while (isspace((unsigned char)*c))
            *c++ = 0;
        if (!*c)
            break;
        word[(*n_word)++] = c;
        while (*c && !isspace((unsigned char)*c))
            c++;
        if (*c)
            *c++ = 0;
    }
    return true;
}

static bool find_type(const char *word, enum type *type)
{
    static const struct {
        const char *name;
        enum type type;
    } known[] = {{"char", I8},   {"int8", I8},     {"uchar", U8},   {"uint8", U8},
                 {"short", I16}, {"int16", I16},   {"ushort", U16}, {"uint16", U16},
                 {"int", I32},   {"int32", I32},   {"uint", U32},   {"uint32", U32},
                 {"float", F32}, {"float32", F32}, {"double", F64}, {"float64", F64}};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        if (strcmp(word, known[i].name) != 0)
            continue;
        *type = known[i].type;
        return true;
    }
    return false;
}

static enum rmap_status read_element(struct ply *ply, char *word[WORDS_MAX], int n_word)
{
    char *end = NULL;
    if (n_word != 3 || ply->n_element == ELEMENTS_MAX || !isdigit((unsigned char)word[2][0]))
        return refuse(ply, "a line of its header that begins with 'element' is wrong");
    struct element *element = &ply->element[ply->n_element++];
    (void)snprintf(element->name, sizeof element->name, "%.31s", word[1]);
    ply->has_surfaces = ply->has_surfaces || strcmp(word[1], "surface") == 0;
    element->n = strtoull(word[2], &end, 10);
    if (*end || element->n > ply->nbytes)
        return refuse(ply, "its header promises more than the file holds");
    return RMAP_OK;
}

static enum role role_of(const struct element *element, const struct property *property,
                         const char *name)
{
    static const struct {
        const char *element, *name;
        enum role role;
    } known[] = {{"vertex", "x", ROLE_X},          {"vertex", "y", ROLE_Y},
                 {"vertex", "z", ROLE_Z},          {"vertex", "u", ROLE_U},
                 {"vertex", "s", ROLE_U},          {"vertex", "texture_u", ROLE_U},
                 {"vertex", "v", ROLE_V},          {"vertex", "t", ROLE_V},
                 {"vertex", "texture_v", ROLE_V},  {"face", "face", ROLE_FACE},
                 {"surface", "kind", ROLE_KIND},   {"surface", "ox", ROLE_AT},
                 {"surface", "oy", ROLE_AT + 1},   {"surface", "oz", ROLE_AT + 2},
                 {"surface", "ax", ROLE_AXIS},     {"surface", "ay", ROLE_AXIS + 1},
                 {"surface", "az", ROLE_AXIS + 2}, {"surface", "r1", ROLE_RADIUS},
                 {"surface", "r2", ROLE_SECOND}};
    if (property->is_list)
        return strcmp(element->name, "face") == 0 &&
                       (strcmp(name, "vertex_indices") == 0 || strcmp(name, "vertex_index") == 0)
                   ? ROLE_CORNERS
                   : ROLE_NONE;
    for (size_t k = 0; k < sizeof known / sizeof known[0]; k++)
        if (strcmp(element->name, known[k].element) == 0 && strcmp(name, known[k].name) == 0)
            return known[k].role;
    return ROLE_NONE;
}

static enum rmap_status read_property(struct ply *ply, char *word[WORDS_MAX], int n_word)
{
    static const char wrong[] = "a line of its header that begins with 'property' is wrong";
    struct element *element = ply->n_element ? &ply->element[ply->n_element - 1] : NULL;
    if (n_word < 3 || !element || element->n_property == PROPERTIES_MAX)
        return refuse(ply, wrong);
    struct property *property = &element->property[element->n_property++];
    property->is_list = strcmp(word[1], "list") == 0;
    bool good = property->is_list ? n_word == 5 && find_type(word[2], &property->count_type) &&
                                        find_type(word[3], &property->type)
                                  : n_word == 3 && find_type(word[1], &property->type);
    if (!good)
        return refuse(ply, wrong);
    property->role = role_of(element, property, word[n_word - 1]);
    ply->has_u = ply->has_u || property->role == ROLE_U;
    ply->has_v = ply->has_v || property->role == ROLE_V;
    return RMAP_OK;
}

static enum rmap_status read_format(struct ply *ply, char *word[WORDS_MAX], int n_word)
{
    static const char *const form[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    for (int i = 0; n_word == 3 && i < 3; i++) {
        if (strcmp(word[1], form[i]) != 0)
            continue;
        ply->form = (enum form)i;
        return RMAP_OK;
    }
    return refuse(ply, "its format is not ascii, binary_little_endian or binary_big_endian");
}

/* comment face 3 a name to the line's end */
static enum rmap_status read_title(struct ply *ply, const char *line)
{
    enum rmap_status st = RMAP_OK;
    enum { LONGEST = 200 };
    char name[LONGEST + 1] = "";
    char *rest = NULL;
    const char *end = memchr(line, '\n', (size_t)(ply->text + ply->at - line));
    line = strstr(line, "face") + strlen("face");
    const uint64_t face = strtoull(line, &rest, 10);
    while (rest < end && isspace((unsigned char)*rest))
        rest++;
    while (end > rest && isspace((unsigned char)end[-1]))
        end--;
    if (rest == line || rest >= end || end - rest > LONGEST)
        return RMAP_OK;
    memcpy(name, rest, (size_t)(end - rest));
    RMAP_TRY(RMAP_RESERVE(ply->title, ply->cap_title, ply->n_title + 1, ply->builder->err));
    ply->title[ply->n_title] = (struct title){face, rmap_strdup(name)};
    if (!ply->title[ply->n_title++].name)
        return rmap_error_set(ply->builder->err, RMAP_SYSTEM, "out of memory: %zu faces",
                              ply->n_title);
out:
    return st;
}

static enum rmap_status read_header(struct ply *ply)
{
    enum rmap_status st = RMAP_OK;
    char line[256], *word[WORDS_MAX];
    int n_word = 0;
    bool formatted = false;
    if (!next_line(ply, line, word, &n_word) || n_word != 1 || strcmp(word[0], "ply") != 0)
        return refuse(ply, "it does not begin with 'ply'");
    for (size_t at = ply->at; next_line(ply, line, word, &n_word); at = ply->at) {
        if (n_word > 3 && strcmp(word[0], "comment") == 0 && strcmp(word[1], "face") == 0)
            RMAP_TRY(read_title(ply, ply->text + at));
        if (n_word == 0 || strcmp(word[0], "comment") == 0 || strcmp(word[0], "obj_info") == 0)
            continue;
        if (strcmp(word[0], "end_header") == 0)
            return formatted ? RMAP_OK : refuse(ply, "its header has no 'format'");
        if (strcmp(word[0], "format") == 0) {
            RMAP_TRY(read_format(ply, word, n_word));
            formatted = true;
        } else if (strcmp(word[0], "element") == 0)
            RMAP_TRY(read_element(ply, word, n_word));
        else if (strcmp(word[0], "property") == 0)
            RMAP_TRY(read_property(ply, word, n_word));
        else
            return refuse(ply, "its header has a line that means nothing");
    }
    return refuse(ply, "its header does not end: the file is cut off");
out:
    return st;
}

/* ---- body ---- */

static bool next_ascii(struct ply *ply, double *value)
{
    const char *start = ply->text + ply->at;
    char *end = NULL;
    *value = strtod(start, &end);
    if (end == start || end > ply->text + ply->nbytes)
        return false;
    ply->at = (size_t)(end - ply->text);
    return true;
}

static bool next_value(struct ply *ply, enum type type, double *value)
{
    if (ply->form == ASCII)
        return next_ascii(ply, value);
    size_t n = type_nbytes[type];
    if (ply->nbytes - ply->at < n)
        return false;
    uint64_t bits = 0;
    for (size_t i = 0; i < n; i++) {
        size_t place = ply->form == LITTLE_ENDIAN_BYTES ? i : n - 1 - i;
        bits |= (uint64_t)(unsigned char)ply->text[ply->at + i] << (8 * place);
    }
    ply->at += n;
    if (type == F64) {
        memcpy(value, &bits, sizeof *value);
    } else if (type == F32) {
        uint32_t half = (uint32_t)bits;
        float single;
        memcpy(&single, &half, sizeof single);
        *value = (double)single;
    } else {
        /* Signed types: the top bit counts negative. */
        bool is_signed = type == I8 || type == I16 || type == I32;
        uint64_t top = (uint64_t)1 << (8 * n - 1);
        *value = (double)(bits & ~top) + (bits & top ? (is_signed ? -1 : 1) * (double)top : 0);
    }
    return true;
}

/* "line 12: " of a file that is text. */
static void put_line(const struct ply *ply, char line[40])
{
    unsigned long long n = 1;
    line[0] = 0;
    for (size_t i = 0; ply->form == ASCII && i < ply->at; i++)
        n += ply->text[i] == '\n';
    if (ply->form == ASCII)
        (void)snprintf(line, 40, "line %llu: ", n);
}

static enum rmap_status cut_off(struct ply *ply)
{
    char line[40];
    while (ply->form == ASCII && isspace((unsigned char)ply->text[ply->at]))
        ply->at++;
    put_line(ply, line);
    return rmap_error_set(ply->builder->err, RMAP_INPUT,
                          "%sit ends before what its header promises, or holds what is no number",
                          line);
}

/* *value as an index or count in [0, limit). */
static bool next_index(struct ply *ply, enum type type, uint64_t limit, uint64_t *index)
{
    double value = 0;
    if (!next_value(ply, type, &value) || !(value >= 0) || value >= (double)limit ||
        value != floor(value))
        return false;
    *index = (uint64_t)value;
    return true;
}

/* start: where it was to stand. */
static enum rmap_status refuse_corner(struct ply *ply, uint64_t row, size_t start)
{
    char line[40];
    if (ply->at == start)
        return cut_off(ply);
    put_line(ply, line);
    return rmap_error_set(ply->builder->err, RMAP_INPUT,
                          "%sface %llu has a vertex that is not there: there are 0 to %lld", line,
                          (unsigned long long)row + 1, (long long)ply->n_vertex - 1);
}

static enum rmap_status read_list(struct ply *ply, const struct property *property, uint64_t row,
                                  size_t *n_ret)
{
    enum rmap_status st = RMAP_OK;
    uint64_t n = 0;
    double skipped = 0;
    bool corners = property->role == ROLE_CORNERS;
    if (!next_index(ply, property->count_type, ply->nbytes - ply->at + 1, &n))
        return cut_off(ply);
    if (corners)
        RMAP_TRY(RMAP_RESERVE(ply->corner, ply->cap_corner, (size_t)n, ply->builder->err));
    for (uint64_t i = 0; i < n; i++) {
        const size_t start = ply->at;
        if (corners && !next_index(ply, property->type, ply->n_vertex, &ply->corner[i]))
            return refuse_corner(ply, row, start);
        if (!corners && !next_value(ply, property->type, &skipped))
            return cut_off(ply);
    }
    if (corners)
        *n_ret = (size_t)n;
out:
    return st;
}

static enum rmap_status add_triangle(struct ply *ply, const uint64_t index[3])
{
    struct rmap_vec3 corner[3];
    double uv[3][2];
    for (int k = 0; k < 3; k++) {
        const double *v = ply->vertex[index[k]];
        memcpy(uv[k], v + 3, sizeof uv[k]);
        corner[k] = rmap_scale(rmap_vec3(v[0], v[1], v[2]), ply->scale);
    }
    return rmap_mesh_builder_add(ply->builder, corner, ply->has_u && ply->has_v ? uv[0] : NULL);
}

static enum rmap_status add_polygon(struct ply *ply, size_t n, uint64_t face)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 2; i < n; i++) {
        const struct part part = {{ply->corner[0], ply->corner[i - 1], ply->corner[i]}, face};
        if (!ply->has_surfaces) {
            RMAP_TRY(add_triangle(ply, part.corner));
            continue;
        }
        RMAP_TRY(RMAP_RESERVE(ply->part, ply->cap_part, ply->n_part + 1, ply->builder->err));
        ply->part[ply->n_part++] = part;
    }
out:
    return st;
}

static enum rmap_status read_row(struct ply *ply, const struct element *element, uint64_t row)
{
    enum rmap_status st = RMAP_OK;
    size_t n_corner = 0;
    uint64_t face = 0;
    for (int i = 0; i < element->n_property; i++) {
        const struct property *property = &element->property[i];
        double value = 0;
        if (property->is_list) {
            RMAP_TRY(read_list(ply, property, row, &n_corner));
            continue;
        }
        if (!next_value(ply, property->type, &value))
            return cut_off(ply);
        if (property->role >= ROLE_KIND)
            ply->surface[row][property->role - ROLE_KIND] = value;
        else if (property->role == ROLE_FACE)
            face = value >= 0 && value < (double)UINT32_MAX ? (uint64_t)value : UINT64_MAX;
        else if (property->role != ROLE_NONE)
            ply->vertex[row][property->role - ROLE_X] = value;
    }
    RMAP_TRY(add_polygon(ply, n_corner, face));
out:
    return st;
}

static enum rmap_status read_rows(struct ply *ply, const struct element *element)
{
    enum rmap_status st = RMAP_OK;
    if (!element->n_property) /* nothing stands there for it */
        return RMAP_OK;
    if (strcmp(element->name, "vertex") == 0) {
        if (ply->vertex)
            return refuse(ply, "it has two lists of vertices");
        ply->vertex = rmap_alloc((size_t)element->n, sizeof *ply->vertex);
        if (!ply->vertex)
            return rmap_error_set(ply->builder->err, RMAP_SYSTEM, "out of memory for %llu vertices",
                                  (unsigned long long)element->n);
        ply->n_vertex = element->n;
    }
    if (strcmp(element->name, "surface") == 0) {
        if (ply->surface)
            return refuse(ply, "it has two lists of surfaces");
        ply->surface = rmap_alloc((size_t)element->n, sizeof *ply->surface);
        if (!ply->surface)
            return rmap_error_set(ply->builder->err, RMAP_SYSTEM, "out of memory for %llu surfaces",
                                  (unsigned long long)element->n);
        ply->n_surface = element->n;
    }
    for (uint64_t row = 0; row < element->n; row++)
        RMAP_TRY(read_row(ply, element, row));
out:
    return st;
}

/* ---- faces that lie on surfaces ---- */

static enum rmap_status set_surface(struct ply *ply, uint64_t face,
                                    struct rmap_true_surface *surface)
{
    const double *row = ply->surface[face] - ROLE_KIND, kind = row[ROLE_KIND];
    struct rmap_vec3 axis = rmap_vec3(row[ROLE_AXIS], row[ROLE_AXIS + 1], row[ROLE_AXIS + 2]);
    const double length = rmap_length(axis);
    if (!(kind >= RMAP_TRUE_NONE && kind <= RMAP_TRUE_TORUS && kind == floor(kind)))
        return rmap_error_set(ply->builder->err, RMAP_INPUT,
                              "face %llu lies on a surface of kind %g, which is none of 0 to %d",
                              (unsigned long long)face, kind, RMAP_TRUE_TORUS);
    *surface = (struct rmap_true_surface){.kind = (enum rmap_true_kind)kind};
    surface->at =
        rmap_scale(rmap_vec3(row[ROLE_AT], row[ROLE_AT + 1], row[ROLE_AT + 2]), ply->scale);
    surface->axis = rmap_scale(axis, length > 0 ? 1 / length : 0);
    if (surface->kind == RMAP_TRUE_SPHERE)
        surface->axis = rmap_vec3(0, 0, 1);
    surface->radius = surface->kind == RMAP_TRUE_PLANE ? 0 : ply->scale * row[ROLE_RADIUS];
    if (surface->kind == RMAP_TRUE_CONE)
        surface->second = tan(row[ROLE_SECOND]);
    else if (surface->kind == RMAP_TRUE_TORUS)
        surface->second = ply->scale * row[ROLE_SECOND];
    const char *wrong = rmap_true_surface_finish(surface);
    return wrong ? rmap_error_set(ply->builder->err, RMAP_INPUT,
                                  "the surface of face %llu is none: %s", (unsigned long long)face,
                                  wrong)
                 : RMAP_OK;
}

static const char *name_of(const struct ply *ply, uint64_t face)
{
    const char *name = NULL;
    for (size_t i = 0; i < ply->n_title; i++)
        if (ply->title[i].face == face)
            name = ply->title[i].name;
    return name;
}

static int compare_parts(const void *left, const void *right)
{
    const struct part *a = left, *b = right;
    return (a->face > b->face) - (a->face < b->face);
}

/* Face after face. */
static enum rmap_status add_faces(struct ply *ply)
{
    enum rmap_status st = RMAP_OK;
    size_t k = 0;
    if (ply->n_part)
        qsort(ply->part, ply->n_part, sizeof *ply->part, compare_parts);
    for (uint64_t face = 0; face < ply->n_surface; face++) {
        struct rmap_true_surface surface;
        RMAP_TRY(set_surface(ply, face, &surface));
        for (; k < ply->n_part && ply->part[k].face == face; k++)
            RMAP_TRY(add_triangle(ply, ply->part[k].corner));
        RMAP_TRY(rmap_mesh_builder_close_surface(ply->builder, name_of(ply, face), &surface));
    }
    if (k < ply->n_part)
        return refuse(ply, "a triangle belongs to a face that has no surface");
out:
    return st;
}

/* ---- file ---- */

enum rmap_status rmap_ply_read(const uint8_t *bytes, size_t nbytes, double scale,
                               struct rmap_mesh_builder *builder)
{
    enum rmap_status st = RMAP_OK;
    struct ply *ply = rmap_alloc(1, sizeof *ply);
    if (!ply)
        return rmap_error_set(builder->err, RMAP_SYSTEM, "out of memory for a PLY file");
    ply->builder = builder;
    ply->scale = scale;
    ply->text = (const char *)bytes;
    ply->nbytes = nbytes;
    RMAP_TRY(read_header(ply));
    for (int i = 0; i < ply->n_element; i++)
        RMAP_TRY(read_rows(ply, &ply->element[i]));
    if (ply->has_surfaces)
        RMAP_TRY(add_faces(ply));
    RMAP_TRY(rmap_mesh_builder_close_face(builder, NULL));
out:
    for (size_t i = 0; i < ply->n_title; i++)
        rmap_free(ply->title[i].name);
    rmap_free(ply->title);
    rmap_free(ply->part);
    rmap_free(ply->surface);
    rmap_free(ply->vertex);
    rmap_free(ply->corner);
    rmap_free(ply);
    return st;
}

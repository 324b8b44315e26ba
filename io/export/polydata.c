/* SPDX-License-Identifier: MIT
 *
 * Rays as polylines in a VTK XML file (.vtp) that ParaView opens: version 1.0, little-endian
 * binary arrays in base64, in pieces of some thousand rays, so that memory does not grow with the
 * answer.
 */
#include "io/export/polydata.h"

#include <inttypes.h>
#include <string.h>

#include "base/alloc.h"
#include "io/export/vtk_xml.h"
#include "portion/event.h"

/* A piece ends with the ray that makes it as long as this. */
enum { PIECE_POINTS = 1 << 16 };

/* Where an array stands in a piece. */
enum place { PLACE_POINT, PLACE_CELL, PLACE_POINTS, PLACE_LINES, PLACE_COUNT };

/* Arrays of a piece, in the order of their places. */
#define ARRAYS(X)                                                                                  \
    X(EVENT, PLACE_POINT, "UInt32", "event", 1, 4)                                                 \
    X(OBJECT, PLACE_POINT, "Int32", "object", 1, 4)                                                \
    X(MEDIUM, PLACE_POINT, "Int32", "medium", 1, 4)                                                \
    X(PRIMITIVE, PLACE_POINT, "Int32", "primitive", 1, 4)                                          \
    X(NORMAL, PLACE_POINT, "Float32", "normal", 3, 12)                                             \
    X(RAY, PLACE_CELL, "UInt64", "ray", 1, 8)                                                      \
    X(SOURCE, PLACE_CELL, "Int32", "source", 1, 4)                                                 \
    X(STOP, PLACE_CELL, "UInt8", "stop", 1, 1)                                                     \
    X(FLUX, PLACE_CELL, "Float64", "flux", 1, 8)                                                   \
    X(WAVELENGTH, PLACE_CELL, "Float64", "wavelength", 1, 8)                                       \
    X(PATH_LENGTH, PLACE_CELL, "Float64", "path_length", 1, 8)                                     \
    X(OPTICAL_PATH, PLACE_CELL, "Float64", "optical_path", 1, 8)                                   \
    X(GROUP, PLACE_CELL, "Int32", "group", 1, 4)                                                   \
    X(POSITION, PLACE_POINTS, "Float32", "position", 3, 12)                                        \
    X(CONNECTIVITY, PLACE_LINES, "Int64", "connectivity", 1, 8)                                    \
    X(OFFSET, PLACE_LINES, "Int64", "offsets", 1, 8)

enum array_index {
#define ARRAY_ENUM(symbol, place, type, name, components, nbytes) ARRAY_##symbol,
    ARRAYS(ARRAY_ENUM)
#undef ARRAY_ENUM
        ARRAY_COUNT
};

static const struct {
    enum place place;
    const char *type, *name;
    int n_component;
    size_t row_nbytes;
} array_table[] = {
#define ARRAY_ROW(symbol, place, type, name, components, nbytes)                                   \
    {place, type, name, components, nbytes},
    ARRAYS(ARRAY_ROW)
#undef ARRAY_ROW
};

/* The rows of an array behind its length in bytes, with which they are encoded. */
struct array {
    uint8_t *bytes;
    size_t n_row, cap;
};

struct rmap_polydata {
    FILE *file;
    size_t n_point, n_ray; /* of the piece in hand */
    struct array array[ARRAY_COUNT];
};

enum { LENGTH_NBYTES = RMAP_VTK_LENGTH_NBYTES };

static enum rmap_status reserve(struct rmap_polydata *self, enum array_index index, size_t n_more,
                                struct rmap_error *err)
{
    struct array *array = &self->array[index];
    enum rmap_status st =
        RMAP_RESERVE(array->bytes, array->cap,
                     LENGTH_NBYTES + (array->n_row + n_more) * array_table[index].row_nbytes, err);
    return st;
}

/* Adds a row, for which there is room. */
static void put(struct rmap_polydata *self, enum array_index index, const void *row)
{
    struct array *array = &self->array[index];
    size_t nbytes = array_table[index].row_nbytes;
    memcpy(array->bytes + LENGTH_NBYTES + array->n_row++ * nbytes, row, nbytes);
}

/* What happened at a point; all zero or -1 where nothing did. */
struct happening {
    uint32_t event;
    int32_t object, medium, primitive;
    const int16_t *normal; /* x 32767; NULL: none */
};

static void put_point(struct rmap_polydata *self, const float *position,
                      const struct happening *what)
{
    const int64_t number = (int64_t)self->n_point++;
    float normal[3] = {0.0F, 0.0F, 0.0F};
    for (int k = 0; what->normal && k < 3; k++)
        normal[k] = (float)(what->normal[k] / 32767.0);
    put(self, ARRAY_POSITION, position);
    put(self, ARRAY_EVENT, &what->event);
    put(self, ARRAY_OBJECT, &what->object);
    put(self, ARRAY_MEDIUM, &what->medium);
    put(self, ARRAY_PRIMITIVE, &what->primitive);
    put(self, ARRAY_NORMAL, normal);
    put(self, ARRAY_CONNECTIVITY, &number);
}

static void write_head(FILE *file, const struct rmap_scene *scene,
                       const struct rmap_polydata_terms *terms)
{
    const char *word[RMAP_STOP_COUNT], *event[32];
    size_t n_event = 0;
    for (int s = 0; s < RMAP_STOP_COUNT; s++)
        word[s] = rmap_stop_word(s);
    while (rmap_event_word(UINT32_C(1) << n_event))
        event[n_event] = rmap_event_word(UINT32_C(1) << n_event), n_event++;
    rmap_vtk_begin(file, "PolyData");
    fputs("<PolyData>\n<FieldData>\n", file);
    rmap_vtk_length_unit(file, scene->unit_m);
    rmap_vtk_names(file, "flux_unit", &terms->flux_unit, 1, 0);
    rmap_vtk_names(file, "event_bits", event, n_event, sizeof *event);
    rmap_vtk_names(file, "stops", word, RMAP_STOP_COUNT, sizeof *word);
    rmap_vtk_names(file, "sources", (const void *)&scene->source->name, scene->n_source,
                   sizeof *scene->source);
    rmap_vtk_names(file, "objects", (const void *)&scene->object->name, scene->n_object,
                   sizeof *scene->object);
    rmap_vtk_names(file, "media", (const void *)&scene->medium->name, scene->n_medium,
                   sizeof *scene->medium);
    if (terms->n_group > 0)
        rmap_vtk_names(file, "groups", terms->group, terms->n_group, sizeof *terms->group);
    fputs("</FieldData>\n", file);
}

enum rmap_status rmap_polydata_begin(FILE *file, const struct rmap_scene *scene,
                                     const struct rmap_polydata_terms *terms,
                                     struct rmap_polydata **data_ret, struct rmap_error *err)
{
    struct rmap_polydata *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for polylines");
    self->file = file;
    write_head(file, scene, terms);
    *data_ret = self;
    return RMAP_OK;
}

static void write_array(struct rmap_polydata *self, enum array_index index)
{
    struct array *array = &self->array[index];
    const struct rmap_vtk_array as = {array_table[index].type, array_table[index].name,
                                      array_table[index].n_component};
    rmap_vtk_array(self->file, &as, array->bytes, array->n_row * array_table[index].row_nbytes);
    array->n_row = 0;
}

static void write_piece(struct rmap_polydata *self)
{
    static const char *const element[PLACE_COUNT] = {"PointData", "CellData", "Points", "Lines"};
    fprintf(self->file,
            "<Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"0\" NumberOfLines=\"%zu\" "
            "NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n",
            self->n_point, self->n_ray);
    for (int place = 0, index = 0; place < PLACE_COUNT; place++) {
        fprintf(self->file, "<%s>\n", element[place]);
        for (; index < ARRAY_COUNT && (int)array_table[index].place == place; index++)
            write_array(self, (enum array_index)index);
        fprintf(self->file, "</%s>\n", element[place]);
    }
    fputs("</Piece>\n", self->file);
    self->n_point = self->n_ray = 0;
}

/* Start, the ends of the segments, and what a curved one passes between them, where nothing
 * happens. */
static void put_points(struct rmap_polydata *self, const struct rmap_portion *portion, size_t ray,
                       size_t first, size_t first_curve, size_t n_curve)
{
    const struct rmap_segment_columns *segment = &portion->segment;
    const struct rmap_ray_columns *from = &portion->ray;
    size_t n_segment = from->segment_count[ray], at = first_curve;
    put_point(self, from->start + 3 * ray,
              &(struct happening){0, from->start_object[ray],
                                  n_segment > 0 ? segment->medium[first] : -1,
                                  from->start_primitive[ray], from->start_normal + 3 * ray});
    for (size_t k = 0, row = first; k < n_segment; k++, row++) {
        for (; at < first_curve + n_curve && portion->curve.segment[at] == k; at++)
            put_point(self, portion->curve.position + 3 * at,
                      &(struct happening){0, -1, segment->medium[row], -1, NULL});
        put_point(self, segment->position + 3 * row,
                  &(struct happening){segment->event[row], segment->object[row],
                                      segment->medium[row], segment->primitive[row],
                                      segment->normal + 3 * row});
    }
}

enum rmap_status rmap_polydata_add(struct rmap_polydata *self, const struct rmap_portion *portion,
                                   size_t ray, size_t segment,
                                   const struct rmap_polydata_ray *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_ray_columns *from = &portion->ray;
    const uint64_t id = from->id[ray];
    const int32_t source = from->source[ray];
    const uint8_t stop = from->stop[ray];
    size_t first_curve, n_curve = rmap_portion_curve_of(portion, id, &first_curve);
    for (int index = 0; index < ARRAY_COUNT; index++)
        RMAP_TRY(
            reserve(self, (enum array_index)index, from->segment_count[ray] + n_curve + 1, err));
    put_points(self, portion, ray, segment, first_curve, n_curve);
    const int64_t end = (int64_t)self->n_point;
    put(self, ARRAY_OFFSET, &end);
    put(self, ARRAY_RAY, &id);
    put(self, ARRAY_SOURCE, &source);
    put(self, ARRAY_STOP, &stop);
    put(self, ARRAY_FLUX, &given->flux);
    put(self, ARRAY_GROUP, &given->group);
    put(self, ARRAY_WAVELENGTH, from->wavelength + ray);
    put(self, ARRAY_PATH_LENGTH, from->path_length + ray);
    put(self, ARRAY_OPTICAL_PATH, from->optical_path + ray);
    self->n_ray++;
    if (self->n_point >= PIECE_POINTS)
        write_piece(self);
out:
    return st;
}

void rmap_polydata_finish(struct rmap_polydata *self)
{
    if (self->n_ray > 0)
        write_piece(self);
    fputs("</PolyData>\n</VTKFile>\n", self->file);
}

void rmap_polydata_destroy(struct rmap_polydata *self)
{
    if (!self)
        return;
    for (int index = 0; index < ARRAY_COUNT; index++)
        rmap_free(self->array[index].bytes);
    rmap_free(self);
}

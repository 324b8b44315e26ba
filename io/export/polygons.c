/* SPDX-License-Identifier: MIT
 *
 * Polygons with numbers of each as a VTK XML file (.vtp).
 */
#include "io/export/polygons.h"

#include "base/alloc.h"
#include "io/export/vtk_xml.h"
#include "io/file/whole_file.h"

/* Which points make polygons: number k is corner k. */
static enum rmap_status write_polygons(const struct rmap_polygons *polygons, FILE *file,
                                       struct rmap_error *err)
{
    const size_t n = polygons->n_polygon, n_corner = n > 0 ? polygons->end[n - 1] : 0;
    uint8_t *bytes = rmap_alloc(n_corner + n + 2, 8);
    if (!bytes)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu polygons", n);
    fputs("<Polys>\n", file);
    for (int k = 0; k < 2; k++) {
        const size_t rows = k == 0 ? n_corner : n;
        for (size_t i = 0; i < rows; i++)
            for (int b = 0; b < 8; b++)
                bytes[RMAP_VTK_LENGTH_NBYTES + 8 * i + (size_t)b] =
                    (uint8_t)((k == 0 ? i : polygons->end[i]) >> 8 * b);
        rmap_vtk_array(file,
                       &(struct rmap_vtk_array){"Int64", k == 0 ? "connectivity" : "offsets", 1},
                       bytes, 8 * rows);
    }
    fputs("</Polys>\n", file);
    rmap_free(bytes);
    return RMAP_OK;
}

enum rmap_status rmap_polygons_write(const struct rmap_polygons *polygons,
                                     const struct rmap_grid_array *array, size_t n_array,
                                     const struct rmap_grid_text *text, size_t n_text,
                                     const char *path, struct rmap_error *err)
{
    _Static_assert(sizeof(struct rmap_vec3) == 3 * sizeof(double), "points are rows of doubles");
    struct rmap_whole_file whole = {0};
    const size_t n = polygons->n_polygon, n_corner = n > 0 ? polygons->end[n - 1] : 0;
    enum rmap_status st = rmap_whole_file_open(&whole, path, err);
    if (st != RMAP_OK)
        goto out;
    FILE *file = whole.file;
    rmap_vtk_begin(file, "PolyData");
    fputs("<PolyData>\n<FieldData>\n", file);
    rmap_vtk_length_unit(file, polygons->unit_m);
    for (size_t i = 0; i < n_text; i++)
        rmap_vtk_names(file, text[i].name, &text[i].text, 1, 0);
    for (size_t i = 0; i < n_array; i++) {
        char name[80];
        (void)snprintf(name, sizeof name, "%.64s_unit", array[i].name);
        rmap_vtk_names(file, name, &array[i].unit, 1, 0);
    }
    fprintf(file,
            "</FieldData>\n<Piece NumberOfPoints=\"%zu\" NumberOfVerts=\"0\" NumberOfLines=\"0\" "
            "NumberOfStrips=\"0\" NumberOfPolys=\"%zu\">\n<Points>\n",
            n_corner, n);
    rmap_vtk_doubles(file, &(struct rmap_vtk_array){"Float64", "points", 3}, &polygons->point->x,
                     3 * n_corner);
    fputs("</Points>\n", file);
    RMAP_TRY(write_polygons(polygons, file, err));
    fprintf(file, "<CellData Scalars=\"%s\">\n", array[0].name);
    for (size_t i = 0; i < n_array; i++)
        rmap_vtk_doubles(file, &(struct rmap_vtk_array){"Float64", array[i].name, 1}, array[i].data,
                         n);
    fputs("</CellData>\n</Piece>\n</PolyData>\n</VTKFile>\n", file);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

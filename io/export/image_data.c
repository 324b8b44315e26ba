/* SPDX-License-Identifier: MIT
 *
 * Numbers of the voxels of a box as a VTK XML file (.vti).
 */
#include "io/export/image_data.h"

#include "io/export/vtk_xml.h"
#include "io/file/whole_file.h"

enum rmap_status rmap_image_data_write(const struct rmap_image_data *box,
                                       const struct rmap_grid_array *array, size_t n_array,
                                       const struct rmap_grid_text *text, size_t n_text,
                                       const char *path, struct rmap_error *err)
{
    struct rmap_whole_file whole = {0};
    const size_t n_voxel = (size_t)box->n[0] * box->n[1] * box->n[2];
    char extent[64];
    enum rmap_status st = rmap_whole_file_open(&whole, path, err);
    if (st != RMAP_OK)
        goto out;
    FILE *file = whole.file;
    (void)snprintf(extent, sizeof extent, "0 %u 0 %u 0 %u", box->n[0], box->n[1], box->n[2]);
    rmap_vtk_begin(file, "ImageData");
    fprintf(file,
            "<ImageData WholeExtent=\"%s\" Origin=\"%.17g %.17g %.17g\" "
            "Spacing=\"%.17g %.17g %.17g\">\n<FieldData>\n",
            extent, box->low[0], box->low[1], box->low[2], box->step[0], box->step[1],
            box->step[2]);
    rmap_vtk_length_unit(file, box->unit_m);
    for (size_t i = 0; i < n_text; i++)
        rmap_vtk_names(file, text[i].name, &text[i].text, 1, 0);
    for (size_t i = 0; i < n_array; i++) {
        char name[80];
        (void)snprintf(name, sizeof name, "%.64s_unit", array[i].name);
        if (array[i].rank == 3)
            rmap_vtk_names(file, name, &array[i].unit, 1, 0);
    }
    fprintf(file, "</FieldData>\n<Piece Extent=\"%s\">\n<CellData>\n", extent);
    for (size_t i = 0; i < n_array; i++)
        if (array[i].rank == 3)
            rmap_vtk_doubles(file, &(struct rmap_vtk_array){"Float64", array[i].name, 1},
                             array[i].data, n_voxel);
    fputs("</CellData>\n</Piece>\n</ImageData>\n</VTKFile>\n", file);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_whole_file_fini(&whole);
    return st;
}

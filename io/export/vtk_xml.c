/* SPDX-License-Identifier: MIT
 *
 * What VTK's XML files are made of.
 */
#include "io/export/vtk_xml.h"

#include <string.h>

#include "io/file/base64.h"

static void write_base64(const uint8_t *bytes, size_t n, FILE *file)
{
    char four[4];
    for (size_t i = 0; i < n; i += 3) {
        rmap_base64_four(bytes + i, n - i, four);
        (void)fwrite(four, 1, sizeof four, file);
    }
}

void rmap_vtk_begin(FILE *file, const char *type)
{
    fprintf(file,
            "<?xml version=\"1.0\"?>\n<VTKFile type=\"%s\" version=\"1.0\" "
            "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n",
            type);
}

void rmap_vtk_length_unit(FILE *file, double unit_m)
{
    fprintf(file,
            "<DataArray type=\"Float64\" Name=\"length_unit_m\" NumberOfTuples=\"1\" "
            "format=\"ascii\">%.17g</DataArray>\n",
            unit_m);
}

/* Strings of character codes. */
void rmap_vtk_names(FILE *file, const char *array, const char *const *name, size_t n, size_t stride)
{
    fprintf(file, "<Array type=\"String\" Name=\"%s\" NumberOfTuples=\"%zu\" format=\"ascii\">",
            array, n);
    for (size_t i = 0; i < n; i++) {
        const char *const *at = (const void *)((const char *)name + i * stride);
        for (const char *c = *at ? *at : ""; *c; c++)
            fprintf(file, "%d ", (int)(unsigned char)*c);
        fputs("0 ", file);
    }
    fputs("</Array>\n", file);
}

static void put_length(uint8_t *bytes, uint64_t nbytes)
{
    for (int k = 0; k < RMAP_VTK_LENGTH_NBYTES; k++)
        bytes[k] = (uint8_t)(nbytes >> 8 * k);
}

static void open_array(FILE *file, const struct rmap_vtk_array *array)
{
    fprintf(file, "<DataArray type=\"%s\" Name=\"%s\" NumberOfComponents=\"%d\" format=\"binary\">",
            array->type, array->name, array->n_component);
}

void rmap_vtk_array(FILE *file, const struct rmap_vtk_array *array, uint8_t *bytes, size_t nbytes)
{
    put_length(bytes, nbytes);
    open_array(file, array);
    write_base64(bytes, RMAP_VTK_LENGTH_NBYTES + nbytes, file);
    fputs("</DataArray>\n", file);
}

/* Three words of 8 bytes at a time, which are whole groups of base64: the first is the length. */
void rmap_vtk_doubles(FILE *file, const struct rmap_vtk_array *array, const double *value, size_t n)
{
    uint8_t some[24];
    size_t held = RMAP_VTK_LENGTH_NBYTES;
    put_length(some, n * sizeof *value);
    open_array(file, array);
    for (size_t i = 0; i < n; i++) {
        uint64_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        for (int k = 0; k < 8; k++)
            some[held++] = (uint8_t)(bits >> 8 * k);
        if (held < sizeof some)
            continue;
        write_base64(some, held, file);
        held = 0;
    }
    write_base64(some, held, file);
    fputs("</DataArray>\n", file);
}

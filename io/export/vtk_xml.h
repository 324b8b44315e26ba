/* SPDX-License-Identifier: MIT
 *
 * What VTK's XML files (version 1.0, little-endian, arrays in base64 behind their length) are made
 * of. Errors of the file are left to the caller's ferror.
 */
#ifndef RMAP_VTK_XML_H
#define RMAP_VTK_XML_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

/* The head up to the data set's element, as "PolyData". */
void rmap_vtk_begin(FILE *file, const char *type);

/* Entries of FieldData: the unit of coordinates, and texts: name[i] stands `stride` bytes behind
 * name[i - 1]. */
void rmap_vtk_length_unit(FILE *file, double unit_m);
void rmap_vtk_names(FILE *file, const char *array, const char *const *name, size_t n,
                    size_t stride);

/* A row of bytes as an array's content; the first RMAP_VTK_LENGTH_NBYTES are for its length. */
enum { RMAP_VTK_LENGTH_NBYTES = 8 };
struct rmap_vtk_array {
    const char *type, *name; /* "Float64" */
    int n_component;
};
void rmap_vtk_array(FILE *file, const struct rmap_vtk_array *array, uint8_t *bytes, size_t nbytes);

/* The same of numbers that stand elsewhere. */
void rmap_vtk_doubles(FILE *file, const struct rmap_vtk_array *array, const double *value,
                      size_t n);

#endif

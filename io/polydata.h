/* SPDX-License-Identifier: MIT
 *
 * Rays as polylines in a VTK XML file (.vtp) that ParaView opens: version 1.0, little-endian
 * binary arrays in base64, in pieces of some thousand rays, so that memory does not grow with the
 * answer. What the arrays hold is told in docs/commands.md.
 */
#ifndef RMAP_POLYDATA_H
#define RMAP_POLYDATA_H

#include <stdio.h>

#include "scene/scene.h"
#include "trace/portion.h"

struct rmap_polydata;

/* The file is borrowed; its errors are left to the caller's ferror. */
enum rmap_status rmap_polydata_begin(FILE *file, const struct rmap_scene *scene,
                                     const char *flux_unit, struct rmap_polydata **data_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* One ray: row `ray` of a portion that has all columns, its legs from row `segment` on; flux in
 * that unit. RMAP_SYSTEM. */
enum rmap_status rmap_polydata_add(struct rmap_polydata *data, const struct rmap_portion *portion,
                                   size_t ray, size_t segment, double flux,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Writes what is left, and the end of the file. */
void rmap_polydata_finish(struct rmap_polydata *data);
void rmap_polydata_destroy(struct rmap_polydata *data); /* NULL is fine */

#endif

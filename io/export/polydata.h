/* SPDX-License-Identifier: MIT
 *
 * Rays as polylines in a VTK XML file (.vtp) that ParaView opens: version 1.0, little-endian
 * binary arrays in base64, in pieces of some thousand rays, so that memory does not grow with the
 * answer. What the arrays hold is said in docs/commands.md.
 */
#ifndef RMAP_POLYDATA_H
#define RMAP_POLYDATA_H

#include <stdio.h>

#include "portion/portion.h"
#include "scene/scene.h"

struct rmap_polydata;

/* What the numbers in the arrays refer to, beside the scene's names. */
struct rmap_polydata_terms {
    const char *flux_unit;
    const char *const *group; /* [n_group] names of groups of rays */
    size_t n_group;
};

/* The file is borrowed; its errors are left to the caller's ferror. */
enum rmap_status rmap_polydata_begin(FILE *file, const struct rmap_scene *scene,
                                     const struct rmap_polydata_terms *terms,
                                     struct rmap_polydata **data_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* One ray: row `ray` of a portion that has all columns, its segments from row `segment` on.
 * RMAP_SYSTEM.
 */
struct rmap_polydata_ray {
    double flux;   /* in that unit */
    int32_t group; /* of a drawing's legend; -1: none */
};
enum rmap_status rmap_polydata_add(struct rmap_polydata *data, const struct rmap_portion *portion,
                                   size_t ray, size_t segment,
                                   const struct rmap_polydata_ray *given,
                                   struct rmap_error *err) RMAP_MUST_USE;

/* Writes what is left, and the end of the file. */
void rmap_polydata_finish(struct rmap_polydata *data);
void rmap_polydata_destroy(struct rmap_polydata *data); /* NULL is fine */

#endif

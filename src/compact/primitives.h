/* SPDX-License-Identifier: MIT
 *
 * Primitives of segments: triangles of meshes are listed, all others follow from the object.
 */
#ifndef RMAP_COMPACT_PRIMITIVES_H
#define RMAP_COMPACT_PRIMITIVES_H

#include "compact/model.h"

/* Primitives of n segments that end on these objects; the n_triangle triangles in turn where it is
 * a mesh. Returns how many were asked for, where there are any: if it is not n_triangle, what was
 * written is no good. */
size_t rmap_primitives_place(const struct rmap_compact_model *model, const int32_t *object,
                             size_t n, const uint32_t *triangle, size_t n_triangle,
                             int32_t *primitive);

/* Of n segments that end on these objects, those whose triangle is listed. */
size_t rmap_primitives_listed(const struct rmap_compact_model *model, const int32_t *object,
                              size_t n);

#endif

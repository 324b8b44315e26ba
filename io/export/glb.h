/* SPDX-License-Identifier: MIT
 *
 * A writer of glTF 2.0 scenes in one file (Khronos Group, "glTF 2.0 Specification", 2021):
 * materials, triangle meshes, lines with a colour per point, and named nodes that place them. The
 * same calls give the same bytes.
 */
#ifndef RMAP_GLB_H
#define RMAP_GLB_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

struct rmap_glb;

/* scale: of all that is placed, to metres; z_upright: turned, since y points upwards in glTF. */
enum rmap_status rmap_glb_create(double scale, int z_upright, struct rmap_glb **glb_ret,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_glb_destroy(struct rmap_glb *glb); /* NULL is fine */

struct rmap_glb_material {
    const char *name;
    double colour[4]; /* linear RGB and opacity; below 1 it is blended */
    double metallic, roughness;
    int unlit;     /* shows its colours as they are (KHR_materials_unlit) */
    int one_sided; /* seen from where its triangles turn counter-clockwise */
};
/* Index of the new entry in *index_ret; RMAP_SYSTEM. The same for all below. */
enum rmap_status rmap_glb_add_material(struct rmap_glb *glb,
                                       const struct rmap_glb_material *material, size_t *index_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Points [n_point][3] and corners [n_triangle][3]: what several meshes may share. */
struct rmap_glb_shape {
    size_t position, corner; /* accessors */
};
enum rmap_status rmap_glb_add_shape(struct rmap_glb *glb, const float (*point)[3], size_t n_point,
                                    const uint32_t (*corner)[3], size_t n_triangle,
                                    struct rmap_glb_shape *shape_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_glb_add_mesh(struct rmap_glb *glb, const char *name,
                                   const struct rmap_glb_shape *shape, size_t material,
                                   size_t *index_ret, struct rmap_error *err) RMAP_MUST_USE;

/* The same with a colour and a number of each point [n_point], under the name that
 * applications give theirs, "_IRRADIANCE". colour: linear RGB and opacity x 65535. */
struct rmap_glb_paint {
    const uint16_t (*colour)[4];
    const float *number;
    const char *attribute;
    size_t n_point;
};
enum rmap_status rmap_glb_add_painted(struct rmap_glb *glb, const char *name,
                                      const struct rmap_glb_shape *shape,
                                      const struct rmap_glb_paint *paint, size_t material,
                                      size_t *index_ret, struct rmap_error *err) RMAP_MUST_USE;

/* Separate lines: points [2 n_line][3] in pairs, with linear RGBA in bytes [2 n_line][4]. */
enum rmap_status rmap_glb_add_lines(struct rmap_glb *glb, const char *name, const float (*point)[3],
                                    const uint8_t (*colour)[4], size_t n_line, size_t *index_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* A mesh in its place: columns of a 4 x 4 matrix; NULL: as it is. */
enum rmap_status rmap_glb_place(struct rmap_glb *glb, const char *name, size_t mesh,
                                const double matrix[16], struct rmap_error *err) RMAP_MUST_USE;

/* Writes the whole, as a binary file (.glb), or as JSON with the numbers in base64 (.gltf). The
 * file's errors are left to the caller's ferror. RMAP_USAGE beyond what a binary one holds. */
enum rmap_status rmap_glb_write(const struct rmap_glb *glb, FILE *out,
                                struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_gltf_write(const struct rmap_glb *glb, FILE *out,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif

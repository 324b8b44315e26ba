/* SPDX-License-Identifier: MIT
 *
 * An assembly: a tree of named parts in places, the shapes that they share, and what the file says
 * of colours and materials. Lengths are mm, colours sRGB from 0 to 1.
 */
#ifndef RMAP_ASSEMBLY_H
#define RMAP_ASSEMBLY_H

#include <jansson.h>
#include <stdbool.h>

#include "geometry/mesh.h"
#include "io/file/diagnostics.h"

/* Of a file; a tree of parts is no deeper than scenes are. */
#define RMAP_ASSEMBLY_PARTS_MAX  1000000
#define RMAP_ASSEMBLY_FACES_MAX  10000000
#define RMAP_ASSEMBLY_DEPTH_MAX  24
#define RMAP_ASSEMBLY_NBYTES_MAX ((size_t)1 << 30)

struct rmap_assembly_colour {
    bool given;
    double rgb[3];
};

struct rmap_assembly_face {
    char *name, *material; /* "" or NULL: none */
    struct rmap_assembly_colour colour;
    double middle[3]; /* of its area, where the shape has a `form`; NaN: not known */
};

struct rmap_assembly_shape {
    char *id, *name;
    char *file;      /* of its mesh, without a folder */
    char *made;      /* what it was called where it was read; NULL: it is no file yet */
    char hash[33];   /* the same for the same shape, whatever file it is in */
    char form[33];   /* the same also for one that lies elsewhere in its frame; "": not known */
    uint64_t digest; /* of the mesh file's bytes; 0: not known */
    double chord;    /* of its triangles; 0: not known */
    bool closed;
    double lower[3], upper[3];
    size_t n_face;
    struct rmap_assembly_face *face;
    struct rmap_mesh *mesh; /* that is not yet a file; NULL: it is one */
};

struct rmap_assembly_part {
    char *id;        /* the same in the next revision, as far as the file has such names */
    char *name;      /* the file's own words */
    char *label;     /* its name in the scene; NULL: not yet given */
    uint64_t number; /* its id in the scene, which it keeps; 0: not yet given */
    char *material;  /* or NULL */
    struct rmap_assembly_colour colour;
    int32_t parent, shape;    /* -1: none; a part without a shape is a group */
    struct rmap_affine place; /* in its parent's frame */
};

/* What a file says of a material's looks, by which a surface is guessed. */
struct rmap_assembly_material {
    char *name;
    struct rmap_assembly_colour colour;
    double metalness, roughness, transmission, index;
};

struct rmap_assembly_touch {
    char *part[2]; /* ids */
    double area;
};

struct rmap_assembly {
    char *source, *schema, *writer, *file_unit; /* texts, "" where unknown */
    double chord, angle;                        /* asked for; 0: what is usual */
    size_t n_shape, n_part, n_material, n_touch;
    size_t cap_shape, cap_part, cap_material, cap_touch;
    struct rmap_assembly_shape *shape;
    struct rmap_assembly_part *part; /* parents before their children */
    struct rmap_assembly_material *material;
    struct rmap_assembly_touch *touch;
    struct rmap_diagnostics findings;
};

void rmap_assembly_shape_fini(struct rmap_assembly_shape *shape);

/* Zero-initialise; fini in any case. */
void rmap_assembly_fini(struct rmap_assembly *assembly);

/* A zeroed new one at the end, with copies of the texts (NULL: ""); NULL: no memory, *err says it.
 */
struct rmap_assembly_part *rmap_assembly_add_part(struct rmap_assembly *assembly, const char *id,
                                                  const char *name, int32_t parent,
                                                  struct rmap_error *err);
struct rmap_assembly_shape *rmap_assembly_add_shape(struct rmap_assembly *assembly, const char *id,
                                                    const char *name, struct rmap_error *err);

/* Of a shape's own faces, or of all parts. */
const struct rmap_assembly_material *rmap_assembly_material(const struct rmap_assembly *assembly,
                                                            const char *name);

/* Ids that several parts have become id, id.2, ...; so do names in `label`, which are made of the
 * file's words where they are not yet given, with a `number` of the id. RMAP_SYSTEM. */
enum rmap_status rmap_assembly_settle_ids(struct rmap_assembly *assembly,
                                          struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_assembly_settle_labels(struct rmap_assembly *assembly,
                                             struct rmap_error *err) RMAP_MUST_USE;

/* Names of mesh files for shapes that have none. RMAP_SYSTEM. */
enum rmap_status rmap_assembly_settle_files(struct rmap_assembly *assembly,
                                            struct rmap_error *err) RMAP_MUST_USE;

/* Shapes of equal geometry, whose faces look alike, become one; faces that all look as their part
 * does leave it to the part. Not yet files. RMAP_SYSTEM. */
enum rmap_status rmap_assembly_share(struct rmap_assembly *assembly,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* ---- from files and to them ---- */

/* The text of an assembly.json. RMAP_INPUT: it is none, with what is wrong, without its path;
 * RMAP_SYSTEM. */
enum rmap_status rmap_assembly_read_json(const char *text, size_t nbytes,
                                         struct rmap_assembly *assembly,
                                         struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_assembly_json(const struct rmap_assembly *assembly); /* NULL: no memory */

/* A mesh file: .gltf and .glb with their tree (in m), .obj by its groups, .stl and .ply as a single
 * part, whose lengths are multiplied by scale. unit: of the file's lengths, to be kept; "": not
 * said. RMAP_INPUT, RMAP_SYSTEM. */
enum rmap_status rmap_assembly_read_mesh(const char *path, double scale, const char *unit,
                                         struct rmap_assembly *assembly,
                                         struct rmap_error *err) RMAP_MUST_USE;

/* Materials of a Wavefront .mtl file, by their names. */
enum rmap_status rmap_assembly_read_mtl(char *text, struct rmap_assembly *assembly,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Place of a part in the world. */
struct rmap_affine rmap_assembly_world(const struct rmap_assembly *assembly, size_t part);

#endif

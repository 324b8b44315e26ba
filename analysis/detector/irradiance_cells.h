/* SPDX-License-Identifier: MIT
 *
 * The surface of objects, cut into cells. Of a mesh they are its triangles: those with long edges
 * are halved until none is longer than asked, those that are much smaller and lie together joined.
 * Other shapes are cut into rows along their profile, each of as many cells around as keep them
 * about square. What is drawn of a cell are its facets.
 *
 * By texture coordinates a mesh's cells are those of a grid over the texture; triangles are cut at
 * its lines.
 */
#ifndef RMAP_IRRADIANCE_CELLS_H
#define RMAP_IRRADIANCE_CELLS_H

#include "scene/scene.h"

struct rmap_irradiance_cell {
    double area; /* of the surface itself, in the scene's unit squared */
    struct rmap_vec3 centre;
    uint32_t part, n_facet;
    uint32_t uv;      /* place in the texture, row by row upwards */
    int32_t triangle; /* it lies in, as /segment/primitive has it; -1: several, or of a shape */
};

struct rmap_irradiance_facet {
    double area;
    size_t corner; /* corner[corner ...], counter-clockwise about the normal of the surface */
    uint32_t n_corner, cell;
    int32_t triangle; /* of the mesh; -1: of a shape */
};

/* An object. */
struct rmap_irradiance_part {
    int32_t object;
    size_t first, n;             /* its cells */
    size_t first_facet, n_facet; /* and what is drawn of them, in any order */
    size_t look_up;              /* first row of n_row, or node, one for each triangle */
    size_t n_row;
    double area;
};

struct rmap_irradiance_row {
    size_t first; /* facet */
    uint32_t n;
};
/* A triangle of a mesh, or a part of one: halved between corners `edge` and edge + 1, the halves at
 * nodes `at` and at + 1; or a cell. */
struct rmap_irradiance_node {
    uint32_t at, edge;
};
enum { RMAP_IRRADIANCE_LEAF = 3, RMAP_IRRADIANCE_NONE = 4 /* no cell */ };

struct rmap_irradiance_cells {
    const struct rmap_scene *scene; /* borrowed */
    double length;                  /* of cells; INFINITY: triangles as they are */
    double shape_length;            /* the same of shapes */
    size_t n_part, n_cell, n_facet, n_row, n_node, n_corner;
    uint32_t uv[2];   /* columns and rows of the texture; 0: it is not asked about */
    size_t n_twice;   /* cells of it that charts cover more than once */
    size_t n_without; /* triangles without texture coordinates */
    bool mirrored;    /* the object in hand: corners turn the other way */
    size_t cap_cell, cap_facet, cap_row, cap_node, cap_corner;
    uint32_t *uv_cell; /* [n_part][rows][columns]; UINT32_MAX: nothing of the surface */
    int32_t *part_of;  /* [n_object] index of a part; -1: none */
    struct rmap_irradiance_part *part;
    struct rmap_irradiance_cell *cell;
    struct rmap_irradiance_facet *facet;
    struct rmap_irradiance_row *row;
    struct rmap_irradiance_node *node;
    struct rmap_vec3 *corner; /* in the world */
};

#define RMAP_IRRADIANCE_CELLS_MAX (1u << 22)

struct rmap_irradiance_choice {
    const uint8_t *object;   /* [n_object] 1: it takes part */
    const char *const *face; /* [n_face] of meshes these alone, by number or name, with * and ? */
    size_t n_face;           /* 0: everything */
    double length;  /* of cells; INFINITY: triangles as they are; 0: a part of their size */
    uint32_t uv[2]; /* columns and rows over the texture; 0: cells of a length */
};

/* RMAP_USAGE when there would be too many, RMAP_INPUT when there are none. */
enum rmap_status rmap_irradiance_cells_create(const struct rmap_scene *scene,
                                              const struct rmap_irradiance_choice *choice,
                                              struct rmap_irradiance_cells **cells_ret,
                                              struct rmap_error *err) RMAP_MUST_USE;
void rmap_irradiance_cells_destroy(struct rmap_irradiance_cells *cells); /* NULL is fine */

/* The cell of a part in which light arrives: place in the world, and primitive of the object.
 * SIZE_MAX: in none. */
size_t rmap_irradiance_cells_find(const struct rmap_irradiance_cells *cells, size_t part,
                                  struct rmap_vec3 place, int32_t primitive);

#endif

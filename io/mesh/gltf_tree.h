/* SPDX-License-Identifier: MIT
 *
 * A glTF file as the tree that it is: named nodes in places, meshes that several of them share, and
 * what the file says of materials.
 */
#ifndef RMAP_GLTF_TREE_H
#define RMAP_GLTF_TREE_H

#include "io/mesh/mesh_builder.h"

struct rmap_gltf_node {
    char *name; /* "": it has none */
    struct rmap_affine place;
    int32_t parent, mesh; /* -1: none */
};

struct rmap_gltf_mesh {
    char *name;
    struct rmap_mesh *mesh; /* NULL: no node has it, or it has no triangles */
    int32_t *material;      /* [n_face]; -1: none */
    struct rmap_mesh_left_out left_out;
};

/* As glTF has them: colours and factors are linear; KHR_materials_transmission and _ior. What says
 * nothing of metal is none, though glTF's default is 1: it is a guess at what things are. Blended
 * ones (alphaMode) let light through, unless their colour covers all. */
struct rmap_gltf_material {
    char *name;
    double colour[3], metalness, roughness, transmission, index;
};

struct rmap_gltf_tree {
    size_t n_node, n_mesh, n_material, cap_node;
    struct rmap_gltf_node *node; /* parents before their children */
    struct rmap_gltf_mesh *mesh;
    struct rmap_gltf_material *material;
};

/* Of a file's bytes, lengths scaled. RMAP_INPUT, without the path, when they are none; RMAP_SYSTEM.
 * Zero-initialise; call rmap_gltf_tree_fini in any case. */
enum rmap_status rmap_gltf_read_tree(const char *path, const uint8_t *bytes, size_t nbytes,
                                     double scale, struct rmap_gltf_tree *tree,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_gltf_tree_fini(struct rmap_gltf_tree *tree);

#endif

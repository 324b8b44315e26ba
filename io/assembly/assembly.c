/* SPDX-License-Identifier: MIT
 *
 * Assemblies in memory.
 */
#include "io/assembly/assembly.h"

#include <string.h>

#include "base/alloc.h"

void rmap_assembly_shape_fini(struct rmap_assembly_shape *shape)
{
    for (size_t i = 0; shape->face && i < shape->n_face; i++) {
        rmap_free(shape->face[i].name);
        rmap_free(shape->face[i].material);
    }
    rmap_free(shape->face);
    rmap_free(shape->id);
    rmap_free(shape->name);
    rmap_free(shape->file);
    rmap_free(shape->made);
    rmap_mesh_destroy(shape->mesh);
}

void rmap_assembly_fini(struct rmap_assembly *assembly)
{
    for (size_t i = 0; i < assembly->n_shape; i++)
        rmap_assembly_shape_fini(&assembly->shape[i]);
    for (size_t i = 0; i < assembly->n_part; i++) {
        rmap_free(assembly->part[i].id);
        rmap_free(assembly->part[i].name);
        rmap_free(assembly->part[i].label);
        rmap_free(assembly->part[i].material);
    }
    for (size_t i = 0; i < assembly->n_material; i++)
        rmap_free(assembly->material[i].name);
    for (size_t i = 0; i < assembly->n_touch; i++)
        for (int k = 0; k < 2; k++)
            rmap_free(assembly->touch[i].part[k]);
    rmap_free(assembly->shape);
    rmap_free(assembly->part);
    rmap_free(assembly->material);
    rmap_free(assembly->touch);
    rmap_free(assembly->source);
    rmap_free(assembly->schema);
    rmap_free(assembly->writer);
    rmap_free(assembly->file_unit);
    rmap_diagnostics_fini(&assembly->findings);
    *assembly = (struct rmap_assembly){0};
}

struct rmap_assembly_part *rmap_assembly_add_part(struct rmap_assembly *assembly, const char *id,
                                                  const char *name, int32_t parent,
                                                  struct rmap_error *err)
{
    if (assembly->n_part >= RMAP_ASSEMBLY_PARTS_MAX) {
        (void)rmap_error_set(err, RMAP_INPUT, "it has more than %d parts", RMAP_ASSEMBLY_PARTS_MAX);
        return NULL;
    }
    if (RMAP_RESERVE(assembly->part, assembly->cap_part, assembly->n_part + 1, err) != RMAP_OK)
        return NULL;
    struct rmap_assembly_part *part = &assembly->part[assembly->n_part++];
    *part = (struct rmap_assembly_part){.id = rmap_strdup(id ? id : ""),
                                        .name = rmap_strdup(name ? name : ""),
                                        .parent = parent,
                                        .shape = -1,
                                        .place = rmap_affine_identity()};
    if (part->id && part->name)
        return part;
    (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu parts", assembly->n_part);
    return NULL;
}

struct rmap_assembly_shape *rmap_assembly_add_shape(struct rmap_assembly *assembly, const char *id,
                                                    const char *name, struct rmap_error *err)
{
    if (RMAP_RESERVE(assembly->shape, assembly->cap_shape, assembly->n_shape + 1, err) != RMAP_OK)
        return NULL;
    struct rmap_assembly_shape *shape = &assembly->shape[assembly->n_shape++];
    *shape = (struct rmap_assembly_shape){.id = rmap_strdup(id ? id : ""),
                                          .name = rmap_strdup(name ? name : "")};
    if (shape->id && shape->name)
        return shape;
    (void)rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu shapes", assembly->n_shape);
    return NULL;
}

const struct rmap_assembly_material *rmap_assembly_material(const struct rmap_assembly *assembly,
                                                            const char *name)
{
    for (size_t i = 0; name && i < assembly->n_material; i++)
        if (strcmp(assembly->material[i].name, name) == 0)
            return &assembly->material[i];
    return NULL;
}

struct rmap_affine rmap_assembly_world(const struct rmap_assembly *assembly, size_t part)
{
    struct rmap_affine world = assembly->part[part].place;
    for (int32_t up = assembly->part[part].parent; up >= 0; up = assembly->part[up].parent)
        world = rmap_affine_compose(&assembly->part[up].place, &world);
    return world;
}

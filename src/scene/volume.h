/* SPDX-License-Identifier: MIT
 *
 * Places in a body, along a track, or in the cells of a grid, from which light starts in all
 * directions.
 */
#ifndef RMAP_VOLUME_H
#define RMAP_VOLUME_H

#include <stddef.h>
#include <stdint.h>

#include "base/status.h"
#include "base/vec.h"
#include "gradient/grid.h"

struct rmap_scene;
struct rmap_source;

enum rmap_volume_kind {
    RMAP_VOLUME_BODY,  /* the source's `frame` carries the unit cube to the box about it, in the
                          frame of its first part */
    RMAP_VOLUME_TRACK, /* `frame` carries (0, 0, 0) and (0, 0, 1) to its ends */
    RMAP_VOLUME_GRID   /* in proportion to the numbers of cells about the nodes */
};

struct rmap_volume {
    enum rmap_volume_kind kind;
    int32_t on_object, on_group; /* BODY; both -1: the body is not in the scene */
    struct rmap_grid *grid;      /* GRID; held */
    double *below;               /* GRID: [nodes] sum of the numbers up to and with each */
    /* Derived by rmap_volume_finish. */
    int32_t *part; /* BODY: [n_part] objects that close it */
    size_t n_part;
    bool is_lens; /* the inside is what differs from the medium outside */
};

void rmap_volume_fini(struct rmap_volume *volume);

/* RMAP_INPUT: a number below 0, or none above. */
enum rmap_status rmap_volume_take_grid(struct rmap_volume *volume, struct rmap_grid *grid,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* Parts and box of a body whose objects have their inverse transforms. RMAP_INPUT when it is not
 * there or nothing is found inside. */
enum rmap_status rmap_volume_finish(const struct rmap_scene *scene, struct rmap_source *source,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* The medium inside a body, on whose inner sides all of its parts have the same; -1: they have
 * none, or several. */
int32_t rmap_volume_medium(const struct rmap_scene *scene, const struct rmap_volume *volume);

/* Where ray `ray` starts, in the world. Part of the compact encoding: of +, -, x, / and square
 * roots alone, and to stay as it is. */
struct rmap_vec3 rmap_volume_draw(const struct rmap_scene *scene, const struct rmap_source *source,
                                  uint64_t seed, uint64_t ray);

#endif

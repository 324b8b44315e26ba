/* SPDX-License-Identifier: MIT
 *
 * Optical constants of what is no medium of its own: layers of films, particles.
 */
#ifndef RMAP_SCENE_CONSTANTS_H
#define RMAP_SCENE_CONSTANTS_H

#include "io/scene/scene_glass.h"
#include "io/scene/scene_reader.h"

/* As they are written. */
struct rmap_constants {
    struct rmap_glass glass; /* with a name: of the catalogue */
    struct rmap_table1 n, k; /* with rows: of a table of the scene */
    double index, loss;
    bool has_glass;
};

double rmap_constants_index(const struct rmap_constants *its, double wavelength_nm);
double rmap_constants_loss(const struct rmap_constants *its, double wavelength_nm);

/* Of the keys `material`, `n` and `k`, or `table`. `kind` and `name` ("film", "ar") are told where
 * the scene's light goes beyond them, `what` ("a layer") where a key is missing. False after a
 * complaint. *its is empty. */
bool rmap_reader_constants(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           const char *kind, const char *name, const char *what,
                           struct rmap_constants *its);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Glasses in a scene file: of the catalogue, with what is meant by a name that it does not have,
 * and by coefficients.
 */
#ifndef RMAP_SCENE_GLASS_H
#define RMAP_SCENE_GLASS_H

#include "io/scene/scene_reader.h"
#include "optics/catalogue.h"

/* The glass of a name. False after a complaint, which names the nearest media and glasses. */
bool rmap_reader_find_glass(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            const char *name, struct rmap_glass *glass);

/* The material that `key` of the mapping, `glass` or `metal`, names. False after a complaint. */
bool rmap_reader_material(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          const char *key, struct rmap_glass *glass);

/* Warns where the scene has light outside the range of data, with what comes of it. */
void rmap_reader_warn_outside(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                              const char *kind, const char *name, double from_nm, double to_nm,
                              const char *consequence);

/* {B: [..], C: [..]}, with C brought to um^2 from the square of unit_um. False after a complaint.
 */
bool rmap_reader_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_glass *glass);

/* Whether a value is the word `catalogue`. */
bool rmap_reader_is_catalogue(const struct rmap_yaml_node *node);

#endif

/* SPDX-License-Identifier: MIT
 *
 * What must be set in one scene's text to make it another: the `set:` of a simulation.
 */
#ifndef RMAP_YAML_DIFFERENCE_H
#define RMAP_YAML_DIFFERENCE_H

#include <stdio.h>

#include "io/scene/yaml_tree.h"

/* Writes a line "INDENT key.path: value" for each difference; how many. `simulations` is passed
 * over. Errors of `out` are its owner's to find. */
size_t rmap_yaml_difference(const struct rmap_yaml_node *base, const struct rmap_yaml_node *other,
                            const char *indent, FILE *out);

#endif

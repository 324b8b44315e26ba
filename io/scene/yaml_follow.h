/* SPDX-License-Identifier: MIT
 *
 * A tree that follows a change of its text.
 */
#ifndef RMAP_YAML_FOLLOW_H
#define RMAP_YAML_FOLLOW_H

#include "io/scene/yaml_tree.h"

/* Where a node's value stood (`from`), another (`to`, in one line) was written: the tree becomes
 * what rmap_yaml_parse makes of the changed text, if it has no anchors and includes no files.
 * false, and it is as it was: the old value had several lines or none, the new one is no YAML, or
 * memory is short. */
bool rmap_yaml_follow(struct rmap_yaml_node *root, struct rmap_yaml_node *node, const char *from,
                      size_t from_nbytes, const char *to, size_t to_nbytes);

#endif

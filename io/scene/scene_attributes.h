/* SPDX-License-Identifier: MIT
 *
 * `attributes:` rules that give objects, and faces of their meshes, surfaces and media by what they
 * are called, so that these outlive the text of the objects. They change the tree before objects
 * are read.
 */
#ifndef RMAP_SCENE_ATTRIBUTES_H
#define RMAP_SCENE_ATTRIBUTES_H

#include "io/scene/scene_reader.h"

/* The groups that an object is in, from the innermost on. */
struct rmap_attribute_above {
    const struct rmap_attribute_above *next;
    const char *name;
};

/* Whether the object has all that a rule's `match` asks for, but for its colour and faces. */
bool rmap_attribute_fits(const struct rmap_yaml_node *match, const struct rmap_yaml_node *object,
                         const struct rmap_attribute_above *above);

/* Once geometries are read. */
void rmap_reader_apply_attributes(struct rmap_reader *reader);

/* Once objects are read: warns of rules that fit nothing. */
void rmap_reader_check_attributes(struct rmap_reader *reader);

/* The rule that made an item of `faces`; NULL: none did. */
struct rmap_attribute_rule *rmap_reader_rule_of(struct rmap_reader *reader,
                                                const struct rmap_yaml_node *item);

/* `color` and `material` of an object, of which rules alone know. */
void rmap_reader_check_labels(struct rmap_reader *reader, const struct rmap_yaml_node *node);

#endif

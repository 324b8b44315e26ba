/* SPDX-License-Identifier: MIT
 *
 * From where to where a node of a tree stands in its text.
 */
#ifndef RMAP_YAML_SPAN_H
#define RMAP_YAML_SPAN_H

#include "io/scene/yaml_tree.h"

/* Of a node, or of a key with its value. */
struct rmap_yaml_span {
    size_t first, end; /* bytes; end: behind the last of its content */
    size_t before;     /* behind the last content before it in its block */
    int column;        /* of the first, from 0 */
    bool flow, empty;
    bool in_flow; /* of the mapping or list that has it */
};

/* Of the n_node nodes (2: a key and its value) of which the first begins at that place in the text
 * whose tree that is. false: none does. */
bool rmap_yaml_span(const char *text, const struct rmap_yaml_node *root, int line, int column,
                    bool is_scalar, int n_node, struct rmap_yaml_span *span);

/* So many bytes end a line there, as libyaml counts lines; 0: none. */
size_t rmap_yaml_line_break(const char *text);

#endif

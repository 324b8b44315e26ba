/* SPDX-License-Identifier: MIT
 *
 * A YAML text as a tree whose every node knows its line and column, with limits that keep hostile
 * text harmless: depth, number of nodes, expansion of aliases.
 */
#ifndef RMAP_YAML_TREE_H
#define RMAP_YAML_TREE_H

#include <stdbool.h>
#include <stddef.h>

#include "base/pool.h"
#include "base/status.h"
#include "io/file/diagnostics.h"

#define RMAP_YAML_DEPTH_MAX 64
#define RMAP_YAML_TOO_DEEP  "nested too deeply (at most 64 levels)"
#define RMAP_YAML_NO_ANCHOR "an alias refers to nothing that is complete before it"
#define RMAP_YAML_NODE_MAX  4000000 /* about 1 GiB of tree */
#define RMAP_YAML_COPY_MAX  1000000 /* nodes that aliases may add */

enum rmap_yaml_kind { RMAP_YAML_SCALAR, RMAP_YAML_LIST, RMAP_YAML_MAP };

struct rmap_yaml_node;

/* Of a list (key NULL) or a mapping. */
struct rmap_yaml_item {
    char *key;
    int line, column; /* of the key; of the value in a list */
    struct rmap_yaml_node *value;
};

struct rmap_yaml_node {
    enum rmap_yaml_kind kind;
    int line, column; /* from 1; below: not from the file but the -line-th --set */
    bool quoted;      /* SCALAR: written in quotes */
    bool aliased;     /* a copy, which stands in the place of an alias */
    bool merged;      /* a copy, with a key that '<<' brings */
    char *text;       /* SCALAR */
    size_t n_item, cap_item;
    struct rmap_yaml_item *item;
    struct rmap_pool *pool; /* of its tree: memory of its nodes, items and texts */
};

/* Builds the tree. A text that is not one YAML document puts what is wrong into diagnostics and
 * gives RMAP_INPUT; duplicate keys are put there too, and the first one stands. */
enum rmap_status rmap_yaml_parse(const char *text, size_t nbytes, struct rmap_yaml_node **root_ret,
                                 struct rmap_diagnostics *diagnostics,
                                 struct rmap_error *err) RMAP_MUST_USE;
void rmap_yaml_destroy(struct rmap_yaml_node *root); /* of a whole tree; NULL is fine */

/* An empty plain scalar, ~ or null. */
bool rmap_yaml_is_nothing(const struct rmap_yaml_node *node);

/* Value of a key; NULL when node is no mapping, has no such key, or nothing stands behind it. */
struct rmap_yaml_node *rmap_yaml_get(const struct rmap_yaml_node *node, const char *key);

/* Applies "key.path=value" (value: YAML). Items of a list are addressed by their name or by their
 * number from 1; missing keys are added. A path that leads nowhere is put into diagnostics. line:
 * of what it adds. */
enum rmap_status rmap_yaml_edit(struct rmap_yaml_node *root, const char *assignment, int line,
                                struct rmap_diagnostics *diagnostics,
                                struct rmap_error *err) RMAP_MUST_USE;

/* The same with a value of the tree itself, which is copied: of `set:` of a simulation, whose line
 * and column it is. */
enum rmap_status rmap_yaml_put(struct rmap_yaml_node *root, const struct rmap_yaml_item *assignment,
                               struct rmap_diagnostics *diagnostics,
                               struct rmap_error *err) RMAP_MUST_USE;

/* A copy whose nodes have the same places, for the tree of `in`. RMAP_SYSTEM. */
enum rmap_status rmap_yaml_copy(const struct rmap_yaml_node *in, const struct rmap_yaml_node *from,
                                struct rmap_yaml_node **node_ret,
                                struct rmap_error *err) RMAP_MUST_USE;

/* The same of at most *n_left nodes, from a depth on; they are counted down. RMAP_INPUT: there are
 * more, or it is nested too deeply, as err says. */
enum rmap_status rmap_yaml_copy_some(const struct rmap_yaml_node *in,
                                     const struct rmap_yaml_node *from, int depth, size_t *n_left,
                                     struct rmap_yaml_node **node_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* A tree of one empty node. NULL when memory is short. */
struct rmap_yaml_node *rmap_yaml_create(void);

/* A tree of its own that is the same. RMAP_SYSTEM. */
enum rmap_status rmap_yaml_duplicate(const struct rmap_yaml_node *root,
                                     struct rmap_yaml_node **root_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* A list or mapping without items for the tree of `in`; NULL when memory is short. */
struct rmap_yaml_node *rmap_yaml_new(const struct rmap_yaml_node *in, enum rmap_yaml_kind kind,
                                     int line, int column);

/* Takes an item out. */
void rmap_yaml_remove(struct rmap_yaml_node *node, size_t index);

/* Whether n letters are keys with a dot between each two, and no more of them than a tree is deep.
 */
bool rmap_yaml_is_path(const char *path, size_t n);

/* What a path of such an edit leads to, as far as the tree has it; *rest_ret: what of the path is
 * not there, "" where nothing is missing; *item_ret (or NULL): whose value it is, untouched where
 * that is the root. */
const struct rmap_yaml_node *rmap_yaml_find(const struct rmap_yaml_node *root, const char *path,
                                            const char **rest_ret,
                                            const struct rmap_yaml_item **item_ret);

/* The first item on a path's way that is written elsewhere, for others too: for an alias, or by
 * '<<'; NULL: none is. *rest_ret: what of the path is behind it; *in_ret: what has it, of '<<'. */
const struct rmap_yaml_item *rmap_yaml_find_shared(const struct rmap_yaml_node *root,
                                                   const char *path, const char **rest_ret,
                                                   const struct rmap_yaml_node **in_ret);

/* The nearest name among a mapping's keys or a list's items to the head of a path, or NULL. */
const char *rmap_yaml_nearest(const struct rmap_yaml_node *node, const char *path);

/* Appends an item; the value is of the same tree, the key (which may be NULL) is copied.
 * RMAP_SYSTEM. */
enum rmap_status rmap_yaml_append(struct rmap_yaml_node *node, const char *key, int line,
                                  int column, struct rmap_yaml_node *value,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

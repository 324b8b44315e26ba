/* SPDX-License-Identifier: MIT
 *
 * The automata of the paths of all criteria that share definitions: paths of one text are one
 * automaton, and all together are bounded in time and memory.
 */
#ifndef RMAP_PATH_STORE_H
#define RMAP_PATH_STORE_H

#include "analysis/criterion/criterion_parser.h"

struct rmap_path_store;

/* Held once. NULL: no memory. */
struct rmap_path_store *rmap_path_store_create(void);
struct rmap_path_store *rmap_path_store_hold(struct rmap_path_store *store);
void rmap_path_store_release(struct rmap_path_store *store); /* NULL is fine */

/* The automaton of the string token, for the parser's scene; the store's. RMAP_INPUT: the path is
 * wrong, or too much with those that are there. */
enum rmap_status rmap_path_store_table(struct rmap_path_store *store, struct rmap_parser *parser,
                                       const struct rmap_token *string,
                                       const struct rmap_path_table **table_ret) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Named criteria: a text of `let NAME = CRITERION`, one after another, used as @NAME. A '#'
 * begins a comment up to the line's end.
 */
#ifndef RMAP_CRITERION_FILE_H
#define RMAP_CRITERION_FILE_H

#include "analysis/criterion/criterion.h"

/* Immutable, thread-safe. */
struct rmap_criteria;

/* What messages call criteria that stand in no file. */
#define RMAP_CRITERION_LABEL "criterion"

/* label: what messages call the text, as a file's name; both are copied. Definitions are told
 * apart, not yet understood: that needs a scene. RMAP_INPUT: "LABEL:LINE:COLUMN: error: ...". */
enum rmap_status rmap_criteria_create(const char *text, const char *label,
                                      struct rmap_criteria **criteria_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_criteria_destroy(struct rmap_criteria *criteria);

/* In the order of the text; 1 at least. */
size_t rmap_criteria_count(const struct rmap_criteria *criteria);
const char *rmap_criteria_name(const struct rmap_criteria *criteria, size_t index);
const char *rmap_criteria_definition(const struct rmap_criteria *criteria, size_t index);

/* The criterion text that asks for it: @NAME, quoted where it must be. */
const char *rmap_criteria_reference(const struct rmap_criteria *criteria, size_t index);

/* The text of a compiled criterion with what its @names stand for, definitions (NULL: none) or rays
 * of the map, so that it means the same wherever it stands; as it is written where that would be
 * longer than 64 KiB. *text_ret: rmap_free. */
enum rmap_status rmap_criterion_spell(const struct rmap_criterion *criterion,
                                      const struct rmap_criteria *criteria, char **text_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Index of a name, or SIZE_MAX. */
size_t rmap_criteria_find(const struct rmap_criteria *criteria, const char *name);

#endif

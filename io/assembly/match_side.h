/* SPDX-License-Identifier: MIT
 *
 * What parts of a revision are looked for by: hashes of their ids, names and contents, and places.
 */
#ifndef RMAP_MATCH_SIDE_H
#define RMAP_MATCH_SIDE_H

#include "io/assembly/assembly.h"

/* A part by what it is looked for. */
struct rmap_part_key {
    uint64_t value;
    int32_t part;
};

struct rmap_match_side {
    const struct rmap_assembly *assembly;
    int32_t *known;             /* [n_part] its part of the other side; -1: none yet */
    struct rmap_part_key *key;  /* of what is not matched yet, sorted by value */
    struct rmap_part_key *name; /* [n_part] all, sorted by name */
    uint64_t *id; /* [n_part] of its own step of the path, without the count that made it unique */
    uint64_t *content; /* [n_part] of the shape; of a group, of what is in it */
    int *depth;
    struct rmap_affine *world;
};

/* By value, then by part; for qsort. */
int rmap_part_key_compare(const void *a, const void *b);

uint64_t rmap_match_text(const char *text);
uint64_t rmap_match_mix(uint64_t a, uint64_t b); /* never 0 */

/* Of its assembly; nothing is known of any part. by_form: shapes are the same wherever they lie in
 * their frames. RMAP_SYSTEM; fini in any case, which leaves `known`. */
enum rmap_status rmap_match_side_begin(struct rmap_match_side *side, bool by_form,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_match_side_fini(struct rmap_match_side *side);

/* A body of several that have no names, but are counted: "X 2" in "X", with the id ".../2". */
bool rmap_assembly_is_numbered(const struct rmap_assembly *assembly, size_t part);

bool rmap_assembly_has_forms(const struct rmap_assembly *assembly);

#endif

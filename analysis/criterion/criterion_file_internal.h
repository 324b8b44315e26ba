/* SPDX-License-Identifier: MIT */
#ifndef RMAP_CRITERION_FILE_INTERNAL_H
#define RMAP_CRITERION_FILE_INTERNAL_H

#include "analysis/criterion/criterion_file.h"

struct rmap_let {
    char *name, *definition, *reference;
    size_t name_begin, name_end; /* bytes of the text */
    size_t begin, end;           /* of the definition; `end` where the next `let` begins */
};

struct rmap_path_store;

struct rmap_criteria {
    char *text; /* comments are blanks */
    char *label;
    struct rmap_let *let; /* [n] */
    size_t n, cap;
    size_t *slot; /* [n_slot] 1 + let by its name's hash, 0: free; n_slot is a power of two */
    size_t n_slot;
    struct rmap_path_store *paths; /* of all criteria that are compiled with these definitions */
};

#endif

/* SPDX-License-Identifier: MIT */
#ifndef RMAP_CRITERION_FILE_INTERNAL_H
#define RMAP_CRITERION_FILE_INTERNAL_H

#include "analysis/criterion_file.h"

struct rmap_let {
    char *name, *definition, *reference;
    size_t name_begin, name_end; /* bytes of the text */
    size_t begin, end;           /* of the definition; `end` where the next `let` begins */
};

struct rmap_criteria {
    char *text; /* comments are blanks */
    char *label;
    struct rmap_let *let; /* [n] */
    size_t n, cap;
};

#endif

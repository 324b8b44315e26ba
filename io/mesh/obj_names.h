/* SPDX-License-Identifier: MIT
 *
 * Names of parts in a Wavefront OBJ file. assimp cuts some at a blank and takes parts whose first
 * words are the same for one: it is given a text in which they are numbers.
 */
#ifndef RMAP_OBJ_NAMES_H
#define RMAP_OBJ_NAMES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

struct rmap_obj_names {
    uint8_t *text; /* the file, whose `o` and `g` lines name parts "part:0", "part:1", ... */
    size_t nbytes;
    size_t n, cap;
    char **name; /* [n] what they were called */
};

/* Each `o` is a part of its own; a `g` that comes again below one `o` goes on with its part. Bytes
 * behind which stands a 0; zero-initialise, fini in any case. RMAP_SYSTEM. */
enum rmap_status rmap_obj_names_read(const uint8_t *bytes, size_t nbytes,
                                     struct rmap_obj_names *names,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_obj_names_fini(struct rmap_obj_names *names);

/* The number of a part that is called so in the text; -1: it has none. */
int32_t rmap_obj_part(const struct rmap_obj_names *names, const char *name);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Which part of a revision is which part of the one before, and what became of it.
 */
#ifndef RMAP_ASSEMBLY_MATCH_H
#define RMAP_ASSEMBLY_MATCH_H

#include "io/assembly/assembly.h"

enum rmap_part_change {
    RMAP_PART_MOVED = 1,
    RMAP_PART_RESHAPED = 2,
    RMAP_PART_RENAMED = 4,
    RMAP_PART_RECOLOURED = 8 /* or of another material */
};

struct rmap_assembly_match {
    int32_t *from;    /* [parts of the new one] its part of the old one; -1: it is new */
    unsigned *change; /* [the same] */
    int32_t *to;      /* [parts of the old one]; -1: it is gone */
    bool *kept;       /* [shapes of the new one] the mesh file of the old one serves */
};

/* By id where the name or the shape agrees; then by the names from the root on, where these are
 * unique; then by the shape, the nearest first; then by the id alone. RMAP_SYSTEM. */
enum rmap_status rmap_assembly_match(const struct rmap_assembly *before,
                                     const struct rmap_assembly *after,
                                     struct rmap_assembly_match *match,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_assembly_match_fini(struct rmap_assembly_match *match);

/* Parts that were there keep their names in the scene. Shapes keep their files: those that are as
 * they were (`kept`), and those of a part that changed, if nothing else has the file. */
enum rmap_status rmap_assembly_adopt(const struct rmap_assembly *before,
                                     struct rmap_assembly *after, struct rmap_assembly_match *match,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif

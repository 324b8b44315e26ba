/* SPDX-License-Identifier: MIT
 *
 * Which part of a revision is which part of the one before, and what became of it.
 */
#ifndef RMAP_ASSEMBLY_MATCH_H
#define RMAP_ASSEMBLY_MATCH_H

#include "io/assembly/assembly.h"

enum rmap_part_change {
    RMAP_PART_MOVED = 1, /* or turned */
    RMAP_PART_RESHAPED = 2,
    RMAP_PART_RENAMED = 4,
    RMAP_PART_RECOLOURED = 8, /* or of another material */
    RMAP_PART_REGROUPED = 16,
    RMAP_PART_SCALED = 32
};

/* From the old place to the new one, in the parent's frame where it is the same parent. */
struct rmap_part_motion {
    double distance; /* mm, of the origin */
    double turn;     /* degrees */
    double scale;    /* of lengths, < 0: mirrored */
};

struct rmap_assembly_match {
    int32_t *from;                   /* [parts of the new one] its part of the old one; -1: new */
    unsigned *change;                /* [the same] */
    struct rmap_part_motion *motion; /* [the same] */
    int32_t *to;                     /* [parts of the old one]; -1: it is gone */
    bool *kept; /* [shapes of the new one] the mesh file of the old one serves */
};

/* A body's copies share a shape in the frame of the first of them. Where the first is another one
 * now, or gone, shapes that are an old one in another frame, as a part that did not move shows, get
 * the old one's, and their parts' places follow. */
void rmap_assembly_keep_frames(const struct rmap_assembly *before, struct rmap_assembly *after);

/* Under parents that are the same, from the root on: by id where the name or the shape agrees, by
 * name, by shape and place; among equal ids or names place and shape decide. Groups by what is in
 * them. Then wherever they are: by name where it is unique, by shape, the nearest first; at last
 * by the id alone. RMAP_SYSTEM. */
enum rmap_status rmap_assembly_match(const struct rmap_assembly *before,
                                     const struct rmap_assembly *after,
                                     struct rmap_assembly_match *match,
                                     struct rmap_error *err) RMAP_MUST_USE;
void rmap_assembly_match_fini(struct rmap_assembly_match *match);

/* Fills change and motion of the parts that are matched. */
void rmap_assembly_find_changes(const struct rmap_assembly *before,
                                const struct rmap_assembly *after,
                                struct rmap_assembly_match *match);

/* Whether two places differ beyond rounding. */
bool rmap_assembly_is_apart(const struct rmap_affine *a, const struct rmap_affine *b);

/* Parts that were there keep their names and numbers in the scene. Shapes keep their files: those
 * that are as they were (`kept`), and those of a part that changed, if nothing else has the file.
 */
enum rmap_status rmap_assembly_adopt(const struct rmap_assembly *before,
                                     struct rmap_assembly *after, struct rmap_assembly_match *match,
                                     struct rmap_error *err) RMAP_MUST_USE;

#endif

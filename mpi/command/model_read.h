/* SPDX-License-Identifier: MIT
 *
 * A model of a CAD program, read: STEP and IGES by raymap-step, a program of its own that is
 * started for it; glTF, OBJ, STL and PLY by ourselves.
 */
#ifndef RMAP_MODEL_READ_H
#define RMAP_MODEL_READ_H

#include "io/assembly/assembly.h"

#define RMAP_MODEL_MADE "model" /* in the folder that is made, where raymap-step writes */

struct rmap_model_request {
    const char *path;
    const char *folder;        /* in which meshes are made, in a folder of their own */
    const char *chord, *angle; /* for raymap-step, in mm and degrees; NULL: as it likes */
    const char *unit;          /* of the lengths of files that have none; "": mm */
    bool is_update;            /* nobody asks what touches */
    double scale;              /* of the unit, to mm */
};

/* Whether the name ends as one of them. */
bool rmap_model_is_one(const char *path);

/* A folder of mesh files that are not yet where they belong. */
struct rmap_model_made {
    char *folder; /* NULL: there are none */
    int lock;     /* by which others see that it is in use */
};

/* Removes what imports into the same folder that were killed have left there. *made: for
 * rmap_model_clean in any case; zeroed before. RMAP_INPUT: it is no such file, with what is wrong;
 * RMAP_SYSTEM, also where raymap-step is not here. Not collective. */
enum rmap_status rmap_model_read(const struct rmap_model_request *request,
                                 struct rmap_assembly *assembly, struct rmap_model_made *made,
                                 struct rmap_error *err) RMAP_MUST_USE;

/* Removes the folder and what is left in it. Zeroed: fine. */
void rmap_model_clean(struct rmap_model_made *made);

#endif

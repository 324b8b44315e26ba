/* SPDX-License-Identifier: MIT
 *
 * What a program that stays has in memory of the one map or scene that its commands are about: they
 * take that where they would open it by its name.
 */
#ifndef RMAP_AT_HAND_H
#define RMAP_AT_HAND_H

#include "io/map/map_reader.h"

/* Of a command that can be run again and again, with the same arguments, until it is done. */
struct rmap_at_hand_steps {
    double seconds; /* that a run may take, about */
    void *state;    /* what the next run goes on with; NULL: it begins, or is done */
    void (*destroy)(void *state);
};

struct rmap_at_hand {
    const char *path;                  /* the name; other names are files as ever */
    struct rmap_map *map;              /* lent to each command (rmap_map_lend) */
    const char *text;                  /* of the scene as it is by now */
    const struct rmap_yaml_node *root; /* its tree, without mistakes; NULL: it is to be read */
    const struct rmap_bundle *bundle;  /* its meshes and tables; NULL: none were read yet */
    bool is_map;                       /* these are all there are: no file is read */
    void (*progressed)(void *context, double share); /* of long work, on rank 0; NULL: untold */
    void *context;
    struct rmap_at_hand_steps *steps; /* of the command in hand; NULL: it is done in one run */
};

#endif

/* SPDX-License-Identifier: MIT
 *
 * What a server has in memory, the same on every rank: a scene's text with its undo list, the
 * scene, and the rays traced of it so far, or of a map.
 */
#ifndef RMAP_SERVE_STATE_H
#define RMAP_SERVE_STATE_H

#include <jansson.h>

#include "accel/accel.h"
#include "io/scene/scene_text.h"
#include "mpi/command/command.h"
#include "mpi/parallel/at_hand.h"
#include "mpi/serve/serve_cancel.h"
#include "mpi/serve/serve_queue.h"
#include "mpi/trace/trace_reuse.h"

enum { RMAP_SERVE_RENDERS = 4 }; /* pictures at once; each has a structure of the scene */

enum rmap_serve_trace_state {
    RMAP_SERVE_NONE,
    RMAP_SERVE_RUNNING,
    RMAP_SERVE_PAUSED,
    RMAP_SERVE_DONE,
    RMAP_SERVE_STOPPED,
    RMAP_SERVE_FAILED
};

/* A detector that the last edit moved and that lies on something, and where it stood before; -1:
 * there is none. */
struct rmap_serve_lying {
    int32_t detector;
    struct rmap_vec3 place;
};

struct rmap_serve {
    struct rmap_context context; /* what commands are run with */
    struct rmap_at_hand at_hand;
    struct rmap_map *map;
    struct rmap_bundle *bundle; /* of at_hand, without a text */
    struct rmap_accel *accel;   /* of the map's scene; NULL: not yet */
    /* Of before the last edits: what the scene still has of it is taken over. NULL: none. */
    struct rmap_map *last; /* with rays */
    int n_useless;         /* scenes in a row that had nothing of its rays */
    struct rmap_accel *last_accel;
    struct rmap_reuse reuse; /* of `last`, while a trace goes on */
    int isa_level;

    struct rmap_scene_text *text; /* [n_text] of the scene, oldest first; `now` is its number */
    size_t n_text, cap_text, now, saved;
    bool is_mixed;     /* the map that was opened has several colour spaces */
    char *saved_as;    /* of a map: the file of its scene; NULL: none yet */
    uint64_t revision; /* goes up with every change */
    uint64_t edited;   /* that the last edit led to */
    struct rmap_serve_lying lying;

    enum rmap_serve_trace_state state;
    uint64_t n_ray; /* that are wanted */
    uint64_t seed;
    uint64_t n_begun;              /* traces, and scenes that have taken the place of theirs */
    double pace;                   /* rays per second of late, 0: unknown */
    double seconds;                /* of tracing */
    uint64_t n_reused;             /* rays that were taken over */
    char why[RMAP_ERROR_TEXT_LEN]; /* it failed */

    struct rmap_serve_cancel *cancel;
    struct rmap_at_hand_steps render[RMAP_SERVE_RENDERS]; /* under way */

    /* Of rank 0. */
    struct rmap_serve_queue *queue;
    struct rmap_serve_request *request; /* in hand; NULL: none */
    double sliced;                      /* when the trace came on */
    json_t *details;                    /* more of what is wrong, for the answer's error */
    char *stored;                       /* the scene's text as its files have it; NULL: a map's */
    char *folder;                       /* where it was started: scenes are saved below */
    char *scratch;                      /* a folder of its own; NULL: not yet */
    int capture;                        /* what stands in the place of standard output */
    bool again, quit;                   /* the request is not done yet */
};

#endif

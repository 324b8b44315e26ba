/* SPDX-License-Identifier: MIT
 *
 * Everything that is wrong with a scene: what its reader finds, its bodies, and what rays find.
 */
#ifndef RMAP_SCENE_CHECK_H
#define RMAP_SCENE_CHECK_H

#include "accel/accel.h"
#include "io/mesh/bundle.h"
#include "mpi/command/mismatch.h"

struct rmap_scene_checked {
    struct rmap_scene *scene; /* NULL: it cannot be read */
    struct rmap_mismatch_effort effort;
    size_t n_read;                 /* warnings of its reading alone */
    double read_s;                 /* grows by the time of its reading */
    struct rmap_accel_build build; /* where rays were sent */
};

/* By one rank. Adds to the diagnostics, whose n_error says whether the scene is refused; *checked
 * is the caller's to finish in any case. RMAP_INPUT: it cannot be read, or a file that it names;
 * RMAP_SYSTEM. */
enum rmap_status rmap_scene_check(struct rmap_bundle *bundle, int n_thread, uint64_t seed,
                                  struct rmap_diagnostics *diagnostics,
                                  struct rmap_scene_checked *checked,
                                  struct rmap_error *err) RMAP_MUST_USE;
void rmap_scene_checked_fini(struct rmap_scene_checked *checked);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Repairing a map on all ranks: verify, mend, until nothing is left to mend.
 */
#ifndef RMAP_REPAIR_RUN_H
#define RMAP_REPAIR_RUN_H

#include "io/map/map_writer.h"
#include "mpi/upkeep/verify_run.h"
#include "portion/ray_plan.h"

enum rmap_repair_mode { RMAP_REPAIR_DO, RMAP_REPAIR_SAY };

/* Rank 0's. */
struct rmap_repair_result {
    struct rmap_findings found; /* at first */
    struct rmap_findings done;  /* in the order in which it was done; "says" alone: nothing */
    struct rmap_findings left;  /* what cannot be mended */
    struct rmap_ray_set lost;   /* that the map said to hold and does not any more */
    uint64_t n_missing;         /* of all rays asked for */
    bool is_picked;             /* by a query: no trace can go on with the map */
    struct rmap_map_summary summary;
    double seconds;
};
void rmap_repair_result_fini(struct rmap_repair_result *result);

/* Collective. scene: on rank 0, with bundle and scene set, for a map without a usable index; NULL:
 * not given. With RMAP_REPAIR_SAY nothing is changed. No trace may be writing to the map. A kill at
 * any moment leaves a map that can be repaired again. The caller finishes the result, in any case.
 */
enum rmap_status rmap_repair_run(const struct rmap_context *context, const char *path,
                                 const struct rmap_run *scene, enum rmap_repair_mode mode,
                                 struct rmap_repair_result *result,
                                 struct rmap_error *err) RMAP_MUST_USE;

#endif

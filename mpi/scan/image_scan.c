/* SPDX-License-Identifier: MIT
 *
 * A detector's sums over the rays that match a criterion, portions scattered over ranks and
 * threads.
 */
#include "mpi/scan/image_scan.h"

#include "mpi/scan/fold_run.h"

enum rmap_status rmap_image_scan(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_choice *choice, struct rmap_detector_sums *sums,
                                 struct rmap_error *err)
{
    const struct rmap_fold fold = {.kind = &rmap_detector_sums_kind,
                                   .context = &sums->ask,
                                   .map = map,
                                   .criterion = choice->criterion,
                                   .which = choice->which,
                                   .columns = rmap_detector_sums_columns(&sums->ask),
                                   .only_detector = 1 + sums->ask.detector,
                                   .overlay = sums->ask.overlay};
    void *state = NULL;
    enum rmap_status st = rmap_fold_run(context, &fold, &state, err);
    if (state)
        rmap_detector_sums_merge(sums, state);
    fold.kind->destroy(state);
    return st;
}

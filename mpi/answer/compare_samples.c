/* SPDX-License-Identifier: MIT
 *
 * The samples of a comparison: two; or, of one map, what criterion A has alone, what B has alone,
 * and what both have.
 */
#include "mpi/answer/compare_samples.h"

#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

enum rmap_status rmap_compare_samples_run(const struct rmap_context *context,
                                          const struct rmap_compare_samples *samples,
                                          const struct rmap_compare_sum *sum, void **state,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *more = NULL;
    for (size_t i = 0; i < samples->n_part; i++) {
        const struct rmap_compare_part *part = &samples->part[i];
        const int k = rmap_compare_map_of(samples, part->sample);
        if (part->sample >= sum->n_sample || (part->registrations_alone && !sum->alone))
            continue;
        const struct rmap_fold fold = {.kind = sum->kind,
                                       .context =
                                           part->registrations_alone ? sum->alone : sum->context[k],
                                       .map = samples->map[k],
                                       .overlay = samples->overlay[k],
                                       .criterion = part->criterion,
                                       .which = sum->alone ? part->which : NULL,
                                       .columns = sum->columns[k]};
        RMAP_TRY(rmap_fold_run(context, &fold, &more, err));
        void **into = &state[part->sample];
        if (!*into) {
            *into = more;
            more = NULL;
        } else if (more) {
            st = sum->kind->merge(*into, more, err);
        }
        sum->kind->destroy(more);
        more = NULL;
        RMAP_TRY(rmap_agree(context, st, err));
    }
out:
    return st;
}

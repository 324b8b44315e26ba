/* SPDX-License-Identifier: MIT
 *
 * Rays that match a criterion about receivers (--receivers): counted, and by their ids, so that
 * whatever reads rays of a map by their ids goes on from there.
 */
#include "mpi/scan/overlay_pick.h"

#include "analysis/stats/group_count.h"
#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

enum rmap_status rmap_overlay_count_run(const struct rmap_context *context,
                                        const struct rmap_overlay_question *question,
                                        struct rmap_count *count, struct rmap_error *err)
{
    void *state = NULL;
    const struct rmap_group_counting counting = rmap_group_counting(
        rmap_scene_with(question->map, question->overlay), RMAP_STATS_TOGETHER, NULL);
    const struct rmap_fold fold = {.kind = &rmap_group_count_kind,
                                   .context = &counting,
                                   .map = question->map,
                                   .criterion = question->criterion,
                                   .columns = rmap_group_count_columns(&counting),
                                   .overlay = question->overlay};
    enum rmap_status st = rmap_fold_run(context, &fold, &state, err);
    if (state)
        rmap_group_counts_read(state, 0, count);
    fold.kind->destroy(state);
    count->portions_read = rmap_overlay_n_read(question->overlay, question->criterion);
    count->nbytes_read = UINT64_MAX;
    return st;
}

/* Collective. */
static enum rmap_status share_ids(const struct rmap_context *context,
                                  const struct rmap_sample_fold *found, uint64_t **id_ret,
                                  size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t *id = NULL;
    size_t nbytes = 0;
    if (found)
        st = rmap_sample_ids(&found->sample, &id, err);
    if (found && st == RMAP_OK)
        nbytes = found->sample.n * sizeof *id;
    RMAP_TRY(rmap_agree(context, st, err));
    uint8_t *blob = (uint8_t *)id;
    st = rmap_broadcast_blob(context, &blob, &nbytes, err);
    id = (uint64_t *)(void *)blob;
    RMAP_TRY(st);
    *id_ret = id;
    *n_ret = nbytes / sizeof *id;
    id = NULL;
out:
    rmap_free(id);
    return st;
}

enum rmap_status rmap_overlay_pick(const struct rmap_context *context,
                                   const struct rmap_overlay_question *question,
                                   const struct rmap_sample_order *order, uint64_t **id_ret,
                                   size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    struct rmap_sample_order own = *order;
    if (order->most == UINT64_MAX) {
        own.most = RMAP_OVERLAY_PICK_MOST;
        own.or_none = true;
    }
    const struct rmap_fold fold = {.kind = &rmap_sample_kind,
                                   .context = &own,
                                   .map = question->map,
                                   .criterion = question->criterion,
                                   .columns = RMAP_SAMPLE_COLUMNS,
                                   .overlay = question->overlay};
    RMAP_TRY(rmap_fold_run(context, &fold, &state, err));
    RMAP_TRY(share_ids(context, state, id_ret, n_ret, err));
out:
    rmap_sample_kind.destroy(state);
    return st;
}

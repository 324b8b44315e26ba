/* SPDX-License-Identifier: MIT
 *
 * The statistics of a whole map, on all ranks and threads.
 */
#include "mpi/scan/stats_run.h"

#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/scan/fold_run.h"

void rmap_stats_answer_fini(struct rmap_stats_answer *answer)
{
    rmap_stats_destroy(answer->stats);
    rmap_stats_plan_fini(&answer->plan);
    *answer = (struct rmap_stats_answer){0};
}

static struct rmap_fold fold_of(const struct rmap_stats_request *request,
                                const struct rmap_fold_kind *kind, const void *context)
{
    const struct rmap_quantities *quantities = request->setup->quantities;
    return (struct rmap_fold){.kind = kind,
                              .context = context,
                              .map = quantities->map,
                              .overlay = quantities->overlay,
                              .criterion = request->criterion,
                              .which = request->which,
                              .columns = quantities->columns,
                              .deferred = quantities->deferred};
}

/* Readings in memory, shared out over the threads of rank 0. */
struct sharing {
    const struct rmap_stats_plan *plan;
    const struct rmap_stats_gathered *gathered;
    void **state; /* [n_thread] */
};

static enum rmap_status add_share(void *context, int thread, size_t first, size_t last,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct sharing *sharing = context;
    for (size_t p = first; p < last && st == RMAP_OK; p++) {
        const struct rmap_stats_block block = rmap_stats_gathered_block(sharing->gathered, p);
        st = rmap_stats_sums_add(sharing->state[thread], &block, err);
    }
    return st;
}

/* Portions that a thread takes at once. */
enum { SHARE = 16 };

static enum rmap_status sum_in_memory(const struct rmap_context *context,
                                      const struct rmap_stats_plan *plan,
                                      const struct rmap_stats_gathered *gathered, void **sums_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_fold_kind *kind = &rmap_stats_sums_kind;
    struct sharing sharing = {.plan = plan, .gathered = gathered};
    size_t n_share = gathered->n_part / SHARE + 1;
    size_t n_thread = (size_t)context->n_thread;
    n_thread = n_share < n_thread ? n_share : n_thread;
    struct rmap_parts parts = {
        .last = gathered->n_part, .step = SHARE, .context = &sharing, .work = add_share};
    sharing.state = rmap_alloc(n_thread, sizeof *sharing.state);
    if (!sharing.state)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu threads", n_thread);
    for (size_t t = 0; t < n_thread; t++)
        RMAP_TRY(kind->create(plan, &sharing.state[t], err));
    RMAP_TRY(rmap_parts_run(&parts, (int)n_thread, err));
    for (size_t t = 1; t < n_thread; t++)
        RMAP_TRY(kind->merge(sharing.state[0], sharing.state[t], err));
    *sums_ret = sharing.state[0];
    sharing.state[0] = NULL;
out:
    for (size_t t = 0; t < n_thread; t++)
        kind->destroy(sharing.state[t]);
    rmap_free(sharing.state);
    return st;
}

/* Collective. What rank 0 knows after the first look, to all: known, then the ranges. */
static enum rmap_status share_known(const struct rmap_context *context,
                                    const struct rmap_stats_request *request,
                                    const struct rmap_stats_gathered *gathered,
                                    struct rmap_stats_known *known, struct rmap_stats_range *range,
                                    struct rmap_error *err)
{
    const size_t n = request->setup->n_group * request->setup->quantities->n;
    size_t nbytes = sizeof *known + n * sizeof *range;
    enum rmap_status st = RMAP_OK;
    uint8_t *blob = NULL;
    if (context->rank == 0) {
        blob = rmap_alloc(nbytes, 1);
        if (!blob)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for ranges");
    }
    if (blob) {
        memcpy(blob, &gathered->known, sizeof *known);
        memcpy(blob + sizeof *known, gathered->range, n * sizeof *range);
    }
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
    memcpy(known, blob, sizeof *known);
    memcpy(range, blob + sizeof *known, n * sizeof *range);
out:
    rmap_free(blob);
    return st;
}

/* Collective. The plan is the same on every rank. */
static enum rmap_status make_plan(const struct rmap_context *context,
                                  const struct rmap_stats_request *request,
                                  const struct rmap_stats_gathered *gathered,
                                  struct rmap_stats_plan *plan, bool *in_memory,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = request->setup->n_group * request->setup->quantities->n;
    struct rmap_stats_known known;
    struct rmap_stats_range *range = rmap_alloc(n + 1, sizeof *range);
    if (!range)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for ranges");
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(share_known(context, request, gathered, &known, range, err));
    *in_memory = !known.dropped;
    st = rmap_stats_plan_init(plan, request->setup, &known, range, request->axis, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_free(range);
    return st;
}

enum rmap_status rmap_stats_run(const struct rmap_context *context,
                                const struct rmap_stats_request *request,
                                struct rmap_stats_answer *answer, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *gathered = NULL, *sums = NULL;
    bool in_memory = false;
    const struct rmap_fold first = fold_of(request, &rmap_stats_gather_kind, request->setup);
    const struct rmap_fold second = fold_of(request, &rmap_stats_sums_kind, &answer->plan);
    *answer = (struct rmap_stats_answer){0};
    st = rmap_stats_check_bins(request->setup, request->axis, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_fold_run(context, &first, &gathered, err));
    RMAP_TRY(make_plan(context, request, gathered, &answer->plan, &in_memory, err));
    if (!in_memory)
        RMAP_TRY(rmap_fold_run(context, &second, &sums, err));
    if (context->rank == 0 && in_memory)
        st = sum_in_memory(context, &answer->plan, gathered, &sums, err);
    if (context->rank == 0 && st == RMAP_OK)
        st = rmap_stats_create(&answer->plan, gathered, sums, request->p, request->n_quantile,
                               &answer->stats, err);
    RMAP_TRY(rmap_agree(context, st, err));
out:
    rmap_stats_sums_kind.destroy(sums);
    rmap_stats_gather_kind.destroy(gathered);
    return st;
}

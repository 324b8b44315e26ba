/* SPDX-License-Identifier: MIT
 *
 * The rays of a picture that several criteria share.
 */
#include "mpi/answer/draw_pick.h"

#include <stdlib.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/overlay_pick.h"
#include "mpi/scan/ray_sample.h"

/* share[k]: of the matching[k] rays that criterion k has; the rarest is served first. */
static void deal_shares(const uint64_t *matching, size_t n, uint64_t most, uint64_t *share)
{
    for (size_t k = 0; k < n; k++)
        share[k] = UINT64_MAX;
    for (size_t served = 0; served < n; served++) {
        size_t rarest = n;
        for (size_t k = 0; k < n; k++)
            if (share[k] == UINT64_MAX && (rarest == n || matching[k] < matching[rarest]))
                rarest = k;
        const uint64_t due = (most + n - served - 1) / (n - served);
        share[rarest] = matching[rarest] < due ? matching[rarest] : due;
        most -= share[rarest];
    }
}

/* Collective. */
static enum rmap_status pick_one(const struct rmap_context *context,
                                 const struct rmap_draw_question *question,
                                 const struct rmap_criterion *criterion, uint64_t most,
                                 uint64_t **id_ret, size_t *n_ret, struct rmap_error *err)
{
    const struct rmap_sample_order order = {.most = most};
    const struct rmap_overlay_question receivers = {question->map, question->overlay, criterion};
    const struct rmap_pick pick = {.criterion = criterion};
    return question->overlay ? rmap_overlay_pick(context, &receivers, &order, id_ret, n_ret, err)
                             : rmap_ray_sample(context, question->map, &pick, RMAP_DEAL_SHARES,
                                               &order, id_ret, n_ret, err);
}

static int ascending(const void *a, const void *b)
{
    const uint64_t left = *(const uint64_t *)a, right = *(const uint64_t *)b;
    return (left > right) - (left < right);
}

/* Collective. */
static enum rmap_status find_shares(const struct rmap_context *context,
                                    const struct rmap_draw_question *question, uint64_t *share,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = question->n_criterion;
    uint64_t *matching = rmap_alloc(n + 1, sizeof *matching);
    if (!matching)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", n);
    for (size_t k = 0; k < n && st == RMAP_OK && context->rank == 0; k++)
        matching[k] = question->matching[k].rays;
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(RMAP_MPI(MPI_Bcast(matching, (int)n, MPI_UINT64_T, 0, context->comm)));
    deal_shares(matching, n, question->most, share);
out:
    rmap_free(matching);
    return st;
}

struct ids {
    uint64_t *id; /* [n], ascending, each once */
    size_t n;
};

/* Collective. The criterion's first rays join those that are picked: `share` of them, and no more
 * than there is room for. */
static enum rmap_status add_rays(const struct rmap_context *context,
                                 const struct rmap_draw_question *question,
                                 const struct rmap_criterion *criterion, uint64_t share,
                                 struct ids *all, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_before = all->n;
    uint64_t *id = NULL, *longer = NULL;
    size_t n = 0;
    RMAP_TRY(pick_one(context, question, criterion, share, &id, &n, err));
    longer = rmap_realloc(all->id, all->n + n + 1, sizeof *longer);
    if (!longer)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", all->n + n);
    else
        all->id = longer;
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t i = 0; i < n && all->n < question->most; i++)
        if (!bsearch(&id[i], all->id, n_before, sizeof *id, ascending))
            all->id[all->n++] = id[i];
    qsort(all->id, all->n, sizeof *all->id, ascending);
out:
    rmap_free(id);
    return st;
}

enum rmap_status rmap_draw_pick(const struct rmap_context *context,
                                const struct rmap_draw_question *question, uint64_t **id_ret,
                                size_t *n_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct ids all = {.id = rmap_alloc(1, sizeof *all.id)};
    uint64_t *share = rmap_alloc(question->n_criterion + 1, sizeof *share);
    if (!all.id || !share)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the shares of criteria");
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(find_shares(context, question, share, err));
    for (size_t k = 0; k < question->n_criterion; k++)
        if (share[k] > 0)
            RMAP_TRY(add_rays(context, question, question->criterion[k], share[k], &all, err));
    if (all.n < question->most && question->n_criterion > 1) /* rays of several count once */
        RMAP_TRY(add_rays(context, question, question->any, question->most, &all, err));
    *n_ret = all.n;
    *id_ret = all.id;
    all.id = NULL;
out:
    rmap_free(all.id);
    rmap_free(share);
    return st;
}

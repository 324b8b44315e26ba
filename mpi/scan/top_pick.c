/* SPDX-License-Identifier: MIT
 *
 * The rays that match and have the greatest values of a quantity.
 */
#include "mpi/scan/top_pick.h"

#include <stdlib.h>

#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"

static int by_key(const void *a, const void *b)
{
    const struct rmap_sample_ray *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

enum rmap_status rmap_top_pick(const struct rmap_context *context,
                               const struct rmap_top_question *question,
                               struct rmap_sample_ray **ray_ret, size_t *n_ret,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    void *state = NULL;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    const struct rmap_sample_order order = {.most = question->most, .of = question->of};
    const struct rmap_fold fold = {.kind = &rmap_sample_kind,
                                   .context = &order,
                                   .map = question->map,
                                   .criterion = question->criterion,
                                   .which = question->which,
                                   .columns = RMAP_SAMPLE_COLUMNS | question->of->columns,
                                   .overlay = question->overlay};
    RMAP_TRY(rmap_fold_run(context, &fold, &state, err));
    if (state) {
        struct rmap_sample *sample = &((struct rmap_sample_fold *)state)->sample;
        if (sample->n > 0)
            qsort(sample->ray, sample->n, sizeof *sample->ray, by_key);
        nbytes = sample->n * sizeof *sample->ray;
        blob = (uint8_t *)sample->ray;
        sample->ray = NULL;
    }
    RMAP_TRY(rmap_broadcast_blob(context, &blob, &nbytes, err));
    *ray_ret = (struct rmap_sample_ray *)(void *)blob;
    *n_ret = nbytes / sizeof **ray_ret;
    blob = NULL;
out:
    rmap_free(blob);
    rmap_sample_kind.destroy(state);
    return st;
}

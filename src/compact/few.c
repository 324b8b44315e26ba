/* SPDX-License-Identifier: MIT
 *
 * The rays of a portion that have to be traced again to find what their paths do not predict.
 */
#include "compact/few.h"

#include "base/alloc.h"

void rmap_few_destroy(struct rmap_few *few)
{
    if (!few)
        return;
    rmap_portion_destroy(few->rows);
    rmap_free(few);
}

static void add(struct rmap_few *few, size_t ray, bool sample)
{
    few->ray[few->n] = (uint32_t)ray;
    few->sample[few->n++] = sample;
}

bool rmap_few_choose(struct rmap_few *few, const struct rmap_compact_model *model, uint64_t seed,
                     const struct rmap_portion *portion)
{
    const struct rmap_unpredicted *unpredicted = portion->unpredicted;
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY], k = 0, n_sample = 0;
    few->n = 0;
    if (!model->predicts || !unpredicted || unpredicted->seed != seed ||
        unpredicted->n > RMAP_UNPREDICTED_MAX || unpredicted->n > n_ray / 4)
        return false;
    uint64_t first = portion->first_ray, block = first / RMAP_BLOCK_RAYS;
    for (size_t next = (size_t)((block - first) % RMAP_FEW_STRIDE);
         next < n_ray && n_sample < RMAP_FEW_SAMPLES; next += RMAP_FEW_STRIDE, n_sample++) {
        for (; k < unpredicted->n && unpredicted->ray[k] < next; k++)
            add(few, unpredicted->ray[k], false);
        if (k == unpredicted->n || unpredicted->ray[k] != next)
            add(few, next, true);
    }
    for (; k < unpredicted->n; k++)
        add(few, unpredicted->ray[k], false);
    return true;
}

enum rmap_status rmap_few_gather(struct rmap_few *few, const struct rmap_portion *portion,
                                 const uint8_t *channel, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t segment = 0, registration = 0, i = 0;
    if (!few->rows)
        RMAP_TRY(rmap_portion_create(1, portion->n_channel, &few->rows, err));
    rmap_portion_clear(few->rows);
    for (size_t k = 0; k < few->n; k++) {
        for (; i < few->ray[k]; i++) {
            segment += portion->ray.segment_count[i];
            registration += portion->ray.registration_count[i];
        }
        few->first_segment[k] = segment;
        few->first_registration[k] = registration;
        few->channel[k] = channel[i];
        RMAP_TRY(rmap_portion_append_ray(few->rows, portion, i, segment, registration, err));
    }
out:
    return st;
}

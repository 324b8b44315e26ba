/* SPDX-License-Identifier: MIT
 *
 * What classes registered in cells of detectors.
 */
#include "analysis/paths/path_count_internal.h"

/* Numbers of a cell's entry: the last ray, and what it brought so far in weights. */
enum { LAST_RAY, LAST_COUNT };

static struct rmap_key cell_key(struct rmap_key class, int32_t detector, uint32_t cell)
{
    return (struct rmap_key){class.low,
                             UINT64_C(1) << 63 | (uint64_t)(uint32_t)detector << 32 | cell};
}

struct rmap_path_cell rmap_path_cell_of(const struct rmap_key_sum *entry)
{
    return (struct rmap_path_cell){entry->key.low, (int32_t)(entry->key.high >> 32 & INT32_MAX),
                                   (uint32_t)entry->key.high};
}

/* The ray's k-th registration in the cell makes its contribution k w: (k w)^2 - ((k - 1) w)^2. */
static enum rmap_status add_cell(struct rmap_path_counts *self, struct rmap_key key, uint64_t ray,
                                 double weight, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key_sum *sum = NULL;
    RMAP_TRY(rmap_key_sums_enter(&self->cells, key, &sum, err));
    if (!sum) {
        rmap_path_counts_drop_cells(self);
        goto out;
    }
    bool again = sum->number[LAST_COUNT] > 0 && sum->number[LAST_RAY] == ray;
    uint64_t k = again ? sum->number[LAST_COUNT] + 1 : 1;
    sum->number[LAST_RAY] = ray;
    sum->number[LAST_COUNT] = k;
    sum->weight += weight;
    sum->weight_squared += (2.0 * (double)k - 1.0) * weight * weight;
out:
    return st;
}

enum rmap_status rmap_path_counts_add_hits(struct rmap_path_counts *self,
                                           const struct rmap_portion *portion, size_t k,
                                           uint64_t *n_hit, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = self->context;
    const struct rmap_detector *detector =
        rmap_scene_with(context->map, context->overlay)->detector;
    const struct rmap_registration_columns *hit = &portion->registration;
    const struct rmap_path_keyed *keyed = &self->buffers->hasher.keyed;
    const struct rmap_key key = rmap_path_key_at(keyed, k);
    const size_t row = keyed->ray[k];
    const size_t until = keyed->until ? keyed->until[k] : 0;
    const size_t first = until ? until - 1 : keyed->registration[k];
    const size_t last =
        until ? until : keyed->registration[k] + portion->ray.registration_count[row];
    *n_hit = 0;
    for (size_t i = first; i < last; i++) {
        int32_t d = hit->detector[i];
        if (!hit->registered[i] || (context->detector >= 0 && d != context->detector))
            continue;
        ++*n_hit;
        if (self->cells_full || context->most_cells == 0)
            continue;
        uint32_t cell = hit->cell[2 * i] + hit->cell[2 * i + 1] * detector[d].cells[0];
        RMAP_TRY(add_cell(self, cell_key(key, d, cell), portion->ray.id[row],
                          portion->ray.weight[row], err));
    }
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Classes of two states in one.
 */
#include "analysis/path_count_internal.h"

static enum rmap_status merge_class(struct rmap_path_counts *into,
                                    const struct rmap_path_counts *from, size_t class,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t before = into->classes.n;
    size_t n;
    RMAP_TRY(rmap_path_counts_add_class(into, &from->classes.entry[class], err));
    if (into->classes.n <= before)
        return RMAP_OK;
    const rmap_path_step *step = rmap_path_steps_of(&from->steps, class, &n);
    if (step)
        st = rmap_path_steps_add(&into->steps, before, step, n, err);
out:
    return st;
}

static enum rmap_status merge_classes(struct rmap_path_counts *into,
                                      const struct rmap_path_counts *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_key_sum *entry = from->classes.entry;
    const size_t n = from->classes.n;
    into->steps.is_closed = true;
    if (from->is_full)
        RMAP_TRY(rmap_path_counts_spill(into, err));
    for (size_t i = 0; i < n; i++) {
        if (i + 2 * RMAP_PATH_AHEAD < n)
            rmap_key_sums_expect(&into->classes, entry[i + 2 * RMAP_PATH_AHEAD].key);
        if (i + RMAP_PATH_AHEAD < n)
            rmap_key_sums_expect_entry(&into->classes, entry[i + RMAP_PATH_AHEAD].key);
        RMAP_TRY(merge_class(into, from, i, err));
    }
    if (from->sketch.rays)
        rmap_path_sketch_merge(&into->sketch, &from->sketch);
out:
    return st;
}

static enum rmap_status merge_cells(struct rmap_path_counts *into,
                                    const struct rmap_path_counts *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (from->cells_full)
        rmap_path_counts_drop_cells(into);
    for (size_t i = 0; i < from->cells.n && !into->cells_full; i++) {
        const struct rmap_key_sum *more = &from->cells.entry[i];
        struct rmap_key_sum *sum = NULL;
        RMAP_TRY(rmap_key_sums_enter(&into->cells, more->key, &sum, err));
        if (!sum) {
            rmap_path_counts_drop_cells(into);
            break;
        }
        sum->weight += more->weight;
        sum->weight_squared += more->weight_squared;
    }
out:
    return st;
}

enum rmap_status rmap_path_counts_merge(void *into_, const void *from_, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_counts *into = into_;
    const struct rmap_path_counts *from = from_;
    rmap_count_add(&into->total, &from->total, rmap_map_scene(into->context->map)->n_source);
    if (from->most_weight > into->most_weight)
        into->most_weight = from->most_weight;
    RMAP_TRY(merge_classes(into, from, err));
    st = merge_cells(into, from, err);
out:
    return st;
}

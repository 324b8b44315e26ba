/* SPDX-License-Identifier: MIT
 *
 * Classes of two states in one.
 */
#include "analysis/paths/path_count_internal.h"
#include "base/alloc.h"

/* number: of its steps. Some come twice: they are the same. */
static enum rmap_status merge_class(struct rmap_path_counts *into,
                                    const struct rmap_path_tally *from, size_t class,
                                    uint32_t number, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_added added;
    const struct rmap_class_sum sum = rmap_class_sums_at(&from->classes, class);
    size_t n;
    const rmap_path_step *step = rmap_path_steps_at(&from->steps, number, &n);
    RMAP_TRY(rmap_path_counts_add_class(into, &sum, &added, err));
    if (step && added.class != RMAP_KEY_SLOTS_NONE && added.before < 2)
        st = rmap_path_steps_add(&into->tally.steps, added.class, step, n, err);
out:
    return st;
}

static void expect_next(const struct rmap_class_sums *classes, const struct rmap_class_entry *entry,
                        size_t n)
{
    uint64_t mixed[RMAP_PATH_TOGETHER];
    n = n < RMAP_PATH_TOGETHER ? n : RMAP_PATH_TOGETHER;
    for (size_t i = 0; i < n; i++)
        mixed[i] = rmap_key_mixed(entry[i].key);
    rmap_key_slots_expect(&classes->slots, mixed, n);
    rmap_key_slots_expect_entries(&classes->slots, classes->entry, sizeof *classes->entry, mixed,
                                  n);
}

static enum rmap_status merge_tally(struct rmap_path_counts *into,
                                    const struct rmap_path_tally *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = from->classes.n;
    uint32_t *number = NULL;
    RMAP_TRY(rmap_path_steps_index(&from->steps, n, &number, err));
    for (size_t i = 0; i < n; i++) {
        if (i % RMAP_PATH_TOGETHER == 0)
            expect_next(&into->tally.classes, from->classes.entry + i, n - i);
        RMAP_TRY(merge_class(into, from, i, number[i], err));
    }
out:
    rmap_free(number);
    return st;
}

static enum rmap_status merge_classes(struct rmap_path_counts *into,
                                      const struct rmap_path_counts *from, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (from->is_full)
        RMAP_TRY(rmap_path_counts_spill(into, err));
    rmap_path_counts_take_cache(into, from->cache);
    RMAP_TRY(merge_tally(into, &from->tally, err));
    if (from->sketch.rays)
        rmap_path_sketch_merge(&into->sketch, &from->sketch);
out:
    return st;
}

/* The pool's classes become the state's, with those that it has itself. */
enum rmap_status rmap_path_counts_settle(void *counts, struct rmap_error *err)
{
    struct rmap_path_counts *self = counts;
    struct rmap_path_pool *pool = self->pool;
    self->pool = NULL;
    if (!pool)
        return RMAP_OK;
    if (pool->is_full)
        return rmap_path_counts_spill(self, err);
    if (self->is_full) /* by paths of an index, which it counts itself */
        return rmap_path_counts_outline(self, &pool->tally.classes, err);
    struct rmap_path_tally own = self->tally;
    self->tally = pool->tally;
    pool->tally = (struct rmap_path_tally){0};
    rmap_path_counts_take_cache(self, self->cache);
    rmap_path_counts_drop_cache(self);
    const enum rmap_status st = merge_tally(self, &own, err);
    rmap_path_tally_fini(&own);
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

enum rmap_status rmap_path_counts_merge(void *into_, void *from_, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_counts *into = into_;
    const struct rmap_path_counts *from = from_;
    rmap_count_add(&into->total, &from->total, rmap_map_scene(into->context->map)->n_source);
    into->again.rays += from->again.rays;
    into->again.segments += from->again.segments;
    if (from->most_weight > into->most_weight)
        into->most_weight = from->most_weight;
    RMAP_TRY(merge_classes(into, from, err));
    st = merge_cells(into, from, err);
out:
    return st;
}

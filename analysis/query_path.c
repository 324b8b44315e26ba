/* SPDX-License-Identifier: MIT */
#include "analysis/query_path.h"

#include <string.h>

#include "analysis/path_table.h"
#include "base/alloc.h"
#include "base/wide.h"

void rmap_query_path_fini(struct rmap_query_path *self)
{
    rmap_free(self->ray);
    rmap_free(self->row_class);
    rmap_free(self->begins);
    rmap_free(self->match);
    rmap_free(self->wanted);
    rmap_portion_destroy(self->rays);
    *self = (struct rmap_query_path){0};
}

static enum rmap_status reserve(struct rmap_query_path *self, const struct rmap_history_view *view,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    size_t n_class = rmap_history_n_class(view->index), n_hit = rmap_history_n_hit(view->index);
    void *begins = self->begins, *ray = self->ray, *match = self->match, *wanted = self->wanted;
    if (!self->rays && !(self->rays = rmap_alloc(1, sizeof *self->rays)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    RMAP_TRY(rmap_reserve(&ray, &self->ray_cap, n_ray + 1, sizeof *self->ray, err));
    self->ray = ray;
    RMAP_TRY(rmap_reserve(&begins, &self->begins_cap, n_ray + 1, 1, err));
    self->begins = begins;
    RMAP_TRY(rmap_reserve(&match, &self->match_cap, n_ray + 1, 1, err));
    self->match = match;
    RMAP_TRY(
        rmap_reserve(&wanted, &self->wanted_cap, (n_class > n_hit ? n_class : n_hit) + 1, 1, err));
    self->wanted = wanted;
out:
    return st;
}

/* Of the listed rays, those that have a step that is needed. */
static size_t keep_steps(struct rmap_query_path *self, const struct rmap_history_view *view,
                         const struct rmap_path_need *need, const uint16_t *symbol, size_t n)
{
    for (size_t k = 0; k < rmap_history_n_class(view->index); k++)
        self->wanted[k] = need->has[symbol[k]];
    return rmap_history_keep(view, self->wanted, self->ray, n);
}

/* Those that have a registration; count [n_ray] is used on the way. */
static size_t keep_hits(struct rmap_query_path *self, const struct rmap_history_view *view,
                        const struct rmap_path_table *table, const struct rmap_path_need *need,
                        size_t n, uint32_t *count)
{
    const struct rmap_history_hit *hit = rmap_history_hits(view->index);
    size_t n_kept = 0;
    for (size_t k = 0; k < rmap_history_n_hit(view->index); k++) {
        size_t detector = (uint32_t)hit[k].detector < table->n_detector ? (size_t)hit[k].detector
                                                                        : table->n_detector;
        self->wanted[k] = hit[k].registered && need->has[table->symbol_of_hit[detector]];
    }
    rmap_history_count_hits(view, self->wanted, count);
    for (size_t i = 0; i < n; i++) {
        self->ray[n_kept] = self->ray[i];
        n_kept += count[self->ray[i].ray] > 0;
    }
    return n_kept;
}

/* Whether a registration may come before a ray's first step. */
static bool has_free_hits(const struct rmap_history_view *view, const struct rmap_path_table *table)
{
    const struct rmap_history_hit *hit = rmap_history_hits(view->index);
    bool free = false;
    for (size_t k = 0; k < rmap_history_n_hit(view->index); k++)
        free |= (uint32_t)hit[k].detector >= table->n_detector ||
                !table->follows_object[hit[k].detector];
    return free;
}

RMAP_WIDE static void add_empty(const uint32_t *restrict count, size_t n, bool is_empty,
                                uint8_t *restrict begins)
{
    for (size_t i = 0; i < n; i++)
        begins[i] |= (count[i] == 0) == is_empty;
}

/* Lists the rays that begin as a match may; those without legs, and those that may begin with a
 * registration, are not told by a leg. */
static size_t list_beginnings(struct rmap_query_path *self, const struct rmap_history_view *view,
                              const struct rmap_path_table *table, const uint16_t *symbol)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    for (size_t k = 0; k < rmap_history_n_class(view->index); k++)
        self->wanted[k] = table->first[symbol[k]];
    rmap_history_test_first(view, self->wanted, self->begins);
    add_empty(view->segment_count, n_ray, true, self->begins);
    if (view->registration_count && has_free_hits(view, table))
        add_empty(view->registration_count, n_ray, false, self->begins);
    return rmap_history_place_rays(view, self->begins, self->ray);
}

/* Lists the rays that begin so, and have all that is needed; count [n_ray] is used on the way. */
static size_t list_rays(struct rmap_query_path *self, const struct rmap_history_view *view,
                        const struct rmap_path_table *table, const uint16_t *symbol,
                        uint32_t *count)
{
    size_t n = table->first ? list_beginnings(self, view, table, symbol)
                            : rmap_history_place_rays(view, NULL, self->ray);
    for (int k = 0; k < table->n_need && n > 0; k++)
        n = table->need[k].is_hit ? keep_hits(self, view, table, &table->need[k], n, count)
                                  : keep_steps(self, view, &table->need[k], symbol, n);
    return n;
}

/* Puts their rows side by side. */
static enum rmap_status gather(struct rmap_query_path *self, const struct rmap_history_view *view,
                               size_t n, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const rmap_column_set counts =
        RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    const rmap_column_set hits = RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |
                                 RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered) |
                                 RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment);
    size_t n_leg = 0, n_hit = 0;
    void *block = self->row_class;
    for (size_t k = 0; k < n; k++) {
        n_leg += view->segment_count[self->ray[k].ray];
        n_hit += view->registration_count ? view->registration_count[self->ray[k].ray] : 0;
    }
    RMAP_TRY(rmap_reserve(&block, &self->row_class_cap, n_leg + 1, sizeof *self->row_class, err));
    self->row_class = block;
    rmap_portion_clear(self->rays);
    RMAP_TRY(rmap_portion_reserve(self->rays, RMAP_TABLE_RAY, n, counts, err));
    RMAP_TRY(rmap_portion_reserve(self->rays, RMAP_TABLE_REGISTRATION, n_hit, hits, err));
    rmap_history_gather(view, self->ray, n, self->rays, self->row_class);
    self->rays->n_row[RMAP_TABLE_SEGMENT] = n_leg;
    self->rays->first_ray = view->first_ray;
out:
    return st;
}

enum rmap_status rmap_query_path_count(struct rmap_query_path *self,
                                       const struct rmap_history_view *view,
                                       const struct rmap_criterion_node *node,
                                       const uint16_t *symbol, uint32_t *count,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_node own = *node;
    own.interval = (struct rmap_interval){1.0, 1.0, false};
    RMAP_TRY(reserve(self, view, err));
    size_t n = list_rays(self, view, node->path.table, symbol, count);
    memset(count, 0, view->n_row[RMAP_TABLE_RAY] * sizeof *count);
    if (n == 0)
        goto out;
    RMAP_TRY(gather(self, view, n, err));
    const struct rmap_path_rows rows = {.row_class = self->row_class, .symbol = symbol};
    RMAP_TRY(rmap_path_mark_rows(&own, self->rays, &rows, self->match, err));
    for (size_t k = 0; k < n; k++)
        count[self->ray[k].ray] = self->match[k];
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * A test path("...") on a portion of which the history index has the rows: only rays that have all
 * the steps and registrations without which none matches are run through the automaton.
 */
#include "analysis/query/query_path.h"

#include <string.h>

#include "analysis/criterion/path_mark.h"
#include "analysis/criterion/path_table.h"
#include "base/alloc.h"
#include "history/history_gather.h"
#include "history/history_view.h"

void rmap_query_path_fini(struct rmap_query_path *self)
{
    rmap_free(self->may);
    rmap_free(self->ray);
    rmap_free(self->row_class);
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
    if (!self->rays && !(self->rays = rmap_alloc(1, sizeof *self->rays)))
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a scan");
    RMAP_TRY(RMAP_RESERVE(self->may, self->may_cap, 2 * rmap_bit_words(n_ray), err));
    RMAP_TRY(
        RMAP_RESERVE(self->wanted, self->wanted_cap, (n_class > n_hit ? n_class : n_hit) + 1, err));
out:
    return st;
}

/* What is being looked for in a portion. */
struct search {
    struct rmap_query_path *path;
    const struct rmap_history_view *view;
    const struct rmap_path_table *table;
    const uint16_t *symbol; /* of each class of segments */
    size_t n_word;          /* of a bit per ray */
};

/* Bits of segments with one of these symbols, or NULL. */
static const uint64_t *mark_segments(const struct search *search, const uint8_t *has)
{
    uint8_t *wanted = search->path->wanted;
    size_t n_class = rmap_history_n_class(search->view->index);
    for (size_t k = 0; k < n_class; k++)
        wanted[k] = has[search->symbol[k]];
    return rmap_history_mark(search->view, wanted);
}

/* Bits of registrations with one of these symbols, or NULL. */
static const uint64_t *mark_hits(const struct search *search, const uint8_t *has)
{
    const struct rmap_path_table *table = search->table;
    const struct rmap_history_hit *hit = rmap_history_hits(search->view->index);
    uint8_t *wanted = search->path->wanted;
    size_t n_hit = rmap_history_n_hit(search->view->index);
    for (size_t k = 0; k < n_hit; k++) {
        size_t detector = (uint32_t)hit[k].detector < table->n_detector ? (size_t)hit[k].detector
                                                                        : table->n_detector;
        wanted[k] = hit[k].registered && has[table->symbol_of_hit[detector]];
    }
    return rmap_history_mark_hits(search->view, wanted);
}

/* Rays that have a bit in their group stay; false: none do. */
static bool keep(const struct search *search, const uint32_t *n_rows, const uint64_t *bits)
{
    uint64_t *may = search->path->may, *own = may + search->n_word, any = 0;
    if (!bits)
        return false;
    rmap_bits_any_groups(bits, n_rows, search->view->n_row[RMAP_TABLE_RAY], own);
    for (size_t w = 0; w < search->n_word; w++)
        any |= may[w] &= own[w];
    return any != 0;
}

/* Lists the rays that have every step and registration without which there is no match. */
static enum rmap_status list_rays(const struct search *search, size_t *n_ret,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_table *table = search->table;
    struct rmap_query_path *path = search->path;
    const size_t n_ray = search->view->n_row[RMAP_TABLE_RAY];
    const uint32_t *hits = search->view->registration_count;
    bool any = true;
    *n_ret = 0;
    memset(path->may, UINT8_MAX, search->n_word * sizeof *path->may);
    if (n_ray % 64 > 0)
        path->may[search->n_word - 1] &= (UINT64_C(1) << n_ray % 64) - 1;
    for (int k = 0; k < table->n_need && any; k++) {
        const uint8_t *has = table->need[k].has;
        if (table->need[k].is_hit)
            any = hits && keep(search, hits, mark_hits(search, has));
        else
            any = keep(search, search->view->segment_count, mark_segments(search, has));
    }
    if (!any)
        return RMAP_OK;
    RMAP_TRY(RMAP_RESERVE(path->ray, path->ray_cap, n_ray, err));
    *n_ret = rmap_history_place_rays(search->view, path->may, path->ray);
out:
    return st;
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
    size_t n_segment = 0, n_hit = 0;
    for (size_t k = 0; k < n; k++) {
        n_segment += view->segment_count[self->ray[k].ray];
        n_hit += view->registration_count ? view->registration_count[self->ray[k].ray] : 0;
    }
    RMAP_TRY(RMAP_RESERVE(self->row_class, self->row_class_cap, n_segment + 1, err));
    rmap_portion_clear(self->rays);
    RMAP_TRY(rmap_portion_reserve(self->rays, RMAP_TABLE_RAY, n, counts, err));
    RMAP_TRY(rmap_portion_reserve(self->rays, RMAP_TABLE_REGISTRATION, n_hit, hits, err));
    rmap_history_gather(view, self->ray, n, self->rays, self->row_class);
    self->rays->n_row[RMAP_TABLE_SEGMENT] = n_segment;
    self->rays->first_ray = view->first_ray;
out:
    return st;
}

enum rmap_status rmap_query_path_mark(struct rmap_query_path *self,
                                      const struct rmap_history_view *view,
                                      const struct rmap_criterion_node *node,
                                      const uint16_t *symbol, uint64_t *bits,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion_node own = *node;
    struct search search = {.path = self,
                            .view = view,
                            .table = node->path.table,
                            .symbol = symbol,
                            .n_word = rmap_bit_words(view->n_row[RMAP_TABLE_RAY])};
    size_t n = 0;
    own.interval = (struct rmap_interval){1.0, 1.0, false};
    memset(bits, 0, search.n_word * sizeof *bits);
    RMAP_TRY(reserve(self, view, err));
    RMAP_TRY(list_rays(&search, &n, err));
    if (n == 0)
        goto out;
    RMAP_TRY(gather(self, view, n, err));
    RMAP_TRY(RMAP_RESERVE(self->match, self->match_cap, n, err));
    const struct rmap_path_rows rows = {.row_class = self->row_class, .symbol = symbol};
    RMAP_TRY(rmap_path_mark_rows(&own, self->rays, &rows, self->match, err));
    for (size_t k = 0; k < n; k++)
        bits[self->ray[k].ray / 64] |= (uint64_t)self->match[k] << self->ray[k].ray % 64;
out:
    return st;
}

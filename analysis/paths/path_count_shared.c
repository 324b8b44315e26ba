/* SPDX-License-Identifier: MIT
 *
 * Classes by the paths that rays share, as a map's index or a compact piece has them: path by path,
 * not ray by ray.
 */
#include "analysis/paths/path_count.h"

/* Whether ids of the portion's rays matter to the classes of its paths. */
static bool needs_ids(const struct rmap_path_counts *self, const struct rmap_matched *rays)
{
    const struct rmap_path_dictionary *dictionary = &self->dictionary;
    for (size_t k = 0; !self->is_full && k < dictionary->n; k++) {
        const struct rmap_path_known *path = &dictionary->known[dictionary->row[k]];
        if (dictionary->shares.n_ray[k] == 0 || path->key.high == 0)
            continue;
        const struct rmap_key_sum *class = rmap_key_sums_find(&self->classes, path->key);
        if (!class || class->number[RMAP_PATH_CLASS_FIRST_RAY] > rays->view->first_ray)
            return true;
    }
    return false;
}

/* Rays of the k-th path of the portion, which weigh 1. */
static enum rmap_status add_path(struct rmap_path_counts *self, size_t k, struct rmap_error *err)
{
    const struct rmap_path_dictionary *dictionary = &self->dictionary;
    const size_t row = dictionary->row[k];
    const struct rmap_path_known *path = &dictionary->known[row];
    const uint64_t n = dictionary->shares.n_ray[k];
    if (n == 0 || path->key.high == 0)
        return RMAP_OK;
    const size_t source = (size_t)rmap_path_source_of(path->key);
    const struct rmap_key_sum some = {path->key,
                                      (double)n,
                                      (double)n,
                                      {n, dictionary->shares.first[k],
                                       n * dictionary->paths->ray.segment_count[row],
                                       n * path->n_hit}};
    self->total.rays += n;
    self->total.segments += some.number[RMAP_PATH_CLASS_SEGMENTS];
    self->total.source_weight[source] += some.weight;
    self->total.source_weight_squared[source] += some.weight_squared;
    self->most_weight = self->most_weight > 1.0 ? self->most_weight : 1.0;
    return rmap_path_counts_add_class(self, &some, err);
}

static enum rmap_status add_paths(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < self->dictionary.n && st == RMAP_OK; k++)
        st = add_path(self, k, err);
    return st;
}

/* Some rays of the portion have several paths, of which a dictionary knows nothing. */
static bool has_several(const struct rmap_path_counts *self)
{
    const struct rmap_path_dictionary *dictionary = &self->dictionary;
    if (!rmap_path_keys_view(self->context->keys)->until_detector)
        return false;
    for (size_t k = 0; k < dictionary->n; k++)
        if (dictionary->shares.n_ray[k] > 0 && dictionary->known[dictionary->row[k]].n_hit > 1)
            return true;
    return false;
}

static struct rmap_path_keying keying_of(const struct rmap_path_counts *self)
{
    const struct rmap_path_counting *context = self->context;
    return (struct rmap_path_keying){context->keys, context->map, context->detector};
}

enum rmap_status rmap_path_counts_add_view(struct rmap_path_counts *self,
                                           const struct rmap_matched *rays, bool *done_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_keying keying = keying_of(self);
    RMAP_TRY(rmap_path_dictionary_enter_view(&self->dictionary, &keying, rays, err));
    *done_ret = !has_several(self);
    if (!*done_ret)
        goto out;
    if (needs_ids(self, rays)) {
        RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_id), err));
        rmap_path_dictionary_find_first(&self->dictionary, rays);
    }
    st = add_paths(self, err);
out:
    return st;
}

enum rmap_status rmap_path_counts_add_told(struct rmap_path_counts *self,
                                           const struct rmap_matched *rays,
                                           const struct rmap_told_paths *told, bool *done_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_keying keying = keying_of(self);
    struct rmap_matched own;
    RMAP_TRY(rmap_path_dictionary_enter_told(&self->dictionary, &keying, rays, told, err));
    *done_ret = !has_several(self);
    if (!*done_ret)
        goto out;
    RMAP_TRY(add_paths(self, err));
    RMAP_TRY(rmap_path_shares_own(&self->dictionary.shares, rays, told, &own, err));
    if (own.n_match > 0)
        st = rmap_path_counts_add_rays(self, &own, err);
out:
    return st;
}

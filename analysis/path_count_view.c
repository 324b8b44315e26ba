/* SPDX-License-Identifier: MIT
 *
 * Classes by the index of a map: path by path, not ray by ray.
 */
#include "analysis/path_count_internal.h"

/* By a path of an index. */
static enum rmap_status keep_known_steps(struct rmap_path_counts *self,
                                         const struct rmap_portion *paths,
                                         const struct rmap_path_place_of_ray *place,
                                         const struct rmap_path_added *added,
                                         struct rmap_error *err)
{
    size_t n = 0;
    rmap_path_step *to;
    enum rmap_status st = rmap_path_counts_make_room(self, paths, place, added, &to, err);
    if (!to)
        return st;
    (void)rmap_path_key_of(self->context->keys, paths, place, to, &n);
    rmap_path_counts_end_class(self, added, n);
    return st;
}

/* n rays of weight 1 that took a path of the dictionary. */
static struct rmap_key_sum sum_of(const struct rmap_path_known *path, uint64_t n, uint64_t first)
{
    return (struct rmap_key_sum){.key = path->key,
                                 .weight = (double)n,
                                 .weight_squared = (double)n,
                                 .number = {[RMAP_PATH_RAYS] = n,
                                            [RMAP_PATH_SEGMENTS] = n * path->n_leg,
                                            [RMAP_PATH_REGISTRATIONS] = n * path->n_hit,
                                            [RMAP_PATH_FIRST_RAY] = first}};
}

/* Whether ids of the portion's rays matter to the classes of its paths. */
static bool needs_ids(const struct rmap_path_counts *self, const struct rmap_matched *rays)
{
    const struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    for (size_t k = 0; !self->is_full && k < rays->view->n_path; k++) {
        const struct rmap_path_known *path = &dictionary->path[rays->view->path_row[k]];
        if (dictionary->n_ray[k] == 0 || path->key.high == 0)
            continue;
        const struct rmap_key_sum *known = rmap_key_sums_find(&self->classes, path->key);
        if (!known || known->number[RMAP_PATH_FIRST_RAY] > rays->view->first_ray)
            return true;
    }
    return false;
}

enum rmap_status rmap_path_counts_add_view(struct rmap_path_counts *self,
                                           const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_counting *context = self->context;
    const struct rmap_history_view *view = rays->view;
    struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    const size_t piece = (size_t)rmap_map_portion(context->map, rays->index)->piece;
    RMAP_TRY(rmap_path_dictionary_enter(dictionary, &self->buffers->hasher, context->keys,
                                        context->detector, piece, rays, err));
    if (needs_ids(self, rays)) {
        RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_id), err));
        rmap_path_dictionary_find_first(dictionary, rays);
    }
    for (size_t k = 0; k < view->n_path; k++) {
        const struct rmap_path_known *path = &dictionary->path[view->path_row[k]];
        const uint64_t n = dictionary->n_ray[k];
        struct rmap_path_added added;
        if (n == 0 || path->key.high == 0)
            continue;
        const struct rmap_key_sum some = sum_of(path, n, dictionary->first[k]);
        self->total.rays += n;
        self->total.segments += some.number[RMAP_PATH_SEGMENTS];
        self->total.source_weight[path->source] += some.weight;
        self->total.source_weight_squared[path->source] += some.weight_squared;
        self->most_weight = self->most_weight > 1.0 ? self->most_weight : 1.0;
        if (!rmap_path_counts_has(context, path->key))
            continue;
        RMAP_TRY(rmap_path_counts_add_class(self, &some, &added, err));
        if (rmap_path_counts_want_steps(self, &added))
            RMAP_TRY(
                keep_known_steps(self, rmap_history_paths(view->index), &path->place, &added, err));
    }
out:
    return st;
}

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
    enum rmap_status st = rmap_path_tally_make_room(&self->tally, paths, place, added, &to, err);
    if (!to)
        return st;
    (void)rmap_path_key_of(self->context->keys, paths, place, to, &n);
    rmap_path_steps_end_class(&self->tally.steps, added->class, n);
    return st;
}

/* n rays of weight 1 that took a path of the dictionary. */
static struct rmap_class_sum sum_of(const struct rmap_path_known *path, uint64_t n, uint64_t first)
{
    return (struct rmap_class_sum){{.key = path->key, .rays = n, .first_ray = first},
                                   {(double)n, (double)n, n * path->n_leg, n * path->n_hit}};
}

/* Whether ids of the portion's rays matter to the classes of its paths. */
static bool needs_ids(const struct rmap_path_counts *self, const struct rmap_matched *rays)
{
    const struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    const struct rmap_class_sums *classes = &self->tally.classes;
    for (size_t k = 0; !self->is_full && k < rays->view->n_path; k++) {
        const struct rmap_path_known *path = &dictionary->path[rays->view->path_row[k]];
        if (dictionary->n_ray[k] == 0 || path->key.high == 0)
            continue;
        size_t slot;
        const size_t known =
            rmap_class_sums_look(classes, path->key, rmap_key_mixed(path->key), &slot);
        if (known == RMAP_KEY_SLOTS_NONE || classes->entry[known].first_ray > rays->view->first_ray)
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
        const struct rmap_class_sum some = sum_of(path, n, dictionary->first[k]);
        self->total.rays += n;
        self->total.segments += some.more.segments;
        self->total.source_weight[path->source] += some.more.weight;
        self->total.source_weight_squared[path->source] += some.more.weight_squared;
        self->most_weight = self->most_weight > 1.0 ? self->most_weight : 1.0;
        if (!rmap_path_counts_has(context, path->key))
            continue;
        RMAP_TRY(rmap_path_counts_add_class(self, &some, &added, err));
        if (rmap_path_tally_wants_steps(&self->tally, &added))
            RMAP_TRY(
                keep_known_steps(self, rmap_history_paths(view->index), &path->place, &added, err));
    }
out:
    return st;
}

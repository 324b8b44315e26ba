/* SPDX-License-Identifier: MIT
 *
 * Classes by the paths that rays share, as a map's index or a compact piece has them: path by path,
 * not ray by ray.
 */
#include "analysis/paths/path_count_internal.h"

/* By a path of a dictionary. */
static enum rmap_status keep_known_steps(struct rmap_path_counts *self, size_t row,
                                         const struct rmap_path_added *added,
                                         struct rmap_error *err)
{
    const struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    const struct rmap_path_known *path = &dictionary->known[row];
    const struct rmap_path_place_of_ray place = {row, path->segment, path->registration, 0};
    size_t n = 0;
    rmap_path_step *to;
    enum rmap_status st =
        rmap_path_tally_make_room(&self->tally, dictionary->paths, &place, added, &to, err);
    if (!to)
        return st;
    (void)rmap_path_key_of(self->context->keys, dictionary->paths, &place, to, &n);
    rmap_path_steps_end_class(&self->tally.steps, added->class, n);
    return st;
}

/* n rays of weight 1 that took a path of the dictionary. */
static struct rmap_class_sum sum_of(const struct rmap_path_known *path, uint32_t n_leg, uint64_t n,
                                    uint64_t first)
{
    return (struct rmap_class_sum){{.key = path->key, .rays = n, .first_ray = first},
                                   {(double)n, (double)n, n * n_leg, n * path->n_hit}};
}

/* Whether ids of the portion's rays matter to the classes of its paths. */
static bool needs_ids(const struct rmap_path_counts *self, const struct rmap_matched *rays)
{
    const struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    const struct rmap_class_sums *classes = &self->tally.classes;
    for (size_t k = 0; !self->is_full && k < dictionary->n; k++) {
        const struct rmap_path_known *path = &dictionary->known[dictionary->row[k]];
        if (dictionary->shares.n_ray[k] == 0 || path->key.high == 0)
            continue;
        size_t slot;
        const size_t known =
            rmap_class_sums_look(classes, path->key, rmap_key_mixed(path->key), &slot);
        if (known == RMAP_KEY_SLOTS_NONE || classes->entry[known].first_ray > rays->view->first_ray)
            return true;
    }
    return false;
}

/* Rays of the k-th path of the portion. */
static enum rmap_status add_path(struct rmap_path_counts *self, size_t k, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    const size_t row = dictionary->row[k];
    const struct rmap_path_known *path = &dictionary->known[row];
    const uint64_t n = dictionary->shares.n_ray[k];
    struct rmap_path_added added;
    if (n == 0 || path->key.high == 0)
        return RMAP_OK;
    const struct rmap_class_sum some =
        sum_of(path, dictionary->paths->ray.segment_count[row], n, dictionary->shares.first[k]);
    const size_t source = (size_t)rmap_path_source_of(path->key);
    self->total.rays += n;
    self->total.segments += some.more.segments;
    self->total.source_weight[source] += some.more.weight;
    self->total.source_weight_squared[source] += some.more.weight_squared;
    self->most_weight = self->most_weight > 1.0 ? self->most_weight : 1.0;
    if (!rmap_path_counts_has(self->context, path->key))
        return RMAP_OK;
    RMAP_TRY(rmap_path_counts_add_class(self, &some, &added, err));
    if (rmap_path_tally_wants_steps(&self->tally, &added))
        RMAP_TRY(keep_known_steps(self, row, &added, err));
out:
    return st;
}

static enum rmap_status add_paths(struct rmap_path_counts *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t k = 0; k < self->buffers->dictionary.n && st == RMAP_OK; k++)
        st = add_path(self, k, err);
    return st;
}

/* Some rays of the portion have several paths, of which a dictionary knows nothing. */
static bool has_several(const struct rmap_path_counts *self)
{
    const struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    if (rmap_path_keys_are_simple(self->context->keys) || self->context->detector < 0)
        return false;
    for (size_t k = 0; k < dictionary->n; k++)
        if (dictionary->shares.n_ray[k] > 0 && dictionary->known[dictionary->row[k]].n_hit > 1)
            return true;
    return false;
}

static struct rmap_path_keying keying_of(const struct rmap_path_counts *self)
{
    const struct rmap_path_counting *context = self->context;
    return (struct rmap_path_keying){.hasher = &self->buffers->hasher,
                                     .keys = context->keys,
                                     .map = context->map,
                                     .detector = context->detector};
}

enum rmap_status rmap_path_counts_add_view(struct rmap_path_counts *self,
                                           const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_dictionary *dictionary = &self->buffers->dictionary;
    const struct rmap_path_keying keying = keying_of(self);
    RMAP_TRY(rmap_path_dictionary_enter_view(dictionary, &keying, rays, err));
    if (has_several(self))
        return rmap_path_counts_add_rays(self, rays, err);
    if (needs_ids(self, rays)) {
        RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_id), err));
        rmap_path_dictionary_find_first(dictionary, rays);
    }
    st = add_paths(self, err);
out:
    return st;
}

enum rmap_status rmap_path_counts_add_told(struct rmap_path_counts *self,
                                           const struct rmap_matched *rays,
                                           const struct rmap_told_paths *told,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_keying keying = keying_of(self);
    struct rmap_matched own;
    RMAP_TRY(rmap_path_dictionary_enter_told(&self->buffers->dictionary, &keying, rays, told, err));
    if (has_several(self))
        return rmap_path_counts_add_rays(self, rays, err);
    RMAP_TRY(add_paths(self, err));
    RMAP_TRY(rmap_path_shares_own(&self->buffers->dictionary.shares, rays, told, &own, err));
    if (own.n_match > 0)
        st = rmap_path_counts_add_rays(self, &own, err);
out:
    return st;
}

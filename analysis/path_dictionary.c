/* SPDX-License-Identifier: MIT */
#include "analysis/path_dictionary.h"

#include <string.h>

#include "base/alloc.h"

void rmap_path_dictionary_fini(struct rmap_path_dictionary *self)
{
    rmap_free(self->path);
    rmap_free(self->n_ray);
    rmap_free(self->first);
    *self = (struct rmap_path_dictionary){0};
}

static uint32_t count_hits(const struct rmap_portion *portion,
                           const struct rmap_path_place_of_ray *place, int32_t detector)
{
    const struct rmap_registration_columns *hit = &portion->registration;
    const size_t end = place->registration + portion->ray.registration_count[place->ray];
    uint32_t n = 0;
    for (size_t i = place->registration; i < end; i++)
        n += hit->registered[i] && (detector < 0 || hit->detector[i] == detector);
    return n;
}

/* All paths of the piece. */
static enum rmap_status read_piece(struct rmap_path_dictionary *self,
                                   struct rmap_path_hasher *hasher,
                                   const struct rmap_path_keys *keys, int32_t detector,
                                   const struct rmap_portion *paths, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = paths->n_row[RMAP_TABLE_RAY];
    const struct rmap_matched all = {.portion = paths, .n_match = n};
    void *block = self->path;
    const struct rmap_path_keyed *keyed = &hasher->keyed;
    st = rmap_reserve(&block, &self->path_cap, n + 1, sizeof *self->path, err);
    self->path = block;
    if (st == RMAP_OK)
        st = rmap_path_hasher_enter(hasher, keys, &all, err);
    RMAP_TRY(st);
    memset(self->path, 0, n * sizeof *self->path);
    RMAP_TRY(rmap_path_hasher_place(hasher, &all, err));
    rmap_path_hasher_key(hasher, 0, hasher->keyed.n, -1);
    for (size_t k = 0; k < keyed->n; k++) {
        const struct rmap_path_place_of_ray place = rmap_path_place_at(keyed, k);
        self->path[place.ray] = (struct rmap_path_known){
            rmap_path_key_at(keyed, k), paths->ray.source[place.ray],
            paths->ray.segment_count[place.ray], count_hits(paths, &place, detector), place};
    }
out:
    return st;
}

/* Matching rays of each path. */
static enum rmap_status count_rays(struct rmap_path_dictionary *self,
                                   const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_history_view *view = rays->view;
    void *n_ray = self->n_ray, *first = self->first;
    st = rmap_reserve(&n_ray, &self->n_ray_cap, view->n_path + 1, sizeof *self->n_ray, err);
    self->n_ray = n_ray;
    if (st == RMAP_OK)
        st = rmap_reserve(&first, &self->first_cap, view->n_path + 1, sizeof *self->first, err);
    self->first = first;
    if (st != RMAP_OK)
        return st;
    for (size_t k = 0; k < view->n_path; k++) {
        self->n_ray[k] = rays->match ? 0 : view->path_rays[k];
        self->first[k] = UINT64_MAX;
    }
    for (size_t i = 0; rays->match && i < view->n_row[RMAP_TABLE_RAY]; i++)
        self->n_ray[view->path[i]] += rays->match[i];
    return RMAP_OK;
}

enum rmap_status rmap_path_dictionary_enter(struct rmap_path_dictionary *self,
                                            struct rmap_path_hasher *hasher,
                                            const struct rmap_path_keys *keys, int32_t detector,
                                            size_t piece, const struct rmap_matched *rays,
                                            struct rmap_error *err)
{
    if (self->piece != piece + 1) {
        self->piece = 0;
        enum rmap_status st =
            read_piece(self, hasher, keys, detector, rmap_history_paths(rays->view->index), err);
        if (st != RMAP_OK)
            return st;
        self->piece = piece + 1;
    }
    return count_rays(self, rays, err);
}

void rmap_path_dictionary_find_first(struct rmap_path_dictionary *self,
                                     const struct rmap_matched *rays)
{
    const uint16_t *path = rays->view->path;
    const uint64_t *id = rays->portion->ray.id;
    for (size_t i = 0; i < rays->view->n_row[RMAP_TABLE_RAY]; i++)
        if ((!rays->match || rays->match[i]) && id[i] < self->first[path[i]])
            self->first[path[i]] = id[i];
}

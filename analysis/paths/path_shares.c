/* SPDX-License-Identifier: MIT
 *
 * How many of a portion's matching rays share each path, where the portion is summed up by its
 * paths.
 */
#include "analysis/paths/path_shares.h"

#include "base/alloc.h"

void rmap_path_shares_fini(struct rmap_path_shares *self)
{
    rmap_free(self->row);
    rmap_free(self->n_ray);
    rmap_free(self->first);
    rmap_free(self->number_of);
    rmap_free(self->own);
    *self = (struct rmap_path_shares){0};
}

bool rmap_path_shares_matter(const struct rmap_matched *rays,
                             const struct rmap_path_summary *summary)
{
    enum { MANY_SHARE = 4 };
    return summary->paths && (!(rays->portion->segment.object || rays->portion->segment.event) ||
                              summary->n_own < rays->portion->n_row[RMAP_TABLE_RAY] / MANY_SHARE);
}

/* Room for all paths; numbers are 0. */
static enum rmap_status reserve_paths(struct rmap_path_shares *self, size_t n_path, size_t n_ray,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = (n_path < n_ray ? n_path : n_ray) + 1; /* of matching rays */
    RMAP_TRY(RMAP_RESERVE(self->n_ray, self->n_ray_cap, n, err));
    RMAP_TRY(RMAP_RESERVE(self->first, self->first_cap, n, err));
    RMAP_TRY(RMAP_RESERVE(self->row, self->row_cap, n_path + 1, err));
    if (n_path + 1 <= self->number_cap)
        goto out;
    rmap_free(self->number_of);
    self->number_cap = 0;
    self->number_of = rmap_alloc(n_path + 1, sizeof *self->number_of);
    if (!self->number_of)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n_path);
    self->number_cap = n_path + 1;
out:
    return st;
}

/* Without a branch but for paths that were not met before: rays that do not match, or have a path
 * of their own, are counted for path 0. Counts stand one further on. */
static inline size_t count(const struct rmap_path_shares *shares, const uint32_t *path,
                           const uint8_t *match, size_t n_ray, uint64_t first_ray)
{
    const struct rmap_path_shares self = *shares; /* a copy: registers know it */
    size_t n = 0;
    for (size_t i = 0; i < n_ray; i++) {
        const uint32_t its = match ? path[i] & (0u - match[i]) : path[i];
        uint32_t k = self.number_of[its];
        if (k == 0 && its > 0) {
            self.row[n] = its - 1;
            self.first[n] = first_ray + i;
            self.n_ray[++n] = 0;
            self.number_of[its] = k = (uint32_t)n;
        }
        self.n_ray[k]++;
    }
    return n;
}

enum rmap_status rmap_path_shares_count(struct rmap_path_shares *self,
                                        const struct rmap_matched *rays,
                                        const struct rmap_path_summary *summary,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY];
    const uint64_t first_ray = rays->portion->first_ray;
    RMAP_TRY(reserve_paths(self, summary->paths->n_row[RMAP_TABLE_RAY], n_ray, err));
    self->n = rays->match ? count(self, summary->path, rays->match, n_ray, first_ray)
                          : count(self, summary->path, NULL, n_ray, first_ray);
    for (size_t k = 0; k < self->n; k++) {
        self->n_ray[k] = self->n_ray[k + 1];
        self->number_of[self->row[k] + 1] = 0;
    }
out:
    return st;
}

static size_t match_own(const uint32_t *path, const uint8_t *match, size_t n_ray, uint8_t *own)
{
    size_t n_match = 0;
    for (size_t i = 0, k = 0; i < n_ray; i++) { /* one more than there are is written */
        const uint8_t is_own = path[i] == 0;
        own[k] = match[i];
        n_match += is_own & match[i];
        k += is_own;
    }
    return n_match;
}

enum rmap_status rmap_path_shares_own(struct rmap_path_shares *self,
                                      const struct rmap_matched *rays,
                                      const struct rmap_path_summary *summary,
                                      struct rmap_matched *own, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *own = (struct rmap_matched){
        .n_match = summary->n_own, .index = rays->index, .space = rays->space};
    if (rays->match) {
        RMAP_TRY(RMAP_RESERVE(self->own, self->own_cap, summary->n_own + 1, err));
        own->n_match =
            match_own(summary->path, rays->match, rays->portion->n_row[RMAP_TABLE_RAY], self->own);
        own->match = self->own;
    }
    if (own->n_match > 0)
        st = rmap_fold_own_paths(rays, &own->portion, err);
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * The keys of paths that rays of a compact piece share: of its dictionary each is found once,
 * however many rays took it.
 */
#include "analysis/paths/path_dictionary.h"

#include <string.h>

#include "base/alloc.h"
#include "io/map/map_memory.h"

/* Keys of pieces are kept up to this, in all threads; then all are forgotten. */
enum { DICTIONARY_NBYTES_MAX = 32 << 20 };

static void forget_pieces(struct rmap_path_dictionary *self)
{
    for (size_t i = 0; i < self->n_slot; i++) {
        rmap_free(self->slot[i]);
        self->slot[i] = NULL;
    }
    self->nbytes = 0;
}

void rmap_path_dictionary_fini(struct rmap_path_dictionary *self)
{
    forget_pieces(self);
    rmap_free(self->slot);
    rmap_path_shares_fini(&self->shares);
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

/* Keys of all paths of a piece, its rays. */
static enum rmap_status key_paths(const struct rmap_path_keying *keying,
                                  const struct rmap_portion *paths, struct rmap_path_known *known,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_place_of_ray place = {0};
    rmap_path_step *step = NULL;
    size_t step_cap = 0, n_step;
    for (; place.ray < paths->n_row[RMAP_TABLE_RAY]; place.ray++) {
        const size_t n_segment = paths->ray.segment_count[place.ray];
        const size_t n_hit = paths->ray.registration_count[place.ray];
        RMAP_TRY(RMAP_RESERVE(step, step_cap, n_segment + n_hit + 1, err));
        if (rmap_path_key_of(keying->keys, paths, &place, step, &n_step))
            known[place.ray] = (struct rmap_path_known){
                .key = rmap_path_key_hash(step, n_step, paths->ray.source[place.ray]),
                .n_hit = count_hits(paths, &place, keying->detector)};
        place.segment += n_segment;
        place.registration += n_hit;
    }
out:
    rmap_free(step);
    return st;
}

static enum rmap_status key_piece(struct rmap_path_dictionary *self,
                                  const struct rmap_path_keying *keying, size_t slot,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = self->paths->n_row[RMAP_TABLE_RAY] + 1, nbytes = n * sizeof *self->known;
    if (self->nbytes + nbytes > rmap_map_share(keying->map, DICTIONARY_NBYTES_MAX))
        forget_pieces(self);
    struct rmap_path_known *known = rmap_alloc(n, sizeof *known);
    if (!known)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n);
    RMAP_TRY(key_paths(keying, self->paths, known, err));
    self->slot[slot] = known;
    self->nbytes += nbytes;
    known = NULL;
out:
    rmap_free(known);
    return st;
}

static enum rmap_status enter_piece(struct rmap_path_dictionary *self,
                                    const struct rmap_path_keying *keying,
                                    const struct rmap_matched *rays,
                                    const struct rmap_portion *paths, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t slot = (size_t)rmap_map_portion(keying->map, rays->index)->piece;
    self->paths = paths;
    self->n = 0;
    if (!self->slot) {
        self->n_slot = rmap_map_n_piece(keying->map);
        self->slot = rmap_alloc(self->n_slot, sizeof(void *));
        if (!self->slot) {
            self->n_slot = 0;
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
        }
    }
    if (!self->slot[slot])
        RMAP_TRY(key_piece(self, keying, slot, err));
    self->known = self->slot[slot];
out:
    return st;
}

enum rmap_status rmap_path_dictionary_enter_summary(struct rmap_path_dictionary *self,
                                                    const struct rmap_path_keying *keying,
                                                    const struct rmap_matched *rays,
                                                    const struct rmap_path_summary *summary,
                                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(enter_piece(self, keying, rays, summary->paths, err));
    RMAP_TRY(rmap_path_shares_count(&self->shares, rays, summary, err));
    self->n = self->shares.n;
    self->row = self->shares.row;
out:
    return st;
}

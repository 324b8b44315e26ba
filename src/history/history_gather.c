/* SPDX-License-Identifier: MIT
 *
 * Classes of legs, of all rays of a portion or of some.
 */
#include "base/byte_set.h"
#include "base/wide.h"
#include "history/history_parts.h"

/* Classes by code, and what tells those of the codes that rare ones share. */
struct class_codes {
    uint16_t class_of[256];
    uint32_t n_common;
    const uint64_t *rare;
};

static struct class_codes class_codes(const struct rmap_history_view *view)
{
    struct class_codes codes = {.n_common = view->rows->shape.n_common,
                                .rare = rmap_history_rare_legs(view)};
    for (uint32_t k = 0; k < codes.n_common; k++)
        codes.class_of[k] = view->local_class[k];
    return codes;
}

static inline uint16_t class_at(const struct rmap_history_view *view,
                                const struct class_codes *codes, size_t leg)
{
    uint8_t code = view->rows->code[leg];
    return code < codes->n_common || !codes->rare
               ? codes->class_of[code]
               : view->local_class[rmap_history_rare_at(view, codes->rare, leg)];
}

void rmap_history_row_classes(const struct rmap_history_view *view, uint16_t *row_class)
{
    const struct class_codes codes = class_codes(view);
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_SEGMENT]; i++)
        row_class[i] = class_at(view, &codes, i);
}

/* Where legs and registrations of each of n rays begin, registrations in the upper half; returns
 * where the next ones do. */
static inline uint64_t place_block(const uint32_t *legs, const uint32_t *hits, size_t n,
                                   uint64_t at, uint64_t *begin)
{
    RMAP_UNROLL
    for (size_t i = 0; i < n; i++) {
        begin[i] = at;
        at += legs[i] | (uint64_t)hits[i] << 32;
    }
    return at;
}

size_t rmap_history_place_rays(const struct rmap_history_view *view, const uint64_t *bits,
                               struct rmap_history_place_of_ray *ray)
{
    enum { BLOCK = 64 };
    const size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    const bool has_hits = view->registration_count != NULL;
    const uint32_t *legs = view->segment_count, *hits = has_hits ? view->registration_count : legs;
    uint64_t at = 0, begin[BLOCK];
    size_t n = 0;
    for (size_t first = 0; first < n_ray; first += BLOCK) {
        size_t few = n_ray - first < BLOCK ? n_ray - first : BLOCK;
        at = place_block(legs + first, hits + first, few, at, begin);
        for (uint64_t left = bits[first / BLOCK]; left != 0; left &= left - 1) {
            size_t i = (size_t)__builtin_ctzll(left);
            ray[n++] =
                (struct rmap_history_place_of_ray){(uint32_t)(first + i), (uint32_t)begin[i],
                                                   has_hits ? (uint32_t)(begin[i] >> 32) : 0};
        }
    }
    return n;
}

/* Far legs of registrations before one of them, counted on from an earlier one. */
struct far_walk {
    size_t at;
    uint32_t n;
};

static uint32_t far_before(const struct rmap_history_rows *rows, struct far_walk *walk, size_t hit)
{
    for (; rows->shape.n_far > 0 && walk->at < hit; walk->at++)
        walk->n += rows->leg[walk->at] == UINT8_MAX;
    return walk->n;
}

/* The leg on which a registration happened; later ones must be asked for after earlier ones. */
static uint32_t leg_of_hit(const struct rmap_history_rows *rows, struct far_walk *walk, size_t hit)
{
    uint32_t leg = rows->leg[hit];
    return leg == UINT8_MAX && far_before(rows, walk, hit) < rows->shape.n_far ? rows->far[walk->n]
                                                                               : leg;
}

void rmap_history_seen_behind(const struct rmap_history_view *view,
                              const struct rmap_history_place_of_ray *ray, size_t n,
                              const uint64_t *leg, const uint8_t *wanted, const uint8_t *follows,
                              uint64_t *bits)
{
    const struct rmap_history_rows *rows = view->rows;
    struct far_walk walk = {0};
    for (size_t k = 0; view->registration_count && k < n; k++) {
        size_t first = ray[k].registration, end = first + view->registration_count[ray[k].ray];
        uint32_t n_leg = view->segment_count[ray[k].ray], most = 0; /* legs before one of them */
        for (size_t i = first; i < end; i++) {
            uint32_t hit = rmap_history_number(rows->hit, rows->shape.hit_nbytes, i);
            uint32_t leg_of = leg_of_hit(rows, &walk, i);
            uint32_t before = leg_of < n_leg ? leg_of + follows[hit] : n_leg;
            most = wanted[hit] && before > most ? before : most;
        }
        bits[ray[k].ray / 64] |= (uint64_t)rmap_bits_any(leg, ray[k].leg, most) << ray[k].ray % 64;
    }
}

static void copy_hits(const struct rmap_history_view *view, struct far_walk *walk, size_t first,
                      uint32_t n, struct rmap_portion *out)
{
    const struct rmap_history_rows *rows = view->rows;
    for (size_t i = first; i < first + n; i++) {
        size_t to = out->n_row[RMAP_TABLE_REGISTRATION]++;
        const struct rmap_history_hit *hit =
            &view->index->hit[rmap_history_number(rows->hit, rows->shape.hit_nbytes, i)];
        out->registration.detector[to] = hit->detector;
        out->registration.registered[to] = (uint8_t)hit->registered;
        out->registration.segment[to] = leg_of_hit(rows, walk, i);
    }
}

void rmap_history_gather(const struct rmap_history_view *view,
                         const struct rmap_history_place_of_ray *ray, size_t n,
                         struct rmap_portion *out, uint16_t *row_class)
{
    const struct class_codes codes = class_codes(view);
    struct far_walk walk = {0};
    out->n_row[RMAP_TABLE_REGISTRATION] = 0;
    for (size_t k = 0; k < n; k++) {
        uint32_t n_leg = view->segment_count[ray[k].ray];
        uint32_t n_hit = view->registration_count ? view->registration_count[ray[k].ray] : 0;
        for (size_t leg = ray[k].leg; leg < (size_t)ray[k].leg + n_leg; leg++)
            *row_class++ = class_at(view, &codes, leg);
        copy_hits(view, &walk, ray[k].registration, n_hit, out);
        out->ray.segment_count[k] = n_leg;
        out->ray.registration_count[k] = n_hit;
    }
    out->n_row[RMAP_TABLE_RAY] = n;
}

/* SPDX-License-Identifier: MIT
 *
 * Classes of legs, of all rays of a portion or of some.
 */
#include <string.h>

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

/* Whether the classes of codes are wanted; of a rare code: UINT8_MAX, or 0 where no rare class is.
 */
static void answer_codes(const struct rmap_history_view *view, const uint8_t *wanted,
                         uint8_t answer[256])
{
    const uint32_t n_common = view->rows->shape.n_common;
    bool rare = false;
    for (size_t k = n_common; k < view->n_local; k++)
        rare |= wanted[view->local_class[k]] != 0;
    memset(answer, rare ? UINT8_MAX : 0, 256);
    for (uint32_t k = 0; k < n_common; k++)
        answer[k] = wanted[view->local_class[k]];
}

/* Whether a leg of each ray is wanted: the first, or the last. */
static inline void test_legs(const struct rmap_history_view *view, const uint8_t *wanted,
                             bool is_last, uint8_t *restrict is)
{
    const uint32_t *segment_count = view->segment_count;
    const uint8_t *code = view->rows->code;
    const size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    const struct class_codes codes = class_codes(view);
    uint8_t answer[256];
    size_t leg = 0;
    answer_codes(view, wanted, answer);
    for (size_t i = 0; i < n_ray; i++) {
        uint32_t n = segment_count[i];
        size_t at = is_last ? leg + n - (n > 0) : leg;
        leg += n;
        uint8_t own = n > 0 ? answer[code[at]] : 0;
        if (__builtin_expect(own == UINT8_MAX, 0))
            own = wanted[class_at(view, &codes, at)] != 0;
        is[i] = own;
    }
}

void rmap_history_test_first(const struct rmap_history_view *view, const uint8_t *wanted,
                             uint8_t *is)
{
    test_legs(view, wanted, false, is);
}

void rmap_history_test_last(const struct rmap_history_view *view, const uint8_t *wanted,
                            uint8_t *is)
{
    test_legs(view, wanted, true, is);
}

size_t rmap_history_place_rays(const struct rmap_history_view *view, const uint8_t *is,
                               struct rmap_history_place_of_ray *ray)
{
    uint32_t leg = 0, registration = 0;
    size_t n = 0;
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_RAY]; i++) {
        ray[n] = (struct rmap_history_place_of_ray){(uint32_t)i, leg, registration};
        n += is ? is[i] : 1;
        leg += view->segment_count[i];
        registration += view->registration_count ? view->registration_count[i] : 0;
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

static void copy_hits(const struct rmap_history_view *view, struct far_walk *walk, size_t first,
                      uint32_t n, struct rmap_portion *out)
{
    const struct rmap_history_rows *rows = view->rows;
    for (size_t i = first; i < first + n; i++) {
        size_t to = out->n_row[RMAP_TABLE_REGISTRATION]++;
        const struct rmap_history_hit *hit =
            &view->index->hit[rmap_history_number(rows->hit, rows->shape.hit_nbytes, i)];
        uint32_t leg = rows->leg[i];
        if (leg == UINT8_MAX && far_before(rows, walk, i) < rows->shape.n_far)
            leg = rows->far[walk->n];
        out->registration.detector[to] = hit->detector;
        out->registration.registered[to] = (uint8_t)hit->registered;
        out->registration.segment[to] = leg;
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

/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_places.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/intrinsics.h"

size_t rmap_stats_cell_at(const struct rmap_stats_plan *plan, double value)
{
    const size_t cell = rmap_bin_of(&plan->bins[0], value);
    return cell == RMAP_BIN_BELOW   ? plan->n_cell + RMAP_STATS_BELOW
           : cell == RMAP_BIN_ABOVE ? plan->n_cell + RMAP_STATS_ABOVE
                                    : cell;
}

size_t rmap_stats_cell_of(const struct rmap_stats_plan *plan, const struct rmap_stats_block *block,
                          size_t k)
{
    if (plan->setup->quantities->n == 1)
        return rmap_stats_cell_at(plan, block->value[0][k]);
    const size_t x = rmap_bin_of(&plan->bins[0], block->value[0][k]);
    const size_t y = rmap_bin_of(&plan->bins[1], block->value[1][k]);
    if (x >= plan->bins[0].n || y >= plan->bins[1].n)
        return plan->n_cell + RMAP_STATS_ABOVE;
    return x + plan->bins[0].n * y;
}

/* Fine bins [first, end) of a cell, or of what is below or above all. */
static void bins_of_cell(const struct rmap_stats_plan *plan, size_t cell, size_t *first,
                         size_t *end)
{
    const size_t each = plan->n_fine_per_cell, cells_end = plan->n_fine_below + plan->n_cell * each;
    *first = cell < plan->n_cell                       ? plan->n_fine_below + cell * each
             : cell == plan->n_cell + RMAP_STATS_BELOW ? 0
                                                       : cells_end;
    *end = cell < plan->n_cell                       ? *first + each
           : cell == plan->n_cell + RMAP_STATS_BELOW ? plan->n_fine_below
                                                     : plan->n_fine;
}

size_t rmap_stats_fine(const struct rmap_stats_plan *plan, size_t quantity, double value)
{
    const double at = (value - plan->fine_low[quantity]) * plan->fine_per[quantity];
    size_t first = 0, end = plan->n_fine, k = at > 0.0 ? (size_t)at : 0;
    if (plan->n_fine_per_cell > 0)
        bins_of_cell(plan, rmap_stats_cell_at(plan, value), &first, &end);
    k = k < end ? k : end - 1;
    return k < first ? first : k;
}

void rmap_stats_cells_from_fine(const struct rmap_stats_plan *plan, const uint32_t *fine,
                                double *cell)
{
    for (size_t c = 0; c < plan->n_cell + RMAP_STATS_BEYOND; c++) {
        size_t k, end;
        uint64_t sum = 0;
        for (bins_of_cell(plan, c, &k, &end); k < end; k++)
            sum += fine[k];
        cell[c] += (double)sum;
    }
}

/* What places are told by: where bins begin, and how near to an edge, in parts of a bin, one is in
 * doubt. */
struct ruler {
    double low, per; /* parts per unit */
    uint16_t doubt;
    uint16_t most; /* the last bin */
};

/* Parts of a bin: what is left of 32 bits of a place. */
enum { PART_BITS = 16, PARTS = 1 << PART_BITS };

/* Adding this leaves a whole number, the nearest one, in the last bits. */
static const double WHOLE = 0x1.8p52;

static inline uint32_t parts_of(const struct ruler *ruler, double value)
{
    const double whole = (value - ruler->low) * ruler->per + WHOLE;
    uint64_t bits;
    memcpy(&bits, &whole, sizeof bits);
    return (uint32_t)bits;
}

static inline bool is_in_doubt(const struct ruler *ruler, uint32_t parts)
{
    return (uint16_t)(parts + ruler->doubt) < 2 * ruler->doubt;
}

/* So many are told at once, and so many of these before those in doubt are looked at again. */
enum { GROUP = 16, GROUPS = 64 };

/* Bits of groups with some in doubt; of each of these, two bits of each. */
struct doubts {
    uint64_t groups;
    uint32_t which[GROUPS];
};

static void guess_narrow(const struct ruler *ruler, const double *value, size_t n_group,
                         uint16_t *place, struct doubts *doubts)
{
    *doubts = (struct doubts){0};
    for (size_t k = 0; k < n_group * GROUP; k++) {
        const uint32_t parts = parts_of(ruler, value[k]), bin = parts >> PART_BITS;
        const bool near = is_in_doubt(ruler, parts);
        place[k] = (uint16_t)(bin < ruler->most ? bin : ruler->most);
        doubts->groups |= (uint64_t)near << k / GROUP;
        doubts->which[k / GROUP] |= (near ? UINT32_C(3) : 0) << k % GROUP * 2;
    }
}

#ifdef RMAP_INTRINSICS
/* Four values' parts of bins, in the lower halves of four numbers. */
__attribute__((target("avx2"))) static inline __m256 parts_of_4(const double *value, __m256d low,
                                                                __m256d per)
{
    const __m256d at = _mm256_mul_pd(_mm256_sub_pd(_mm256_loadu_pd(value), low), per);
    return _mm256_castpd_ps(_mm256_add_pd(at, _mm256_set1_pd(WHOLE)));
}

/* Sets place of n_group groups. */
__attribute__((target("avx2"))) static void guess_wide(const struct ruler *ruler,
                                                       const double *value, size_t n_group,
                                                       uint16_t *place, struct doubts *doubts)
{
    const __m256d low = _mm256_set1_pd(ruler->low), per = _mm256_set1_pd(ruler->per);
    const __m256i most = _mm256_set1_epi16((short)ruler->most);
    const __m256i doubt = _mm256_set1_epi16((short)ruler->doubt);
    const __m256i beyond = _mm256_set1_epi16((short)(2 * ruler->doubt - 1));
    const __m256i order = _mm256_setr_epi32(0, 4, 1, 5, 2, 6, 3, 7);
    doubts->groups = 0;
    for (size_t g = 0; g < n_group; g++) {
        const double *own = value + g * GROUP;
        const __m256i a = _mm256_castps_si256(
            _mm256_shuffle_ps(parts_of_4(own, low, per), parts_of_4(own + 4, low, per), 0x88));
        const __m256i b = _mm256_castps_si256(
            _mm256_shuffle_ps(parts_of_4(own + 8, low, per), parts_of_4(own + 12, low, per), 0x88));
        const __m256i bin =
            _mm256_packus_epi32(_mm256_srli_epi32(a, PART_BITS), _mm256_srli_epi32(b, PART_BITS));
        const __m256i none = _mm256_setzero_si256();
        const __m256i part = _mm256_packus_epi32(_mm256_blend_epi16(a, none, 0xaa),
                                                 _mm256_blend_epi16(b, none, 0xaa));
        const __m256i moved = _mm256_add_epi16(part, doubt);
        const __m256i near = _mm256_cmpeq_epi16(_mm256_min_epu16(moved, beyond), moved);
        _mm256_storeu_si256((void *)(place + g * GROUP),
                            _mm256_permutevar8x32_epi32(_mm256_min_epu16(bin, most), order));
        if (_mm256_testz_si256(near, near))
            continue;
        doubts->groups |= UINT64_C(1) << g;
        doubts->which[g] = (uint32_t)_mm256_movemask_epi8(_mm256_permutevar8x32_epi32(near, order));
    }
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("avx2");
}
#else
#define guess_wide(ruler, value, n_group, place, doubts)                                           \
    guess_narrow(ruler, value, n_group, place, doubts)
#define is_wide() false
#endif

/* Edges are rounded, and so are places: by some parts in 2^52 of the numbers in them. False: by so
 * many parts of a bin that nothing is sure. */
static bool make_ruler(const struct rmap_stats_plan *plan, size_t quantity, struct ruler *ruler)
{
    const double low = plan->fine_low[quantity], per = plan->fine_per[quantity];
    const double n = (double)plan->n_fine, reach = 2.0 * fabs(low) * per + 2.0 * n;
    const double doubt = 64.0 * DBL_EPSILON * reach * PARTS + 2.0;
    *ruler = (struct ruler){low, per * PARTS, 0, (uint16_t)(plan->n_fine - 1)};
    if (!(per > 0.0 && doubt < 0.25 * PARTS))
        return false;
    ruler->doubt = (uint16_t)doubt;
    return true;
}

/* Tells those in doubt one by one. */
static void settle(const struct rmap_stats_plan *plan, size_t quantity, const struct doubts *doubts,
                   const double *value, uint16_t *place)
{
    for (uint64_t groups = doubts->groups; groups; groups &= groups - 1) {
        const size_t g = (size_t)__builtin_ctzll(groups);
        for (uint32_t which = doubts->which[g] & 0x55555555; which; which &= which - 1) {
            const size_t k = g * GROUP + (size_t)__builtin_ctz(which) / 2;
            place[k] = (uint16_t)rmap_stats_fine(plan, quantity, value[k]);
        }
    }
}

/* At most GROUPS groups. */
static void tell_groups(const struct rmap_stats_plan *plan, size_t quantity,
                        const struct ruler *ruler, const double *value, size_t n_group,
                        uint16_t *place)
{
    struct doubts doubts;
    if (is_wide())
        guess_wide(ruler, value, n_group, place, &doubts);
    else
        guess_narrow(ruler, value, n_group, place, &doubts);
    settle(plan, quantity, &doubts, value, place);
}

void rmap_stats_fine_places(const struct rmap_stats_plan *plan, size_t quantity,
                            const double *value, size_t n, uint16_t *place)
{
    struct ruler ruler;
    size_t n_group = make_ruler(plan, quantity, &ruler) ? n / GROUP : 0;
    for (size_t k = 0; n_group == 0 && k < n; k++)
        place[k] = (uint16_t)rmap_stats_fine(plan, quantity, value[k]);
    if (n_group == 0)
        return;
    const size_t rest = n % GROUP, last = n - GROUP;
    for (size_t k = 0, some; n_group > 0; n_group -= some, k += some * GROUP) {
        some = n_group < GROUPS ? n_group : GROUPS;
        tell_groups(plan, quantity, &ruler, value + k, some, place + k);
    }
    if (rest > 0) /* some of these once more */
        tell_groups(plan, quantity, &ruler, value + last, 1, place + last);
}

/* SPDX-License-Identifier: MIT */
#include "analysis/stats_places.h"

#include <float.h>
#include <math.h>
#include <string.h>

#include "base/wide.h"

size_t rmap_stats_cell_at(const struct rmap_stats_plan *plan, double value)
{
    const size_t cell = rmap_bin_of(&plan->bins[0], value);
    return cell == RMAP_BIN_BELOW   ? plan->n_cell + RMAP_STATS_BELOW
           : cell == RMAP_BIN_ABOVE ? plan->n_cell + RMAP_STATS_ABOVE
                                    : cell;
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

/* What places are told by: bins counted from the middle of the first one. */
struct ruler {
    double middle, per;
    double sure; /* so far from the middle of a bin at most it is the right one for certain */
};

/* Adding this leaves a whole number, the nearest one, in the last bits. */
static const double WHOLE = 0x1.8p52;

/* A place in doubt, or the last one of as many as there may be. */
#define IN_DOUBT 0xffff

/* Returns whether one is in doubt. */
RMAP_WIDE static uint64_t guess_places(const double *restrict value, size_t n,
                                       const struct ruler *ruler, uint16_t most,
                                       uint16_t *restrict place)
{
    const double middle = ruler->middle, per = ruler->per, sure = ruler->sure;
    uint64_t doubt = 0;
    for (size_t k = 0; k < n; k++) {
        const double at = (value[k] - middle) * per, whole = at + WHOLE;
        const uint64_t in_doubt = -(uint64_t) !(fabs(at - (whole - WHOLE)) < sure);
        uint64_t bits;
        memcpy(&bits, &whole, sizeof bits);
        const uint16_t guess = (uint16_t)bits;
        place[k] = (guess < most ? guess : most) | (uint16_t)in_doubt;
        doubt |= in_doubt;
    }
    return doubt;
}

/* Whether one of four is in doubt, or may be. */
static bool any_of_four(const uint16_t *place)
{
    uint64_t four;
    memcpy(&four, place, sizeof four);
    four = ~four; /* is 0 there: the carry of a subtraction tells */
    return ((four - 0x0001000100010001) & ~four & 0x8000800080008000) != 0;
}

static void settle_places(const struct rmap_stats_plan *plan, size_t quantity, const double *value,
                          size_t n, uint16_t *place)
{
    for (size_t k = 0; k < n; k++) {
        while (n - k > 4 && !any_of_four(place + k))
            k += 4;
        if (place[k] == IN_DOUBT)
            place[k] = (uint16_t)rmap_stats_fine(plan, quantity, value[k]);
    }
}

/* So many at once: few are in doubt. */
enum { GUESSED = 128 };

void rmap_stats_fine_places(const struct rmap_stats_plan *plan, size_t quantity,
                            const double *value, size_t n, uint16_t *place)
{
    const double low = plan->fine_low[quantity], per = plan->fine_per[quantity];
    const double width = per > 0.0 ? 1.0 / per : 0.0;
    /* Edges are rounded, and so are places: by some parts in 2^52 of the numbers in them. */
    const double reach = 2.0 * fabs(low) + width * (double)plan->n_fine;
    const double slack = 64.0 * DBL_EPSILON * (reach * per + (double)plan->n_fine);
    const struct ruler ruler = {low + 0.5 * width, per, 0.5 - slack};
    const uint16_t most = (uint16_t)(plan->n_fine - 1);
    for (size_t first = 0; first < n; first += GUESSED) {
        const size_t some = n - first < GUESSED ? n - first : GUESSED;
        if (guess_places(value + first, some, &ruler, most, place + first))
            settle_places(plan, quantity, value + first, some, place + first);
    }
}

/* SPDX-License-Identifier: MIT
 *
 * By halves (Hoare 1961): of the items about a value, those below it or those above are looked at
 * further. Weights are multiples of 2^-24 whose sums are exact (rmap_stats_rounded).
 */
#include "analysis/stats/stats_items.h"

#include <stdbool.h>

static void swap(struct rmap_stats_item *a, struct rmap_stats_item *b)
{
    const struct rmap_stats_item kept = *a;
    *a = *b;
    *b = kept;
}

static double median(double a, double b, double c)
{
    const double low = a < b ? a : b, high = a < b ? b : a;
    return c < low ? low : c > high ? high : c;
}

/* Puts items below a value first, then those of it. */
static void divide(struct rmap_stats_item *item, size_t n, double value, size_t *n_below,
                   size_t *n_up_to)
{
    size_t below = 0, end = n;
    for (size_t k = 0; k < end;) {
        if (item[k].value < value)
            swap(&item[k++], &item[below++]);
        else if (item[k].value > value)
            swap(&item[k], &item[--end]);
        else
            k++;
    }
    *n_below = below;
    *n_up_to = end;
}

static void add(const struct rmap_stats_item *item, size_t n, double sign, double *weight)
{
    for (size_t k = 0; k < n; k++)
        weight[item[k].source] += sign * item[k].weight;
}

static bool is_reached(const struct rmap_stats_flux *flux, const double *weight)
{
    double sum = flux->below;
    for (size_t s = 0; s < flux->n_source; s++)
        sum += flux->per_weight[s] * weight[s];
    return sum >= flux->target;
}

/* In one part; weight: of what is below it. n > 0. */
static double value_in_part(struct rmap_stats_item *item, size_t n,
                            const struct rmap_stats_flux *flux, double *weight)
{
    double value = item[0].value;
    while (n > 0) {
        size_t n_below, n_up_to;
        const double middle = median(item[0].value, item[n / 2].value, item[n - 1].value);
        divide(item, n, middle, &n_below, &n_up_to);
        add(item, n_below, 1.0, weight);
        if (n_below > 0 && is_reached(flux, weight)) {
            add(item, n_below, -1.0, weight);
            n = n_below;
            continue;
        }
        value = middle;
        add(item + n_below, n_up_to - n_below, 1.0, weight);
        if (is_reached(flux, weight))
            return value;
        item += n_up_to;
        n -= n_up_to;
    }
    return value;
}

double rmap_stats_items_at(struct rmap_stats_item *item, const size_t *first, size_t n_part,
                           const struct rmap_stats_flux *flux, double *weight)
{
    size_t last = 0; /* with an item */
    for (size_t s = 0; s < flux->n_source; s++)
        weight[s] = 0.0;
    for (size_t k = 0; k < n_part; k++) {
        const size_t n = first[k + 1] - first[k];
        if (n == 0)
            continue;
        last = k;
        add(item + first[k], n, 1.0, weight);
        if (is_reached(flux, weight))
            break;
    }
    const size_t n = first[last + 1] - first[last];
    add(item + first[last], n, -1.0, weight);
    return value_in_part(item + first[last], n, flux, weight);
}

/* SPDX-License-Identifier: MIT
 *
 * The colour of the ray in hand: shares of its flux per channel, summing to 1.
 */
#include "trace/colour.h"

#include <string.h>

static void trim(struct rmap_colour *colour)
{
    while (colour->end - colour->begin > 1 && !(colour->share[colour->begin] > 0.0))
        colour->begin++;
    while (colour->end - colour->begin > 1 && !(colour->share[colour->end - 1] > 0.0))
        colour->end--;
}

void rmap_colour_set(struct rmap_colour *colour, const double *share, int n)
{
    colour->n = n;
    colour->begin = 0;
    colour->end = n;
    memcpy(colour->share, share, (size_t)n * sizeof *share);
    trim(colour);
}

void rmap_colour_collapse(struct rmap_colour *colour, int channel)
{
    for (int i = colour->begin; i < colour->end; i++)
        colour->share[i] = 0.0;
    colour->share[channel] = 1.0;
    colour->begin = channel;
    colour->end = channel + 1;
}

double rmap_colour_sum(const struct rmap_colour *colour, const double *p)
{
    if (rmap_colour_single(colour))
        return p[colour->begin];
    double sum = 0.0;
    for (int i = colour->begin; i < colour->end; i++)
        sum += colour->share[i] * p[i];
    return sum;
}

bool rmap_colour_weigh(struct rmap_colour *colour, const double *p)
{
    int alike = colour->begin + 1;
    while (alike < colour->end && p[alike] == p[colour->begin])
        alike++;
    if (alike == colour->end)
        return false; /* a grey surface leaves every bit of the colour as it is */
    double sum = rmap_colour_sum(colour, p);
    for (int i = colour->begin; i < colour->end; i++)
        colour->share[i] *= p[i] / sum;
    trim(colour);
    return true;
}

int rmap_colour_pick(const struct rmap_colour *colour, const double *p, double u)
{
    if (rmap_colour_single(colour))
        return colour->begin;
    double total = 0.0, sum = 0.0;
    for (int i = colour->begin; i < colour->end; i++)
        total += p ? colour->share[i] * p[i] : colour->share[i];
    int last = colour->begin;
    for (int i = colour->begin; i < colour->end; i++) {
        double term = p ? colour->share[i] * p[i] : colour->share[i];
        if (!(term > 0.0))
            continue;
        last = i;
        sum += term;
        if (u * total < sum)
            break;
    }
    return last;
}

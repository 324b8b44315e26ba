/* SPDX-License-Identifier: MIT
 *
 * How long light waits in a medium before it is given back: exponential decays, each with a share
 * of the light.
 */
#ifndef RMAP_DECAY_H
#define RMAP_DECAY_H

#include "base/portable.h"
#include "base/search.h"

#define RMAP_DECAY_MAX 8

struct rmap_decay {
    size_t n; /* 0: at once */
    double time_ns[RMAP_DECAY_MAX];
    double below[RMAP_DECAY_MAX]; /* share of this component and those before it; the last is 1 */
};

/* By two numbers in (0, 1): of the component, and of its time. By portable operations. */
static inline double rmap_decay_delay(const struct rmap_decay *decay, double component, double u)
{
    if (decay->n == 0)
        return 0.0;
    return -decay->time_ns[rmap_first_above(decay->below, decay->n, component)] *
           rmap_portable_log(u);
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * What a silicon photo-multiplier reads of an event: the cells that fire for its photo-electrons,
 * for dark counts in its window, and by crosstalk; each gives the same charge.
 */
#ifndef RMAP_READING_H
#define RMAP_READING_H

#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Borel: the cells that an avalanche fires are Poisson's, and each of them fires others (Vinogradov
 * 2012, doi:10.1016/j.nima.2011.11.086). Geometric: at most one, which may fire one
 * (Vinogradov et al. 2009, doi:10.1109/NSSMIC.2009.5402300). */
enum rmap_crosstalk_model { RMAP_CROSSTALK_BOREL, RMAP_CROSSTALK_GEOMETRIC };

struct rmap_reading {
    bool given;
    double gain;      /* electrons per cell that fires */
    double dark_hz;   /* rate of dark counts */
    double window_ns; /* light and dark counts are read from the event's beginning until then; 0:
                         all light */
    double crosstalk; /* probability that an avalanche fires any other cell */
    enum rmap_crosstalk_model model;
    double afterpulse;    /* probability that an avalanche lets its cell fire once more */
    double afterpulse_ns; /* mean of the exponential delay until then */
    uint64_t cells; /* an avalanche is in any of them, and what fires twice counts once; 0: many */
};

static inline double rmap_reading_until(const struct rmap_reading *reading)
{
    return reading->given && reading->window_ns > 0.0 ? reading->window_ns : (double)INFINITY;
}

struct rmap_reading_of {
    uint64_t seed, event;
    int32_t detector;
};

struct rmap_read {
    uint64_t photo_electrons, dark, crosstalk, afterpulses, cells;
};

/* Of photo-electrons that are expected, or, is_whole, counted, and of their mean arrival (NaN: the
 * beginning), after which afterpulses of the window come. By nothing but these and `of`. */
void rmap_reading_draw(const struct rmap_reading *reading, const struct rmap_reading_of *of,
                       double photo_electrons, bool is_whole, double mean_ns,
                       struct rmap_read *read);

/* Times of the dark counts, ns: puts them, and those that stand in early[n] ascending (INFINITY:
 * none), in order, as many as have room. */
void rmap_reading_dark_times(const struct rmap_reading *reading, const struct rmap_reading_of *of,
                             uint64_t dark, double *early, size_t n);

#endif

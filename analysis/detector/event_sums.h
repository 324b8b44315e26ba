/* SPDX-License-Identifier: MIT
 *
 * What each event left in each of some detectors: a kind of fold. Sums are whole numbers: amounts
 * in parts of the map's whole flux, times in parts of a ns, so that they do not depend on the order
 * of adding.
 *
 * Rows of events that come one after the other stand on pages, which are there where an event is:
 * what a state takes is as the events of its rays.
 */
#ifndef RMAP_EVENT_SUMS_H
#define RMAP_EVENT_SUMS_H

#include "analysis/query/fold.h"

enum { RMAP_EVENT_EARLY_MAX = 64, RMAP_EVENT_DETECTORS_MAX = 4096 };

struct rmap_event_ask {
    const struct rmap_map *map;
    const struct rmap_scene *scene; /* with receivers */
    const uint64_t *event;          /* [n_event] all there are, ascending */
    size_t n_event;
    const int32_t *detector; /* [n_detector] those asked about, */
    size_t n_detector;
    const int32_t *place; /* [scene->n_detector] and the place of each among them; -1: not asked */
    bool timed;           /* times of arrival are known */
    size_t n_early;       /* so many of the earliest are kept; 0 unless timed */
    double part;          /* of an amount, a power of 2 of the flux unit; rmap_event_part */
};

/* A part of which the map's flux has at most 2^52. */
double rmap_event_part(const struct rmap_map *map);

/* Columns that it reads. */
rmap_column_set rmap_event_columns(const struct rmap_event_ask *ask);

/* Bytes of the rows of all events. */
double rmap_event_sums_nbytes(const struct rmap_event_ask *ask);

enum { RMAP_EVENT_PAGE = 256 };

struct rmap_event_sums {
    const struct rmap_event_ask *ask;
    size_t n_word; /* 64 bits each, of a row: rays, then for each detector registrations, amount,
                      amount times time in two, and the earliest times */
    size_t n_page;
    uint64_t **page; /* [n_page], NULL: no ray of its events; [RMAP_EVENT_PAGE][n_word] */
};

/* Context: struct rmap_event_ask. */
extern const struct rmap_fold_kind rmap_event_kind;

struct rmap_event_reading {
    uint64_t registrations;
    double sum;                            /* of flux times response */
    double mean_ns;                        /* by that; NaN: none, or not timed */
    double early_ns[RMAP_EVENT_EARLY_MAX]; /* [ask->n_early] ascending; INFINITY: none */
};

/* Matching rays of event `index`; 0: it has none. And what it left on detector `place` of those
 * asked about. */
uint64_t rmap_event_sums_rays(const struct rmap_event_sums *sums, size_t index);
void rmap_event_sums_read(const struct rmap_event_sums *sums, size_t index, size_t place,
                          struct rmap_event_reading *reading);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Readings of events as a table: a row for each event that has rays, and in it what each detector
 * read; and what they are on the mean.
 */
#ifndef RMAP_EVENT_TABLE_H
#define RMAP_EVENT_TABLE_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/detector/event_sums.h"

/* Symbol, name, unit (NULL: of flux times response), what it takes, description. */
enum rmap_event_needs { RMAP_EVENT_ALWAYS, RMAP_EVENT_TIMES, RMAP_EVENT_READS };
#define RMAP_EVENT_VALUE_TABLE(X)                                                                  \
    X(COUNT, "registrations", "1", ALWAYS, "registrations that count")                             \
    X(SUM, "sum", NULL, ALWAYS, "of their flux times the detector's response")                     \
    X(FIRST, "first", "ns", TIMES, "arrival of the first; NaN: none")                              \
    X(MEAN, "mean", "ns", TIMES, "mean time of arrival, weighted as the sum; NaN: none")           \
    X(TRIGGER, "trigger", "ns", TIMES, "time of count number `order`, dark ones too; NaN: none")   \
    X(ELECTRONS, "photo_electrons", "1", READS, "by chance, of the sum")                           \
    X(DARK, "dark", "1", READS, "dark counts within the window")                                   \
    X(CROSSTALK, "crosstalk", "1", READS, "avalanches by crosstalk")                               \
    X(AFTERPULSES, "afterpulses", "1", READS, "of cells that fired, within the window")            \
    X(CELLS, "cells", "1", READS, "that fired, by afterpulses once more")                          \
    X(CHARGE, "charge", "pC", READS, "cells times gain times e")

enum rmap_event_value {
#define RMAP_EVENT_VALUE_ENUM(symbol, name, unit, needs, description) RMAP_EVENT_##symbol,
    RMAP_EVENT_VALUE_TABLE(RMAP_EVENT_VALUE_ENUM)
#undef RMAP_EVENT_VALUE_ENUM
        RMAP_EVENT_VALUES
};

/* How detectors fire, and together. */
struct rmap_event_trigger {
    double threshold; /* of the cells where a detector has a reading, else of the sum */
    size_t order;     /* its time is that of this count, from 1 */
    size_t least;     /* so many detectors in coincidence */
    double window_ns; /* within this; INFINITY: whenever */
};

struct rmap_event_row {
    uint64_t event, rays;
    size_t n_fired;
    bool coincident;
    double (*value)[RMAP_EVENT_VALUES]; /* [n_detector] NaN: not defined */
};

struct rmap_event_table {
    const struct rmap_event_sums *sums; /* borrowed */
    const struct rmap_event_ask *ask;
    struct rmap_event_trigger trigger;
    const char *criterion;          /* borrowed; NULL: all rays */
    const struct rmap_which *which; /* borrowed; NULL: all registrations */
    size_t n_row;                   /* events that have rays */
    bool reads;                     /* some detector has a reading */
    bool whole;                     /* each ray is a photon */
    struct rmap_event_row row;      /* the one in hand */
    double *time;                   /* [n_detector] of those that fired */
};

/* Sums borrowed. */
enum rmap_status rmap_event_table_init(const struct rmap_event_sums *sums,
                                       const struct rmap_event_trigger *trigger,
                                       struct rmap_event_table *table,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_event_table_fini(struct rmap_event_table *table); /* zeroed: fine */

/* The next row from event `*index` on, which goes behind it; NULL: there is none. The table's,
 * until the next call. */
const struct rmap_event_row *rmap_event_table_next(struct rmap_event_table *table, size_t *index);

bool rmap_event_table_has(const struct rmap_event_table *table, enum rmap_event_value value);
const char *rmap_event_value_name(enum rmap_event_value value);
const char *rmap_event_value_description(enum rmap_event_value value);
const char *rmap_event_value_unit(const struct rmap_event_table *table,
                                  enum rmap_event_value value);

/* What is told of all rows. */
struct rmap_event_spread {
    uint64_t n;
    double mean, squares; /* of values, and of deviations from it */
};
struct rmap_event_of_detector {
    struct rmap_event_spread signal, first,
        trigger; /* signal: cells or sum; times where there are */
    uint64_t n_fired;
};
struct rmap_event_summary {
    struct rmap_event_of_detector *detector; /* [n_detector] */
    uint64_t n_coincident;
    struct rmap_event_spread difference; /* of two detectors that fired: times of the first less
                                            those of the second */
};
enum rmap_status rmap_event_summary_init(struct rmap_event_table *table,
                                         struct rmap_event_summary *summary,
                                         struct rmap_error *err) RMAP_MUST_USE;
void rmap_event_summary_fini(struct rmap_event_summary *summary);
double rmap_event_spread_deviation(const struct rmap_event_spread *spread); /* NaN: fewer than 2 */

#endif

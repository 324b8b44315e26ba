/* SPDX-License-Identifier: MIT
 *
 * Statistics as text: for people, as CSV, as JSON.
 */
#ifndef RMAP_STATS_TEXT_H
#define RMAP_STATS_TEXT_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/stats/stats.h"
#include "io/map/map_cut.h"

struct rmap_stats_labels {
    const char *map;                  /* path */
    const char *criterion;            /* NULL: all rays */
    const struct rmap_which *which;   /* registrations that count; NULL: all */
    uint64_t n_ray;                   /* of the map */
    const struct rmap_map_part *part; /* what of the map was asked; NULL: all of it */
    const char *detector; /* whose registrations have a value each, by name or pattern; NULL: as
                             the quantity says */
};

enum rmap_status rmap_stats_print(const struct rmap_stats *stats,
                                  const struct rmap_stats_labels *labels, FILE *out,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Lines of "# key: value", then a row per bin and group: edges, flux, standard error, rays. */
void rmap_stats_csv(const struct rmap_stats *stats, const struct rmap_stats_labels *labels,
                    FILE *out);

/* New reference; NULL when memory is short. */
json_t *rmap_stats_json(const struct rmap_stats *stats, const struct rmap_stats_labels *labels);

/* "x(sensor), mm". Whether the group is one of those asked for. */
void rmap_stats_name(const struct rmap_stats *stats, size_t quantity, char *name, size_t nbytes);
bool rmap_stats_shows(const struct rmap_stats *stats, size_t group);

/* "W", "lm". */
const char *rmap_stats_flux_unit(const struct rmap_stats *stats);

#endif

/* SPDX-License-Identifier: MIT
 *
 * What the paths of a portion's rays say by themselves, as columns.
 */
#ifndef RMAP_COMPACT_DECODE_PATHS_H
#define RMAP_COMPACT_DECODE_PATHS_H

#include "compact/paths.h"

/* Columns that the head of a path says. */
#define RMAP_HEAD_COLUMNS                                                                          \
    (RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_stop) |                           \
     RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_registration_count) |      \
     RMAP_COLUMN_BIT(RMAP_RAY_start_object))
/* And its registrations. */
#define RMAP_CROSSING_COLUMNS                                                                      \
    (RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector) |    \
     RMAP_COLUMN_BIT(RMAP_REGISTRATION_registered))

/* A portion's paths: those that its rays refer to, and its own ones. Streams as typed rows. */
struct rmap_own_paths {
    const struct rmap_compact_model *model;
    const struct rmap_path_table *table;
    bool classed; /* object: the classes of segments; event: nothing */
    const uint32_t *path;
    const int32_t *source, *detector;
    const uint8_t *stop, *registered;
    const uint32_t *start_object, *segment_count, *registration_count, *object, *event, *segment;
    size_t n, n_segment, n_registration; /* rows of its own */
};
struct rmap_own_paths rmap_own_paths(const struct rmap_compact_model *model,
                                     const struct rmap_path_table *table,
                                     const struct rmap_rows *rows, bool classed);

/* The paths exist, and their rows add up to what the index promises; without `path`, those of its
 * own to as many as are there, as far as their counts are there. RMAP_FORMAT. */
enum rmap_status rmap_own_paths_check(const struct rmap_own_paths *own,
                                      const size_t n_row[RMAP_TABLE_COUNT],
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Columns asked for, whose rows are there. */
void rmap_paths_fill(const struct rmap_own_paths *own, rmap_column_set columns,
                     struct rmap_portion *out);

/* The segments of own path k, which begin at row `from` of theirs. */
void rmap_own_path_unfold(const struct rmap_own_paths *own, size_t k, size_t from,
                          const struct rmap_path_columns *out);

/* The own paths alone, as rays side by side: how many segments they have, and what else of
 * RMAP_COLUMNS_DISCRETE `columns` names; their rows are there. */
void rmap_own_paths_unfold(const struct rmap_own_paths *own, rmap_column_set columns,
                           struct rmap_portion *out);

#endif

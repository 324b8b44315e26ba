/* SPDX-License-Identifier: MIT
 *
 * What is known of a sweep's variants: a row each, with the answers and their standard errors; and
 * what the rows say together: which share of the samples meets the requirements, and which
 * parameters matter.
 */
#ifndef RMAP_SWEEP_TABLE_H
#define RMAP_SWEEP_TABLE_H

#include <jansson.h>
#include <stdio.h>

#include "analysis/sweep/sweep_parts.h"

struct rmap_sweep_result {
    double value, standard_error; /* NaN: not defined */
    double difference_error;      /* of the difference to variant 0, which has the same rays */
    char unit[24];
};

struct rmap_sweep_table {
    const struct rmap_sweep *sweep;
    bool *is_known;                   /* [n_variant] */
    char **mistake;                   /* [n_variant] why it has no answers; NULL: it has */
    struct rmap_sweep_result *result; /* [n_variant][n_answer]; units: of the nominal variant */
    double *nominal_part;             /* [n_answer][RMAP_SWEEP_PARTS] of variant 0 */
};

enum rmap_status rmap_sweep_table_init(struct rmap_sweep_table *table,
                                       const struct rmap_sweep *sweep,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_sweep_table_fini(struct rmap_sweep_table *table); /* zeroed: fine */

const struct rmap_sweep_result *rmap_sweep_table_row(const struct rmap_sweep_table *table,
                                                     uint64_t variant);

/* An answer less that of the scene as it is; NaN where one of them is not known. */
double rmap_sweep_difference(const struct rmap_sweep_table *table, uint64_t variant, size_t answer);

/* Fills in the differences' errors of a variant whose answers have these parts; those of variant 0
 * are kept. */
void rmap_sweep_row_differ(struct rmap_sweep_table *table, uint64_t variant, const double *part);

/* A variant that is no scene, or one that the answers cannot be asked of: a row without them.
 * RMAP_SYSTEM. */
enum rmap_status rmap_sweep_row_fail(struct rmap_sweep_table *table, uint64_t variant,
                                     const char *mistake, struct rmap_error *err) RMAP_MUST_USE;

/* How many have no answers. */
uint64_t rmap_sweep_n_failed(const struct rmap_sweep_table *table);

/* A row as one line of a journal, and from it: what is no whole line of this sweep changes nothing.
 * The line: rmap_free; NULL when memory is short. */
char *rmap_sweep_row_line(const struct rmap_sweep_table *table, uint64_t variant);
void rmap_sweep_row_take(struct rmap_sweep_table *table, const char *line, size_t nbytes);

/* Whether a variant meets all requirements; an answer that is not defined meets none. */
bool rmap_sweep_row_meets(const struct rmap_sweep_table *table, uint64_t variant);

/* Share of the variants but the nominal one that meet the requirements. standard_error:
 * sqrt(p (1 - p) / n), where none or all do with p = (k + 1) / (n + 2). */
struct rmap_sweep_yield {
    uint64_t n, n_met;
    double share, standard_error;
};
struct rmap_sweep_yield rmap_sweep_yield_of(const struct rmap_sweep_table *table);

/* How a parameter bears on an answer: of the least squares fit of a sum of a straight line and a
 * parabola of every parameter. slope: of the line at the mean of the values, per unit of the
 * parameter. share: of the answer's variance over the variants. NaN: not to be had, as where two
 * parameters move together. */
struct rmap_sweep_effect {
    size_t parameter;
    double slope, slope_error, share;
};

/* effect: [n_parameter], the greatest share first. *explained_ret: the fit's share of the variance
 * (R squared). RMAP_SYSTEM. */
enum rmap_status rmap_sweep_effects(const struct rmap_sweep_table *table, size_t answer,
                                    struct rmap_sweep_effect *effect, double *explained_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* A file with a row per variant; CSV begins with lines "# key: value". RMAP_SYSTEM. */
enum rmap_status rmap_sweep_table_csv(const struct rmap_sweep_table *table, const char *path,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_sweep_table_h5(const struct rmap_sweep_table *table, const char *path,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* For people; and a JSON object (new reference; NULL when memory is short). */
enum rmap_status rmap_sweep_table_print(const struct rmap_sweep_table *table, FILE *out,
                                        struct rmap_error *err) RMAP_MUST_USE;
json_t *rmap_sweep_table_json(const struct rmap_sweep_table *table);

#endif

/* SPDX-License-Identifier: MIT
 *
 * How the rays of a sample are distributed over the bins of a number (analysis/query/quantity.h),
 * or over classes of paths: source, objects met, events, by names, so that paths of two scenes are
 * the same where they are called the same. Classes are hashed into a fixed number of bins: every
 * ray lies in one, so a chi-square over them is exact whatever share a bin, and memory is bounded.
 */
#ifndef RMAP_COMPARE_FIELD_H
#define RMAP_COMPARE_FIELD_H

#include "analysis/compare/compare.h"
#include "analysis/compare/compare_cut.h"
#include "analysis/query/quantity.h"

#define RMAP_COMPARE_PATH_BINS 4096
#define RMAP_COMPARE_BINS_MAX  1000

/* Plain data; rmap_compare_field_plan_fini. */
struct rmap_compare_field_plan {
    const struct rmap_map *map;               /* borrowed */
    const struct rmap_quantities *quantities; /* borrowed; NULL: paths */
    uint64_t *object, *medium, *source;       /* of paths: hashes of names */
    const struct rmap_compare_cut *cut;       /* borrowed; NULL: equal bins */
    size_t n_source, n_bin;                   /* 0 bins: only the extent */
    double low, high;                         /* of all bins; the last one has its upper end */
    size_t n_merged;  /* merge neighbours to about so many with as many rays each; 0: as they are */
    size_t n_product; /* per source: of pairs of bins; 0: paths */
    size_t n_value;
};

/* RMAP_SYSTEM. */
enum rmap_status rmap_compare_paths_plan(struct rmap_compare_field_plan *plan,
                                         const struct rmap_map *map,
                                         struct rmap_error *err) RMAP_MUST_USE;
/* Of the first of the quantities, in equal bins; readings outside [low, high] have a bin each below
 * and above. n_bin 0: finds the extent. RMAP_SYSTEM, with the reason. */
enum rmap_status rmap_compare_number_plan(struct rmap_compare_field_plan *plan,
                                          const struct rmap_quantities *quantities, size_t n_bin,
                                          double low, double high,
                                          struct rmap_error *err) RMAP_MUST_USE;
/* In the bins of a cut between low and high (borrowed; NULL: counts readings in its cells, of all
 * sources together). */
enum rmap_status rmap_compare_cut_plan(struct rmap_compare_field_plan *plan,
                                       const struct rmap_quantities *quantities,
                                       const struct rmap_compare_cut *cut, double low, double high,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_compare_field_plan_fini(struct rmap_compare_field_plan *plan);
rmap_column_set rmap_compare_field_columns(const struct rmap_compare_field_plan *plan);

struct rmap_compare_field {
    const struct rmap_compare_field_plan *plan; /* borrowed */
    double *value;                              /* all that follows [n_value] */
    double *extent;   /* [2] least and largest reading; +-HUGE_VAL where there is none */
    double *repeated; /* rays that do not count once in one bin */
    double *count;    /* [n_source][n_bin] */
    double *product;  /* [n_source][n_product] lower triangle, as in struct rmap_products */
    struct rmap_readings readings;
    double *own; /* [n_bin] of the ray in hand */
    size_t *met;
};

/* context: the plan; state: struct rmap_compare_field. */
extern const struct rmap_fold_kind rmap_compare_field_kind;

/* One more test. fields: as the sums of rmap_comparison_add_sums. */
enum rmap_status rmap_comparison_add_field(struct rmap_comparison *comparison,
                                           enum rmap_compare_kind kind, const char *name,
                                           const struct rmap_compare_field *const fields[3],
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif

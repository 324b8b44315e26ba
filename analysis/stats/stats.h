/* SPDX-License-Identifier: MIT
 *
 * Statistics of one or two numbers of rays or registrations: flux, mean, standard deviation,
 * skewness, kurtosis, quantiles and a histogram, weighted by flux, each with its standard error.
 *
 * Errors: with the sums q of a ray's contributions, T = sum_s f_s sum q has the covariances
 * sum_s f_s^2 N_s / (N_s - 1) (sum q_j q_k - sum q_j sum q_k / N_s), N_s the rays that source s
 * emitted; moments and ratios by the delta method; quantiles after Woodruff (1952),
 * doi:10.1080/01621459.1952.10483443: half of Q(p + e) - Q(p - e), e being the error of the share
 * of flux below Q(p).
 */
#ifndef RMAP_STATS_H
#define RMAP_STATS_H

#include "analysis/stats/stats_gather.h"
#include "analysis/stats/stats_sums.h"

/* How the histogram is cut along a quantity. */
struct rmap_stats_axis {
    size_t n_bin; /* 0: not said */
    double *edge; /* [n_edge], or NULL; borrowed */
    size_t n_edge;
    bool has_range, logarithmic;
    double range[2];
};

#define RMAP_STATS_NBYTES_MAX (1024.0 * 1024.0 * 1024.0)

/* RMAP_USAGE when the bins asked for would take more memory than that. */
enum rmap_status rmap_stats_check_bins(const struct rmap_stats_setup *setup,
                                       const struct rmap_stats_axis *axis,
                                       struct rmap_error *err) RMAP_MUST_USE;

/* range: [n_group][n quantities]. The setup is borrowed. */
enum rmap_status
rmap_stats_plan_init(struct rmap_stats_plan *plan, const struct rmap_stats_setup *setup,
                     const struct rmap_stats_known *known, const struct rmap_stats_range *range,
                     const struct rmap_stats_axis *axis, struct rmap_error *err) RMAP_MUST_USE;
void rmap_stats_plan_fini(struct rmap_stats_plan *plan);

struct rmap_stats_estimate {
    double value, standard_error;
};

struct rmap_stats_moment_estimates {
    struct rmap_stats_estimate flux, mean, deviation, skewness, kurtosis;
};

struct rmap_stats_summary {
    struct rmap_stats_moment_estimates moment;
    double least, greatest;               /* NaN without readings */
    struct rmap_stats_estimate *quantile; /* [n_quantile] */
};

struct rmap_stats_group {
    const char *name;          /* as stats_groups.h has it; NULL: all together. Borrowed */
    char *named;               /* name, where it is "lamp of CRITERION"; else NULL */
    uint64_t n_ray, n_reading; /* rays with readings, and these */
    struct rmap_stats_estimate flux;
    struct rmap_stats_summary of[RMAP_QUANTITIES_MAX];
    struct rmap_stats_estimate *cell; /* [n_cell + RMAP_STATS_BEYOND] flux */
    double *cell_rays;                /* same layout */
};

struct rmap_stats {
    const struct rmap_stats_setup *setup;
    const struct rmap_stats_plan *plan;
    struct rmap_stats_known known;
    double resolution[RMAP_QUANTITIES_MAX]; /* of quantiles; 0: exact */
    size_t n_quantile;
    const double *p; /* [n_quantile], borrowed */
    size_t n_group;
    struct rmap_stats_group *group;
};

/* All but the result is borrowed. */
enum rmap_status rmap_stats_create(const struct rmap_stats_plan *plan,
                                   const struct rmap_stats_gathered *gathered,
                                   const struct rmap_stats_sums *sums, const double *p,
                                   size_t n_quantile, struct rmap_stats **stats_ret,
                                   struct rmap_error *err) RMAP_MUST_USE;
void rmap_stats_destroy(struct rmap_stats *stats); /* NULL is fine */

/* Moments of u from totals and covariances of q, in the units of value = centre + scale u. */
void rmap_stats_estimate_moments(const double total[RMAP_MOMENTS],
                                 double covariance[RMAP_MOMENTS][RMAP_MOMENTS], double centre,
                                 double scale, struct rmap_stats_moment_estimates *estimates);

#endif

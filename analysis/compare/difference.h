/* SPDX-License-Identifier: MIT
 *
 * Whether two samples of rays differ by more than chance makes them: one number (z) or a
 * distribution over bins (chi-square).
 *
 * Ray i of source s stands for the flux f_s q_i, with f_s = Phi_s / N_s and q_i what it adds to a
 * number. Samples of two maps are independent: under the hypothesis that both are the same, q has
 * one variance, which the rays of both tell together, and T = sum f q of each the variance N_s
 * f_s^2 times that. Samples that two criteria pick out of one map share rays. Those cancel, and the
 * rays that only one of them holds, with + and -, are one sample of N_s rays.
 */
#ifndef RMAP_DIFFERENCE_H
#define RMAP_DIFFERENCE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

/* A source of both maps, or of one of them. */
struct rmap_stratum {
    int32_t source[2]; /* index in each map; -1: not there */
    double emitted[2]; /* N */
    double unit[2];    /* f */
    double shared;     /* rays that are the same in both maps: same seed, id and scene */
};

struct rmap_strata {
    struct rmap_stratum *stratum; /* [n] */
    size_t n;
    bool paired; /* both samples come from one map, less what both hold */
};

/* Of one stratum: sums of q, of q squared, and rays with q > 0. Where the strata are paired [0] and
 * [1] are of the rays in that sample alone, [2] of those in both; else [2] is 0. */
struct rmap_scalar_sums {
    double sum[3], square[3], rays[3];
};

struct rmap_difference {
    double value[2], error[2]; /* flux and its standard error, of each sample by itself */
    double rays[2];
    double difference, standard_error; /* value[0] - value[1]; under the hypothesis */
    double z;                          /* NaN: cannot be said */
    double p;      /* NaN: nothing in either. 0 where values differ that have no error */
    bool is_exact; /* few rays: p is that of the binomial distribution of their number */
};

/* sums: [strata->n]. */
void rmap_difference_scalar(const struct rmap_strata *strata, const struct rmap_scalar_sums *sums,
                            struct rmap_difference *difference);

/* Fewest rays that each sample is expected to have in a bin (Cochran 1954, doi:10.2307/3001616,
 * asks for 5; twice that keeps the tails of chi-square). */
#define RMAP_EXPECTED_MIN 10.0

struct rmap_bins {
    const double *const *count[2]; /* [strata->n][n_bin] rays; NULL: none of that source */
    size_t n_bin;
    double rays_min; /* merge until so many are expected, at least RMAP_EXPECTED_MIN */
};

struct rmap_chi_square {
    double rays[2];    /* in all bins */
    size_t n_bin;      /* after merging; those that were left out counted in */
    double chi_square; /* NaN: too few rays for any bin */
    double degrees;
    double p;
};

/* Pearson's test of homogeneity where every ray lies in one bin at most, once. Neighbouring bins,
 * in the order given, are merged until enough rays are expected; what lies in no bin is one more.
 * Of one source it is Pearson's sum (A - E)^2 / E over both samples; several sources of unlike
 * flux per ray are weighed by that. RMAP_SYSTEM. */
enum rmap_status rmap_difference_bins(const struct rmap_strata *strata,
                                      const struct rmap_bins *bins, struct rmap_chi_square *result,
                                      struct rmap_error *err) RMAP_MUST_USE;

/* Which merged bin [0, *n_group_ret) each bin belongs to; -1: none, it is what the others leave
 * over. is_share: every ray lies in one bin at most, so that the last bin follows from the others.
 * group: [bins->n_bin]. */
void rmap_difference_merge(const struct rmap_strata *strata, const struct rmap_bins *bins,
                           bool is_share, int32_t *group, size_t *n_group_ret);

/* The same test where a ray may count several times and in several bins: the products of what each
 * ray adds to merged bins say how they vary together. */
struct rmap_products {
    size_t n_group;
    const double *const *count[2];   /* [strata->n][n_group] sums of q */
    const double *const *product[2]; /* [strata->n][n_group (n_group + 1) / 2] sums of q_a q_b, row
                                        a of the lower triangle after row a - 1 */
};
enum rmap_status rmap_difference_products(const struct rmap_strata *strata,
                                          const struct rmap_products *products,
                                          struct rmap_chi_square *result,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif

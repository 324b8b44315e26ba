/* SPDX-License-Identifier: MIT */
#include "analysis/compare/difference_internal.h"

#include <math.h>

#include "analysis/table/significance.h"

/* Of a sum of N independent draws: N times the variance of one. NaN for N < 2. */
static double spread(double sum, double square, double n)
{
    return n < 2.0 ? (double)NAN : n / (n - 1.0) * fmax(square - sum * sum / n, 0.0);
}

/* Variance of T_A - T_B per unit variance of q: N_A f_A^2 + N_B f_B^2, less what the same rays have
 * in common. */
double rmap_stratum_scale(const struct rmap_stratum *stratum)
{
    double scale = -2.0 * stratum->unit[0] * stratum->unit[1] * stratum->shared;
    for (int k = 0; k < 2; k++)
        scale += stratum->emitted[k] * stratum->unit[k] * stratum->unit[k];
    return fmax(scale, 0.0);
}

static double variance_of_difference(const struct rmap_stratum *stratum,
                                     const struct rmap_scalar_sums *sums, bool paired)
{
    double n = stratum->emitted[0] + stratum->emitted[1];
    double square = sums->square[0] + sums->square[1];
    if (sums->rays[0] + sums->rays[1] <= 0.0)
        return 0.0;
    if (paired)
        return stratum->unit[0] * stratum->unit[0] *
               spread(sums->sum[0] - sums->sum[1], square, stratum->emitted[0]);
    return rmap_stratum_scale(stratum) * spread(sums->sum[0] + sums->sum[1], square, n) / n;
}

/* Each sample's own flux and error. */
static void estimate(const struct rmap_strata *strata, const struct rmap_scalar_sums *sums, int k,
                     struct rmap_difference *out)
{
    double variance = 0.0;
    for (size_t s = 0; s < strata->n; s++) {
        const struct rmap_stratum *stratum = &strata->stratum[s];
        double unit = stratum->unit[k], sum = sums[s].sum[k] + sums[s].sum[2];
        out->value[k] += unit * sum;
        out->rays[k] += sums[s].rays[k] + sums[s].rays[2];
        if (stratum->source[k] >= 0 && unit > 0.0)
            variance += unit * unit *
                        spread(sum, sums[s].square[k] + sums[s].square[2], stratum->emitted[k]);
    }
    out->error[k] = sqrt(variance);
}

/* Chance that a ray that is in one of the samples is in the first; 0 where that is not the same for
 * all of them, or where rays do not count as 1. */
static double chance_of_first(const struct rmap_strata *strata, const struct rmap_scalar_sums *sums)
{
    double chance = 0.0, unit = 0.0;
    for (size_t s = 0; s < strata->n; s++) {
        const struct rmap_stratum *stratum = &strata->stratum[s];
        double rays = sums[s].rays[0] + sums[s].rays[1];
        double n = stratum->emitted[0] + stratum->emitted[1];
        double own = strata->paired ? 0.5 : stratum->emitted[0] / n;
        if (rays <= 0.0)
            continue;
        if (sums[s].square[0] + sums[s].square[1] != rays || stratum->shared > 0.0)
            return 0.0;
        if (chance > 0.0 &&
            (fabs(own - chance) > 1e-6 * own || fabs(stratum->unit[0] - unit) > 1e-6 * unit))
            return 0.0;
        /* and the flux of both sources is the same */
        if (!strata->paired &&
            fabs(stratum->unit[0] * stratum->emitted[0] - stratum->unit[1] * stratum->emitted[1]) >
                1e-9 * stratum->unit[0] * stratum->emitted[0])
            return 0.0;
        chance = own;
        unit = stratum->unit[0];
    }
    return chance < 1.0 ? chance : 0.0;
}

/* The normal distribution is a bad guess of few rays, above all where one map has far fewer. */
static void count_few(const struct rmap_strata *strata, const struct rmap_scalar_sums *sums,
                      struct rmap_difference *out)
{
    double chance = chance_of_first(strata, sums), first = 0.0, all = 0.0;
    for (size_t s = 0; s < strata->n; s++) {
        first += sums[s].rays[0];
        all += sums[s].rays[0] + sums[s].rays[1];
    }
    if (chance <= 0.0 || all * fmin(chance, 1.0 - chance) >= RMAP_EXPECTED_MIN)
        return;
    out->is_exact = true;
    out->p = rmap_significance_binomial((uint64_t)first, (uint64_t)all, chance);
}

void rmap_difference_scalar(const struct rmap_strata *strata, const struct rmap_scalar_sums *sums,
                            struct rmap_difference *out)
{
    double variance = 0.0;
    *out = (struct rmap_difference){.z = (double)NAN, .p = (double)NAN};
    for (int k = 0; k < 2; k++)
        estimate(strata, sums, k, out);
    for (size_t s = 0; s < strata->n; s++)
        variance += variance_of_difference(&strata->stratum[s], &sums[s], strata->paired);
    out->difference = out->value[0] - out->value[1];
    /* a difference of rounding is none */
    if (fabs(out->difference) <= 1e-12 * (fabs(out->value[0]) + fabs(out->value[1])))
        out->difference = 0.0;
    out->standard_error = sqrt(variance);
    if (out->rays[0] + out->rays[1] <= 0.0 || isnan(variance))
        return;
    /* nor is a spread of rounding one: all rays of a source count, say */
    if (variance <= 1e-24 * (out->value[0] * out->value[0] + out->value[1] * out->value[1])) {
        out->standard_error = 0.0;
        out->p = out->difference == 0.0 ? 1.0 : 0.0;
        return;
    }
    out->z = out->difference / out->standard_error;
    out->p = rmap_significance_normal(out->z);
    count_few(strata, sums, out);
}

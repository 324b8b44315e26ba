/* SPDX-License-Identifier: MIT
 *
 * Whether two samples of rays differ by more than chance makes them: one number (z) or a
 * distribution over bins (chi-square).
 */
#include <math.h>

#include "analysis/compare/difference.h"
#include "analysis/table/significance.h"
#include "base/alloc.h"

/* Of a sum of N independent draws: N times the variance of one. NaN for N < 2. */
static double spread(double sum, double square, double n)
{
    return n < 2.0 ? (double)NAN : n / (n - 1.0) * fmax(square - sum * sum / n, 0.0);
}

/* Variance of T_A - T_B per unit variance of q: N_A f_A^2 + N_B f_B^2, less what the same rays have
 * in common. */
static double stratum_scale(const struct rmap_stratum *stratum)
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
    return stratum_scale(stratum) * spread(sums->sum[0] + sums->sum[1], square, n) / n;
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

/* Let D be the differences of flux in merged bins, M their covariance under the hypothesis: D'
 * M^-1 D has the chi-square distribution. Where a ray lies in one bin at most M is a diagonal less
 * one product u u' per source, which the formula of Sherman, Morrison and Woodbury inverts; of one
 * source D' M^-1 D is Pearson's sum then. */

/* A pivot smaller than that, of one that was 1: what it stands for follows from the others. */
static const double PIVOT_MIN = 1e-9;

/* Rays that each sample is expected to have in a bin. */
static void expected(const struct rmap_strata *strata, const struct rmap_bins *bins, size_t bin,
                     double rays[2])
{
    rays[0] = rays[1] = 0.0;
    for (size_t s = 0; s < strata->n; s++) {
        const struct rmap_stratum *stratum = &strata->stratum[s];
        double found = 0.0, n = stratum->emitted[0] + stratum->emitted[1];
        for (int k = 0; k < 2; k++)
            found += bins->count[k][s] ? bins->count[k][s][bin] : 0.0;
        for (int k = 0; k < 2 && n > 0.0; k++)
            rays[k] += found * (strata->paired ? 0.5 : stratum->emitted[k] / n);
    }
}

void rmap_difference_merge(const struct rmap_strata *strata, const struct rmap_bins *bins,
                           bool is_share, int32_t *group, size_t *n_group_ret)
{
    double held[2] = {0.0, 0.0}, rest[2] = {0.0, 0.0}, enough = bins->rays_min;
    int32_t n = 0;
    if (!(enough >= RMAP_EXPECTED_MIN))
        enough = RMAP_EXPECTED_MIN;
    for (size_t s = 0; s < strata->n; s++)
        for (int k = 0; k < 2; k++)
            rest[k] += strata->stratum[s].emitted[k];
    for (size_t b = 0; b < bins->n_bin; b++) {
        double rays[2];
        expected(strata, bins, b, rays);
        group[b] = n;
        for (int k = 0; k < 2; k++) {
            held[k] += rays[k];
            rest[k] -= rays[k];
        }
        if (held[0] < enough || held[1] < enough)
            continue;
        held[0] = held[1] = 0.0;
        n++;
    }
    /* What is left over goes to the last one, and that to the rays outside when those are few. */
    for (size_t b = bins->n_bin; b-- > 0 && group[b] == n;)
        group[b] = n - 1;
    if (is_share && !strata->paired && (rest[0] < enough || rest[1] < enough)) {
        n--;
        for (size_t b = bins->n_bin; b-- > 0 && group[b] == n;)
            group[b] = -1;
    }
    *n_group_ret = n > 0 ? (size_t)n : 0;
}

/* In place: the lower triangle of a symmetric [n][n] becomes L with L L' = it, row by row. Rows
 * that follow from those before become 0; returns how many do not. */
static size_t factorise(double *m, size_t n)
{
    size_t rank = 0;
    for (size_t i = 0; i < n; i++) {
        double whole = m[i * n + i];
        for (size_t j = 0; j <= i; j++) {
            double x = m[i * n + j];
            for (size_t k = 0; k < j; k++)
                x -= m[i * n + k] * m[j * n + k];
            if (j < i)
                m[i * n + j] = m[j * n + j] > 0.0 ? x / m[j * n + j] : 0.0;
            else
                m[i * n + i] = x > PIVOT_MIN * whole && whole > 0.0 ? sqrt(x) : 0.0;
        }
        rank += m[i * n + i] > 0.0;
    }
    return rank;
}

/* x' (L L')^-1 x, over rows that are not 0; x becomes L^-1 x. */
static double quadratic(const double *l, size_t n, double *x)
{
    double sum = 0.0;
    for (size_t i = 0; i < n; i++) {
        for (size_t k = 0; k < i; k++)
            x[i] -= l[i * n + k] * x[k];
        x[i] = l[i * n + i] > 0.0 ? x[i] / l[i * n + i] : 0.0;
        sum += x[i] * x[i];
    }
    return sum;
}

/* Merged counts and what follows from them. */
struct table {
    size_t n_stratum, n_group;
    double *rays[2];    /* [n_stratum][n_group] */
    double *difference; /* [n_group] D */
    double *diagonal;   /* [n_group] */
    double *weight;     /* [n_stratum] of the products u u' */
    double *u;          /* [n_stratum][n_group] */
    double *core;       /* [n_stratum][n_stratum] */
    double *right;      /* [n_stratum] */
};

static void table_fini(struct table *table)
{
    for (int k = 0; k < 2; k++)
        rmap_free(table->rays[k]);
    rmap_free(table->difference);
    rmap_free(table->diagonal);
    rmap_free(table->weight);
    rmap_free(table->u);
    rmap_free(table->core);
    rmap_free(table->right);
}

/* table_fini after a failure, too. */
static enum rmap_status table_init(struct table *table, size_t n_stratum, size_t n_group,
                                   struct rmap_error *err)
{
    *table = (struct table){.n_stratum = n_stratum, .n_group = n_group};
    for (int k = 0; k < 2; k++)
        table->rays[k] = rmap_alloc(n_stratum * n_group + 1, sizeof(double));
    table->difference = rmap_alloc(n_group + 1, sizeof(double));
    table->diagonal = rmap_alloc(n_group + 1, sizeof(double));
    table->weight = rmap_alloc(n_stratum + 1, sizeof(double));
    table->u = rmap_alloc(n_stratum * n_group + 1, sizeof(double));
    table->core = rmap_alloc(n_stratum * n_stratum + 1, sizeof(double));
    table->right = rmap_alloc(n_stratum + 1, sizeof(double));
    if (table->rays[0] && table->rays[1] && table->difference && table->diagonal && table->weight &&
        table->u && table->core && table->right)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory to compare %zu bins of %zu sources",
                          n_group, n_stratum);
}

static void gather(struct table *table, const struct rmap_bins *bins, const int32_t *group,
                   struct rmap_chi_square *result)
{
    for (size_t s = 0; s < table->n_stratum; s++)
        for (int k = 0; k < 2; k++)
            for (size_t b = 0; b < bins->n_bin && bins->count[k][s]; b++) {
                result->rays[k] += bins->count[k][s][b];
                if (group[b] >= 0)
                    table->rays[k][s * table->n_group + (size_t)group[b]] += bins->count[k][s][b];
            }
}

/* One source's part of the differences and of their covariance. */
static void add_stratum(struct table *table, const struct rmap_stratum *stratum, size_t s,
                        bool paired)
{
    const double *a = table->rays[0] + s * table->n_group, *b = table->rays[1] + s * table->n_group;
    double *u = table->u + s * table->n_group;
    double n = stratum->emitted[0] + (paired ? 0.0 : stratum->emitted[1]);
    double scale = paired ? stratum->unit[0] * stratum->unit[0] : stratum_scale(stratum) / n;
    if (n <= 0.0)
        return;
    table->weight[s] = scale / n;
    for (size_t g = 0; g < table->n_group; g++) {
        table->difference[g] += stratum->unit[0] * a[g] - stratum->unit[1] * b[g];
        table->diagonal[g] += scale * (a[g] + b[g]);
        u[g] = paired ? a[g] - b[g] : a[g] + b[g];
    }
}

/* D' M^-1 D = D' V^-1 D + w' (1 - W U' V^-1 U W)^-1 w with w = W U' V^-1 D, V the diagonal and W
 * the roots of the weights. False: one of the bins follows from the others. */
static bool solve(struct table *table, double *chi_square)
{
    size_t n = table->n_stratum;
    *chi_square = 0.0;
    for (size_t g = 0; g < table->n_group; g++) /* a bin without spread has no difference */
        table->diagonal[g] = table->diagonal[g] > 0.0 ? table->diagonal[g] : HUGE_VAL;
    for (size_t g = 0; g < table->n_group; g++)
        *chi_square += table->difference[g] * table->difference[g] / table->diagonal[g];
    for (size_t i = 0; i < n; i++) {
        const double *u = table->u + i * table->n_group;
        table->right[i] = 0.0;
        for (size_t g = 0; g < table->n_group; g++)
            table->right[i] += u[g] * table->difference[g] / table->diagonal[g];
        table->right[i] *= sqrt(table->weight[i]);
        for (size_t j = 0; j <= i; j++) {
            const double *v = table->u + j * table->n_group;
            double sum = 0.0;
            for (size_t g = 0; g < table->n_group; g++)
                sum += u[g] * v[g] / table->diagonal[g];
            table->core[i * n + j] =
                (i == j ? 1.0 : 0.0) - sum * sqrt(table->weight[i] * table->weight[j]);
        }
    }
    for (size_t i = 0; i < n; i++)
        if (table->core[i * n + i] < PIVOT_MIN)
            return false;
    if (factorise(table->core, n) < n)
        return false;
    *chi_square += quadratic(table->core, n, table->right);
    return true;
}

/* Takes the last group out of the table. */
static void drop_last(struct table *table)
{
    size_t n = table->n_group;
    for (size_t s = 0; s < table->n_stratum; s++)
        for (size_t g = 0; g + 1 < n; g++)
            table->u[s * (n - 1) + g] = table->u[s * n + g];
    table->n_group--;
}

static void conclude(struct rmap_chi_square *result, double chi_square, size_t degrees)
{
    result->chi_square = chi_square;
    result->degrees = (double)degrees;
    result->p = rmap_significance_chi_square(chi_square, (double)degrees);
}

static const struct rmap_chi_square NOTHING = {.chi_square = (double)NAN, .p = (double)NAN};

enum rmap_status rmap_difference_bins(const struct rmap_strata *strata,
                                      const struct rmap_bins *bins, struct rmap_chi_square *result,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct table table = {0};
    size_t n_group = 0;
    double chi_square = 0.0;
    bool any = false;
    int32_t *group = rmap_alloc(bins->n_bin + 1, sizeof *group);
    *result = NOTHING;
    if (!group)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", bins->n_bin);
    rmap_difference_merge(strata, bins, true, group, &n_group);
    RMAP_TRY(table_init(&table, strata->n, n_group, err));
    gather(&table, bins, group, result);
    for (size_t s = 0; s < strata->n; s++)
        add_stratum(&table, &strata->stratum[s], s, strata->paired);
    for (size_t g = 0; g < n_group; g++)
        any = any || table.diagonal[g] > 0.0;
    if (n_group == 0)
        goto out;
    result->n_bin = n_group + (strata->paired ? 0 : 1);
    if (!any) { /* the same rays in both maps */
        conclude(result, 0.0, n_group);
        goto out;
    }
    while (table.n_group > 0 && !solve(&table, &chi_square))
        drop_last(&table);
    if (table.n_group > 0)
        conclude(result, chi_square, table.n_group);
out:
    table_fini(&table);
    rmap_free(group);
    return st;
}

/* Adds one source's covariance of the merged bins to the lower triangle of m. */
static void add_products(const struct rmap_stratum *stratum, const double *const count[2],
                         const double *const product[2], bool paired, double *difference, double *m,
                         size_t n_group)
{
    double n = stratum->emitted[0] + (paired ? 0.0 : stratum->emitted[1]);
    double scale = paired ? stratum->unit[0] * stratum->unit[0] : stratum_scale(stratum) / n;
    double sign = paired ? -1.0 : 1.0;
    if (n <= 0.0)
        return;
    for (size_t i = 0; i < n_group; i++) {
        double q[2] = {count[0] ? count[0][i] : 0.0, count[1] ? count[1][i] : 0.0};
        difference[i] += stratum->unit[0] * q[0] - stratum->unit[1] * q[1];
        for (size_t j = 0; j <= i; j++) {
            double other = (count[0] ? count[0][j] : 0.0) + sign * (count[1] ? count[1][j] : 0.0);
            double both = 0.0;
            for (int k = 0; k < 2; k++)
                both += product[k] ? product[k][i * (i + 1) / 2 + j] : 0.0;
            m[i * n_group + j] += scale * (both - (q[0] + sign * q[1]) * other / n);
        }
    }
}

enum rmap_status rmap_difference_products(const struct rmap_strata *strata,
                                          const struct rmap_products *products,
                                          struct rmap_chi_square *result, struct rmap_error *err)
{
    size_t n = products->n_group;
    double *m = rmap_alloc(n * n + 1, sizeof *m), *difference = rmap_alloc(n + 1, sizeof *m);
    enum rmap_status st = RMAP_OK;
    *result = NOTHING;
    if (!m || !difference) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory to compare %zu bins", n);
        goto out;
    }
    for (size_t s = 0; s < strata->n; s++) {
        const double *const count[2] = {products->count[0][s], products->count[1][s]};
        const double *const product[2] = {products->product[0][s], products->product[1][s]};
        add_products(&strata->stratum[s], count, product, strata->paired, difference, m, n);
        for (size_t g = 0; g < n; g++)
            for (int k = 0; k < 2; k++)
                result->rays[k] += count[k] ? count[k][g] : 0.0;
    }
    if (n == 0)
        goto out;
    result->n_bin = n;
    size_t rank = factorise(m, n);
    conclude(result, quadratic(m, n, difference), rank > 0 ? rank : n);
out:
    rmap_free(m);
    rmap_free(difference);
    return st;
}

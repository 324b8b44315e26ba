/* SPDX-License-Identifier: MIT
 *
 * The test of two distributions: Pearson's where each ray lies in one bin; else by the products of
 * bins, added up over merged ones.
 */
#include <math.h>

#include "analysis/compare/compare_field.h"
#include "base/alloc.h"

/* Per stratum rows of one sample. */
struct rows {
    const double **count;
    double *group_count, *group_product; /* [n_stratum][...] of merged bins */
    const double **group_count_row, **group_product_row;
};

static void rows_fini(struct rows *rows)
{
    rmap_free(rows->count);
    rmap_free(rows->group_count);
    rmap_free(rows->group_product);
    rmap_free(rows->group_count_row);
    rmap_free(rows->group_product_row);
}

static enum rmap_status rows_init(struct rows *rows, const struct rmap_strata *strata,
                                  const struct rmap_compare_field *field, int which,
                                  struct rmap_error *err)
{
    rows->count = rmap_alloc(strata->n + 1, sizeof *rows->count);
    if (!rows->count)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", strata->n);
    for (size_t s = 0; s < strata->n; s++) {
        int32_t source = strata->stratum[s].source[which];
        rows->count[s] = source < 0 ? NULL : field->count + (size_t)source * field->plan->n_bin;
    }
    return RMAP_OK;
}

/* Sums and products of merged bins. */
static enum rmap_status contract(struct rows *rows, const struct rmap_strata *strata,
                                 const struct rmap_compare_field *field, int which,
                                 const int32_t *group, size_t n_group, struct rmap_error *err)
{
    const struct rmap_compare_field_plan *plan = field->plan;
    size_t n_pair = n_group * (n_group + 1) / 2;
    rows->group_count = rmap_alloc(strata->n * n_group + 1, sizeof *rows->group_count);
    rows->group_product = rmap_alloc(strata->n * n_pair + 1, sizeof *rows->group_product);
    rows->group_count_row = rmap_alloc(strata->n + 1, sizeof *rows->group_count_row);
    rows->group_product_row = rmap_alloc(strata->n + 1, sizeof *rows->group_product_row);
    if (!rows->group_count || !rows->group_product || !rows->group_count_row ||
        !rows->group_product_row)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory to compare %zu bins", n_group);
    for (size_t s = 0; s < strata->n; s++) {
        int32_t source = strata->stratum[s].source[which];
        double *count = rows->group_count + s * n_group, *pair = rows->group_product + s * n_pair;
        const double *product =
            source < 0 ? NULL : field->product + (size_t)source * plan->n_product;
        rows->group_count_row[s] = source < 0 ? NULL : count;
        rows->group_product_row[s] = source < 0 ? NULL : pair;
        for (size_t a = 0; a < plan->n_bin && product; a++) {
            if (group[a] < 0)
                continue;
            count[group[a]] += rows->count[s][a];
            for (size_t b = 0; b <= a; b++) {
                if (group[b] < 0)
                    continue;
                /* bins of one group meet twice, as (a, b) and as (b, a) */
                double times = a != b && group[a] == group[b] ? 2.0 : 1.0;
                size_t i = (size_t)(group[a] > group[b] ? group[a] : group[b]);
                size_t j = (size_t)(group[a] > group[b] ? group[b] : group[a]);
                pair[i * (i + 1) / 2 + j] += times * product[a * (a + 1) / 2 + b];
            }
        }
    }
    return RMAP_OK;
}

static enum rmap_status test_products(struct rmap_comparison *comparison, struct rows rows[2],
                                      const struct rmap_compare_field *const fields[2],
                                      const struct rmap_bins *bins, struct rmap_chi_square *result,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_group = 0;
    int32_t *group = rmap_alloc(bins->n_bin + 1, sizeof *group);
    if (!group)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", bins->n_bin);
    rmap_difference_merge(&comparison->strata, bins, false, group, &n_group);
    for (int k = 0; k < 2; k++)
        RMAP_TRY(contract(&rows[k], &comparison->strata, fields[k], k, group, n_group, err));
    const struct rmap_products products = {
        .n_group = n_group,
        .count = {rows[0].group_count_row, rows[1].group_count_row},
        .product = {rows[0].group_product_row, rows[1].group_product_row}};
    st = rmap_difference_products(&comparison->strata, &products, result, err);
out:
    rmap_free(group);
    return st;
}

static double rays_of(const struct rmap_compare_field *field)
{
    double sum = 0.0;
    for (size_t i = 0; i < field->plan->n_source * field->plan->n_bin; i++)
        sum += field->count[i];
    return sum;
}

enum rmap_status rmap_comparison_add_field(struct rmap_comparison *comparison,
                                           enum rmap_compare_kind kind, const char *name,
                                           const struct rmap_compare_field *const fields[3],
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rows rows[2] = {{0}, {0}};
    struct rmap_chi_square result;
    const struct rmap_compare_field_plan *plan = fields[0]->plan;
    const struct rmap_strata *strata = &comparison->strata;
    for (int k = 0; k < 2; k++)
        RMAP_TRY(rows_init(&rows[k], strata, fields[k], k, err));
    struct rmap_bins bins = {.count = {rows[0].count, rows[1].count}, .n_bin = plan->n_bin};
    if (plan->n_merged > 0)
        bins.rays_min = fmin(rays_of(fields[0]), rays_of(fields[1])) / (double)plan->n_merged;
    if (fields[0]->repeated[0] + fields[1]->repeated[0] <= 0.0 || plan->n_product == 0)
        RMAP_TRY(rmap_difference_bins(strata, &bins, &result, err));
    else
        RMAP_TRY(test_products(comparison, rows, fields, &bins, &result, err));
    for (size_t i = 0; fields[2] && i < plan->n_source * plan->n_bin; i++)
        for (int k = 0; k < 2; k++)
            result.rays[k] += fields[2]->count[i];
    st = rmap_comparison_add_bins(comparison, kind, name, &result, NULL, err);
out:
    for (int k = 0; k < 2; k++)
        rows_fini(&rows[k]);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * How the rays of a sample are distributed over the bins of a number (analysis/query/quantity.h),
 * or over classes of paths.
 */
#include <math.h>
#include <string.h>
#include <xxhash.h>

#include "analysis/compare/compare_field.h"
#include "analysis/query/quantity_read.h"
#include "base/alloc.h"
#include "portion/event.h"
#include "portion/weight.h"

/* 32 Mi numbers: a quarter of a GiB for each thread. */
static const size_t VALUE_MAX = (size_t)32 << 20;

/* A wavelength that is not sure yet spreads over bins. In steps of 2^-12 sums are exact, squares as
 * well, for 2^29 rays. */
static const double SHARE_STEP = 4096.0;

enum { EXTENT = 2, REPEATED = 1 };

static enum rmap_status size_up(struct rmap_compare_field_plan *plan, struct rmap_error *err)
{
    size_t per_source = plan->n_bin + plan->n_product;
    plan->n_value = EXTENT + REPEATED + plan->n_source * per_source;
    if (plan->n_source == 0 || per_source <= VALUE_MAX / plan->n_source)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_SYSTEM,
                          "%zu bins of each of %zu sources are too many to compare in memory",
                          plan->n_bin, plan->n_source);
}

enum rmap_status rmap_compare_number_plan(struct rmap_compare_field_plan *plan,
                                          const struct rmap_quantities *quantities, size_t n_bin,
                                          double low, double high, struct rmap_error *err)
{
    *plan = (struct rmap_compare_field_plan){.map = quantities->map,
                                             .quantities = quantities,
                                             .n_source = rmap_map_scene(quantities->map)->n_source,
                                             .low = low,
                                             .high = high};
    plan->n_bin = n_bin > 0 ? n_bin + 2 : 0;
    plan->n_product = plan->n_bin * (plan->n_bin + 1) / 2;
    return size_up(plan, err);
}

enum rmap_status rmap_compare_cut_plan(struct rmap_compare_field_plan *plan,
                                       const struct rmap_quantities *quantities,
                                       const struct rmap_compare_cut *cut, double low, double high,
                                       struct rmap_error *err)
{
    enum rmap_status st = rmap_compare_number_plan(
        plan, quantities, cut ? cut->n_bin : RMAP_COMPARE_CELLS, low, high, err);
    plan->cut = cut;
    if (cut)
        return st;
    plan->n_source = 1;
    plan->n_product = 0;
    return size_up(plan, err);
}

enum rmap_status rmap_compare_paths_plan(struct rmap_compare_field_plan *plan,
                                         const struct rmap_map *map, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(map);
    *plan = (struct rmap_compare_field_plan){
        .map = map, .n_source = scene->n_source, .n_bin = RMAP_COMPARE_PATH_BINS};
    plan->object = rmap_alloc(scene->n_object + 1, sizeof *plan->object);
    plan->medium = rmap_alloc(scene->n_medium + 1, sizeof *plan->medium);
    plan->source = rmap_alloc(scene->n_source + 1, sizeof *plan->source);
    if (!plan->object || !plan->medium || !plan->source) {
        rmap_compare_field_plan_fini(plan);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu names", scene->n_object);
    }
    for (size_t i = 0; i < scene->n_object; i++)
        plan->object[i] = XXH3_64bits(scene->object[i].name, strlen(scene->object[i].name));
    for (size_t i = 0; i < scene->n_medium; i++)
        plan->medium[i] = XXH3_64bits(scene->medium[i].name, strlen(scene->medium[i].name));
    for (size_t i = 0; i < scene->n_source; i++)
        plan->source[i] = XXH3_64bits(scene->source[i].name, strlen(scene->source[i].name));
    return size_up(plan, err);
}

void rmap_compare_field_plan_fini(struct rmap_compare_field_plan *plan)
{
    rmap_free(plan->object);
    rmap_free(plan->medium);
    rmap_free(plan->source);
    *plan = (struct rmap_compare_field_plan){0};
}

rmap_column_set rmap_compare_field_columns(const struct rmap_compare_field_plan *plan)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
                              RMAP_COLUMN_BIT(RMAP_RAY_weight) |
                              RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    if (plan->quantities)
        return columns | plan->quantities->columns;
    return columns | RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_event) |
           RMAP_COLUMN_BIT(RMAP_SEGMENT_medium);
}

static void destroy(void *state)
{
    struct rmap_compare_field *self = state;
    if (!self)
        return;
    rmap_readings_fini(&self->readings);
    rmap_free(self->value);
    rmap_free(self->own);
    rmap_free(self->met);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_compare_field_plan *plan = context;
    struct rmap_compare_field *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->plan = plan;
        self->value = rmap_alloc(plan->n_value, sizeof *self->value);
        self->own = rmap_alloc(plan->n_bin + 1, sizeof *self->own);
        self->met = rmap_alloc(plan->n_bin + 1, sizeof *self->met);
    }
    if (!self || !self->value || !self->own || !self->met) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sums", plan->n_value);
    }
    self->extent = self->value;
    self->repeated = self->extent + EXTENT;
    self->count = self->repeated + REPEATED;
    self->product = self->count + plan->n_source * plan->n_bin;
    self->extent[0] = HUGE_VAL;
    self->extent[1] = -HUGE_VAL;
    *state_ret = self;
    return RMAP_OK;
}

/* ---- paths ---- */

static uint64_t mix(uint64_t hash, uint64_t word)
{
    const uint64_t both[2] = {hash, word};
    return XXH3_64bits(both, sizeof both);
}

static void add_paths(struct rmap_compare_field *self, const struct rmap_matched *rays)
{
    const struct rmap_compare_field_plan *plan = self->plan;
    const struct rmap_portion *portion = rays->portion;
    size_t first = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t end = first + portion->ray.segment_count[i];
        size_t source = (size_t)portion->ray.source[i];
        uint64_t hash = plan->source[source];
        for (size_t k = first; k < end && (!rays->match || rays->match[i]); k++) {
            int32_t object = portion->segment.object[k];
            hash = mix(hash, (uint64_t)rmap_event_letter(portion->segment.event[k]));
            hash = mix(hash, object >= 0 ? plan->object[object]
                                         : plan->medium[portion->segment.medium[k]]);
        }
        first = end;
        if (rays->match && !rays->match[i])
            continue;
        double weight = portion->ray.weight[i];
        self->count[source * plan->n_bin + hash % plan->n_bin] += weight;
        self->repeated[0] += weight != 1.0;
    }
}

/* ---- numbers ---- */

static size_t bin_of(const struct rmap_compare_field_plan *plan, double value)
{
    const size_t n_cell = plan->cut ? RMAP_COMPARE_CELLS : plan->n_bin - 2;
    if (value < plan->low)
        return 0;
    if (value > plan->high)
        return plan->n_bin - 1;
    const double at = (value - plan->low) / (plan->high - plan->low) * (double)n_cell;
    const size_t cell = at < (double)n_cell ? (size_t)at : n_cell - 1;
    return 1 + (plan->cut ? plan->cut->bin[cell] : cell);
}

/* The ray's bins are in `met`; empties them. */
static void add_ray(struct rmap_compare_field *self, size_t source, size_t n_met)
{
    const struct rmap_compare_field_plan *plan = self->plan;
    double *count = self->count + source * plan->n_bin;
    double *product = self->product + source * plan->n_product;
    self->repeated[0] += n_met > 1 || self->own[self->met[0]] != 1.0;
    for (size_t i = 0; i < n_met; i++) {
        size_t a = self->met[i];
        count[a] += self->own[a];
        for (size_t j = 0; j < n_met; j++)
            if (self->met[j] <= a)
                product[a * (a + 1) / 2 + self->met[j]] +=
                    rmap_weight_product(self->own[a], self->own[self->met[j]]);
    }
    for (size_t i = 0; i < n_met; i++)
        self->own[self->met[i]] = 0.0;
}

static enum rmap_status add_numbers(struct rmap_compare_field *self,
                                    const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_compare_field_plan *plan = self->plan;
    const struct rmap_portion *portion = rays->portion;
    const struct rmap_readings *read = &self->readings;
    size_t n_met = 0;
    RMAP_TRY(rmap_quantities_read(plan->quantities, rays, &self->readings, err));
    for (size_t i = 0; i < read->n; i++) {
        double value = read->value[0][i];
        self->extent[0] = fmin(self->extent[0], value);
        self->extent[1] = fmax(self->extent[1], value);
        if (plan->n_bin == 0)
            continue;
        uint32_t ray = read->ray[i];
        size_t bin = bin_of(plan, value);
        if (plan->n_product == 0) {
            self->count[bin] += 1.0;
            continue;
        }
        double q = nearbyint(read->share[i] * SHARE_STEP) / SHARE_STEP * portion->ray.weight[ray];
        if (q > 0.0 && self->own[bin] == 0.0)
            self->met[n_met++] = bin;
        self->own[bin] += q;
        if ((i + 1 == read->n || read->ray[i + 1] != ray) && n_met > 0) {
            add_ray(self, (size_t)portion->ray.source[ray], n_met);
            n_met = 0;
        }
    }
out:
    return st;
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_compare_field *self = state;
    if (self->plan->quantities)
        return add_numbers(self, rays, err);
    add_paths(self, rays);
    return RMAP_OK;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_compare_field *self = into;
    const struct rmap_compare_field *other = from;
    (void)err;
    self->extent[0] = fmin(self->extent[0], other->extent[0]);
    self->extent[1] = fmax(self->extent[1], other->extent[1]);
    for (size_t i = EXTENT; i < self->plan->n_value; i++)
        self->value[i] += other->value[i];
    return RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_compare_field *self = state;
    block[0] = (struct rmap_fold_block){self->value, self->plan->n_value * sizeof *self->value};
    return 1;
}

static bool may_count(const void *context, const struct rmap_portion_info *portion)
{
    const struct rmap_compare_field_plan *plan = context;
    return !plan->quantities || rmap_quantities_may_count(plan->quantities, portion);
}

const struct rmap_fold_kind rmap_compare_field_kind = {.create = create,
                                                       .destroy = destroy,
                                                       .add = add,
                                                       .merge = merge,
                                                       .blocks = blocks,
                                                       .may_count = may_count};

/* The test of two distributions: Pearson's where each ray lies in one bin; else by the products of
 * bins, added up over merged ones. */

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

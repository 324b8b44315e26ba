/* SPDX-License-Identifier: MIT
 *
 * What differs where: a comparison bin by bin, over the cells of a detector or the values of a
 * number.
 */
#include "analysis/compare/compare_bins.h"

#include "analysis/detector/image_unit.h"
#include "analysis/table/csv_field.h"
#include "base/alloc.h"
#include "io/export/json_number.h"

enum { N_ARRAY = 9 };

void rmap_compare_bins_destroy(struct rmap_compare_bins *bins)
{
    if (!bins)
        return;
    rmap_free(bins->name);
    rmap_free(bins->edge);
    rmap_free(bins->memory);
    rmap_free(bins);
}

static enum rmap_status create(const char *name, size_t nu, size_t nv,
                               struct rmap_compare_bins **bins_ret, struct rmap_error *err)
{
    const size_t n = nu * nv;
    struct rmap_compare_bins *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->name = rmap_strdup(name);
        self->memory = rmap_alloc(N_ARRAY * n + 1, sizeof *self->memory);
    }
    if (!self || !self->name || !self->memory) {
        rmap_compare_bins_destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu differences", n);
    }
    self->n[0] = nu;
    self->n[1] = nv;
    double **const array[N_ARRAY] = {&self->value[0], &self->value[1],   &self->error[0],
                                     &self->error[1], &self->difference, &self->standard_error,
                                     &self->z,        &self->place[0],   &self->place[1]};
    for (size_t k = 0; k < N_ARRAY; k++)
        *array[k] = self->memory + k * n;
    *bins_ret = self;
    return RMAP_OK;
}

/* Sums of q of a sample, [n_source][n], and behind them those of q squared. NULL: no rays. */
struct sample {
    const double *sum;
    size_t n_source, n;
};

static void add_part(const struct sample *sample, int32_t source, size_t bin, int k,
                     struct rmap_scalar_sums *into)
{
    if (!sample->sum || source < 0)
        return;
    const double *at = sample->sum + (size_t)source * sample->n + bin;
    into->sum[k] += at[0];
    into->square[k] += at[sample->n_source * sample->n];
    into->rays[k] += at[0];
}

static enum rmap_status fill(const struct rmap_comparison *comparison,
                             const struct sample sample[3], struct rmap_compare_bins *bins,
                             struct rmap_error *err)
{
    const struct rmap_strata *strata = &comparison->strata;
    struct rmap_scalar_sums *scalar = rmap_alloc(strata->n + 1, sizeof *scalar);
    if (!scalar)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", strata->n);
    for (size_t b = 0; b < bins->n[0] * bins->n[1]; b++) {
        struct rmap_difference found;
        for (size_t s = 0; s < strata->n; s++) {
            const int32_t *source = strata->stratum[s].source;
            scalar[s] = (struct rmap_scalar_sums){0};
            add_part(&sample[0], source[0], b, 0, &scalar[s]);
            add_part(&sample[1], source[1], b, 1, &scalar[s]);
            add_part(&sample[2], source[0], b, 2, &scalar[s]);
        }
        rmap_difference_scalar(strata, scalar, &found);
        const double extent = bins->is_image ? rmap_detector_bins_extent(&bins->grid, b) : 1.0;
        for (int k = 0; k < 2; k++) {
            bins->value[k][b] = found.value[k] / extent;
            bins->error[k][b] = found.error[k] / extent;
        }
        bins->difference[b] = found.difference / extent;
        bins->standard_error[b] = found.standard_error / extent;
        bins->z[b] = found.z;
        if (bins->is_image)
            rmap_detector_bins_centre(&bins->grid, (uint32_t)(b % bins->n[0]),
                                      (uint32_t)(b / bins->n[0]), &bins->place[0][b],
                                      &bins->place[1][b]);
    }
    rmap_free(scalar);
    return RMAP_OK;
}

static const char *flux_unit(const struct rmap_comparison *comparison)
{
    return rmap_flux_unit_name(rmap_map_scene(comparison->map[0]));
}

enum rmap_status rmap_compare_bins_of_images(const struct rmap_comparison *comparison,
                                             const struct rmap_detector_sums *const sums[3],
                                             struct rmap_compare_bins **bins_ret,
                                             struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_detector_bins *grid = &sums[0]->ask.bins;
    const bool lumens = rmap_map_scene(comparison->map[0])->flux_unit == RMAP_FLUX_LM;
    struct rmap_compare_bins *bins = NULL;
    struct sample sample[3] = {{NULL, 0, 0}, {NULL, 0, 0}, {NULL, 0, 0}};
    const struct rmap_scene *const scene[2] = {rmap_comparison_scene(comparison, 0),
                                               rmap_comparison_scene(comparison, 1)};
    const size_t detector[2] = {(size_t)sums[0]->ask.detector, (size_t)sums[1]->ask.detector};
    if (!rmap_compare_same_grid(scene, detector))
        return rmap_error_set(err, RMAP_INPUT,
                              "the grids of detector '%s' differ between the maps: there is no "
                              "image of the difference",
                              grid->detector->name);
    RMAP_TRY(create(grid->detector->name, grid->n[0], grid->n[1], &bins, err));
    bins->is_image = true;
    bins->grid = *grid;
    bins->axis_unit = grid->directions ? "deg" : scene[0]->unit;
    bins->quantity = grid->directions ? (lumens ? "luminous intensity" : "radiant intensity")
                                      : (lumens ? "illuminance" : "irradiance");
    bins->unit = rmap_image_unit_usual(grid->directions ? RMAP_PER_SOLID_ANGLE : RMAP_PER_AREA,
                                       scene[0]->flux_unit)
                     ->name;
    for (int k = 0; k < 3; k++)
        if (sums[k])
            sample[k] = (struct sample){sums[k]->weight, sums[k]->n_source, sums[k]->n_cell};
    RMAP_TRY(fill(comparison, sample, bins, err));
    *bins_ret = bins;
    bins = NULL;
out:
    rmap_compare_bins_destroy(bins);
    return st;
}

/* Bins [first, end) of a field joined: a ray in several of them counts once. */
static void join(const struct rmap_compare_field *field, size_t source, size_t first, size_t end,
                 double *sum, double *square)
{
    const struct rmap_compare_field_plan *plan = field->plan;
    const double *count = field->count + source * plan->n_bin;
    const double *product = field->product + source * plan->n_product;
    *sum = *square = 0.0;
    for (size_t a = first; a < end; a++) {
        *sum += count[a];
        for (size_t b = first; b <= a; b++)
            *square += (a == b ? 1.0 : 2.0) * product[a * (a + 1) / 2 + b];
    }
}

/* The field's inner bins, those joined that a cut shows as one; sums [2][n_source][n]. */
static void join_all(const struct rmap_compare_field *field, size_t n, double *sums)
{
    const size_t n_source = field->plan->n_source;
    const struct rmap_compare_cut *cut = field->plan->cut;
    for (size_t s = 0; s < n_source; s++)
        for (size_t k = 0; k < n; k++)
            join(field, s, 1 + (cut ? cut->shown[k] : k), 1 + (cut ? cut->shown[k + 1] : k + 1),
                 &sums[s * n + k], &sums[(n_source + s) * n + k]);
}

enum rmap_status rmap_compare_bins_of_field(const struct rmap_comparison *comparison,
                                            const char *name,
                                            const struct rmap_compare_field *const fields[3],
                                            struct rmap_compare_bins **bins_ret,
                                            struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_compare_field_plan *plan = fields[0]->plan;
    const size_t n = plan->cut ? RMAP_COMPARE_SHOWN : plan->n_bin - 2;
    double *sums[3] = {NULL, NULL, NULL};
    struct sample sample[3] = {{NULL, 0, 0}, {NULL, 0, 0}, {NULL, 0, 0}};
    struct rmap_compare_bins *bins = NULL;
    RMAP_TRY(create(name, n, 1, &bins, err));
    bins->quantity = "flux";
    bins->unit = flux_unit(comparison);
    bins->axis_unit = plan->quantities->of[0].unit;
    bins->edge = rmap_alloc(n + 1, sizeof *bins->edge);
    if (!bins->edge)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", n));
    for (size_t k = 0; k <= n; k++)
        bins->edge[k] = plan->low + (plan->high - plan->low) * (double)k / (double)n;
    for (int i = 0; i < 3; i++) {
        if (!fields[i])
            continue;
        const size_t n_source = fields[i]->plan->n_source;
        sums[i] = rmap_alloc(2 * n_source * n + 1, sizeof(double));
        if (!sums[i])
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu bins", n));
        join_all(fields[i], n, sums[i]);
        sample[i] = (struct sample){sums[i], n_source, n};
    }
    RMAP_TRY(fill(comparison, sample, bins, err));
    *bins_ret = bins;
    bins = NULL;
out:
    for (int i = 0; i < 3; i++)
        rmap_free(sums[i]);
    rmap_compare_bins_destroy(bins);
    return st;
}

static json_t *list_of(const double *value, size_t n)
{
    json_t *list = json_array();
    for (size_t i = 0; i < n; i++)
        (void)json_array_append_new(list, rmap_json_number(value[i]));
    return list;
}

const char *rmap_compare_bins_axis(const struct rmap_compare_bins *bins, int k)
{
    static const char *const name[2][2] = {{"x", "y"}, {"theta", "phi"}};
    return name[bins->grid.directions ? 1 : 0][k];
}

json_t *rmap_compare_bins_json(const struct rmap_compare_bins *self)
{
    const size_t n = self->n[0] * self->n[1];
    json_t *json = json_pack("{s:s, s:s, s:s, s:s}", "name", self->name, "quantity", self->quantity,
                             "unit", self->unit, "axis_unit", self->axis_unit);
    if (self->is_image)
        (void)json_object_set_new(
            json, "cells", json_pack("[I, I]", (json_int_t)self->n[0], (json_int_t)self->n[1]));
    else
        (void)json_object_set_new(json, "edges", list_of(self->edge, n + 1));
    for (int k = 0; k < 2 && self->is_image; k++)
        (void)json_object_set_new(json, rmap_compare_bins_axis(self, k),
                                  list_of(self->place[k], n));
    const struct {
        const char *name;
        const double *value;
    } array[] = {{"a", self->value[0]},
                 {"a_standard_error", self->error[0]},
                 {"b", self->value[1]},
                 {"b_standard_error", self->error[1]},
                 {"difference", self->difference},
                 {"standard_error", self->standard_error},
                 {"z", self->z}};
    for (size_t k = 0; k < sizeof array / sizeof *array; k++)
        (void)json_object_set_new(json, array[k].name, list_of(array[k].value, n));
    return json;
}

void rmap_compare_bins_csv(const struct rmap_comparison *comparison,
                           const struct rmap_compare_bins *self, FILE *out)
{
    for (int k = 0; k < 2; k++) {
        char line[1024];
        rmap_which_caption(comparison->which[k], comparison->criterion[k], line, sizeof line);
        fprintf(out, "# %c: %s, %s\n", 'A' + k, comparison->path[k], line);
    }
    fprintf(out, "# %s: %s, %s\n# axes: %s\n", self->name, self->quantity, self->unit,
            *self->axis_unit ? self->axis_unit : "1");
    if (self->is_image)
        fprintf(out, "i,j,%s,%s", rmap_compare_bins_axis(self, 0), rmap_compare_bins_axis(self, 1));
    else
        fputs("bin,low,high", out);
    fputs(",a,a_standard_error,b,b_standard_error,difference,standard_error,z\n", out);
    for (size_t b = 0; b < self->n[0] * self->n[1]; b++) {
        double x = 0.0, y = 0.0;
        const uint32_t i = (uint32_t)(b % self->n[0]), j = (uint32_t)(b / self->n[0]);
        if (self->is_image) {
            x = self->place[0][b];
            y = self->place[1][b];
            fprintf(out, "%u,%u", i, j);
        } else {
            x = self->edge[b];
            y = self->edge[b + 1];
            fprintf(out, "%zu", b);
        }
        const double number[] = {x,
                                 y,
                                 self->value[0][b],
                                 self->error[0][b],
                                 self->value[1][b],
                                 self->error[1][b],
                                 self->difference[b],
                                 self->standard_error[b],
                                 self->z[b]};
        for (size_t k = 0; k < sizeof number / sizeof *number; k++)
            rmap_csv_put_number(number[k], out);
        fputc('\n', out);
    }
}

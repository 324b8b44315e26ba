/* SPDX-License-Identifier: MIT
 *
 * A comparison as a table for people and as JSON.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/compare/compare.h"
#include "analysis/compare/compare_internal.h"
#include "analysis/compare/compare_out.h"
#include "analysis/compare/compare_products.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "io/map/map_json.h"
#include "portion/weight.h"

static const char *flux_unit(const struct rmap_comparison *self)
{
    return rmap_flux_unit_name(rmap_map_scene(self->map[0]));
}

/* Same seed and ids: what that means, or NULL. */
static const char *dependence(const struct rmap_comparison *self)
{
    if (self->strata.paired)
        return "both samples come from one map: rays that both hold cancel, the test is of those "
               "that one of them holds alone";
    if (self->overlap.identical)
        return "the maps are identical: their digests are equal; there is nothing to test";
    if (self->overlap.rays > 0 && self->overlap.same_scene)
        return "the maps share rays (same scene, seed and ids): they are the same light twice, "
               "which the tests take into account; for an independent sample give another --seed";
    if (self->overlap.rays > 0)
        return "the samples are not independent: both scenes were traced with the same random "
               "numbers (same seed and ids), so they differ less than chance would make them; "
               "trace one with another --seed to test by how much";
    return NULL;
}

static bool independent(const struct rmap_comparison *self)
{
    return !self->strata.paired && self->overlap.rays == 0 && !self->overlap.identical;
}

static void put_value(struct rmap_text_table *table, double value, double error)
{
    if (isnan(error))
        rmap_text_table_add(table, "%.6g", value);
    else
        rmap_text_table_add(table, "%.6g +- %.2g", value, error);
}

static double ratio_of(const struct rmap_compare_test *test)
{
    return test->scalar.value[0] != 0.0 ? test->scalar.value[1] / test->scalar.value[0]
                                        : (double)NAN;
}

static void put_test(struct rmap_text_table *table, const struct rmap_compare_test *test)
{
    rmap_text_table_add(table, "%s", rmap_compare_word[test->kind]);
    rmap_text_table_add(table, "%s", test->name[0] ? test->name : "(all)");
    for (int k = 0; k < 2; k++)
        if (test->is_bins && isnan(test->bins.rays[k]))
            rmap_text_table_add(table, "-");
        else if (test->is_bins)
            rmap_text_table_add(table, "%.0f", test->bins.rays[k]);
        else
            put_value(table, test->scalar.value[k], test->scalar.error[k]);
    if (test->is_bins || isnan(test->scalar.difference)) {
        rmap_text_table_add(table, "-");
        rmap_text_table_add(table, "-");
    } else {
        put_value(table, test->scalar.difference, test->scalar.standard_error);
        rmap_text_table_add(table, "%.5g", ratio_of(test));
    }
    if (test->is_bins && !isnan(test->p))
        rmap_text_table_add(table, "chi2 %.5g / %.0f", test->bins.chi_square, test->bins.degrees);
    else if (!test->is_bins && !isnan(test->scalar.z))
        rmap_text_table_add(table, "z %.3f", test->scalar.z);
    else
        rmap_text_table_add(table, "-");
    for (int k = 0; k < 2; k++) {
        double p = k ? test->adjusted : test->p;
        if (isnan(p))
            rmap_text_table_add(table, "-");
        else
            rmap_text_table_add(table, "%.3g", p);
    }
    if (isnan(test->p))
        rmap_text_table_add(table, "%s", test->note ? test->note : "-");
    else
        rmap_text_table_add(table, "%s", test->same ? "same" : "DIFFERENT");
}

static void print_samples(const struct rmap_comparison *self, FILE *out)
{
    for (int k = 0; k < 2; k++)
        fprintf(out, "%-12s %s, %s%s%s\n", k ? "B" : "A", self->path[k],
                self->criterion[k] ? self->criterion[k] : "all rays",
                rmap_which_chooses(self->which[k]) ? "; registrations: " : "",
                rmap_which_chooses(self->which[k]) ? self->which[k]->text : "");
}

static size_t count_tests(const struct rmap_comparison *self, size_t *n_different)
{
    size_t n = 0;
    *n_different = 0;
    for (size_t i = 0; i < self->n; i++) {
        n += isnan(self->test[i].p) ? 0 : 1;
        *n_different += self->test[i].same ? 0 : 1;
    }
    return n;
}

enum rmap_status rmap_comparison_print(const struct rmap_comparison *self, FILE *out,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_text_table table;
    size_t n_different = 0, n = count_tests(self, &n_different);
    print_samples(self, out);
    if (dependence(self))
        fprintf(out, "%-12s %s\n", "note", dependence(self));
    for (int k = 0; k < 2; k++)
        for (size_t i = 0; i < self->n_only[k] && i < 10; i++)
            fprintf(out, "%-12s %s%s\n", k ? "only in B" : "only in A", self->only[k][i],
                    i == 9 && self->n_only[k] > 10 ? ", and more" : "");
    rmap_text_table_init(&table, 10);
    rmap_text_table_add(&table, "what");
    rmap_text_table_add(&table, "name");
    rmap_text_table_add(&table, "A [%s, rays]", flux_unit(self));
    rmap_text_table_add(&table, "B");
    rmap_text_table_add(&table, "A - B");
    rmap_text_table_add(&table, "B / A");
    rmap_text_table_add(&table, "test");
    rmap_text_table_add(&table, "p");
    rmap_text_table_add(&table, "adjusted");
    rmap_text_table_add(&table, "verdict");
    for (size_t i = 0; i < self->n; i++)
        put_test(&table, &self->test[i]);
    if (self->n > 0)
        RMAP_TRY(rmap_text_table_print(&table, "llrrrrrrrl", out, err));
    else
        fputs("nothing to compare: no ray matches in either sample\n", out);
    if (n == 0 && self->same && !self->overlap.identical)
        fprintf(out, "%-12s none: nothing could be tested\n", "verdict");
    else
        fprintf(out, "%-12s %s: %zu of %zu tests differ at significance %g (%s)\n", "verdict",
                self->same ? "same" : "DIFFERENT", n_different, n, self->significance,
                rmap_correction_word[self->correction]);
    if (self->too_equal)
        fputs("suspicious   the distributions agree better than independent samples would\n", out);
out:
    rmap_text_table_fini(&table);
    return st;
}

/* Sums of weights: whole numbers as a rule. */
static json_t *count(double rays)
{
    return rays == floor(rays) && fabs(rays) < 1e15 ? json_integer((json_int_t)rays)
                                                    : rmap_json_number(rays);
}

static json_t *test_json(const struct rmap_compare_test *test, const char *unit)
{
    json_t *object =
        json_pack("{s:s, s:s}", "name", test->name, "quantity", rmap_compare_word[test->kind]);
    json_t *values = json_array();
    for (int k = 0; k < 2; k++)
        json_array_append_new(
            values, test->is_bins
                        ? json_pack("{s:o}", "rays", count(test->bins.rays[k]))
                        : json_pack("{s:o, s:o, s:s, s:o}", "value",
                                    rmap_json_number(test->scalar.value[k]), "standard_error",
                                    rmap_json_number(test->scalar.error[k]), "unit", unit, "rays",
                                    count(test->scalar.rays[k])));
    json_object_set_new(object, "values", values);
    if (test->is_bins) {
        json_object_set_new(object, "chi_square", rmap_json_number(test->bins.chi_square));
        json_object_set_new(object, "degrees", rmap_json_number(test->bins.degrees));
        json_object_set_new(object, "bins", json_integer((json_int_t)test->bins.n_bin));
    } else {
        json_object_set_new(object, "difference",
                            json_pack("{s:o, s:o}", "value",
                                      rmap_json_number(test->scalar.difference), "standard_error",
                                      rmap_json_number(test->scalar.standard_error)));
        json_object_set_new(object, "ratio", rmap_json_number(ratio_of(test)));
        json_object_set_new(object, "z", rmap_json_number(test->scalar.z));
    }
    const char *method = test->is_bins ? "chi-square" : test->scalar.is_exact ? "binomial" : "z";
    json_object_set_new(object, "method", isnan(test->p) ? json_null() : json_string(method));
    json_object_set_new(object, "p", rmap_json_number(test->p));
    json_object_set_new(object, "adjusted_p", rmap_json_number(test->adjusted));
    json_object_set_new(object, "same", json_boolean(test->same));
    if (test->note)
        json_object_set_new(object, "note", json_string(test->note));
    return object;
}

static json_t *sample_json(const struct rmap_comparison *self, int k)
{
    json_t *only = json_array();
    for (size_t i = 0; i < self->n_only[k]; i++)
        json_array_append_new(only, json_string(self->only[k][i]));
    return rmap_json_of_map(json_pack("{s:s, s:s, s:o, s:o}", "map", self->path[k], "criterion",
                                      self->criterion[k] ? self->criterion[k] : "all", "which",
                                      rmap_which_json(self->which[k]), "only_here", only),
                            self->map[k]);
}

json_t *rmap_comparison_json(const struct rmap_comparison *self)
{
    json_t *tests = json_array(), *notes = json_array();
    size_t n_different = 0, n = count_tests(self, &n_different);
    for (size_t i = 0; i < self->n; i++)
        json_array_append_new(tests, test_json(&self->test[i], flux_unit(self)));
    if (dependence(self))
        json_array_append_new(notes, json_string(dependence(self)));
    if (self->n == 0)
        json_array_append_new(notes, json_string("no ray matches in either sample"));
    return json_pack("{s:[o, o], s:b, s:f, s:s, s:I, s:I, s:b, s:b, s:b, s:b, s:I, s:I, s:o, s:o}",
                     "samples", sample_json(self, 0), sample_json(self, 1), "same", (int)self->same,
                     "significance", self->significance, "correction",
                     rmap_correction_word[self->correction], "tested", (json_int_t)n, "different",
                     (json_int_t)n_different, "suspiciously_equal", (int)self->too_equal, "paired",
                     (int)self->strata.paired, "independent", (int)independent(self), "identical",
                     (int)self->overlap.identical, "shared_rays", (json_int_t)self->overlap.rays,
                     "empty", (json_int_t)self->n_empty, "notes", notes, "tests", tests);
}

/* 32 Mi numbers: a quarter of a GiB for each thread. */
static const size_t VALUE_MAX = (size_t)32 << 20;

enum rmap_status rmap_compare_products_layout_init(struct rmap_compare_products_layout *layout,
                                                   const struct rmap_compare_layout *of,
                                                   const struct rmap_comparison *comparison,
                                                   int which, struct rmap_error *err)
{
    *layout = (struct rmap_compare_products_layout){.of = of};
    layout->group = rmap_alloc(of->n_detector + 1, sizeof *layout->group);
    layout->n_group = rmap_alloc(of->n_detector + 1, sizeof *layout->n_group);
    layout->first = rmap_alloc(of->n_detector + 1, sizeof *layout->first);
    if (!layout->group || !layout->n_group || !layout->first) {
        rmap_compare_products_layout_fini(layout);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors", of->n_detector);
    }
    for (size_t i = 0; i < comparison->n_again; i++) {
        const struct rmap_compare_again *again = &comparison->again[i];
        layout->group[again->detector[which]] = again->group;
        layout->n_group[again->detector[which]] = again->n_group;
    }
    for (size_t d = 0; d < of->n_detector; d++) {
        size_t n = layout->n_group[d];
        layout->first[d + 1] = layout->first[d] + n + n * (n + 1) / 2;
    }
    layout->n_value = layout->first[of->n_detector];
    if (layout->n_value <= VALUE_MAX / (of->n_source > 0 ? of->n_source : 1))
        return RMAP_OK;
    rmap_compare_products_layout_fini(layout);
    return rmap_error_set(err, RMAP_SYSTEM,
                          "the images of so many detectors, of %zu sources, are too many to "
                          "compare at once; name one with --detector",
                          of->n_source);
}

void rmap_compare_products_layout_fini(struct rmap_compare_products_layout *layout)
{
    rmap_free(layout->group);
    rmap_free(layout->n_group);
    rmap_free(layout->first);
    *layout = (struct rmap_compare_products_layout){0};
}

static size_t n_value(const struct rmap_compare_products_layout *layout)
{
    return layout->of->n_source * layout->n_value;
}

static void destroy(void *state)
{
    struct rmap_compare_products *self = state;
    if (!self)
        return;
    rmap_free(self->value);
    rmap_free(self->own);
    rmap_free(self->met);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_compare_products_layout *layout = context;
    struct rmap_compare_products *self = rmap_alloc(1, sizeof *self);
    size_t most = 0;
    for (size_t d = 0; d < layout->of->n_detector; d++)
        most = layout->n_group[d] > most ? layout->n_group[d] : most;
    if (self) {
        self->layout = layout;
        self->value = rmap_alloc(n_value(layout) + 1, sizeof *self->value);
        self->own = rmap_alloc(most + 1, sizeof *self->own);
        self->met = rmap_alloc(most + 1, sizeof *self->met);
    }
    if (!self || !self->value || !self->own || !self->met) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sums", n_value(layout));
    }
    *state_ret = self;
    return RMAP_OK;
}

/* Rows [first, end) of /registration are of one ray: what it adds to the groups of detector d. */
static size_t gather(struct rmap_compare_products *self, const struct rmap_matched *rays,
                     size_t first, size_t end, size_t d, double weight)
{
    const struct rmap_registration_columns *at = &rays->portion->registration;
    const uint8_t *counts = rmap_registrations_counted(rays);
    const uint32_t width = self->layout->of->scene->detector[d].cells[0];
    size_t n_met = 0;
    for (size_t row = first; row < end; row++) {
        if (!counts[row] || (size_t)at->detector[row] != d)
            continue;
        int32_t group =
            self->layout->group[d][at->cell[2 * row] + (size_t)at->cell[2 * row + 1] * width];
        if (group < 0)
            continue;
        if (self->own[group] == 0.0)
            self->met[n_met++] = (size_t)group;
        self->own[group] += weight;
    }
    return n_met;
}

static void add_products(struct rmap_compare_products *self, size_t source, size_t d, size_t n_met)
{
    const struct rmap_compare_products_layout *layout = self->layout;
    double *sum = self->value + source * layout->n_value + layout->first[d];
    double *product = sum + layout->n_group[d];
    for (size_t i = 0; i < n_met; i++) {
        size_t a = self->met[i];
        sum[a] += self->own[a];
        for (size_t j = 0; j < n_met; j++)
            if (self->met[j] <= a)
                product[a * (a + 1) / 2 + self->met[j]] +=
                    rmap_weight_product(self->own[a], self->own[self->met[j]]);
    }
    for (size_t i = 0; i < n_met; i++)
        self->own[self->met[i]] = 0.0;
}

/* The first pass has checked the cells. */
static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_compare_products *self = state;
    const struct rmap_portion *portion = rays->portion;
    size_t row = 0;
    (void)err;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t end = row + portion->ray.registration_count[i];
        if (!rays->match || rays->match[i])
            for (size_t at = row; at < end; at++) {
                size_t d = (size_t)portion->registration.detector[at];
                bool seen = !self->layout->group[d];
                for (size_t before = row; before < at && !seen; before++)
                    seen = (size_t)portion->registration.detector[before] == d;
                if (!seen)
                    add_products(self, (size_t)portion->ray.source[i], d,
                                 gather(self, rays, row, end, d, portion->ray.weight[i]));
            }
        row = end;
    }
    return RMAP_OK;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_compare_products *self = into;
    const struct rmap_compare_products *other = from;
    (void)err;
    for (size_t i = 0; i < n_value(self->layout); i++)
        self->value[i] += other->value[i];
    return RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_compare_products *self = state;
    block[0] = (struct rmap_fold_block){self->value, n_value(self->layout) * sizeof *self->value};
    return 1;
}

const struct rmap_fold_kind rmap_compare_products_kind = {
    .create = create, .destroy = destroy, .add = add, .merge = merge, .blocks = blocks};

enum rmap_status rmap_comparison_add_products(struct rmap_comparison *comparison,
                                              const struct rmap_compare_sums *both,
                                              const struct rmap_compare_products *const products[2],
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = comparison->strata.n;
    const double **sum[2] = {rmap_alloc(n + 1, sizeof **sum), rmap_alloc(n + 1, sizeof **sum)};
    const double **product[2] = {rmap_alloc(n + 1, sizeof **sum), rmap_alloc(n + 1, sizeof **sum)};
    if (!sum[0] || !sum[1] || !product[0] || !product[1]) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", n);
        goto out;
    }
    for (size_t i = 0; i < comparison->n_again; i++) {
        const struct rmap_compare_again *again = &comparison->again[i];
        struct rmap_chi_square result;
        for (size_t s = 0; s < n; s++)
            for (int k = 0; k < 2; k++) {
                const struct rmap_compare_products_layout *layout = products[k]->layout;
                int32_t source = comparison->strata.stratum[s].source[k];
                sum[k][s] = source < 0 ? NULL
                                       : products[k]->value + (size_t)source * layout->n_value +
                                             layout->first[again->detector[k]];
                product[k][s] = sum[k][s] ? sum[k][s] + again->n_group : NULL;
            }
        const struct rmap_products matrix = {.n_group = again->n_group,
                                             .count = {sum[0], sum[1]},
                                             .product = {product[0], product[1]}};
        RMAP_TRY(rmap_difference_products(&comparison->strata, &matrix, &result, err));
        rmap_compare_count_both(both, again->detector[0], &result);
        RMAP_TRY(rmap_comparison_add_bins(
            comparison, RMAP_COMPARE_IMAGE,
            rmap_comparison_scene(comparison, 0)->detector[again->detector[0]].name, &result, NULL,
            err));
    }
out:
    for (int k = 0; k < 2; k++) {
        rmap_free(sum[k]);
        rmap_free(product[k]);
    }
    return st;
}

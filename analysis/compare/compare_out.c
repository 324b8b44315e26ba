/* SPDX-License-Identifier: MIT
 *
 * A comparison as a table for people and as JSON.
 */
#include <inttypes.h>
#include <math.h>

#include "analysis/compare/compare.h"
#include "analysis/table/text_table.h"
#include "io/export/json_number.h"
#include "io/map/map_json.h"

static const char *flux_unit(const struct rmap_comparison *self)
{
    return rmap_map_scene(self->map[0])->flux_unit == RMAP_FLUX_LM ? "lm" : "W";
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
    rmap_text_table_init(&table, 8);
    rmap_text_table_add(&table, "what");
    rmap_text_table_add(&table, "name");
    rmap_text_table_add(&table, "A [%s, rays]", flux_unit(self));
    rmap_text_table_add(&table, "B");
    rmap_text_table_add(&table, "test");
    rmap_text_table_add(&table, "p");
    rmap_text_table_add(&table, "adjusted");
    rmap_text_table_add(&table, "verdict");
    for (size_t i = 0; i < self->n; i++)
        put_test(&table, &self->test[i]);
    if (self->n > 0)
        RMAP_TRY(rmap_text_table_print(&table, "llrrrrrl", out, err));
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

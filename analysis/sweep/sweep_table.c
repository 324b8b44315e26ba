/* SPDX-License-Identifier: MIT
 *
 * The rows of a sweep's table, in memory and in a journal.
 */
#include "analysis/sweep/sweep_table.h"

#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "io/export/json_number.h"

enum rmap_status rmap_sweep_table_init(struct rmap_sweep_table *table,
                                       const struct rmap_sweep *sweep, struct rmap_error *err)
{
    *table = (struct rmap_sweep_table){
        .sweep = sweep,
        .is_known = rmap_alloc(sweep->n_variant, sizeof *table->is_known),
        .mistake = rmap_alloc(sweep->n_variant, sizeof(char *)),
        .result = rmap_alloc(sweep->n_variant * sweep->n_answer, sizeof *table->result),
        .nominal_part =
            rmap_alloc(sweep->n_answer * RMAP_SWEEP_PARTS, sizeof *table->nominal_part)};
    if (table->is_known && table->mistake && table->result && table->nominal_part)
        return RMAP_OK;
    rmap_sweep_table_fini(table);
    return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table of %llu variants",
                          (unsigned long long)sweep->n_variant);
}

void rmap_sweep_table_fini(struct rmap_sweep_table *table)
{
    for (uint64_t v = 0; table->mistake && v < table->sweep->n_variant; v++)
        rmap_free(table->mistake[v]);
    rmap_free(table->mistake);
    rmap_free(table->is_known);
    rmap_free(table->result);
    rmap_free(table->nominal_part);
    *table = (struct rmap_sweep_table){.sweep = NULL};
}

static struct rmap_sweep_result *row_of(const struct rmap_sweep_table *table, uint64_t variant)
{
    return table->result + variant * table->sweep->n_answer;
}

const struct rmap_sweep_result *rmap_sweep_table_row(const struct rmap_sweep_table *table,
                                                     uint64_t variant)
{
    return row_of(table, variant);
}

double rmap_sweep_difference(const struct rmap_sweep_table *table, uint64_t variant, size_t answer)
{
    return table->is_known[0]
               ? row_of(table, variant)[answer].value - row_of(table, 0)[answer].value
               : (double)NAN;
}

void rmap_sweep_row_differ(struct rmap_sweep_table *table, uint64_t variant, const double *part)
{
    struct rmap_sweep_result *row = row_of(table, variant);
    for (size_t i = 0; i < table->sweep->n_answer; i++) {
        double *nominal = table->nominal_part + i * RMAP_SWEEP_PARTS;
        if (variant == 0)
            memcpy(nominal, part + i * RMAP_SWEEP_PARTS, RMAP_SWEEP_PARTS * sizeof *nominal);
        row[i].difference_error =
            rmap_sweep_parts_error(&table->sweep->answer[i], part + i * RMAP_SWEEP_PARTS, nominal);
    }
}

enum rmap_status rmap_sweep_row_fail(struct rmap_sweep_table *table, uint64_t variant,
                                     const char *mistake, struct rmap_error *err)
{
    struct rmap_sweep_result *row = row_of(table, variant);
    char *copy = rmap_strdup(mistake);
    if (!copy)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a row");
    rmap_free(table->mistake[variant]);
    table->mistake[variant] = copy;
    for (size_t i = 0; i < table->sweep->n_answer; i++)
        row[i] = (struct rmap_sweep_result){
            .value = NAN, .standard_error = NAN, .difference_error = NAN};
    return RMAP_OK;
}

uint64_t rmap_sweep_n_failed(const struct rmap_sweep_table *table)
{
    uint64_t n = 0;
    for (uint64_t v = 0; v < table->sweep->n_variant; v++)
        n += table->is_known[v] && table->mistake[v];
    return n;
}

char *rmap_sweep_row_line(const struct rmap_sweep_table *table, uint64_t variant)
{
    const struct rmap_sweep_result *row = row_of(table, variant);
    json_t *answers = json_array();
    for (size_t i = 0; i < table->sweep->n_answer; i++)
        (void)json_array_append_new(answers,
                                    json_pack("[o, o, s, o]", rmap_json_number(row[i].value),
                                              rmap_json_number(row[i].standard_error), row[i].unit,
                                              rmap_json_number(row[i].difference_error)));
    json_t *line = json_pack("{s:I, s:o}", "variant", (json_int_t)variant, "answers", answers);
    if (line && variant == 0) {
        json_t *parts = json_array();
        for (size_t k = 0; k < table->sweep->n_answer * RMAP_SWEEP_PARTS; k++)
            (void)json_array_append_new(parts, rmap_json_number(table->nominal_part[k]));
        (void)json_object_set_new(line, "parts", parts);
    }
    if (line && table->mistake[variant])
        (void)json_object_set_new(line, "mistake", json_string(table->mistake[variant]));
    char *dumped = line ? json_dumps(line, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    char *text = rmap_strdup(dumped);
    free(dumped);
    json_decref(line);
    return text;
}

static double number_of(const json_t *value)
{
    return json_is_number(value) ? json_number_value(value) : (double)NAN;
}

void rmap_sweep_row_take(struct rmap_sweep_table *table, const char *line, size_t nbytes)
{
    json_t *document = json_loadb(line, nbytes, 0, NULL);
    const json_t *answers = json_object_get(document, "answers");
    const json_int_t variant = json_integer_value(json_object_get(document, "variant"));
    const size_t n = table->sweep->n_answer;
    if (json_is_integer(json_object_get(document, "variant")) && variant >= 0 &&
        (uint64_t)variant < table->sweep->n_variant && json_array_size(answers) == n) {
        struct rmap_sweep_result *row = row_of(table, (uint64_t)variant);
        for (size_t i = 0; i < n; i++) {
            const json_t *one = json_array_get(answers, i);
            const char *unit = json_string_value(json_array_get(one, 2));
            row[i].value = number_of(json_array_get(one, 0));
            row[i].standard_error = number_of(json_array_get(one, 1));
            row[i].difference_error = number_of(json_array_get(one, 3));
            (void)snprintf(row[i].unit, sizeof row[i].unit, "%s", unit ? unit : "");
        }
        const char *mistake = json_string_value(json_object_get(document, "mistake"));
        rmap_free(table->mistake[variant]);
        table->mistake[variant] = rmap_strdup(mistake);
        const bool is_kept = !mistake || table->mistake[variant];
        const json_t *parts = json_object_get(document, "parts");
        for (size_t k = 0; variant == 0 && k < n * RMAP_SWEEP_PARTS; k++)
            table->nominal_part[k] = number_of(json_array_get(parts, k));
        table->is_known[variant] = is_kept;
    }
    json_decref(document);
}

bool rmap_sweep_row_meets(const struct rmap_sweep_table *table, uint64_t variant)
{
    const struct rmap_sweep_result *row = row_of(table, variant);
    bool meets = table->is_known[variant];
    for (size_t i = 0; i < table->sweep->n_require; i++) {
        const struct rmap_sweep_require *r = &table->sweep->require[i];
        const double value = row[r->answer].value;
        meets = meets && ((r->below ? value < r->limit : value > r->limit) ||
                          (r->or_equal && value == r->limit));
    }
    return meets;
}

struct rmap_sweep_yield rmap_sweep_yield_of(const struct rmap_sweep_table *table)
{
    struct rmap_sweep_yield yield = {0};
    for (uint64_t v = 1; v < table->sweep->n_variant; v++) {
        yield.n += table->is_known[v];
        yield.n_met += rmap_sweep_row_meets(table, v);
    }
    const double n = (double)yield.n, k = (double)yield.n_met;
    double p = yield.share = n > 0.0 ? k / n : (double)NAN;
    if (k == 0.0 || k == n)
        p = (k + 1.0) / (n + 2.0);
    yield.standard_error = n > 0.0 ? sqrt(p * (1.0 - p) / n) : (double)NAN;
    return yield;
}

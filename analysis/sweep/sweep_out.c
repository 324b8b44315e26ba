/* SPDX-License-Identifier: MIT
 *
 * A sweep's table as CSV, HDF5, text and JSON.
 */
#include <math.h>

#include "analysis/sweep/sweep_table.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "io/file/whole_file.h"
#include "io/hdf5/table_h5.h"

static enum rmap_status put_csv(const void *context, FILE *out, struct rmap_error *err)
{
    const struct rmap_sweep_table *table = context;
    const struct rmap_sweep *sweep = table->sweep;
    const bool some_failed = rmap_sweep_n_failed(table) > 0;
    (void)err;
    for (size_t i = 0; i < sweep->n_parameter; i++)
        fprintf(out, "# %s: %s %s\n", sweep->parameter[i].name, sweep->parameter[i].key[0],
                sweep->parameter[i].unit);
    for (size_t i = 0; i < sweep->n_answer; i++)
        fprintf(out, "# %s: %s\n", sweep->answer[i].name, rmap_sweep_table_row(table, 0)[i].unit);
    fputs("variant", out);
    for (size_t i = 0; i < sweep->n_parameter; i++)
        rmap_csv_put_text(sweep->parameter[i].name, out);
    for (size_t i = 0; i < sweep->n_answer; i++) {
        rmap_csv_put_text(sweep->answer[i].name, out);
        fprintf(out, ",%s_error,%s_difference,%s_difference_error", sweep->answer[i].name,
                sweep->answer[i].name, sweep->answer[i].name);
    }
    fputs(sweep->n_require ? ",met" : "", out);
    fputs(some_failed ? ",mistake\n" : "\n", out);
    for (uint64_t v = 0; v < sweep->n_variant; v++) {
        if (!table->is_known[v])
            continue;
        fprintf(out, "%llu", (unsigned long long)v);
        for (size_t i = 0; i < sweep->n_parameter; i++) {
            const char *text;
            const double value = rmap_sweep_value(sweep, v, i, &text);
            if (text)
                rmap_csv_put_text(text, out);
            else
                rmap_csv_put_number(value, out);
        }
        for (size_t i = 0; i < sweep->n_answer; i++) {
            rmap_csv_put_number(rmap_sweep_table_row(table, v)[i].value, out);
            rmap_csv_put_number(rmap_sweep_table_row(table, v)[i].standard_error, out);
            rmap_csv_put_number(rmap_sweep_difference(table, v, i), out);
            rmap_csv_put_number(rmap_sweep_table_row(table, v)[i].difference_error, out);
        }
        if (sweep->n_require)
            fprintf(out, ",%d", rmap_sweep_row_meets(table, v));
        if (some_failed)
            rmap_csv_put_text(table->mistake[v] ? table->mistake[v] : "", out);
        fputc('\n', out);
    }
    return RMAP_OK;
}

enum rmap_status rmap_sweep_table_csv(const struct rmap_sweep_table *table, const char *path,
                                      struct rmap_error *err)
{
    return rmap_whole_file_put(path, put_csv, table, err);
}

static enum rmap_status add_rows(const struct rmap_sweep_table *table, struct rmap_table_h5 *file,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_sweep *sweep = table->sweep;
    for (uint64_t v = 0; v < sweep->n_variant; v++) {
        const struct rmap_sweep_result *row = rmap_sweep_table_row(table, v);
        size_t c = 0;
        if (!table->is_known[v])
            continue;
        RMAP_TRY(rmap_table_h5_add(file, c++, &v, err));
        for (size_t i = 0; i < sweep->n_parameter; i++) {
            const char *text;
            const double value = rmap_sweep_value(sweep, v, i, &text);
            RMAP_TRY(rmap_table_h5_add(file, c++, &value, err));
        }
        for (size_t i = 0; i < sweep->n_answer; i++)
            RMAP_TRY(rmap_table_h5_add(file, c++, &row[i].value, err));
        for (size_t i = 0; i < sweep->n_answer; i++)
            RMAP_TRY(rmap_table_h5_add(file, c++, &row[i].standard_error, err));
        for (size_t i = 0; i < sweep->n_answer; i++) {
            const double difference = rmap_sweep_difference(table, v, i);
            RMAP_TRY(rmap_table_h5_add(file, c++, &difference, err));
        }
        for (size_t i = 0; i < sweep->n_answer; i++)
            RMAP_TRY(rmap_table_h5_add(file, c++, &row[i].difference_error, err));
    }
out:
    return st;
}

enum rmap_status rmap_sweep_table_h5(const struct rmap_sweep_table *table, const char *path,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_sweep *sweep = table->sweep;
    const size_t n = 1 + sweep->n_parameter + 4 * sweep->n_answer;
    struct rmap_table_h5 *file = NULL;
    struct rmap_table_h5_column *column = rmap_alloc(n, sizeof *column);
    size_t c = 0;
    if (!column)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a table");
    column[c++] = (struct rmap_table_h5_column){"sweep", "variant", RMAP_U64, "1",
                                                "number; 0: the scene as it is"};
    for (size_t i = 0; i < sweep->n_parameter; i++)
        column[c++] =
            (struct rmap_table_h5_column){"parameter", sweep->parameter[i].name, RMAP_F64,
                                          sweep->parameter[i].unit, sweep->parameter[i].key[0]};
    static const char *const group[][2] = {
        {"answer", "answer"},
        {"standard_error", "its standard error"},
        {"difference", "the answer less that of the scene as it is"},
        {"difference_error", "standard error of the difference, both having the same rays"}};
    for (size_t g = 0; g < sizeof group / sizeof *group; g++)
        for (size_t i = 0; i < sweep->n_answer; i++)
            column[c++] =
                (struct rmap_table_h5_column){group[g][0], sweep->answer[i].name, RMAP_F64,
                                              rmap_sweep_table_row(table, 0)[i].unit, group[g][1]};
    RMAP_TRY(rmap_table_h5_begin(path, column, n, &file, err));
    RMAP_TRY(rmap_table_h5_put_text(file, "sweep", sweep->text, err));
    RMAP_TRY(add_rows(table, file, err));
    st = rmap_table_h5_finish(file, false, err);
out:
    rmap_table_h5_destroy(file);
    rmap_free(column);
    return st;
}

static enum rmap_status print_effects(const struct rmap_sweep_table *table, size_t answer,
                                      struct rmap_sweep_effect *effect, FILE *out,
                                      struct rmap_error *err)
{
    struct rmap_text_table text;
    double explained;
    enum rmap_status st = rmap_sweep_effects(table, answer, effect, &explained, err);
    if (st != RMAP_OK || !(explained > 0.0))
        return st;
    rmap_text_table_init(&text, 4);
    rmap_text_table_add(&text, "%s", table->sweep->answer[answer].name);
    rmap_text_table_add(&text, "share");
    rmap_text_table_add(&text, "slope");
    rmap_text_table_add(&text, "+-");
    for (size_t i = 0; i < table->sweep->n_parameter; i++) {
        rmap_text_table_add(&text, "  %s", table->sweep->parameter[effect[i].parameter].name);
        rmap_text_table_add(&text, "%.1f %%", 100.0 * effect[i].share);
        rmap_text_table_add(&text, "%.4g", effect[i].slope);
        if (isfinite(effect[i].slope_error))
            rmap_text_table_add(&text, "%.2g", effect[i].slope_error);
        else
            rmap_text_table_add(&text, "%s", "");
    }
    st = rmap_text_table_print(&text, "lrrr", out, err);
    rmap_text_table_fini(&text);
    return st;
}

enum rmap_status rmap_sweep_table_print(const struct rmap_sweep_table *table, FILE *out,
                                        struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_sweep *sweep = table->sweep;
    const struct rmap_sweep_yield yield = rmap_sweep_yield_of(table);
    struct rmap_sweep_effect *effect = rmap_alloc(sweep->n_parameter, sizeof *effect);
    if (!effect)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the effects of parameters");
    fprintf(out, "%-14s %llu and the scene as it is", "variants", (unsigned long long)yield.n);
    if (rmap_sweep_n_failed(table))
        fprintf(out, "; %llu %s no answers", (unsigned long long)rmap_sweep_n_failed(table),
                rmap_sweep_n_failed(table) == 1 ? "has" : "have");
    fputc('\n', out);
    for (size_t i = 0; i < sweep->n_answer; i++) {
        const struct rmap_sweep_result *nominal = &rmap_sweep_table_row(table, 0)[i];
        double least = HUGE_VAL, most = -HUGE_VAL;
        for (uint64_t v = 1; v < sweep->n_variant; v++)
            if (table->is_known[v]) {
                least = fmin(least, rmap_sweep_table_row(table, v)[i].value);
                most = fmax(most, rmap_sweep_table_row(table, v)[i].value);
            }
        fprintf(out, "%-14s %.6g", sweep->answer[i].name, nominal->value);
        if (isfinite(nominal->standard_error))
            fprintf(out, " +- %.2g", nominal->standard_error);
        fprintf(out, "%s%s as it is", nominal->unit[0] ? " " : "", nominal->unit);
        if (least <= most)
            fprintf(out, "; %.6g to %.6g", least, most);
        fputc('\n', out);
    }
    if (sweep->n_require)
        fprintf(out, "%-14s %.4g +- %.2g: %llu of %llu meet the requirements\n", "yield",
                yield.share, yield.standard_error, (unsigned long long)yield.n_met,
                (unsigned long long)yield.n);
    for (size_t i = 0; i < sweep->n_answer && st == RMAP_OK; i++)
        st = print_effects(table, i, effect, out, err);
    rmap_free(effect);
    return st;
}

static json_t *effects_json(const struct rmap_sweep_table *table, size_t answer)
{
    const struct rmap_sweep *sweep = table->sweep;
    struct rmap_error ignored;
    struct rmap_sweep_effect *effect = rmap_alloc(sweep->n_parameter, sizeof *effect);
    json_t *list = json_array();
    double explained;
    if (effect && rmap_sweep_effects(table, answer, effect, &explained, &ignored) == RMAP_OK)
        for (size_t i = 0; i < sweep->n_parameter; i++)
            (void)json_array_append_new(list, json_pack("{s:s, s:o, s:o, s:o}", "parameter",
                                                        sweep->parameter[effect[i].parameter].name,
                                                        "share", rmap_json_number(effect[i].share),
                                                        "slope", rmap_json_number(effect[i].slope),
                                                        "slope_error",
                                                        rmap_json_number(effect[i].slope_error)));
    rmap_free(effect);
    return list;
}

static json_t *row_json(const struct rmap_sweep_table *table, uint64_t variant)
{
    const struct rmap_sweep *sweep = table->sweep;
    const struct rmap_sweep_result *row = rmap_sweep_table_row(table, variant);
    json_t *parameters = json_object(), *answers = json_object();
    for (size_t i = 0; i < sweep->n_parameter; i++) {
        const char *text;
        const double value = rmap_sweep_value(sweep, variant, i, &text);
        (void)json_object_set_new(parameters, sweep->parameter[i].name,
                                  text ? json_string(text) : rmap_json_number(value));
    }
    for (size_t i = 0; i < sweep->n_answer; i++) {
        json_t *answer = json_pack("{s:o, s:o}", "value", rmap_json_number(row[i].value),
                                   "standard_error", rmap_json_number(row[i].standard_error));
        if (variant > 0)
            (void)json_object_set_new(
                answer, "difference",
                json_pack("{s:o, s:o}", "value",
                          rmap_json_number(rmap_sweep_difference(table, variant, i)),
                          "standard_error", rmap_json_number(row[i].difference_error)));
        (void)json_object_set_new(answers, sweep->answer[i].name, answer);
    }
    json_t *document = json_pack("{s:I, s:o, s:o}", "variant", (json_int_t)variant, "parameters",
                                 parameters, "answers", answers);
    if (document && table->mistake[variant])
        (void)json_object_set_new(document, "mistake", json_string(table->mistake[variant]));
    if (document && sweep->n_require)
        (void)json_object_set_new(document, "met",
                                  json_boolean(rmap_sweep_row_meets(table, variant)));
    return document;
}

json_t *rmap_sweep_table_json(const struct rmap_sweep_table *table)
{
    const struct rmap_sweep *sweep = table->sweep;
    const struct rmap_sweep_yield yield = rmap_sweep_yield_of(table);
    json_t *rows = json_array(), *effects = json_object(), *units = json_object();
    for (uint64_t v = 0; v < sweep->n_variant; v++)
        if (table->is_known[v])
            (void)json_array_append_new(rows, row_json(table, v));
    for (size_t i = 0; i < sweep->n_answer; i++) {
        (void)json_object_set_new(effects, sweep->answer[i].name, effects_json(table, i));
        (void)json_object_set_new(units, sweep->answer[i].name,
                                  json_string(rmap_sweep_table_row(table, 0)[i].unit));
    }
    json_t *document =
        json_pack("{s:s, s:I, s:o, s:o, s:o}", "scene", sweep->scene_path, "variants",
                  (json_int_t)sweep->n_variant, "units", units, "rows", rows, "effects", effects);
    if (document && sweep->n_require)
        (void)json_object_set_new(document, "yield",
                                  json_pack("{s:o, s:o, s:I, s:I}", "value",
                                            rmap_json_number(yield.share), "standard_error",
                                            rmap_json_number(yield.standard_error), "met",
                                            (json_int_t)yield.n_met, "of", (json_int_t)yield.n));
    return document;
}

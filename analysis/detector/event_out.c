/* SPDX-License-Identifier: MIT
 *
 * Readings of events for people, as CSV and as JSON.
 */
#include "analysis/detector/event_out.h"

#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/grouped.h"
#include "io/export/json_number.h"

static const char *name_of(const struct rmap_event_table *table, size_t d)
{
    return table->ask->scene->detector[table->ask->detector[d]].name;
}

static void put_window(const struct rmap_event_table *table, FILE *out)
{
    if (isfinite(table->trigger.window_ns))
        fprintf(out, " within %g ns", table->trigger.window_ns);
}

static bool reads(const struct rmap_event_table *table, size_t d)
{
    return table->ask->scene->detector[table->ask->detector[d]].reading.given;
}

static void add_spread(struct rmap_text_table *text, const struct rmap_event_spread *spread)
{
    const double deviation = rmap_event_spread_deviation(spread);
    rmap_text_table_add(text, spread->n > 0 ? "%.6g" : "-", spread->mean);
    rmap_text_table_add(text, isnan(deviation) ? "-" : "%.4g", deviation);
}

enum rmap_status rmap_event_print(const struct rmap_event_table *table,
                                  const struct rmap_event_summary *summary, FILE *out,
                                  struct rmap_error *err)
{
    const bool timed = table->ask->timed;
    const size_t n = table->ask->n_detector;
    struct rmap_text_table text;
    char grouped[RMAP_GROUPED_LEN];
    fprintf(out, "events        %s\n", rmap_grouped(table->n_row, grouped));
    rmap_text_table_init(&text, timed ? 9 : 5);
    static const char *const heading[] = {"",          "fired",    "signal, mean", "st. dev.", "",
                                          "first, ns", "st. dev.", "trigger, ns",  "st. dev."};
    for (size_t c = 0; c < (timed ? 9 : 5); c++)
        rmap_text_table_add(&text, "%s", heading[c]);
    for (size_t d = 0; d < n; d++) {
        const struct rmap_event_of_detector *of = &summary->detector[d];
        rmap_text_table_add(&text, "%s", name_of(table, d));
        rmap_text_table_add(&text, "%" PRIu64, of->n_fired);
        add_spread(&text, &of->signal);
        rmap_text_table_add(
            &text, "%s", reads(table, d) ? "cells" : rmap_event_value_unit(table, RMAP_EVENT_SUM));
        if (timed) {
            add_spread(&text, &of->first);
            add_spread(&text, &of->trigger);
        }
    }
    enum rmap_status st = rmap_text_table_print(&text, "lrrrlrrrr", out, err);
    rmap_text_table_fini(&text);
    fprintf(out, "coincidences  %s: %zu of %zu detectors with %g or more",
            rmap_grouped(summary->n_coincident, grouped), table->trigger.least, n,
            table->trigger.threshold);
    put_window(table, out);
    fputc('\n', out);
    if (n == 2 && summary->difference.n > 0)
        fprintf(out, "%s - %s    %.6g ns in the mean of %" PRIu64, name_of(table, 0),
                name_of(table, 1), summary->difference.mean, summary->difference.n);
    if (n == 2 && summary->difference.n > 1)
        fprintf(out, ", standard deviation %.4g ns",
                rmap_event_spread_deviation(&summary->difference));
    if (n == 2 && summary->difference.n > 0)
        fputc('\n', out);
    return st;
}

static json_t *spread_json(const struct rmap_event_spread *spread)
{
    return json_pack("{s:I, s:o, s:o}", "events", (json_int_t)spread->n, "mean",
                     rmap_json_number(spread->n > 0 ? spread->mean : (double)NAN),
                     "standard_deviation", rmap_json_number(rmap_event_spread_deviation(spread)));
}

static json_t *detector_json(const struct rmap_event_table *table,
                             const struct rmap_event_of_detector *of, size_t d)
{
    json_t *json =
        json_pack("{s:s, s:I, s:o, s:s}", "name", name_of(table, d), "fired",
                  (json_int_t)of->n_fired, "signal", spread_json(&of->signal), "unit",
                  reads(table, d) ? "cells" : rmap_event_value_unit(table, RMAP_EVENT_SUM));
    if (json && table->ask->timed) {
        (void)json_object_set_new(json, "first", spread_json(&of->first));
        (void)json_object_set_new(json, "trigger", spread_json(&of->trigger));
    }
    return json;
}

static json_t *row_json(const struct rmap_event_table *table, const struct rmap_event_row *row)
{
    json_t *json = json_pack("{s:I, s:I, s:I, s:b}", "event", (json_int_t)row->event, "rays",
                             (json_int_t)row->rays, "fired", (json_int_t)row->n_fired, "coincident",
                             (int)row->coincident);
    for (int v = 0; json && v < RMAP_EVENT_VALUES; v++) {
        if (!rmap_event_table_has(table, (enum rmap_event_value)v))
            continue;
        json_t *list = json_array();
        for (size_t d = 0; d < table->ask->n_detector; d++)
            (void)json_array_append_new(list, rmap_json_number(row->value[d][v]));
        (void)json_object_set_new(json, rmap_event_value_name((enum rmap_event_value)v), list);
    }
    return json;
}

json_t *rmap_event_json(struct rmap_event_table *table, const struct rmap_event_summary *summary,
                        bool rows)
{
    json_t *detectors = json_array();
    for (size_t d = 0; d < table->ask->n_detector; d++)
        (void)json_array_append_new(detectors, detector_json(table, &summary->detector[d], d));
    json_t *json =
        json_pack("{s:s, s:o, s:I, s:{s:o, s:I, s:I, s:o}, s:o, s:I}", "criterion",
                  table->criterion ? table->criterion : "all", "which",
                  rmap_which_json(table->which), "events", (json_int_t)table->n_row, "trigger",
                  "threshold", rmap_json_number(table->trigger.threshold), "order",
                  (json_int_t)table->trigger.order, "coincidence", (json_int_t)table->trigger.least,
                  "window", rmap_json_number(table->trigger.window_ns), "detectors", detectors,
                  "coincident", (json_int_t)summary->n_coincident);
    if (json && table->ask->n_detector == 2 && table->ask->timed)
        (void)json_object_set_new(json, "difference", spread_json(&summary->difference));
    if (!json || !rows)
        return json;
    json_t *list = json_array();
    const struct rmap_event_row *row;
    for (size_t index = 0; (row = rmap_event_table_next(table, &index)) != NULL;)
        (void)json_array_append_new(list, row_json(table, row));
    (void)json_object_set_new(json, "rows", list);
    return json;
}

static void csv_heading(const struct rmap_event_table *table, FILE *out)
{
    fputs("event,rays,fired,coincident", out);
    for (size_t d = 0; d < table->ask->n_detector; d++)
        for (int v = 0; v < RMAP_EVENT_VALUES; v++) {
            char name[512];
            if (!rmap_event_table_has(table, (enum rmap_event_value)v))
                continue;
            (void)snprintf(name, sizeof name, "%s(%s)",
                           rmap_event_value_name((enum rmap_event_value)v), name_of(table, d));
            rmap_csv_put_text(name, out);
        }
    fputc('\n', out);
}

void rmap_event_csv(struct rmap_event_table *table, FILE *out)
{
    const struct rmap_event_row *row;
    fprintf(out, "# criterion: %s\n# sum: %s\n# coincident: %zu of %zu detectors with %g or more",
            table->criterion ? table->criterion : "all",
            rmap_event_value_unit(table, RMAP_EVENT_SUM), table->trigger.least,
            table->ask->n_detector, table->trigger.threshold);
    put_window(table, out);
    fputc('\n', out);
    csv_heading(table, out);
    for (size_t index = 0; (row = rmap_event_table_next(table, &index)) != NULL;) {
        fprintf(out, "%" PRIu64 ",%" PRIu64 ",%zu,%d", row->event, row->rays, row->n_fired,
                (int)row->coincident);
        for (size_t d = 0; d < table->ask->n_detector; d++)
            for (int v = 0; v < RMAP_EVENT_VALUES; v++)
                if (rmap_event_table_has(table, (enum rmap_event_value)v))
                    rmap_csv_put_number(row->value[d][v], out);
        fputc('\n', out);
    }
}

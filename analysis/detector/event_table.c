/* SPDX-License-Identifier: MIT
 *
 * Readings of events as a table.
 */
#include "analysis/detector/event_table.h"

#include <math.h>
#include <stdlib.h>

#include "analysis/criterion/registration_response.h"
#include "base/alloc.h"

static const struct {
    const char *name, *unit, *description;
    enum rmap_event_needs needs;
} value_table[] = {
#define ROW(symbol, name, unit, needs, description)                                                \
    [RMAP_EVENT_##symbol] = {name, unit, description, RMAP_EVENT_##needs},
    RMAP_EVENT_VALUE_TABLE(ROW)
#undef ROW
};

bool rmap_event_table_has(const struct rmap_event_table *table, enum rmap_event_value value)
{
    const enum rmap_event_needs needs = value_table[value].needs;
    return needs == RMAP_EVENT_TIMES   ? table->ask->timed
           : needs == RMAP_EVENT_READS ? table->reads
                                       : true;
}

const char *rmap_event_value_name(enum rmap_event_value value)
{
    return value_table[value].name;
}

const char *rmap_event_value_description(enum rmap_event_value value)
{
    return value_table[value].description;
}

const char *rmap_event_value_unit(const struct rmap_event_table *table, enum rmap_event_value value)
{
    return value_table[value].unit ? value_table[value].unit
                                   : rmap_flux_unit_name(table->ask->scene);
}

/* Every ray of a source with events is one photon. */
static bool are_photons(const struct rmap_event_ask *ask)
{
    const struct rmap_scene *scene = ask->scene;
    bool all = scene->flux_unit == RMAP_FLUX_PHOTONS;
    for (size_t s = 0; s < scene->n_source; s++)
        all = all && (!(scene->source[s].steps || scene->source[s].rays) ||
                      fabs(rmap_map_flux_per_weight(ask->map)[s] - 1.0) < 1e-9);
    return all;
}

enum rmap_status rmap_event_table_init(const struct rmap_event_sums *sums,
                                       const struct rmap_event_trigger *trigger,
                                       struct rmap_event_table *table, struct rmap_error *err)
{
    const struct rmap_event_ask *ask = sums->ask;
    *table = (struct rmap_event_table){
        .sums = sums, .ask = ask, .trigger = *trigger, .whole = are_photons(ask)};
    table->row.value = rmap_alloc(ask->n_detector, sizeof *table->row.value);
    table->time = rmap_alloc(ask->n_detector, sizeof *table->time);
    if (!table->row.value || !table->time)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors", ask->n_detector);
    for (size_t d = 0; d < ask->n_detector; d++)
        table->reads = table->reads || ask->scene->detector[ask->detector[d]].reading.given;
    for (size_t i = 0; i < ask->n_event; i++)
        table->n_row += rmap_event_sums_rays(sums, i) > 0;
    return RMAP_OK;
}

void rmap_event_table_fini(struct rmap_event_table *table)
{
    rmap_free(table->row.value);
    rmap_free(table->time);
    *table = (struct rmap_event_table){0};
}

/* Charge of an electron in pC. */
static const double ELECTRON_PC = 1.602176634e-7;

/* What the detector's reading makes of the event. */
static void read_cells(const struct rmap_event_table *table, size_t d,
                       struct rmap_event_reading *light, double *value)
{
    const struct rmap_event_ask *ask = table->ask;
    const struct rmap_detector *detector = &ask->scene->detector[ask->detector[d]];
    const struct rmap_reading_of of = {ask->scene->seed, table->row.event, ask->detector[d]};
    struct rmap_read read;
    rmap_reading_draw(&detector->reading, &of, light->sum,
                      table->whole && !rmap_detector_weighs(detector), light->mean_ns, &read);
    value[RMAP_EVENT_ELECTRONS] = (double)read.photo_electrons;
    value[RMAP_EVENT_DARK] = (double)read.dark;
    value[RMAP_EVENT_CROSSTALK] = (double)read.crosstalk;
    value[RMAP_EVENT_AFTERPULSES] = (double)read.afterpulses;
    value[RMAP_EVENT_CELLS] = (double)read.cells;
    value[RMAP_EVENT_CHARGE] = (double)read.cells * detector->reading.gain * ELECTRON_PC;
    if (ask->timed)
        rmap_reading_dark_times(&detector->reading, &of, read.dark, light->early_ns, ask->n_early);
}

static double or_nan(double time)
{
    return isfinite(time) ? time : (double)NAN;
}

static void read_detector(const struct rmap_event_table *table, size_t index, size_t d,
                          double *value)
{
    const struct rmap_event_ask *ask = table->ask;
    struct rmap_event_reading light;
    rmap_event_sums_read(table->sums, index, d, &light);
    for (int v = 0; v < RMAP_EVENT_VALUES; v++)
        value[v] = (double)NAN;
    value[RMAP_EVENT_COUNT] = (double)light.registrations;
    value[RMAP_EVENT_SUM] = light.sum;
    value[RMAP_EVENT_MEAN] = light.mean_ns;
    if (ask->timed)
        value[RMAP_EVENT_FIRST] = or_nan(light.early_ns[0]);
    if (ask->scene->detector[ask->detector[d]].reading.given)
        read_cells(table, d, &light, value);
    if (ask->timed)
        value[RMAP_EVENT_TRIGGER] = or_nan(light.early_ns[table->trigger.order - 1]);
}

static double signal_of(const double *value)
{
    return isnan(value[RMAP_EVENT_CELLS]) ? value[RMAP_EVENT_SUM] : value[RMAP_EVENT_CELLS];
}

static bool fires(const struct rmap_event_table *table, const double *value)
{
    return signal_of(value) >= table->trigger.threshold &&
           (!table->ask->timed || isfinite(value[RMAP_EVENT_TRIGGER]));
}

static int compare(const void *a, const void *b)
{
    const double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* `least` of the times lie within the window. */
static bool coincide(const struct rmap_event_table *table, size_t n)
{
    const size_t least = table->trigger.least;
    if (n < least)
        return false;
    if (!table->ask->timed)
        return true;
    qsort(table->time, n, sizeof *table->time, compare);
    for (size_t i = 0; i + least <= n; i++)
        if (table->time[i + least - 1] - table->time[i] <= table->trigger.window_ns)
            return true;
    return false;
}

const struct rmap_event_row *rmap_event_table_next(struct rmap_event_table *table, size_t *index)
{
    const struct rmap_event_ask *ask = table->ask;
    struct rmap_event_row *row = &table->row;
    while (*index < ask->n_event && rmap_event_sums_rays(table->sums, *index) == 0)
        (*index)++;
    if (*index == ask->n_event)
        return NULL;
    row->event = ask->event[*index];
    row->rays = rmap_event_sums_rays(table->sums, *index);
    row->n_fired = 0;
    for (size_t d = 0; d < ask->n_detector; d++) {
        read_detector(table, *index, d, row->value[d]);
        if (fires(table, row->value[d]))
            table->time[row->n_fired++] = row->value[d][RMAP_EVENT_TRIGGER];
    }
    row->coincident = coincide(table, row->n_fired);
    (*index)++;
    return row;
}

/* Welford 1962, doi:10.1080/00401706.1962.10490022. */
static void add_value(struct rmap_event_spread *spread, double value)
{
    if (isnan(value))
        return;
    const double off = value - spread->mean;
    spread->n++;
    spread->mean += off / (double)spread->n;
    spread->squares += off * (value - spread->mean);
}

double rmap_event_spread_deviation(const struct rmap_event_spread *spread)
{
    return spread->n > 1 ? sqrt(spread->squares / (double)(spread->n - 1)) : (double)NAN;
}

enum rmap_status rmap_event_summary_init(struct rmap_event_table *table,
                                         struct rmap_event_summary *summary, struct rmap_error *err)
{
    const size_t n = table->ask->n_detector;
    const struct rmap_event_row *row;
    *summary = (struct rmap_event_summary){.detector = rmap_alloc(n, sizeof *summary->detector)};
    if (!summary->detector)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors", n);
    for (size_t index = 0; (row = rmap_event_table_next(table, &index)) != NULL;) {
        for (size_t d = 0; d < n; d++) {
            struct rmap_event_of_detector *of = &summary->detector[d];
            const double *value = row->value[d];
            add_value(&of->signal, signal_of(value));
            add_value(&of->first, value[RMAP_EVENT_FIRST]);
            of->n_fired += fires(table, value);
            if (fires(table, value))
                add_value(&of->trigger, value[RMAP_EVENT_TRIGGER]);
        }
        summary->n_coincident += row->coincident;
        if (n == 2 && row->n_fired == 2)
            add_value(&summary->difference,
                      row->value[0][RMAP_EVENT_TRIGGER] - row->value[1][RMAP_EVENT_TRIGGER]);
    }
    return RMAP_OK;
}

void rmap_event_summary_fini(struct rmap_event_summary *summary)
{
    rmap_free(summary->detector);
    *summary = (struct rmap_event_summary){0};
}

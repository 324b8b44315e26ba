/* SPDX-License-Identifier: MIT
 *
 * Statistics as text: for people, as CSV, as JSON.
 */
#include <inttypes.h>
#include <math.h>
#include <string.h>

#include "analysis/stats/stats_text.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/grouped.h"
#include "io/export/json_number.h"
#include "io/map/map_json.h"

/* json_object_set_new ignores what could not be made: the document is checked at its end. */
static void set(json_t *object, const char *key, json_t *value, bool *short_of_memory)
{
    if (!value || json_object_set_new(object, key, value) != 0)
        *short_of_memory = true;
}

static void append(json_t *array, json_t *value, bool *short_of_memory)
{
    if (!value || json_array_append_new(array, value) != 0)
        *short_of_memory = true;
}

static json_t *estimate(struct rmap_stats_estimate value)
{
    return json_pack("{s:o, s:o}", "value", rmap_json_number(value.value), "standard_error",
                     rmap_json_number(value.standard_error));
}

static json_t *flux(const struct rmap_stats *stats, struct rmap_stats_estimate value)
{
    return json_pack("{s:o, s:o, s:s}", "value", rmap_json_number(value.value), "standard_error",
                     rmap_json_number(value.standard_error), "unit", rmap_stats_flux_unit(stats));
}

static json_t *numbers(const double *value, size_t n, bool *failed)
{
    json_t *array = json_array();
    for (size_t k = 0; k < n; k++)
        append(array, rmap_json_number(value[k]), failed);
    return array;
}

static void set_summary(json_t *object, const struct rmap_stats *stats,
                        const struct rmap_stats_group *group, size_t i, bool *failed)
{
    const struct rmap_stats_summary *of = &group->of[i];
    set(object, "mean", estimate(of->moment.mean), failed);
    set(object, "standard_deviation", estimate(of->moment.deviation), failed);
    set(object, "skewness", estimate(of->moment.skewness), failed);
    set(object, "kurtosis", estimate(of->moment.kurtosis), failed);
    set(object, "min", rmap_json_number(of->least), failed);
    set(object, "max", rmap_json_number(of->greatest), failed);
    json_t *quantiles = json_array();
    for (size_t k = 0; k < stats->n_quantile; k++)
        append(quantiles,
               json_pack("{s:o, s:o, s:o}", "p", rmap_json_number(stats->p[k]), "value",
                         rmap_json_number(of->quantile[k].value), "standard_error",
                         rmap_json_number(of->quantile[k].standard_error)),
               failed);
    set(object, "quantiles", quantiles, failed);
    set(object, "quantile_resolution", rmap_json_number(stats->resolution[i]), failed);
}

enum field { FIELD_FLUX, FIELD_ERROR, FIELD_RAYS };

static json_t *field_at(const struct rmap_stats_group *group, enum field field, size_t cell)
{
    if (field == FIELD_RAYS)
        return json_integer((json_int_t)group->cell_rays[cell]);
    return rmap_json_number(field == FIELD_FLUX ? group->cell[cell].value
                                                : group->cell[cell].standard_error);
}

/* A row of bins, or of two quantities rows along y of them. */
static json_t *field(const struct rmap_stats *stats, const struct rmap_stats_group *group,
                     enum field which, bool *failed)
{
    const struct rmap_bins *bins = stats->plan->bins;
    const bool two = stats->setup->quantities->n == 2;
    json_t *rows = json_array();
    for (size_t j = 0; j < (two ? bins[1].n : 1); j++) {
        json_t *row = json_array();
        for (size_t i = 0; i < bins[0].n; i++)
            append(row, field_at(group, which, i + j * bins[0].n), failed);
        if (!two) {
            json_decref(rows);
            return row;
        }
        append(rows, row, failed);
    }
    return rows;
}

static json_t *cell(const struct rmap_stats_group *group, size_t c)
{
    return json_pack("{s:o, s:o, s:o}", "flux", rmap_json_number(group->cell[c].value),
                     "standard_error", rmap_json_number(group->cell[c].standard_error), "rays",
                     json_integer((json_int_t)group->cell_rays[c]));
}

static json_t *histogram(const struct rmap_stats *stats, const struct rmap_stats_group *group,
                         bool *failed)
{
    const struct rmap_stats_plan *plan = stats->plan;
    const bool two = stats->setup->quantities->n == 2;
    json_t *object = json_object();
    set(object, two ? "x_edges" : "edges", numbers(plan->bins[0].edge, plan->bins[0].n + 1, failed),
        failed);
    if (two)
        set(object, "y_edges", numbers(plan->bins[1].edge, plan->bins[1].n + 1, failed), failed);
    set(object, "flux", field(stats, group, FIELD_FLUX, failed), failed);
    set(object, "standard_error", field(stats, group, FIELD_ERROR, failed), failed);
    set(object, "rays", field(stats, group, FIELD_RAYS, failed), failed);
    if (!two)
        set(object, "below", cell(group, plan->n_cell + RMAP_STATS_BELOW), failed);
    set(object, two ? "outside" : "above", cell(group, plan->n_cell + RMAP_STATS_ABOVE), failed);
    return object;
}

static void set_group(json_t *object, const struct rmap_stats *stats,
                      const struct rmap_stats_group *group, bool *failed)
{
    const struct rmap_quantities *quantities = stats->setup->quantities;
    set(object, "values", json_integer((json_int_t)group->n_reading), failed);
    set(object, "values_of_rays", json_integer((json_int_t)group->n_ray), failed);
    set(object, "flux", flux(stats, group->flux), failed);
    if (quantities->n == 1) {
        set_summary(object, stats, group, 0, failed);
    } else {
        json_t *each = json_array();
        for (size_t i = 0; i < quantities->n; i++) {
            json_t *own = json_pack("{s:s, s:s}", "of", quantities->of[i].name, "unit",
                                    quantities->of[i].unit);
            if (own)
                set_summary(own, stats, group, i, failed);
            append(each, own, failed);
        }
        set(object, "quantities", each, failed);
    }
    set(object, "histogram", histogram(stats, group, failed), failed);
}

static json_t *names(const struct rmap_quantities *quantities, bool units, bool *failed)
{
    if (quantities->n == 1)
        return json_string(units ? quantities->of[0].unit : quantities->of[0].name);
    json_t *array = json_array();
    for (size_t i = 0; i < quantities->n; i++)
        append(array, json_string(units ? quantities->of[i].unit : quantities->of[i].name), failed);
    return array;
}

json_t *rmap_stats_json(const struct rmap_stats *stats, const struct rmap_stats_labels *labels)
{
    bool failed = false;
    json_t *object = json_object();
    set(object, "map", json_string(labels->map), &failed);
    set(object, "criterion", json_string(labels->criterion ? labels->criterion : "all"), &failed);
    set(object, "which", rmap_which_json(labels->which), &failed);
    set(object, "of", names(stats->setup->quantities, false, &failed), &failed);
    set(object, "unit", names(stats->setup->quantities, true, &failed), &failed);
    if (rmap_quantities_of_phase_time(stats->setup->quantities))
        set(object, "time", json_string("phase"), &failed);
    set(object, "rays",
        json_pack("{s:I, s:I}", "total", (json_int_t)labels->n_ray, "matched",
                  (json_int_t)stats->known.n_ray),
        &failed);
    set(object, "undefined", json_integer((json_int_t)stats->known.n_undefined), &failed);
    rmap_json_add_part(object, labels->part);
    if (stats->setup->by == RMAP_STATS_TOGETHER) {
        set_group(object, stats, &stats->group[0], &failed);
    } else {
        json_t *groups = json_array();
        set(object, "by", json_string(rmap_stats_by_word(stats->setup->by)), &failed);
        for (size_t g = 0; g < stats->n_group; g++) {
            if (!rmap_stats_shows(stats, g))
                continue;
            json_t *own =
                json_pack("{s:s*, s:s}", "criterion", rmap_stats_setup_criterion(stats->setup, g),
                          "name", rmap_stats_setup_name(stats->setup, g));
            if (own)
                set_group(own, stats, &stats->group[g], &failed);
            append(groups, own, &failed);
        }
        set(object, "groups", groups, &failed);
    }
    if (!failed)
        return rmap_json_of_map(object, stats->setup->quantities->map);
    json_decref(object);
    return NULL;
}

const char *rmap_stats_flux_unit(const struct rmap_stats *stats)
{
    return rmap_flux_unit_name(stats->setup->quantities->scene);
}

void rmap_stats_name(const struct rmap_stats *stats, size_t quantity, char *name, size_t nbytes)
{
    const struct rmap_quantity *of = &stats->setup->quantities->of[quantity];
    (void)snprintf(name, nbytes, "%s%s%s", of->name, *of->unit ? ", " : "", of->unit);
}

bool rmap_stats_shows(const struct rmap_stats *stats, size_t group)
{
    const struct rmap_stats_setup *setup = stats->setup;
    if (setup->by == RMAP_STATS_BY_DETECTOR)
        return rmap_index_set_has(&setup->quantities->detector,
                                  (int32_t)rmap_stats_setup_own(setup, group));
    return setup->by <= RMAP_STATS_BY_SOURCE || setup->by == RMAP_STATS_BY_CRITERION ||
           (setup->paths && group < setup->paths->n) || stats->group[group].n_reading > 0;
}

static void add_estimate(struct rmap_text_table *table, const char *name,
                         struct rmap_stats_estimate estimate, const char *unit)
{
    rmap_text_table_add(table, "  %s", name);
    rmap_text_table_add(table, isfinite(estimate.value) ? "%.8g" : "-", estimate.value);
    rmap_text_table_add(table, isfinite(estimate.standard_error) ? "+- %.3g" : "",
                        estimate.standard_error);
    rmap_text_table_add(table, "%s", unit);
}

static enum rmap_status print_summary(const struct rmap_stats *stats,
                                      const struct rmap_stats_group *group, size_t i, FILE *out,
                                      struct rmap_error *err)
{
    const struct rmap_stats_summary *of = &group->of[i];
    const char *unit = stats->setup->quantities->of[i].unit;
    struct rmap_text_table table;
    rmap_text_table_init(&table, 4);
    add_estimate(&table, "mean", of->moment.mean, unit);
    add_estimate(&table, "standard deviation", of->moment.deviation, unit);
    add_estimate(&table, "skewness", of->moment.skewness, "");
    add_estimate(&table, "kurtosis", of->moment.kurtosis, "");
    add_estimate(&table, "least", (struct rmap_stats_estimate){of->least, (double)NAN}, unit);
    for (size_t k = 0; k < stats->n_quantile; k++) {
        char name[48];
        (void)snprintf(name, sizeof name, "%.6g %%", 100.0 * stats->p[k]);
        add_estimate(&table, name, of->quantile[k], unit);
    }
    add_estimate(&table, "greatest", (struct rmap_stats_estimate){of->greatest, (double)NAN}, unit);
    enum rmap_status st = rmap_text_table_print(&table, "lrll", out, err);
    rmap_text_table_fini(&table);
    return st;
}

enum { BAR = 40 };

static void add_bin(struct rmap_text_table *table, const struct rmap_stats_group *group,
                    size_t cell, double most)
{
    char bar[BAR + 1];
    const struct rmap_stats_estimate *flux = &group->cell[cell];
    size_t n = most > 0.0 ? (size_t)lround(BAR * fmin(flux->value / most, 1.0)) : 0;
    memset(bar, '#', n);
    bar[n] = 0;
    rmap_text_table_add(table, "%.0f", group->cell_rays[cell]);
    rmap_text_table_add(table, "%.6g", flux->value);
    rmap_text_table_add(table, isfinite(flux->standard_error) ? "+- %.3g" : "",
                        flux->standard_error);
    rmap_text_table_add(table, "%s", bar);
}

static enum rmap_status print_histogram(const struct rmap_stats *stats,
                                        const struct rmap_stats_group *group, FILE *out,
                                        struct rmap_error *err)
{
    const struct rmap_bins *bins = &stats->plan->bins[0];
    const char *head[] = {"  from", "to", "rays", "flux", "", ""};
    double most = 0.0;
    struct rmap_text_table table;
    rmap_text_table_init(&table, 6);
    for (size_t k = 0; k < 6; k++)
        rmap_text_table_add(&table, "%s", head[k]);
    for (size_t k = 0; k < bins->n; k++)
        most = fmax(most, group->cell[k].value);
    if (group->cell_rays[bins->n + RMAP_STATS_BELOW] > 0.0) {
        rmap_text_table_add(&table, "  below");
        rmap_text_table_add(&table, "%.7g", bins->edge[0]);
        add_bin(&table, group, bins->n + RMAP_STATS_BELOW, most);
    }
    for (size_t k = 0; k < bins->n; k++) {
        rmap_text_table_add(&table, "  %.7g", bins->edge[k]);
        rmap_text_table_add(&table, "%.7g", bins->edge[k + 1]);
        add_bin(&table, group, k, most);
    }
    if (group->cell_rays[bins->n + RMAP_STATS_ABOVE] > 0.0) {
        rmap_text_table_add(&table, "  above");
        rmap_text_table_add(&table, "%.7g", bins->edge[bins->n]);
        add_bin(&table, group, bins->n + RMAP_STATS_ABOVE, most);
    }
    enum rmap_status st = rmap_text_table_print(&table, "rrrrll", out, err);
    rmap_text_table_fini(&table);
    return st;
}

static enum rmap_status print_group(const struct rmap_stats *stats,
                                    const struct rmap_stats_group *group, FILE *out,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (group->name)
        fprintf(out, "\n%s %s\n", rmap_stats_by_word(stats->setup->by), group->name);
    char n[RMAP_GROUPED_LEN];
    fprintf(out, "%-14s %s of %s\n", "values", rmap_grouped(group->n_reading, n),
            rmap_counted((uint64_t)group->n_ray, "ray").text);
    fprintf(out, "%-14s %.9g", "flux", group->flux.value);
    if (isfinite(group->flux.standard_error))
        fprintf(out, " +- %.3g", group->flux.standard_error);
    fprintf(out, " %s\n", rmap_stats_flux_unit(stats));
    if (group->n_reading == 0) {
        fputs("nothing to show: no ray has a value here\n", out);
        return RMAP_OK;
    }
    for (size_t i = 0; i < stats->setup->quantities->n; i++) {
        char name[128];
        rmap_stats_name(stats, i, name, sizeof name);
        fprintf(out, "%s\n", name);
        RMAP_TRY(print_summary(stats, group, i, out, err));
        if (stats->resolution[i] > 0.0)
            fprintf(out, "  (quantiles to within %.3g)\n", stats->resolution[i]);
    }
    if (stats->setup->quantities->n == 1)
        st = print_histogram(stats, group, out, err);
    else
        fprintf(out, "histogram of %zu x %zu bins (-o OUT.csv, .h5, .npz, .png shows it)\n",
                stats->plan->bins[0].n, stats->plan->bins[1].n);
out:
    return st;
}

enum rmap_status rmap_stats_print(const struct rmap_stats *stats,
                                  const struct rmap_stats_labels *labels, FILE *out,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    fprintf(out, "%-14s %s\n", "criterion", labels->criterion ? labels->criterion : "all");
    rmap_which_print(labels->which, out);
    char matched[RMAP_GROUPED_LEN], all[RMAP_GROUPED_LEN], part[RMAP_MAP_PART_LEN];
    fprintf(out, "%-14s %s of %s\n", "rays matched", rmap_grouped(stats->known.n_ray, matched),
            rmap_grouped(labels->n_ray, all));
    rmap_map_part_text(labels->part, part);
    if (part[0])
        fprintf(out, "%-14s %s\n", "until", part);
    if (stats->known.n_undefined > 0)
        fprintf(out, "%-14s %" PRIu64 " values are not defined and left out\n", "note",
                stats->known.n_undefined);
    for (size_t g = 0; g < stats->n_group; g++)
        if (rmap_stats_shows(stats, g))
            RMAP_TRY(print_group(stats, &stats->group[g], out, err));
out:
    return st;
}

/* A number or, where there is none, an empty field. */
static void csv_row(const struct rmap_stats *stats, const struct rmap_stats_group *group,
                    size_t cell, FILE *out)
{
    const struct rmap_stats_plan *plan = stats->plan;
    if (group->name) {
        rmap_csv_put_first(group->name, out);
        fputc(',', out);
    }
    for (size_t i = 0, at = cell; i < stats->setup->quantities->n; i++) {
        size_t k = at % plan->bins[i].n;
        at /= plan->bins[i].n;
        fprintf(out, "%s%.17g,%.17g", i > 0 ? "," : "", plan->bins[i].edge[k],
                plan->bins[i].edge[k + 1]);
    }
    rmap_csv_put_number(group->cell[cell].value, out);
    rmap_csv_put_number(group->cell[cell].standard_error, out);
    fprintf(out, ",%.17g\n", group->cell_rays[cell]);
}

void rmap_stats_csv(const struct rmap_stats *stats, const struct rmap_stats_labels *labels,
                    FILE *out)
{
    const size_t n = stats->setup->quantities->n;
    char part[RMAP_MAP_PART_LEN];
    fprintf(out, "# criterion: %s\n", labels->criterion ? labels->criterion : "all");
    rmap_which_csv(labels->which, out);
    for (size_t i = 0; i < n; i++) {
        char name[128];
        rmap_stats_name(stats, i, name, sizeof name);
        fprintf(out, "# of: %s\n", name);
    }
    fprintf(out, "# flux: %s\n# rays: %" PRIu64 " of %" PRIu64 "\n", rmap_stats_flux_unit(stats),
            stats->known.n_ray, labels->n_ray);
    rmap_map_part_text(labels->part, part);
    if (part[0])
        fprintf(out, "# until: %s\n", part);
    if (stats->setup->by != RMAP_STATS_TOGETHER)
        fprintf(out, "%s,", rmap_stats_by_word(stats->setup->by));
    fputs(n == 1 ? "low,high," : "x_low,x_high,y_low,y_high,", out);
    fputs("flux,standard_error,rays\n", out);
    for (size_t g = 0; g < stats->n_group; g++)
        for (size_t c = 0; rmap_stats_shows(stats, g) && c < stats->plan->n_cell; c++)
            csv_row(stats, &stats->group[g], c, out);
}

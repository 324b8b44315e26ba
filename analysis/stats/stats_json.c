/* SPDX-License-Identifier: MIT */

#include "analysis/stats/stats_text.h"
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
    set(object, "rays",
        json_pack("{s:I, s:I}", "total", (json_int_t)labels->n_ray, "matched",
                  (json_int_t)stats->known.n_ray),
        &failed);
    set(object, "undefined", json_integer((json_int_t)stats->known.n_undefined), &failed);
    if (stats->setup->by == RMAP_STATS_TOGETHER) {
        set_group(object, stats, &stats->group[0], &failed);
    } else {
        json_t *groups = json_array();
        set(object, "by",
            json_string(stats->setup->by == RMAP_STATS_BY_SOURCE ? "source" : "detector"), &failed);
        for (size_t g = 0; g < stats->n_group; g++) {
            if (!rmap_stats_shows(stats, g))
                continue;
            json_t *own = json_pack("{s:s}", "name", stats->group[g].name);
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

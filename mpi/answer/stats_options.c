/* SPDX-License-Identifier: MIT
 *
 * What `raymap stats` is asked for.
 */
#include "mpi/answer/stats_options.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "mpi/command/argument_numbers.h"
#include "mpi/command/output.h"

void rmap_stats_options_fini(struct rmap_stats_options *options)
{
    rmap_argument_list_free(options->of, options->n_of);
    rmap_argument_list_free(options->where, options->n_where);
    rmap_argument_list_free(options->unit, options->n_unit);
    rmap_argument_list_free(options->bins, options->n_bins);
    rmap_argument_list_free(options->range, options->n_range);
    rmap_argument_list_free(options->output, options->n_output);
    rmap_free(options->quantile);
    *options = (struct rmap_stats_options){0};
}

enum rmap_status rmap_stats_by_read(const char *word, enum rmap_stats_by end,
                                    enum rmap_stats_by *by, struct rmap_error *err)
{
    const char *known[RMAP_STATS_BY_COUNT];
    char list[128] = "";
    size_t n = 0;
    *by = RMAP_STATS_TOGETHER;
    if (!word)
        return RMAP_OK;
    for (int k = RMAP_STATS_BY_SOURCE; k < RMAP_STATS_BY_COUNT; k++) {
        const char *its = rmap_stats_by_word((enum rmap_stats_by)k);
        if (strcmp(word, its) == 0)
            *by = (enum rmap_stats_by)k;
        if (k >= (int)end)
            continue;
        known[n++] = its;
        const size_t len = strlen(list);
        (void)snprintf(list + len, sizeof list - len, "%s%s",
                       n == 1              ? ""
                       : k + 1 == (int)end ? " or "
                                           : ", ",
                       its);
    }
    if (*by != RMAP_STATS_TOGETHER)
        return RMAP_OK;
    const char *nearest = rmap_nearest_word(word, known, n);
    if (nearest)
        return rmap_error_set(err, RMAP_USAGE, "--by '%s': did you mean '%s'?", word, nearest);
    return rmap_error_set(err, RMAP_USAGE, "--by '%s': say %s", word, list);
}

/* Classes of paths. */
enum { TOP_DEFAULT = 10, TOP_MOST = 100 };

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

enum { QUANTILES_MAX = 1000 };

static enum rmap_status read_quantiles(const struct rmap_arguments *given,
                                       struct rmap_stats_options *options, struct rmap_error *err)
{
    static const double usual[] = {0.05, 0.25, 0.5, 0.75, 0.95};
    enum rmap_status st = RMAP_OK;
    char **list = NULL;
    size_t n = 0;
    RMAP_TRY(rmap_argument_list(given, "quantiles", &list, &n, err));
    options->n_quantile = n > 0 ? n : sizeof usual / sizeof *usual;
    options->quantile = rmap_alloc(options->n_quantile, sizeof *options->quantile);
    if (!options->quantile || n > QUANTILES_MAX) {
        st = rmap_error_set(err, options->quantile ? RMAP_USAGE : RMAP_SYSTEM,
                            "--quantiles: %zu are too many", n);
        goto out;
    }
    for (size_t i = 0; i < options->n_quantile; i++) {
        char *end = NULL;
        double p = n > 0 ? strtod(list[i], &end) / 100.0 : usual[i];
        if (n > 0 && (end == list[i] || *end || !(p >= 0.0 && p <= 1.0))) {
            st = rmap_error_set(err, RMAP_USAGE,
                                "--quantiles '%s': say per cents from 0 to 100, as 5,50,95",
                                list[i]);
            goto out;
        }
        options->quantile[i] = p;
    }
    qsort(options->quantile, options->n_quantile, sizeof *options->quantile, compare);
out:
    rmap_argument_list_free(list, n);
    return st;
}

enum rmap_status rmap_stats_options_read(const struct rmap_arguments *given,
                                         const char *const *suffixes,
                                         struct rmap_stats_options *options, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint64_t memory = RMAP_STATS_BUDGET_NBYTES;
    options->detector = rmap_argument(given, "detector");
    options->logarithmic = rmap_argument(given, "log") != NULL;
    options->top = TOP_DEFAULT;
    RMAP_TRY(rmap_argument_count(given, "top", &options->top, err));
    RMAP_TRY(
        rmap_stats_by_read(rmap_argument(given, "by"), RMAP_STATS_BY_COUNT, &options->by, err));
    RMAP_TRY(rmap_argument_each(given, "of", &options->of, &options->n_of, err));
    RMAP_TRY(rmap_argument_each(given, "where", &options->where, &options->n_where, err));
    RMAP_TRY(rmap_argument_each(given, "unit", &options->unit, &options->n_unit, err));
    RMAP_TRY(rmap_argument_each(given, "bins", &options->bins, &options->n_bins, err));
    RMAP_TRY(rmap_argument_each(given, "range", &options->range, &options->n_range, err));
    RMAP_TRY(rmap_argument_each(given, "output", &options->output, &options->n_output, err));
    RMAP_TRY(rmap_argument_count(given, "memory", &memory, err));
    options->memory_nbytes = (size_t)memory;
    RMAP_TRY(read_quantiles(given, options, err));
    if (rmap_argument(given, "top") && options->by < RMAP_STATS_BY_PATH)
        return rmap_error_set(err, RMAP_USAGE, "--top is how many classes of --by path");
    if (options->top < 1 || options->top > TOP_MOST)
        return rmap_error_set(err, RMAP_USAGE, "--top lies between 1 and %d classes", TOP_MOST);
    if (options->n_of < 1 || options->n_of > RMAP_QUANTITIES_MAX)
        return rmap_error_set(err, RMAP_USAGE,
                              options->n_of < 1 ? "--of is missing: statistics of which number?"
                                                : "--of stands once, or twice");
    if (options->n_bins > options->n_of || options->n_range > options->n_of ||
        options->n_unit > options->n_of)
        return rmap_error_set(err, RMAP_USAGE, "more --bins, --range or --unit than --of");
    for (size_t i = 0; i < options->n_output; i++)
        RMAP_TRY(rmap_output_check(options->output[i], suffixes,
                                   rmap_argument(given, "force") != NULL, err));
out:
    return st;
}

void rmap_stats_axes_fini(struct rmap_stats_axis *axis)
{
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++) {
        rmap_free(axis[i].edge);
        axis[i].edge = NULL;
    }
}

/* One edge, such as `2.5 mm`, or `2.5` with the unit of all. */
static enum rmap_status read_edge(const struct rmap_quantities *quantities, size_t index,
                                  const char *text, size_t nbytes, const char *unit, double *edge,
                                  struct rmap_error *err)
{
    char written[128];
    double range[2];
    if (2 * (nbytes + strlen(unit)) + 3 > sizeof written)
        return rmap_error_set(err, RMAP_USAGE, "--bins: an edge of %zu characters", nbytes);
    (void)snprintf(written, sizeof written, "%.*s%s..%.*s%s", (int)nbytes, text, unit, (int)nbytes,
                   text, unit);
    enum rmap_status st = rmap_quantity_range(quantities, index, written, "--bins", range, err);
    *edge = range[0];
    return st;
}

/* What stands behind the number of an edge. */
static const char *behind_number(const char *edge)
{
    char *end = NULL;
    (void)strtod(edge, &end);
    return end + strspn(end, " ");
}

/* The unit of the last edge where no other has one: it is meant for all of them. "" else. */
static const char *common_unit(const char *text)
{
    const char *last = text;
    for (const char *comma = strchr(text, ','); comma; comma = strchr(last, ',')) {
        const char *unit = behind_number(last);
        if (unit != comma)
            return "";
        last = comma + 1;
    }
    return behind_number(last);
}

/* Edges between commas. */
static enum rmap_status read_edges(const struct rmap_quantities *quantities, size_t index,
                                   const char *text, struct rmap_stats_axis *axis,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const char *const unit = common_unit(text);
    size_t n = 1;
    for (const char *p = text; *p; p++)
        n += *p == ',';
    axis->edge = rmap_alloc(n, sizeof *axis->edge);
    if (!axis->edge)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu edges", n);
    axis->n_edge = n;
    for (size_t k = 0; k < n; k++) {
        size_t nbytes = strcspn(text, ",");
        RMAP_TRY(
            read_edge(quantities, index, text, nbytes, k + 1 < n ? unit : "", &axis->edge[k], err));
        text += nbytes + 1;
        if (k > 0 && !(axis->edge[k - 1] < axis->edge[k]))
            return rmap_error_set(err, RMAP_USAGE, "--bins: edges must ascend, not from %g to %g",
                                  axis->edge[k - 1], axis->edge[k]);
    }
out:
    return st;
}

static enum rmap_status read_bins(const struct rmap_quantities *quantities, size_t index,
                                  const char *text, struct rmap_stats_axis *axis,
                                  struct rmap_error *err)
{
    uint64_t n = 0;
    if (strchr(text, ','))
        return read_edges(quantities, index, text, axis, err);
    enum rmap_status st = rmap_parse_count(text, "--bins", &n, err);
    if (st == RMAP_OK && n < 1)
        return rmap_error_set(err, RMAP_USAGE, "--bins: one bin at least");
    axis->n_bin = (size_t)n;
    return st;
}

enum rmap_status rmap_stats_options_axes(const struct rmap_stats_options *options,
                                         const struct rmap_quantities *quantities,
                                         struct rmap_stats_axis *axis, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < options->n_of; i++) {
        axis[i].logarithmic = options->logarithmic;
        if (options->n_bins > 0) /* one for both, or one each */
            RMAP_TRY(read_bins(quantities, i, options->bins[i < options->n_bins ? i : 0], &axis[i],
                               err));
        if (i >= options->n_range)
            continue;
        axis[i].has_range = true;
        RMAP_TRY(
            rmap_quantity_range(quantities, i, options->range[i], "--range", axis[i].range, err));
        if (options->logarithmic && !(axis[i].range[0] > 0.0))
            return rmap_error_set(err, RMAP_USAGE, "--log wants a --range above 0");
        if (!(axis[i].range[0] < axis[i].range[1]))
            return rmap_error_set(err, RMAP_USAGE, "--range %s has no width", options->range[i]);
    }
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Classes of paths as a table for people, as JSON and as CSV.
 */
#include "analysis/paths/path_report_out.h"

#include <inttypes.h>
#include <math.h>

#include "analysis/detector/image_unit.h"
#include "analysis/paths/path_text.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "io/export/json_number.h"

static const char *flux_unit(const struct rmap_scene *scene)
{
    return rmap_flux_unit_name(scene);
}

static const char *peak_unit(const struct rmap_scene *scene, int32_t detector)
{
    return rmap_image_unit_usual(scene->detector[detector].type == RMAP_DETECTOR_PLANE
                                     ? RMAP_PER_AREA
                                     : RMAP_PER_SOLID_ANGLE,
                                 scene->flux_unit)
        ->name;
}

/* What columns but the last take, about; and what is left of a line for it at least and at most. */
enum { OTHER_COLUMNS = 88, LEAST = 32, MOST = 480 };

static void add_error(struct rmap_text_table *table, double error)
{
    if (isfinite(error))
        rmap_text_table_add(table, "%.2g", error);
    else
        rmap_text_table_add(table, "-");
}

static void add_row(struct rmap_text_table *table, const struct rmap_path_report *report, size_t k,
                    size_t width)
{
    char path[MOST + 32];
    const struct rmap_path_row *row = &report->row[k];
    const struct rmap_scene *scene = report->scene;
    rmap_text_table_add(table, "%zu", k + 1);
    rmap_text_table_add(table, "%.3g %%", 100.0 * row->share);
    rmap_text_table_add(table, "%.5g", row->flux);
    add_error(table, row->standard_error);
    rmap_text_table_add(table, "%" PRIu64, row->rays);
    rmap_text_table_add(table, "%.4g", (double)row->segments / (double)row->rays);
    rmap_text_table_add(table, "%" PRIu64, row->registrations);
    if (row->peak.detector >= 0 && isfinite(row->peak.standard_error))
        rmap_text_table_add(table, "%.3g +- %.1g %s", row->peak.value, row->peak.standard_error,
                            peak_unit(scene, row->peak.detector));
    else if (row->peak.detector >= 0)
        rmap_text_table_add(table, "%.3g %s", row->peak.value,
                            peak_unit(scene, row->peak.detector));
    else
        rmap_text_table_add(table, "-");
    if (report->timed)
        rmap_text_table_add(table, "%.5g", row->mean_time);
    rmap_text_table_add(table, "%" PRIu64, row->first_ray);
    rmap_path_shorten(row->sequence, width, path, sizeof path);
    rmap_text_table_add(table, "%s: %s", scene->source[row->source].name, path);
}

static void add_rest(struct rmap_text_table *table, const struct rmap_path_report *report)
{
    const struct rmap_path_total *rest = &report->rest;
    rmap_text_table_add(table, "rest");
    rmap_text_table_add(table, "%.3g %%",
                        report->total.flux > 0.0 ? 100.0 * rest->flux / report->total.flux : 0.0);
    rmap_text_table_add(table, "%.5g", rest->flux);
    add_error(table, rest->standard_error);
    rmap_text_table_add(table, "%" PRIu64, rest->rays);
    rmap_text_table_add(table, "%.4g", (double)rest->segments / (double)rest->rays);
    for (int c = 0; c < 3 + report->timed; c++)
        rmap_text_table_add(table, "%s", "");
    if (report->exact)
        rmap_text_table_add(table, "%zu more", report->n_class - report->n_row);
    else
        rmap_text_table_add(table, "all others");
}

static void print_head(const struct rmap_path_report *report, FILE *out)
{
    const struct rmap_path_total *total = &report->total;
    fprintf(out, "%s\n", report->criterion ? report->criterion : "all");
    rmap_which_print(report->which, out);
    fprintf(out, "  rays     %" PRIu64, total->rays);
    if (report->n_path > total->rays)
        fprintf(out, ", registered %" PRIu64 " times", report->n_path);
    fprintf(out, "\n  flux     %.6g", total->flux);
    if (isfinite(total->standard_error))
        fprintf(out, " +- %.2g", total->standard_error);
    fprintf(out, " %s\n", flux_unit(report->scene));
    if (report->exact)
        fprintf(out, "  classes  %zu, by %s\n", report->n_class,
                rmap_path_level_word(report->view.level));
    else
        fprintf(out,
                "  classes  more than are counted: all with %.2g %% of the flux or more, by %s\n",
                100.0 * report->bound, rmap_path_level_word(report->view.level));
}

enum rmap_status rmap_path_report_print(const struct rmap_path_report *report, size_t width,
                                        FILE *out, struct rmap_error *err)
{
    static const char *const head[] = {"#",    "share",      "flux",    "+-",        "rays", "legs",
                                       "seen", "peak +- se", "mean ns", "first ray", "path"};
    enum { N = sizeof head / sizeof *head, TIME = N - 3 };
    struct rmap_text_table table;
    size_t room = width > OTHER_COLUMNS + LEAST ? width - OTHER_COLUMNS : LEAST;
    room = width == 0 || room > MOST ? MOST : room;
    print_head(report, out);
    if (report->total.rays == 0) {
        fputs("  no ray has such a path\n", out);
        return RMAP_OK;
    }
    rmap_text_table_init(&table, N - !report->timed);
    for (size_t c = 0; c < N; c++)
        if (c != TIME || report->timed)
            rmap_text_table_add(&table, "%s", head[c]);
    for (size_t k = 0; k < report->n_row; k++)
        add_row(&table, report, k, room);
    if (report->rest.rays > 0)
        add_rest(&table, report);
    enum rmap_status st = rmap_text_table_print(&table, "rrrrrrrrrl", out, err);
    rmap_text_table_fini(&table);
    if (st == RMAP_OK && report->peaks_missing)
        fputs("Peaks of more rows than these take too much memory.\n", out);
    for (size_t k = 0; st == RMAP_OK && k < report->n_row; k++)
        fprintf(out, "%s%zu  %s\n", k == 0 ? "\ncriteria\n" : "", k + 1,
                report->row[k].criterion ? report->row[k].criterion : "(path too long)");
    return st;
}

static json_t *peak_json(const struct rmap_scene *scene, const struct rmap_path_peak *peak)
{
    if (peak->detector < 0)
        return json_null();
    return json_pack("{s:s, s:o, s:o, s:o, s:o, s:s}", "detector",
                     scene->detector[peak->detector].name, "value", rmap_json_number(peak->value),
                     "standard_error", rmap_json_number(peak->standard_error), "x",
                     rmap_json_number(peak->x), "y", rmap_json_number(peak->y), "unit",
                     peak_unit(scene, peak->detector));
}

static json_t *row_json(const struct rmap_path_report *report, size_t k)
{
    const struct rmap_path_row *row = &report->row[k];
    const struct rmap_scene *scene = report->scene;
    json_t *json = json_pack("{s:I, s:s, s:s, s:s?, s:I, s:I, s:o, s:o, s:o, s:I, s:I, s:o}",
                             "rank", (json_int_t)(k + 1), "source", scene->source[row->source].name,
                             "sequence", row->sequence, "criterion", row->criterion, "rays",
                             (json_int_t)row->rays, "segments", (json_int_t)row->segments, "flux",
                             rmap_json_number(row->flux), "share", rmap_json_number(row->share),
                             "standard_error", rmap_json_number(row->standard_error), "first_ray",
                             (json_int_t)row->first_ray, "registrations",
                             (json_int_t)row->registrations, "peak", peak_json(scene, &row->peak));
    if (report->timed && json)
        (void)json_object_set_new(json, "mean_time", rmap_json_number(row->mean_time));
    return json;
}

json_t *rmap_path_report_json(const struct rmap_path_report *report)
{
    const struct rmap_path_total *total = &report->total, *rest = &report->rest;
    const struct rmap_path_view *view = &report->view;
    const struct rmap_scene *scene = report->scene;
    struct rmap_map_summary summary;
    rmap_map_summarise(report->map, &summary);
    json_t *classes = json_array();
    for (size_t k = 0; k < report->n_row; k++)
        (void)json_array_append_new(classes, row_json(report, k));
    return json_pack(
        "{s:s, s:o, s:s, s:b, s:b, s:s?, s:{s:I, s:I}, s:{s:o, s:o, s:s}, s:o, s:{s:o, s:I, s:o, "
        "s:o, "
        "s:o}, s:b, s:o}",
        "criterion", report->criterion ? report->criterion : "all", "which",
        rmap_which_json(report->which), "by", rmap_path_level_word(view->level), "events",
        !view->without_events, "collapsed", (int)view->collapsed, "detector",
        view->until_detector ? scene->detector[view->detector].name : NULL, "rays", "total",
        (json_int_t)summary.n_row[RMAP_TABLE_RAY], "matched", (json_int_t)total->rays, "flux",
        "value", rmap_json_number(total->flux), "standard_error",
        rmap_json_number(total->standard_error), "unit", flux_unit(scene), "classes", classes,
        "remainder", "classes",
        report->exact ? json_integer((json_int_t)(report->n_class - report->n_row)) : json_null(),
        "rays", (json_int_t)rest->rays, "flux", rmap_json_number(rest->flux), "share",
        rmap_json_number(total->flux > 0.0 ? rest->flux / total->flux : 0.0), "standard_error",
        rmap_json_number(rest->standard_error), "exact", (int)report->exact, "bound",
        report->exact ? json_null() : json_real(report->bound));
}

static void put_time(const struct rmap_path_report *report, const struct rmap_path_row *row,
                     FILE *out)
{
    if (report->timed)
        rmap_csv_put_number(row->mean_time, out);
    fputc('\n', out);
}

static void put_row(const struct rmap_path_report *report, size_t k, FILE *out)
{
    const struct rmap_path_row *row = &report->row[k];
    const struct rmap_scene *scene = report->scene;
    fprintf(out, "%zu", k + 1);
    rmap_csv_put_text(scene->source[row->source].name, out);
    rmap_csv_put_text(row->sequence, out);
    rmap_csv_put_text(row->criterion, out);
    fprintf(out, ",%" PRIu64 ",%" PRIu64, row->rays, row->segments);
    rmap_csv_put_number(row->flux, out);
    rmap_csv_put_number(row->share, out);
    rmap_csv_put_number(row->standard_error, out);
    fprintf(out, ",%" PRIu64 ",%" PRIu64, row->first_ray, row->registrations);
    if (row->peak.detector < 0) {
        fputs(",,,,,,", out);
        put_time(report, row, out);
        return;
    }
    rmap_csv_put_text(scene->detector[row->peak.detector].name, out);
    rmap_csv_put_number(row->peak.value, out);
    rmap_csv_put_number(row->peak.standard_error, out);
    rmap_csv_put_number(row->peak.x, out);
    rmap_csv_put_number(row->peak.y, out);
    rmap_csv_put_text(peak_unit(scene, row->peak.detector), out);
    put_time(report, row, out);
}

void rmap_path_report_csv(const struct rmap_path_report *report, FILE *out)
{
    const struct rmap_path_total *total = &report->total, *rest = &report->rest;
    fprintf(out, "# criterion: %s\n# rays: %" PRIu64 "\n# flux: %.17g %s\n",
            report->criterion ? report->criterion : "all", total->rays, total->flux,
            flux_unit(report->scene));
    rmap_which_csv(report->which, out);
    fprintf(out, "# remainder: %" PRIu64 " rays, flux %.17g\n", rest->rays, rest->flux);
    if (!report->exact)
        fprintf(out, "# not all classes: those with a share of %.17g or more\n", report->bound);
    fputs("rank,source,sequence,criterion,rays,segments,flux,share,standard_error,first_ray,"
          "registrations,peak_detector,peak,peak_standard_error,peak_x,peak_y,peak_unit",
          out);
    fputs(report->timed ? ",mean_time_ns\n" : "\n", out);
    for (size_t k = 0; k < report->n_row; k++)
        put_row(report, k, out);
}

/* SPDX-License-Identifier: MIT
 *
 * The tables of a run's page: energy and paths.
 */
#include <math.h>

#include "analysis/report/run_report_internal.h"
#include "analysis/table/html.h"
#include "base/grouped.h"

enum { SOURCE_MAX = 12 /* tables of sources, beside that of all */ };

void rmap_run_report_cell(FILE *out, double value, int digits)
{
    if (isfinite(value))
        fprintf(out, "<td class=\"n\">%.*g</td>", digits, value);
    else
        fputs("<td class=\"n\">nan</td>", out);
}

void rmap_run_report_measured(FILE *out, double value, double error)
{
    rmap_run_report_cell(out, value, 6);
    if (isfinite(error))
        fprintf(out, "<td class=\"n dim\">± %.2g</td>", error);
    else
        fputs("<td></td>", out);
}

void rmap_run_report_name(FILE *out, const char *text)
{
    fputs("<td>", out);
    rmap_html_text(out, text);
    fputs("</td>", out);
}

/* Cells of a row behind its name: rays, flux, share, a bar. most: share of the longest bar. */
static void put_numbers(const struct rmap_energy_row *row, double most, FILE *out)
{
    char rays[RMAP_GROUPED_LEN];
    fprintf(out, "<td class=\"n\">%s</td>", rmap_grouped(rmap_energy_whole(row->rays), rays));
    rmap_run_report_measured(out, row->flux, row->flux_error);
    if (isfinite(row->share))
        fprintf(out, "<td class=\"n\">%.4f</td>", 100.0 * row->share);
    else
        fputs("<td class=\"n\">nan</td>", out);
    if (isfinite(row->share_error))
        fprintf(out, "<td class=\"n dim\">± %.2g</td>", 100.0 * row->share_error);
    else
        fputs("<td></td>", out);
    if (isfinite(row->share) && most > 0.0)
        fprintf(out, "<td class=\"bar\"><i%s style=\"width:%.2f%%\"></i></td>",
                row->end == RMAP_ENERGY_DETECTOR ? " class=\"caught\"" : "",
                fmin(100.0 * row->share / most, 100.0));
    else
        fputs("<td class=\"bar\"></td>", out);
}

static void put_row(const struct rmap_energy_row *row, double most, FILE *out)
{
    fprintf(out, "<tr><td class=\"dim\">%s</td>", rmap_energy_end_text(row->end));
    rmap_run_report_name(out, row->name);
    put_numbers(row, most, out);
    fputs("</tr>\n", out);
}

static void put_table(const struct rmap_energy *energy, const struct rmap_energy_table *table,
                      FILE *out)
{
    struct rmap_energy_shown shown;
    const struct rmap_energy_row emitted = {.name = "",
                                            .rays = table->rays,
                                            .flux = table->flux,
                                            .flux_error = table->flux_error,
                                            .share = table->flux / table->flux};
    double most = 0.0, most_caught = 0.0;
    rmap_energy_show(table, &shown);
    for (size_t i = 0; i < shown.n; i++)
        most = fmax(most, shown.row[i].share);
    fprintf(out,
            "<div class=\"table\"><table>\n<tr><th></th><th></th><th class=\"n\">rays</th><th "
            "class=\"n\">%s</th><th></th><th class=\"n\">%%</th><th></th><th></th></tr>\n"
            "<tr class=\"sum\"><td>emitted</td><td></td>",
            energy->unit);
    put_numbers(&emitted, 0.0, out);
    fputs("</tr>\n", out);
    for (size_t i = 0; i < shown.n; i++)
        put_row(&shown.row[i], most, out);
    fputs("</table></div>\n", out);
    fprintf(out, "<p>These add up to the %s emitted%s.</p>\n",
            rmap_counted(rmap_energy_whole(table->rays), "ray").text,
            table->exact ? ", exactly" : ": NO, they do not");
    if (table->n_detector == 0)
        return;
    fprintf(out,
            "<p>Beside that, light that detectors registered on its way:</p>\n<div "
            "class=\"table\"><table>\n<tr><th></th><th></th><th class=\"n\">registrations</th><th "
            "class=\"n\">%s</th><th></th><th class=\"n\">%%</th><th></th><th></th></tr>\n",
            energy->unit);
    for (size_t d = 0; d < table->n_detector; d++)
        most_caught = fmax(most_caught, table->row[table->n_row + d].share);
    for (size_t d = 0; d < table->n_detector; d++)
        put_row(&table->row[table->n_row + d], most_caught, out);
    fputs("</table></div>\n", out);
}

void rmap_run_report_energy(const struct rmap_run_report *report, FILE *out)
{
    const struct rmap_energy *energy = report->energy;
    const size_t n_source = energy->n_table - 1;
    if (n_source != 1)
        put_table(energy, &energy->table[0], out);
    for (size_t s = 0; s < n_source && s < SOURCE_MAX; s++) {
        if (n_source > 1)
            fputs("<details><summary>", out);
        else
            fputs("<p>", out);
        fputs("Source ", out);
        rmap_html_text(out, energy->table[1 + s].source);
        fputs(n_source > 1 ? " alone</summary>\n" : "</p>\n", out);
        put_table(energy, &energy->table[1 + s], out);
        if (n_source > 1)
            fputs("</details>\n", out);
    }
    if (n_source > SOURCE_MAX)
        fprintf(out, "<p class=\"dim\">Of the first %d of %zu sources.</p>\n", SOURCE_MAX,
                n_source);
    if (report->energy_note) {
        fputs("<p class=\"dim\">", out);
        rmap_html_text(out, report->energy_note);
        fputs("</p>\n", out);
    }
}

static void put_path(const struct rmap_report_path *path, size_t rank, double most, FILE *out)
{
    const struct rmap_energy_row numbers = {.rays = path->rays,
                                            .flux = path->flux,
                                            .flux_error = path->flux_error,
                                            .share = path->share,
                                            .share_error = (double)NAN};
    fprintf(out, "<tr><td class=\"n\">%zu</td><td><code>", rank);
    rmap_html_text(out, path->text);
    fputs("</code>", out);
    if (path->criterion) {
        fputs("<details><summary>criterion</summary><code>", out);
        rmap_html_text(out, path->criterion);
        fputs("</code></details>", out);
    }
    fputs("</td>", out);
    put_numbers(&numbers, most, out);
    fprintf(out, "<td class=\"n\">%llu</td></tr>\n", (unsigned long long)path->first_ray);
}

void rmap_run_report_paths(const struct rmap_run_report *report, FILE *out)
{
    const struct rmap_report_paths *paths = report->paths;
    fputs("<p>Rays of one source that met the same things in the same order, with the same "
          "events. Letters: R specular and D diffuse reflection, T specular and d diffuse "
          "transmission, I total reflection, S scattering in a volume, A absorbed, X left the "
          "scene, K limit, E error, V registered; {2}: twice in a row. The number of the first ray "
          "is for <code>raymap report MAP RAY</code>.</p>\n",
          out);
    if (*paths->note) {
        fputs("<p class=\"note\">", out);
        rmap_html_text(out, paths->note);
        fputs("</p>\n", out);
    }
    if (paths->n == 0) {
        fputs("<p>There is no path.</p>\n", out);
        return;
    }
    fprintf(out,
            "<div class=\"table\"><table class=\"paths\">\n<tr><th></th><th>path</th><th "
            "class=\"n\">rays</th><th class=\"n\">%s</th><th></th><th class=\"n\">%%</th><th>"
            "</th><th></th><th class=\"n\">first ray</th></tr>\n",
            report->energy->unit);
    for (size_t i = 0; i < paths->n; i++)
        put_path(&paths->path[i], i + 1, paths->path[0].share, out);
    fputs("</table></div>\n", out);
    if (paths->n_class > paths->n)
        fprintf(out, "<p>%zu other paths carry %.6g %s, %.4f %%.</p>\n", paths->n_class - paths->n,
                paths->rest_flux, report->energy->unit, 100.0 * paths->rest_share);
}

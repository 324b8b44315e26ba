/* SPDX-License-Identifier: MIT
 *
 * What a run's page says of the map itself: numbers, remarks, provenance, the scene.
 */
#include <math.h>
#include <string.h>

#include "analysis/report/run_report_facts.h"
#include "analysis/table/html.h"
#include "base/grouped.h"
#include "compact/layout.h"
#include "io/map/selection.h"
#include "portion/weight.h"
#include "trace/tally.h"

/* The tables of a run's page: energy and paths. */

enum { SOURCE_MAX = 12 /* tables of sources, beside that of all */ };

static void run_report_cell(FILE *out, double value, int digits)
{
    if (isfinite(value))
        fprintf(out, "<td class=\"n\">%.*g</td>", digits, value);
    else
        fputs("<td class=\"n\">nan</td>", out);
}

void rmap_run_report_measured(FILE *out, double value, double error)
{
    run_report_cell(out, value, 6);
    if (isfinite(error))
        fprintf(out, "<td class=\"n dim\">± %.2g</td>", error);
    else
        fputs("<td></td>", out);
}

static void run_report_name(FILE *out, const char *text)
{
    fputs("<td>", out);
    rmap_html_text(out, text);
    fputs("</td>", out);
}

/* Cells of a row behind its name: rays, flux, share, a bar. most: share of the longest bar. */
static void put_numbers(const struct rmap_energy_row *row, double most, FILE *out)
{
    char rays[RMAP_GROUPED_LEN];
    fprintf(out, "<td class=\"n\">%s</td>", rmap_grouped(rmap_weight_whole(row->rays), rays));
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
    run_report_name(out, row->name);
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
            rmap_counted(rmap_weight_whole(table->rays), "ray").text,
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

enum { LISTED_MAX = 60, SCENE_TEXT_MAX = 256 * 1024 };

/* "3 rays", "1 ray". */
static void put_number_of(FILE *out, size_t n, const char *what, const char *behind)
{
    fprintf(out, "%zu %s%s%s", n, what, n == 1 ? "" : "s", behind);
}

static void put_fact(FILE *out, const char *value, const char *name)
{
    fputs("<div><b>", out);
    rmap_html_text(out, value);
    fputs("</b><span>", out);
    rmap_html_text(out, name);
    fputs("</span></div>\n", out);
}

static void put_count(FILE *out, uint64_t count, const char *name)
{
    char text[RMAP_GROUPED_LEN];
    put_fact(out, rmap_grouped(count, text), name);
}

void rmap_run_report_facts(const struct rmap_run_report *report, FILE *out)
{
    struct rmap_map_summary summary;
    const struct rmap_energy *energy = report->energy;
    char text[64];
    rmap_map_summarise(report->map, &summary);
    const uint64_t n_segment = summary.n_row[RMAP_TABLE_SEGMENT];
    fputs("<div class=\"facts\">\n", out);
    put_count(out, summary.n_row[RMAP_TABLE_RAY], "rays");
    (void)snprintf(text, sizeof text, "%.6g %s", energy->map_flux, energy->unit);
    put_fact(out, text, rmap_map_selection(report->map) ? "carried by them" : "emitted");
    put_count(out, n_segment, "segments");
    put_count(out, summary.n_row[RMAP_TABLE_REGISTRATION], "registrations");
    (void)snprintf(text, sizeof text, "%.1f MB", 1e-6 * (double)summary.nbytes);
    put_fact(out, text, "on disk");
    fputs("</div>\n", out);
}

static void put_note(FILE *out, const char *kind, const char *text)
{
    fprintf(out, "<p class=\"note %s\">", kind);
    rmap_html_text(out, text);
    fputs("</p>\n", out);
}

/* Light that a limit or an error ended is missing in the images. */
static void warn_of_ends(const struct rmap_run_report *report, FILE *out)
{
    const struct rmap_energy_table *table = &report->energy->table[0];
    const uint64_t first = rmap_map_tally(report->map)->first_error_ray;
    char text[256], rays[RMAP_GROUPED_LEN];
    for (size_t i = 0; i < table->n_row; i++) {
        const struct rmap_energy_row *row = &table->row[i];
        if ((row->end != RMAP_ENERGY_LIMIT && row->end != RMAP_ENERGY_ERROR) || !(row->rays > 0.0))
            continue;
        int n = snprintf(text, sizeof text, "%s ray%s (%.3g %% of the flux) %s %s.",
                         rmap_grouped(rmap_weight_whole(row->rays), rays),
                         row->rays > 1.0 ? "s" : "", 100.0 * row->share,
                         row->rays > 1.0 ? "were" : "was", rmap_energy_end_text(row->end));
        if (row->end == RMAP_ENERGY_ERROR && first != UINT64_MAX && n > 0)
            (void)snprintf(text + n, sizeof text - (size_t)n, " The first of them: ray %llu.",
                           (unsigned long long)first);
        put_note(out, "warn", text);
    }
}

void rmap_run_report_warnings(const struct rmap_run_report *report, FILE *out)
{
    struct rmap_map_summary summary;
    const struct rmap_selection *selection = rmap_map_selection(report->map);
    rmap_map_summarise(report->map, &summary);
    if (summary.complete && rmap_map_n_trouble(report->map) == 0)
        put_note(out, "good", "The map is complete.");
    else if (!summary.complete)
        put_note(out, "warn",
                 selection ? "The map is NOT complete: rays that the query picked are missing."
                           : "The map is NOT complete: it is being traced, or tracing was stopped "
                             "early. What is shown here is of the rays that it holds.");
    for (size_t i = 0; i < rmap_map_n_trouble(report->map); i++)
        put_note(out, "warn", rmap_map_trouble(report->map, i));
    if (summary.n_row[RMAP_TABLE_RAY] == 0)
        put_note(out, "warn", "The map holds no ray.");
    for (size_t i = 0; selection && i < selection->n; i++) {
        fputs("<p class=\"note\">Rays picked from ", out);
        rmap_html_text(out, selection->step[i].map);
        fputs(" by <code>", out);
        rmap_html_text(out, selection->step[i].criterion);
        fputs("</code> (", out);
        rmap_html_text(out, selection->step[i].answer);
        fputs("); fluxes are those in that map.</p>\n", out);
    }
    warn_of_ends(report, out);
}

static void put_pair(FILE *out, const char *name, const char *value)
{
    fputs("<tr><th>", out);
    rmap_html_text(out, name);
    fputs("</th><td>", out);
    rmap_html_text(out, value);
    fputs("</td></tr>\n", out);
}

static void put_encodings(const struct rmap_map *map, FILE *out)
{
    size_t n[RMAP_ENCODING_COUNT] = {0};
    char text[128] = "";
    for (size_t i = 0; i < rmap_map_n_piece(map); i++)
        if (rmap_map_piece(map, i)->encoding >= 0 &&
            rmap_map_piece(map, i)->encoding < RMAP_ENCODING_COUNT)
            n[rmap_map_piece(map, i)->encoding]++;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++)
        if (n[e] > 0) {
            size_t at = strlen(text);
            (void)snprintf(text + at, sizeof text - at, "%s%s (%zu piece%s)", at > 0 ? ", " : "",
                           rmap_encoding_name((enum rmap_encoding)e), n[e], n[e] == 1 ? "" : "s");
        }
    put_pair(out, "encoding", *text ? text : "no piece yet");
}

static void put_runs(const struct rmap_map *map, FILE *out)
{
    const size_t n = rmap_map_n_run(map);
    char first[RMAP_GROUPED_LEN], rays[RMAP_GROUPED_LEN];
    if (n == 0)
        return;
    fputs("<h3>Runs that traced it</h3>\n<div class=\"table\"><table>\n<tr><th class=\"n\">first "
          "ray</th><th class=\"n\">rays asked for</th><th class=\"n\">seed</th><th "
          "class=\"n\">ranks</th><th>light</th></tr>\n",
          out);
    for (size_t i = 0; i < n && i < LISTED_MAX; i++) {
        const struct rmap_run_row *run = rmap_map_run(map, i);
        const size_t space = (size_t)run->space < rmap_map_n_space(map) ? (size_t)run->space : 0;
        const struct rmap_channels *channels = &rmap_map_scene_of(map, space)->channels;
        fprintf(out,
                "<tr><td class=\"n\">%s</td><td class=\"n\">%s</td><td class=\"n\">%llu</td>"
                "<td class=\"n\">%d</td><td>%s, %d channels</td></tr>\n",
                rmap_grouped(run->first_ray, first), rmap_grouped(run->n_ray, rays),
                (unsigned long long)run->seed, run->n_rank,
                channels->mode == RMAP_COLOUR_RGB ? "rgb" : "spectral", channels->n);
    }
    fputs("</table></div>\n", out);
    if (n > LISTED_MAX)
        fprintf(out, "<p class=\"dim\">%zu more runs.</p>\n", n - LISTED_MAX);
}

void rmap_run_report_provenance(const struct rmap_run_report *report, FILE *out)
{
    struct rmap_map_summary summary;
    char text[256], digest[33];
    rmap_map_summarise(report->map, &summary);
    rmap_digest_text(summary.digest, digest);
    fputs("<div class=\"table\"><table>\n", out);
    put_pair(out, "map", report->name);
    put_pair(out, "digest of its content", digest);
    (void)snprintf(text, sizeof text, "%llu", (unsigned long long)summary.seed);
    put_pair(out, "seed", text);
    (void)snprintf(text, sizeof text, "raymap %s (%s)", summary.program_version,
                   summary.git_revision);
    put_pair(out, "traced by", text);
    (void)snprintf(text, sizeof text, "Embree %s (%s), HDF5 %s", summary.embree_version,
                   summary.isa, summary.hdf5_version);
    put_pair(out, "libraries", text);
    (void)snprintf(text, sizeof text, "%d", summary.n_rank);
    put_pair(out, "ranks", text);
    (void)snprintf(text, sizeof text, "%d shard%s, %zu piece%s, %.2f bytes per segment",
                   summary.n_shard, summary.n_shard == 1 ? "" : "s", rmap_map_n_piece(report->map),
                   rmap_map_n_piece(report->map) == 1 ? "" : "s",
                   (double)summary.nbytes / fmax((double)summary.n_row[RMAP_TABLE_SEGMENT], 1.0));
    put_pair(out, "files", text);
    put_encodings(report->map, out);
    fputs("</table></div>\n", out);
    put_runs(report->map, out);
}

static void put_sources(const struct rmap_scene *scene, FILE *out)
{
    static const char *const type[] = {[RMAP_SOURCE_COLLIMATED] = "collimated",
                                       [RMAP_SOURCE_POINT] = "point",
                                       [RMAP_SOURCE_AREA] = "area",
                                       [RMAP_SOURCE_RAYS] = "list of rays",
                                       [RMAP_SOURCE_LAMP] = "lamp",
                                       [RMAP_SOURCE_VOLUME] = "volume",
                                       [RMAP_SOURCE_SKY] = "sky",
                                       [RMAP_SOURCE_SUN] = "sun",
                                       [RMAP_SOURCE_BEAM] = "Gaussian beam",
                                       [RMAP_SOURCE_STEPS] = "steps of particles (photons)"};
    const char *unit = rmap_flux_unit_name(scene);
    fprintf(out,
            "<h3>Sources</h3>\n<div class=\"table\"><table>\n<tr><th>source</th><th>type</th><th "
            "class=\"n\">flux, %s</th><th>in medium</th></tr>\n",
            unit);
    for (size_t s = 0; s < scene->n_source && s < LISTED_MAX; s++) {
        const struct rmap_source *source = &scene->source[s];
        fputs("<tr>", out);
        run_report_name(out, source->name);
        run_report_name(out, type[source->type]);
        run_report_cell(out, source->flux, 9);
        run_report_name(out, scene->medium[source->medium].name);
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
}

static void put_media(const struct rmap_scene *scene, FILE *out)
{
    const int middle = scene->channels.n / 2;
    fputs("<h3>Media</h3>\n<div class=\"table\"><table>\n<tr><th>medium</th><th "
          "class=\"n\">index</th><th>kind</th><th>data</th></tr>\n",
          out);
    for (size_t m = 0; m < scene->n_medium && m < LISTED_MAX; m++) {
        const struct rmap_medium *medium = &scene->medium[m];
        fputs("<tr>", out);
        run_report_name(out, medium->name);
        run_report_cell(out, medium->n[middle], 6);
        fprintf(out, "<td>%s%s%s%s%s</td>", medium->field ? "gradient" : "uniform",
                medium->dispersive ? ", dispersive" : "", medium->absorbing ? ", absorbing" : "",
                medium->scattering_at_all ? ", scattering" : "",
                medium->n_species > 0 ? ", gives light back" : "");
        run_report_name(out, medium->description ? medium->description : "");
        fputs("</tr>\n", out);
    }
    fputs("</table></div>\n", out);
    if (scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        fprintf(out, "<p class=\"dim\">Index at %.6g nm%s.</p>\n",
                scene->channels.wavelength_nm[middle],
                scene->n_gradient > 0 ? "; of gradient media at the origin of their frame" : "");
}

static void put_scene_text(const struct rmap_bundle *bundle, FILE *out)
{
    if (!bundle || !bundle->text || bundle->text_nbytes > SCENE_TEXT_MAX)
        return;
    fputs("<details><summary>The scene file</summary>\n<pre>", out);
    rmap_html_text(out, bundle->text);
    fputs("</pre></details>\n", out);
}

void rmap_run_report_scene(const struct rmap_run_report *report, FILE *out)
{
    const struct rmap_scene *scene = rmap_map_scene(report->map);
    fputs("<p>", out);
    put_number_of(out, scene->n_object, "object", " of ");
    fprintf(out, "%zu geometr%s, in ", scene->n_geometry, scene->n_geometry == 1 ? "y" : "ies");
    put_number_of(out, scene->n_group, "group", "; ");
    put_number_of(out, scene->n_surface, "surface", ", ");
    fprintf(out, "%zu medi%s, ", scene->n_medium, scene->n_medium == 1 ? "um" : "a");
    put_number_of(out, scene->n_source, "source", ", ");
    put_number_of(out, scene->n_detector, "detector", ". Lengths in ");
    rmap_html_text(out, scene->unit);
    if (scene->channels.mode == RMAP_COLOUR_SPECTRAL)
        fprintf(out, ". Light of %d wavelengths, %.6g to %.6g nm.</p>\n", scene->channels.n,
                scene->channels.wavelength_nm[0],
                scene->channels.wavelength_nm[scene->channels.n - 1]);
    else
        fputs(". Light of three colours (RGB).</p>\n", out);
}

void rmap_run_report_parts(const struct rmap_run_report *report, FILE *out)
{
    put_sources(rmap_map_scene(report->map), out);
    put_media(rmap_map_scene(report->map), out);
    put_scene_text(rmap_map_bundle(report->map), out);
}

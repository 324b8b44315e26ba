/* SPDX-License-Identifier: MIT
 *
 * A page about a whole map, to be sent by mail: where it comes from, where its light went, what
 * its detectors saw, the paths that carried most, the scene with rays.
 */
#include "analysis/report/run_report.h"

#include <inttypes.h>
#include <math.h>

#include "analysis/detector/detector_image.h"
#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_draw.h"
#include "analysis/figure/figure_energy.h"
#include "analysis/report/run_report_facts.h"
#include "analysis/table/html.h"
#include "base/grouped.h"
#include "portion/weight.h"

static void begin_section(const char *id, const char *title, FILE *out)
{
    fprintf(out, "<section id=\"%s\">\n<h2>%s</h2>\n", id, title);
}

/* Takes the picture over. */
static enum rmap_status put_figure(struct rmap_svg *svg, int *number, FILE *out,
                                   struct rmap_error *err)
{
    fputs("<figure>\n", out);
    enum rmap_status st = rmap_html_picture(out, svg, ++*number, err);
    fputs("</figure>\n", out);
    rmap_svg_destroy(svg);
    return st;
}

static void put_detector_sums(const struct rmap_detector_image *image, FILE *out)
{
    const bool plane = image->detector->type == RMAP_DETECTOR_PLANE;
    char count[RMAP_GROUPED_LEN];
    fputs("<div class=\"table\"><table>\n<tr><th>registrations</th><th class=\"n\">flux, ", out);
    fprintf(out, "%s</th><th></th><th class=\"n\">mean, %s</th><th></th><th class=\"n\">peak, %s",
            image->flux_unit, image->unit, image->unit);
    fprintf(out, "</th><th></th><th>peak at</th></tr>\n<tr><td>%s</td>",
            rmap_grouped(rmap_weight_whole(image->registrations), count));
    rmap_run_report_measured(out, image->flux, image->flux_error);
    rmap_run_report_measured(out, image->mean, image->mean_error);
    rmap_run_report_measured(
        out, image->peak,
        image->standard_error[image->peak_cell[0] + (size_t)image->peak_cell[1] * image->n[0]]);
    if (isfinite(image->peak_x))
        fprintf(out, "<td>%s %.4g, %s %.4g %s</td>", plane ? "x" : "θ", image->peak_x,
                plane ? "y" : "φ", image->peak_y, plane ? image->scene->unit : "deg");
    else
        fputs("<td></td>", out);
    fputs("</tr>\n</table></div>\n", out);
}

/* Those of the balance, where it knows which registrations are of one ray. */
static void take_errors(const struct rmap_run_report *report, size_t detector,
                        struct rmap_detector_image *image)
{
    const struct rmap_energy_table *table = &report->energy->table[0];
    const struct rmap_energy_row *row = &table->row[table->n_row + detector];
    if (!isfinite(row->flux_error))
        return;
    if (image->flux > 0.0)
        image->mean_error = image->mean / image->flux * row->flux_error;
    image->flux_error = row->flux_error;
}

static enum rmap_status put_detector(const struct rmap_run_report *report, size_t detector,
                                     int *number, FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_detector_sums sums = {0};
    struct rmap_detector_image *image = NULL;
    struct rmap_svg *svg = NULL;
    const struct rmap_figure_detector options = {.criterion = report->energy->criterion};
    const struct rmap_detector_sums *of = report->image ? &report->image[detector] : &sums;
    if (!report->image) {
        RMAP_TRY(rmap_detector_sums_init(&sums, report->map, (int32_t)detector, false, err));
        rmap_detector_sums_add_tally(&sums, rmap_map_tally(report->map));
    }
    RMAP_TRY(rmap_detector_image_create(report->map, of, &image, err));
    image->which = report->which;
    take_errors(report, detector, image);
    fputs("<h3>", out);
    rmap_html_text(out, image->detector->name);
    fprintf(out, "</h3>\n<p class=\"dim\">%s, %" PRIu32 " × %" PRIu32 " cells</p>\n",
            image->detector->type == RMAP_DETECTOR_PLANE ? "Plane" : "Intensity grid", image->n[0],
            image->n[1]);
    put_detector_sums(image, out);
    RMAP_TRY(rmap_figure_detector(image, &options, &svg, err));
    RMAP_TRY(put_figure(svg, number, out, err));
out:
    rmap_detector_image_destroy(image);
    rmap_detector_sums_fini(&sums);
    return st;
}

static enum rmap_status put_detectors(const struct rmap_run_report *report, int *number, FILE *out,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const size_t n = rmap_map_scene(report->map)->n_detector;
    begin_section("detectors", "Detectors", out);
    if (n == 0)
        fputs("<p>The scene has no detector.</p>\n", out);
    for (size_t d = 0; d < n && d < RMAP_REPORT_PICTURES && st == RMAP_OK; d++)
        st = put_detector(report, d, number, out, err);
    if (n > RMAP_REPORT_PICTURES)
        fprintf(out,
                "<p class=\"dim\">The first %d of %zu detectors are pictured; the table of "
                "the light's balance lists all.</p>\n",
                RMAP_REPORT_PICTURES, n);
    fputs("</section>\n", out);
    return st;
}

static enum rmap_status put_scene(const struct rmap_run_report *report, int *number, FILE *out,
                                  struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    const struct rmap_figure_draw options = {.title = report->name,
                                             .criterion = report->energy->criterion,
                                             .n_matched =
                                                 rmap_weight_whole(report->energy->table[0].rays),
                                             .map = report->map};
    begin_section("scene", "Scene", out);
    enum rmap_status st =
        rmap_figure_draw(rmap_map_scene(report->map), report->rays, &options, &svg, err);
    if (st == RMAP_OK)
        st = put_figure(svg, number, out, err);
    rmap_run_report_scene(report, out);
    fputs("</section>\n", out);
    return st;
}

static enum rmap_status put_energy(const struct rmap_run_report *report, int *number, FILE *out,
                                   struct rmap_error *err)
{
    struct rmap_svg *svg = NULL;
    begin_section("energy", "Where the light went", out);
    enum rmap_status st = rmap_figure_energy(report->energy, &svg, err);
    if (st == RMAP_OK)
        st = put_figure(svg, number, out, err);
    rmap_run_report_energy(report, out);
    fputs("</section>\n", out);
    return st;
}

static void put_head(const struct rmap_run_report *report, FILE *out)
{
    fputs("<header>\n<h1>", out);
    rmap_html_text(out, report->name);
    fputs("</h1>\n<p class=\"dim\">", out);
    if (report->energy->criterion) {
        fputs("Of the rays that match <code>", out);
        rmap_html_text(out, report->energy->criterion);
        fputs("</code>", out);
    } else {
        fputs("A ray map: every ray's whole history, and what it tells.", out);
    }
    fputs("</p>\n<nav><a href=\"#scene\">Scene</a><a href=\"#energy\">Where the light went</a>"
          "<a href=\"#detectors\">Detectors</a>",
          out);
    fputs(report->paths ? "<a href=\"#paths\">Paths</a>" : "", out);
    fputs("<a href=\"#parts\">What it is made of</a><a "
          "href=\"#provenance\">Provenance</a></nav>\n</header>\n",
          out);
    rmap_run_report_facts(report, out);
    rmap_run_report_warnings(report, out);
}

enum rmap_status rmap_run_report_write(const struct rmap_run_report *report, FILE *out,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int number = 0; /* of the picture in hand */
    rmap_html_begin(out, report->name);
    put_head(report, out);
    RMAP_TRY(put_scene(report, &number, out, err));
    RMAP_TRY(put_energy(report, &number, out, err));
    RMAP_TRY(put_detectors(report, &number, out, err));
    if (report->paths) {
        begin_section("paths", "Paths that carried most light", out);
        rmap_run_report_paths(report, out);
        fputs("</section>\n", out);
    }
    begin_section("parts", "What it is made of", out);
    rmap_run_report_parts(report, out);
    fputs("</section>\n", out);
    begin_section("provenance", "Provenance", out);
    rmap_run_report_provenance(report, out);
    fputs("</section>\n", out);
    rmap_html_end(out);
out:
    return st;
}

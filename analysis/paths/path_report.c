/* SPDX-License-Identifier: MIT
 *
 * The classes of paths as people want them: ranked, with errors, peaks and texts, and what is
 * left.
 */
#include <inttypes.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/detector/detector_bins.h"
#include "analysis/detector/image_unit.h"
#include "analysis/paths/path_rank.h"
#include "analysis/paths/path_report.h"
#include "analysis/paths/path_text.h"
#include "analysis/table/csv_field.h"
#include "analysis/table/text_table.h"
#include "base/alloc.h"
#include "io/export/json_number.h"
#include "io/map/map_cursor.h"

void rmap_path_flux(const struct rmap_map *map, size_t source, double weight, double weight_squared,
                    double *flux_ret, double *standard_error_ret)
{
    const double n = rmap_map_emitted(map)[source];
    const double unit = rmap_map_flux_per_weight(map)[source];
    *flux_ret = rmap_map_flux(map, source, weight);
    *standard_error_ret =
        n < 2 ? (double)NAN
              : unit * sqrt(fmax(n / (n - 1) * (weight_squared - weight * weight / n), 0.0));
}

/* A row, and its share taken off what is left. */
static void fill_row(struct rmap_path_report *report, const struct rmap_key_sum *sum,
                     struct rmap_path_row *row, struct rmap_count *rest)
{
    const int32_t source = rmap_path_source_of(sum->key);
    *row =
        (struct rmap_path_row){.key = sum->key,
                               .source = source,
                               .rays = sum->number[RMAP_PATH_CLASS_RAYS],
                               .segments = sum->number[RMAP_PATH_CLASS_SEGMENTS],
                               .registrations = sum->number[RMAP_PATH_CLASS_REGISTRATIONS],
                               .first_ray = sum->number[RMAP_PATH_CLASS_FIRST_RAY],
                               .mean_time = report->timed ? rmap_path_class_time(sum) : (double)NAN,
                               .peak.detector = -1};
    rmap_path_flux(report->map, (size_t)source, sum->weight, sum->weight_squared, &row->flux,
                   &row->standard_error);
    row->share = report->total.flux > 0.0 ? row->flux / report->total.flux : 0.0;
    rest->rays -= row->rays;
    rest->segments -= row->segments;
    rest->source_weight[source] -= sum->weight;
    rest->source_weight_squared[source] -= sum->weight_squared;
}

static struct rmap_path_total total_of(const struct rmap_map *map, const struct rmap_count *count)
{
    struct rmap_path_total total = {.rays = count->rays, .segments = count->segments};
    rmap_count_flux(count, map, &total.flux, &total.standard_error);
    return total;
}

enum rmap_status rmap_path_report_create(const struct rmap_path_counts *counts,
                                         enum rmap_path_sort sort, uint64_t top, double bound,
                                         struct rmap_path_report **report_ret,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = counts->context->map;
    const size_t n_source = rmap_map_scene(map)->n_source, n = counts->classes.n;
    struct rmap_path_ranked *ranked = NULL;
    struct rmap_count rest = {0};
    struct rmap_path_report *report = rmap_alloc(1, sizeof *report);
    if (!report)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for paths");
    *report = (struct rmap_path_report){.map = map,
                                        .overlay = counts->context->overlay,
                                        .scene = rmap_scene_with(map, counts->context->overlay),
                                        .keys = counts->context->keys,
                                        .n_class = n,
                                        .exact = bound == 0.0,
                                        .bound = bound,
                                        .timed = counts->context->timed,
                                        .n_row = n < top ? n : (size_t)top};
    report->total = total_of(map, &counts->total);
    report->row = rmap_alloc(report->n_row + 1, sizeof *report->row);
    if (!report->row)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", report->n_row));
    RMAP_TRY(rmap_count_init(&rest, n_source, err));
    rmap_count_add(&rest, &counts->total, n_source);
    rest.rays += counts->again.rays;
    rest.segments += counts->again.segments;
    report->n_path = rest.rays;
    RMAP_TRY(rmap_path_rank(counts, sort, report->n_row, &ranked, err));
    for (size_t k = 0; k < report->n_row; k++)
        fill_row(report, &counts->classes.entry[ranked[k].class], &report->row[k], &rest);
    report->rest = total_of(map, &rest);
    *report_ret = report;
    report = NULL;
out:
    rmap_count_fini(&rest);
    rmap_free(ranked);
    rmap_path_report_destroy(report);
    return st;
}

void rmap_path_report_destroy(struct rmap_path_report *report)
{
    if (!report)
        return;
    for (size_t k = 0; report->row && k < report->n_row; k++) {
        rmap_free(report->row[k].sequence);
        rmap_free(report->row[k].criterion);
    }
    rmap_free(report->row);
    rmap_free(report);
}

/* A cell's sums, and the row that they are of. */
struct placed {
    size_t row;
    struct rmap_path_cell at;
    double weight, weight_squared;
};

static int compare_placed(const void *a_, const void *b_)
{
    const struct placed *a = a_, *b = b_;
    if (a->row != b->row)
        return a->row > b->row ? 1 : -1;
    if (a->at.detector != b->at.detector)
        return a->at.detector > b->at.detector ? 1 : -1;
    return (a->at.cell > b->at.cell) - (a->at.cell < b->at.cell);
}

struct owner {
    uint64_t class_low;
    size_t row;
};

static int compare_owners(const void *a_, const void *b_)
{
    const struct owner *a = a_, *b = b_;
    return (a->class_low > b->class_low) - (a->class_low < b->class_low);
}

/* Cells of the rows: [*n_ret]. */
static enum rmap_status place_cells(const struct rmap_path_report *report,
                                    const struct rmap_key_sums *cells, struct placed **placed_ret,
                                    size_t *n_ret, struct rmap_error *err)
{
    struct owner *owner = rmap_alloc(report->n_row + 1, sizeof *owner);
    struct placed *placed = rmap_alloc(cells->n + 1, sizeof *placed);
    if (!owner || !placed) {
        rmap_free(owner);
        rmap_free(placed);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for peaks of paths");
    }
    *n_ret = 0;
    for (size_t k = 0; k < report->n_row; k++)
        owner[k] = (struct owner){report->row[k].key.low, k};
    qsort(owner, report->n_row, sizeof *owner, compare_owners);
    for (size_t i = 0; i < cells->n; i++) {
        const struct rmap_key_sum *sum = &cells->entry[i];
        const struct rmap_path_cell at = rmap_path_cell_of(sum);
        const struct owner wanted = {.class_low = at.class_low};
        const struct owner *found =
            bsearch(&wanted, owner, report->n_row, sizeof *owner, compare_owners);
        if (found)
            placed[(*n_ret)++] = (struct placed){found->row, at, sum->weight, sum->weight_squared};
    }
    qsort(placed, *n_ret, sizeof *placed, compare_placed);
    rmap_free(owner);
    *placed_ret = placed;
    return RMAP_OK;
}

/* The brightest of cells [first, last), all of one row and one detector. */
static struct rmap_path_peak peak_of(const struct rmap_path_report *report,
                                     const struct placed *first, const struct placed *last)
{
    struct rmap_detector_bins bins;
    const size_t source = (size_t)report->row[first->row].source;
    struct rmap_path_peak peak = {.detector = first->at.detector, .value = -1.0};
    rmap_detector_bins_own(report->scene, first->at.detector, &bins);
    for (const struct placed *cell = first; cell < last; cell++) {
        const uint32_t i = cell->at.cell % bins.n[0], j = cell->at.cell / bins.n[0];
        const double extent = rmap_detector_bins_extent(&bins, cell->at.cell);
        double flux, error;
        rmap_path_flux(report->map, source, cell->weight, cell->weight_squared, &flux, &error);
        if (flux / extent <= peak.value)
            continue;
        peak.value = flux / extent;
        peak.standard_error = error / extent;
        rmap_detector_bins_centre(&bins, i, j, &peak.x, &peak.y);
    }
    return peak;
}

enum rmap_status rmap_path_report_add_peaks(struct rmap_path_report *report,
                                            const struct rmap_key_sums *cells,
                                            struct rmap_error *err)
{
    struct placed *placed = NULL;
    size_t n = 0, row = SIZE_MAX;
    double most = 0.0;
    enum rmap_status st = place_cells(report, cells, &placed, &n, err);
    for (size_t i = 0; st == RMAP_OK && i < n;) {
        const size_t first = i;
        double weight = 0.0;
        for (; i < n && placed[i].row == placed[first].row &&
               placed[i].at.detector == placed[first].at.detector;
             i++)
            weight += placed[i].weight;
        if (placed[first].row != row || weight > most) {
            row = placed[first].row;
            most = weight;
            report->row[row].peak = peak_of(report, placed + first, placed + i);
        }
    }
    rmap_free(placed);
    return st;
}

/* The texts of classes, each from its first ray. */

/* One thread's way through the map, ray after ray. */
struct reading {
    const struct rmap_path_report *report;
    struct rmap_cursor *cursor;
    struct rmap_overlay_view *view; /* NULL: no receivers */
    const struct rmap_portion *portion;
    size_t in_hand; /* SIZE_MAX: none */
    rmap_path_step *symbol;
    size_t symbol_cap;
};

/* Row of the ray in the portion in hand. */
static bool find_row(const struct rmap_portion *portion, uint64_t ray,
                     struct rmap_path_place_of_ray *place)
{
    *place = (struct rmap_path_place_of_ray){0};
    for (; place->ray < portion->n_row[RMAP_TABLE_RAY]; place->ray++) {
        if (portion->ray.id[place->ray] == ray)
            return true;
        place->segment += portion->ray.segment_count[place->ray];
        place->registration += portion->ray.registration_count[place->ray];
    }
    return false;
}

static enum rmap_status read_portion(struct reading *reading, size_t index, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *stored = NULL;
    const size_t space = (size_t)rmap_map_portion(reading->report->map, index)->space;
    RMAP_TRY(rmap_cursor_read(reading->cursor, index, &stored, err));
    reading->portion = stored;
    if (reading->view)
        RMAP_TRY(rmap_overlay_view_extend(reading->view, stored, space, &reading->portion, err));
    reading->in_hand = index;
out:
    return st;
}

static enum rmap_status find_ray(struct reading *reading, uint64_t ray,
                                 struct rmap_path_place_of_ray *place, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = reading->report->map;
    size_t index = rmap_map_n_portion(map);
    while (rmap_map_find_ray(map, ray, &index)) {
        if (index != reading->in_hand)
            RMAP_TRY(read_portion(reading, index, err));
        if (find_row(reading->portion, ray, place))
            goto out;
    }
    st = rmap_error_set(err, RMAP_INTERNAL, "ray %" PRIu64 " is not where it was", ray);
out:
    return st;
}

/* The criterion with the one that the rays were picked by. */
static enum rmap_status narrow(const char *where, char **criterion, struct rmap_error *err)
{
    if (!where || !*criterion)
        return RMAP_OK;
    const size_t nbytes = strlen(where) + strlen(*criterion) + sizeof "() and ";
    char *text = rmap_alloc(nbytes, 1);
    if (!text)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a criterion");
    (void)snprintf(text, nbytes, "(%s) and %s", where, *criterion);
    rmap_free(*criterion);
    *criterion = text;
    return RMAP_OK;
}

static enum rmap_status write_texts(const struct rmap_path_report *report,
                                    struct rmap_path_row *row, const rmap_path_step *step, size_t n,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(rmap_path_key_text(report->keys, step, n, 0, &row->sequence, err));
    RMAP_TRY(rmap_path_criterion_of(report->keys, row->source, step, n,
                                    row->rays == 1 ? row->first_ray : RMAP_PATH_MANY_RAYS,
                                    &row->criterion, err));
    st = narrow(report->criterion, &row->criterion, err);
out:
    return st;
}

/* Where the map is read; made when first needed. */
static enum rmap_status open_map(struct reading *reading, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_report *report = reading->report;
    rmap_column_set columns = rmap_path_keys_columns(report->keys);
    if (reading->cursor)
        return RMAP_OK;
    if (report->overlay) {
        columns = rmap_overlay_columns(report->overlay, columns);
        RMAP_TRY(rmap_overlay_view_create(report->overlay, &reading->view, err));
    }
    st = rmap_cursor_create(report->map, columns, &reading->cursor, err);
out:
    return st;
}

/* Which of the ray's paths is that of the class. */
static void find_path(const struct reading *reading, const struct rmap_path_row *row,
                      struct rmap_path_place_of_ray *place, size_t *n)
{
    const struct rmap_path_keys *keys = reading->report->keys;
    const struct rmap_portion *portion = reading->portion;
    const size_t end = place->registration + portion->ray.registration_count[place->ray];
    const struct rmap_path_view *view = &reading->report->view;
    if (!view->until_detector) {
        (void)rmap_path_key_of(keys, portion, place, reading->symbol, n);
        return;
    }
    for (size_t i = place->registration; i < end; i++) {
        place->until = i + 1;
        if (!portion->registration.registered[i] ||
            portion->registration.detector[i] != view->detector ||
            !rmap_path_key_of(keys, portion, place, reading->symbol, n))
            continue;
        if (rmap_keys_equal(rmap_path_key_hash(reading->symbol, *n, row->source), row->key))
            return;
    }
}

static enum rmap_status read_texts(struct reading *reading, struct rmap_path_row *row,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_path_place_of_ray place;
    size_t n = 0;
    RMAP_TRY(open_map(reading, err));
    RMAP_TRY(find_ray(reading, row->first_ray, &place, err));
    RMAP_TRY(RMAP_RESERVE(reading->symbol, reading->symbol_cap,
                          (size_t)reading->portion->ray.segment_count[place.ray] +
                              reading->portion->ray.registration_count[place.ray] + 1,
                          err));
    find_path(reading, row, &place, &n);
    st = write_texts(reading->report, row, reading->symbol, n, err);
out:
    return st;
}

static int compare_rows(const void *a_, const void *b_)
{
    const struct rmap_path_row *const *a = a_, *const *b = b_;
    return ((*a)->first_ray > (*b)->first_ray) - ((*a)->first_ray < (*b)->first_ray);
}

enum rmap_status rmap_path_report_add_texts(struct rmap_path_report *report, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct reading reading = {.report = report, .in_hand = SIZE_MAX};
    struct rmap_path_row **row = rmap_alloc(report->n_row + 1, sizeof *row);
    if (!row)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", report->n_row);
    for (size_t k = 0; k < report->n_row; k++)
        row[k] = &report->row[k];
    qsort(row, report->n_row, sizeof(struct rmap_path_row *), compare_rows);
    for (size_t k = 0; k < report->n_row; k++)
        RMAP_TRY(read_texts(&reading, row[k], err));
out:
    rmap_overlay_view_destroy(reading.view);
    rmap_cursor_destroy(reading.cursor);
    rmap_free(reading.symbol);
    rmap_free(row);
    return st;
}

/* Classes of paths as text: a table for people, JSON, CSV. */

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
    if (row->peak.detector >= 0)
        rmap_text_table_add(table, "%.3g +- %.1g %s", row->peak.value, row->peak.standard_error,
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

/* SPDX-License-Identifier: MIT
 *
 * The classes of paths as people want them: ranked, with errors and peaks, and what is left.
 */
#include <math.h>
#include <stdlib.h>

#include "analysis/detector/detector_bins.h"
#include "analysis/paths/path_rank.h"
#include "analysis/paths/path_report.h"
#include "base/alloc.h"

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

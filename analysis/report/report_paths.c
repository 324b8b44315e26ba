/* SPDX-License-Identifier: MIT
 *
 * The paths that carried most light, as a page lists them: counted over a whole map, or estimated
 * from some of its rays.
 */
#include "analysis/report/report_paths.h"

#include <math.h>
#include <string.h>

#include "analysis/paths/path_class.h"
#include "analysis/paths/path_text.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "trace/tally.h"

enum { TEXT_MAX = 600, CRITERION_MAX = 1500 /* bytes that a page shows of one */ };

static enum rmap_status create(size_t n, struct rmap_report_paths **paths_ret,
                               struct rmap_error *err)
{
    struct rmap_report_paths *paths = rmap_alloc(1, sizeof *paths);
    if (paths)
        paths->path = rmap_alloc(n + 1, sizeof *paths->path);
    if (!paths || !paths->path) {
        rmap_report_paths_destroy(paths);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n);
    }
    *paths_ret = paths;
    return RMAP_OK;
}

void rmap_report_paths_destroy(struct rmap_report_paths *paths)
{
    if (!paths)
        return;
    for (size_t i = 0; paths->path && i < paths->n; i++) {
        rmap_free(paths->path[i].text);
        rmap_free(paths->path[i].criterion);
    }
    rmap_free(paths->path);
    rmap_free(paths);
}

/* A criterion that is too long for a page is left out: `raymap paths` has it. */
static void drop_long(struct rmap_report_path *path)
{
    if (!path->criterion || strlen(path->criterion) <= CRITERION_MAX)
        return;
    rmap_free(path->criterion);
    path->criterion = NULL;
}

enum rmap_status rmap_report_paths_of(const struct rmap_path_report *report,
                                      struct rmap_report_paths **paths_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_report_paths *paths = NULL;
    RMAP_TRY(create(report->n_row, &paths, err));
    for (size_t i = 0; i < report->n_row; i++) {
        const struct rmap_path_row *row = &report->row[i];
        struct rmap_report_path *path = &paths->path[paths->n++];
        *path = (struct rmap_report_path){.rays = (double)row->rays,
                                          .flux = row->flux,
                                          .flux_error = row->standard_error,
                                          .share = row->share,
                                          .first_ray = row->first_ray};
        RMAP_TRY(rmap_path_with_source(report->keys, row->source, row->sequence, &path->text, err));
        if (row->criterion && !(path->criterion = rmap_strdup(row->criterion)))
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the criteria of paths"));
        drop_long(path);
    }
    paths->n_class = report->n_class;
    paths->rest_flux = report->rest.flux;
    paths->rest_share = report->rest.flux / report->total.flux;
    if (!report->exact)
        (void)snprintf(paths->note, sizeof paths->note,
                       "There are too many paths to count all: every path with more than %.3g %% "
                       "of the flux is here, and what is listed is exact.",
                       100.0 * report->bound);
    *paths_ret = paths;
    paths = NULL;
out:
    rmap_report_paths_destroy(paths);
    return st;
}

/* Rays of each source among those given; flux of one of them. */
struct sample {
    double *rays, *flux_per_ray; /* [n_source] */
    double flux;                 /* of all sources that have rays here */
};

static enum rmap_status take_sample(const struct rmap_map *map, const struct rmap_portion *rays,
                                    struct sample *sample, struct rmap_error *err)
{
    const size_t n_source = rmap_map_scene(map)->n_source;
    sample->rays = rmap_alloc(n_source + 1, sizeof *sample->rays);
    sample->flux_per_ray = rmap_alloc(n_source + 1, sizeof *sample->flux_per_ray);
    if (!sample->rays || !sample->flux_per_ray)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sources", n_source);
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY]; i++)
        sample->rays[rays->ray.source[i]] += 1.0;
    for (size_t s = 0; s < n_source; s++) {
        const double flux = rmap_map_flux_per_weight(map)[s] * rmap_map_tally(map)->emitted[s];
        if (!(sample->rays[s] > 0.0))
            continue;
        sample->flux_per_ray[s] = flux / sample->rays[s];
        sample->flux += flux;
    }
    return RMAP_OK;
}

static enum rmap_status list_classes(const struct rmap_path_classes *classes,
                                     const struct sample *sample, size_t top,
                                     struct rmap_report_paths *paths, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    paths->n_class = classes->n;
    for (size_t i = 0; i < classes->n; i++) {
        const struct rmap_path_class *from = &classes->path[i];
        const double n = sample->rays[from->source], k = (double)from->rays;
        if (i >= top) {
            paths->rest_flux += from->flux;
            paths->rest_share += from->flux / sample->flux;
            continue;
        }
        struct rmap_report_path *path = &paths->path[paths->n++];
        *path = (struct rmap_report_path){
            .rays = k,
            .flux = from->flux,
            .flux_error = n < 2.0 ? (double)NAN
                                  : sample->flux_per_ray[from->source] *
                                        sqrt(n / (n - 1.0) * fmax(k - k * k / n, 0.0)),
            .share = from->flux / sample->flux,
            .first_ray = from->first_ray};
        RMAP_TRY(rmap_path_class_label(classes, i, TEXT_MAX, &path->text, err));
        RMAP_TRY(rmap_path_class_criterion(classes, i, &path->criterion, err));
        drop_long(path);
    }
out:
    return st;
}

enum rmap_status rmap_report_paths_sampled(const struct rmap_map *map,
                                           const struct rmap_portion *rays, size_t top,
                                           struct rmap_report_paths **paths_ret,
                                           struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_view view = {.level = RMAP_PATH_SURFACE};
    struct rmap_report_paths *paths = NULL;
    struct rmap_path_classes *classes = NULL;
    struct sample sample = {0};
    char count[RMAP_GROUPED_LEN];
    RMAP_TRY(create(top, &paths, err));
    RMAP_TRY(take_sample(map, rays, &sample, err));
    RMAP_TRY(rmap_path_classes_create(rmap_map_scene(map), &view, rays, sample.flux_per_ray,
                                      &classes, err));
    RMAP_TRY(list_classes(classes, &sample, top, paths, err));
    (void)snprintf(paths->note, sizeof paths->note,
                   "Not the whole map was read: these are estimates from its first %s rays, as if "
                   "they carried all of the flux (of all rays: raymap paths MAP).",
                   rmap_grouped(rays->n_row[RMAP_TABLE_RAY], count));
    *paths_ret = paths;
    paths = NULL;
out:
    rmap_path_classes_destroy(classes);
    rmap_free(sample.flux_per_ray);
    rmap_free(sample.rays);
    rmap_report_paths_destroy(paths);
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query: listed, or written to a file.
 */
#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "analysis/query/query_plan.h"
#include "analysis/report/ray_report.h"
#include "analysis/report/ray_report_print.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_memory.h"
#include "io/export/polydata.h"
#include "io/file/whole_file.h"
#include "io/map/history_file.h"
#include "io/map/map_held.h"
#include "io/map/map_json.h"
#include "mpi/answer/query_rays_out.h"
#include "mpi/answer/ray_file_out.h"
#include "mpi/command/balance.h"
#include "mpi/command/json_out.h"
#include "mpi/command/output.h"
#include "mpi/scan/ray_lines.h"

/* How one ray is written: first/between/last frame the list. write NULL: as polylines, or tables.
 */
struct format {
    const char *suffix; /* of the file's name */
    const char *first, *between, *last;
    enum rmap_status (*write)(const struct rmap_ray_report *report, FILE *out,
                              struct rmap_error *err);
};

static enum rmap_status write_json(const struct rmap_ray_report *report, FILE *out,
                                   struct rmap_error *err)
{
    json_t *ray = rmap_json_versioned(rmap_ray_report_json(report));
    int failed = ray ? json_dumpf(ray, out, JSON_COMPACT | JSON_REAL_PRECISION(17)) : 0;
    json_decref(ray);
    if (!ray || rmap_json_memory_failed())
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the JSON of a ray");
    if (failed && !ferror(out)) /* what happened to the file is reported by its name */
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write the JSON of a ray");
    return RMAP_OK;
}

static const struct format json_format = {".json", "[\n", ",\n", "\n]\n", write_json};
static const struct format csv_format = {".csv", "", "", "", rmap_ray_csv_write};
static const struct format polydata_format = {".vtp", "", "", "", NULL};
static const struct format table_format = {".h5", "", "", "", NULL};
static const struct format ray_file_format = {".tm25ray", "", "", "", NULL};
static const struct format text_format = {"", "", "", "", rmap_ray_path_write};

static const struct format *format_of(const char *path)
{
    const struct format *const known[] = {&json_format, &csv_format, &polydata_format,
                                          &table_format};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (rmap_output_is(path, known[i]->suffix))
            return known[i];
    return rmap_ray_file_named(path) ? &ray_file_format : NULL;
}

bool rmap_query_rays_named(const char *path)
{
    return format_of(path) != NULL;
}

bool rmap_query_rays_are_files(const char *path)
{
    return format_of(path) == &ray_file_format;
}

bool rmap_query_rays_are_tables(const char *path)
{
    return format_of(path) == &table_format;
}

enum rmap_status rmap_query_rays_check(const char *path, bool force, struct rmap_error *err)
{
    if (!format_of(path))
        return rmap_error_set(
            err, RMAP_USAGE,
            "cannot write '%s': -o takes a name that ends in .csv (a row per "
            "segment), .json (an array of rays), .h5 (tables of plain columns), "
            ".vtp (polylines for ParaView), .tm25ray or .mcpl (a source for other "
            "scenes and programs) or .raymap (a ray map)",
            path);
    return rmap_output_free(path, force, err);
}

struct rmap_rays_out {
    const struct rmap_context *context;
    const struct rmap_map *map;
    const char *path; /* NULL: stdout */
    struct rmap_whole_file whole;
    const struct format *format;
    FILE *file;                     /* the whole one's, or stdout */
    struct rmap_polydata *polydata; /* NULL: of no .vtp */
    struct rmap_table_out *table;   /* NULL: of no .h5 */
    struct rmap_ray_file_out *rays; /* NULL: of no .tm25ray or .mcpl */
    uint64_t n_ray, n_segment;
};

static enum rmap_status begin_text(struct rmap_rays_out *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    if (self->path)
        RMAP_TRY(rmap_whole_file_open(&self->whole, self->path, err));
    self->file = self->path ? self->whole.file : stdout;
    if (self->format == &polydata_format)
        RMAP_TRY(rmap_polydata_begin(
            self->file, scene,
            &(struct rmap_polydata_terms){.flux_unit = rmap_flux_unit_name(scene)}, &self->polydata,
            err));
    fputs(self->format == &csv_format ? rmap_ray_csv_header(scene) : self->format->first,
          self->file);
out:
    return st;
}

enum rmap_status rmap_rays_out_begin(const struct rmap_context *context, const struct rmap_map *map,
                                     const struct rmap_table_request *request,
                                     struct rmap_rays_out **out_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_rays_out *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the answer");
    self->context = context;
    self->map = map;
    self->path = request->path;
    self->format = self->path ? format_of(self->path) : context->json ? &json_format : &text_format;
    if (self->format == &table_format)
        RMAP_TRY(rmap_table_out_begin(map, request, &self->table, err));
    else if (self->format == &ray_file_format)
        RMAP_TRY(rmap_ray_file_out_begin(map, request, &self->rays, err));
    else
        RMAP_TRY(begin_text(self, err));
    *out_ret = self;
    self = NULL;
out:
    rmap_rays_out_destroy(self);
    return st;
}

static enum rmap_status cannot_write(const struct rmap_rays_out *self, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s",
                          self->path ? self->path : "stdout", strerror(errno));
}

static enum rmap_status write_report(struct rmap_rays_out *self,
                                     const struct rmap_streamed_ray *ray, struct rmap_error *err)
{
    struct rmap_ray_report *report = NULL;
    enum rmap_status st = rmap_ray_report_row(self->map, ray->space, ray->portion, ray->row,
                                              ray->segment, ray->registration, &report, err);
    if (st == RMAP_OK && self->n_ray > 0)
        fputs(self->format->between, self->file);
    if (st == RMAP_OK)
        st = self->format->write(report, self->file, err);
    rmap_ray_report_destroy(report);
    return st;
}

static enum rmap_status write_polyline(struct rmap_rays_out *self,
                                       const struct rmap_streamed_ray *ray, struct rmap_error *err)
{
    const struct rmap_ray_columns *from = &ray->portion->ray;
    const struct rmap_polydata_ray given = {
        .flux =
            from->weight[ray->row] * rmap_map_flux_per_weight(self->map)[from->source[ray->row]],
        .group = -1};
    return rmap_polydata_add(self->polydata, ray->portion, ray->row, ray->segment, &given, err);
}

enum rmap_status rmap_rays_out_take(void *out, const struct rmap_streamed_ray *ray,
                                    struct rmap_error *err)
{
    struct rmap_rays_out *self = out;
    enum rmap_status st = self->table      ? rmap_table_out_take(self->table, ray, err)
                          : self->rays     ? rmap_ray_file_out_take(self->rays, ray, err)
                          : self->polydata ? write_polyline(self, ray, err)
                                           : write_report(self, ray, err);
    if (st == RMAP_OK && self->file && ferror(self->file))
        st = cannot_write(self, err);
    self->n_ray++;
    self->n_segment += ray->portion->ray.segment_count[ray->row];
    return st;
}

enum rmap_status rmap_rays_out_finish(struct rmap_rays_out *self, struct rmap_error *err)
{
    if (self->polydata)
        rmap_polydata_finish(self->polydata);
    if (self->file)
        fputs(self->format->last, self->file);
    if (!self->path)
        return fflush(self->file) == 0 ? RMAP_OK : cannot_write(self, err);
    if (self->rays)
        self->n_ray = rmap_ray_file_out_count(self->rays);
    enum rmap_status st = self->table  ? rmap_table_out_finish(self->table, err)
                          : self->rays ? rmap_ray_file_out_finish(self->rays, err)
                                       : rmap_whole_file_finish(&self->whole, err);
    if (st != RMAP_OK)
        return st;
    if (self->context->json)
        return rmap_json_print(rmap_json_of_map(json_pack("{s:s, s:I}", "output", self->path,
                                                          "rays", (json_int_t)self->n_ray),
                                                self->map),
                               stdout, err);
    if (!self->context->quiet)
        fprintf(stderr, "%s: %s%s%s\n", self->path, rmap_counted(self->n_ray, "ray").text,
                self->rays ? "" : ", ",
                self->rays ? "" : rmap_counted(self->n_segment, "segment").text);
    return RMAP_OK;
}

void rmap_rays_out_destroy(struct rmap_rays_out *self)
{
    if (!self)
        return;
    rmap_whole_file_fini(&self->whole);
    rmap_polydata_destroy(self->polydata);
    rmap_table_out_destroy(self->table);
    rmap_ray_file_out_destroy(self->rays);
    rmap_free(self);
}

/* What a query would read: portions, columns and bytes. */

static json_t *explain_json(const struct rmap_map *map, const struct rmap_criterion *criterion,
                            const struct rmap_query_plan *plan,
                            const struct rmap_history_files *indexes)
{
    size_t n_portion = rmap_map_n_portion(map);
    const json_int_t n_read = (json_int_t)(n_portion - plan->n_skipped);
    const json_int_t none = 0; /* of what history indexes told */
    json_t *names = json_array();
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (plan->columns & RMAP_COLUMN_BIT(c))
            (void)json_array_append_new(names,
                                        json_string(rmap_column_info((enum rmap_column)c)->path));
    return json_pack(
        "{s:s, s:o, s:{s:I, s:I, s:I}, s:{s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:I, s:s}, "
        "s:{s:I, s:I, s:I, s:I, s:I}, s:I}",
        "criterion", rmap_criterion_text(criterion), "columns", names, "portions", "total",
        (json_int_t)n_portion, "read", n_read, "skipped", (json_int_t)plan->n_skipped, "index",
        "by_paths", none, "by_rows", none, "without", n_read, "rays", none, "undecided_rays", none,
        "undecided_portions", none, "bytes", none, "unused_pieces", (json_int_t)indexes->n, "why",
        indexes->n > 0 ? "history indexes are no longer used" : "", "compact", "portions",
        (json_int_t)plan->n_compact, "traced_again", (json_int_t)plan->n_retraced, "rays",
        (json_int_t)plan->n_told_ray, "undecided_rays", (json_int_t)plan->n_left_ray,
        "undecided_beside_paths", (json_int_t)plan->n_traced_ray, "bytes_decoded",
        (json_int_t)plan->decoded_nbytes);
}

static void print_text(const struct rmap_map *map, const struct rmap_criterion *criterion,
                       const struct rmap_query_plan *plan)
{
    size_t n_portion = rmap_map_n_portion(map);
    printf("%s\n  portions %llu of %zu to read, %llu skipped\n", rmap_criterion_text(criterion),
           (unsigned long long)(n_portion - plan->n_skipped), n_portion,
           (unsigned long long)plan->n_skipped);
    if (plan->n_told_ray > 0)
        printf("  paths    of %s leave %s undecided (%.3g %%)\n",
               rmap_counted(plan->n_told_ray, "ray").text,
               rmap_counted(plan->n_left_ray, "ray").text,
               100.0 * (double)plan->n_left_ray / (double)plan->n_told_ray);
    if (plan->n_left_ray > plan->n_traced_ray)
        printf("  places   of these leave %s undecided (%.3g %%)\n",
               rmap_counted(plan->n_traced_ray, "ray").text,
               100.0 * (double)plan->n_traced_ray / (double)plan->n_told_ray);
    if (plan->n_compact > 0)
        printf("  compact  %s, rays traced again in %s\n",
               rmap_counted(plan->n_compact, "portion").text,
               plan->n_retraced > 0 ? rmap_counted(plan->n_retraced, "portion").text : "none");
    printf("  columns ");
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (plan->columns & RMAP_COLUMN_BIT(c))
            printf(" %s", rmap_column_info((enum rmap_column)c)->path);
    printf("%s\n  bytes    %.1f MB when decoded\n", plan->columns ? "" : " none",
           1e-6 * (double)plan->decoded_nbytes);
}

enum rmap_status rmap_query_explain(const struct rmap_context *context, const struct rmap_map *map,
                                    struct rmap_criterion *const *criterion, size_t n_criterion,
                                    rmap_column_set wanted, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_files indexes;
    json_t *list = json_array();
    if (rmap_map_is_held(map))
        indexes = (struct rmap_history_files){0};
    else
        RMAP_TRY(rmap_history_files_measure(map, &indexes, err));
    for (size_t c = 0; c < n_criterion; c++) {
        struct rmap_query_plan plan;
        RMAP_TRY(rmap_query_plan(map, criterion[c], wanted, &plan, err));
        if (context->json)
            (void)json_array_append_new(
                list, rmap_json_of_map(explain_json(map, criterion[c], &plan, &indexes), map));
        else
            print_text(map, criterion[c], &plan);
    }
    if (context->json) {
        st = rmap_json_print(list, stdout, err);
        list = NULL;
    }
out:
    json_decref(list);
    return st;
}

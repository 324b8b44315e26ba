/* SPDX-License-Identifier: MIT */
#include "mpi/answer/query_rays_out.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>

#include "analysis/report/ray_report.h"
#include "base/alloc.h"
#include "base/grouped.h"
#include "io/export/json_memory.h"
#include "io/export/polydata.h"
#include "io/file/whole_file.h"
#include "io/map/map_json.h"
#include "mpi/command/balance.h"
#include "mpi/command/json_out.h"
#include "mpi/command/output.h"
#include "mpi/scan/ray_lines.h"

/* How one ray is written: first/between/last frame the list. write NULL: as polylines. */
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
    if (failed && !ferror(out)) /* what happened to the file is told by its name */
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write the JSON of a ray");
    return RMAP_OK;
}

static const struct format json_format = {".json", "[\n", ",\n", "\n]\n", write_json};
static const struct format csv_format = {".csv", RMAP_RAY_CSV_HEADER "\n", "", "",
                                         rmap_ray_csv_write};
static const struct format curved_csv_format = {".csv", RMAP_RAY_CSV_HEADER_CURVED "\n", "", "",
                                                rmap_ray_csv_write};
static const struct format polydata_format = {".vtp", "", "", "", NULL};
static const struct format text_format = {"", "", "", "", rmap_ray_path_write};

static const struct format *format_of(const char *path)
{
    const struct format *const known[] = {&json_format, &csv_format, &polydata_format};
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++)
        if (rmap_output_is(path, known[i]->suffix))
            return known[i];
    return NULL;
}

bool rmap_query_rays_named(const char *path)
{
    return format_of(path) != NULL;
}

enum rmap_status rmap_query_rays_check(const char *path, bool force, struct rmap_error *err)
{
    if (!format_of(path))
        return rmap_error_set(err, RMAP_USAGE,
                              "cannot write '%s': -o takes a name that ends in .csv (a row per "
                              "segment), .json (an array of rays), .vtp (polylines for ParaView) "
                              "or .raymap (a ray map)",
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
    uint64_t n_ray, n_segment;
};

enum rmap_status rmap_rays_out_begin(const struct rmap_context *context, const struct rmap_map *map,
                                     const char *path, struct rmap_rays_out **out_ret,
                                     struct rmap_error *err)
{
    struct rmap_rays_out *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the answer");
    self->context = context;
    self->map = map;
    self->path = path;
    self->format = path ? format_of(path) : context->json ? &json_format : &text_format;
    if (self->format == &csv_format && rmap_scene_is_curved(rmap_map_scene(map)))
        self->format = &curved_csv_format;
    enum rmap_status st = path ? rmap_whole_file_open(&self->whole, path, err) : RMAP_OK;
    RMAP_TRY(st);
    self->file = path ? self->whole.file : stdout;
    if (self->format == &polydata_format)
        RMAP_TRY(rmap_polydata_begin(
            self->file, rmap_map_scene(map),
            &(struct rmap_polydata_terms){.flux_unit = rmap_flux_unit_text(rmap_map_scene(map))},
            &self->polydata, err));
    fputs(self->format->first, self->file);
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
    enum rmap_status st =
        self->polydata ? write_polyline(self, ray, err) : write_report(self, ray, err);
    if (st == RMAP_OK && ferror(self->file))
        st = cannot_write(self, err);
    self->n_ray++;
    self->n_segment += ray->portion->ray.segment_count[ray->row];
    return st;
}

enum rmap_status rmap_rays_out_finish(struct rmap_rays_out *self, struct rmap_error *err)
{
    if (self->polydata)
        rmap_polydata_finish(self->polydata);
    fputs(self->format->last, self->file);
    if (!self->path)
        return fflush(self->file) == 0 ? RMAP_OK : cannot_write(self, err);
    enum rmap_status st = rmap_whole_file_finish(&self->whole, err);
    if (st != RMAP_OK)
        return st;
    if (self->context->json)
        return rmap_json_print(rmap_json_of_map(json_pack("{s:s, s:I}", "output", self->path,
                                                          "rays", (json_int_t)self->n_ray),
                                                self->map),
                               stdout, err);
    if (!self->context->quiet)
        fprintf(stderr, "%s: %s, %s\n", self->path, rmap_counted(self->n_ray, "ray").text,
                rmap_counted(self->n_segment, "segment").text);
    return RMAP_OK;
}

void rmap_rays_out_destroy(struct rmap_rays_out *self)
{
    if (!self)
        return;
    rmap_whole_file_fini(&self->whole);
    rmap_polydata_destroy(self->polydata);
    rmap_free(self);
}

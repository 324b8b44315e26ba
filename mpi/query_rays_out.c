/* SPDX-License-Identifier: MIT */
#include "mpi/query_rays_out.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#include "analysis/ray_report.h"
#include "mpi/json_out.h"
#include "mpi/ray_lines.h"

/* How one ray is written: first/between/last frame the list. */
struct format {
    const char *suffix; /* of the file's name */
    const char *first, *between, *last;
    enum rmap_status (*write)(const struct rmap_ray_report *report, FILE *out,
                              struct rmap_error *err);
};

static enum rmap_status write_json(const struct rmap_ray_report *report, FILE *out,
                                   struct rmap_error *err)
{
    json_t *ray = rmap_ray_report_json(report);
    if (!ray)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the JSON of a ray");
    int failed = json_dumpf(ray, out, JSON_COMPACT | JSON_REAL_PRECISION(17));
    json_decref(ray);
    return failed ? rmap_error_set(err, RMAP_SYSTEM, "cannot write the JSON of a ray") : RMAP_OK;
}

static const struct format json_format = {".json", "[\n", ",\n", "\n]\n", write_json};
static const struct format csv_format = {".csv", RMAP_RAY_CSV_HEADER "\n", "", "",
                                         rmap_ray_csv_write};
static const struct format text_format = {"", "", "", "", rmap_ray_path_write};

static const struct format *format_of(const char *path)
{
    const struct format *const known[] = {&json_format, &csv_format};
    size_t len = strlen(path);
    for (size_t i = 0; i < sizeof known / sizeof known[0]; i++) {
        size_t suffix_len = strlen(known[i]->suffix);
        if (len > suffix_len && strcmp(path + len - suffix_len, known[i]->suffix) == 0)
            return known[i];
    }
    return NULL;
}

enum rmap_status rmap_query_rays_check(const char *path, bool force, struct rmap_error *err)
{
    struct stat status;
    if (!format_of(path))
        return rmap_error_set(err, RMAP_USAGE,
                              "cannot write '%s': -o takes a name that ends in .csv (a row per "
                              "segment) or .json (an array of rays)",
                              path);
    if (!force && stat(path, &status) == 0)
        return rmap_error_set(err, RMAP_USAGE,
                              "'%s' exists; give another name, or --force to replace it", path);
    return RMAP_OK;
}

static enum rmap_status write_rays(const struct rmap_map *map, const struct rmap_portion *rays,
                                   const struct format *format, FILE *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t segment = 0, registration = 0;
    fputs(format->first, out);
    for (size_t i = 0; i < rays->n_row[RMAP_TABLE_RAY] && st == RMAP_OK; i++) {
        struct rmap_ray_report *report = NULL;
        st = rmap_ray_report_row(map, rays, i, segment, registration, &report, err);
        if (st != RMAP_OK)
            break;
        if (i > 0)
            fputs(format->between, out);
        st = format->write(report, out, err);
        rmap_ray_report_destroy(report);
        segment += rays->ray.segment_count[i];
        registration += rays->ray.registration_count[i];
    }
    fputs(format->last, out);
    return st;
}

enum rmap_status rmap_query_rays_print(const struct rmap_context *context,
                                       const struct rmap_map *map, const struct rmap_portion *rays,
                                       const char *path, struct rmap_error *err)
{
    if (!path)
        return write_rays(map, rays, context->json ? &json_format : &text_format, stdout, err);
    FILE *out = fopen(path, "w");
    if (!out)
        return rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", path, strerror(errno));
    enum rmap_status st = write_rays(map, rays, format_of(path), out, err);
    bool failed = ferror(out) != 0;
    if ((fclose(out) != 0 || failed) && st == RMAP_OK)
        st = rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s", path, strerror(errno));
    if (st != RMAP_OK) {
        (void)remove(path); /* half an answer is none */
        return st;
    }
    if (context->json)
        return rmap_json_print(json_pack("{s:s, s:I}", "output", path, "rays",
                                         (json_int_t)rays->n_row[RMAP_TABLE_RAY]),
                               stdout, err);
    if (!context->quiet)
        fprintf(stderr, "%s: %zu rays, %zu segments\n", path, rays->n_row[RMAP_TABLE_RAY],
                rays->n_row[RMAP_TABLE_SEGMENT]);
    return RMAP_OK;
}

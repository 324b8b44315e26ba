/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query as tables of plain columns in an HDF5 file.
 */
#include "mpi/answer/ray_table_out.h"

#include <string.h>

#include "analysis/report/ray_report.h"
#include "analysis/report/ray_table.h"
#include "base/alloc.h"
#include "io/hdf5/table_h5.h"
#include "io/map/map_rays.h"
#include "portion/event.h"
#include "version.h"

struct rmap_table_out {
    const struct rmap_map *map;
    struct rmap_ray_table *table;
    struct rmap_table_h5 *file;
};

static enum rmap_status begin_file(struct rmap_table_out *self, const char *path,
                                   struct rmap_error *err)
{
    const struct rmap_ray_table *table = self->table;
    struct rmap_table_h5_column *column = rmap_alloc(table->n, sizeof *column);
    if (!column)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the columns of a table");
    for (size_t i = 0; i < table->n; i++)
        column[i] = (struct rmap_table_h5_column){
            .group = rmap_ray_table_word(table->column[i].table),
            .name = table->column[i].name,
            .element = table->column[i].element,
            .unit = table->column[i].unit,
            .description = table->column[i].column == RMAP_SEGMENT_event
                               ? "bits of what happened at the end of the leg; "
                                 "see the file's attribute `event_bits`"
                               : table->column[i].description};
    enum rmap_status st = rmap_table_h5_begin(path, column, table->n, &self->file, err);
    rmap_free(column);
    return st;
}

static enum rmap_status put_attributes(struct rmap_table_out *self,
                                       const struct rmap_table_request *request,
                                       struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    struct rmap_map_summary summary;
    char digest[33];
    rmap_map_summarise(self->map, &summary);
    rmap_digest_text(summary.digest, digest);
    const int32_t complete = rmap_map_is_whole(self->map);
    const char *const text[][2] = {{"program_version", RMAP_VERSION},
                                   {"map", request->from},
                                   {"criterion", request->criterion},
                                   {"answer", request->answer},
                                   {"digest", digest},
                                   {"length_unit", scene->unit},
                                   {"flux_unit", rmap_flux_unit_name(scene)},
                                   {"event_bits", rmap_event_bits()}};
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; st == RMAP_OK && i < sizeof text / sizeof *text; i++)
        st = rmap_table_h5_put_text(self->file, text[i][0], text[i][1], err);
    RMAP_TRY(st);
    RMAP_TRY(rmap_table_h5_put_number(self->file, "complete", RMAP_I32, &complete, err));
    RMAP_TRY(rmap_table_h5_put_number(self->file, "seed", RMAP_U64, &summary.seed, err));
out:
    return st;
}

/* n structs from `first` on have a name at `offset`. */
static enum rmap_status put_list(struct rmap_table_out *self, const char *word, const void *first,
                                 size_t n, size_t struct_nbytes, size_t offset,
                                 struct rmap_error *err)
{
    const char **name = rmap_alloc(n + 1, sizeof *name);
    if (!name)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for names");
    for (size_t i = 0; i < n; i++)
        memcpy(&name[i], (const char *)first + i * struct_nbytes + offset, sizeof *name);
    enum rmap_status st =
        rmap_table_h5_put_names(self->file, word, name, n, "what columns of this name count", err);
    rmap_free(name);
    return st;
}

static enum rmap_status put_names(struct rmap_table_out *self, struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    enum rmap_status st = RMAP_OK;
    const char *stop[RMAP_STOP_COUNT];
    for (int i = 0; i < RMAP_STOP_COUNT; i++)
        stop[i] = rmap_stop_word(i);
    RMAP_TRY(rmap_table_h5_put_names(self->file, "stop", stop, RMAP_STOP_COUNT,
                                     "why a ray ended, as /ray/stop counts it", err));
#define PUT(member)                                                                                \
    RMAP_TRY(put_list(self, #member, scene->member, scene->n_##member, sizeof *scene->member,      \
                      offsetof(struct rmap_##member, name), err))
    PUT(source);
    PUT(object);
    PUT(medium);
    PUT(detector);
#undef PUT
out:
    return st;
}

enum rmap_status rmap_table_out_begin(const struct rmap_map *map,
                                      const struct rmap_table_request *request,
                                      struct rmap_table_out **out_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_table_out *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the answer");
    self->map = map;
    RMAP_TRY(
        rmap_ray_table_create(map, request->columns, RMAP_VECTORS_BY_PARTS, &self->table, err));
    RMAP_TRY(begin_file(self, request->path, err));
    RMAP_TRY(put_attributes(self, request, err));
    RMAP_TRY(put_names(self, err));
    *out_ret = self;
    self = NULL;
out:
    rmap_table_out_destroy(self);
    return st;
}

enum rmap_status rmap_table_out_take(struct rmap_table_out *self,
                                     const struct rmap_streamed_ray *given, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_ray_report *report = NULL;
    const struct rmap_table_ray ray = {given->portion, given->space, given->row, given->segment,
                                       given->registration};
    if (self->table->is_reported)
        RMAP_TRY(rmap_ray_report_row(self->map, ray.space, ray.portion, ray.row, ray.segment,
                                     ray.registration, &report, err));
    for (size_t i = 0; i < self->table->n; i++) {
        const struct rmap_table_column *column = &self->table->column[i];
        const size_t n = rmap_ray_table_rows(&ray, column->table);
        for (size_t k = 0; k < n; k++) {
            uint64_t element; /* room for any */
            rmap_ray_table_read(self->table, column, &ray, report, k, &element);
            RMAP_TRY(rmap_table_h5_add(self->file, i, &element, err));
        }
    }
out:
    rmap_ray_report_destroy(report);
    return st;
}

enum rmap_status rmap_table_out_finish(struct rmap_table_out *self, struct rmap_error *err)
{
    return rmap_table_h5_finish(self->file, false, err);
}

void rmap_table_out_destroy(struct rmap_table_out *self)
{
    if (!self)
        return;
    rmap_table_h5_destroy(self->file);
    rmap_ray_table_destroy(self->table);
    rmap_free(self);
}

/* SPDX-License-Identifier: MIT
 *
 * Maps, their names, and how many rays of them match.
 */
#include "analysis/library/library_map.h"

#include <string.h>

#include "analysis/query/query.h"
#include "base/alloc.h"
#include "io/map/map_content.h"
#include "portion/event.h"
#include "version.h"

_Static_assert((int)RAYMAP_SYSTEM == (int)RMAP_SYSTEM && (int)RAYMAP_FORMAT == (int)RMAP_FORMAT &&
                   (int)RAYMAP_INPUT == (int)RMAP_INPUT && (int)RAYMAP_USAGE == (int)RMAP_USAGE,
               "statuses are the program's");

const char *raymap_version(void)
{
    return RMAP_VERSION;
}

struct rmap_library_call rmap_library_enter(void)
{
    return (struct rmap_library_call){.printing = rmap_h5_printing_get()};
}

enum raymap_status rmap_library_leave(struct rmap_library_call *call, enum rmap_status status,
                                      struct raymap_error *error)
{
    rmap_h5_printing_set(call->printing);
    if (status != RMAP_OK && error) {
        _Static_assert(sizeof error->text == sizeof call->error.text, "texts are copied whole");
        error->status = (int32_t)status;
        memcpy(error->text, call->error.text, sizeof error->text);
    }
    return (enum raymap_status)status;
}

enum raymap_status raymap_open(const char *path, raymap_map **map_ret, struct raymap_error *error)
{
    struct rmap_library_call call = rmap_library_enter();
    enum rmap_status st = RMAP_OK;
    struct raymap_map *self = rmap_alloc(1, sizeof *self);
    if (!self)
        RMAP_TRY(rmap_error_set(&call.error, RMAP_SYSTEM, "out of memory for a map"));
    RMAP_TRY(rmap_map_open(path, &self->map, &call.error));
    RMAP_TRY(rmap_map_compare_directory(self->map, &call.error));
    *map_ret = self;
    self = NULL;
out:
    if (self)
        rmap_map_close(self->map);
    rmap_free(self);
    return rmap_library_leave(&call, st, error);
}

void raymap_close(raymap_map *self)
{
    if (!self)
        return;
    struct rmap_library_call call = rmap_library_enter();
    rmap_map_close(self->map);
    (void)rmap_library_leave(&call, RMAP_OK, NULL);
    rmap_free(self);
}

uint64_t raymap_rows(const raymap_map *self, enum raymap_table table)
{
    _Static_assert((int)RAYMAP_CURVE == (int)RMAP_TABLE_CURVE, "tables are the map's");
    return table <= RAYMAP_CURVE ? rmap_map_contents(self->map)->n_row[table] : 0;
}

size_t raymap_blocks(const raymap_map *self)
{
    return rmap_map_n_portion(self->map);
}

int raymap_find_ray(const raymap_map *self, uint64_t ray, size_t *block_ret)
{
    const size_t n_block = raymap_blocks(self);
    size_t block = *block_ret < n_block ? *block_ret : n_block;
    const bool found = rmap_map_find_ray(self->map, ray, &block);
    if (found)
        *block_ret = block;
    return found;
}

int raymap_is_complete(const raymap_map *self)
{
    struct rmap_map_summary summary;
    rmap_map_summarise(self->map, &summary);
    return summary.complete;
}

uint64_t raymap_seed(const raymap_map *self)
{
    struct rmap_map_summary summary;
    rmap_map_summarise(self->map, &summary);
    return summary.seed;
}

const char *raymap_length_unit(const raymap_map *self, double *metres_ret)
{
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    if (metres_ret)
        *metres_ret = scene->unit_m;
    return scene->unit;
}

const char *raymap_flux_unit(const raymap_map *self)
{
    return rmap_flux_unit_name(rmap_map_scene(self->map));
}

const char *raymap_name(const raymap_map *self, enum raymap_kind kind, size_t i)
{
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    switch (kind) {
    case RAYMAP_SOURCE:
        return i < scene->n_source ? scene->source[i].name : NULL;
    case RAYMAP_OBJECT:
        return i < scene->n_object ? scene->object[i].name : NULL;
    case RAYMAP_MEDIUM:
        return i < scene->n_medium ? scene->medium[i].name : NULL;
    case RAYMAP_DETECTOR:
        return i < scene->n_detector ? scene->detector[i].name : NULL;
    case RAYMAP_STOP:
        return i < RMAP_STOP_COUNT ? rmap_stop_word((int)i) : NULL;
    case RAYMAP_EVENT:
        return i < 32 ? rmap_event_word((uint32_t)1 << i) : NULL;
    }
    return NULL;
}

const double *raymap_wavelengths(const raymap_map *self, size_t space, size_t *n_ret)
{
    *n_ret = 0;
    if (space >= rmap_map_n_space(self->map))
        return NULL;
    const struct rmap_channels *channels = &rmap_map_scene_of(self->map, space)->channels;
    *n_ret = (size_t)channels->n;
    return channels->mode == RMAP_COLOUR_RGB ? NULL : channels->wavelength_nm;
}

const char *raymap_trouble(const raymap_map *self, size_t i)
{
    return i < rmap_map_n_trouble(self->map) ? rmap_map_trouble(self->map, i) : NULL;
}

enum rmap_status rmap_library_criterion(const struct rmap_map *map, const char *text,
                                        struct rmap_criterion **criterion_ret,
                                        struct rmap_error *err)
{
    return rmap_criterion_compile(text ? text : "all", rmap_map_scene(map), criterion_ret, err);
}

enum raymap_status raymap_count_rays(const raymap_map *self, const char *text,
                                     struct raymap_count *count_ret, struct raymap_error *error)
{
    struct rmap_library_call call = rmap_library_enter();
    enum rmap_status st = RMAP_OK;
    struct rmap_criterion *criterion = NULL;
    struct rmap_count count = {0};
    RMAP_TRY(rmap_library_criterion(self->map, text, &criterion, &call.error));
    RMAP_TRY(rmap_count_init(&count, rmap_map_scene(self->map)->n_source, &call.error));
    RMAP_TRY(rmap_query_scan(self->map, &criterion, 1, 0, rmap_map_n_portion(self->map), &count,
                             NULL, UINT64_MAX, &call.error));
    *count_ret = (struct raymap_count){.rays = count.rays, .segments = count.segments};
    rmap_count_flux(&count, self->map, &count_ret->flux, &count_ret->standard_error);
out:
    rmap_count_fini(&count);
    rmap_criterion_destroy(criterion);
    return rmap_library_leave(&call, st, error);
}

/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query as a file of rays.
 */
#include "mpi/answer/ray_file_out.h"

#include <errno.h>
#include <string.h>

#include "analysis/query/map_light.h"
#include "base/alloc.h"
#include "io/file/whole_file.h"
#include "io/rays/ray_write.h"
#include "mpi/command/find_detector.h"
#include "mpi/command/output.h"
#include "portion/event.h"

struct rmap_ray_file_out {
    const struct rmap_map *map;
    struct rmap_whole_file whole;
    struct rmap_ray_writer *writer;
    int32_t detector; /* -1: rays as they end */
    uint64_t n;
};

bool rmap_ray_file_named(const char *path)
{
    return rmap_output_is(path, ".tm25ray") || rmap_output_is(path, ".mcpl");
}

static enum rmap_status find_detector(struct rmap_ray_file_out *self, const char *at,
                                      struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_map_scene(self->map);
    self->detector = -1;
    enum rmap_status st = at ? rmap_find_detector(scene, at, &self->detector, err) : RMAP_OK;
    if (st == RMAP_OK && at && scene->detector[self->detector].type != RMAP_DETECTOR_PLANE)
        st = rmap_error_set(err, RMAP_INPUT,
                            "'%.60s' is an intensity grid, where light has a direction and no "
                            "place; --at takes a plane",
                            at);
    return st;
}

enum rmap_status rmap_ray_file_out_begin(const struct rmap_map *map,
                                         const struct rmap_table_request *request,
                                         struct rmap_ray_file_out **out_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    const bool coloured = scene->channels.mode == RMAP_COLOUR_SPECTRAL;
    enum rmap_ray_format format = RMAP_RAYS_TM25;
    struct rmap_ray_file_out *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the answer");
    self->map = map;
    RMAP_TRY(find_detector(self, request->at, err));
    if (!rmap_ray_format_of(request->path, &format) || (format == RMAP_RAYS_MCPL && !coloured))
        RMAP_TRY(
            rmap_error_set(err, RMAP_INPUT,
                           "photons of MCPL have an energy, and this map's light is red, "
                           "green and blue: trace it with --color spectral, or write .tm25ray"));
    if (format == RMAP_RAYS_TM25 && scene->flux_unit > RMAP_FLUX_LM)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT,
                                "TM-25 has flux in W or lm, and this map's is in %s: write .mcpl",
                                rmap_flux_unit_name(scene)));
    RMAP_TRY(rmap_whole_file_open(&self->whole, request->path, err));
    RMAP_TRY(rmap_ray_writer_begin(self->whole.file, format, scene->flux_unit == RMAP_FLUX_LM,
                                   coloured, request->criterion, &self->writer, err));
    *out_ret = self;
    self = NULL;
out:
    rmap_ray_file_out_destroy(self);
    return st;
}

static void put(struct rmap_ray_file_out *self, const struct rmap_ray_written *row)
{
    rmap_ray_writer_add(self->writer, row);
    self->n++;
}

static void add_end(struct rmap_ray_file_out *self, const struct rmap_streamed_ray *ray)
{
    const struct rmap_portion *portion = ray->portion;
    const size_t n = portion->ray.segment_count[ray->row], last = ray->segment + n - 1;
    if (n == 0)
        return;
    const struct rmap_vec3 end = rmap_vec3_of(&portion->segment.position[3 * last]),
                           start = n > 1 ? rmap_vec3_of(&portion->segment.position[3 * (last - 1)])
                                         : rmap_vec3_of(&portion->ray.start[3 * ray->row]);
    const bool left = portion->ray.stop[ray->row] == RMAP_STOP_LEFT;
    const struct rmap_vec3 way =
        left ? rmap_vec3_of(&portion->ray.end_direction[3 * ray->row]) : rmap_sub(end, start);
    const double length = rmap_length(way);
    if (!(length > 0.0))
        return;
    struct rmap_ray_written row = {
        .position = rmap_scale(left ? start : end, rmap_map_scene(self->map)->unit_m),
        .direction = rmap_scale(way, 1.0 / length)};
    rmap_map_light_of_ray(self->map, ray->space, portion, ray->row, last, self->n, &row);
    put(self, &row);
}

enum rmap_status rmap_ray_file_out_take(struct rmap_ray_file_out *self,
                                        const struct rmap_streamed_ray *ray, struct rmap_error *err)
{
    const struct rmap_portion *portion = ray->portion;
    const size_t end = ray->registration + portion->ray.registration_count[ray->row];
    if (self->detector < 0)
        add_end(self, ray);
    for (size_t k = ray->registration; self->detector >= 0 && k < end; k++)
        if (portion->registration.detector[k] == self->detector &&
            portion->registration.registered[k]) {
            struct rmap_ray_written row;
            rmap_map_light_at(self->map, ray->space, portion, ray->row, ray->segment, k, self->n,
                              &row);
            put(self, &row);
        }
    return ferror(self->whole.file) ? rmap_error_set(err, RMAP_SYSTEM, "cannot write '%s': %s",
                                                     self->whole.path, strerror(errno))
                                    : RMAP_OK;
}

enum rmap_status rmap_ray_file_out_finish(struct rmap_ray_file_out *self, struct rmap_error *err)
{
    struct rmap_ray_writer *writer = self->writer;
    self->writer = NULL;
    const enum rmap_status st = rmap_ray_writer_finish(writer, err);
    return st == RMAP_OK ? rmap_whole_file_finish(&self->whole, err) : st;
}

uint64_t rmap_ray_file_out_count(const struct rmap_ray_file_out *self)
{
    return self->n;
}

void rmap_ray_file_out_destroy(struct rmap_ray_file_out *self)
{
    if (!self)
        return;
    rmap_ray_writer_destroy(self->writer);
    rmap_whole_file_fini(&self->whole);
    rmap_free(self);
}

/* SPDX-License-Identifier: MIT
 *
 * Rays of `raymap draw` as polylines for ParaView.
 */
#include "mpi/answer/draw_polydata.h"

#include "base/alloc.h"
#include "io/export/polydata.h"
#include "io/file/whole_file.h"
#include "mpi/command/balance.h"

enum rmap_status rmap_draw_polydata(const struct rmap_map *map, const struct rmap_portion *rays,
                                    const struct rmap_ray_paint *paint, const char *path,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_scene *scene = rmap_map_scene(map);
    struct rmap_whole_file whole = {0};
    struct rmap_polydata *data = NULL;
    const char **group = rmap_alloc(paint->n_group + 1, sizeof *group);
    const struct rmap_polydata_terms terms = {rmap_flux_unit_name(scene), group, paint->n_group};
    if (!group)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of groups");
    for (size_t k = 0; k < paint->n_group; k++)
        group[k] = paint->group[k].label;
    RMAP_TRY(rmap_whole_file_open(&whole, path, err));
    RMAP_TRY(rmap_polydata_begin(whole.file, scene, &terms, &data, err));
    for (size_t i = 0, segment = 0; i < rays->n_row[RMAP_TABLE_RAY];
         segment += rays->ray.segment_count[i++]) {
        const double *flux = rmap_map_flux_per_weight(map);
        const struct rmap_polydata_ray ray = {
            .flux = rays->ray.weight[i] * flux[rays->ray.source[i]],
            .group = paint->of_ray ? (int32_t)paint->of_ray[i] : -1};
        RMAP_TRY(rmap_polydata_add(data, rays, i, segment, &ray, err));
    }
    rmap_polydata_finish(data);
    st = rmap_whole_file_finish(&whole, err);
out:
    rmap_free(group);
    rmap_polydata_destroy(data);
    rmap_whole_file_fini(&whole);
    return st;
}

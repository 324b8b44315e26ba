/* SPDX-License-Identifier: MIT
 *
 * Light that passes and that is absorbed in the voxels of a box: a kind of fold.
 */
#include "analysis/detector/voxel_sums.h"

#include "base/alloc.h"
#include "portion/event.h"

static void destroy(void *state)
{
    struct rmap_voxel_sums *sums = state;
    for (int k = 0; sums && k < RMAP_VOXEL_PARTS; k++)
        rmap_cell_sums_fini(&sums->part[k]);
    rmap_free(sums);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_voxel_ask *ask = context;
    const size_t n_source = rmap_map_scene(ask->map)->n_source;
    const size_t n = rmap_voxel_grid_n(&ask->grid);
    const size_t nbytes = RMAP_VOXEL_PARTS * rmap_cell_sums_nbytes(n_source, n);
    if (nbytes > RMAP_CELL_SUMS_NBYTES_MAX)
        return rmap_error_set(err, RMAP_USAGE,
                              "sums in %u x %u x %u voxels of %zu sources take %.1f GB on every "
                              "thread, and 1 is the most: ask for fewer --cells",
                              ask->grid.n[0], ask->grid.n[1], ask->grid.n[2], n_source,
                              1e-9 * (double)nbytes);
    struct rmap_voxel_sums *sums = rmap_alloc(1, sizeof *sums);
    if (!sums)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for voxels");
    sums->ask = ask;
    for (int k = 0; k < RMAP_VOXEL_PARTS; k++)
        RMAP_TRY(rmap_cell_sums_init(&sums->part[k], n_source, n, err));
    *state_ret = sums;
    sums = NULL;
out:
    destroy(sums);
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_voxel_sums *sums = into, *more = from;
    (void)err;
    for (int k = 0; k < RMAP_VOXEL_PARTS; k++)
        rmap_cell_sums_merge(&sums->part[k], &more->part[k]);
    return RMAP_OK;
}

enum { BLOCKS = RMAP_VOXEL_PARTS * RMAP_CELL_SUMS_BLOCKS };
_Static_assert((int)BLOCKS <= RMAP_FOLD_BLOCKS_MAX, "arrays of a state");

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_voxel_sums *sums = state;
    for (int k = 0; k < RMAP_VOXEL_PARTS; k++)
        rmap_cell_sums_blocks(&sums->part[k], block + (ptrdiff_t)k * RMAP_CELL_SUMS_BLOCKS);
    return BLOCKS;
}

/* A ray's way: curved segments by their points, one that left the scene on to the box's end. */
static void add_way(struct rmap_voxel_sums *sums, const struct rmap_portion *portion, size_t ray,
                    size_t segment)
{
    const struct rmap_voxel_grid *grid = &sums->ask->grid;
    struct rmap_cell_sums *passing = &sums->part[RMAP_VOXEL_PASSING];
    const double weight = portion->ray.weight[ray];
    struct rmap_vec3 from = rmap_vec3_of(portion->ray.start + 3 * ray);
    size_t curve = 0, end = 0;
    if (portion->n_row[RMAP_TABLE_CURVE] > 0)
        end = rmap_portion_curve_of(portion, portion->ray.id[ray], &curve);
    end += curve;
    for (uint32_t k = 0; k < portion->ray.segment_count[ray]; k++) {
        const size_t row = segment + k;
        const uint32_t event = portion->segment.event[row];
        struct rmap_vec3 to = rmap_vec3_of(portion->segment.position + 3 * row);
        for (; curve < end && portion->curve.segment[curve] == k; curve++) {
            const struct rmap_vec3 between = rmap_vec3_of(portion->curve.position + 3 * curve);
            rmap_voxel_grid_walk(grid, from, between, weight, passing);
            from = between;
        }
        if ((event & (RMAP_EVENT_LEFT | RMAP_EVENT_GRADIENT)) == RMAP_EVENT_LEFT)
            to = rmap_axpy(rmap_voxel_grid_reach(grid, from),
                           rmap_vec3_of(portion->ray.end_direction + 3 * ray), from);
        rmap_voxel_grid_walk(grid, from, to, weight, passing);
        from = to;
    }
}

static void add_end(struct rmap_voxel_sums *sums, const struct rmap_portion *portion, size_t ray,
                    size_t segment)
{
    const uint32_t n = portion->ray.segment_count[ray];
    const size_t last = segment + n - 1;
    const bool surface = n > 0 && portion->segment.object[last] >= 0;
    const size_t cell = rmap_voxel_grid_cell(
        &sums->ask->grid,
        rmap_vec3_of(n > 0 ? portion->segment.position + 3 * last : portion->ray.start + 3 * ray));
    if (cell != SIZE_MAX && portion->ray.stop[ray] == RMAP_STOP_ABSORBED)
        rmap_cell_sums_add(&sums->part[surface ? RMAP_VOXEL_SURFACES : RMAP_VOXEL_ABSORBED], cell,
                           portion->ray.weight[ray]);
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    struct rmap_voxel_sums *sums = state;
    const struct rmap_portion *portion = rays->portion;
    (void)err;
    for (size_t i = 0, segment = 0; i < portion->n_row[RMAP_TABLE_RAY];
         segment += portion->ray.segment_count[i++]) {
        if (rays->match && !rays->match[i])
            continue;
        add_way(sums, portion, i, segment);
        add_end(sums, portion, i, segment);
        for (int k = 0; k < RMAP_VOXEL_PARTS; k++)
            rmap_cell_sums_end_ray(&sums->part[k], (size_t)portion->ray.source[i]);
    }
    return RMAP_OK;
}

rmap_column_set rmap_voxel_columns(const struct rmap_scene *scene)
{
    return RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
           RMAP_COLUMN_BIT(RMAP_RAY_stop) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |
           RMAP_COLUMN_BIT(RMAP_RAY_segment_count) | RMAP_COLUMN_BIT(RMAP_RAY_start) |
           RMAP_COLUMN_BIT(RMAP_RAY_end_direction) | RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
           RMAP_COLUMN_BIT(RMAP_SEGMENT_event) | RMAP_COLUMN_BIT(RMAP_SEGMENT_position) |
           (rmap_scene_is_curved(scene) ? RMAP_COLUMNS_CURVE : 0);
}

const struct rmap_fold_kind rmap_voxel_kind = {
    .create = create, .destroy = destroy, .add = add, .merge = merge, .blocks = blocks};

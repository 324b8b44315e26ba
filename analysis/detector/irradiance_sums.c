/* SPDX-License-Identifier: MIT
 *
 * Light that arrives at the cells of objects, and that is absorbed there: a kind of fold.
 */
#include "analysis/detector/irradiance_sums.h"

#include <inttypes.h>
#include <math.h>

#include "base/alloc.h"
#include "portion/event.h"

static void destroy(void *state)
{
    struct rmap_irradiance_sums *sums = state;
    for (int k = 0; sums && k < RMAP_IRRADIANCE_PARTS; k++) {
        rmap_cell_sums_fini(&sums->cell[k]);
        rmap_cell_sums_fini(&sums->object[k]);
    }
    rmap_free(sums);
}

/* lm of a W of the brightest channel; 1: none is seen. */
static double brightest(const struct rmap_channels *channels)
{
    double most = 0.0;
    for (int c = 0; c < channels->n; c++) {
        double alone[RMAP_CHANNEL_MAX] = {0.0};
        alone[c] = 1.0;
        most = fmax(most, rmap_luminous_efficacy(channels, alone));
    }
    return most > 0.0 ? most : 1.0;
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_irradiance_ask *ask = context;
    const struct rmap_scene *scene = rmap_map_scene(ask->map);
    const size_t n_source = scene->n_source, n_cell = ask->cells->n_cell;
    const size_t nbytes = RMAP_IRRADIANCE_PARTS * rmap_cell_sums_nbytes(n_source, n_cell);
    if (nbytes > RMAP_CELL_SUMS_NBYTES_MAX)
        return rmap_error_set(err, RMAP_USAGE,
                              "sums in %zu cells of %zu sources take %.1f GB on every thread, and "
                              "1 is the most: ask for longer --cells, or fewer objects",
                              n_cell, n_source, 1e-9 * (double)nbytes);
    struct rmap_irradiance_sums *sums = rmap_alloc(1, sizeof *sums);
    if (!sums)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells");
    sums->ask = ask;
    sums->unit = ask->luminous ? brightest(&scene->channels) : 1.0;
    for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
        RMAP_TRY(rmap_cell_sums_init(&sums->cell[k], n_source, n_cell, err));
        RMAP_TRY(rmap_cell_sums_init(&sums->object[k], n_source, ask->cells->n_part, err));
    }
    *state_ret = sums;
    sums = NULL;
out:
    destroy(sums);
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_irradiance_sums *sums = into, *more = from;
    (void)err;
    for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
        rmap_cell_sums_merge(&sums->cell[k], &more->cell[k]);
        rmap_cell_sums_merge(&sums->object[k], &more->object[k]);
    }
    return RMAP_OK;
}

enum { BLOCKS = 2 * RMAP_IRRADIANCE_PARTS * RMAP_CELL_SUMS_BLOCKS };
_Static_assert((int)BLOCKS <= RMAP_FOLD_BLOCKS_MAX, "arrays of a state");

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_irradiance_sums *sums = state;
    for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
        rmap_cell_sums_blocks(&sums->cell[k], block + (ptrdiff_t)2 * k * RMAP_CELL_SUMS_BLOCKS);
        rmap_cell_sums_blocks(&sums->object[k],
                              block + (ptrdiff_t)(2 * k + 1) * RMAP_CELL_SUMS_BLOCKS);
    }
    return BLOCKS;
}

/* A ray of the portion. */
struct arriving {
    const struct rmap_portion *portion;
    const struct rmap_scene *scene; /* of its colour space */
    size_t ray, segment;            /* rows, the first of its segments */
};

/* Where segment k begins, or the last recorded point of a curved one. */
static struct rmap_vec3 before(const struct arriving *light, uint32_t k)
{
    const struct rmap_portion *portion = light->portion;
    size_t first = 0, n = 0;
    if (portion->n_row[RMAP_TABLE_CURVE] > 0)
        n = rmap_portion_curve_of(portion, portion->ray.id[light->ray], &first);
    for (size_t i = first + n; i-- > first;)
        if (portion->curve.segment[i] == k)
            return rmap_vec3_of(portion->curve.position + 3 * i);
    return rmap_vec3_of(k > 0 ? portion->segment.position + 3 * (light->segment + k - 1)
                              : portion->ray.start + 3 * light->ray);
}

/* Light is in front of an object whose medium there is its own; where both sides have one medium
 * the way tells. */
static bool is_in_front(const struct arriving *light, uint32_t k)
{
    const size_t row = light->segment + k;
    const struct rmap_segment_columns *segment = &light->portion->segment;
    const struct rmap_object *object = &light->scene->object[segment->object[row]];
    const int32_t medium = segment->medium[row];
    if ((medium == object->medium_front) != (medium == object->medium_back))
        return medium == object->medium_front;
    const int16_t *n = segment->normal + 3 * row;
    const struct rmap_vec3 way =
        rmap_sub(rmap_vec3_of(segment->position + 3 * row), before(light, k));
    return rmap_dot(way, rmap_vec3(n[0], n[1], n[2])) < 0.0;
}

/* lm of a W of it, in units of the sums. */
static double seen(const struct rmap_irradiance_sums *sums, const struct arriving *light,
                   size_t row)
{
    const struct rmap_portion *portion = light->portion;
    const uint16_t *colour = portion->colour + row * (size_t)portion->n_channel;
    double share[RMAP_CHANNEL_MAX] = {0.0};
    for (int c = 0; c < portion->n_channel && c < light->scene->channels.n; c++)
        share[c] = colour[c] / 65535.0;
    return rmap_luminous_efficacy(&light->scene->channels, share) / sums->unit;
}

static void add_end(struct rmap_irradiance_sums *sums, const struct arriving *light, uint32_t k)
{
    const struct rmap_irradiance_ask *ask = sums->ask;
    const struct rmap_segment_columns *segment = &light->portion->segment;
    const size_t row = light->segment + k;
    const int32_t object = segment->object[row];
    const uint32_t event = segment->event[row];
    const int32_t part = object >= 0 ? ask->cells->part_of[object] : -1;
    if (part < 0 || (event & (RMAP_EVENT_LIMIT | RMAP_EVENT_ERROR)))
        return;
    if (ask->side != RMAP_SIDE_BOTH && is_in_front(light, k) != (ask->side == RMAP_SIDE_FRONT))
        return;
    const size_t cell = rmap_irradiance_cells_find(ask->cells, (size_t)part,
                                                   rmap_vec3_of(segment->position + 3 * row),
                                                   segment->primitive[row]);
    if (cell == SIZE_MAX)
        return;
    const double amount =
        light->portion->ray.weight[light->ray] * (ask->luminous ? seen(sums, light, row) : 1.0);
    for (int what = 0; what < (event & RMAP_EVENT_ABSORB ? 2 : 1); what++) {
        rmap_cell_sums_add(&sums->cell[what], cell, amount);
        rmap_cell_sums_add(&sums->object[what], (size_t)part, amount);
    }
}

static enum rmap_status check_names(const struct arriving *light, struct rmap_error *err)
{
    const struct rmap_portion *portion = light->portion;
    bool good = (uint32_t)portion->ray.source[light->ray] < light->scene->n_source;
    for (uint32_t k = 0; k < portion->ray.segment_count[light->ray]; k++)
        good =
            good && portion->segment.object[light->segment + k] < (int64_t)light->scene->n_object;
    return good ? RMAP_OK
                : rmap_error_set(err, RMAP_FORMAT,
                                 "damaged map: ray %" PRIu64
                                 " has a source or an object that the scene has not",
                                 portion->ray.id[light->ray]);
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_irradiance_sums *sums = state;
    const struct rmap_portion *portion = rays->portion;
    struct arriving light = {.portion = portion,
                             .scene = rmap_map_scene_of(sums->ask->map, rays->space)};
    for (; light.ray < portion->n_row[RMAP_TABLE_RAY];
         light.segment += portion->ray.segment_count[light.ray++]) {
        if (rays->match && !rays->match[light.ray])
            continue;
        RMAP_TRY(check_names(&light, err));
        for (uint32_t k = 0; k < portion->ray.segment_count[light.ray]; k++)
            add_end(sums, &light, k);
        for (int k = 0; k < RMAP_IRRADIANCE_PARTS; k++) {
            rmap_cell_sums_end_ray(&sums->cell[k], (size_t)portion->ray.source[light.ray]);
            rmap_cell_sums_end_ray(&sums->object[k], (size_t)portion->ray.source[light.ray]);
        }
    }
out:
    return st;
}

rmap_column_set rmap_irradiance_columns(const struct rmap_irradiance_ask *ask)
{
    rmap_column_set columns =
        RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_source) |
        RMAP_COLUMN_BIT(RMAP_RAY_weight) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
        RMAP_COLUMN_BIT(RMAP_SEGMENT_object) | RMAP_COLUMN_BIT(RMAP_SEGMENT_primitive) |
        RMAP_COLUMN_BIT(RMAP_SEGMENT_event) | RMAP_COLUMN_BIT(RMAP_SEGMENT_position);
    if (ask->luminous)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_colour);
    if (ask->side == RMAP_SIDE_BOTH)
        return columns;
    return columns | RMAP_COLUMN_BIT(RMAP_RAY_start) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) |
           RMAP_COLUMN_BIT(RMAP_SEGMENT_normal) |
           (rmap_scene_is_curved(rmap_map_scene(ask->map)) ? RMAP_COLUMNS_CURVE : 0);
}

const struct rmap_fold_kind rmap_irradiance_kind = {
    .create = create, .destroy = destroy, .add = add, .merge = merge, .blocks = blocks};

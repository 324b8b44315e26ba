/* SPDX-License-Identifier: MIT
 *
 * What the rays of a sample (a map's rays that match) add up to, per source: their flux, what each
 * detector registered, what each object and medium absorbed, how they ended; and the detectors'
 * images.
 */
#include "analysis/compare/compare_sums.h"

#include <inttypes.h>
#include <string.h>

#include "base/alloc.h"
#include "portion/event.h"
#include "portion/weight.h"

/* 64 Mi numbers: half a GiB for each thread. */
static const size_t VALUE_MAX = (size_t)64 << 20;

size_t rmap_compare_detector(const struct rmap_compare_layout *layout, size_t detector)
{
    (void)layout;
    return 1 + detector;
}

size_t rmap_compare_object(const struct rmap_compare_layout *layout, size_t object)
{
    return 1 + layout->n_detector + object;
}

size_t rmap_compare_medium(const struct rmap_compare_layout *layout, size_t medium)
{
    return rmap_compare_object(layout, layout->n_object) + medium;
}

size_t rmap_compare_stop(const struct rmap_compare_layout *layout, int stop)
{
    return rmap_compare_medium(layout, layout->n_medium) + (size_t)stop;
}

enum rmap_status rmap_compare_layout_init(struct rmap_compare_layout *layout,
                                          const struct rmap_map *map,
                                          const struct rmap_overlay *overlay,
                                          struct rmap_error *err)
{
    const struct rmap_scene *scene = rmap_scene_with(map, overlay);
    *layout = (struct rmap_compare_layout){.map = map,
                                           .scene = scene,
                                           .n_source = scene->n_source,
                                           .n_detector = scene->n_detector,
                                           .n_object = scene->n_object,
                                           .n_medium = scene->n_medium};
    layout->n_scalar = rmap_compare_stop(layout, RMAP_STOP_COUNT);
    layout->first_cell = rmap_alloc(scene->n_detector + 1, sizeof *layout->first_cell);
    if (!layout->first_cell)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu detectors",
                              scene->n_detector);
    for (size_t d = 0; d < scene->n_detector; d++)
        layout->first_cell[d + 1] = layout->first_cell[d] + (size_t)scene->detector[d].cells[0] *
                                                                scene->detector[d].cells[1];
    layout->n_cell = layout->first_cell[scene->n_detector];
    size_t per_source = 3 * layout->n_scalar + layout->n_cell;
    if (layout->n_source > 0 && per_source > VALUE_MAX / layout->n_source) {
        rmap_compare_layout_fini(layout);
        return rmap_error_set(
            err, RMAP_SYSTEM,
            "%zu sources times %zu cells of detectors and objects are too many to "
            "compare in memory",
            scene->n_source, per_source);
    }
    layout->n_value = layout->n_source * per_source + layout->n_detector;
    return RMAP_OK;
}

void rmap_compare_layout_fini(struct rmap_compare_layout *layout)
{
    rmap_free(layout->first_cell);
    *layout = (struct rmap_compare_layout){0};
}

static void destroy(void *state)
{
    struct rmap_compare_sums *self = state;
    if (!self)
        return;
    rmap_free(self->value);
    rmap_free(self->hits);
    rmap_free(self);
}

static enum rmap_status create(const void *context, void **state_ret, struct rmap_error *err)
{
    const struct rmap_compare_layout *layout = context;
    struct rmap_compare_sums *self = rmap_alloc(1, sizeof *self);
    if (self) {
        self->layout = layout;
        self->value = rmap_alloc(layout->n_value + 1, sizeof *self->value);
        self->hits = rmap_alloc(layout->n_detector + 1, sizeof *self->hits);
    }
    if (!self || !self->value || !self->hits) {
        destroy(self);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu sums", layout->n_value);
    }
    size_t n = layout->n_source * layout->n_scalar;
    self->sum = self->value;
    self->square = self->sum + n;
    self->rays = self->square + n;
    self->cell = self->rays + n;
    self->repeated = self->cell + layout->n_source * layout->n_cell;
    *state_ret = self;
    return RMAP_OK;
}

static void add_scalar(struct rmap_compare_sums *self, size_t source, size_t scalar, double q)
{
    size_t at = source * self->layout->n_scalar + scalar;
    self->sum[at] += q;
    self->square[at] += rmap_weight_squared(q);
    self->rays[at] += 1.0;
}

/* Rows [first, end) of /registration, all of one ray. */
static enum rmap_status add_registrations(struct rmap_compare_sums *self,
                                          const struct rmap_matched *rays, size_t ray, size_t first,
                                          size_t end, struct rmap_error *err)
{
    const struct rmap_compare_layout *layout = self->layout;
    const struct rmap_portion *portion = rays->portion;
    const uint8_t *counts = rmap_registrations_counted(rays);
    const struct rmap_registration_columns *at = &portion->registration;
    size_t source = (size_t)portion->ray.source[ray];
    double weight = portion->ray.weight[ray];
    for (size_t row = first; row < end; row++) {
        size_t d = (size_t)at->detector[row];
        if (!counts[row])
            continue;
        const struct rmap_detector *detector = &layout->scene->detector[d];
        const uint16_t *cell = at->cell + 2 * row;
        if (cell[0] >= detector->cells[0] || cell[1] >= detector->cells[1])
            return rmap_error_set(err, RMAP_FORMAT,
                                  "damaged map: ray %" PRIu64 " is registered in cell %u %u",
                                  portion->ray.id[ray], cell[0], cell[1]);
        self->cell[source * layout->n_cell + layout->first_cell[d] + cell[0] +
                   (size_t)cell[1] * detector->cells[0]] += weight;
        self->hits[d]++;
    }
    for (size_t row = first; row < end; row++) {
        size_t d = (size_t)at->detector[row];
        uint32_t hits = self->hits[d];
        if (hits == 0)
            continue;
        add_scalar(self, source, rmap_compare_detector(layout, d), weight * hits);
        self->repeated[d] += hits > 1 || weight != 1.0;
        self->hits[d] = 0;
    }
    return RMAP_OK;
}

/* segment: the ray's last row of /segment; -1: it has none. */
static void add_ending(struct rmap_compare_sums *self, const struct rmap_portion *portion,
                       size_t ray, ptrdiff_t segment)
{
    const struct rmap_compare_layout *layout = self->layout;
    size_t source = (size_t)portion->ray.source[ray];
    double weight = portion->ray.weight[ray];
    int stop = portion->ray.stop[ray];
    add_scalar(self, source, RMAP_COMPARE_SELECTED, weight);
    add_scalar(self, source, rmap_compare_stop(layout, stop), weight);
    if (stop != RMAP_STOP_ABSORBED || segment < 0)
        return;
    int32_t object = portion->segment.object[segment];
    add_scalar(self, source,
               object >= 0 ? rmap_compare_object(layout, (size_t)object)
                           : rmap_compare_medium(layout, (size_t)portion->segment.medium[segment]),
               weight);
}

static enum rmap_status add(void *state, const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_compare_sums *self = state;
    const struct rmap_portion *portion = rays->portion;
    size_t row = 0, segment = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        size_t end = row + portion->ray.registration_count[i];
        size_t n_segment = portion->ray.segment_count[i];
        segment += n_segment;
        if (!rays->match || rays->match[i]) {
            RMAP_TRY(add_registrations(self, rays, i, row, end, err));
            if (!self->layout->registrations_alone)
                add_ending(self, portion, i, n_segment > 0 ? (ptrdiff_t)segment - 1 : -1);
        }
        row = end;
    }
out:
    return st;
}

static enum rmap_status merge(void *into, void *from, struct rmap_error *err)
{
    struct rmap_compare_sums *self = into;
    const struct rmap_compare_sums *other = from;
    (void)err;
    for (size_t i = 0; i < self->layout->n_value; i++)
        self->value[i] += other->value[i];
    return RMAP_OK;
}

static size_t blocks(const void *state, struct rmap_fold_block block[RMAP_FOLD_BLOCKS_MAX])
{
    const struct rmap_compare_sums *self = state;
    block[0] = (struct rmap_fold_block){self->value, self->layout->n_value * sizeof *self->value};
    return 1;
}

const struct rmap_fold_kind rmap_compare_sums_kind = {
    .create = create, .destroy = destroy, .add = add, .merge = merge, .blocks = blocks};

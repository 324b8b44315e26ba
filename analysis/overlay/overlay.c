/* SPDX-License-Identifier: MIT */
#include "analysis/overlay/overlay.h"

#include "analysis/overlay/overlay_internal.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"

static enum rmap_status read_scene(struct rmap_overlay *self,
                                   const struct rmap_receivers *receivers, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bundle *options = NULL;
    RMAP_TRY(rmap_map_options_of(self->map, 0, &options, err));
    st = rmap_scene_read_receivers(rmap_map_bundle(self->map), &options->options, receivers,
                                   &self->read, err);
out:
    rmap_bundle_destroy(options);
    return st;
}

/* Everything but the receivers is the map's own: its numbers were kept as they were traced. */
static enum rmap_status compose(struct rmap_overlay *self, struct rmap_error *err)
{
    const struct rmap_scene *own = rmap_map_scene(self->map), *read = self->read;
    self->first = own->n_detector;
    if (read->n_detector < own->n_detector || read->n_object != own->n_object)
        return rmap_error_set(err, RMAP_FORMAT, "the scene inside the map does not fit the map");
    self->detector = rmap_alloc(read->n_detector, sizeof *self->detector);
    if (!self->detector)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the receivers");
    for (size_t i = 0; i < read->n_detector; i++) {
        self->detector[i] = i < self->first ? own->detector[i] : read->detector[i];
        self->lies_on |= i >= self->first && rmap_detector_lies_on(&read->detector[i]);
        self->on_faces |= i >= self->first && read->detector[i].face;
    }
    self->scene = *own;
    self->scene.detector = self->detector;
    self->scene.n_detector = read->n_detector;
    self->scene.free_detector = read->free_detector;
    self->scene.n_free_detector = read->n_free_detector;
    self->scene.far_detector = read->far_detector;
    self->scene.n_far_detector = read->n_far_detector;
    self->scene.on_detector = read->on_detector;
    self->scene.on_first = read->on_first;
    self->scene.centre = read->centre;
    self->scene.radius = read->radius;
    for (size_t i = 0; i < own->n_medium; i++)
        self->needs_index |= own->medium[i].dispersive;
    for (size_t i = 0; i < own->n_gradient; i++)
        self->needs_wavelength |= own->gradient[i].field && own->gradient[i].field->n_channel > 1;
    return RMAP_OK;
}

/* Lists of detectors are by index: the receivers' are the ends of them. */
static void set_apart(struct rmap_overlay *self)
{
    struct rmap_scene *alone = &self->alone;
    const int32_t first = (int32_t)self->first;
    *alone = self->scene;
    while (alone->n_free_detector > 0 && alone->free_detector[0] < first) {
        alone->free_detector++;
        alone->n_free_detector--;
    }
    while (alone->n_far_detector > 0 && alone->far_detector[0] < first) {
        alone->far_detector++;
        alone->n_far_detector--;
    }
}

enum rmap_status rmap_overlay_create(const struct rmap_map *map,
                                     const struct rmap_receivers *receivers,
                                     struct rmap_overlay **overlay_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_overlay *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the receivers");
    self->map = map;
    RMAP_TRY(read_scene(self, receivers, err));
    RMAP_TRY(compose(self, err));
    set_apart(self);
    *overlay_ret = self;
    self = NULL;
out:
    rmap_overlay_destroy(self);
    return st;
}

void rmap_overlay_destroy(struct rmap_overlay *self)
{
    if (!self)
        return;
    rmap_scene_destroy(self->read);
    rmap_free(self->detector);
    rmap_free(self);
}

const struct rmap_scene *rmap_scene_with(const struct rmap_map *map,
                                         const struct rmap_overlay *overlay)
{
    return overlay ? &overlay->scene : rmap_map_scene(map);
}

size_t rmap_overlay_first(const struct rmap_overlay *overlay)
{
    return overlay->first;
}

rmap_column_set rmap_overlay_columns(const struct rmap_overlay *overlay, rmap_column_set wanted)
{
    rmap_column_set columns =
        wanted | RMAP_COLUMN_BIT(RMAP_RAY_id) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
        RMAP_COLUMN_BIT(RMAP_RAY_registration_count) | RMAP_COLUMN_BIT(RMAP_RAY_start) |
        RMAP_COLUMN_BIT(RMAP_RAY_end_direction) | RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
        RMAP_COLUMN_BIT(RMAP_SEGMENT_event) | RMAP_COLUMN_BIT(RMAP_SEGMENT_medium) |
        RMAP_COLUMN_BIT(RMAP_SEGMENT_position) | RMAP_COLUMN_BIT(RMAP_REGISTRATION_segment) |
        RMAP_COLUMN_BIT(RMAP_REGISTRATION_detector);
    const struct rmap_scene *scene = rmap_map_scene(overlay->map);
    if (rmap_scene_is_curved(scene))
        columns |= RMAP_COLUMNS_CURVE | RMAP_COLUMN_BIT(RMAP_RAY_start_object);
    if (overlay->on_faces)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_primitive);
    bool optical = (wanted & RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path)) != 0;
    if ((optical && overlay->needs_index) || overlay->needs_wavelength)
        columns |= RMAP_COLUMN_BIT(RMAP_SEGMENT_colour);
    return columns;
}

void rmap_overlay_info(const struct rmap_overlay *overlay, const struct rmap_portion_info *stored,
                       struct rmap_portion_info *info)
{
    *info = *stored;
    for (size_t d = overlay->first; d < overlay->scene.n_detector; d++)
        info->summary.detectors |= UINT64_C(1) << (d % 64);
}

size_t rmap_overlay_n_read(const struct rmap_overlay *overlay,
                           const struct rmap_criterion *criterion)
{
    size_t n = 0;
    for (size_t i = 0; i < rmap_map_n_portion(overlay->map); i++) {
        struct rmap_portion_info info;
        rmap_overlay_info(overlay, rmap_map_portion(overlay->map, i), &info);
        n += !criterion || rmap_criterion_may_match(criterion, &info.summary);
    }
    return n;
}

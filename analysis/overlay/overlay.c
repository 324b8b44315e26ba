/* SPDX-License-Identifier: MIT
 *
 * Receivers laid over a finished map: detectors that the scene did not have when it was traced.
 */
#include <inttypes.h>
#include <string.h>

#include "analysis/overlay/overlay.h"
#include "analysis/overlay/overlay_segment.h"
#include "base/alloc.h"
#include "io/file/diagnostics.h"
#include "io/map/map_space.h"
#include "portion/portion_recorder.h"

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
    const bool optical = (wanted & (RMAP_COLUMN_BIT(RMAP_REGISTRATION_optical_path) |
                                    RMAP_COLUMN_BIT(RMAP_REGISTRATION_group_path))) != 0;
    const bool delay = (wanted & RMAP_COLUMN_BIT(RMAP_REGISTRATION_delay)) != 0;
    if (delay)
        columns |= RMAP_COLUMN_BIT(RMAP_RAY_delay);
    if ((optical && overlay->needs_index) || overlay->needs_wavelength ||
        (delay && scene->fluoresces))
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

/* A portion with the receivers' registrations among its own. */

struct rmap_overlay_view {
    struct rmap_recorder base; /* takes what detectors tell of the segment in hand */
    const struct rmap_overlay *overlay;
    struct rmap_portion *own; /* counts of registrations, and their rows */
    struct rmap_portion_recorder recorder;
    struct rmap_portion extended;
    struct rmap_registration *found;
    size_t n_found, cap_found;
    enum rmap_status status;
};

static void take(struct rmap_recorder *base, const struct rmap_registration *registration)
{
    struct rmap_overlay_view *self = (struct rmap_overlay_view *)base;
    if (self->status == RMAP_OK)
        self->status = RMAP_RESERVE(self->found, self->cap_found, self->n_found + 1, NULL);
    if (self->status != RMAP_OK)
        return;
    self->found[self->n_found++] = *registration;
}

enum rmap_status rmap_overlay_view_create(const struct rmap_overlay *overlay,
                                          struct rmap_overlay_view **view_ret,
                                          struct rmap_error *err)
{
    struct rmap_overlay_view *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the receivers");
    self->overlay = overlay;
    self->base.registration = take;
    enum rmap_status st = rmap_portion_create(RMAP_BLOCK_RAYS, 1, &self->own, err);
    if (st == RMAP_OK)
        st = rmap_portion_set_timed(self->own, overlay->scene.timed, err);
    if (st != RMAP_OK) {
        rmap_overlay_view_destroy(self);
        return st;
    }
    rmap_portion_recorder_init(&self->recorder, self->own);
    *view_ret = self;
    return RMAP_OK;
}

void rmap_overlay_view_destroy(struct rmap_overlay_view *self)
{
    if (!self)
        return;
    rmap_portion_destroy(self->own);
    rmap_free(self->found);
    rmap_free(self);
}

/* ---- one segment ---- */

static bool is_free(const struct rmap_overlay *overlay, int32_t index)
{
    const struct rmap_detector *detector = &overlay->scene.detector[index];
    return detector->type == RMAP_DETECTOR_PLANE && detector->on_object < 0 &&
           detector->on_group < 0;
}

/* Appends stored row `from`, with the columns that are there. */
static enum rmap_status copy_row(struct rmap_overlay_view *self, const struct rmap_portion *stored,
                                 size_t from, struct rmap_error *err)
{
    struct rmap_portion *own = self->own;
    size_t *n = &own->n_row[RMAP_TABLE_REGISTRATION];
    if (*n == own->cap[RMAP_TABLE_REGISTRATION]) {
        enum rmap_status st =
            rmap_portion_reserve(own, RMAP_TABLE_REGISTRATION, 1, RMAP_COLUMNS_ALL, err);
        if (st != RMAP_OK)
            return st;
    }
#define RMAP_COPY(field, path, type, element, width, unit, text)                                   \
    if (stored->registration.field)                                                                \
        memcpy(own->registration.field + (size_t)(width) * (*n),                                   \
               stored->registration.field + (size_t)(width)*from, (width) * sizeof(type));
    RMAP_REGISTRATION_COLUMNS(RMAP_COPY)
    RMAP_REGISTRATION_TIME_COLUMNS(RMAP_COPY)
#undef RMAP_COPY
    ++*n;
    own->ray.registration_count[own->n_row[RMAP_TABLE_RAY] - 1]++;
    return RMAP_OK;
}

static enum rmap_status copy_until(struct rmap_overlay_view *self, struct rmap_overlay_ray *ray,
                                   size_t end, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    while (ray->registration < end && st == RMAP_OK) {
        st = copy_row(self, ray->portion, ray->registration++, err);
        ray->n_registration--;
    }
    return st;
}

/* The ray's stored rows of that segment from its next one on; free: of planes free in space alone,
 * which come first. */
static size_t stored_until(const struct rmap_overlay_view *self, const struct rmap_overlay_ray *ray,
                           uint32_t segment, bool free)
{
    const struct rmap_registration_columns *stored = &ray->portion->registration;
    size_t row = ray->registration, end = row + ray->n_registration;
    while (row < end && stored->segment[row] == segment &&
           (!free || is_free(self->overlay, stored->detector[row])))
        row++;
    return row;
}

/* What the segment's detectors told, receivers or all of them, put where it belongs among the
 * stored rows up to `end`: a stored row keeps its place among the stored ones. */
static enum rmap_status merge(struct rmap_overlay_view *self, struct rmap_overlay_ray *ray,
                              size_t end, struct rmap_error *err)
{
    enum rmap_status st = self->status;
    if (st != RMAP_OK)
        return rmap_error_set(err, st, "out of memory for the receivers' registrations");
    for (size_t i = 0; i < self->n_found && st == RMAP_OK; i++) {
        const struct rmap_registration *found = &self->found[i];
        if ((size_t)found->detector >= self->overlay->first) {
            self->recorder.base.registration(&self->recorder.base, found);
            st = self->recorder.status;
            continue;
        }
        size_t row = ray->registration;
        while (row < end && ray->portion->registration.detector[row] != found->detector)
            row++;
        if (row < end)
            st = copy_until(self, ray, row + 1, err);
    }
    self->n_found = 0;
    if (st == RMAP_OK)
        st = copy_until(self, ray, end, err);
    return st;
}

static enum rmap_status watch(struct rmap_overlay_view *self, struct rmap_overlay_ray *ray,
                              struct rmap_segment *segment, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_overlay *overlay = self->overlay;
    const struct rmap_segment_columns *columns = &ray->portion->segment;
    const size_t row = ray->segment + segment->segment;
    const uint32_t event = columns->event[row];
    const size_t end = stored_until(self, ray, segment->segment, true);
    const struct rmap_segment begun = *segment;
    const struct rmap_clock clock = ray->clock;
    self->n_found = 0;
    /* Which comes first only matters where both are met: then all are looked for. */
    for (int pass = 0; pass < 2; pass++) {
        const struct rmap_scene *scene = pass == 0 ? &overlay->alone : &overlay->scene;
        size_t curve = ray->curve;
        if (event & RMAP_EVENT_GRADIENT)
            rmap_overlay_curve(scene, ray, segment, &self->base);
        else
            rmap_detect_free(scene, segment, &self->base);
        if (pass > 0 || self->n_found == 0 || end == ray->registration)
            break;
        *segment = begun;
        ray->curve = curve;
        ray->clock = clock;
        self->n_found = 0;
    }
    RMAP_TRY(merge(self, ray, end, err));
    RMAP_TRY(copy_until(self, ray, stored_until(self, ray, segment->segment, false), err));
    if (columns->object[row] >= 0 && overlay->lies_on &&
        !(event & (RMAP_EVENT_LIMIT | RMAP_EVENT_ERROR)))
        rmap_detect_on(&overlay->scene, segment, columns->object[row],
                       overlay->on_faces ? columns->primitive[row] : 0, &self->base);
    if (event & RMAP_EVENT_LEFT)
        rmap_detect_far(&overlay->alone, segment, &self->base);
    RMAP_TRY(merge(self, ray, ray->registration, err));
out:
    return st;
}

/* ---- one ray ---- */

static enum rmap_status extend_ray(struct rmap_overlay_view *self, struct rmap_overlay_ray *ray,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *stored = ray->portion;
    struct rmap_segment segment;
    const float *start = stored->ray.start + 3 * ray->row;
    struct rmap_vec3 from = rmap_vec3((double)start[0], (double)start[1], (double)start[2]);
    double optical = 0.0;
    ray->clock = (struct rmap_clock){.delay_ns = rmap_overlay_emission_delay(ray)};
    for (uint32_t k = 0; k < ray->n_segment; k++) {
        const int32_t object = stored->segment.object[ray->segment + k];
        const int16_t medium = stored->segment.medium[ray->segment + k];
        if (object >= (int64_t)ray->scene->n_object || medium < 0 ||
            (size_t)medium >= ray->scene->n_medium)
            return rmap_error_set(err, RMAP_FORMAT,
                                  "damaged map: segment %u of ray %" PRIu64
                                  " has an object or a medium that the scene has not",
                                  k, stored->ray.id[ray->row]);
        rmap_overlay_segment(&self->overlay->scene, ray, k, from, optical, &segment);
        RMAP_TRY(watch(self, ray, &segment, err));
        if (ray->scene->fluoresces)
            ray->clock.delay_ns += rmap_overlay_delay(ray, k);
        optical = segment.optical_from + segment.index * segment.length;
        ray->clock.group_path += ray->clock.group_index * segment.length;
        from = segment.to;
    }
    if (ray->n_registration > 0)
        st = rmap_error_set(err, RMAP_FORMAT,
                            "damaged map: ray %" PRIu64
                            " is registered on a segment that it has not",
                            stored->ray.id[ray->row]);
out:
    return st;
}

static enum rmap_status extend_rays(struct rmap_overlay_view *self,
                                    const struct rmap_portion *stored, size_t space,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map *map = self->overlay->map;
    const bool each = space == RMAP_OVERLAY_EACH_SPACE;
    struct rmap_portion *own = self->own;
    struct rmap_overlay_ray ray = {.portion = stored,
                                   .scene = each ? NULL : rmap_map_scene_of(map, space)};
    const size_t n_ray = stored->n_row[RMAP_TABLE_RAY];
    if (n_ray > own->cap[RMAP_TABLE_RAY])
        RMAP_TRY(rmap_portion_reserve(own, RMAP_TABLE_RAY, n_ray, RMAP_COLUMNS_ALL, err));
    for (ray.row = 0; ray.row < n_ray; ray.row++) {
        size_t end;
        if (each)
            ray.scene = rmap_map_scene_of(map, rmap_map_space_of_ray(map, stored->ray.id[ray.row]));
        ray.n_segment = stored->ray.segment_count[ray.row];
        ray.n_registration = stored->ray.registration_count[ray.row];
        end = ray.registration + ray.n_registration;
        if (ray.n_segment > stored->n_row[RMAP_TABLE_SEGMENT] - ray.segment ||
            ray.n_registration > stored->n_row[RMAP_TABLE_REGISTRATION] - ray.registration)
            return rmap_error_set(err, RMAP_FORMAT, "damaged map: rows do not fit together");
        if (stored->curve.segment) {
            size_t n = rmap_portion_curve_of(stored, stored->ray.id[ray.row], &ray.curve);
            ray.curve_end = ray.curve + n;
        }
        own->ray.registration_count[ray.row] = 0;
        own->n_row[RMAP_TABLE_RAY] = ray.row + 1;
        RMAP_TRY(extend_ray(self, &ray, err));
        ray.segment += ray.n_segment;
        ray.registration = end;
    }
out:
    return st;
}

enum rmap_status rmap_overlay_view_extend(struct rmap_overlay_view *self,
                                          const struct rmap_portion *stored, size_t space,
                                          const struct rmap_portion **extended_ret,
                                          struct rmap_error *err)
{
    struct rmap_portion *extended = &self->extended;
    rmap_portion_clear(self->own);
    self->status = self->recorder.status = RMAP_OK;
    enum rmap_status st = extend_rays(self, stored, space, err);
    if (st != RMAP_OK)
        return st;
    *extended = *stored;
    extended->knows_angles = false;
    extended->n_row[RMAP_TABLE_REGISTRATION] = self->own->n_row[RMAP_TABLE_REGISTRATION];
    extended->ray.registration_count = self->own->ray.registration_count;
    /* Columns that were not read lack the stored rows. */
#define RMAP_LEND(field, path, type, element, width, unit, text)                                   \
    extended->registration.field =                                                                 \
        stored->registration.field ? self->own->registration.field : NULL;
    RMAP_REGISTRATION_COLUMNS(RMAP_LEND)
    RMAP_REGISTRATION_TIME_COLUMNS(RMAP_LEND)
#undef RMAP_LEND
    *extended_ret = extended;
    return RMAP_OK;
}

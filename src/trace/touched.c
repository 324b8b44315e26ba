/* SPDX-License-Identifier: MIT
 *
 * Which recorded rays of a scene are other ones in a later version of it.
 */
#include "trace/touched.h"

#include <math.h>

#include "portion/event.h"

/* Detectors free in space that came, went or moved: rays through one that went are told by what it
 * registered. */
static enum rmap_status add_detectors(struct rmap_touch *touch, const struct rmap_scene *new,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < new->n_detector &&st == RMAP_OK; i++) {
        const struct rmap_detector *detector = &new->detector[i];
        const double x = 0.5 * detector->size[0], y = 0.5 * detector->size[1];
        const struct rmap_vec3 column[3] = {detector->x, detector->y, detector->axis};
        struct rmap_affine frame = {.t = detector->origin};
        if (!touch->change.watches[i])
            continue;
        for (int k = 0; k < 3; k++) {
            frame.m[0][k] = column[k].x;
            frame.m[1][k] = column[k].y;
            frame.m[2][k] = column[k].z;
        }
        st = rmap_places_add(&touch->places, &frame, rmap_vec3(-x, -y, 0), rmap_vec3(x, y, 0),
                             rmap_places_rounding(new), err);
    }
    return st;
}

/* As the source's starts may be off; more is no harm. */
static double looseness(const struct rmap_source *source)
{
    const struct rmap_file_rays *rays = source->rays;
    if (!rays || !(rays->loose > 0))
        return 0;
    const struct rmap_vec3 far = rmap_greatest(rays->upper, rmap_scale(rays->lower, -1));
    return rays->loose * rmap_affine_norm(&source->frame) *
           rmap_length(rmap_greatest(far, rmap_vec3(0, 0, 0)));
}

enum rmap_status rmap_touch_init(struct rmap_touch *touch, const struct rmap_scene *old,
                                 const struct rmap_scene *new, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *touch = (struct rmap_touch){.loose = 0};
    RMAP_TRY(rmap_scene_change_find(old, new, &touch->change, err));
    if (touch->change.all[0])
        goto out;
    RMAP_TRY(rmap_accel_mark_joined(old, touch->change.stood, err));
    RMAP_TRY(rmap_accel_mark_joined(new, touch->change.stands, err));
    rmap_scene_change_settle(old, &touch->change);
    RMAP_TRY(rmap_accel_add_places(old, touch->change.stood, &touch->places, err));
    RMAP_TRY(rmap_accel_add_places(new, touch->change.stands, &touch->places, err));
    RMAP_TRY(add_detectors(touch, new, err));
    for (size_t i = 0; i < new->n_source; i++)
        touch->loose = fmax(touch->loose, looseness(&new->source[i]));
out:
    if (st != RMAP_OK)
        rmap_touch_fini(touch);
    return st;
}

void rmap_touch_fini(struct rmap_touch *touch)
{
    rmap_scene_change_fini(&touch->change);
    rmap_places_fini(&touch->places);
}

/* A ray's rows. */
struct rows {
    size_t ray, segment, end, registration, end_registration;
};

/* A start on what changed. */
static bool starts_other(const struct rmap_scene_change *change, const struct rmap_portion *portion,
                         size_t ray)
{
    const int32_t start = portion->ray.start_object[ray];
    return start >= 0 && change->met[start];
}

/* Row of the first segment that meets what changed, or runs in it; `end`: none does. */
static size_t first_other(const struct rmap_scene_change *change,
                          const struct rmap_segment_columns *segment, size_t first, size_t end)
{
    size_t i = first;
    while (i < end && !((segment->object[i] >= 0 && change->met[segment->object[i]]) ||
                        change->in[segment->medium[i]]))
        i++;
    return i;
}

/* By what it met, where it ran and who noted it. */
static bool told_by_path(const struct rmap_scene_change *change, const struct rmap_portion *portion,
                         const struct rows *rows)
{
    bool told = (change->leaving && portion->ray.stop[rows->ray] == RMAP_STOP_LEFT) ||
                starts_other(change, portion, rows->ray) ||
                first_other(change, &portion->segment, rows->segment, rows->end) < rows->end;
    for (size_t i = rows->registration; i < rows->end_registration && !told; i++)
        told = change->noted[portion->registration.detector[i]];
    return told;
}

static struct rmap_vec3 point(const float *p)
{
    return rmap_vec3((double)p[0], (double)p[1], (double)p[2]);
}

/* Does the way from one point to another lie on one side of all places? Mostly. */
static inline bool lies_beside(const struct rmap_places *places, struct rmap_vec3 a,
                               struct rmap_vec3 b)
{
    const struct rmap_vec3 lower = places->lower, upper = places->upper;
    return ((a.x < lower.x) & (b.x < lower.x)) | ((a.x > upper.x) & (b.x > upper.x)) |
           ((a.y < lower.y) & (b.y < lower.y)) | ((a.y > upper.y) & (b.y > upper.y)) |
           ((a.z < lower.z) & (b.z < lower.z)) | ((a.z > upper.z) & (b.z > upper.z));
}

/* Where a ray of a file starts, it may have been put on a surface. */
static struct rmap_vec3 before_start(const struct rmap_touch *touch,
                                     const struct rmap_portion *portion, const struct rows *rows)
{
    const struct rmap_vec3 from = point(portion->ray.start + 3 * rows->ray);
    if (!(touch->loose > 0) || rows->segment == rows->end)
        return from;
    const struct rmap_vec3 way =
        rmap_sub(point(portion->segment.position + 3 * rows->segment), from);
    const double length = rmap_length(way);
    return length > 0 ? rmap_axpy(-2 * touch->loose / length, way, from) : from;
}

static bool told_by_place(const struct rmap_touch *touch, const struct rmap_portion *portion,
                          const struct rows *rows)
{
    struct rmap_vec3 from = before_start(touch, portion, rows);
    bool told = false;
    for (size_t i = rows->segment; i < rows->end && !told; i++) {
        const struct rmap_vec3 to = point(portion->segment.position + 3 * i);
        told = !lies_beside(&touch->places, from, to) && rmap_places_meet(&touch->places, from, to);
        from = to;
    }
    return told;
}

static void next(struct rows *rows, const struct rmap_portion *portion, size_t ray)
{
    rows->ray = ray;
    rows->segment = rows->end;
    rows->end += portion->ray.segment_count[ray];
    rows->registration = rows->end_registration;
    rows->end_registration += portion->ray.registration_count[ray];
}

void rmap_touch_paths(const struct rmap_touch *touch, const struct rmap_portion *portion,
                      uint8_t *touched)
{
    struct rows rows = {.ray = 0};
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        next(&rows, portion, i);
        touched[i] = told_by_path(&touch->change, portion, &rows);
    }
}

size_t rmap_touch_places(const struct rmap_touch *touch, const struct rmap_portion *portion,
                         uint8_t *touched)
{
    struct rows rows = {.ray = 0};
    size_t n = 0;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        next(&rows, portion, i);
        if (!touched[i] && touch->places.n > 0)
            touched[i] = told_by_place(touch, portion, &rows);
        n += touched[i];
    }
    return n;
}

struct rmap_known_way rmap_touch_known(const struct rmap_touch *touch,
                                       const struct rmap_portion *portion,
                                       const size_t first[RMAP_TABLE_COUNT])
{
    const struct rmap_segment_columns *segment = &portion->segment;
    const size_t ray = first[RMAP_TABLE_RAY], row = first[RMAP_TABLE_SEGMENT];
    struct rmap_known_way way = {.object = segment->object + row,
                                 .primitive = segment->primitive + row,
                                 .number = touch->change.object,
                                 .places = &touch->places};
    if (!(touch->loose > 0) && !starts_other(&touch->change, portion, ray))
        way.n =
            first_other(&touch->change, segment, row, row + portion->ray.segment_count[ray]) - row;
    return way;
}

void rmap_touch_renumber(const struct rmap_touch *touch, struct rmap_portion *portion,
                         const size_t first[RMAP_TABLE_COUNT])
{
    const struct rmap_scene_change *change = &touch->change;
    struct rmap_segment_columns *segment = &portion->segment;
    if (!change->renumbers)
        return;
    for (size_t i = first[RMAP_TABLE_RAY]; i < portion->n_row[RMAP_TABLE_RAY]; i++)
        if (portion->ray.start_object[i] >= 0)
            portion->ray.start_object[i] = change->object[portion->ray.start_object[i]];
    for (size_t i = first[RMAP_TABLE_SEGMENT]; i < portion->n_row[RMAP_TABLE_SEGMENT]; i++) {
        if (segment->object[i] >= 0)
            segment->object[i] = change->object[segment->object[i]];
        segment->medium[i] = (int16_t)change->medium[segment->medium[i]];
    }
    for (size_t i = first[RMAP_TABLE_REGISTRATION]; i < portion->n_row[RMAP_TABLE_REGISTRATION];
         i++)
        portion->registration.detector[i] = change->detector[portion->registration.detector[i]];
}

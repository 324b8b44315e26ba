/* SPDX-License-Identifier: MIT
 *
 * Which rows of a table count for a test. The loops over steps run over whole columns without
 * branches, so that compilers turn them into SIMD.
 */
#include <math.h>
#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/criterion_tree.h"
#include "analysis/criterion/registration_angle.h"
#include "analysis/criterion/step_number.h"
#include "base/byte_set.h"
#include "base/wide.h"
#include "portion/event.h"

/* Indices from low on as bytes; CODES - 1: beyond the set. */
enum { CODES = 256 };
RMAP_WIDE static void narrow(const int32_t *restrict index, size_t n, uint32_t low, uint32_t span,
                             uint8_t *restrict code)
{
    for (size_t i = 0; i < n; i++) {
        uint32_t at = (uint32_t)index[i] - low;
        code[i] = (uint8_t)(at < span ? at : CODES - 1);
    }
}

RMAP_WIDE static void mark_range(const int32_t *restrict index, size_t n, uint32_t low,
                                 uint32_t span, uint8_t *restrict flag)
{
    for (size_t i = 0; i < n; i++)
        flag[i] = (uint32_t)index[i] - low < span;
}

void rmap_index_set_mark(const struct rmap_index_set *set, const int32_t *index, size_t n,
                         uint8_t *flag)
{
    if (!set->member) {
        mark_range(index, n, (uint32_t)set->low, set->span, flag);
    } else if (set->span < CODES) {
        uint8_t member[CODES] = {0};
        memcpy(member, set->member, set->span);
        narrow(index, n, (uint32_t)set->low, set->span, flag);
        rmap_byte_set_flags(flag, n, member, flag);
    } else {
        for (size_t i = 0; i < n; i++)
            flag[i] = rmap_index_set_member(set, index[i]);
    }
}

RMAP_WIDE static void keep_events(uint32_t events, uint32_t events_not,
                                  const uint32_t *restrict event, size_t n, uint8_t *restrict flag)
{
    if (events)
        for (size_t i = 0; i < n; i++)
            flag[i] &= (event[i] & events) != 0;
    if (events_not)
        for (size_t i = 0; i < n; i++)
            flag[i] &= (event[i] & events_not) == 0;
}

RMAP_WIDE static void keep_media_range(const int16_t *restrict medium, size_t n, uint32_t low,
                                       uint32_t span, uint8_t *restrict flag)
{
    for (size_t i = 0; i < n; i++)
        flag[i] &= (uint32_t)medium[i] - low < span;
}

static void keep_media(const struct rmap_index_set *set, const int16_t *medium, size_t n,
                       uint8_t *flag)
{
    if (!set->member)
        keep_media_range(medium, n, (uint32_t)set->low, set->span, flag);
    else
        for (size_t i = 0; i < n; i++)
            flag[i] &= rmap_index_set_member(set, medium[i]);
}

RMAP_WIDE static void keep_registered(const uint8_t *restrict registered, size_t n,
                                      uint8_t *restrict flag)
{
    for (size_t i = 0; i < n; i++)
        flag[i] &= registered[i] != 0;
}

static bool has_part(const struct rmap_criterion *criterion, const struct rmap_step_test *test,
                     int32_t object, int32_t primitive)
{
    const struct rmap_scene *scene = criterion->scene;
    uint32_t part = (uint32_t)primitive;
    if (test->part == RMAP_PART_FACE) {
        const struct rmap_mesh *mesh = scene->geometry[scene->object[object].geometry].mesh;
        if (mesh && part >= mesh->n_triangle)
            return false;
        part = mesh ? mesh->face[part] : 0;
    }
    return part >= test->part_low && part <= test->part_high;
}

static struct rmap_vec3 segment(const float *from, const float *to)
{
    return rmap_vec3((double)to[0] - (double)from[0], (double)to[1] - (double)from[1],
                     (double)to[2] - (double)from[2]);
}

/* The side of an object that light met in a row: bit 0 front, bit 1 back. Against the normal is
 * the front; a segment of no length (touching faces) is evaluated by where the light went next. */
static unsigned side_by_geometry(const struct rmap_portion *portion, size_t row, size_t ray,
                                 size_t ray_row)
{
    const float *position = portion->segment.position, *at = position + 3 * row;
    const int16_t *n = portion->segment.normal + 3 * row;
    struct rmap_vec3 normal = rmap_vec3(n[0], n[1], n[2]);
    double along =
        rmap_dot(segment(row > ray_row ? at - 3 : portion->ray.start + 3 * ray, at), normal);
    bool is_last = row + 1 >= ray_row + portion->ray.segment_count[ray];
    if (along == 0.0 && !is_last) {
        const uint32_t back =
            RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TOTAL_REFLECTION;
        along = rmap_dot(segment(at, at + 3), normal);
        if (portion->segment.event[row] & back)
            along = -along;
    }
    return along > 0.0 ? 2 : 1;
}

unsigned rmap_side_met(const struct rmap_scene *scene, const struct rmap_portion *portion,
                       size_t row, size_t ray, size_t ray_row)
{
    const struct rmap_object *met = &scene->object[portion->segment.object[row]];
    if (!rmap_object_medium_tells(met))
        return side_by_geometry(portion, row, ray, ray_row);
    const int16_t medium = portion->segment.medium[row];
    return (unsigned)(medium == met->medium_front) | (unsigned)(medium == met->medium_back) << 1;
}

static void keep_sides(const struct rmap_criterion *criterion, const struct rmap_step_test *test,
                       const struct rmap_portion *portion, const struct rmap_strip *strip,
                       uint8_t *flag)
{
    size_t ray = strip->ray, ray_row = strip->ray_row;
    for (size_t i = 0; i < strip->n; i++) {
        if (!flag[i])
            continue;
        size_t row = strip->first + i;
        while (row >= ray_row + portion->ray.segment_count[ray])
            ray_row += portion->ray.segment_count[ray++];
        const unsigned its = test->side[portion->segment.object[row]];
        const bool passes =
            test->by_way && (portion->segment.event[row] & RMAP_EVENT_TRANSMIT_DIFFUSE);
        const unsigned side = (passes ? its >> 2 : its) & 3;
        if (side == 0)
            flag[i] = 0;
        if (side == 0 || side == 3)
            continue;
        const unsigned own = rmap_side_met(criterion->scene, portion, row, ray, ray_row);
        flag[i] = (side & own) != 0;
    }
}

static void keep_limits(const struct rmap_criterion *criterion, const struct rmap_step_test *test,
                        const struct rmap_portion *portion, const struct rmap_strip *strip,
                        uint8_t *flag)
{
    size_t ray = strip->ray, ray_row = strip->ray_row;
    for (size_t i = 0; i < strip->n; i++) {
        const size_t row = strip->first + i;
        if (!flag[i])
            continue;
        while (row >= ray_row + portion->ray.segment_count[ray])
            ray_row += portion->ray.segment_count[ray++];
        flag[i] = rmap_step_limits_hold(criterion->scene, test, portion, row, ray, ray_row);
    }
}

void rmap_steps_mark(const struct rmap_criterion *criterion, const struct rmap_step_test *test,
                     const struct rmap_portion *portion, const struct rmap_strip *strip,
                     uint8_t *flag)
{
    const struct rmap_segment_columns *segment = &portion->segment;
    size_t first = strip->first, n = strip->n;
    if (test->of_object)
        rmap_index_set_mark(&test->object, segment->object + first, n, flag);
    else
        memset(flag, 1, n);
    if (test->events | test->events_not)
        keep_events(test->events, test->events_not, segment->event + first, n, flag);
    if (test->of_medium)
        keep_media(&test->medium, segment->medium + first, n, flag);
    if (test->part != RMAP_PART_ALL)
        for (size_t i = 0; i < n; i++)
            if (flag[i])
                flag[i] = has_part(criterion, test, segment->object[first + i],
                                   segment->primitive[first + i]);
    if (test->side)
        keep_sides(criterion, test, portion, strip, flag);
    if (test->n_limit > 0)
        keep_limits(criterion, test, portion, strip, flag);
}

double rmap_detector_coordinate(const struct rmap_detector *detector, uint16_t stored, int axis,
                                bool as_relative)
{
    double r = stored / 65535.0;
    if (as_relative)
        return r;
    if (detector->type == RMAP_DETECTOR_INTENSITY)
        return r * (axis == 0 ? 180.0 : 360.0);
    return (r - 0.5) * detector->size[axis];
}

static double world_coordinate(const struct rmap_detector *detector, const uint16_t relative[2],
                               int axis)
{
    if (detector->type == RMAP_DETECTOR_INTENSITY)
        return (double)NAN;
    const struct rmap_vec3 p =
        rmap_axpy(rmap_detector_coordinate(detector, relative[0], 0, false), detector->x,
                  rmap_axpy(rmap_detector_coordinate(detector, relative[1], 1, false), detector->y,
                            detector->origin));
    return axis == 0 ? p.x : axis == 1 ? p.y : p.z;
}

double rmap_registration_number(const struct rmap_scene *scene, const struct rmap_portion *portion,
                                size_t row, enum rmap_registration_number number)
{
    const double light_speed_m_per_s = 299792458.0;
    const struct rmap_registration_columns *registration = &portion->registration;
    const struct rmap_detector *detector = &scene->detector[registration->detector[row]];
    switch (number) {
    case RMAP_REGISTRATION_ANGLE:
        return rmap_registration_angle(detector, registration->direction + 3 * row);
    case RMAP_REGISTRATION_X:
        return rmap_detector_coordinate(detector, registration->relative[2 * row], 0, false);
    case RMAP_REGISTRATION_Y:
        return rmap_detector_coordinate(detector, registration->relative[2 * row + 1], 1, false);
    case RMAP_REGISTRATION_WORLD_X:
    case RMAP_REGISTRATION_WORLD_Y:
    case RMAP_REGISTRATION_WORLD_Z:
        return world_coordinate(detector, registration->relative + 2 * row,
                                (int)(number - RMAP_REGISTRATION_WORLD_X));
    case RMAP_REGISTRATION_TIME:
        return registration->optical_path[row] * scene->unit_m / light_speed_m_per_s;
    case RMAP_REGISTRATION_ARRIVAL:
        return registration->delay[row] * 1e-9 +
               registration->group_path[row] * scene->unit_m / light_speed_m_per_s;
    case RMAP_REGISTRATION_OPTICAL_PATH:
        return registration->optical_path[row];
    case RMAP_REGISTRATION_DETECTED:
        break; /* of its ray, too: rmap_registration_detected */
    case RMAP_REGISTRATION_GROUP_PATH:
        return registration->group_path[row];
    }
    return (double)NAN;
}

/* Even-odd rule; points on an edge are inside. */
static bool polygon_has(const double (*corner)[2], size_t n, double x, double y)
{
    bool inside = false;
    for (size_t i = 0, j = n - 1; i < n; j = i++) {
        const double *a = corner[j], *b = corner[i];
        double turn = (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
        if (turn == 0.0 && x >= fmin(a[0], b[0]) && x <= fmax(a[0], b[0]) &&
            y >= fmin(a[1], b[1]) && y <= fmax(a[1], b[1]))
            return true;
        if ((a[1] > y) != (b[1] > y) && (turn > 0.0) == (b[1] > a[1]))
            inside = !inside;
    }
    return inside;
}

static bool is_curved(enum rmap_region region)
{
    return region == RMAP_REGION_ELLIPSE || region == RMAP_REGION_POLYGON;
}

static bool region_has(const struct rmap_registration_test *test,
                       const struct rmap_detector *detector, const uint16_t *relative)
{
    const double *b = test->bound;
    double x = rmap_detector_coordinate(detector, relative[0], 0, test->relative);
    double y = rmap_detector_coordinate(detector, relative[1], 1, test->relative);
    if (test->region == RMAP_REGION_POLYGON)
        return polygon_has((const double(*)[2])test->corner, test->n_corner, x, y);
    const double c = test->cosine, s = test->sine, across = x - b[0], up = y - b[1];
    double u = (across * c + up * s) / b[2], v = (up * c - across * s) / b[3];
    return u * u + v * v <= 1.0;
}

/* Rows that are out already look at detector 0, which there always is. */
static void keep_box(const struct rmap_box *box, const int32_t *detector, const uint16_t *at,
                     size_t n, uint8_t *flag)
{
    for (size_t i = 0; i < n; i++) {
        const struct rmap_box *its = &box[flag[i] ? detector[i] : 0];
        flag[i] &= (at[2 * i] >= its->low[0]) & (at[2 * i] <= its->high[0]) &
                   (at[2 * i + 1] >= its->low[1]) & (at[2 * i + 1] <= its->high[1]);
    }
}

/* All rows that are in have one detector. */
RMAP_WIDE static void keep_one_box(const struct rmap_box *box, const uint16_t *restrict at,
                                   size_t n, uint8_t *restrict flag)
{
    uint32_t x = box->low[0], y = box->low[1], width = box->high[0] - x, height = box->high[1] - y;
    bool empty = box->low[0] > box->high[0] || box->low[1] > box->high[1];
    for (size_t i = 0; i < n; i++)
        flag[i] &= (at[2 * i] - x <= width) & (at[2 * i + 1] - y <= height) & !empty;
}

void rmap_registrations_mark(const struct rmap_criterion *criterion,
                             const struct rmap_registration_test *test,
                             const struct rmap_portion *portion, const struct rmap_strip *strip,
                             uint8_t *flag)
{
    const struct rmap_registration_columns *registration = &portion->registration;
    size_t first = strip->first, n = strip->n;
    rmap_index_set_mark(&test->detector, registration->detector + first, n, flag);
    if (!test->crossed)
        keep_registered(registration->registered + first, n, flag);
    const uint16_t *at =
        test->region == RMAP_REGION_CELLS ? registration->cell : registration->relative;
    if (test->box && test->detector.span == 1)
        keep_one_box(&test->box[test->detector.low], at + 2 * first, n, flag);
    else if (test->box)
        keep_box(test->box, registration->detector + first, at + 2 * first, n, flag);
    if (is_curved(test->region))
        for (size_t i = 0; i < n; i++)
            if (flag[i])
                flag[i] =
                    region_has(test, &criterion->scene->detector[registration->detector[first + i]],
                               registration->relative + 2 * (first + i));
}

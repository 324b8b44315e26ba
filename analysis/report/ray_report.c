/* SPDX-License-Identifier: MIT
 *
 * Everything that happened along one ray, as a table or as JSON: read from a map (float columns, 9
 * digits) or traced again (double, 17 digits).
 */
#include "analysis/report/ray_report.h"

#include <inttypes.h>
#include <math.h>

#include "base/alloc.h"
#include "io/map/map_cursor.h"
#include "trace/surface_shares.h"

enum { DIGITS_FLOAT = 9, DIGITS_DOUBLE = 17 };

enum rmap_status rmap_ray_report_create(const struct rmap_scene *scene, size_t n_step,
                                        size_t n_registration, size_t n_point,
                                        struct rmap_ray_report **report_ret, struct rmap_error *err)
{
    size_t n_channel = (size_t)scene->channels.n;
    struct rmap_ray_report *report = rmap_alloc(1, sizeof *report);
    if (report) {
        report->step = rmap_alloc(n_step + 1, sizeof *report->step);
        report->registration = rmap_alloc(n_registration + 1, sizeof *report->registration);
        report->point = rmap_alloc(n_point + 1, sizeof *report->point);
        report->colour = rmap_alloc((n_step + 1) * n_channel, sizeof *report->colour);
    }
    if (!report || !report->step || !report->registration || !report->point || !report->colour) {
        rmap_ray_report_destroy(report);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a ray of %zu segments", n_step);
    }
    report->scene = scene;
    report->n_step = n_step;
    report->n_registration = n_registration;
    report->n_point = n_point;
    for (size_t i = 0; i < n_step; i++)
        report->step[i].colour = report->colour + i * n_channel;
    *report_ret = report;
    return RMAP_OK;
}

void rmap_ray_report_destroy(struct rmap_ray_report *report)
{
    if (!report)
        return;
    rmap_free(report->step);
    rmap_free(report->registration);
    rmap_free(report->point);
    rmap_free(report->colour);
    rmap_free(report);
}

/* The first registration at this step or behind it. */
static size_t first_from(const struct rmap_ray_report *report, size_t step)
{
    size_t low = 0, high = report->n_registration;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (report->registration[middle].step < step)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

size_t rmap_ray_report_registrations(const struct rmap_ray_report *report, size_t step,
                                     size_t *first_ret)
{
    *first_ret = first_from(report, step);
    return first_from(report, step + 1);
}

void rmap_detector_coordinates(const struct rmap_detector *detector, const double relative[2],
                               double *x, double *y)
{
    if (detector->type == RMAP_DETECTOR_INTENSITY) {
        *x = relative[0] * 180.0;
        *y = relative[1] * 360.0;
    } else {
        *x = (relative[0] - 0.5) * detector->size[0];
        *y = (relative[1] - 0.5) * detector->size[1];
    }
}

static struct rmap_vec3 nowhere(void)
{
    return rmap_vec3((double)NAN, (double)NAN, (double)NAN);
}

static struct rmap_vec3 normal_of(const int16_t v[3])
{
    struct rmap_vec3 normal = rmap_vec3(v[0] / 32767.0, v[1] / 32767.0, v[2] / 32767.0);
    return v[0] || v[1] || v[2] ? rmap_normalize(normal) : nowhere();
}

static int32_t face_of(const struct rmap_scene *scene, int32_t object, int32_t primitive)
{
    if (object < 0 || (size_t)object >= scene->n_object)
        return -1;
    const struct rmap_geometry *geometry = &scene->geometry[scene->object[object].geometry];
    if (geometry->kind != RMAP_GEOMETRY_MESH)
        return 0;
    if (primitive < 0 || (size_t)primitive >= geometry->mesh->n_triangle)
        return -1;
    return (int32_t)geometry->mesh->face[primitive];
}

/* The next points that lie on segment `segment` are the step's; segment: of every point behind
 * them. */
static void take_points(struct rmap_report_step *step, uint32_t number, const uint32_t *segment,
                        size_t n, size_t *next)
{
    step->first_point = *next;
    while (*next < n && segment[*next] == number)
        (*next)++;
    step->n_point = *next - step->first_point;
}

static void read_points(struct rmap_ray_report *report, const struct rmap_portion *portion,
                        size_t first)
{
    size_t next = 0;
    for (size_t i = 0; i < report->n_point; i++)
        report->point[i] = (struct rmap_report_point){
            .position = rmap_vec3_of(portion->curve.position + 3 * (first + i)),
            .direction = nowhere(),
            .length = (double)NAN,
            .optical_path = (double)NAN};
    for (size_t i = 0; report->n_point > 0 && i < report->n_step; i++)
        take_points(&report->step[i], (uint32_t)i, portion->curve.segment + first, report->n_point,
                    &next);
}

/* Along the points of the segment that begins at `from`; its last stretch. */
static double polyline(const struct rmap_ray_report *report, const struct rmap_report_step *step,
                       struct rmap_vec3 from, struct rmap_vec3 *last)
{
    double length = 0.0;
    for (size_t k = 0; k < step->n_point; k++) {
        struct rmap_vec3 to = report->point[step->first_point + k].position;
        length += rmap_length(rmap_sub(to, from));
        from = to;
    }
    *last = rmap_sub(step->position, from);
    return length + rmap_length(*last);
}

static void read_steps(struct rmap_ray_report *report, const struct rmap_portion *portion,
                       size_t ray, size_t first)
{
    struct rmap_vec3 from = report->start;
    for (size_t i = 0; i < report->n_step; i++) {
        struct rmap_report_step *step = &report->step[i];
        size_t row = first + i;
        step->object = portion->segment.object[row];
        step->primitive = portion->segment.primitive[row];
        step->face = face_of(report->scene, step->object, step->primitive);
        step->events = portion->segment.event[row];
        step->medium = portion->segment.medium[row];
        step->position = rmap_vec3_of(portion->segment.position + 3 * row);
        step->normal = normal_of(portion->segment.normal + 3 * row);
        step->optical_path = (double)NAN;
        step->first_direction = nowhere();
        struct rmap_vec3 segment;
        step->length = polyline(report, step, from, &segment);
        step->direction = rmap_dot(segment, segment) > 0.0 ? rmap_normalize(segment) : nowhere();
        if (step->events & RMAP_EVENT_LEFT) {
            step->length = 0.0;
            step->direction = rmap_vec3_of(portion->ray.end_direction + 3 * ray);
        }
        for (int c = 0; c < portion->n_channel && c < report->scene->channels.n; c++)
            report->colour[i * (size_t)report->scene->channels.n + (size_t)c] =
                portion->colour[row * (size_t)portion->n_channel + (size_t)c] / 65535.0;
        from = step->position;
    }
}

static void read_registrations(struct rmap_ray_report *report, const struct rmap_portion *portion,
                               size_t first)
{
    const struct rmap_registration_columns *column = &portion->registration;
    for (size_t i = 0; i < report->n_registration; i++) {
        struct rmap_report_registration *to = &report->registration[i];
        size_t row = first + i;
        to->detector = column->detector[row];
        to->step = column->segment[row];
        to->cell[0] = column->cell[2 * row];
        to->cell[1] = column->cell[2 * row + 1];
        to->registered = column->registered[row] != 0;
        to->optical_path = column->optical_path[row];
        to->x = to->y = to->angle_deg = (double)NAN;
        if (to->detector < 0 || (size_t)to->detector >= report->scene->n_detector)
            continue;
        const struct rmap_detector *detector = &report->scene->detector[to->detector];
        const double relative[2] = {column->relative[2 * row] / 65535.0,
                                    column->relative[2 * row + 1] / 65535.0};
        rmap_detector_coordinates(detector, relative, &to->x, &to->y);
        struct rmap_vec3 direction = rmap_vec3_of(column->direction + 3 * row);
        double sign = detector->type == RMAP_DETECTOR_INTENSITY ? 1.0 : -1.0;
        to->angle_deg = atan2(rmap_length(rmap_cross(direction, detector->axis)),
                              sign * rmap_dot(direction, detector->axis)) *
                        180.0 / RMAP_PI;
    }
}

/* On one channel; NaN where the surface has none, or an index is not known. */
static double reflectance_on(const struct rmap_scene *scene, const struct rmap_report_step *step,
                             int channel, double cosine)
{
    const struct rmap_object *object = &scene->object[step->object];
    const bool front = rmap_dot(step->direction, step->normal) < 0.0;
    const struct rmap_surface *surface =
        &scene->surface[front ? object->surface_front : object->surface_back];
    const double n1 = rmap_medium_index(scene, step->medium, channel);
    const double n2 =
        rmap_medium_index(scene, front ? object->medium_back : object->medium_front, channel);
    const bool fresnel = surface->type == RMAP_SURFACE_FRESNEL;
    if ((fresnel && isnan(n1 + n2)) ||
        !(fresnel || surface->type == RMAP_SURFACE_MIXTURE || surface->type == RMAP_SURFACE_MIRROR))
        return (double)NAN;
    return rmap_surface_reflectance(scene, (struct rmap_surface_side){object, front}, channel, n1,
                                    n2, cosine);
}

static void find_incidence(struct rmap_ray_report *report)
{
    const struct rmap_scene *scene = report->scene;
    for (size_t i = 0; i < report->n_step; i++) {
        struct rmap_report_step *step = &report->step[i];
        const double cosine = fmin(fabs(rmap_dot(step->direction, step->normal)), 1.0);
        double sum = 0.0;
        step->incidence_deg = step->reflectance = (double)NAN;
        if (step->object < 0 || (size_t)step->object >= scene->n_object || isnan(cosine) ||
            (step->medium >= 0 && (size_t)step->medium >= scene->n_medium))
            continue;
        step->incidence_deg = acos(cosine) * 180.0 / RMAP_PI;
        for (int c = 0; c < scene->channels.n; c++)
            if (step->colour[c] > 0.0)
                sum += step->colour[c] * reflectance_on(scene, step, c, cosine);
        step->reflectance = sum;
    }
}

enum rmap_status rmap_ray_report_row(const struct rmap_map *map, size_t space,
                                     const struct rmap_portion *portion, size_t row, size_t segment,
                                     size_t registration, struct rmap_ray_report **report_ret,
                                     struct rmap_error *err)
{
    struct rmap_ray_report *report = NULL;
    size_t first_point,
        n_point = rmap_portion_curve_of(portion, portion->ray.id[row], &first_point);
    enum rmap_status st =
        rmap_ray_report_create(rmap_map_scene_of(map, space), portion->ray.segment_count[row],
                               portion->ray.registration_count[row], n_point, &report, err);
    if (st != RMAP_OK)
        return st;
    report->digits = DIGITS_FLOAT;
    report->ray = portion->ray.id[row];
    report->source = portion->ray.source[row];
    report->stop = portion->ray.stop[row];
    report->flux = portion->ray.weight[row] * rmap_map_flux_per_weight(map)[report->source];
    report->wavelength_nm = portion->ray.wavelength[row];
    report->path_length = portion->ray.path_length[row];
    report->optical_path = portion->ray.optical_path[row];
    report->start = rmap_vec3_of(portion->ray.start + 3 * row);
    report->start_object = portion->ray.start_object[row];
    read_points(report, portion, first_point);
    read_steps(report, portion, row, segment);
    read_registrations(report, portion, registration);
    find_incidence(report);
    *report_ret = report;
    return RMAP_OK;
}

/* The ray of a portion, if it is there (*report_ret). */
static enum rmap_status read_ray(const struct rmap_map *map, struct rmap_cursor *cursor,
                                 size_t index, uint64_t ray, struct rmap_ray_report **report_ret,
                                 struct rmap_error *err)
{
    const struct rmap_portion *portion = NULL;
    size_t row = 0, segment = 0, registration = 0;
    enum rmap_status st = rmap_cursor_read(cursor, index, &portion, err);
    if (st != RMAP_OK)
        return st;
    while (row < portion->n_row[RMAP_TABLE_RAY] && portion->ray.id[row] != ray) {
        segment += portion->ray.segment_count[row];
        registration += portion->ray.registration_count[row++];
    }
    return row == portion->n_row[RMAP_TABLE_RAY]
               ? RMAP_OK
               : rmap_ray_report_row(map, (size_t)rmap_map_portion(map, index)->space, portion, row,
                                     segment, registration, report_ret, err);
}

enum rmap_status rmap_ray_report_read(const struct rmap_map *map, uint64_t ray,
                                      struct rmap_ray_report **report_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_cursor *cursor = NULL;
    struct rmap_ray_report *report = NULL;
    size_t index = rmap_map_n_portion(map);
    RMAP_TRY(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, err));
    while (!report && rmap_map_find_ray(map, ray, &index))
        RMAP_TRY(read_ray(map, cursor, index, ray, &report, err));
    if (!report)
        st = rmap_error_set(err, RMAP_INPUT, "no ray %" PRIu64 " in this map", ray);
    *report_ret = report;
out:
    rmap_cursor_destroy(cursor);
    return st;
}

static void copy_registrations(struct rmap_ray_report *report, const struct rmap_history *history)
{
    for (size_t i = 0; i < report->n_registration; i++) {
        const struct rmap_registration *from = &history->registration[i];
        struct rmap_report_registration *to = &report->registration[i];
        *to = (struct rmap_report_registration){.detector = from->detector,
                                                .step = from->segment,
                                                .cell = {from->cell[0], from->cell[1]},
                                                .angle_deg =
                                                    rmap_angle_of(from->cosine) * 180.0 / RMAP_PI,
                                                .optical_path = from->optical_path,
                                                .registered = from->registered};
        rmap_detector_coordinates(&report->scene->detector[from->detector], from->relative, &to->x,
                                  &to->y);
    }
}

static void copy_points(struct rmap_ray_report *report, const struct rmap_history *history)
{
    size_t step = 0;
    for (size_t i = 0; i < report->n_point; i++) {
        const struct rmap_curve_point *from = &history->curve[i];
        report->point[i] = (struct rmap_report_point){.position = from->position,
                                                      .direction = from->direction,
                                                      .length = from->length,
                                                      .optical_path = from->optical_path};
        while (step < from->segment && step + 1 < report->n_step)
            report->step[++step].first_point = i;
        report->step[step].n_point++;
    }
}

static void copy_steps(struct rmap_ray_report *report, const struct rmap_history *history)
{
    size_t n_channel = (size_t)report->scene->channels.n;
    for (size_t i = 0; i < report->n_step; i++) {
        const struct rmap_step *from = &history->step[i];
        struct rmap_report_step *to = &report->step[i];
        to->object = from->object;
        to->primitive = from->primitive;
        to->face = face_of(report->scene, from->object, from->primitive);
        to->events = from->events;
        to->medium = from->medium;
        to->position = from->position;
        to->normal = rmap_dot(from->normal, from->normal) > 0.0 ? from->normal : nowhere();
        to->direction = from->direction;
        to->first_direction =
            from->events & RMAP_EVENT_GRADIENT ? from->first_direction : nowhere();
        to->length = from->length;
        to->optical_path = from->optical_path;
        for (size_t c = 0; c < n_channel; c++)
            report->colour[i * n_channel + c] = from->colour[c];
    }
}

enum rmap_status rmap_ray_report_trace(const struct rmap_scene *scene,
                                       const struct rmap_history *history,
                                       struct rmap_ray_report **report_ret, struct rmap_error *err)
{
    struct rmap_ray_report *report = NULL;
    if (history->status != RMAP_OK)
        return rmap_error_set(err, history->status, "out of memory for a ray's history");
    enum rmap_status st = rmap_ray_report_create(scene, history->n_step, history->n_registration,
                                                 history->n_curve, &report, err);
    if (st != RMAP_OK)
        return st;
    report->digits = DIGITS_DOUBLE;
    report->ray = history->emission.ray;
    report->source = history->emission.source;
    report->stop = (int)history->ending.stop;
    report->flux = history->ending.weight * scene->source[report->source].flux;
    report->wavelength_nm = history->ending.wavelength_nm;
    report->path_length = history->ending.path_length;
    report->optical_path = history->ending.optical_path;
    report->start = history->emission.position;
    report->start_object = history->emission.object;
    copy_steps(report, history);
    copy_points(report, history);
    copy_registrations(report, history);
    find_incidence(report);
    *report_ret = report;
    return RMAP_OK;
}

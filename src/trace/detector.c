/* SPDX-License-Identifier: MIT */
#include "trace/detector.h"

#include <math.h>

static uint32_t cell_of(double relative, uint32_t cells)
{
    double cell = floor(relative * (double)cells);
    if (!(cell > 0.0))
        return 0;
    return cell < (double)cells ? (uint32_t)cell : cells - 1;
}

/* Angle limit, counted from the normal of the side that the light meets. */
static bool accepts_angle(const struct rmap_detector *detector, double cosine)
{
    if (detector->max_angle_rad >= 0.5 * RMAP_PI) /* no angle is greater */
        return true;
    double angle_rad = rmap_angle_of(cosine);
    return fmin(angle_rad, RMAP_PI - angle_rad) <= detector->max_angle_rad;
}

static bool accepts(const struct rmap_detector *detector, double cosine)
{
    if (detector->side == RMAP_SIDE_FRONT && !(cosine > 0.0))
        return false;
    if (detector->side == RMAP_SIDE_BACK && !(cosine < 0.0))
        return false;
    return accepts_angle(detector, cosine);
}

static void place(const struct rmap_detector *detector, struct rmap_registration *registration)
{
    for (int k = 0; k < 2; k++)
        registration->cell[k] = cell_of(registration->relative[k], detector->cells[k]);
}

/* Registers light at a point of the detector's plane, if it lies within its area. */
static void register_plane(const struct rmap_scene *scene, const struct rmap_leg *leg,
                           int32_t index, struct rmap_vec3 point, double distance,
                           struct rmap_recorder *recorder)
{
    const struct rmap_detector *detector = &scene->detector[index];
    struct rmap_vec3 offset = rmap_sub(point, detector->origin);
    double x = rmap_dot(offset, detector->x), y = rmap_dot(offset, detector->y);
    if (!(fabs(x) <= 0.5 * detector->size[0] && fabs(y) <= 0.5 * detector->size[1]))
        return;
    double cosine = -rmap_dot(leg->direction, detector->axis);
    struct rmap_registration registration = {
        .detector = index,
        .segment = leg->segment,
        .relative = {x / detector->size[0] + 0.5, y / detector->size[1] + 0.5},
        .position = rmap_axpy(x, detector->x, rmap_axpy(y, detector->y, detector->origin)),
        .direction = leg->direction,
        .cosine = cosine,
        .optical_path = leg->optical_from + leg->index * distance};
    registration.registered = accepts(detector, cosine);
    place(detector, &registration);
    recorder->registration(recorder, &registration);
}

struct crossing {
    double distance;
    int32_t detector;
};

static bool before(struct crossing a, struct crossing b)
{
    return a.distance < b.distance || (a.distance == b.distance && a.detector < b.detector);
}

/* False when the leg does not cross the plane. */
static bool cross(const struct rmap_detector *detector, const struct rmap_leg *leg,
                  double *distance)
{
    double from = rmap_dot(rmap_sub(leg->from, detector->origin), detector->axis);
    double to = rmap_dot(rmap_sub(leg->to, detector->origin), detector->axis);
    if (!((from > 0.0 && to <= 0.0) || (from < 0.0 && to >= 0.0)))
        return false;
    *distance = leg->length * (from / (from - to));
    return true;
}

#define SORTED_MAX 16

/* The nearest crossings after `last`, sorted, at most SORTED_MAX; returns how many. */
static int nearest_crossings(const struct rmap_scene *scene, const struct rmap_leg *leg,
                             struct crossing last, struct crossing sorted[SORTED_MAX])
{
    int n = 0;
    for (size_t k = 0; k < scene->n_free_detector; k++) {
        struct crossing c = {0.0, scene->free_detector[k]};
        if (!cross(&scene->detector[c.detector], leg, &c.distance) || !before(last, c))
            continue;
        if (n == SORTED_MAX && !before(c, sorted[n - 1]))
            continue;
        int at = n < SORTED_MAX ? n++ : n - 1;
        for (; at > 0 && before(c, sorted[at - 1]); at--)
            sorted[at] = sorted[at - 1];
        sorted[at] = c;
    }
    return n;
}

void rmap_detect_free(const struct rmap_scene *scene, const struct rmap_leg *leg,
                      struct rmap_recorder *recorder)
{
    if (scene->n_free_detector == 0)
        return;
    struct crossing sorted[SORTED_MAX], last = {-1.0, -1};
    int n;
    do {
        n = nearest_crossings(scene, leg, last, sorted);
        for (int i = 0; i < n; i++)
            register_plane(scene, leg, sorted[i].detector,
                           rmap_axpy(sorted[i].distance, leg->direction, leg->from),
                           sorted[i].distance, recorder);
        if (n > 0)
            last = sorted[n - 1];
    } while (n == SORTED_MAX);
}

void rmap_detect_on(const struct rmap_scene *scene, const struct rmap_leg *leg, int32_t object,
                    struct rmap_recorder *recorder)
{
    for (size_t k = scene->on_first[object]; k < scene->on_first[object + 1]; k++)
        register_plane(scene, leg, scene->on_detector[k], leg->to, leg->length, recorder);
}

void rmap_detect_far(const struct rmap_scene *scene, const struct rmap_leg *leg,
                     struct rmap_recorder *recorder)
{
    for (size_t k = 0; k < scene->n_far_detector; k++) {
        int32_t index = scene->far_detector[k];
        const struct rmap_detector *detector = &scene->detector[index];
        double cosine = rmap_dot(leg->direction, detector->axis), theta = rmap_angle_of(cosine);
        double phi =
            atan2(rmap_dot(leg->direction, detector->y), rmap_dot(leg->direction, detector->x));
        if (phi < 0.0)
            phi += 2.0 * RMAP_PI;
        struct rmap_registration registration = {
            .detector = index,
            .segment = leg->segment,
            .relative = {theta / RMAP_PI, phi / (2.0 * RMAP_PI)},
            .position = leg->to,
            .direction = leg->direction,
            .cosine = cosine,
            .optical_path = leg->optical_from};
        registration.registered = accepts_angle(detector, cosine);
        place(detector, &registration);
        recorder->registration(recorder, &registration);
    }
}

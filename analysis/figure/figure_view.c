/* SPDX-License-Identifier: MIT
 *
 * How a scene is looked at: along an axis, cut by a plane, or from above at an angle, by parallel
 * projection, so that lengths can be measured; or by a camera, in perspective.
 */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/figure/figure_view.h"
#include "base/alloc.h"

/* Views in perspective. Right and up over the distance, and 1 over the distance: lines stay lines,
 * and depth is linear along them. */

/* Nearer to the eye than this part of the scene's radius nothing is drawn. */
static const double NEAREST = 1e-3;

/* Lines are cut off so far outside the picture, in its own size. */
static const double AROUND = 1.1;

void rmap_view_camera(const struct rmap_scene *scene, const struct rmap_camera *camera,
                      struct rmap_view *view)
{
    *view = (struct rmap_view){.perspective = true,
                               .right = camera->right,
                               .up = camera->up,
                               .toward = rmap_scale(camera->forward, -1.0),
                               .offset = -rmap_dot(camera->at, camera->forward),
                               .eye = camera->at,
                               .nearest = NEAREST * scene->radius};
    view->slope[1] = camera->slope;
    view->slope[0] = camera->slope * camera->resolution[0] / camera->resolution[1];
    (void)snprintf(view->description, sizeof view->description, "seen by camera %.40s, %.3g° high",
                   camera->name, 2.0 * atan(camera->slope) * 180.0 / RMAP_PI);
}

struct rmap_vec3 rmap_view_place(const struct rmap_view *view, struct rmap_vec3 point)
{
    if (view->perspective)
        point = rmap_sub(point, view->eye);
    return rmap_vec3(rmap_dot(point, view->right), rmap_dot(point, view->up),
                     rmap_dot(point, view->toward) - (view->perspective ? 0.0 : view->offset));
}

struct rmap_vec3 rmap_view_flatten(const struct rmap_view *view, struct rmap_vec3 place)
{
    return view->perspective ? rmap_vec3(place.x / -place.z, place.y / -place.z, 1.0 / -place.z)
                             : place;
}

struct rmap_vec3 rmap_view_project(const struct rmap_view *view, struct rmap_vec3 point)
{
    return rmap_view_flatten(view, rmap_view_place(view, point));
}

/* How far a place lies inside the k-th of the planes about what is seen. */
static double inside(const struct rmap_view *view, struct rmap_vec3 place, int k)
{
    const double distance = -place.z;
    const double wide = AROUND * view->slope[0] * distance;
    const double high = AROUND * view->slope[1] * distance;
    const double value[] = {distance - view->nearest, wide - place.x, wide + place.x,
                            high - place.y, high + place.y};
    return value[k];
}
enum { N_PLANE = 5 };

bool rmap_view_clip(const struct rmap_view *view, struct rmap_vec3 *from, struct rmap_vec3 *to)
{
    if (!view->perspective)
        return true;
    const struct rmap_vec3 a = rmap_view_place(view, *from), b = rmap_view_place(view, *to);
    const struct rmap_vec3 start = *from, along = rmap_sub(*to, *from);
    double first = 0.0, last = 1.0;
    for (int k = 0; k < N_PLANE; k++) {
        const double u = inside(view, a, k), v = inside(view, b, k);
        if (u < 0.0 && v < 0.0)
            return false;
        if (u < 0.0)
            first = fmax(first, u / (u - v));
        else if (v < 0.0)
            last = fmin(last, u / (u - v));
    }
    *from = rmap_axpy(first, along, start);
    *to = last < 1.0 ? rmap_axpy(last, along, start) : *to;
    return first < last;
}

bool rmap_view_sees(const struct rmap_view *view, struct rmap_vec3 point)
{
    const struct rmap_vec3 place = rmap_view_place(view, point);
    for (int k = 0; view->perspective && k < N_PLANE; k++)
        if (!(inside(view, place, k) >= 0.0))
            return false;
    return true;
}

double rmap_view_distance(const struct rmap_view *view, double height)
{
    return view->perspective ? 1.0 / height : -height;
}

/* Where the eye stands in a 3-d view: degrees from +x towards +y, and above the ground. */
static const double AZIMUTH_DEG = -62.0, ELEVATION_DEG = 28.0;

/* A source further from the objects than this part of their size is left out. */
static const double NEAR_SOURCE = 1.5;

void rmap_view_pixel(const struct rmap_view_frame *frame, const double coordinates[2],
                     double pixel[2])
{
    pixel[0] = frame->x + 0.5 * frame->width + frame->scale * (coordinates[0] - frame->centre[0]);
    pixel[1] = frame->y + 0.5 * frame->height -
               frame->scale * frame->stretch * (coordinates[1] - frame->centre[1]);
}

static int ascending(const void *a, const void *b)
{
    double left = *(const double *)a, right = *(const double *)b;
    return (left > right) - (left < right);
}

static bool about_axis(const struct rmap_scene *scene, size_t object)
{
    const struct rmap_geometry *geometry = &scene->geometry[scene->object[object].geometry];
    return geometry->kind == RMAP_GEOMETRY_SHAPE && rmap_shape_model[geometry->shape.type].revolved;
}

/* The plane that most axes lie in: the median place of surfaces of revolution, else the scene's
 * centre. */
static double axis_offset(const struct rmap_scene *scene, struct rmap_vec3 toward)
{
    double *place = rmap_alloc(scene->n_object + 1, sizeof *place);
    double offset = rmap_dot(scene->centre, toward);
    size_t n = 0;
    for (size_t o = 0; place && o < scene->n_object; o++)
        if (about_axis(scene, o))
            place[n++] = rmap_dot(scene->object[o].to_world.t, toward);
    if (n > 0) {
        qsort(place, n, sizeof *place, ascending);
        offset = place[n / 2];
    }
    rmap_free(place);
    return offset + 0.0; /* no -0 */
}

static bool is_of_bodies(const struct rmap_scene *scene)
{
    size_t n_mesh = 0;
    for (size_t o = 0; o < scene->n_object; o++)
        n_mesh += scene->geometry[scene->object[o].geometry].kind == RMAP_GEOMETRY_MESH;
    return 2 * n_mesh > scene->n_object;
}

/* What a camera's pictures have upwards is at right angles to what they have to the right. */
bool rmap_view_has_z_upright(const struct rmap_scene *scene)
{
    const double level = 1e-6;
    if (scene->n_camera == 0)
        return is_of_bodies(scene);
    const struct rmap_camera *camera = &scene->camera[0];
    const bool z_may_be = fabs(camera->right.z) < level, y_may_be = fabs(camera->right.y) < level;
    if (z_may_be != y_may_be)
        return z_may_be;
    return fabs(camera->up.z) >= fabs(camera->up.y);
}

/* Of the two sections through the z axis, the one that the rays start along; y-z in doubt. */
static enum rmap_view_kind best_section(const struct rmap_portion *rays)
{
    double x = 0.0, y = 0.0;
    size_t segment = 0, n_ray = rays ? rays->n_row[RMAP_TABLE_RAY] : 0;
    for (size_t i = 0; i < n_ray; i++) {
        const float *from = rays->ray.start + 3 * i, *to = rays->segment.position + 3 * segment;
        if (rays->ray.segment_count[i] > 0) {
            double dx = (double)(to[0] - from[0]), dy = (double)(to[1] - from[1]);
            double length = sqrt(dx * dx + dy * dy + pow((double)(to[2] - from[2]), 2.0));
            x += length > 0.0 ? dx / length : 0.0;
            y += length > 0.0 ? dy / length : 0.0;
        }
        segment += rays->ray.segment_count[i];
    }
    /* A mean below a few standard errors of random directions says nothing. */
    return fabs(x) > fabs(y) + 0.01 * (double)n_ray ? RMAP_VIEW_XZ : RMAP_VIEW_YZ;
}

/* Bodies stand on the x-y plane, z upwards; optics lies along z, y upwards. */
void rmap_view_turn(const struct rmap_scene *scene, double azimuth_deg, double elevation_deg,
                    struct rmap_view *view)
{
    double azimuth = azimuth_deg * RMAP_PI / 180.0, height = elevation_deg * RMAP_PI / 180.0;
    double ahead = cos(azimuth), aside = sin(azimuth), level = cos(height), above = sin(height);
    bool bodies = rmap_view_has_z_upright(scene);
    view->toward = bodies ? rmap_vec3(level * ahead, level * aside, above)
                          : rmap_vec3(level * aside, above, -level * ahead);
    view->right = bodies ? rmap_vec3(-aside, ahead, 0) : rmap_vec3(-ahead, 0, -aside);
    view->up = rmap_cross(view->toward, view->right);
    (void)snprintf(view->description, sizeof view->description, "seen from %.0f° above",
                   elevation_deg);
}

static void describe_section(const struct rmap_scene *scene, struct rmap_view *view)
{
    const double sum = view->toward.x + view->toward.y + view->toward.z;
    const char axis = view->toward.x != 0.0 ? 'x' : view->toward.y != 0.0 ? 'y' : 'z';
    (void)snprintf(view->description, sizeof view->description, "section at %c = %.4g %s", axis,
                   sum * view->offset + 0.0, scene->unit);
}

bool rmap_view_meets(const struct rmap_scene *scene, const struct rmap_view *view, size_t object)
{
    const double slack = 1e-9 * scene->radius; /* of what lies in the plane */
    struct rmap_vec3 lower, upper;
    double low = HUGE_VAL, high = -HUGE_VAL;
    rmap_geometry_bounds(&scene->geometry[scene->object[object].geometry], &lower, &upper);
    for (int k = 0; k < 8; k++) {
        const struct rmap_vec3 corner = rmap_vec3(
            k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y, k & 4 ? upper.z : lower.z);
        const double at =
            rmap_dot(rmap_affine_point(&scene->object[object].to_world, corner), view->toward) -
            view->offset;
        low = fmin(low, at);
        high = fmax(high, at);
    }
    return low <= slack && high >= -slack;
}

bool rmap_view_meets_objects(const struct rmap_scene *scene, const struct rmap_view *view)
{
    for (size_t o = 0; o < scene->n_object; o++)
        if (rmap_view_meets(scene, view, o))
            return true;
    return false;
}

void rmap_view_move(const struct rmap_scene *scene, double place, struct rmap_view *view)
{
    view->offset = (view->toward.x + view->toward.y + view->toward.z) * place;
    describe_section(scene, view);
    const size_t len = strlen(view->description);
    if (!rmap_view_meets_objects(scene, view))
        (void)snprintf(view->description + len, sizeof view->description - len,
                       ", where no object is");
}

enum rmap_view_kind rmap_view_resolve(const struct rmap_scene *scene, enum rmap_view_kind kind,
                                      const struct rmap_portion *rays)
{
    return kind != RMAP_VIEW_AUTO ? kind : is_of_bodies(scene) ? RMAP_VIEW_3D : best_section(rays);
}

void rmap_view_choose(const struct rmap_scene *scene, enum rmap_view_kind kind,
                      const struct rmap_portion *rays, struct rmap_view *view)
{
    static const struct rmap_vec3 axis[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    kind = rmap_view_resolve(scene, kind, rays);
    *view = (struct rmap_view){.section = kind != RMAP_VIEW_3D};
    if (kind == RMAP_VIEW_3D) {
        rmap_view_turn(scene, AZIMUTH_DEG, ELEVATION_DEG, view);
        return;
    }
    const bool upright = kind != RMAP_VIEW_XY && rmap_view_has_z_upright(scene);
    const struct rmap_vec3 other = kind == RMAP_VIEW_YZ ? axis[1] : axis[0]; /* than z */
    view->right = kind == RMAP_VIEW_XY || upright ? other : axis[2];
    view->up = kind == RMAP_VIEW_XY ? axis[1] : upright ? axis[2] : other;
    view->toward = rmap_cross(view->right, view->up);
    view->offset = axis_offset(scene, view->toward);
    describe_section(scene, view);
}

static void cover(struct rmap_view_box *box, const struct rmap_view *view, struct rmap_vec3 point)
{
    struct rmap_vec3 p = rmap_view_project(view, point);
    box->low[0] = fmin(box->low[0], p.x);
    box->low[1] = fmin(box->low[1], p.y);
    box->high[0] = fmax(box->high[0], p.x);
    box->high[1] = fmax(box->high[1], p.y);
}

static void cover_corners(struct rmap_view_box *box, const struct rmap_view *view,
                          const struct rmap_affine *to_world, struct rmap_vec3 lower,
                          struct rmap_vec3 upper)
{
    for (int k = 0; k < 8; k++)
        cover(box, view,
              rmap_affine_point(to_world,
                                rmap_vec3(k & 1 ? upper.x : lower.x, k & 2 ? upper.y : lower.y,
                                          k & 4 ? upper.z : lower.z)));
}

void rmap_view_cover_object(const struct rmap_scene *scene, const struct rmap_view *view,
                            size_t object, struct rmap_view_box *box)
{
    struct rmap_vec3 lower, upper;
    rmap_geometry_bounds(&scene->geometry[scene->object[object].geometry], &lower, &upper);
    cover_corners(box, view, &scene->object[object].to_world, lower, upper);
}

/* What sends light. */
static void cover_emitter(const struct rmap_source *source, const struct rmap_view *view,
                          struct rmap_view_box *box)
{
    const struct rmap_vec3 half = rmap_source_half_size(source);
    cover_corners(box, view, &source->frame, rmap_scale(half, -1.0), half);
}

static void cover_sources(const struct rmap_scene *scene, const struct rmap_view *view,
                          struct rmap_view_box *box)
{
    struct rmap_view_box wide = *box;
    for (int k = 0; k < 2; k++) {
        double reach = NEAR_SOURCE * fmax(box->high[0] - box->low[0], box->high[1] - box->low[1]);
        wide.low[k] -= reach;
        wide.high[k] += reach;
    }
    for (size_t s = 0; s < scene->n_source; s++) {
        struct rmap_vec3 p = rmap_view_project(view, scene->source[s].frame.t);
        if (p.x >= wide.low[0] && p.x <= wide.high[0] && p.y >= wide.low[1] && p.y <= wide.high[1])
            cover_emitter(&scene->source[s], view, box);
    }
}

void rmap_view_bounds(const struct rmap_scene *scene, const struct rmap_view *view,
                      struct rmap_view_box *box)
{
    *box = RMAP_VIEW_BOX_EMPTY;
    for (size_t o = 0; o < scene->n_object; o++)
        rmap_view_cover_object(scene, view, o, box);
    for (size_t d = 0; d < scene->n_detector; d++) {
        const struct rmap_detector *detector = &scene->detector[d];
        if (detector->type != RMAP_DETECTOR_PLANE)
            continue;
        for (int k = 0; k < 4; k++)
            cover(box, view,
                  rmap_axpy(k & 1 ? 0.5 * detector->size[0] : -0.5 * detector->size[0], detector->x,
                            rmap_axpy(k & 2 ? 0.5 * detector->size[1] : -0.5 * detector->size[1],
                                      detector->y, detector->origin)));
    }
    if (box->low[0] > box->high[0])
        for (int k = 0; k < 2; k++) {
            struct rmap_vec3 centre = rmap_view_project(view, scene->centre);
            box->low[k] = (k ? centre.y : centre.x) - scene->radius;
            box->high[k] = (k ? centre.y : centre.x) + scene->radius;
        }
    cover_sources(scene, view, box);
}

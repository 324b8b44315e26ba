/* SPDX-License-Identifier: MIT
 *
 * Views in perspective. Right and up over the distance, and 1 over the distance: lines stay lines,
 * and depth is linear along them.
 */
#include <math.h>
#include <stdio.h>

#include "analysis/figure/figure_view.h"

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

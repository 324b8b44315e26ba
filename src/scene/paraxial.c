/* SPDX-License-Identifier: MIT
 *
 * First-order properties of a lens.
 */
#include "scene/paraxial.h"

#include <math.h>
#include <stdlib.h>

enum { SURFACES_MAX = 256 };

/* In the order of their vertices. Of a stop the curvature is 0 and both indices are equal. */
struct vertex {
    int32_t object;
    double z, curvature, aperture; /* in the meridian */
    double before, after;          /* refractive indices */
    bool is_stop;
};

struct train {
    struct vertex vertex[SURFACES_MAX];
    size_t n, n_stop;
    struct rmap_vec3 origin, axis, across[2]; /* x and y of the first */
    double scale;
    int meridian; /* 0: along x; 1: along y */
};

/* (y, n u) before to those after. */
struct matrix {
    double a, b, c, d;
};

/* Whether the object stands on the axis of those before it. */
static bool on_axis(struct train *train, const struct rmap_affine *frame)
{
    const struct rmap_vec3 column = rmap_affine_vector(frame, rmap_vec3(0, 0, 1));
    const double scale = rmap_length(column);
    const struct rmap_vec3 axis = rmap_scale(column, 1.0 / scale);
    if (train->n == 0) {
        train->origin = frame->t;
        train->axis = axis;
        train->scale = scale;
        train->across[0] = rmap_normalize(rmap_affine_vector(frame, rmap_vec3(1, 0, 0)));
        train->across[1] = rmap_cross(axis, train->across[0]);
    }
    const struct rmap_vec3 from = rmap_sub(frame->t, train->origin);
    const double along = rmap_dot(from, train->axis);
    const double off = rmap_length(rmap_sub(from, rmap_scale(train->axis, along)));
    return rmap_dot(axis, train->axis) > 1.0 - 1e-12 && off < 1e-9 * (scale + fabs(along)) &&
           fabs(scale - train->scale) < 1e-12 * scale;
}

static double index_of(const struct rmap_scene *scene, int32_t medium, int channel)
{
    return scene->medium[medium].n[channel];
}

/* What a surface is in the meridian: curvature and half width. False: the meridians mix. */
static bool set_profile(const struct train *train, const struct rmap_object *object,
                        const struct rmap_shape *shape, const double bend[3], struct vertex *vertex)
{
    const double scale = train->scale, size = fabs(bend[0]) + fabs(bend[2]), skewed = 1e-9;
    struct rmap_vec3 l[2];
    double second[2][2];
    for (int k = 0; k < 2; k++)
        l[k] = rmap_affine_vector(&object->to_local, train->across[k]);
    for (int i = 0; i < 2; i++)
        for (int k = 0; k < 2; k++)
            second[i][k] = bend[0] * l[i].x * l[k].x + bend[2] * l[i].y * l[k].y +
                           bend[1] * (l[i].x * l[k].y + l[i].y * l[k].x);
    const struct rmap_vec3 *its = &l[train->meridian];
    const bool round = fabs(bend[0] - bend[2]) + fabs(bend[1]) <= skewed * size &&
                       fabs(rmap_dot(*its, *its) * scale * scale - 1.0) < 1e-12;
    vertex->curvature = round ? bend[0] / scale : scale * second[train->meridian][train->meridian];
    vertex->aperture = scale * shape->aperture;
    if (shape->type == RMAP_SHAPE_SAG)
        vertex->aperture = shape->outline.half[fabs(its->y) > fabs(its->x)] / rmap_length(*its);
    return round || fabs(second[0][1]) * scale * scale <= skewed * size;
}

/* False: nothing that a lens has. */
static bool add(struct train *train, const struct rmap_scene *scene, int32_t o, int channel)
{
    const struct rmap_object *object = &scene->object[o];
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    const struct rmap_shape *shape = &geometry->shape;
    if (geometry->kind != RMAP_GEOMETRY_SHAPE || object->gradient_front || object->gradient_back)
        return false;
    if (shape->type == RMAP_SHAPE_TUBE || shape->type == RMAP_SHAPE_WALL ||
        (shape->type == RMAP_SHAPE_DISC && !(shape->inner > 0.0)))
        return true; /* edges */
    const bool is_stop = shape->type == RMAP_SHAPE_DISC &&
                         object->medium_front == RMAP_MEDIUM_ANY &&
                         object->medium_back == RMAP_MEDIUM_ANY;
    if (shape->type == RMAP_SHAPE_DISC && !is_stop)
        return true;
    double bend[3] = {0.0, 0.0, 0.0};
    const bool refracts = rmap_shape_vertex(shape, bend) && object->medium_front >= 0 &&
                          object->medium_back >= 0 &&
                          rmap_scene_transmits(scene, object->surface_front);
    if ((!is_stop && !refracts) || train->n == SURFACES_MAX || !on_axis(train, &object->to_world))
        return false;
    const double scale = train->scale;
    struct vertex *vertex = &train->vertex[train->n++];
    *vertex = (struct vertex){
        .object = o,
        .z = rmap_dot(rmap_sub(object->to_world.t, train->origin), train->axis),
        .aperture = scale * shape->inner,
        .before = 1.0,
        .after = 1.0,
        .is_stop = is_stop,
    };
    train->n_stop += is_stop;
    if (is_stop)
        return true;
    vertex->before = index_of(scene, object->medium_back, channel);
    vertex->after = index_of(scene, object->medium_front, channel);
    return set_profile(train, object, shape, bend, vertex);
}

static int by_z(const void *a, const void *b)
{
    const double left = ((const struct vertex *)a)->z, right = ((const struct vertex *)b)->z;
    return (left > right) - (left < right);
}

static void refract(struct matrix *m, const struct vertex *v)
{
    const double power = v->is_stop ? 0.0 : v->curvature * (v->after - v->before);
    m->c -= power * m->a;
    m->d -= power * m->b;
}

static void transfer(struct matrix *m, double distance, double index)
{
    m->a += distance / index * m->c;
    m->b += distance / index * m->d;
}

/* From before vertex `first` to after `last`, which is behind it; index: before the first. */
static struct matrix system_of(const struct train *train, size_t first, size_t last, double *index)
{
    struct matrix m = {1.0, 0.0, 0.0, 1.0};
    for (size_t k = first; k <= last; k++) {
        const struct vertex *v = &train->vertex[k];
        if (k > first)
            transfer(&m, v->z - train->vertex[k - 1].z, *index);
        refract(&m, v);
        if (!v->is_stop)
            *index = v->after;
    }
    return m;
}

/* To a vertex, before it refracts. */
static struct matrix until(const struct train *train, size_t k, double index)
{
    struct matrix m = {1.0, 0.0, 0.0, 1.0};
    if (k == 0)
        return m;
    m = system_of(train, 0, k - 1, &index);
    transfer(&m, train->vertex[k].z - train->vertex[k - 1].z, index);
    return m;
}

/* The stop, or the vertex whose rim an axial beam meets first. */
static size_t find_stop(const struct train *train, double index)
{
    size_t stop = 0;
    double most = 0.0;
    for (size_t k = 0; k < train->n; k++) {
        const double height = fabs(until(train, k, index).a) / train->vertex[k].aperture;
        const bool limits = train->n_stop > 0 ? train->vertex[k].is_stop : true;
        if (limits && height > most) {
            most = height;
            stop = k;
        }
    }
    return stop;
}

/* Slopes of chief rays: the steepest that all apertures let through, before the lens. */
static double find_field(const struct train *train, double entrance, double index)
{
    double most = HUGE_VAL;
    for (size_t k = 0; k < train->n; k++) {
        const struct matrix m = until(train, k, index);
        const double height = fabs(-m.a * entrance + m.b * index); /* of slope 1 */
        if (height > 1e-12 * train->vertex[k].aperture)
            most = fmin(most, train->vertex[k].aperture / height);
    }
    return atan(most) * 180.0 / RMAP_PI;
}

static void solve(const struct train *train, struct rmap_paraxial *out)
{
    const double before = out->index[0], after = out->index[1];
    double index = before;
    const struct matrix m = system_of(train, 0, train->n - 1, &index);
    const size_t stop = find_stop(train, before);
    const double radius = train->vertex[stop].aperture;
    const struct matrix front = until(train, stop, before);
    const struct vertex *at = &train->vertex[stop];
    double inside = before;
    for (size_t k = 0; k < stop; k++)
        inside = train->vertex[k].is_stop ? inside : train->vertex[k].after;
    const struct matrix rear = system_of(train, stop, train->n - 1, &inside);
    out->focal_length = -after / m.c;
    out->back_focus = -after * m.a / m.c;
    out->front_focus = before * m.d / m.c;
    out->stop = at->object;
    out->entrance = before * front.b / front.a;
    out->entrance_diameter = 2.0 * radius / fabs(front.a);
    out->exit = -after * rear.b / rear.d;
    out->exit_diameter = 2.0 * radius / fabs(rear.d);
    out->f_number = fabs(out->focal_length) / out->entrance_diameter;
    out->field_deg = find_field(train, out->entrance, before);
}

static bool is_within(const struct rmap_scene *scene, int32_t inner, int32_t group)
{
    while (inner >= 0 && inner != group)
        inner = scene->group[inner].parent;
    return inner == group;
}

static bool solve_meridian(const struct rmap_scene *scene, int32_t group, int channel, int meridian,
                           struct rmap_paraxial *out)
{
    struct train train = {.n = 0, .meridian = meridian};
    *out = (struct rmap_paraxial){.n_surface = 0};
    for (size_t o = 0; o < scene->n_object; o++)
        if (is_within(scene, scene->object[o].parent, group) &&
            !add(&train, scene, (int32_t)o, channel))
            return false;
    out->n_surface = train.n - train.n_stop;
    if (out->n_surface == 0)
        return false;
    qsort(train.vertex, train.n, sizeof *train.vertex, by_z);
    const struct vertex *first = NULL, *last = NULL;
    for (size_t k = 0; k < train.n; k++) {
        const struct vertex *v = &train.vertex[k];
        if (v->is_stop)
            continue;
        if (last && fabs(last->after - v->before) > 1e-12)
            return false; /* bodies that stand in each other */
        first = first ? first : v;
        last = v;
    }
    out->index[0] = first->before;
    out->index[1] = last->after;
    solve(&train, out);
    return true;
}

static bool alike(const struct rmap_paraxial *p)
{
    const double x[] = {p[0].focal_length,  p[0].back_focus,        p[0].front_focus,
                        p[0].entrance,      p[0].entrance_diameter, p[0].exit,
                        p[0].exit_diameter, p[0].field_deg};
    const double y[] = {p[1].focal_length,  p[1].back_focus,        p[1].front_focus,
                        p[1].entrance,      p[1].entrance_diameter, p[1].exit,
                        p[1].exit_diameter, p[1].field_deg};
    for (size_t k = 0; k < sizeof x / sizeof *x; k++)
        if (!(x[k] == y[k] || fabs(x[k] - y[k]) <= 1e-9 * fabs(x[k])))
            return false;
    return true;
}

int rmap_paraxial_of(const struct rmap_scene *scene, int32_t group, int channel,
                     struct rmap_paraxial paraxial[2])
{
    for (int k = 0; k < 2; k++)
        if (!solve_meridian(scene, group, channel, k, &paraxial[k]))
            return 0;
    return alike(paraxial) ? 1 : 2;
}

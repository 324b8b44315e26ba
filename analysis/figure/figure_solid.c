/* SPDX-License-Identifier: MIT
 *
 * Faces of bodies, put into layers one after the other.
 */
#include "analysis/figure/figure_layers.h"
#include "base/alloc.h"

/* An object that spans this part of the scene in two directions encloses it. */
static const double ENCLOSING = 0.7;

struct body {
    const struct rmap_mesh *mesh;
    uint32_t object;
    bool encloses;
    struct rmap_vec3 *corner; /* [n_vertex] canvas x, y (down), and depth in length units */
    struct rmap_vec3 *place;  /* [n_vertex] view coordinates */
    struct rmap_vec3 centre;  /* of the scene, view coordinates */
};

/* Is this face of an enclosing body between the eye and the scene? facing: cosine of the angle
 * between its normal and the line to the eye. */
static bool hides_scene(const struct body *body, const uint32_t *t, struct rmap_vec3 normal,
                        double facing)
{
    struct rmap_vec3 out = rmap_sub(body->place[t[0]], body->centre);
    return rmap_dot(out, normal) > 0.0 ? facing > 0.02 : facing < -0.02;
}

/* Pixel of the layers and depth of a place in front of the eye. */
static struct rmap_vec3 corner_of(const struct rmap_solid *canvas, struct rmap_vec3 place)
{
    const struct rmap_view_frame *frame = canvas->frame;
    const struct rmap_vec3 p = rmap_view_flatten(frame->view, place);
    double pixel[2];
    rmap_view_pixel(frame, (const double[2]){p.x, p.y}, pixel);
    return rmap_vec3((pixel[0] - frame->x) * canvas->scale, (pixel[1] - frame->y) * canvas->scale,
                     p.z);
}

/* What lies in front of the eye of a triangle that does so in part: one or two triangles. */
static void fill_cut(struct rmap_solid *canvas, const struct rmap_vec3 place[3],
                     const struct rmap_solid_pixel *kind)
{
    const double nearest = canvas->frame->view->nearest;
    struct rmap_vec3 c[4];
    size_t n = 0;
    for (int k = 0; k < 3; k++) {
        const struct rmap_vec3 p = place[k], q = place[(k + 1) % 3];
        const double u = -p.z - nearest, v = -q.z - nearest;
        if (u >= 0.0)
            c[n++] = corner_of(canvas, p);
        if ((u >= 0.0) != (v >= 0.0))
            c[n++] = corner_of(canvas, rmap_axpy(u / (u - v), rmap_sub(q, p), p));
    }
    for (size_t k = 2; k < n; k++)
        rmap_solid_fill(canvas, (const struct rmap_vec3[3]){c[0], c[k - 1], c[k]}, kind);
}

static void draw_face(struct rmap_solid *canvas, const struct body *body, const uint32_t *t,
                      const struct rmap_solid_pixel *kind)
{
    const struct rmap_view *view = canvas->frame->view;
    const struct rmap_vec3 place[3] = {body->place[t[0]], body->place[t[1]], body->place[t[2]]};
    const struct rmap_vec3 c[3] = {body->corner[t[0]], body->corner[t[1]], body->corner[t[2]]};
    bool whole = true;
    for (int k = 0; view->perspective && k < 3; k++)
        whole = whole && -place[k].z >= view->nearest;
    if (whole)
        rmap_solid_fill(canvas, c, kind);
    else
        fill_cut(canvas, place, kind);
}

/* Of the face's first corner. */
static double cosine_to_eye(const struct rmap_view *view, struct rmap_vec3 normal,
                            struct rmap_vec3 place)
{
    if (!view->perspective)
        return normal.z;
    const double distance = rmap_length(place);
    return distance > 0.0 ? -rmap_dot(normal, place) / distance : normal.z;
}

static void draw_body(struct rmap_solid *canvas, const struct body *body)
{
    static const struct rmap_vec3 light = {-0.35, 0.55, 0.758};
    for (size_t i = 0; i < body->mesh->n_triangle; i++) {
        const uint32_t *t = body->mesh->triangle[i];
        struct rmap_vec3 normal = rmap_cross(rmap_sub(body->place[t[1]], body->place[t[0]]),
                                             rmap_sub(body->place[t[2]], body->place[t[0]]));
        double length = rmap_length(normal);
        if (!(length > 0.0))
            continue;
        normal = rmap_scale(normal, 1.0 / length);
        const double facing = cosine_to_eye(canvas->frame->view, normal, body->place[t[0]]);
        if (body->encloses && hides_scene(body, t, normal, facing))
            continue;
        if (facing < 0.0) /* the side that is seen */
            normal = rmap_scale(normal, -1.0);
        struct rmap_solid_pixel kind = {
            .object = body->object,
            .normal = {(int8_t)(127 * normal.x), (int8_t)(127 * normal.y),
                       (int8_t)(127 * normal.z)},
            .shade = (uint8_t)(255 * fmax(rmap_dot(normal, light), 0.0))};
        draw_face(canvas, body, t, &kind);
    }
}

struct extent {
    struct rmap_vec3 low, high;
};

static void widen(struct extent *extent, struct rmap_vec3 p)
{
    extent->low = rmap_least(extent->low, p);
    extent->high = rmap_greatest(extent->high, p);
}

static struct rmap_vec3 vertex_of(const struct rmap_mesh *mesh, size_t i,
                                  const struct rmap_affine *to_world)
{
    const float *v = mesh->vertex[i];
    return rmap_affine_point(to_world, rmap_vec3((double)v[0], (double)v[1], (double)v[2]));
}

static void object_extent(const struct rmap_scene *scene, size_t object,
                          const struct rmap_mesh *mesh, struct extent *extent)
{
    for (size_t i = 0; i < mesh->n_vertex; i++)
        widen(extent, vertex_of(mesh, i, &scene->object[object].to_world));
}

static const struct extent empty = {{INFINITY, INFINITY, INFINITY},
                                    {-INFINITY, -INFINITY, -INFINITY}};

static bool encloses(const struct extent *object, const struct extent *scene)
{
    struct rmap_vec3 a = rmap_sub(object->high, object->low), b = rmap_sub(scene->high, scene->low);
    return (a.x >= ENCLOSING * b.x) + (a.y >= ENCLOSING * b.y) + (a.z >= ENCLOSING * b.z) >= 2;
}

static enum rmap_status draw_object(const struct rmap_scene *scene, size_t object,
                                    const struct rmap_mesh *mesh, const struct extent *whole,
                                    const struct rmap_view_frame *frame, struct rmap_solid *canvas,
                                    struct rmap_error *err)
{
    struct extent own = empty;
    struct body body = {
        .mesh = mesh,
        .object = (uint32_t)object,
        .corner = rmap_alloc(mesh->n_vertex + 1, sizeof *body.corner),
        .place = rmap_alloc(mesh->n_vertex + 1, sizeof *body.place),
        .centre = rmap_view_place(frame->view, rmap_scale(rmap_add(whole->low, whole->high), 0.5))};
    enum rmap_status st = RMAP_OK;
    if (!body.corner || !body.place)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    object_extent(scene, object, mesh, &own);
    body.encloses = encloses(&own, whole);
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        body.place[i] =
            rmap_view_place(frame->view, vertex_of(mesh, i, &scene->object[object].to_world));
        body.corner[i] = corner_of(canvas, body.place[i]);
    }
    draw_body(canvas, &body);
out:
    rmap_free(body.corner);
    rmap_free(body.place);
    return st;
}

enum rmap_status rmap_solid_create(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                   const struct rmap_view_frame *frame,
                                   struct rmap_solid **solid_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct extent whole = empty;
    struct rmap_solid *canvas = rmap_alloc(1, sizeof *canvas);
    if (!canvas)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    RMAP_TRY(rmap_solid_init(scene, frame, canvas, err));
    for (size_t o = 0; o < scene->n_object; o++)
        object_extent(scene, o, mesh[scene->object[o].geometry], &whole);
    for (size_t o = 0; o < scene->n_object; o++)
        RMAP_TRY(
            draw_object(scene, o, mesh[scene->object[o].geometry], &whole, frame, canvas, err));
    rmap_solid_find_depths(canvas);
    *solid_ret = canvas;
    canvas = NULL;
out:
    rmap_solid_destroy(canvas);
    return st;
}

void rmap_solid_destroy(struct rmap_solid *canvas)
{
    if (!canvas)
        return;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++)
        rmap_free(canvas->pixel[layer]);
    rmap_free(canvas);
}

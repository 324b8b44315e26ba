/* SPDX-License-Identifier: MIT
 *
 * Faces of bodies, put into layers one after the other.
 */
#include <string.h>

#include "analysis/figure/figure_detector.h"
#include "analysis/figure/figure_layers.h"
#include "analysis/figure/object_colour.h"
#include "base/alloc.h"
#include "io/export/raster.h"

/* Hidden surfaces by a depth buffer. Lines are drawn where the object changes between neighbouring
 * pixels or the normal turns by more than 20 degrees, then two by two pixels are averaged. The
 * result goes into the picture as one image. */

enum { OVERSAMPLING = 2 };

static const uint32_t NOTHING = UINT32_MAX;

static const double CREASE_COS = 0.9397; /* cos 20 degrees */

/* A face of glass covers what is behind it so far; and a point is behind a body when it is by more
 * than this part of the scene's depth: rays end on surfaces. */
static const double GLASS_COVER = 0.45, BEHIND = 0.006;

/* sRGB of a body on which lines are as dark as on paper. */
static const double WHITE_BODY = 0.94;

static bool is_glass(const struct rmap_scene *scene, size_t object)
{
    return rmap_object_look(scene, object) == RMAP_LOOK_REFRACTING;
}

static enum rmap_solid_layer layer_of(const struct rmap_scene *scene, size_t object)
{
    return is_glass(scene, object) ? RMAP_LAYER_GLASS : RMAP_LAYER_BODY;
}

static double edge(struct rmap_vec3 a, struct rmap_vec3 b, double x, double y)
{
    return (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
}

static int within(double pixel, int most)
{
    return (int)fmin(fmax(pixel, -1.0), most);
}

/* A triangle, by pixels of the layers and depths, where it is nearer than what is there. */
static void solid_fill(struct rmap_solid *canvas, const struct rmap_vec3 c[3],
                       const struct rmap_solid_pixel *kind)
{
    const enum rmap_solid_layer layer =
        kind->paint ? RMAP_LAYER_PAINTED : layer_of(canvas->scene, kind->object);
    double area = edge(c[0], c[1], c[2].x, c[2].y);
    if (!(fabs(area) > 0.0) || !isfinite(area))
        return;
    int x0 = within(floor(fmin(c[0].x, fmin(c[1].x, c[2].x))), canvas->width);
    int x1 = within(ceil(fmax(c[0].x, fmax(c[1].x, c[2].x))), canvas->width - 1);
    int y0 = within(floor(fmin(c[0].y, fmin(c[1].y, c[2].y))), canvas->height);
    int y1 = within(ceil(fmax(c[0].y, fmax(c[1].y, c[2].y))), canvas->height - 1);
    for (int y = y0 < 0 ? 0 : y0; y <= y1; y++)
        for (int x = x0 < 0 ? 0 : x0; x <= x1; x++) {
            double u = edge(c[1], c[2], x + 0.5, y + 0.5) / area;
            double v = edge(c[2], c[0], x + 0.5, y + 0.5) / area;
            if (u < 0.0 || v < 0.0 || u + v > 1.0)
                continue;
            float depth = (float)(u * c[0].z + v * c[1].z + (1.0 - u - v) * c[2].z);
            struct rmap_solid_pixel *at =
                &canvas->pixel[layer][(size_t)y * (size_t)canvas->width + (size_t)x];
            if (at->object != NOTHING && at->depth >= depth)
                continue;
            *at = *kind;
            at->depth = depth;
        }
}

static enum rmap_status clear_layers(struct rmap_solid *canvas, struct rmap_error *err)
{
    const size_t n_pixel = (size_t)canvas->width * (size_t)canvas->height;
    bool any[RMAP_LAYER_COUNT] = {
        [RMAP_LAYER_BODY] = true, [RMAP_LAYER_PAINTED] = canvas->painted != NULL};
    for (size_t o = 0; o < canvas->scene->n_object; o++)
        any[layer_of(canvas->scene, o)] = true;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++) {
        if (!any[layer])
            continue;
        canvas->pixel[layer] = rmap_alloc(n_pixel, sizeof(struct rmap_solid_pixel));
        if (!canvas->pixel[layer])
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
        for (size_t i = 0; i < n_pixel; i++)
            canvas->pixel[layer][i].object = NOTHING;
    }
    return RMAP_OK;
}

static enum rmap_status find_tints(struct rmap_solid *canvas, struct rmap_error *err)
{
    canvas->tint = rmap_object_colours(canvas->scene);
    if (!canvas->tint)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    for (size_t o = 0; o < canvas->scene->n_object; o++) {
        double tint[3];
        rmap_object_tint(rmap_object_look(canvas->scene, o), canvas->tint[o], tint);
        memcpy(canvas->tint[o], tint, sizeof tint);
    }
    return RMAP_OK;
}

/* Empty layers of the size of the frame. */
static enum rmap_status solid_init(const struct rmap_scene *scene,
                                   const struct rmap_painted *painted,
                                   const struct rmap_view_frame *frame, struct rmap_solid *canvas,
                                   struct rmap_error *err)
{
    *canvas = (struct rmap_solid){.scene = scene,
                                  .frame = frame,
                                  .painted = painted,
                                  .scale = RMAP_FIGURE_SCALE * OVERSAMPLING};
    canvas->width = OVERSAMPLING * (int)(frame->width * RMAP_FIGURE_SCALE);
    canvas->height = OVERSAMPLING * (int)(frame->height * RMAP_FIGURE_SCALE);
    const enum rmap_status st = find_tints(canvas, err);
    return st == RMAP_OK ? clear_layers(canvas, err) : st;
}

/* After the last one: how near and how far all of it is. */
static void solid_find_depths(struct rmap_solid *canvas)
{
    const size_t n_pixel = (size_t)canvas->width * (size_t)canvas->height;
    canvas->nearest = -INFINITY;
    canvas->farthest = INFINITY;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++)
        for (size_t i = 0; canvas->pixel[layer] && i < n_pixel; i++)
            if (canvas->pixel[layer][i].object != NOTHING) {
                canvas->nearest = fmaxf(canvas->nearest, canvas->pixel[layer][i].depth);
                canvas->farthest = fminf(canvas->farthest, canvas->pixel[layer][i].depth);
            }
}

/* Distance between the nearest and the farthest that is seen. */
static double range_of(const struct rmap_solid *canvas)
{
    const struct rmap_view *view = canvas->frame->view;
    return rmap_view_distance(view, (double)canvas->farthest) -
           rmap_view_distance(view, (double)canvas->nearest);
}

/* Does a line run between two neighbouring pixels? */
static bool parted(const struct rmap_solid_pixel *a, const struct rmap_solid_pixel *b)
{
    if (a->object != b->object)
        return true;
    if (a->object == NOTHING)
        return false;
    double cosine =
        (a->normal[0] * b->normal[0] + a->normal[1] * b->normal[1] + a->normal[2] * b->normal[2]) /
        (127.0 * 127.0);
    return cosine < CREASE_COS;
}

/* Face or line of one layer over what is there; what is far is lighter. */
static void cover(const struct rmap_solid *canvas, enum rmap_solid_layer layer, size_t x, size_t y,
                  double rgb[3])
{
    const size_t width = (size_t)canvas->width;
    const struct rmap_solid_pixel *at = &canvas->pixel[layer][y * width + x];
    const struct rmap_solid_pixel *right = x + 1 < width ? at + 1 : at;
    const struct rmap_solid_pixel *below = y + 1 < (size_t)canvas->height ? at + width : at;
    const struct rmap_solid_pixel *front =
        at->object == NOTHING ? right->object == NOTHING ? below : right : at;
    const struct rmap_solid_pixel *wall = &canvas->pixel[RMAP_LAYER_BODY][y * width + x];
    const bool is_line = parted(at, right) || parted(at, below);
    if (layer == RMAP_LAYER_PAINTED && !is_line) {
        const bool behind_line = wall->depth > at->depth && (parted(wall, wall + (right - at)) ||
                                                             parted(wall, wall + (below - at)));
        for (int k = 0; k < 3 && at->object != NOTHING && !behind_line; k++)
            rgb[k] = canvas->painted->rgb[at->paint - 1][k] / 255.0;
        return;
    }
    if (layer == RMAP_LAYER_GLASS && wall->object != NOTHING && wall->depth > front->depth)
        return;
    if (is_line) {
        const struct rmap_view *view = canvas->frame->view;
        double range = range_of(canvas);
        double far = range > 0.0 ? (rmap_view_distance(view, (double)front->depth) -
                                    rmap_view_distance(view, (double)canvas->nearest)) /
                                       range
                                 : 0.0;
        /* darker than the body whose face it is on, whatever its colour */
        const double *body = canvas->tint[front->object];
        const double part = layer == RMAP_LAYER_BODY
                                ? fmin(fmax(body[0], fmax(body[1], body[2])) / WHITE_BODY, 1.0)
                                : 1.0;
        for (int k = 0; k < 3; k++)
            rgb[k] = part * (0.35 + 0.33 * fmin(fmax(far, 0.0), 1.0));
        return;
    }
    if (at->object == NOTHING)
        return;
    const double *tint = canvas->tint[at->object];
    const double part = layer == RMAP_LAYER_GLASS ? GLASS_COVER : 1.0;
    for (int k = 0; k < 3; k++)
        rgb[k] += part * (tint[k] * (0.80 + 0.20 * at->shade / 255.0) - rgb[k]);
}

/* sRGB of a pixel of the layers on white paper. */
static void colour_of(const struct rmap_solid *canvas, size_t x, size_t y, double rgb[3])
{
    for (int k = 0; k < 3; k++)
        rgb[k] = 1.0;
    for (int layer = 0; layer < RMAP_LAYER_COUNT; layer++)
        if (canvas->pixel[layer])
            cover(canvas, (enum rmap_solid_layer)layer, x, y, rgb);
}

enum rmap_status rmap_solid_draw(const struct rmap_solid *canvas, struct rmap_svg *svg,
                                 struct rmap_error *err)
{
    const struct rmap_view_frame *frame = canvas->frame;
    size_t width = (size_t)canvas->width / OVERSAMPLING;
    size_t height = (size_t)canvas->height / OVERSAMPLING, nbytes = 0;
    uint8_t *rgb = rmap_alloc(width * height, 3), *png = NULL;
    if (!rgb)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    for (size_t i = 0; i < width * height; i++) {
        double sum[3] = {0.0, 0.0, 0.0}, part[3];
        for (size_t s = 0; s < OVERSAMPLING * OVERSAMPLING; s++) {
            colour_of(canvas, OVERSAMPLING * (i % width) + s % OVERSAMPLING,
                      OVERSAMPLING * (i / width) + s / OVERSAMPLING, part);
            for (int k = 0; k < 3; k++)
                sum[k] += part[k] / (OVERSAMPLING * OVERSAMPLING);
        }
        for (size_t k = 0; k < 3; k++)
            rgb[3 * i + k] = (uint8_t)(255.0 * sum[k] + 0.5);
    }
    enum rmap_status st =
        rmap_png_encode(rgb, (uint32_t)width, (uint32_t)height, &png, &nbytes, err);
    if (st == RMAP_OK)
        rmap_svg_image(svg, frame->x, frame->y, frame->width, frame->height, png, nbytes);
    rmap_free(png);
    rmap_free(rgb);
    return st;
}

bool rmap_solid_hides(const struct rmap_solid *canvas, double x, double y, double depth)
{
    const struct rmap_view *view = canvas->frame->view;
    const double i = floor((x - canvas->frame->x) * canvas->scale);
    const double j = floor((y - canvas->frame->y) * canvas->scale);
    if (!(i >= 0.0 && i < canvas->width && j >= 0.0 && j < canvas->height))
        return false;
    const struct rmap_solid_pixel *at =
        &canvas->pixel[RMAP_LAYER_BODY][(size_t)j * (size_t)canvas->width + (size_t)i];
    return at->object != NOTHING &&
           rmap_view_distance(view, depth) >
               rmap_view_distance(view, (double)at->depth) + BEHIND * range_of(canvas);
}

/* A plane that is painted alone is seen from both sides: a part of its size. */
static const double FLAT = 1e-3;

/* An object that spans this part of the scene in two directions encloses it. */
static const double ENCLOSING = 0.7;

struct body {
    const struct rmap_mesh *mesh;
    uint32_t object;
    bool painted; /* faces are cells */
    bool encloses;
    struct rmap_vec3 *corner; /* [n_vertex] canvas x, y (down), and depth in length units */
    struct rmap_vec3 *place;  /* [n_vertex] view coordinates */
    struct rmap_vec3 centre;  /* of the scene, view coordinates */
    double flat;              /* faces no further from it hide nothing */
};

/* Is this face of an enclosing body between the eye and the scene? facing: cosine of the angle
 * between its normal and the line to the eye. */
static bool hides_scene(const struct body *body, const uint32_t *t, struct rmap_vec3 normal,
                        double facing)
{
    struct rmap_vec3 out = rmap_sub(body->place[t[0]], body->centre);
    if (fabs(rmap_dot(out, normal)) < body->flat)
        return false;
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
        solid_fill(canvas, (const struct rmap_vec3[3]){c[0], c[k - 1], c[k]}, kind);
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
        solid_fill(canvas, c, kind);
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

/* Is the side seen that is not painted? */
static bool is_turned(const struct rmap_solid *canvas, const struct body *body, double facing)
{
    const enum rmap_side side = body->painted ? canvas->painted->side : RMAP_SIDE_BOTH;
    return (side == RMAP_SIDE_FRONT && facing < 0.0) || (side == RMAP_SIDE_BACK && facing > 0.0);
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
        if (is_turned(canvas, body, facing) ||
            (body->encloses && hides_scene(body, t, normal, facing)))
            continue;
        if (facing < 0.0) /* the side that is seen */
            normal = rmap_scale(normal, -1.0);
        struct rmap_solid_pixel kind = {
            .object = body->object,
            .paint = body->painted ? 1 + body->mesh->face[i] : 0,
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

/* Whether the middle of something else lies in its box. */
static bool holds_something(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                            size_t object, const struct extent *own)
{
    bool holds = false;
    for (size_t o = 0; o < scene->n_object && !holds; o++) {
        struct extent other = empty;
        object_extent(scene, o, mesh[scene->object[o].geometry], &other);
        const struct rmap_vec3 at = rmap_scale(rmap_add(other.low, other.high), 0.5);
        holds = o != object && at.x > own->low.x && at.x < own->high.x && at.y > own->low.y &&
                at.y < own->high.y && at.z > own->low.z && at.z < own->high.z;
    }
    return holds;
}

/* Its cells as triangles of a mesh in the world, whose faces they are. */
static enum rmap_status cells_mesh(const struct rmap_irradiance_cells *cells, size_t part,
                                   struct rmap_mesh **mesh_ret, struct rmap_error *err)
{
    const struct rmap_irradiance_part *of = &cells->part[part];
    struct rmap_mesh *mesh = NULL;
    size_t n = 0, n_triangle = 0;
    const struct rmap_irradiance_facet *facet = cells->facet + of->first_facet;
    for (size_t i = 0; i < of->n_facet; i++)
        n += facet[i].n_corner;
    const enum rmap_status st = rmap_mesh_create(n, n, 1, &mesh, err);
    if (st != RMAP_OK)
        return st;
    const size_t first = of->n_facet > 0 ? facet->corner : 0;
    for (size_t i = 0; i < n; i++) {
        const struct rmap_vec3 p = cells->corner[first + i];
        mesh->vertex[i][0] = (float)p.x;
        mesh->vertex[i][1] = (float)p.y;
        mesh->vertex[i][2] = (float)p.z;
    }
    for (size_t i = 0; i < of->n_facet; i++)
        for (uint32_t k = 2; k < facet[i].n_corner; k++, n_triangle++) {
            const uint32_t corner = (uint32_t)(facet[i].corner - first);
            mesh->triangle[n_triangle][0] = corner;
            mesh->triangle[n_triangle][1] = corner + k - 1;
            mesh->triangle[n_triangle][2] = corner + k;
            mesh->face[n_triangle] = facet[i].cell;
        }
    mesh->n_triangle = n_triangle;
    *mesh_ret = mesh;
    return RMAP_OK;
}

/* What is painted and no wall, or of one side, whose back nobody sees. */
static bool stays_in_sight(const struct rmap_solid *canvas, size_t object)
{
    const struct rmap_scene *scene = canvas->scene;
    const struct rmap_geometry *geometry = &scene->geometry[scene->object[object].geometry];
    return canvas->painted->side != RMAP_SIDE_BOTH ||
           (geometry->kind == RMAP_GEOMETRY_SHAPE &&
            rmap_shape_model[geometry->shape.type].revolved);
}

/* body: its mesh, of the geometry or of cells in the world, and what is said of it. whole: of all
 * objects, or of those that are painted. */
static enum rmap_status draw_object(struct body *body, const struct rmap_affine *to_world,
                                    const struct extent *whole, struct rmap_solid *canvas,
                                    struct rmap_error *err)
{
    const struct rmap_view *view = canvas->frame->view;
    const size_t n = body->mesh->n_vertex;
    enum rmap_status st = RMAP_OK;
    body->flat = body->painted ? FLAT * rmap_length(rmap_sub(whole->high, whole->low)) : 0.0;
    body->centre = rmap_view_place(view, rmap_scale(rmap_add(whole->low, whole->high), 0.5));
    body->corner = rmap_alloc(n + 1, sizeof *body->corner);
    body->place = rmap_alloc(n + 1, sizeof *body->place);
    if (!body->corner || !body->place)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing"));
    for (size_t i = 0; i < n; i++) {
        body->place[i] = rmap_view_place(view, vertex_of(body->mesh, i, to_world));
        body->corner[i] = corner_of(canvas, body->place[i]);
    }
    draw_body(canvas, body);
out:
    rmap_free(body->corner);
    rmap_free(body->place);
    return st;
}

static enum rmap_status draw_cells(size_t object, size_t part, const struct extent *whole,
                                   struct rmap_solid *canvas, struct rmap_error *err)
{
    struct rmap_mesh *mesh = NULL;
    struct extent own = empty;
    const struct rmap_affine in_place = rmap_affine_identity();
    enum rmap_status st = cells_mesh(canvas->painted->cells, part, &mesh, err);
    for (size_t i = 0; st == RMAP_OK && i < mesh->n_vertex; i++)
        widen(&own, vertex_of(mesh, i, &in_place));
    struct body body = {.mesh = mesh,
                        .object = (uint32_t)object,
                        .painted = true,
                        .encloses = encloses(&own, whole) && !stays_in_sight(canvas, object)};
    if (st == RMAP_OK)
        st = draw_object(&body, &in_place, whole, canvas, err);
    rmap_mesh_destroy(mesh);
    return st;
}

/* Glass hides nothing, and without light only what is in a body is to be seen through its walls. */
static enum rmap_status draw_solid(size_t object, struct rmap_mesh *const *mesh,
                                   const struct extent *whole, struct rmap_solid *canvas,
                                   struct rmap_error *err)
{
    const struct rmap_scene *scene = canvas->scene;
    const struct rmap_object *its = &scene->object[object];
    struct extent own = empty;
    object_extent(scene, object, mesh[its->geometry], &own);
    struct body body = {.mesh = mesh[its->geometry],
                        .object = (uint32_t)object,
                        .encloses =
                            encloses(&own, whole) && !is_glass(scene, object) &&
                            (scene->n_source > 0 || holds_something(scene, mesh, object, &own))};
    return draw_object(&body, &its->to_world, whole, canvas, err);
}

enum rmap_status rmap_solid_create(const struct rmap_scene *scene, struct rmap_mesh *const *mesh,
                                   const struct rmap_painted *painted,
                                   const struct rmap_view_frame *frame,
                                   struct rmap_solid **solid_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct extent whole = empty, painted_whole = empty;
    struct rmap_solid *canvas = rmap_alloc(1, sizeof *canvas);
    if (!canvas)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a drawing");
    RMAP_TRY(solid_init(scene, painted, frame, canvas, err));
    for (size_t o = 0; o < scene->n_object; o++) {
        object_extent(scene, o, mesh[scene->object[o].geometry], &whole);
        if (painted && painted->cells->part_of[o] >= 0)
            object_extent(scene, o, mesh[scene->object[o].geometry], &painted_whole);
    }
    for (size_t o = 0; o < scene->n_object; o++) {
        const int32_t part = painted ? painted->cells->part_of[o] : -1;
        if (part >= 0)
            RMAP_TRY(draw_cells(o, (size_t)part, &painted_whole, canvas, err));
        else
            RMAP_TRY(draw_solid(o, mesh, &whole, canvas, err));
    }
    solid_find_depths(canvas);
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
    rmap_free(canvas->tint);
    rmap_free(canvas);
}

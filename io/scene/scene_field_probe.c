/* SPDX-License-Identifier: MIT
 *
 * Gradient media are asked for an index on the surfaces that bound them, and inside closed bodies,
 * before light is: a scene whose medium has none there is told of it with the place.
 */
#include <math.h>
#include <string.h>

#include "base/grouped.h"
#include "geometry/sag.h"
#include "io/scene/scene_field_probe.h"
#include "io/scene/scene_reader.h"

enum { ROUND = 8, LEVELS = 5, MESH_POINT_MAX = 200, TRIANGLE_MAX = 1000000, OBJECT_MAX = 2000 };

/* What was found of one medium. */
struct finding {
    size_t n_asked, n_missing;
    struct rmap_vec3 first; /* missing: in the world */
    double n;               /* there; NaN: none */
    int32_t object;
};

struct probe {
    const struct rmap_scene *scene;
    const struct rmap_object *object;
    const struct rmap_gradient *gradient;
    struct finding *finding;
};

/* p: in the object's frame. The first, middle and last wavelength stand for all. */
static void ask(struct probe *probe, struct rmap_vec3 p)
{
    const struct rmap_gradient *gradient = probe->gradient;
    const int n_channel = gradient->field->n_channel;
    const int channel[3] = {0, n_channel / 2, n_channel - 1};
    struct rmap_vec3 world = rmap_affine_point(&probe->object->to_world, p), slope;
    struct rmap_vec3 place = rmap_affine_point(&gradient->to_local, world);
    struct finding *finding = probe->finding;
    finding->n_asked++;
    for (int i = 0; i < 3; i++) {
        double n = 0;
        if (rmap_field_at(gradient->field, channel[i], place, &n, &slope))
            continue;
        bool given = rmap_field_scalar(gradient->field, channel[i], place, &n, &slope);
        if (finding->n_missing++ == 0) {
            finding->first = world;
            finding->n = given ? n : (double)NAN;
            finding->object = (int32_t)(probe->object - probe->scene->object);
        }
        return;
    }
}

/* ---- places ---- */

/* A ring of points about z, at a height. */
static void ask_ring(struct probe *probe, double radius, double z)
{
    for (int i = 0; i < ROUND; i++) {
        double phi = 2 * RMAP_PI * (i + 0.25) / ROUND;
        ask(probe, rmap_vec3(radius * cos(phi), radius * sin(phi), z));
    }
}

/* Spheres of several radii, none at the centre: there a model may have a pole of no width. */
static void ask_sphere(struct probe *probe, double radius, bool inside)
{
    for (int shell = inside ? 1 : LEVELS; shell <= LEVELS; shell++) {
        double r = radius * shell / LEVELS;
        for (int i = 0; i < LEVELS; i++) {
            double angle = RMAP_PI * (i + 0.5) / LEVELS;
            ask_ring(probe, r * sin(angle), r * cos(angle));
        }
    }
}

/* Of a SAG a curve around it, of a WALL along it from one end to the other. */
static void ask_outline(struct probe *probe, const struct rmap_shape *shape, double t)
{
    for (int k = 0; k < ROUND; k++) {
        const bool wall = shape->type == RMAP_SHAPE_WALL;
        struct rmap_vec3 p =
            rmap_aperture_chart(&shape->outline, (k + 0.25) / ROUND, wall ? 0 : 1 - t);
        p.z = rmap_sag_height(shape->sag[0], p.x, p.y).z;
        if (wall)
            p.z += t * (shape->length + rmap_sag_height(shape->sag[1], p.x, p.y).z - p.z);
        ask(probe, p);
    }
}

static void ask_shape(struct probe *probe, const struct rmap_shape *shape, bool inside)
{
    for (int i = 0; i <= LEVELS; i++) {
        double t = (double)i / LEVELS, r = shape->inner + t * (shape->aperture - shape->inner);
        switch (shape->type) {
        case RMAP_SHAPE_CONIC:
            ask_ring(probe, r, rmap_shape_sag(shape, r));
            break;
        case RMAP_SHAPE_DISC:
            ask_ring(probe, r, 0);
            break;
        case RMAP_SHAPE_TUBE:
            ask_ring(probe, shape->radius + t * (shape->radius2 - shape->radius),
                     t * shape->length);
            break;
        case RMAP_SHAPE_RECTANGLE:
            for (int k = 0; k <= LEVELS; k++)
                ask(probe, rmap_vec3(shape->size[0] * (t - 0.5),
                                     shape->size[1] * ((double)k / LEVELS - 0.5), 0));
            break;
        case RMAP_SHAPE_SPHERE:
            break;
        case RMAP_SHAPE_SAG:
        case RMAP_SHAPE_WALL:
            ask_outline(probe, shape, t);
            break;
        }
    }
    if (shape->type == RMAP_SHAPE_SPHERE)
        ask_sphere(probe, shape->radius, inside);
}

/* Whether a line from p towards +z crosses the triangle. */
static bool is_crossed(const struct rmap_vec3 corner[3], struct rmap_vec3 p)
{
    struct rmap_vec3 a = rmap_sub(corner[0], p), b = rmap_sub(corner[1], p),
                     c = rmap_sub(corner[2], p);
    double ab = a.x * b.y - a.y * b.x, bc = b.x * c.y - b.y * c.x, ca = c.x * a.y - c.y * a.x;
    double area = ab + bc + ca;
    bool within = (ab > 0 && bc > 0 && ca > 0) || (ab < 0 && bc < 0 && ca < 0);
    return within && (bc * a.z + ca * b.z + ab * c.z) / area > 0;
}

static bool is_inside(const struct rmap_mesh *mesh, struct rmap_vec3 p)
{
    bool inside = false;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 corner[3];
        rmap_mesh_corners(mesh, t, corner);
        inside ^= is_crossed(corner, p);
    }
    return inside;
}

static void ask_mesh(struct probe *probe, const struct rmap_mesh *mesh, bool inside)
{
    const size_t stride = 1 + mesh->n_vertex / MESH_POINT_MAX;
    for (size_t i = 0; i < mesh->n_vertex; i += stride) {
        const float *v = mesh->vertex[i];
        ask(probe, rmap_vec3((double)v[0], (double)v[1], (double)v[2]));
    }
    struct rmap_vec3 lower, upper;
    rmap_mesh_bounds(mesh, &lower, &upper);
    for (int i = 0; inside && mesh->n_triangle <= TRIANGLE_MAX && i < LEVELS * LEVELS * LEVELS;
         i++) {
        /* Off the middle, where meshes like to have their edges. */
        double x = (i % LEVELS + 0.493) / LEVELS, y = (i / LEVELS % LEVELS + 0.511) / LEVELS;
        double z = (i / LEVELS / LEVELS + 0.507) / LEVELS;
        struct rmap_vec3 p = {lower.x + x * (upper.x - lower.x), lower.y + y * (upper.y - lower.y),
                              lower.z + z * (upper.z - lower.z)};
        if (is_inside(mesh, p))
            ask(probe, p);
    }
}

static void ask_side(struct probe *probe, int32_t gradient, bool inside)
{
    const struct rmap_geometry *geometry = &probe->scene->geometry[probe->object->geometry];
    if (gradient <= 0)
        return;
    struct finding *all = probe->finding;
    probe->gradient = &probe->scene->gradient[gradient - 1];
    probe->finding = &all[probe->gradient->medium];
    if (geometry->kind == RMAP_GEOMETRY_MESH)
        ask_mesh(probe, geometry->mesh, inside);
    else
        ask_shape(probe, &geometry->shape, inside);
    probe->finding = all;
}

/* ---- what is reported ---- */

static void tell(struct rmap_reader *reader, const struct rmap_medium_frame *frame,
                 const struct finding *finding)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_medium *medium = &scene->medium[frame->medium];
    char text[400], value[40] = "none";
    if (!finding->n_missing)
        return;
    if (isfinite(finding->n))
        (void)snprintf(value, sizeof value, "%.6g", finding->n);
    (void)snprintf(text, sizeof text,
                   "medium '%.60s' has no index > 0 at (%.6g, %.6g, %.6g) of the scene, at body "
                   "'%.60s' (its value there: %s); %zu of %zu places looked at are such",
                   medium->name, finding->first.x, finding->first.y, finding->first.z,
                   scene->object[finding->object].name, value, finding->n_missing,
                   finding->n_asked);
    if (frame->lenient && finding->n_missing < finding->n_asked)
        rmap_reader_warn(reader, frame->node, "%s: light that comes there ends with 'error'", text);
    else
        rmap_reader_error(reader, frame->node,
                          "%s: change the model's numbers or the size of the body", text);
}

/* ---- what light may pass unseen ---- */

/* Objects that a straight piece beside the curve may miss, of one medium. */
struct overlooked {
    size_t n;
    int32_t object; /* the smallest */
    double across, sag;
};

/* The second of the three lengths of its box: no plane cuts a body in less than about this. */
static double breadth(const struct rmap_scene *scene, const struct rmap_object *object)
{
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    struct rmap_vec3 lower, upper;
    if (geometry->kind == RMAP_GEOMETRY_MESH)
        rmap_mesh_bounds(geometry->mesh, &lower, &upper);
    else
        rmap_shape_bounds(&geometry->shape, &lower, &upper);
    struct rmap_vec3 d = rmap_sub(upper, lower);
    double x = rmap_length(rmap_affine_vector(&object->to_world, rmap_vec3(d.x, 0, 0)));
    double y = rmap_length(rmap_affine_vector(&object->to_world, rmap_vec3(0, d.y, 0)));
    double z = rmap_length(rmap_affine_vector(&object->to_world, rmap_vec3(0, 0, d.z)));
    return fmax(fmin(x, y), fmin(fmax(x, y), z));
}

static void look_at(const struct rmap_scene *scene, int32_t object, int32_t gradient,
                    struct overlooked *overlooked)
{
    if (gradient <= 0)
        return;
    const struct rmap_gradient *place = &scene->gradient[gradient - 1];
    struct overlooked *of = &overlooked[place->medium];
    double across = breadth(scene, &scene->object[object]);
    if (!(across < place->options.sag))
        return;
    if (of->n++ == 0 || across < of->across)
        *of = (struct overlooked){of->n, object, across, place->options.sag};
}

/* A value of two digits that is surely small enough. */
static double curing_sag(double across)
{
    double unit = pow(10, floor(log10(across / 4)) - 1);
    return floor(across / 4 / unit) * unit;
}

static void tell_overlooked(struct rmap_reader *reader, const struct rmap_medium_frame *frame,
                            const struct overlooked *of)
{
    const struct rmap_scene *scene = reader->scene;
    char others[80] = "";
    if (!of->n)
        return;
    if (of->n > 1)
        (void)snprintf(others, sizeof others, ", and %s so small",
                       rmap_counted(of->n - 1, "other").text);
    rmap_reader_warn(
        reader, frame->node,
        "light in medium '%.60s' may pass '%.60s' unseen: it is %.3g %s across%s, and the straight "
        "pieces that are tested may leave the curve by 'sag', %g: write 'sag: %g' here",
        scene->medium[frame->medium].name, scene->object[of->object].name, of->across, scene->unit,
        others, of->sag, curing_sag(of->across));
}

void rmap_reader_probe_sag(struct rmap_reader *reader)
{
    const struct rmap_scene *scene = reader->scene;
    struct overlooked *overlooked = rmap_reader_alloc(reader, scene->n_medium, sizeof *overlooked);
    if (!overlooked)
        return;
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_object *object = &scene->object[o];
        look_at(scene, (int32_t)o, object->gradient_front, overlooked);
        if (object->gradient_back != object->gradient_front)
            look_at(scene, (int32_t)o, object->gradient_back, overlooked);
    }
    for (size_t i = 0; i < reader->n_frame; i++)
        tell_overlooked(reader, &reader->frame[i], &overlooked[reader->frame[i].medium]);
}

void rmap_reader_probe_gradients(struct rmap_reader *reader)
{
    const struct rmap_scene *scene = reader->scene;
    size_t n_probed = 0;
    struct finding *finding = rmap_reader_alloc(reader, scene->n_medium, sizeof *finding);
    if (!finding)
        return;
    struct probe probe = {.scene = scene, .finding = finding};
    for (size_t o = 0; o < scene->n_object && n_probed < OBJECT_MAX; o++) {
        probe.object = &scene->object[o];
        n_probed += probe.object->gradient_front > 0 || probe.object->gradient_back > 0;
        ask_side(&probe, probe.object->gradient_front, false);
        ask_side(&probe, probe.object->gradient_back, true);
    }
    for (size_t i = 0; i < reader->n_frame; i++)
        tell(reader, &reader->frame[i], &finding[reader->frame[i].medium]);
}

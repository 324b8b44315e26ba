/* SPDX-License-Identifier: MIT
 *
 * Builds the two levels. Embree's world is the scene moved to the centre of its objects. A mesh
 * gets one bottom-level structure, shared by its instances. These are user primitives of the top
 * level, which take the ray into the mesh's frame in double, as analytic surfaces do: Embree's own
 * instances do it in float, whose error in a large scene is not small against a triangle.
 */
#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "accel/accel_build.h"
#include "accel/accel_cell.h"
#include "accel/accel_internal.h"
#include "accel/accel_joint.h"
#include "accel/accel_prefilter.h"
#include "accel/accel_triangle.h"
#include "base/alloc.h"

/* Boxes for shapes. A tube or a ring in one box would be looked at by every ray that runs through
 * its middle, as light in a lens barrel does; in sectors it is not. */

enum { SECTORS = 16 }; /* a multiple of 4: x and y are monotonic within each */

void rmap_shell_radii(const struct rmap_shape *shape, double radius[2])
{
    radius[0] = 0;
    radius[1] = shape->radius;
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC:
        radius[0] = shape->inner;
        radius[1] = shape->aperture;
        break;
    case RMAP_SHAPE_TUBE:
        radius[0] = rmap_lesser(shape->radius, shape->radius2);
        radius[1] = rmap_greater(shape->radius, shape->radius2);
        break;
    case RMAP_SHAPE_RECTANGLE:
        radius[1] = 0.5 * hypot(shape->size[0], shape->size[1]);
        break;
    case RMAP_SHAPE_SAG:
        radius[0] = shape->inner;
        radius[1] = rmap_aperture_far(&shape->outline);
        break;
    case RMAP_SHAPE_WALL:
        radius[0] = shape->outline.rectangle ? 0 : rmap_aperture_near(&shape->outline);
        radius[1] = rmap_aperture_far(&shape->outline);
        break;
    case RMAP_SHAPE_SPHERE:
        break;
    }
}

/* Is the middle hollow enough for sectors? */
static bool hollow(const struct rmap_shape *shape, double radius[2])
{
    if (!shape)
        return false;
    rmap_shell_radii(shape, radius);
    return radius[0] > 0.3 * radius[1];
}

int rmap_part_count(const struct rmap_accel_object *object)
{
    double radius[2];
    return hollow(object->shape, radius) ? SECTORS : 1;
}

void rmap_part_bounds(const struct rmap_accel_object *object, int part, struct rmap_vec3 *lower,
                      struct rmap_vec3 *upper)
{
    double radius[2];
    *lower = object->lower;
    *upper = object->upper;
    if (!hollow(object->shape, radius))
        return;
    for (int k = 0; k < 4; k++) {
        double angle = 2 * RMAP_PI / SECTORS * (part + k % 2);
        double x = radius[k / 2] * cos(angle), y = radius[k / 2] * sin(angle);
        lower->x = k == 0 ? x : rmap_lesser(lower->x, x);
        lower->y = k == 0 ? y : rmap_lesser(lower->y, y);
        upper->x = k == 0 ? x : rmap_greater(upper->x, x);
        upper->y = k == 0 ? y : rmap_greater(upper->y, y);
    }
}

/* The triangles around each vertex of a mesh. Vertices at the same place are one, whether or not
 * the file shared them. */

/* A ray begins this share of the float error that it may be off behind its start: see
 * RMAP_REACH_ERRORS. */
#define LEAST_COSINE (4.0 / RMAP_REACH_ERRORS)

struct placed {
    float at[3];
    uint32_t vertex;
};

static int compare(const void *left, const void *right)
{
    const struct placed *a = left, *b = right;
    for (int k = 0; k < 3; k++)
        if (a->at[k] != b->at[k])
            return a->at[k] < b->at[k] ? -1 : 1;
    return a->vertex < b->vertex ? -1 : a->vertex > b->vertex;
}

static bool same_place(const struct placed *a, const struct placed *b)
{
    return a->at[0] == b->at[0] && a->at[1] == b->at[1] && a->at[2] == b->at[2];
}

static bool join_vertices(const struct rmap_mesh *mesh, uint32_t *same)
{
    struct placed *sorted = rmap_alloc(mesh->n_vertex, sizeof(*sorted));
    if (!sorted)
        return false;
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        memcpy(sorted[i].at, mesh->vertex[i], sizeof(sorted[i].at));
        sorted[i].vertex = (uint32_t)i;
    }
    qsort(sorted, mesh->n_vertex, sizeof(*sorted), compare);
    size_t leader = 0;
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        if (!same_place(&sorted[leader], &sorted[i]))
            leader = i;
        same[sorted[i].vertex] = sorted[leader].vertex;
    }
    rmap_free(sorted);
    return true;
}

/* At RMAP_NEEDLE_SINE a triangle is not wide enough to be safe from any side. */
static void set_sight(const struct rmap_facets *facets, size_t i, double wider, float sight[4])
{
    struct rmap_vec3 corner[3];
    rmap_facets_corners(facets, (int32_t)i, corner);
    struct rmap_vec3 e1 = rmap_sub(corner[1], corner[0]), e2 = rmap_sub(corner[2], corner[0]);
    struct rmap_vec3 e0 = rmap_sub(e2, e1), n = rmap_cross(e1, e2);
    double area = rmap_length(n), cosine = HUGE_VAL;
    double longest = rmap_max(rmap_dot(e0, e0), rmap_max(rmap_dot(e1, e1), rmap_dot(e2, e2)));
    if (area > RMAP_NEEDLE_SINE * longest) {
        cosine = rmap_max(wider / rmap_facet_margin(e1, e2, wider), LEAST_COSINE) * (1 + 1e-5);
        n = rmap_scale(n, 1 / area);
    }
    sight[0] = (float)n.x;
    sight[1] = (float)n.y;
    sight[2] = (float)n.z;
    sight[3] = (float)cosine;
}

static enum rmap_status facets_build(const struct rmap_mesh *mesh, double wider,
                                     struct rmap_facets *facets, struct rmap_error *err)
{
    facets->same = rmap_alloc(mesh->n_vertex, sizeof(*facets->same));
    facets->first = rmap_alloc(mesh->n_vertex + 2, sizeof(*facets->first));
    facets->fan = rmap_alloc(3 * mesh->n_triangle, sizeof(*facets->fan));
    facets->corner = rmap_alloc(mesh->n_triangle, sizeof(*facets->corner));
    facets->sight = rmap_alloc(mesh->n_triangle, sizeof(*facets->sight));
    if (!facets->corner || !facets->sight || !facets->same || !facets->first || !facets->fan ||
        !join_vertices(mesh, facets->same)) {
        rmap_facets_release(facets);
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles",
                              mesh->n_triangle);
    }
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            memcpy(&facets->corner[i][3 * k], mesh->vertex[mesh->triangle[i][k]],
                   sizeof(*mesh->vertex));
    /* counts two places on, so that filling them leaves the starts where they belong */
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            facets->first[facets->same[mesh->triangle[i][k]] + 2]++;
    for (size_t v = 2; v < mesh->n_vertex + 2; v++)
        facets->first[v] += facets->first[v - 1];
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            facets->fan[facets->first[facets->same[mesh->triangle[i][k]] + 1]++] = (uint32_t)i;
    for (size_t i = 0; i < mesh->n_triangle; i++)
        set_sight(facets, i, wider, facets->sight[i]);
    return RMAP_OK;
}

void rmap_facets_release(struct rmap_facets *facets)
{
    rmap_free(facets->corner);
    rmap_free(facets->sight);
    rmap_free(facets->same);
    rmap_free(facets->first);
    rmap_free(facets->fan);
    rmap_cells_destroy(facets->cells);
    memset(facets, 0, sizeof(*facets));
}

/* Meshes of more vertices are put into the world by the corners of their box. */
#define EXACT_BOUNDS_MAX 16384

/* Between a ray's start at the sphere about a mesh's box and Embree's decision, in roundings of
 * the farthest coordinate, at most: 6 of the start and the direction, 12 of a triangle's edges, 8
 * of boxes. */
#define LOCAL_ERRORS 32

/* The same in the top level, of 4 roundings of the radius each: 3 of the start and the direction, 8
 * of boxes, which lie up to twice the radius away. */
#define BOX_ERRORS 4

static bool keeps_lengths(const struct rmap_affine *a)
{
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++) {
            double dot =
                a->m[0][i] * a->m[0][j] + a->m[1][i] * a->m[1][j] + a->m[2][i] * a->m[2][j];
            if (fabs(dot - (i == j)) > 1e-12)
                return false;
        }
    return true;
}

void rmap_world_box(const struct rmap_affine *to_world, struct rmap_vec3 *lower,
                    struct rmap_vec3 *upper)
{
    struct rmap_vec3 low = *lower, high = *upper;
    for (int k = 0; k < 8; k++) {
        struct rmap_vec3 corner =
            rmap_vec3(k & 1 ? high.x : low.x, k & 2 ? high.y : low.y, k & 4 ? high.z : low.z);
        corner = rmap_affine_point(to_world, corner);
        *lower = k == 0 ? corner : rmap_least(*lower, corner);
        *upper = k == 0 ? corner : rmap_greatest(*upper, corner);
    }
}

void rmap_accel_bounds(const struct rmap_accel_object *object, struct rmap_vec3 *lower,
                       struct rmap_vec3 *upper)
{
    *lower = object->lower;
    *upper = object->upper;
    rmap_world_box(&object->to_world, lower, upper);
}

/* Tighter than by the corners of its box, for a mesh that is turned. */
static void set_mesh_bounds(struct rmap_accel_object *object)
{
    const struct rmap_mesh *mesh = object->mesh;
    const struct rmap_affine *a = &object->to_world;
    const double t[3] = {a->t.x, a->t.y, a->t.z};
    double lower[3], upper[3];
    rmap_accel_bounds(object, &object->world_lower, &object->world_upper);
    if (mesh->n_vertex > EXACT_BOUNDS_MAX || mesh->surface)
        return;
    for (int k = 0; k < 3; k++) {
        lower[k] = INFINITY;
        upper[k] = -INFINITY;
    }
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        const float *v = mesh->vertex[i];
        for (int k = 0; k < 3; k++) {
            double at = a->m[k][0] * (double)v[0] + a->m[k][1] * (double)v[1] +
                        a->m[k][2] * (double)v[2] + t[k];
            lower[k] = rmap_lesser(lower[k], at);
            upper[k] = rmap_greater(upper[k], at);
        }
    }
    object->world_lower = rmap_vec3(lower[0], lower[1], lower[2]);
    object->world_upper = rmap_vec3(upper[0], upper[1], upper[2]);
}

static double reach_of(struct rmap_vec3 lower, struct rmap_vec3 upper)
{
    struct rmap_vec3 far = rmap_greatest(rmap_vec3(fabs(lower.x), fabs(lower.y), fabs(lower.z)),
                                         rmap_vec3(fabs(upper.x), fabs(upper.y), fabs(upper.z)));
    return rmap_length(far);
}

/* Of the size: bodies of a CAD model that touch agree to so much. */
#define MODEL_ERROR 1e-9

static bool is_all_true(const struct rmap_mesh *mesh)
{
    bool all = mesh->surface != NULL;
    for (size_t i = 0; i < mesh->n_face && all; i++)
        all = mesh->surface[i].kind != RMAP_TRUE_NONE;
    return all;
}

/* Coincidence: 1e-12 of the object's size, double rounding of its place, and for a mesh the
 * rounding of its float vertices, with a factor 4 in hand, or of its model. */
static void set_tolerances(struct rmap_accel_object *object)
{
    struct rmap_vec3 lower = {0}, upper = {0};
    rmap_accel_bounds(object, &lower, &upper);
    double size = rmap_length(rmap_sub(upper, lower));
    double place = reach_of(lower, upper);
    object->exact = 1e-12 * size + 64 * DBL_EPSILON * place;
    object->local_exact = object->exact * rmap_affine_norm(&object->to_local);
    object->tolerance = object->exact;
    if (object->mesh && is_all_true(object->mesh))
        object->tolerance += MODEL_ERROR * size;
    else if (object->mesh)
        object->tolerance += 4 * RMAP_FLOAT_EPS * reach_of(object->lower, object->upper) *
                             rmap_affine_norm(&object->to_world);
}

void rmap_accel_set_object(struct rmap_accel *accel, const struct rmap_scene *scene, size_t i)
{
    const struct rmap_object *from = &scene->object[i];
    const struct rmap_geometry *geometry = &scene->geometry[from->geometry];
    struct rmap_accel_object *object = &accel->object[i];
    object->to_local = from->to_local;
    object->to_world = from->to_world;
    object->rigid = keeps_lengths(&from->to_world);
    object->medium_front = from->medium_front;
    object->medium_back = from->medium_back;
    object->soon = &from->surface_front;
    if (geometry->kind == RMAP_GEOMETRY_SHAPE) {
        object->shape = &geometry->shape;
        rmap_shape_bounds(&geometry->shape, &object->lower, &object->upper);
    } else {
        object->mesh = geometry->mesh;
        rmap_mesh_bounds(geometry->mesh, &object->lower, &object->upper);
        set_mesh_bounds(object);
    }
    set_tolerances(object);
}

static enum rmap_status set_world(struct rmap_accel *accel, struct rmap_error *err)
{
    struct rmap_vec3 lower = {0}, upper = {0};
    for (size_t i = 0; i < accel->n_object; i++) {
        struct rmap_vec3 low = {0}, high = {0};
        rmap_accel_bounds(&accel->object[i], &low, &high);
        lower = i == 0 ? low : rmap_least(lower, low);
        upper = i == 0 ? high : rmap_greatest(upper, high);
    }
    accel->centre = rmap_scale(rmap_add(lower, upper), 0.5);
    accel->radius = 0.5 * rmap_length(rmap_sub(upper, lower));
    if (!(accel->radius < RMAP_OBJECTS_RADIUS_MAX))
        return rmap_error_set(err, RMAP_INPUT, "the scene is too large: radius %g", accel->radius);
    accel->radius = accel->radius * (1 + 1e-6) + 1e-30;
    accel->error = 4 * RMAP_FLOAT_EPS * accel->radius;
    return RMAP_OK;
}

static void part_bounds(const struct rmap_accel_parts *parts, size_t index, struct RTCBounds *box)
{
    const struct rmap_accel *accel = parts->accel;
    const struct rmap_accel_part *part = &parts->part[index];
    const struct rmap_accel_object *object = &accel->object[part->object];
    struct rmap_vec3 lower = object->world_lower, upper = object->world_upper;
    if (object->shape) {
        rmap_part_bounds(object, part->part, &lower, &upper);
        rmap_world_box(&object->to_world, &lower, &upper);
    }
    double pad = BOX_ERRORS * accel->error + object->tolerance;
    lower = rmap_sub(lower, accel->centre);
    upper = rmap_sub(upper, accel->centre);
    box->lower_x = (float)(lower.x - pad);
    box->lower_y = (float)(lower.y - pad);
    box->lower_z = (float)(lower.z - pad);
    box->upper_x = (float)(upper.x + pad);
    box->upper_y = (float)(upper.y + pad);
    box->upper_z = (float)(upper.z + pad);
}

static void bounds_callback(const struct RTCBoundsFunctionArguments *args)
{
    part_bounds(args->geometryUserPtr, args->primID, args->bounds_o);
}

static void add_parts(struct rmap_accel_parts *parts, const struct rmap_accel_object *object,
                      size_t index)
{
    int n = rmap_part_count(object);
    for (int k = 0; k < n; k++)
        parts->part[parts->n++] = (struct rmap_accel_part){(int32_t)index, k};
}

static void attach_callbacks(struct rmap_accel *accel, struct rmap_accel_parts *parts,
                             RTCScene scene)
{
    if (parts->n == 0)
        return;
    RTCGeometry user = rtcNewGeometry(accel->device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(user, (unsigned)parts->n);
    rtcSetGeometryUserData(user, parts);
    rtcSetGeometryBoundsFunction(user, bounds_callback, NULL);
    rtcSetGeometryIntersectFunction(user, rmap_accel_callback);
    rtcCommitGeometry(user);
    rtcAttachGeometry(scene, user);
    rtcReleaseGeometry(user);
}

/* Room for every object's parts; how many shapes there are. */
static enum rmap_status reserve_parts(struct rmap_accel *accel, size_t *n_shape,
                                      struct rmap_error *err)
{
    size_t most = 0;
    for (size_t i = 0; i < accel->n_object; i++) {
        most += (size_t)rmap_part_count(&accel->object[i]);
        *n_shape += accel->object[i].shape != NULL;
    }
    accel->meshes.accel = accel->shapes.accel = accel;
    accel->meshes.part = rmap_alloc(accel->n_object, sizeof(*accel->meshes.part));
    accel->shapes.part = rmap_alloc(most, sizeof(*accel->shapes.part));
    if (!accel->meshes.part || !accel->shapes.part)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu objects", accel->n_object);
    return RMAP_OK;
}

static RTCScene new_scene(const struct rmap_accel *accel)
{
    RTCScene scene = rtcNewScene(accel->device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_NONE);
    return scene;
}

static double volume_of(const struct RTCBounds *box)
{
    return (double)(box->upper_x - box->lower_x) * (double)(box->upper_y - box->lower_y) *
           (double)(box->upper_z - box->lower_z);
}

/* Do the shapes stand about everything else, as walls about a room? To a hundredth. */
static bool shapes_surround(const struct rmap_accel *accel, const struct RTCBounds *rest)
{
    const struct rmap_vec3 low = rmap_vec3(rest->lower_x, rest->lower_y, rest->lower_z);
    const struct rmap_vec3 high = rmap_vec3(rest->upper_x, rest->upper_y, rest->upper_z);
    struct rmap_vec3 lower = rmap_vec3(INFINITY, INFINITY, INFINITY);
    struct rmap_vec3 upper = rmap_vec3(-INFINITY, -INFINITY, -INFINITY);
    for (size_t i = 0; i < accel->n_object; i++) {
        struct rmap_vec3 from, to;
        if (!accel->object[i].shape)
            continue;
        rmap_accel_bounds(&accel->object[i], &from, &to);
        lower = rmap_least(lower, rmap_sub(from, accel->centre));
        upper = rmap_greatest(upper, rmap_sub(to, accel->centre));
    }
    double slack = 0.01 * rmap_length(rmap_sub(high, low));
    return lower.x - slack <= low.x && high.x <= upper.x + slack && lower.y - slack <= low.y &&
           high.y <= upper.y + slack && lower.z - slack <= low.z && high.z <= upper.z + slack;
}

/* Of the box and all shapes. */
static double volume_with_shapes(const struct rmap_accel *accel, struct RTCBounds box)
{
    for (size_t i = 0; i < accel->shapes.n; i++) {
        struct RTCBounds part;
        part_bounds(&accel->shapes, i, &part);
        box.lower_x = fminf(box.lower_x, part.lower_x);
        box.lower_y = fminf(box.lower_y, part.lower_y);
        box.lower_z = fminf(box.lower_z, part.lower_z);
        box.upper_x = fmaxf(box.upper_x, part.upper_x);
        box.upper_y = fmaxf(box.upper_y, part.upper_y);
        box.upper_z = fmaxf(box.upper_z, part.upper_z);
    }
    return volume_of(&box);
}

/* Bounds are worth a look where there is much room beside them. */
static void set_rest_bounds(struct rmap_accel *accel)
{
    const double roundings = 64;
    float pad = (float)(roundings * RMAP_FLOAT_EPS * 2 * (accel->radius + accel->reach));
    struct RTCBounds rest;
    if (!accel->rest)
        return;
    rtcGetSceneBounds(accel->rest, &rest);
    const float lower[3] = {rest.lower_x, rest.lower_y, rest.lower_z};
    const float upper[3] = {rest.upper_x, rest.upper_y, rest.upper_z};
    accel->rest_apart = volume_of(&rest) < 0.5 * volume_with_shapes(accel, rest);
    accel->rest_inside = shapes_surround(accel, &rest);
    for (int k = 0; k < 3; k++) {
        accel->rest_lower[k] = lower[k] - pad;
        accel->rest_upper[k] = upper[k] + pad;
    }
}

static RTCScene build_scene(struct rmap_accel *accel, bool with_shapes)
{
    RTCScene scene = new_scene(accel);
    attach_callbacks(accel, &accel->meshes, scene);
    if (with_shapes)
        attach_callbacks(accel, &accel->shapes, scene);
    rtcCommitScene(scene);
    return scene;
}

/* A few shapes are found faster through the prefilter than by Embree, which then holds the meshes
 * only. */
static enum rmap_status build_top(struct rmap_accel *accel, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n_shape = 0;
    RMAP_TRY(reserve_parts(accel, &n_shape, err));
    bool sieved = n_shape > 0 && n_shape <= RMAP_PREFILTER_MAX && rmap_accel_is_wide(accel);
    for (size_t i = 0; i < accel->n_object; i++) {
        const struct rmap_accel_object *object = &accel->object[i];
        if (object->shape || object->mesh->n_triangle > 0)
            add_parts(object->mesh ? &accel->meshes : &accel->shapes, object, i);
    }
    if (!sieved || n_shape < accel->n_object)
        accel->rest = build_scene(accel, !sieved);
    if (sieved) {
        set_rest_bounds(accel);
        if (accel->rest_inside)
            rmap_clearance_build(accel);
        rmap_spheres_build(accel);
        rmap_prefilter_build(accel);
    } else {
        accel->whole = accel->rest;
        rtcRetainScene(accel->whole);
    }
    RMAP_TRY(rmap_accel_failed(accel, "building the scene", err));
out:
    return st;
}

enum rmap_status rmap_accel_build_whole(struct rmap_accel *accel, struct rmap_error *err)
{
    if (!accel->whole)
        accel->whole = build_scene(accel, true);
    return rmap_accel_failed(accel, "building the scene", err);
}

/* Triangles are widened by the float error and the rounding of the widened corners. */
static enum rmap_status build_bottoms(struct rmap_accel *accel, const struct rmap_scene *scene,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    double *wider = rmap_alloc(scene->n_geometry, sizeof(*wider));
    if (!wider)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu geometries", scene->n_geometry);
    for (size_t i = 0; i < accel->n_object; i++) {
        struct rmap_accel_object *object = &accel->object[i];
        if (!object->mesh)
            continue;
        double reach = RMAP_FLOAT_EPS * reach_of(object->lower, object->upper);
        object->middle = rmap_scale(rmap_add(object->lower, object->upper), 0.5);
        object->half = 0.5 * rmap_length(rmap_sub(object->upper, object->lower));
        object->local_error = LOCAL_ERRORS * reach;
        wider[scene->object[i].geometry] = object->local_error + 2 * reach;
    }
    accel->reach = RMAP_REACH_ERRORS * accel->error;
    accel->n_bottom = scene->n_geometry;
    for (size_t i = 0; i < scene->n_geometry; i++) {
        const struct rmap_geometry *geometry = &scene->geometry[i];
        if (!(wider[i] > 0) || geometry->mesh->n_triangle == 0)
            continue;
        if (geometry->mesh->surface) {
            const struct rmap_mesh whole = rmap_mesh_with_beyond(geometry->mesh);
            RMAP_TRY(facets_build(&whole, wider[i], &accel->facets[i], err));
            RMAP_TRY(rmap_cells_build(geometry->mesh, &accel->facets[i], wider[i],
                                      &accel->facets[i].cells, err));
            RMAP_TRY(rmap_accel_cells(accel, accel->facets[i].cells, &accel->bottom[i], err));
            continue;
        }
        RMAP_TRY(rmap_accel_mesh(accel, geometry, wider[i], &accel->bottom[i], err));
        RMAP_TRY(facets_build(geometry->mesh, wider[i], &accel->facets[i], err));
    }
    for (size_t i = 0; i < accel->n_object; i++) {
        accel->object[i].bottom = accel->bottom[scene->object[i].geometry];
        accel->object[i].facets = &accel->facets[scene->object[i].geometry];
        accel->object[i].cells = accel->object[i].facets->cells;
    }
out:
    rmap_free(wider);
    return st;
}

enum rmap_status rmap_accel_build(struct rmap_accel *accel, const struct rmap_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    accel->n_object = scene->n_object;
    accel->behind = -1e-11 * scene->radius;
    accel->object = rmap_alloc(scene->n_object, sizeof(*accel->object));
    accel->bottom = rmap_alloc(scene->n_geometry, sizeof(*accel->bottom));
    accel->facets = rmap_alloc(scene->n_geometry, sizeof(*accel->facets));
    if (!accel->facets || !accel->object || !accel->bottom)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu objects", scene->n_object);
    for (size_t i = 0; i < scene->n_object; i++)
        rmap_accel_set_object(accel, scene, i);
    RMAP_TRY(rmap_joints_build(accel, err));
    RMAP_TRY(set_world(accel, err));
    RMAP_TRY(build_bottoms(accel, scene, err));
    RMAP_TRY(build_top(accel, err));
out:
    return st;
}

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

#include "accel/accel_bottom.h"
#include "accel/accel_build.h"
#include "accel/accel_internal.h"
#include "accel/accel_joint.h"
#include "accel/accel_prefilter.h"
#include "accel/accel_triangle.h"
#include "base/alloc.h"
#include "base/clock.h"
#include "scene/bounds.h"

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

/* As RMAP_LOCAL_ERRORS in the top level, of 4 roundings of the radius each: 3 of the start and the
 * direction, 8 of boxes, which lie up to twice the radius away. */
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
    const struct rmap_vec3 half = rmap_scale(rmap_sub(*upper, *lower), 0.5),
                           middle = rmap_affine_point(to_world, rmap_add(*lower, half));
    const double(*m)[3] = to_world->m;
    const struct rmap_vec3 reach =
        rmap_vec3(fabs(m[0][0]) * half.x + fabs(m[0][1]) * half.y + fabs(m[0][2]) * half.z,
                  fabs(m[1][0]) * half.x + fabs(m[1][1]) * half.y + fabs(m[1][2]) * half.z,
                  fabs(m[2][0]) * half.x + fabs(m[2][1]) * half.y + fabs(m[2][2]) * half.z);
    *lower = rmap_sub(middle, reach);
    *upper = rmap_add(middle, reach);
}

void rmap_accel_bounds(const struct rmap_accel_object *object, struct rmap_vec3 *lower,
                       struct rmap_vec3 *upper)
{
    *lower = object->lower;
    *upper = object->upper;
    rmap_world_box(&object->to_world, lower, upper);
}

/* Tighter than by the corners of its box, for a mesh that is turned: as the scene has them. */
static void set_mesh_bounds(struct rmap_accel_object *object, const struct rmap_bounds *bounds)
{
    if (!bounds || !(bounds->lower.x <= bounds->upper.x)) {
        rmap_accel_bounds(object, &object->world_lower, &object->world_upper);
        return;
    }
    object->world_lower = bounds->lower;
    object->world_upper = bounds->upper;
}

static double reach_of(struct rmap_vec3 lower, struct rmap_vec3 upper)
{
    struct rmap_vec3 far = rmap_greatest(rmap_vec3(fabs(lower.x), fabs(lower.y), fabs(lower.z)),
                                         rmap_vec3(fabs(upper.x), fabs(upper.y), fabs(upper.z)));
    return rmap_length(far);
}

double rmap_mesh_rounding(struct rmap_vec3 lower, struct rmap_vec3 upper)
{
    return RMAP_FLOAT_EPS * reach_of(lower, upper);
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
        const struct rmap_bottom *bottom = accel->bottom ? accel->bottom[from->geometry] : NULL;
        object->mesh = geometry->mesh;
        if (bottom) {
            object->lower = bottom->lower;
            object->upper = bottom->upper;
        } else {
            rmap_mesh_bounds(geometry->mesh, &object->lower, &object->upper);
        }
        set_mesh_bounds(object, scene->object_bounds ? &scene->object_bounds[i] : NULL);
        object->middle = rmap_scale(rmap_add(object->lower, object->upper), 0.5);
        object->half = 0.5 * rmap_length(rmap_sub(object->upper, object->lower));
        object->local_error = RMAP_LOCAL_ERRORS * rmap_mesh_rounding(object->lower, object->upper);
    }
    set_tolerances(object);
    if (accel->box)
        rmap_accel_bounds(object, &accel->box[i].lower, &accel->box[i].upper);
}

static enum rmap_status set_world(struct rmap_accel *accel, struct rmap_error *err)
{
    struct rmap_vec3 lower = {0}, upper = {0};
    for (size_t i = 0; i < accel->n_object; i++) {
        const struct rmap_accel_box *box = &accel->box[i];
        lower = i == 0 ? box->lower : rmap_least(lower, box->lower);
        upper = i == 0 ? box->upper : rmap_greatest(upper, box->upper);
    }
    accel->world = (struct rmap_accel_box){lower, upper};
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
    RTCGeometry user = rtcNewGeometry(accel->device->embree, RTC_GEOMETRY_TYPE_USER);
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
    RTCScene scene = rtcNewScene(accel->device->embree);
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
        if (!accel->object[i].shape)
            continue;
        lower = rmap_least(lower, rmap_sub(accel->box[i].lower, accel->centre));
        upper = rmap_greatest(upper, rmap_sub(accel->box[i].upper, accel->centre));
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

/* Of float rays' places, at most, with much in hand. */
static float ray_error(const struct rmap_accel *accel)
{
    const double roundings = 64;
    return (float)(roundings * RMAP_FLOAT_EPS * 2 * (accel->radius + accel->reach));
}

/* Bounds are worth a look where there is much room beside them. */
static void set_rest_bounds(struct rmap_accel *accel)
{
    const float pad = ray_error(accel);
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
    if (!accel->whole) {
        accel->whole = new_scene(accel);
        attach_callbacks(accel, &accel->meshes, accel->whole);
        attach_callbacks(accel, &accel->shapes, accel->whole);
        attach_callbacks(accel, &accel->moved, accel->whole);
        rtcCommitScene(accel->whole);
    }
    return rmap_accel_failed(accel, "building the scene", err);
}

static const struct rmap_facets no_facets;

static void set_bottom(struct rmap_accel *accel, const struct rmap_scene *scene, size_t i)
{
    const struct rmap_bottom *bottom = accel->bottom[scene->object[i].geometry];
    struct rmap_accel_object *object = &accel->object[i];
    object->bottom = bottom ? bottom->scene : NULL;
    object->facets = bottom ? &bottom->facets : &no_facets;
    object->cells = object->facets->cells;
}

/* Meshes that stand where they stood need no new look at their vertices. */
static bool take_object(struct rmap_accel *accel, const struct rmap_scene *scene,
                        const struct rmap_accel *like, size_t i)
{
    const struct rmap_object *from = &scene->object[i];
    const struct rmap_bottom *bottom = accel->bottom[from->geometry];
    if (!like || i >= like->n_object || !bottom || like->object[i].facets != &bottom->facets ||
        memcmp(&like->object[i].to_world, &from->to_world, sizeof(from->to_world)) != 0 ||
        memcmp(&like->object[i].to_local, &from->to_local, sizeof(from->to_local)) != 0)
        return false;
    accel->object[i] = like->object[i];
    accel->box[i] = like->box[i];
    accel->object[i].mesh = scene->geometry[from->geometry].mesh;
    accel->object[i].medium_front = from->medium_front;
    accel->object[i].medium_back = from->medium_back;
    accel->object[i].soon = &from->surface_front;
    return true;
}

/* What depends on where all objects stand. */
static enum rmap_status build_around(struct rmap_accel *accel, bool joints, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    accel->behind = -1e-11 * accel->scene->radius;
    if (joints)
        RMAP_TRY(rmap_joints_build(accel, err));
    RMAP_TRY(set_world(accel, err));
    accel->reach = RMAP_REACH_ERRORS * accel->error;
    RMAP_TRY(build_top(accel, err));
out:
    return st;
}

enum rmap_status rmap_accel_build(struct rmap_accel *accel, const struct rmap_scene *scene,
                                  const struct rmap_accel *like, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const double begun = rmap_clock_seconds();
    accel->scene = scene;
    accel->n_object = accel->build.n_object = scene->n_object;
    accel->object = rmap_alloc(scene->n_object, sizeof(*accel->object));
    accel->box = rmap_alloc(scene->n_object, sizeof(*accel->box));
    if (!accel->object || !accel->box)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu objects", scene->n_object);
    RMAP_TRY(rmap_bottoms_build(accel, scene, like, err));
    accel->build.meshes_s = rmap_clock_seconds() - begun;
    for (size_t i = 0; i < scene->n_object; i++) {
        if (!take_object(accel, scene, like, i))
            rmap_accel_set_object(accel, scene, i);
        set_bottom(accel, scene, i);
    }
    RMAP_TRY(build_around(accel, true, err));
    accel->build.top_s = rmap_clock_seconds() - begun - accel->build.meshes_s;
out:
    return st;
}

/* The search looks at meshes that left the top level besides: of many that is not felt. */
enum { PARTS_PER_MOVED = 256 };

static int by_object(const void *key, const void *part)
{
    const int32_t a = *(const int32_t *)key, b = ((const struct rmap_accel_part *)part)->object;
    return (a > b) - (a < b);
}

static bool is_within(const struct rmap_accel_box *box, const struct rmap_accel_box *world)
{
    return box->lower.x >= world->lower.x && box->upper.x <= world->upper.x &&
           box->lower.y >= world->lower.y && box->upper.y <= world->upper.y &&
           box->lower.z >= world->lower.z && box->upper.z <= world->upper.z;
}

/* Takes the object out of the top level; false: there is no room for it beside, or it has left the
 * world that Embree's boxes are made for. */
static bool set_aside(struct rmap_accel *accel, int32_t object)
{
    struct rmap_accel_part *part =
        bsearch(&object, accel->meshes.part, accel->meshes.n, sizeof(*part), by_object);
    if (!is_within(&accel->box[object], &accel->world))
        return false;
    if (!part || part->part == RMAP_PART_GONE) /* it is nothing, or aside already */
        return true;
    if (accel->moved.n >= RMAP_MOVED_MAX || accel->moved.n >= accel->meshes.n / PARTS_PER_MOVED)
        return false;
    accel->moved.part[accel->moved.n++] = *part;
    part->part = RMAP_PART_GONE;
    return true;
}

/* Wider than the float error of rays; where there is none, no ray comes between its sides. */
static void set_moved_box(struct rmap_accel *accel, int i)
{
    struct RTCBounds box = {.lower_x = NAN};
    const float pad = ray_error(accel);
    if ((size_t)i < accel->moved.n)
        part_bounds(&accel->moved, (size_t)i, &box);
    const float low[3] = {box.lower_x, box.lower_y, box.lower_z};
    const float high[3] = {box.upper_x, box.upper_y, box.upper_z};
    for (int k = 0; k < 3; k++) {
        accel->moved_lower[k][i] = low[k] - pad;
        accel->moved_upper[k][i] = high[k] + pad;
    }
}

/* Meshes that moved are looked for beside the top level, which stays as it is. */
static bool follow(struct rmap_accel *accel, const int32_t *object, size_t n_object)
{
    bool good = accel->rest != NULL && n_object > 0 && n_object <= RMAP_MOVED_MAX;
    if (good && !accel->moved.part) {
        accel->moved.accel = accel;
        accel->moved.part = rmap_alloc(RMAP_MOVED_MAX, sizeof(*accel->moved.part));
        good = accel->moved.part != NULL;
    }
    for (size_t i = 0; i < n_object && good; i++)
        good = set_aside(accel, object[i]);
    if (!good || accel->moved.n == 0)
        return good;
    if (accel->whole)
        rtcReleaseScene(accel->whole);
    accel->whole = NULL;
    for (int i = 0; i < RMAP_MOVED_MAX; i++)
        set_moved_box(accel, i);
    return true;
}

enum rmap_status rmap_accel_rebuild(struct rmap_accel *accel, const int32_t *object,
                                    size_t n_object, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const double begun = rmap_clock_seconds();
    bool shapes = false;
    for (size_t i = 0; i < n_object; i++) {
        rmap_accel_set_object(accel, accel->scene, (size_t)object[i]);
        shapes = shapes || accel->object[object[i]].shape;
    }
    accel->behind = -1e-11 * accel->scene->radius;
    if (!shapes && follow(accel, object, n_object)) {
        st = rmap_accel_failed(accel, "moving an object", err);
    } else {
        if (shapes) /* rims are theirs alone */
            rmap_joints_release(accel);
        rmap_accel_release_top(accel);
        st = build_around(accel, shapes, err);
    }
    accel->build = (struct rmap_accel_build){.n_kept = accel->build.n_built + accel->build.n_kept,
                                             .n_object = accel->n_object,
                                             .n_beside = accel->moved.n,
                                             .top_s = rmap_clock_seconds() - begun};
    return st;
}

void rmap_accel_release_top(struct rmap_accel *accel)
{
    if (accel->whole)
        rtcReleaseScene(accel->whole);
    if (accel->rest)
        rtcReleaseScene(accel->rest);
    accel->whole = accel->rest = NULL;
    rmap_free(accel->meshes.part);
    rmap_free(accel->shapes.part);
    rmap_free(accel->moved.part);
    accel->meshes = accel->shapes = accel->moved = (struct rmap_accel_parts){.n = 0};
    accel->rest_apart = accel->rest_inside = false;
    accel->spheres.n = 0;
    accel->prefilter = (struct rmap_prefilter){.n_slot = 0};
}

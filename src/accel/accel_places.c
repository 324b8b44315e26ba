/* SPDX-License-Identifier: MIT
 *
 * Where objects stand: boxes about all that the search for the next surface looks at of them.
 *
 * A surface decides about a ray where the ray comes to it within the tolerances of both surfaces
 * that may be the next one, along the ray, which at grazing incidence are RMAP_GRAZING_MAX times as
 * long; and near a rim that it shares with others.
 */
#include "accel/accel_places.h"

#include <math.h>

#include "accel/accel_bottom.h"
#include "accel/accel_build.h"
#include "accel/accel_joint.h"
#include "base/alloc.h"
#include "scene/scene.h"

/* Objects with their tolerances and joints. A mesh has its bounds found once. */
static enum rmap_status begin(const struct rmap_scene *scene, struct rmap_accel *accel,
                              struct rmap_error *err)
{
    accel->n_object = scene->n_object;
    accel->object = rmap_alloc(scene->n_object, sizeof *accel->object);
    accel->bottom = rmap_alloc(scene->n_geometry + 1, sizeof *accel->bottom);
    if (accel->bottom)
        accel->bottom[0] = rmap_alloc(scene->n_geometry + 1, sizeof **accel->bottom);
    if (!accel->object || !accel->bottom || !accel->bottom[0])
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu objects", scene->n_object);
    for (size_t i = 0; i < scene->n_geometry; i++) {
        struct rmap_bottom *bottom = accel->bottom[i] = accel->bottom[0] + i;
        if (scene->geometry[i].kind == RMAP_GEOMETRY_MESH)
            rmap_mesh_bounds(scene->geometry[i].mesh, &bottom->lower, &bottom->upper);
    }
    for (size_t i = 0; i < scene->n_object; i++)
        rmap_accel_set_object(accel, scene, i);
    return rmap_joints_build(accel, err);
}

static void end(struct rmap_accel *accel)
{
    rmap_joints_release(accel);
    if (accel->bottom)
        rmap_free(accel->bottom[0]);
    rmap_free(accel->bottom);
    rmap_free(accel->object);
}

/* Which joints marked objects have; or marks the objects that have these. */
static void spread(const struct rmap_accel *accel, uint8_t *joint, uint8_t *mark, bool to_objects)
{
    for (size_t i = 0; i < accel->n_object; i++) {
        const struct rmap_object_rims *rims = accel->object[i].rims;
        for (int k = 0; rims && k < rims->n; k++)
            if (rims->joint[k] < 0)
                continue;
            else if (to_objects)
                mark[i] |= joint[rims->joint[k]];
            else
                joint[rims->joint[k]] |= mark[i];
    }
}

enum rmap_status rmap_accel_mark_joined(const struct rmap_scene *scene, uint8_t *mark,
                                        struct rmap_error *err)
{
    struct rmap_accel accel = {.n_object = 0};
    uint8_t *joint = NULL;
    enum rmap_status st = begin(scene, &accel, err);
    if (st != RMAP_OK)
        goto out;
    joint = rmap_alloc(accel.n_joint, 1);
    if (!joint) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu joints", accel.n_joint);
        goto out;
    }
    spread(&accel, joint, mark, false);
    spread(&accel, joint, mark, true);
out:
    rmap_free(joint);
    end(&accel);
    return st;
}

double rmap_places_rounding(const struct rmap_scene *scene)
{
    return 8 * RMAP_FLOAT_EPS * (rmap_length(scene->centre) + scene->radius);
}

enum rmap_status rmap_places_add(struct rmap_places *places, const struct rmap_affine *to_world,
                                 struct rmap_vec3 lower, struct rmap_vec3 upper, double pad,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_RESERVE(places->place, places->cap, places->n + 1, err);
    struct rmap_place box = {.world_lower = lower, .world_upper = upper};
    if (st != RMAP_OK)
        return st;
    rmap_world_box(to_world, &box.world_lower, &box.world_upper);
    box.world_lower = rmap_sub(box.world_lower, rmap_vec3(pad, pad, pad));
    box.world_upper = rmap_add(box.world_upper, rmap_vec3(pad, pad, pad));
    if (!rmap_affine_invert(to_world, &box.to_local)) /* the box in the world must do */
        box = (struct rmap_place){.lower = box.world_lower,
                                  .upper = box.world_upper,
                                  .to_local = rmap_affine_identity(),
                                  .world_lower = box.world_lower,
                                  .world_upper = box.world_upper};
    else {
        const double wide = pad * rmap_affine_norm(&box.to_local);
        box.lower = rmap_sub(lower, rmap_vec3(wide, wide, wide));
        box.upper = rmap_add(upper, rmap_vec3(wide, wide, wide));
    }
    places->lower = places->n ? rmap_least(places->lower, box.world_lower) : box.world_lower;
    places->upper = places->n ? rmap_greatest(places->upper, box.world_upper) : box.world_upper;
    places->place[places->n++] = box;
    return RMAP_OK;
}

enum rmap_status rmap_accel_add_places(const struct rmap_scene *scene, const uint8_t *mark,
                                       struct rmap_places *places, struct rmap_error *err)
{
    struct rmap_accel accel = {.n_object = 0};
    enum rmap_status st = begin(scene, &accel, err);
    double widest = 0;
    RMAP_TRY(st);
    for (size_t i = 0; i < accel.n_object; i++)
        widest = rmap_greater(widest, accel.object[i].tolerance);
    for (size_t i = 0; i < accel.n_object; i++) {
        const struct rmap_accel_object *object = &accel.object[i];
        const double pad =
            RMAP_GRAZING_MAX * (widest + object->tolerance) + rmap_places_rounding(scene);
        for (int k = 0; mark[i] && k < rmap_part_count(object); k++) {
            struct rmap_vec3 lower, upper;
            rmap_part_bounds(object, k, &lower, &upper);
            RMAP_TRY(rmap_places_add(places, &object->to_world, lower, upper, pad, err));
        }
    }
out:
    end(&accel);
    return st;
}

void rmap_places_fini(struct rmap_places *places)
{
    rmap_free(places->place);
    *places = (struct rmap_places){.n = 0};
}

/* Narrows the part [*near, *far] of the way on which one coordinate lies in its interval. */
static bool within(double lower, double upper, double from, double to, double *near, double *far)
{
    if (from == to)
        return lower <= from && from <= upper;
    const double a = (lower - from) / (to - from), b = (upper - from) / (to - from);
    *near = rmap_greater(*near, rmap_lesser(a, b));
    *far = rmap_lesser(*far, rmap_greater(a, b));
    return *near <= *far;
}

static bool meets(struct rmap_vec3 lower, struct rmap_vec3 upper, struct rmap_vec3 from,
                  struct rmap_vec3 to)
{
    double near = 0, far = 1;
    return within(lower.x, upper.x, from.x, to.x, &near, &far) &&
           within(lower.y, upper.y, from.y, to.y, &near, &far) &&
           within(lower.z, upper.z, from.z, to.z, &near, &far);
}

bool rmap_places_meet(const struct rmap_places *places, struct rmap_vec3 from, struct rmap_vec3 to)
{
    if (places->n == 0 || !meets(places->lower, places->upper, from, to))
        return false;
    for (size_t i = 0; i < places->n; i++) {
        const struct rmap_place *place = &places->place[i];
        if (meets(place->world_lower, place->world_upper, from, to) &&
            meets(place->lower, place->upper, rmap_affine_point(&place->to_local, from),
                  rmap_affine_point(&place->to_local, to)))
            return true;
    }
    return false;
}

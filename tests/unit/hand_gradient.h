/* SPDX-License-Identifier: MIT
 *
 * Hand-built scenes with gradient media. Include after cmocka.h.
 */
#ifndef HAND_GRADIENT_H
#define HAND_GRADIENT_H

#include "build_scene.h"
#include "gradient/field_polynomial.h"
#include "gradient/models.h"
#include "hand_bench.h"

/* A medium with this field; the scene owns it. */
static inline int32_t add_gradient(struct rmap_scene *scene, struct rmap_field *field)
{
    int32_t medium = hand_medium(scene, 1.5);
    scene->medium[medium].field = field;
    return medium;
}

/* In the world's frame, for objects to share. */
static inline void add_place(struct rmap_scene *scene, int32_t medium)
{
    scene->gradient = rmap_alloc(1, sizeof *scene->gradient);
    scene->gradient[0] =
        (struct rmap_gradient){.medium = medium, .to_world = rmap_affine_identity()};
    scene->n_gradient = 1;
}

static inline struct rmap_field *luneburg(double radius)
{
    struct rmap_field *field = NULL;
    const struct rmap_luneburg parameter = {1.0, radius};
    assert_int_equal(rmap_field_luneburg(&field, 1, &parameter, NULL), RMAP_OK);
    return field;
}

static inline struct rmap_field *parabolic(double n0, double alpha)
{
    struct rmap_field *field = NULL;
    const struct rmap_parabolic parameter = {n0, alpha};
    assert_int_equal(rmap_field_parabolic(&field, 1, &parameter, NULL), RMAP_OK);
    return field;
}

/* All light goes through, but for total reflection. */
static inline int32_t add_clear(struct rmap_scene *scene)
{
    int32_t surface = hand_surface(scene, RMAP_SURFACE_FRESNEL);
    scene->surface[surface].coat = RMAP_COAT_IDEAL;
    return surface;
}

static inline int32_t sphere(struct rmap_scene *scene, double radius)
{
    return hand_shape(scene, (struct rmap_shape){.type = RMAP_SHAPE_SPHERE, .radius = radius});
}

static inline int32_t mesh_ball(struct rmap_scene *scene, uint32_t n)
{
    scene->geometry[scene->n_geometry].kind = RMAP_GEOMETRY_MESH;
    scene->geometry[scene->n_geometry].mesh = make_ball(n);
    return (int32_t)scene->n_geometry++;
}

/* The one place of the only gradient medium, as the scene has resolved it. */
static inline struct rmap_curve_options *options(struct bench *b)
{
    assert_int_equal(b->scene->n_gradient, 1);
    return &b->scene->gradient[0].options;
}

/* A beam along +z at this height into a Luneburg lens of radius 1. */
static inline void open_luneburg(struct bench *b, double height)
{
    b->scene = hand_scene(1);
    hand_medium(b->scene, 1.0);
    int32_t medium = add_gradient(b->scene, luneburg(1.0));
    hand_object(b->scene, sphere(b->scene, 1.0), add_clear(b->scene), rmap_affine_identity(), 0,
                medium);
    hand_source(b->scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(height, 0, -3), rmap_vec3(0, 0, 1));
}

/* A rod of this radius and length, from z = 0 on, in air: three surfaces, one place. */
static inline int32_t add_rod(struct rmap_scene *scene, struct rmap_field *field, double radius,
                              double length, int32_t surface)
{
    int32_t medium = add_gradient(scene, field);
    int32_t side = hand_shape(
        scene, (struct rmap_shape){
                   .type = RMAP_SHAPE_TUBE, .radius = radius, .radius2 = radius, .length = length});
    int32_t cap =
        hand_shape(scene, (struct rmap_shape){.type = RMAP_SHAPE_DISC, .aperture = radius});
    hand_object(scene, side, surface, rmap_affine_identity(), 0, medium);
    hand_object(scene, cap, surface, rmap_affine_identity(), medium, 0);
    hand_object(scene, cap, surface, hand_shift(0, 0, length), 0, medium);
    add_place(scene, medium);
    scene->object[0].gradient_back = scene->object[1].gradient_front =
        scene->object[2].gradient_back = 1;
    return medium;
}

/* A constant index as a gradient medium: straight segments, the paths of a uniform one. */
static inline struct rmap_field *constant(double index)
{
    struct rmap_field *field = NULL;
    assert_int_equal(rmap_field_series(&field, RMAP_SERIES_Z, RMAP_SERIES_OF_N, 1, 1, &index, NULL),
                     RMAP_OK);
    return field;
}

#endif

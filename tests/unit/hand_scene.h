/* SPDX-License-Identifier: MIT
 *
 * Small scenes built by hand, for tests of what works on scenes without the scene reader.
 * Include after cmocka.h.
 */
#ifndef HAND_SCENE_H
#define HAND_SCENE_H

#include "base/alloc.h"
#include "scene/scene.h"

#define HAND_MAX 32 /* of each kind of thing */

/* Spectral, n channels at 450 nm and every 50 nm on. */
static inline struct rmap_scene *hand_scene(int n_channel)
{
    struct rmap_scene *scene = NULL;
    assert_int_equal(rmap_scene_create(&scene, NULL), RMAP_OK);
    scene->channels.mode = RMAP_COLOUR_SPECTRAL;
    scene->channels.n = n_channel;
    for (int i = 0; i < n_channel; i++)
        scene->channels.wavelength_nm[i] = 450.0 + 50.0 * i;
    scene->medium = rmap_alloc(HAND_MAX, sizeof *scene->medium);
    scene->surface = rmap_alloc(HAND_MAX, sizeof *scene->surface);
    scene->geometry = rmap_alloc(HAND_MAX, sizeof *scene->geometry);
    scene->object = rmap_alloc(HAND_MAX, sizeof *scene->object);
    scene->group = rmap_alloc(HAND_MAX, sizeof *scene->group);
    scene->source = rmap_alloc(HAND_MAX, sizeof *scene->source);
    scene->detector = rmap_alloc(HAND_MAX, sizeof *scene->detector);
    return scene;
}

static inline int32_t hand_medium(struct rmap_scene *scene, double index)
{
    struct rmap_medium *medium = &scene->medium[scene->n_medium];
    for (int i = 0; i < scene->channels.n; i++)
        medium->n[i] = index;
    return (int32_t)scene->n_medium++;
}

/* Every share of it 0. */
static inline int32_t hand_surface(struct rmap_scene *scene, enum rmap_surface_type type)
{
    scene->surface[scene->n_surface].type = type;
    return (int32_t)scene->n_surface++;
}

static inline void hand_fill(const struct rmap_scene *scene, double *per_channel, double value)
{
    for (int i = 0; i < scene->channels.n; i++)
        per_channel[i] = value;
}

static inline int32_t hand_shape(struct rmap_scene *scene, struct rmap_shape shape)
{
    scene->geometry[scene->n_geometry].kind = RMAP_GEOMETRY_SHAPE;
    scene->geometry[scene->n_geometry].shape = shape;
    return (int32_t)scene->n_geometry++;
}

static inline int32_t hand_rectangle(struct rmap_scene *scene, double width, double height)
{
    return hand_shape(scene,
                      (struct rmap_shape){.type = RMAP_SHAPE_RECTANGLE, .size = {width, height}});
}

/* One surface and placement; the front is the side of the normal. */
static inline int32_t hand_object(struct rmap_scene *scene, int32_t geometry, int32_t surface,
                                  struct rmap_affine to_world, int32_t front, int32_t back)
{
    struct rmap_object *object = &scene->object[scene->n_object];
    object->id = scene->n_object + 1;
    object->parent = -1;
    object->geometry = geometry;
    object->to_world = to_world;
    object->surface_front = object->surface_back = surface;
    object->medium_front = front;
    object->medium_back = back;
    return (int32_t)scene->n_object++;
}

static inline struct rmap_affine hand_shift(double x, double y, double z)
{
    struct rmap_affine affine = rmap_affine_identity();
    affine.t = rmap_vec3(x, y, z);
    return affine;
}

/* At a point, along an axis, in medium 0, of equal shares. */
static inline struct rmap_source *hand_source(struct rmap_scene *scene, enum rmap_source_type type,
                                              struct rmap_vec3 at, struct rmap_vec3 axis)
{
    struct rmap_source *source = &scene->source[scene->n_source++];
    source->type = type;
    source->shape = RMAP_EMITTER_POINT;
    source->frame = rmap_affine_frame(axis, at);
    source->share = 1.0;
    source->flux = 1.0;
    hand_fill(scene, source->colour, 1.0 / scene->channels.n);
    return source;
}

/* A plane with its x and y along the world's, axis +z or -z, accepting both sides. */
static inline struct rmap_detector *hand_detector(struct rmap_scene *scene, struct rmap_vec3 at,
                                                  double axis_z, double size)
{
    struct rmap_detector *detector = &scene->detector[scene->n_detector++];
    detector->type = RMAP_DETECTOR_PLANE;
    detector->origin = at;
    detector->x = rmap_vec3(1.0, 0.0, 0.0);
    detector->axis = rmap_vec3(0.0, 0.0, axis_z);
    detector->y = rmap_cross(detector->axis, detector->x);
    detector->size[0] = detector->size[1] = size;
    detector->cells[0] = detector->cells[1] = 10;
    detector->side = RMAP_SIDE_BOTH;
    detector->max_angle_rad = 0.5 * RMAP_PI;
    detector->on_object = detector->on_group = -1;
    return detector;
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * A small scene with every kind of name, and portions written by hand, for the criterion's tests.
 *
 *   object 0 lens.1   group lens       polished, shape, air in front, glass behind
 *          1 tube     group housing    black, mesh of 8 triangles, faces 0 0 0 1 1 2 2 2
 *          2 lens.2   group lens       coated in front and behind, shape
 *          3 cover    group housing    front white, back black, air on both sides
 *          4 mirror   no group         front mirror, back black, air in front, glass behind
 *          5 'odd näme'  no group      mixed
 *   group lens lies in group housing. So housing has the objects 0 to 3.
 *   detector 0 sensor, free; 1 screen, on the tube; 2 far, an intensity grid
 */
#ifndef RMAP_TEST_CRITERION_SCENE_H
#define RMAP_TEST_CRITERION_SCENE_H

#include <math.h>
#include <string.h>

#include "base/vec.h"
#include "portion/event.h"
#include "portion/portion.h"
#include "scene/scene.h"

struct test_scene {
    struct rmap_scene scene;
    struct rmap_medium medium[3];
    struct rmap_surface surface[5];
    struct rmap_geometry geometry[2];
    struct rmap_mesh mesh;
    uint32_t face[8];
    struct rmap_object object[6];
    struct rmap_group group[2];
    struct rmap_source source[2];
    struct rmap_detector detector[3];
    char name[24][16];
    int n_name;
};

static inline char *test_name(struct test_scene *t, const char *name)
{
    char *slot = t->name[t->n_name++];
    strncpy(slot, name, sizeof t->name[0] - 1);
    return slot;
}

static inline void test_scene_optics(struct test_scene *t)
{
    static const char *const medium[] = {"air", "glass", "ink"};
    static const char *const surface[] = {"polished", "black", "coated", "white", "mixed"};
    static const enum rmap_surface_type type[] = {RMAP_SURFACE_FRESNEL, RMAP_SURFACE_ABSORBER,
                                                  RMAP_SURFACE_FRESNEL, RMAP_SURFACE_LAMBERT,
                                                  RMAP_SURFACE_MIXTURE};
    for (int i = 0; i < 3; i++)
        t->medium[i].name = test_name(t, medium[i]);
    for (int i = 0; i < 5; i++) {
        t->surface[i].name = test_name(t, surface[i]);
        t->surface[i].type = type[i];
    }
    t->surface[2].coat = RMAP_COAT_REFLECTANCE;
    for (int c = 0; c < 3; c++) {
        t->surface[2].reflect_specular[c] = 0.05;
        t->surface[3].reflect_diffuse[c] = 0.8;
        t->surface[4].reflect_specular[c] = 0.1 * c; /* mean 0.1 */
        t->surface[4].reflect_diffuse[c] = 0.2;
        t->surface[4].transmit_specular[c] = 0.3;
        t->surface[4].transmit_diffuse[c] = 0.15;
    }
}

static inline void test_scene_bodies(struct test_scene *t)
{
    static const uint32_t face[8] = {0, 0, 0, 1, 1, 2, 2, 2};
    static const struct {
        const char *name;
        int32_t parent, geometry, surface_front, surface_back, medium_front, medium_back;
    } object[6] = {
        {"lens.1", 1, 0, 0, 0, 0, 1},  {"tube", 0, 1, 1, 1, 0, 0},
        {"lens.2", 1, 0, 2, 2, 1, 0},  {"cover", 0, 0, 3, 1, 0, 0},
        {"mirror", -1, 0, 4, 1, 0, 1}, {"odd n\xc3\xa4me", -1, 0, 4, 4, RMAP_MEDIUM_ANY, 0},
    };
    memcpy(t->face, face, sizeof face);
    t->mesh = (struct rmap_mesh){.n_triangle = 8, .n_face = 3, .face = t->face};
    t->geometry[1] = (struct rmap_geometry){.kind = RMAP_GEOMETRY_MESH, .mesh = &t->mesh};
    for (int i = 0; i < 6; i++)
        t->object[i] = (struct rmap_object){.name = test_name(t, object[i].name),
                                            .parent = object[i].parent,
                                            .geometry = object[i].geometry,
                                            .surface_front = object[i].surface_front,
                                            .surface_back = object[i].surface_back,
                                            .medium_front = object[i].medium_front,
                                            .medium_back = object[i].medium_back};
    t->group[0] = (struct rmap_group){.name = test_name(t, "housing"), .parent = -1};
    t->group[1] = (struct rmap_group){.name = test_name(t, "lens"), .parent = 0};
}

static inline void test_scene_ends(struct test_scene *t)
{
    t->source[0].name = test_name(t, "lamp");
    t->source[1].name = test_name(t, "sun");
    t->detector[0] = (struct rmap_detector){.name = test_name(t, "sensor"),
                                            .on_object = -1,
                                            .on_group = -1,
                                            .type = RMAP_DETECTOR_PLANE,
                                            .size = {36.0, 24.0},
                                            .axis = {0, 0, -1}};
    t->detector[1] = (struct rmap_detector){.name = test_name(t, "screen"),
                                            .on_object = 1,
                                            .on_group = -1,
                                            .type = RMAP_DETECTOR_PLANE,
                                            .size = {2.0, 2.0},
                                            .axis = {1, 0, 0}};
    t->detector[2] = (struct rmap_detector){.name = test_name(t, "far"),
                                            .on_object = -1,
                                            .on_group = -1,
                                            .type = RMAP_DETECTOR_INTENSITY,
                                            .size = {RMAP_PI, 2 * RMAP_PI},
                                            .axis = {0, 0, 1}};
}

/* The scene lives in *t; nothing to release. */
static inline void test_scene_init(struct test_scene *t)
{
    memset(t, 0, sizeof *t);
    test_scene_optics(t);
    test_scene_bodies(t);
    test_scene_ends(t);
    t->scene = (struct rmap_scene){.unit = test_name(t, "mm"),
                                   .unit_m = 1e-3,
                                   .channels = {.mode = RMAP_COLOUR_RGB, .n = 3},
                                   .flux_unit = RMAP_FLUX_W,
                                   .n_medium = 3,
                                   .n_surface = 5,
                                   .n_geometry = 2,
                                   .n_object = 6,
                                   .n_group = 2,
                                   .n_source = 2,
                                   .n_detector = 3,
                                   .medium = t->medium,
                                   .surface = t->surface,
                                   .geometry = t->geometry,
                                   .object = t->object,
                                   .group = t->group,
                                   .source = t->source,
                                   .detector = t->detector};
}

/* What a portion's rows say; a row that is 0 where it does not matter. */
struct test_ray {
    uint64_t id;
    int32_t source;
    uint8_t stop;
    double weight, wavelength, path_length, optical_path;
    float start[3];
};

struct test_step {
    int32_t object, primitive;
    uint32_t event;
    int16_t medium;
    float position[3];
    int16_t normal[3];
};

struct test_registration {
    int32_t detector;
    uint16_t cell[2], relative[2];
    uint8_t registered;
    float direction[3];
    double optical_path;
    uint32_t segment;
};

/* Appends a ray; its steps and registrations follow. False: out of memory. */
static inline bool test_add_ray(struct rmap_portion *p, const struct test_ray *ray)
{
    if (rmap_portion_reserve(p, RMAP_TABLE_RAY, 1, RMAP_COLUMNS_ALL, NULL) != RMAP_OK)
        return false;
    size_t i = p->n_row[RMAP_TABLE_RAY]++;
    p->ray.id[i] = ray->id;
    p->ray.source[i] = ray->source;
    p->ray.stop[i] = ray->stop;
    p->ray.weight[i] = ray->weight;
    p->ray.wavelength[i] = ray->wavelength;
    p->ray.path_length[i] = ray->path_length;
    p->ray.optical_path[i] = ray->optical_path;
    p->ray.segment_count[i] = 0;
    p->ray.registration_count[i] = 0;
    memcpy(p->ray.start + 3 * i, ray->start, sizeof ray->start);
    return true;
}

static inline bool test_add_step(struct rmap_portion *p, const struct test_step *step)
{
    if (rmap_portion_reserve(p, RMAP_TABLE_SEGMENT, 1, RMAP_COLUMNS_ALL, NULL) != RMAP_OK)
        return false;
    size_t i = p->n_row[RMAP_TABLE_SEGMENT]++;
    p->ray.segment_count[p->n_row[RMAP_TABLE_RAY] - 1]++;
    p->segment.object[i] = step->object;
    p->segment.primitive[i] = step->primitive;
    p->segment.event[i] = step->event;
    p->segment.medium[i] = step->medium;
    memcpy(p->segment.position + 3 * i, step->position, sizeof step->position);
    memcpy(p->segment.normal + 3 * i, step->normal, sizeof step->normal);
    return true;
}

static inline bool test_add_registration(struct rmap_portion *p, const struct test_registration *r)
{
    if (rmap_portion_reserve(p, RMAP_TABLE_REGISTRATION, 1, RMAP_COLUMNS_ALL, NULL) != RMAP_OK)
        return false;
    size_t i = p->n_row[RMAP_TABLE_REGISTRATION]++;
    p->ray.registration_count[p->n_row[RMAP_TABLE_RAY] - 1]++;
    p->registration.detector[i] = r->detector;
    memcpy(p->registration.cell + 2 * i, r->cell, sizeof r->cell);
    memcpy(p->registration.relative + 2 * i, r->relative, sizeof r->relative);
    p->registration.registered[i] = r->registered;
    memcpy(p->registration.direction + 3 * i, r->direction, sizeof r->direction);
    p->registration.optical_path[i] = r->optical_path;
    p->registration.segment[i] = r->segment;
    return true;
}

#endif

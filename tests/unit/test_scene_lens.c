/* SPDX-License-Identifier: MIT
 *
 * A prescription becomes caps, edges and a stop, with the right media on their sides.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "tests/unit/near.h"
#include "tests/unit/read_text.h"

/* A cemented doublet, a stop in the air, and a plate whose second side is wider. */
#define HEAD                                                                                       \
    "raymap: 1\n"                                                                                  \
    "media: {air: {index: 1}, crown: {index: 1.5}, flint: {index: 1.7}}\n"                         \
    "surfaces: {coat: {type: fresnel, coat: ideal}, paint: {type: lambert, reflectance: 0.1}}\n"   \
    "sources: [{name: s, type: point, at: [0, 0, -50]}]\n"
#define TABLE                                                                                      \
    "geometries:\n"                                                                                \
    "  tele:\n"                                                                                    \
    "    type: lens\n"                                                                             \
    "    surface: coat\n"                                                                          \
    "    edge: paint\n"                                                                            \
    "    surfaces:\n"                                                                              \
    "      - {radius: 50, thickness: 6, medium: crown, aperture: 10}\n"                            \
    "      - {curvature: -0.02, thickness: 2, medium: flint, aperture: 10}\n"                      \
    "      - {thickness: 3, medium: air, aperture: 9}\n"                                           \
    "      - {thickness: 4, medium: air, aperture: 5, stop: true}\n"                               \
    "      - {radius: 0, thickness: 2, medium: N-BK7, aperture: 6}\n"                              \
    "      - {radius: inf, medium: air, aperture: 8}\n"

static struct rmap_scene *must_read(const char *text)
{
    char *told = NULL;
    struct rmap_scene *scene = read_text(text, &told);
    assert_string_equal(told, "");
    assert_non_null(scene);
    free(told);
    return scene;
}

static const struct rmap_object *object(const struct rmap_scene *scene, const char *name)
{
    for (size_t i = 0; i < scene->n_object; i++)
        if (strcmp(scene->object[i].name, name) == 0)
            return &scene->object[i];
    return NULL;
}

static const struct rmap_shape *shape(const struct rmap_scene *scene, const char *name)
{
    return &scene->geometry[object(scene, name)->geometry].shape;
}

static void assert_sides(const struct rmap_scene *scene, const char *name, const char *front,
                         const char *back, const char *surface)
{
    const struct rmap_object *o = object(scene, name);
    assert_non_null(o);
    assert_string_equal(scene->medium[o->medium_front].name, front);
    assert_string_equal(scene->medium[o->medium_back].name, back);
    assert_string_equal(scene->surface[o->surface_front].name, surface);
    assert_string_equal(scene->surface[o->surface_back].name, surface);
}

static void test_caps(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read(HEAD TABLE "objects: [{name: t, geometry: tele, outside: air}]\n");
    assert_sides(scene, "t.1", "crown", "air", "coat");
    assert_sides(scene, "t.2", "flint", "crown", "coat");
    assert_sides(scene, "t.3", "air", "flint", "coat");
    assert_sides(scene, "t.5", "N-BK7", "air", "coat");
    assert_sides(scene, "t.6", "air", "N-BK7", "coat");
    assert_null(object(scene, "t.4"));
    assert_near(object(scene, "t.2")->to_world.t.z, 6, 0);
    assert_near(object(scene, "t.6")->to_world.t.z, 17, 0);
    assert_near(shape(scene, "t.2")->curvature, -0.02, 0);
    assert_near(shape(scene, "t.6")->curvature, 0, 0);
    assert_int_equal(scene->n_object, 6 + 3);
    rmap_scene_destroy(scene);
}

static void test_edges(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read(HEAD TABLE "objects: [{name: t, geometry: tele, outside: air}]\n");
    double sag = 50 - sqrt(50.0 * 50 - 100); /* of radius 50 at 10 */
    assert_sides(scene, "t.edge.1", "air", "crown", "paint");
    assert_sides(scene, "t.edge.2", "air", "flint", "paint");
    assert_sides(scene, "t.edge.3", "air", "N-BK7", "paint");
    assert_near(object(scene, "t.edge.1")->to_world.t.z, sag, 1e-12);
    assert_near(shape(scene, "t.edge.1")->length, 6 - 2 * sag, 1e-12);
    assert_near(shape(scene, "t.edge.1")->radius, 10, 0);
    assert_near(shape(scene, "t.edge.1")->radius2, 10, 0);
    assert_near(shape(scene, "t.edge.2")->radius2, 9, 0);
    assert_near(shape(scene, "t.edge.3")->radius, 6, 0);
    assert_near(shape(scene, "t.edge.3")->radius2, 8, 0);
    rmap_scene_destroy(scene);
}

static void test_stop(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read(HEAD TABLE "objects: [{name: t, geometry: tele, outside: air}]\n");
    const struct rmap_object *stop = object(scene, "t.stop");
    assert_non_null(stop);
    assert_near(stop->to_world.t.z, 11, 0);
    assert_near(shape(scene, "t.stop")->inner, 5, 0);
    assert_near(shape(scene, "t.stop")->aperture, 10, 0);
    assert_string_equal(scene->surface[stop->surface_front].name, "paint");
    assert_int_equal(stop->medium_front, RMAP_MEDIUM_ANY);
    assert_string_equal(scene->group[stop->parent].name, "t.4");
    assert_string_equal(scene->group[scene->group[stop->parent].parent].name, "t");
    rmap_scene_destroy(scene);
}

static void test_instances_share_geometries(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read(HEAD TABLE "objects:\n"
                             "  - {name: t, geometry: tele, outside: air}\n"
                             "  - {name: u, geometry: tele, outside: air, at: [100, 0, 0], "
                             "surface: paint, edge: coat, rotate: [0, 180, 0]}\n");
    assert_int_equal(scene->n_object, 18);
    assert_int_equal(scene->n_geometry, 9);
    assert_int_equal(object(scene, "t.2")->geometry, object(scene, "u.2")->geometry);
    assert_near(object(scene, "u.2")->to_world.t.z, -6, 1e-12);
    assert_near(object(scene, "u.2")->to_world.t.x, 100, 1e-12);
    assert_sides(scene, "u.2", "flint", "crown", "paint");
    assert_sides(scene, "u.edge.2", "air", "flint", "coat");
    /* Edges that let light through do not make the stop transparent. */
    assert_string_equal(scene->surface[object(scene, "u.stop")->surface_front].name, "absorber");
    assert_true(object(scene, "t.1")->id != object(scene, "u.1")->id);
    rmap_scene_destroy(scene);
}

/* In glass all around, the air gaps are what has edges. */
static void test_outside_decides_the_edges(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read(HEAD TABLE "objects: [{name: t, geometry: tele, outside: crown}]\n");
    assert_sides(scene, "t.1", "crown", "crown", "coat");
    assert_sides(scene, "t.edge.1", "crown", "flint", "paint");
    assert_sides(scene, "t.edge.2", "crown", "air", "paint"); /* around the stop, from 3 to 5 */
    assert_near(shape(scene, "t.edge.2")->length, 7, 1e-12);
    assert_sides(scene, "t.edge.3", "crown", "N-BK7", "paint");
    assert_null(object(scene, "t.edge.4"));
    rmap_scene_destroy(scene);
}

/* The second rim may lie before the first one, or beside it: the glass is then in front. */
static void test_edges_that_run_back(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read(HEAD "geometries:\n"
                       "  back:\n"
                       "    type: lens\n"
                       "    surfaces:\n"
                       "      - {thickness: 1, medium: crown, aperture: 4}\n"
                       "      - {radius: -20, medium: air, aperture: 10}\n"
                       "  flush:\n"
                       "    type: lens\n"
                       "    surfaces:\n"
                       "      - {thickness: 8, medium: crown, aperture: 8}\n"
                       "      - {radius: -20, medium: air, aperture: 16}\n"
                       "objects:\n"
                       "  - {name: b, geometry: back, outside: air}\n"
                       "  - {name: f, geometry: flush, outside: air, at: [0, 0, 99]}\n");
    assert_sides(scene, "b.edge.1", "crown", "air", "absorber");
    assert_near(object(scene, "b.edge.1")->to_world.t.z, 1 - (20 - sqrt(300)), 1e-12);
    assert_near(shape(scene, "b.edge.1")->radius, 10, 0);
    assert_near(shape(scene, "b.edge.1")->radius2, 4, 0);
    assert_sides(scene, "f.edge.1", "crown", "air", "absorber"); /* 8 - sag(16) = 0 */
    assert_int_equal(shape(scene, "f.edge.1")->type, RMAP_SHAPE_DISC);
    assert_near(shape(scene, "f.edge.1")->inner, 8, 0);
    assert_near(shape(scene, "f.edge.1")->aperture, 16, 0);
    rmap_scene_destroy(scene);
}

static void test_stop_on_a_refracting_row(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        HEAD "geometries:\n"
             "  one:\n"
             "    type: lens\n"
             "    surfaces:\n"
             "      - {radius: 50, thickness: 4, medium: crown, aperture: 10, stop: true}\n"
             "      - {radius: -50, medium: air, aperture: 10, conic: -1, asphere: {4: 1.0e-5}}\n"
             "objects: [{name: l, geometry: one, outside: air}]\n");
    assert_sides(scene, "l.1", "crown", "air", "fresnel");
    assert_sides(scene, "l.edge.1", "air", "crown", "absorber");
    assert_near(shape(scene, "l.stop")->inner, 10, 0);
    assert_near(shape(scene, "l.stop")->aperture, 15, 0);
    assert_near(object(scene, "l.stop")->to_world.t.z, 50 - sqrt(2400), 1e-12);
    assert_near(shape(scene, "l.2")->asphere[1], 1e-5, 0);
    rmap_scene_destroy(scene);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_caps),
        cmocka_unit_test(test_edges),
        cmocka_unit_test(test_stop),
        cmocka_unit_test(test_instances_share_geometries),
        cmocka_unit_test(test_outside_decides_the_edges),
        cmocka_unit_test(test_edges_that_run_back),
        cmocka_unit_test(test_stop_on_a_refracting_row),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

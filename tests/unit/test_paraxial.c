/* SPDX-License-Identifier: MIT
 *
 * First-order numbers of lenses against closed forms, a published design, and their own laws.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "scene/paraxial.h"
#include "tests/unit/read_text.h"

#define HEAD                                                                                       \
    "raymap: 1\nmedia: {air: {index: 1}, water: {index: 1.33}, glass: {index: 1.5}}\n"             \
    "surfaces: {clear: {type: fresnel}}\ngeometries:\n  g: {type: lens, surface: clear, "          \
    "surfaces: ["
#define TAIL(more)                                                                                 \
    "]}\nobjects:\n  - {name: l, geometry: g, outside: air" more                                   \
    "}\nsources: [{name: s, type: point, medium: air}]\n"

static int meridians_of(const char *text, struct rmap_paraxial p[2])
{
    char *told = NULL;
    struct rmap_scene *scene = read_text(text, &told);
    if (!scene)
        fail_msg("%s", told);
    const int n = rmap_paraxial_of(scene, 0, 0, p);
    rmap_scene_destroy(scene);
    free(told);
    return n;
}

static struct rmap_paraxial of(const char *text)
{
    struct rmap_paraxial p[2];
    assert_int_equal(meridians_of(text, p), 1);
    return p[0];
}

static void near(double found, double wanted)
{
    if (!(fabs(found - wanted) <= 1e-12 * (1.0 + fabs(wanted))))
        fail_msg("%.17g, wanted %.17g", found, wanted);
}

/* Lensmaker's equation of a thick lens; a tilt, a shift and a scale change nothing but the unit. */
static void test_thick_lens(void **state)
{
    (void)state;
    const double n = 1.5, r1 = 50.0, r2 = -80.0, d = 10.0;
    const double power = (n - 1) * (1 / r1 - 1 / r2 + (n - 1) * d / (n * r1 * r2));
#define LENS                                                                                       \
    "{radius: 50, thickness: 10, medium: glass, aperture: 9}, {radius: -80, medium: air, "         \
    "aperture: 9}"
    struct rmap_paraxial p = of(HEAD LENS TAIL(""));
    near(p.focal_length, 1 / power);
    near(p.back_focus, 1 / power * (1 - (n - 1) * d / (n * r1)));
    near(p.front_focus, -1 / power * (1 + (n - 1) * d / (n * r2)));
    near(p.entrance, 0.0); /* the first rim limits */
    near(p.entrance_diameter, 18.0);
    near(p.f_number, 1 / power / 18.0);
    p = of(HEAD LENS TAIL(", at: [1, 2, 3], rotate: [20, 30, 40], scale: 2"));
    near(p.focal_length, 2 / power);
    near(p.entrance_diameter, 36.0);
}

/* A ball: f = n R / (2 (n - 1)), from its centre. Into water: Gullstrand's equation. */
static void test_ball_and_immersion(void **state)
{
    (void)state;
    struct rmap_paraxial p = of(HEAD "{radius: 6, thickness: 12, medium: glass, aperture: 3}, "
                                     "{radius: -6, medium: air, aperture: 3}" TAIL(""));
    near(p.focal_length, 1.5 * 6 / (2 * 0.5));
    near(p.back_focus, p.focal_length - 6);
    p = of(HEAD "{radius: 50, thickness: 10, medium: glass, aperture: 9}, "
                "{radius: -80, medium: water, aperture: 9}" TAIL(""));
    near(p.index[1], 1.33);
    const double c1 = 1 / 50.0, c2 = -1 / 80.0, first = c1 * 0.5, second = c2 * (1.33 - 1.5);
    near(p.focal_length, 1.33 / (first + second - first * second * 10 / 1.5));
}

/* A stop in front: the entrance pupil is the stop itself, the exit pupil its image. */
static void test_stop(void **state)
{
    (void)state;
    const struct rmap_paraxial p =
        of(HEAD "{curvature: 0, thickness: 20, medium: air, aperture: 4, stop: true}, "
                "{radius: 50, thickness: 10, medium: glass, aperture: 12}, "
                "{radius: -80, medium: air, aperture: 12}" TAIL(""));
    near(p.entrance_diameter, 8.0);
    near(p.entrance, 0.0);
    /* Newton: x x' = -f^2 from the focal points, magnification f / x */
    const double x = p.entrance - p.front_focus, image = p.exit - p.back_focus;
    near(x * image, -p.focal_length * p.focal_length);
    near(p.exit_diameter, fabs(8.0 * p.focal_length / x));
    /* at the last surface: refracted, slope 1 becomes (1 - 20 / 50 / 2) / 1.5 */
    near(p.field_deg, atan(12.0 / (20.0 + 10.0 * 0.8 / 1.5)) * 180.0 / RMAP_PI);
}

/* CODE V's sample dblgauss: EFL 100.0038 mm. */
static void test_double_gauss(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rmap_bundle *bundle = NULL;
    struct rmap_scene *scene = NULL;
    struct rmap_diagnostics diagnostics;
    struct rmap_paraxial p = {.n_surface = 0}, its[2];
    const char *path = RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml";
    rmap_diagnostics_init(&diagnostics, path);
    assert_int_equal(rmap_bundle_open(path, &(struct rmap_scene_options){0}, &bundle, &err),
                     RMAP_OK);
    assert_int_equal(rmap_scene_read(bundle, &scene, &diagnostics, &err), RMAP_OK);
    size_t n = 0;
    for (int32_t g = 0; g < (int32_t)scene->n_group; g++) {
        if (strcmp(scene->group[g].name, "lens") != 0)
            continue;
        assert_int_equal(rmap_paraxial_of(scene, g, 1, its), 1);
        p = its[0];
        n++;
    }
    assert_int_equal(n, 1);
    assert_true(fabs(p.focal_length - 100.0038) < 2e-4);
    assert_string_equal(scene->object[p.stop].name, "lens.stop");
    /* exit pupil: image of the entrance pupil */
    const double x = p.entrance - p.front_focus, image = p.exit - p.back_focus;
    assert_true(fabs(x * image + p.focal_length * p.focal_length) < 1e-8);
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(bundle);
    rmap_diagnostics_fini(&diagnostics);
}

/* Thick lenses in two planes: biconic in front, toroid (or an xy polynomial) behind; turned by 90
 * degrees they change places; by 30 there is none. */
static void test_meridians(void **state)
{
    (void)state;
    const double n = 1.5, d = 6.0, r[2][2] = {{40.0, 70.0}, {-90.0, -55.0}};
    static const char *const back[] = {
        "{toroid: -90, radius: -55, medium: air, aperture: {rectangle: [12, 16]}}",
        "{curvature: 0, xy: {norm: 1, terms: {x2y0: -0.005555555555555556, x0y2: "
        "-0.009090909090909091, x3y0: 1e-4, x2y2: 1e-5}}, medium: air, aperture: {rectangle: [12, "
        "16]}}"};
    struct rmap_paraxial p[2];
    char text[1000];
    for (int b = 0; b < 2; b++) {
        (void)snprintf(text, sizeof text,
                       HEAD "{radius: [40, 70], conic: [-1, 0.5], thickness: 6, medium: glass, "
                            "aperture: {rectangle: [12, 16]}}, %s" TAIL(
                                ", at: [1, 2, 3], rotate: [20, 30, 40], scale: 2"),
                       back[b]);
        assert_int_equal(meridians_of(text, p), 2);
        for (int k = 0; k < 2; k++) {
            const double power =
                (n - 1) * (1 / r[0][k] - 1 / r[1][k] + (n - 1) * d / (n * r[0][k] * r[1][k]));
            const double bfl = 1 / power * (1 - (n - 1) * d / (n * r[0][k]));
            if (fabs(p[k].focal_length - 2 / power) > 1e-9 * fabs(p[k].focal_length) ||
                fabs(p[k].back_focus - 2 * bfl) > 1e-9 * fabs(bfl))
                fail_msg("%d: EFL %.15g of %.15g, BFL %.15g of %.15g", k, p[k].focal_length,
                         2 / power, p[k].back_focus, 2 * bfl);
            near(p[k].entrance_diameter, 2.0 * (k == 0 ? 12.0 : 16.0));
        }
    }
    /* of one curvature, but a wide aperture: the same lens, other pupils */
    assert_int_equal(
        meridians_of(HEAD
                     "{radius: 50, thickness: 6, medium: glass, aperture: {rectangle: [8, "
                     "16]}}, {radius: -50, medium: air, aperture: {rectangle: [8, 16]}}" TAIL(""),
                     p),
        2);
    near(p[0].focal_length, p[1].focal_length);
    near(p[1].f_number * 2, p[0].f_number);
    /* bent between x and y: no such lens */
    assert_int_equal(
        meridians_of(HEAD
                     "{curvature: 0, xy: {norm: 1, terms: {x1y1: 0.01}}, thickness: 6, medium: "
                     "glass, aperture: 5}, {radius: -50, medium: air, aperture: 5}" TAIL(""),
                     p),
        0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_thick_lens), cmocka_unit_test(test_ball_and_immersion),
        cmocka_unit_test(test_stop),       cmocka_unit_test(test_double_gauss),
        cmocka_unit_test(test_meridians),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

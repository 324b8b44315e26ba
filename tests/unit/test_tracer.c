/* SPDX-License-Identifier: MIT
 *
 * The tracer on small scenes: exact paths, Fresnel's series, Lambert, limits, errors, the order of
 * a history.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_bench.h"
#include "near.h"
#include "optics/fresnel.h"

/* (1 - R) / (1 + R) goes through a clear slab, R the mean of s and p at the angle. */
static void clear_slab(void **state)
{
    (void)state;
    const double degrees[] = {0.0, 45.0, 75.0};
    for (int k = 0; k < 3; k++) {
        struct bench b = {.scene = hand_scene(1)};
        hand_medium(b.scene, 1.0);
        add_slab(b.scene, 1.52, 2.0, hand_surface(b.scene, RMAP_SURFACE_FRESNEL));
        add_beam(b.scene, degrees[k]);
        start(&b);
        enum { N = 40000 };
        double passed = 0.0, glossy = 0.0;
        for (uint64_t ray = 0; ray < N; ray++) {
            const struct rmap_history *h = trace(&b, ray);
            assert_int_equal(h->ending.stop, RMAP_STOP_LEFT);
            assert_int_equal(h->step[h->n_step - 1].events, RMAP_EVENT_LEFT);
            assert_near(fabs(h->ending.direction.z), cos(degrees[k] * RMAP_PI / 180.0), 1e-14);
            passed += h->ending.direction.z > 0.0;
            glossy += h->step[0].events == RMAP_EVENT_REFLECT_SPECULAR;
        }
        struct rmap_fresnel f =
            rmap_fresnel_dielectric(1.0, 1.52, cos(degrees[k] * RMAP_PI / 180.0));
        double r = 0.5 * (f.rs + f.rp), t = (1.0 - r) / (1.0 + r);
        assert_mean(passed, N, t, t * (1.0 - t));
        assert_mean(glossy, N, r, r * (1.0 - r));
        stop(&b);
    }
}

/* Positions, paths and media along the straight way through a slab. */
static void path_through_a_slab(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t surface = hand_surface(b.scene, RMAP_SURFACE_FRESNEL);
    b.scene->surface[surface].coat = RMAP_COAT_IDEAL;
    int32_t glass = add_slab(b.scene, 1.5, 3.0, surface);
    add_beam(b.scene, 30.0);
    start(&b);
    const struct rmap_history *h = trace(&b, 0);
    assert_int_equal(h->n_step, 3);
    double to_slab = 10.0 / cos(RMAP_PI / 6.0), sine = 0.5 / 1.5, cosine = sqrt(1.0 - sine * sine);
    assert_near(h->step[0].length, to_slab, 1e-14 * to_slab);
    assert_near(h->step[0].position.x, 10.0 * tan(RMAP_PI / 6.0), 1e-14);
    assert_near(h->step[1].length, 3.0 / cosine, 1e-14);
    assert_near(h->step[1].position.x, 10.0 * tan(RMAP_PI / 6.0) + 3.0 * sine / cosine, 1e-14);
    assert_near(h->step[1].direction.x, sine, 1e-15);
    assert_near(h->step[1].optical_path, to_slab + 1.5 * 3.0 / cosine, 1e-13);
    assert_int_equal(h->step[0].medium, 0);
    assert_int_equal(h->step[1].medium, glass);
    assert_int_equal(h->step[2].medium, 0);
    assert_int_equal(h->step[0].object, 0);
    assert_int_equal(h->step[1].object, 1);
    assert_int_equal(h->step[2].object, -1);
    assert_int_equal(h->step[2].primitive, -1);
    assert_true(h->step[2].length == 0.0);
    assert_near(rmap_length(rmap_sub(h->step[2].position, b.scene->centre)), b.scene->radius,
                1e-12 * b.scene->radius);
    assert_near(h->ending.direction.x, 0.5, 1e-15);
    assert_true(h->ending.path_length == h->step[0].length + h->step[1].length);
    assert_true(h->ending.optical_path == h->step[1].optical_path);
    assert_true(h->ending.wavelength_nm == 450.0);
    stop(&b);
}

/* Total reflection is an event of its own, and certain. */
static void total_reflection(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t glass = add_slab(b.scene, 1.5, 2.0, hand_surface(b.scene, RMAP_SURFACE_FRESNEL));
    struct rmap_source *source = hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, 1),
                                             rmap_vec3(sin(1.0), 0, cos(1.0)));
    source->medium = glass;
    b.scene->limit_steps = 50;
    start(&b);
    for (uint64_t ray = 0; ray < 100; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        assert_int_equal(h->n_step, 50);
        for (int i = 0; i < 49; i++) {
            assert_int_equal(h->step[i].events, RMAP_EVENT_TOTAL_REFLECTION);
            assert_int_equal(h->step[i].object, 1 - i % 2);
            assert_int_equal(h->step[i].medium, glass);
        }
        assert_int_equal(h->step[49].events, RMAP_EVENT_LIMIT);
        assert_int_equal(h->step[49].object, 0);
        assert_int_equal(h->ending.stop, RMAP_STOP_LIMIT);
        assert_near(fabs(h->step[49].direction.x), sin(1.0), 1e-14);
    }
    stop(&b);
}

/* Reflectance 0.7 about the normal: <cos> = 2/3, <cos^2> = 1/2; the rest is absorbed. */
static void lambert(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(2)};
    hand_medium(b.scene, 1.0);
    int32_t white = hand_surface(b.scene, RMAP_SURFACE_LAMBERT);
    hand_fill(b.scene, b.scene->surface[white].reflect_diffuse, 0.7);
    hand_object(b.scene, hand_rectangle(b.scene, 10, 10), white, hand_shift(0, 0, 0),
                RMAP_MEDIUM_ANY, RMAP_MEDIUM_ANY);
    add_beam(b.scene, 20.0);
    start(&b);
    enum { N = 40000 };
    double n = 0.0, cosine = 0.0, square = 0.0, x = 0.0;
    for (uint64_t ray = 0; ray < N; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        if (h->ending.stop == RMAP_STOP_ABSORBED) {
            assert_int_equal(h->step[0].events, RMAP_EVENT_ABSORB);
            continue;
        }
        assert_int_equal(h->step[0].events, RMAP_EVENT_REFLECT_DIFFUSE);
        assert_true(h->ending.direction.z < 0.0); /* the beam comes from below */
        n += 1.0;
        cosine -= h->ending.direction.z;
        square += h->ending.direction.z * h->ending.direction.z;
        x += h->ending.direction.x;
    }
    assert_mean(n, N, 0.7, 0.21);
    assert_mean(cosine, n, 2.0 / 3.0, 0.5 - 4.0 / 9.0);
    assert_mean(square, n, 0.5, 1.0 / 3.0 - 0.25);
    assert_mean(x, n, 0.0, 0.25);
    stop(&b);
}

/* The four outcomes and the rest of a mixture, on the side that is met. */
static void mixture(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t plastic = hand_surface(b.scene, RMAP_SURFACE_MIXTURE);
    struct rmap_surface *s = &b.scene->surface[plastic];
    const double share[4] = {0.1, 0.3, 0.25, 0.15};
    s->reflect_specular[0] = share[0];
    s->reflect_diffuse[0] = share[1];
    s->transmit_specular[0] = share[2];
    s->transmit_diffuse[0] = share[3];
    int32_t object =
        hand_object(b.scene, hand_rectangle(b.scene, 10, 10), plastic, hand_shift(0, 0, 0), 0, 0);
    b.scene->object[object].surface_front = hand_surface(b.scene, RMAP_SURFACE_ABSORBER);
    add_beam(b.scene, 10.0); /* meets the back */
    hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, 10), rmap_vec3(0, 0, -1));
    start(&b);
    enum { N = 40000 };
    double count[6] = {0};
    for (uint64_t ray = 0; ray < 2 * N; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        uint32_t events = h->step[0].events;
        if (h->emission.source == 1) {
            assert_int_equal(events, RMAP_EVENT_ABSORB);
            continue;
        }
        for (int bit = 0; bit < 6; bit++)
            count[bit] += events == 1u << bit;
        if (events == RMAP_EVENT_TRANSMIT_DIFFUSE || events == RMAP_EVENT_TRANSMIT_SPECULAR)
            assert_true(h->ending.direction.z > 0.0);
        else if (events != RMAP_EVENT_ABSORB)
            assert_true(h->ending.direction.z < 0.0);
    }
    const double expected[6] = {0.1, 0.3, 0.25, 0.15, 0.0, 0.2};
    for (int bit = 0; bit < 6; bit++)
        assert_mean(count[bit], N, expected[bit], expected[bit] * (1.0 - expected[bit]));
    stop(&b);
}

/* A side whose medium is not the light's ends the ray with an error, before its detectors. */
static void wrong_medium(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t water = hand_medium(b.scene, 1.33);
    hand_object(b.scene, hand_rectangle(b.scene, 10, 10),
                hand_surface(b.scene, RMAP_SURFACE_ABSORBER), hand_shift(0, 0, 0), water, water);
    hand_detector(b.scene, rmap_vec3(0, 0, 0), -1.0, 4.0)->on_object = 0;
    add_beam(b.scene, 0.0);
    start(&b);
    const struct rmap_history *h = trace(&b, 0);
    assert_int_equal(h->n_step, 1);
    assert_int_equal(h->step[0].events, RMAP_EVENT_ERROR);
    assert_int_equal(h->step[0].object, 0);
    assert_near(h->step[0].position.z, 0.0, 1e-15);
    assert_int_equal(h->ending.stop, RMAP_STOP_ERROR);
    assert_int_equal(h->n_registration, 0);
    stop(&b);
}

/* Free planes come before the step that ends the segment, planes on an object after it, far-field
 * grids after the last. */
static void order_of_registrations(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t mirror = hand_surface(b.scene, RMAP_SURFACE_MIRROR);
    b.scene->surface[mirror].reflect_specular[0] = 1.0;
    hand_object(b.scene, hand_rectangle(b.scene, 10, 10), mirror, hand_shift(0, 0, 0),
                RMAP_MEDIUM_ANY, RMAP_MEDIUM_ANY);
    hand_detector(b.scene, rmap_vec3(0, 0, 0), -1.0, 4.0)->on_object = 0;
    hand_detector(b.scene, rmap_vec3(0, 0, 0), 1.0, 4.0)->type = RMAP_DETECTOR_INTENSITY;
    hand_detector(b.scene, rmap_vec3(0, 0, -2), -1.0, 4.0);
    hand_detector(b.scene, rmap_vec3(0, 0, -5), -1.0, 4.0);
    add_beam(b.scene, 0.0);
    start(&b);
    const struct rmap_history *h = trace(&b, 0);
    const struct {
        int32_t detector;
        uint32_t segment;
        double path;
    } expected[] = {{3, 0, 5}, {2, 0, 8}, {0, 0, 10}, {2, 1, 12}, {3, 1, 15}, {1, 1, 10}};
    assert_int_equal(h->n_registration, 6);
    for (int i = 0; i < 6; i++) {
        assert_int_equal(h->registration[i].detector, expected[i].detector);
        assert_int_equal(h->registration[i].segment, expected[i].segment);
        assert_near(h->registration[i].optical_path, expected[i].path, 1e-14);
    }
    assert_near(h->registration[5].relative[0], 1.0, 1e-15); /* theta = pi */
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(clear_slab),
        cmocka_unit_test(path_through_a_slab),
        cmocka_unit_test(total_reflection),
        cmocka_unit_test(lambert),
        cmocka_unit_test(mixture),
        cmocka_unit_test(wrong_medium),
        cmocka_unit_test(order_of_registrations),
    };
    return cmocka_run_group_tests_name("tracer", test, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Rays through gradient media among surfaces: what they meet, and where.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gradient/field_polynomial.h"
#include "hand_gradient.h"
#include "near.h"

/* Every parallel ray meets the far pole, after the same optical path (Luneburg, Mathematical Theory
 * of Optics, 1944): along the axis, the integral of sqrt(2 - z^2) is 1 + pi/2. */
static void luneburg_focus(void **state)
{
    (void)state;
    for (int i = 0; i <= 20; i++) {
        struct bench b = {0};
        open_luneburg(&b, 0.99999 * i / 20.0);
        start(&b);
        double tolerance = options(&b)->tolerance;
        const struct rmap_history *h = trace(&b, 0);
        assert_int_equal(h->n_step, 3);
        const struct rmap_step *in = &h->step[1];
        assert_int_equal(in->events, RMAP_EVENT_TRANSMIT_SPECULAR | RMAP_EVENT_GRADIENT);
        assert_int_equal(in->object, 0);
        assert_near(rmap_length(in->position), 1.0, 1e-15);
        assert_near(rmap_length(rmap_sub(in->position, rmap_vec3(0, 0, 1))), 0.0, 40 * tolerance);
        assert_near(in->optical_path, 2.0 + 1.0 + 0.5 * RMAP_PI, 40 * tolerance);
        /* T = r' = -sin t r0 + cos t T0 at t where r is the pole: -r0 + (...) */
        assert_near(h->ending.direction.x, -0.99999 * i / 20.0, 40 * tolerance);
        assert_near(rmap_length(h->ending.direction), 1.0, 1e-14);
        stop(&b);
    }
}

/* 5,000 triangles instead of the sphere. */
static void mesh_as_sphere(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t medium = add_gradient(b.scene, luneburg(1.0));
    hand_object(b.scene, mesh_ball(b.scene, 25), add_clear(b.scene), rmap_affine_identity(), 0,
                medium);
    struct rmap_source *source =
        hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, -3), rmap_vec3(0, 0, 1));
    source->shape = RMAP_EMITTER_DISC;
    source->shape_size[0] = 0.9;
    start(&b);
    for (uint64_t ray = 0; ray < 2000; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        assert_int_equal(h->ending.stop, RMAP_STOP_LEFT);
        assert_true(h->n_step == 3);
        assert_int_equal(h->step[0].events, RMAP_EVENT_TRANSMIT_SPECULAR);
        /* facets as long as 0.09 lie up to 1e-3 inside the sphere */
        assert_near(rmap_length(h->step[1].position), 1.0, 1.2e-3);
        assert_near(rmap_length(rmap_sub(h->step[1].position, rmap_vec3(0, 0, 1))), 0.0, 6e-3);
    }
    stop(&b);
}

/* An absorber inside the lens, met on the curve r0 cos t + T0 sin t (|r|^2 is known in t). */
static void body_inside(void **state)
{
    (void)state;
    for (int mesh = 0; mesh < 2; mesh++) {
        struct bench b = {0};
        open_luneburg(&b, 0.6);
        int32_t medium = 1, black = hand_surface(b.scene, RMAP_SURFACE_ABSORBER);
        struct rmap_affine place = hand_shift(0.45, 0, 0.3);
        int32_t ball = mesh ? mesh_ball(b.scene, 25) : sphere(b.scene, 0.1);
        for (int k = 0; k < 3 && mesh; k++)
            place.m[k][k] = 0.1;
        hand_object(b.scene, ball, black, place, medium, medium);
        add_place(b.scene, medium);
        b.scene->object[0].gradient_back = 1;
        b.scene->object[1].gradient_back = b.scene->object[1].gradient_front = 1;
        start(&b);
        const struct rmap_history *h = trace(&b, 0);
        assert_int_equal(h->n_step, 2);
        assert_int_equal(h->ending.stop, RMAP_STOP_ABSORBED);
        assert_int_equal(h->step[1].object, 1);
        assert_int_equal(h->step[1].events, RMAP_EVENT_ABSORB | RMAP_EVENT_GRADIENT);
        struct rmap_vec3 r0 = rmap_vec3(0.6, 0, -0.8), T0 = rmap_vec3(0, 0, 1), p;
        double low = 0.0, high = 1.2;
        for (int i = 0; i < 60; i++) {
            double t = 0.5 * (low + high);
            p = rmap_axpy(sin(t), T0, rmap_scale(r0, cos(t)));
            if (rmap_length(rmap_sub(p, place.t)) > 0.1)
                low = t;
            else
                high = t;
        }
        assert_near(rmap_length(rmap_sub(h->step[1].position, p)), 0.0,
                    mesh ? 2e-4 : 2 * options(&b)->tolerance);
        stop(&b);
    }
}

/* n^2 = n0^2 (1 - alpha^2 rho^2) in a rod wide enough: x = a sin(alpha n0 t), z = T_z t, so that it
 * turns back to the axis again and again; T_z and the skewness keep. */
static void turning_points(void **state)
{
    (void)state;
    const double n0 = 1.6, alpha = 0.2, slope = 0.3, length = 60.0;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    add_rod(b.scene, parabolic(n0, alpha), 3.0, length, add_clear(b.scene));
    struct rmap_source *source = hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, 1e-3),
                                             rmap_vec3(sin(slope), 0, cos(slope)));
    source->medium = 1;
    source->gradient = 1;
    hand_detector(b.scene, rmap_vec3(0, 0, 30), 1.0, 10.0);
    struct rmap_detector *axial = hand_detector(b.scene, rmap_vec3(0, 0, 30), 1.0, 100.0);
    axial->axis = rmap_vec3(1, 0, 0); /* the plane x = 0 */
    axial->x = rmap_vec3(0, 0, 1);
    axial->y = rmap_cross(axial->axis, axial->x);
    start(&b);
    double tolerance = options(&b)->tolerance, Tx = n0 * sin(slope), Tz = n0 * cos(slope);
    const struct rmap_history *h = trace(&b, 0);
    double t = (length - 1e-3) / Tz, w = alpha * n0;
    assert_int_equal(h->n_step, 2);
    assert_int_equal(h->step[0].object, 2);
    assert_near(h->step[0].position.x, Tx / w * sin(w * t), 200 * tolerance);
    assert_near(h->step[0].position.z, length, 1e-14 * length);
    /* optical path: the integral of n^2 = Tx^2 cos^2 + Tz^2 over t, since |r'| = n */
    double optical = Tz * Tz * t + Tx * Tx * (0.5 * t + sin(2 * w * t) / (4 * w));
    assert_near(h->step[0].optical_path, optical, 200 * tolerance);
    size_t crossings = (size_t)(w * t / RMAP_PI), axis = 0;
    for (size_t i = 0; i < h->n_registration; i++) {
        const struct rmap_registration *r = &h->registration[i];
        if (r->segment > 0)
            break;
        assert_true(i == 0 || r->optical_path > h->registration[i - 1].optical_path);
        if (r->detector == 0) {
            double at = (30 - 1e-3) / Tz;
            assert_near(r->position.x, Tx / w * sin(w * at), 100 * tolerance);
            assert_near(r->direction.x / r->direction.z, Tx * cos(w * at) / Tz, 100 * tolerance);
        } else {
            axis++;
            assert_near(r->position.z - 1e-3, Tz * (double)axis * RMAP_PI / w, 200 * tolerance);
        }
    }
    assert_int_equal(axis, crossings);
    stop(&b);
}

/* In a rod narrower than the turning points light is reflected totally at its side, at the angle
 * at which it comes; T_z keeps. */
static void reflection_inside(void **state)
{
    (void)state;
    const double n0 = 1.6, alpha = 0.2, slope = 0.3;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    add_rod(b.scene, parabolic(n0, alpha), 0.8, 60.0, add_clear(b.scene));
    struct rmap_source *source = hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0.1, 1),
                                             rmap_vec3(sin(slope), 0, cos(slope)));
    source->medium = 1;
    source->gradient = 1;
    start(&b);
    double tolerance = options(&b)->tolerance, from = n0 * n0 * (1 - alpha * alpha * 0.01);
    double Tz = sqrt(from) * cos(slope), edge = n0 * sqrt(1 - alpha * alpha * 0.64);
    const struct rmap_history *h = trace(&b, 0);
    assert_true(h->n_step > 10);
    for (size_t i = 0; i + 2 < h->n_step; i++) {
        assert_int_equal(h->step[i].events, RMAP_EVENT_TOTAL_REFLECTION | RMAP_EVENT_GRADIENT);
        assert_int_equal(h->step[i].object, 0);
        assert_near(hypot(h->step[i].position.x, h->step[i].position.y), 0.8,
                    4e-14); /* rounding: 60 along the rod */
        assert_near(h->step[i].direction.z * edge, Tz, 100 * tolerance);
    }
    assert_int_equal(h->step[h->n_step - 2].object, 2);
    assert_int_equal(h->ending.stop, RMAP_STOP_LEFT);
    stop(&b);
}

/* The exit ray, sent back, comes home. */
static void reversal(void **state)
{
    (void)state;
    for (int i = 0; i < 12; i++) {
        struct bench b = {0};
        open_luneburg(&b, 0.08 * i);
        struct rmap_source *back =
            hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 1));
        struct rmap_vec3 on_way = rmap_vec3(0.08 * i, 0, -2.5);
        start(&b);
        double tolerance = options(&b)->tolerance;
        const struct rmap_history *h = trace(&b, 0);
        assert_int_equal(h->emission.source, 0);
        struct rmap_vec3 end = rmap_axpy(1.0, h->ending.direction, h->step[1].position);
        back->frame = rmap_affine_frame(rmap_scale(h->ending.direction, -1.0), end);
        h = trace(&b, 1);
        assert_int_equal(h->emission.source, 1);
        assert_int_equal(h->n_step, 3);
        struct rmap_vec3 way = rmap_sub(on_way, h->step[1].position);
        struct rmap_vec3 off = rmap_cross(way, h->ending.direction);
        assert_near(rmap_length(off), 0.0, 40 * tolerance);
        assert_near(h->ending.direction.z, -1.0, 40 * tolerance);
        stop(&b);
    }
}

/* Cubes that touch, of gradient media and of glass, and a ball in the first: rays in all directions
 * go the way that they go where every medium is uniform, at grazing angles too. */
static void same_as_uniform(void **state)
{
    (void)state;
    struct bench b[2];
    for (int k = 0; k < 2; k++) {
        struct rmap_scene *scene = b[k].scene = hand_scene(1);
        hand_medium(scene, 1.0);
        int32_t first = k ? add_gradient(scene, constant(1.5)) : hand_medium(scene, 1.5);
        int32_t second = k ? add_gradient(scene, constant(1.3)) : hand_medium(scene, 1.3);
        int32_t glass = hand_medium(scene, 1.7), clear = hand_surface(scene, RMAP_SURFACE_FRESNEL);
        scene->geometry[scene->n_geometry].kind = RMAP_GEOMETRY_MESH;
        scene->geometry[scene->n_geometry].mesh = make_cube(1.0);
        int32_t cube = (int32_t)scene->n_geometry++;
        hand_object(scene, cube, clear, hand_shift(0, 0, 0), 0, first);
        hand_object(scene, cube, clear, hand_shift(2, 0, 0), 0, second);
        hand_object(scene, cube, clear, hand_shift(0, 2, 0), 0, glass);
        hand_object(scene, sphere(scene, 0.5), clear, hand_shift(0, 0, 0), first, second);
        hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(-1.5, -1.7, -1.9), rmap_vec3(1, 1, 1));
        struct rmap_source *source =
            hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(0.7, 0.6, 0.3), rmap_vec3(1, 0, 0));
        source->medium = first;
        if (k) {
            scene->gradient = rmap_alloc(2, sizeof *scene->gradient);
            scene->gradient[0].medium = first;
            scene->gradient[1].medium = second;
            scene->gradient[0].to_world = scene->gradient[1].to_world = rmap_affine_identity();
            scene->n_gradient = 2;
            scene->object[0].gradient_back = scene->object[3].gradient_front = 1;
            scene->object[1].gradient_back = scene->object[3].gradient_back = 2;
            source->gradient = 1;
        }
        scene->limit_steps = 12; /* rounding grows tenfold at each turn at the ball */
        start(&b[k]);
    }
    for (uint64_t ray = 0; ray < 4000; ray++) {
        const struct rmap_history *flat = trace(&b[0], ray), *bent = trace(&b[1], ray);
        assert_int_equal(bent->n_step, flat->n_step);
        assert_int_equal(bent->ending.stop, flat->ending.stop);
        for (size_t i = 0; i < flat->n_step; i++) {
            const struct rmap_step *f = &flat->step[i], *g = &bent->step[i];
            bool curved = g->medium == 1 || g->medium == 2;
            assert_int_equal(g->events & ~(uint32_t)RMAP_EVENT_GRADIENT, f->events);
            assert_int_equal((g->events & RMAP_EVENT_GRADIENT) != 0, curved);
            assert_int_equal(g->object, f->object);
            assert_int_equal(g->medium, f->medium);
            assert_near(rmap_length(rmap_sub(g->position, f->position)), 0.0, 1e-9);
            assert_near(g->length, f->length, 1e-9);
            assert_near(g->optical_path, f->optical_path, 1e-9);
        }
    }
    stop(&b[0]);
    stop(&b[1]);
}

/* A rod whose index grows outward bends light onto its wall: grazing starts on the wall come back
 * to it. n = 1.5 + 0.2 rho^2, all of it kept inside by total reflection. */
static void grazing_starts(void **state)
{
    (void)state;
    const double coefficient[] = {1.5, 0.2};
    struct rmap_field *field = NULL;
    assert_int_equal(
        rmap_field_series(&field, RMAP_SERIES_RHO2, RMAP_SERIES_OF_N, 1, 2, coefficient, NULL),
        RMAP_OK);
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    add_rod(b.scene, field, 1.0, 40.0, add_clear(b.scene));
    b.scene->limit_steps = 300;
    for (int i = 0; i < 24; i++) {
        double angle = 0.7 * pow(0.5, i);
        struct rmap_source *source = hand_source(
            b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0.999999 * cos(i), 0.999999 * sin(i), 5),
            rmap_vec3(-cos(i) * sin(angle), -sin(i) * sin(angle), cos(angle)));
        source->medium = 1;
        source->gradient = 1;
    }
    start(&b);
    for (uint64_t ray = 0; ray < 24; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        assert_true(h->n_step > 3);
        size_t inside = h->n_step - (h->ending.stop == RMAP_STOP_LEFT ? 2 : 1);
        double sine = h->step[0].direction.z;
        for (size_t i = 0; i < inside; i++) {
            assert_int_equal(h->step[i].events, RMAP_EVENT_TOTAL_REFLECTION | RMAP_EVENT_GRADIENT);
            assert_int_equal(h->step[i].object, 0);
            assert_near(h->step[i].direction.z, sine, 1e-7);
        }
        assert_true(h->ending.stop == RMAP_STOP_LEFT || h->ending.stop == RMAP_STOP_LIMIT);
    }
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(luneburg_focus),    cmocka_unit_test(mesh_as_sphere),
        cmocka_unit_test(body_inside),       cmocka_unit_test(turning_points),
        cmocka_unit_test(reflection_inside), cmocka_unit_test(reversal),
        cmocka_unit_test(same_as_uniform),   cmocka_unit_test(grazing_starts),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

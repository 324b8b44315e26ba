/* SPDX-License-Identifier: MIT
 *
 * Rays through gradient media among surfaces: what they meet, where, and what is recorded of it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "build_scene.h"
#include "gradient/models.h"
#include "hand_bench.h"
#include "near.h"

/* A medium with this field; the scene owns it. */
static int32_t add_gradient(struct rmap_scene *scene, struct rmap_field *field)
{
    int32_t medium = hand_medium(scene, 1.5);
    scene->medium[medium].field = field;
    return medium;
}

/* In the world's frame, for objects to share. */
static void add_place(struct rmap_scene *scene, int32_t medium)
{
    scene->gradient = rmap_alloc(1, sizeof *scene->gradient);
    scene->gradient[0] =
        (struct rmap_gradient){.medium = medium, .to_world = rmap_affine_identity()};
    scene->n_gradient = 1;
}

static struct rmap_field *luneburg(double radius)
{
    struct rmap_field *field = NULL;
    const struct rmap_luneburg parameter = {1.0, radius};
    assert_int_equal(rmap_field_luneburg(&field, 1, &parameter, NULL), RMAP_OK);
    return field;
}

static struct rmap_field *parabolic(double n0, double alpha)
{
    struct rmap_field *field = NULL;
    const struct rmap_parabolic parameter = {n0, alpha};
    assert_int_equal(rmap_field_parabolic(&field, 1, &parameter, NULL), RMAP_OK);
    return field;
}

/* All light goes through, but for total reflection. */
static int32_t add_clear(struct rmap_scene *scene)
{
    int32_t surface = hand_surface(scene, RMAP_SURFACE_FRESNEL);
    scene->surface[surface].coat = RMAP_COAT_IDEAL;
    return surface;
}

static int32_t sphere(struct rmap_scene *scene, double radius)
{
    return hand_shape(scene, (struct rmap_shape){.type = RMAP_SHAPE_SPHERE, .radius = radius});
}

static int32_t mesh_ball(struct rmap_scene *scene, uint32_t n)
{
    scene->geometry[scene->n_geometry].kind = RMAP_GEOMETRY_MESH;
    scene->geometry[scene->n_geometry].mesh = make_ball(n);
    return (int32_t)scene->n_geometry++;
}

/* The one place of the only gradient medium, as the scene has resolved it. */
static struct rmap_curve_options *options(struct bench *b)
{
    assert_int_equal(b->scene->n_gradient, 1);
    return &b->scene->gradient[0].options;
}

/* A beam along +z at this height into a Luneburg lens of radius 1. */
static void open_luneburg(struct bench *b, double height)
{
    b->scene = hand_scene(1);
    hand_medium(b->scene, 1.0);
    int32_t medium = add_gradient(b->scene, luneburg(1.0));
    hand_object(b->scene, sphere(b->scene, 1.0), add_clear(b->scene), rmap_affine_identity(), 0,
                medium);
    hand_source(b->scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(height, 0, -3), rmap_vec3(0, 0, 1));
}

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

/* A rod of this radius and length, from z = 0 on, in air: three surfaces, one place. */
static int32_t add_rod(struct rmap_scene *scene, struct rmap_field *field, double radius,
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
        assert_near(hypot(h->step[i].position.x, h->step[i].position.y), 0.8, 1e-14);
        assert_near(h->step[i].direction.z * edge, Tz, 100 * tolerance);
    }
    assert_int_equal(h->step[h->n_step - 2].object, 2);
    assert_int_equal(h->ending.stop, RMAP_STOP_LEFT);
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(luneburg_focus),    cmocka_unit_test(mesh_as_sphere),
        cmocka_unit_test(body_inside),       cmocka_unit_test(turning_points),
        cmocka_unit_test(reflection_inside),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

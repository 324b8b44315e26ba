/* SPDX-License-Identifier: MIT
 *
 * Crossing and registration on virtual detectors.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_scene.h"
#include "near.h"
#include "portion/history.h"
#include "trace/detector.h"

/* Lists of detectors as rmap_scene_finish makes them, without the geometry. */
static void list_by_hand(struct rmap_scene *scene)
{
    scene->free_detector = rmap_alloc(HAND_MAX, sizeof *scene->free_detector);
    scene->far_detector = rmap_alloc(HAND_MAX, sizeof *scene->far_detector);
    for (size_t d = 0; d < scene->n_detector; d++)
        if (scene->detector[d].type == RMAP_DETECTOR_PLANE)
            scene->free_detector[scene->n_free_detector++] = (int32_t)d;
        else
            scene->far_detector[scene->n_far_detector++] = (int32_t)d;
}

static struct rmap_segment segment_between(struct rmap_vec3 from, struct rmap_vec3 to)
{
    struct rmap_vec3 way = rmap_sub(to, from);
    return (struct rmap_segment){.from = from,
                                 .to = to,
                                 .direction = rmap_normalize(way),
                                 .length = rmap_length(way),
                                 .optical_from = 100.0,
                                 .index = 1.5,
                                 .segment = 4};
}

/* A history that is ready to take registrations. */
static struct rmap_history empty_history(void)
{
    struct rmap_history history;
    rmap_history_init(&history, 1);
    return history;
}

static void position_cell_and_path(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    struct rmap_detector *plane = hand_detector(scene, rmap_vec3(1, 2, 10), -1.0, 4.0);
    plane->cells[1] = 20;
    list_by_hand(scene);
    struct rmap_history history = empty_history();
    /* axis -z, so y = axis x x = (0, -1, 0) */
    struct rmap_segment segment = segment_between(rmap_vec3(0, 2, 0), rmap_vec3(3, 3.5, 20));
    rmap_detect_free(scene, &segment, &history.base);
    assert_int_equal(history.n_registration, 1);
    const struct rmap_registration *r = &history.registration[0];
    assert_true(r->registered);
    assert_int_equal(r->detector, 0);
    assert_int_equal(r->segment, 4);
    assert_near(r->position.x, 1.5, 1e-14);
    assert_near(r->position.y, 2.75, 1e-14);
    assert_near(r->position.z, 10.0, 1e-14);
    assert_near(r->relative[0], 0.5 + 0.5 / 4.0, 1e-15);
    assert_near(r->relative[1], 0.5 - 0.75 / 4.0, 1e-15);
    assert_int_equal(r->cell[0], 6);
    assert_int_equal(r->cell[1], 6);
    assert_near(r->optical_path, 100.0 + 1.5 * 0.5 * segment.length, 1e-12);
    assert_near(rmap_angle_of(r->cosine), acos(20.0 / segment.length), 1e-14);
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
}

static void misses(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    hand_detector(scene, rmap_vec3(0, 0, 10), -1.0, 4.0);
    list_by_hand(scene);
    struct rmap_history history = empty_history();
    struct rmap_segment outside = segment_between(rmap_vec3(2.01, 0, 0), rmap_vec3(2.01, 0, 20));
    struct rmap_segment before = segment_between(rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 9.9));
    struct rmap_segment parallel = segment_between(rmap_vec3(-9, 0, 10), rmap_vec3(9, 0, 10));
    rmap_detect_free(scene, &outside, &history.base);
    rmap_detect_free(scene, &before, &history.base);
    rmap_detect_free(scene, &parallel, &history.base);
    assert_int_equal(history.n_registration, 0);
    struct rmap_segment edge = segment_between(rmap_vec3(2, 2, 0), rmap_vec3(2, 2, 20));
    rmap_detect_free(scene, &edge, &history.base);
    assert_int_equal(history.n_registration, 1);
    assert_int_equal(history.registration[0].cell[0], 9);
    assert_int_equal(history.registration[0].cell[1], 0);
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
}

/* Segments that end on the plane, or near it by rounding, cross it once in all. */
static void never_twice(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    struct rmap_detector *plane = hand_detector(scene, rmap_vec3(0, 0, 0), 1.0, 100.0);
    plane->axis = rmap_normalize(rmap_vec3(0.3, -0.2, 0.9));
    list_by_hand(scene);
    struct rmap_history history = empty_history();
    struct rmap_vec3 start = rmap_vec3(0.1, 0.7, 5.3), way = rmap_vec3(0.21, -0.04, -1.0);
    double meeting = -rmap_dot(start, plane->axis) / rmap_dot(way, plane->axis);
    for (int k = -40; k <= 40; k++) {
        double t = meeting * (1.0 + k * 1.1102230246251565e-16);
        struct rmap_vec3 middle = rmap_axpy(t, way, start);
        struct rmap_segment first = segment_between(start, middle);
        struct rmap_segment second = segment_between(middle, rmap_axpy(2.0 * meeting, way, start));
        history.n_registration = 0;
        rmap_detect_free(scene, &first, &history.base);
        rmap_detect_free(scene, &second, &history.base);
        assert_int_equal(history.n_registration, 1);
    }
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
}

/* Times that a parabola crosses a plane through the origin with this axis. */
static size_t crossings_of(struct rmap_vec3 axis, struct rmap_vec3 from, struct rmap_vec3 along,
                           struct rmap_vec3 bend)
{
    struct rmap_scene *scene = hand_scene(1);
    hand_detector(scene, rmap_vec3(0, 0, 0), 1.0, 1e9)->axis = axis;
    scene->detector[0].side = RMAP_SIDE_BOTH;
    list_by_hand(scene);
    struct rmap_history history = empty_history();
    struct rmap_curve_step step = {.from = {.r = from, .T = along}, .h = 1.0, .whole = 1.0};
    step.bend[0][0] = bend.x;
    step.bend[0][1] = bend.y;
    step.bend[0][2] = bend.z;
    for (int k = 0; k < 3; k++)
        step.turn[0][k] = 2.0 * step.bend[0][k];
    rmap_curve_at(&step, 1.0, &step.to.r, &step.to.T);
    rmap_curve_lengths(&step, 1.0, &step.optical, &step.length);
    const struct rmap_segment_piece piece = {.step = &step, .from = from, .to = step.to.r};
    rmap_detect_curve(scene, &piece, &history.base);
    size_t n = history.n_registration;
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
    return n;
}

/* The search ends where a curve runs in the plane itself, exactly or up to rounding, however far it
 * bends there, and where it is no curve at all. */
static void curves_within_the_plane(void **state)
{
    (void)state;
    const struct rmap_vec3 axis = rmap_normalize(rmap_vec3(0.3, -0.2, 0.9));
    const struct rmap_vec3 u = rmap_normalize(rmap_cross(axis, rmap_vec3(0, 1, 0)));
    const struct rmap_vec3 v = rmap_cross(axis, u);
    const struct rmap_vec3 z = rmap_vec3(0, 0, 1);
    for (double size = 1e-6; size < 1e40; size *= 1e5) {
        assert_int_equal(crossings_of(z, rmap_vec3(size, 0, 0), rmap_vec3(0, size, 0),
                                      rmap_vec3(-3 * size, size, 0)),
                         0);
        (void)crossings_of(axis, rmap_scale(u, size), rmap_scale(v, size),
                           rmap_axpy(size, v, rmap_scale(u, -3 * size)));
    }
    (void)crossings_of(z, rmap_vec3((double)NAN, 0, 0), z, u);
    (void)crossings_of(z, rmap_vec3(1, 0, 0), z, rmap_vec3((double)INFINITY, 0, 0));
    assert_int_equal(crossings_of(z, rmap_vec3(0, 0, 1), rmap_vec3(3, 0, -5), rmap_vec3(0, 0, 5)),
                     2);
    assert_int_equal(crossings_of(z, rmap_vec3(0, 0, 1), rmap_vec3(3, 0, -5), rmap_vec3(0, 0, 6.3)),
                     0);
}

/* More planes than the sorter holds, given in no order, two of them at one place. */
static void ordered_by_distance_then_index(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    for (int d = 0; d < 31; d++)
        hand_detector(scene, rmap_vec3(0, 0, 1 + (d * 12) % 31), 1.0, 4.0);
    hand_detector(scene, rmap_vec3(0, 0, 1 + 12), -1.0, 4.0);
    list_by_hand(scene);
    struct rmap_history history = empty_history();
    struct rmap_segment segment = segment_between(rmap_vec3(0, 0, 0), rmap_vec3(0.1, 0.1, 40));
    rmap_detect_free(scene, &segment, &history.base);
    assert_int_equal(history.n_registration, 32);
    for (size_t i = 1; i < 32; i++) {
        const struct rmap_registration *a = &history.registration[i - 1], *b = a + 1;
        assert_true(a->optical_path < b->optical_path ||
                    (a->optical_path == b->optical_path && a->detector < b->detector));
    }
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
}

static bool registers(struct rmap_scene *scene, enum rmap_side side, double max_deg, double deg)
{
    struct rmap_history history = empty_history();
    scene->detector[0].side = side;
    scene->detector[0].max_angle_rad = max_deg * RMAP_PI / 180.0;
    double a = deg * RMAP_PI / 180.0; /* between the reversed ray and the axis +z */
    struct rmap_vec3 back = rmap_vec3(sin(a), 0, cos(a));
    struct rmap_segment segment = segment_between(back, rmap_scale(back, -1.0));
    rmap_detect_free(scene, &segment, &history.base);
    assert_int_equal(history.n_registration, 1); /* crossed in any case */
    assert_near(rmap_angle_of(history.registration[0].cosine), a, 1e-7);
    bool registered = history.registration[0].registered;
    rmap_history_fini(&history);
    return registered;
}

static void sides_and_angles(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    hand_detector(scene, rmap_vec3(0, 0, 0), 1.0, 4.0);
    list_by_hand(scene);
    assert_true(registers(scene, RMAP_SIDE_FRONT, 90, 0));
    assert_true(registers(scene, RMAP_SIDE_FRONT, 90, 89));
    assert_false(registers(scene, RMAP_SIDE_FRONT, 90, 91));
    assert_true(registers(scene, RMAP_SIDE_BACK, 90, 91));
    assert_false(registers(scene, RMAP_SIDE_BACK, 90, 45));
    assert_true(registers(scene, RMAP_SIDE_BOTH, 30, 29));
    assert_true(registers(scene, RMAP_SIDE_BOTH, 30, 151));
    assert_false(registers(scene, RMAP_SIDE_BOTH, 30, 31));
    assert_false(registers(scene, RMAP_SIDE_BOTH, 30, 149));
    rmap_scene_destroy(scene);
}

/* On an object: the point is projected along the axis. */
static void lying_on_an_object(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    struct rmap_detector *plane = hand_detector(scene, rmap_vec3(0, 0, 5), 1.0, 4.0);
    plane->on_object = 1;
    scene->on_first = rmap_alloc(4, sizeof *scene->on_first);
    scene->on_detector = rmap_alloc(1, sizeof *scene->on_detector);
    scene->on_first[2] = scene->on_first[3] = 1;
    struct rmap_history history = empty_history();
    struct rmap_segment segment = segment_between(rmap_vec3(0, 0, 10), rmap_vec3(1, -0.5, 4.2));
    rmap_detect_on(scene, &segment, 0, 0, &history.base);
    rmap_detect_on(scene, &segment, 2, 0, &history.base);
    assert_int_equal(history.n_registration, 0);
    rmap_detect_on(scene, &segment, 1, 0, &history.base);
    assert_int_equal(history.n_registration, 1);
    assert_near(history.registration[0].position.x, 1.0, 1e-15);
    assert_near(history.registration[0].position.y, -0.5, 1e-15);
    assert_near(history.registration[0].position.z, 5.0, 1e-15);
    assert_near(history.registration[0].optical_path, 100.0 + 1.5 * segment.length, 1e-12);
    struct rmap_segment beside = segment_between(rmap_vec3(0, 0, 10), rmap_vec3(2.1, 0, 4.2));
    rmap_detect_on(scene, &beside, 1, 0, &history.base);
    assert_int_equal(history.n_registration, 1);
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
}

static void far_field(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    struct rmap_detector *far = hand_detector(scene, rmap_vec3(0, 0, 0), 1.0, 1.0);
    far->type = RMAP_DETECTOR_INTENSITY;
    far->cells[0] = 18;
    far->cells[1] = 36;
    list_by_hand(scene);
    struct rmap_history history = empty_history();
    const double deg = RMAP_PI / 180.0, theta = 125.0 * deg, phi = 303.0 * deg;
    struct rmap_segment segment = segment_between(
        rmap_vec3(0, 0, 0), rmap_vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)));
    rmap_detect_far(scene, &segment, &history.base);
    const struct rmap_registration *r = &history.registration[0];
    assert_near(r->relative[0] * 180.0, 125.0, 1e-12);
    assert_near(r->relative[1] * 360.0, 303.0, 1e-12);
    assert_int_equal(r->cell[0], 12);
    assert_int_equal(r->cell[1], 30);
    assert_near(rmap_angle_of(r->cosine), theta, 1e-14);
    assert_true(r->optical_path == 100.0 && r->registered);
    rmap_history_fini(&history);
    rmap_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(position_cell_and_path),
        cmocka_unit_test(misses),
        cmocka_unit_test(never_twice),
        cmocka_unit_test(curves_within_the_plane),
        cmocka_unit_test(ordered_by_distance_then_index),
        cmocka_unit_test(sides_and_angles),
        cmocka_unit_test(lying_on_an_object),
        cmocka_unit_test(far_field),
    };
    return cmocka_run_group_tests_name("detector", test, NULL, NULL);
}

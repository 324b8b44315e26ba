/* SPDX-License-Identifier: MIT
 *
 * Curved segments that end inside the medium or leave the scene; what is recorded on the way.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "hand_gradient.h"
#include "near.h"

/* 1.5 + x / 10 up to z = 1.5; there it ends. */
static bool ending_at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
                      struct rmap_vec3 *gradient)
{
    (void)field;
    (void)channel;
    *n = 1.5 + 0.1 * p.x;
    *gradient = rmap_vec3(0.1, 0, 0);
    return p.z <= 1.5;
}

static void keep(struct rmap_field *field)
{
    (void)field;
}

/* Light that meets no surface: it leaves the scene, or circles in the fish-eye up to the limit; or
 * it comes to where there is no index. */
static void ends_in_space(void **state)
{
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct bench b = {.scene = hand_scene(1)};
        hand_medium(b.scene, 1.0);
        static const struct rmap_field_ops ops = {.at = ending_at, .destroy = keep};
        static struct rmap_field ending = {.ops = &ops, .n_channel = 1};
        const struct rmap_maxwell fish_eye = {2.0, 1.0};
        struct rmap_field *field = NULL;
        if (k == 0)
            field = constant(1.5);
        else if (k == 1)
            assert_int_equal(rmap_field_maxwell(&field, 1, &fish_eye, NULL), RMAP_OK);
        else
            field = &ending;
        int32_t medium = add_gradient(b.scene, field);
        b.scene->medium[medium].curve.max_steps = 50;
        add_place(b.scene, medium);
        hand_detector(b.scene, rmap_vec3(0, 0, 0), 1.0, 10.0);
        struct rmap_source *source =
            hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(1, 0, 0), rmap_vec3(0, 0, 1));
        source->medium = medium;
        source->gradient = 1;
        start(&b);
        const enum rmap_stop stops[] = {RMAP_STOP_LEFT, RMAP_STOP_LIMIT, RMAP_STOP_ERROR};
        const uint32_t events[] = {RMAP_EVENT_LEFT, RMAP_EVENT_LIMIT, RMAP_EVENT_ERROR};
        const struct rmap_history *h = trace(&b, 0);
        assert_int_equal(h->n_step, 1);
        assert_int_equal(h->ending.stop, stops[k]);
        assert_int_equal(h->step[0].events, events[k] | RMAP_EVENT_GRADIENT);
        assert_int_equal(h->step[0].object, -1);
        if (k == 0)
            assert_near(rmap_length(rmap_sub(h->step[0].position, b.scene->centre)),
                        b.scene->radius, 1e-8);
        if (k == 1)
            assert_near(rmap_length(h->step[0].position), 1.0, 1e-6); /* a circle */
        if (k == 2)
            assert_near(h->step[0].position.z, 1.5, 1e-6);
        stop(&b);
    }
}

/* Mean free path 1 / (absorption + scattering), absorbed by its share, and the mean cosine g, along
 * curves and straight segments alike. */
static void turbid(void **state)
{
    (void)state;
    for (int k = 0; k < 2; k++) {
        const double cosines[] = {0.7, -0.4};
        struct bench b = {.scene = hand_scene(1)};
        hand_medium(b.scene, 1.0);
        int32_t medium =
            k ? add_gradient(b.scene, parabolic(1.6, 0.02)) : hand_medium(b.scene, 1.5);
        b.scene->medium[medium].absorption[0] = 0.5;
        b.scene->medium[medium].scattering[0] = 1.5;
        b.scene->medium[medium].scattering_g = cosines[k];
        b.scene->medium[medium].absorbing = b.scene->medium[medium].scattering_at_all = true;
        if (k)
            add_place(b.scene, medium);
        hand_detector(b.scene, rmap_vec3(0, 0, 0), 1.0, 1000.0);
        struct rmap_source *source =
            hand_source(b.scene, RMAP_SOURCE_COLLIMATED, rmap_vec3(0.5, 0, 0), rmap_vec3(0, 1, 0));
        source->medium = medium;
        source->gradient = k;
        start(&b);
        enum { N = 20000 };
        double path = 0.0, absorbed = 0.0, cosine = 0.0, square = 0.0, n = 0.0;
        for (uint64_t ray = 0; ray < N; ray++) {
            const struct rmap_history *h = trace(&b, ray);
            assert_int_equal(h->ending.stop, RMAP_STOP_ABSORBED);
            path += h->step[0].length;
            absorbed += (h->step[0].events & RMAP_EVENT_ABSORB) != 0;
            if (h->n_step < 2)
                continue;
            assert_true(h->step[0].events & RMAP_EVENT_SCATTER_VOLUME);
            assert_int_equal(h->step[0].object, -1);
            struct rmap_vec3 way = rmap_sub(h->step[1].position, h->step[0].position);
            double c = rmap_dot(h->step[0].direction, way) / rmap_length(way);
            cosine += c;
            square += c * c;
            n += 1.0;
        }
        assert_mean(path, N, 0.5, 0.25);
        assert_mean(absorbed, N, 0.25, 0.25 * 0.75);
        /* the medium bends chords a little; <cos^2> = (1 + 2 g^2) / 3 */
        double g = cosines[k];
        assert_near(cosine / n, g, 4.0 * sqrt((1 + 2 * g * g) / 3 - g * g) / sqrt(n) + k * 2e-3);
        assert_near(square / n, (1 + 2 * g * g) / 3, 0.02);
        stop(&b);
    }
}

struct pointed {
    struct rmap_recorder base;
    struct rmap_vec3 last;
    size_t n;
    double farthest, length;
};

static void pass_emit(struct rmap_recorder *self, const struct rmap_emission *emission)
{
    (void)self;
    (void)emission;
}

static void pass_step(struct rmap_recorder *self, const struct rmap_step *step)
{
    struct pointed *p = (struct pointed *)self;
    p->length = 0.0;
    p->last = step->position;
}

static void take_point(struct rmap_recorder *self, const struct rmap_curve_point *point)
{
    struct pointed *p = (struct pointed *)self;
    assert_int_equal(point->segment, 1);
    assert_true(point->length > p->length);
    assert_near(rmap_length(point->direction), 1.0, 1e-14);
    double r2 = rmap_dot(point->position, point->position);
    assert_near(point->index, sqrt(2.0 - r2), 1e-7);
    p->farthest = fmax(p->farthest, rmap_length(rmap_sub(point->position, p->last)));
    p->length = point->length;
    p->last = point->position;
    p->n++;
}

static void pass_registration(struct rmap_recorder *self,
                              const struct rmap_registration *registration)
{
    (void)self;
    (void)registration;
}

static void pass_end(struct rmap_recorder *self, const struct rmap_ending *ending)
{
    (void)self;
    (void)ending;
}

/* As many points as the polyline's tolerance needs, within a factor of 2, and none for a straight
 * ray. */
static void points_recorded(void **state)
{
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct bench b = {0};
        struct pointed pointed = {.base = {.emit = pass_emit,
                                           .step = pass_step,
                                           .curve = take_point,
                                           .registration = pass_registration,
                                           .end = pass_end}};
        open_luneburg(&b, i ? 0.6 : 0.0);
        start(&b);
        rmap_trace_ray(&b.tracer, 0, &pointed.base);
        /* curvature about 0.5: chords of sqrt(8 tolerance / 0.5) */
        double expected = 1.9 / sqrt(8.0 * options(&b)->polyline / 0.5);
        if (i) {
            assert_true((double)pointed.n > 0.7 * expected);
            assert_true((double)pointed.n < 2.0 * expected);
        } else {
            assert_int_equal(pointed.n, 0);
        }
        stop(&b);
    }
}

/* A ray's history is the same whoever traced what before. */
static void same_history(void **state)
{
    (void)state;
    struct bench b = {0};
    open_luneburg(&b, 0.3);
    b.scene->source[0].shape = RMAP_EMITTER_DISC;
    b.scene->source[0].shape_size[0] = 0.6;
    b.scene->surface[0].coat = RMAP_COAT_NONE;
    start(&b);
    struct rmap_step kept[8];
    const struct rmap_history *h = trace(&b, 77);
    size_t n = h->n_step < 8 ? h->n_step : 8;
    memcpy(kept, h->step, n * sizeof *kept);
    for (uint64_t ray = 0; ray < 200; ray++)
        (void)trace(&b, ray);
    h = trace(&b, 77);
    for (size_t i = 0; i < n; i++) {
        kept[i].colour = h->step[i].colour;
        assert_memory_equal(&kept[i].position, &h->step[i].position, sizeof kept[i].position);
        assert_true(kept[i].optical_path == h->step[i].optical_path);
    }
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(ends_in_space),
        cmocka_unit_test(turbid),
        cmocka_unit_test(points_recorded),
        cmocka_unit_test(same_history),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

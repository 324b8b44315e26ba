/* SPDX-License-Identifier: MIT
 *
 * Colours on the way: Beer-Lambert, coloured surfaces, dispersion.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "hand_bench.h"
#include "near.h"
#include "optics/fresnel.h"

/* Beer-Lambert at equal indices; where it is absorbed the depth has mean 1/mu - L/(e^(mu L) - 1).
 */
static void beer_lambert(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(1)};
    hand_medium(b.scene, 1.0);
    int32_t ink = add_slab(b.scene, 1.0, 2.0, hand_surface(b.scene, RMAP_SURFACE_FRESNEL));
    b.scene->medium[ink].absorption[0] = 0.5;
    b.scene->medium[ink].absorbing = true;
    add_beam(b.scene, 0.0);
    start(&b);
    enum { N = 40000 };
    double passed = 0.0, absorbed = 0.0, depth = 0.0;
    for (uint64_t ray = 0; ray < N; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        const struct rmap_step *last = &h->step[h->n_step - 1];
        assert_int_equal(h->step[0].events, RMAP_EVENT_TRANSMIT_SPECULAR); /* equal indices too */
        passed += h->ending.stop == RMAP_STOP_LEFT;
        if (h->ending.stop != RMAP_STOP_ABSORBED)
            continue;
        assert_int_equal(h->n_step, 2);
        assert_true(last->object == -1 && last->primitive == -1 && last->medium == ink);
        assert_int_equal(last->events, RMAP_EVENT_ABSORB);
        assert_near(last->position.z, last->length, 1e-15);
        assert_near(h->ending.path_length, 10.0 + last->length, 1e-14);
        absorbed += 1.0;
        depth += last->length;
    }
    double t = exp(-1.0);
    assert_mean(passed, N, t, t * (1.0 - t));
    assert_true(passed + absorbed == (double)N);
    double mean = 2.0 - 2.0 / (exp(1.0) - 1.0);
    assert_mean(depth, absorbed, mean, 1.0 / 3.0); /* variance at most L^2 / 12 */
    stop(&b);
}

/* Two channels with different absorption: posterior colours, by Bayes; shares stay normalised. */
static void colour_of_survivors(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(2)};
    hand_medium(b.scene, 1.0);
    int32_t filter = add_slab(b.scene, 1.0, 1.0, hand_surface(b.scene, RMAP_SURFACE_FRESNEL));
    struct rmap_medium *m = &b.scene->medium[filter];
    m->absorption[0] = 2.0;
    m->absorption[1] = 0.25;
    m->absorbing = true;
    add_beam(b.scene, 0.0);
    start(&b);
    enum { N = 20000 };
    double passed = 0.0, t0 = 0.5 * exp(-2.0), t1 = 0.5 * exp(-0.25);
    for (uint64_t ray = 0; ray < N; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        const double *c = h->step[1].colour;
        assert_near(c[0] + c[1], 1.0, 1e-15);
        if (h->ending.stop == RMAP_STOP_LEFT) {
            passed += 1.0;
            assert_near(c[0], t0 / (t0 + t1), 1e-14);
        } else {
            double s = h->step[1].length, a0 = 2.0 * exp(-2.0 * s), a1 = 0.25 * exp(-0.25 * s);
            assert_near(c[0], a0 / (a0 + a1), 1e-13);
        }
    }
    assert_mean(passed, N, t0 + t1, (t0 + t1) * (1.0 - t0 - t1));
    stop(&b);
}

/* A colour reflector: white light becomes c_i r_i / sum c r. */
static void colour_by_reflection(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(3)};
    hand_medium(b.scene, 1.0);
    int32_t mirror = hand_surface(b.scene, RMAP_SURFACE_MIRROR);
    double *r = b.scene->surface[mirror].reflect_specular;
    r[0] = 0.0;
    r[1] = 0.3;
    r[2] = 0.9;
    hand_object(b.scene, hand_rectangle(b.scene, 10, 10), mirror, hand_shift(0, 0, 0),
                RMAP_MEDIUM_ANY, RMAP_MEDIUM_ANY);
    add_beam(b.scene, 0.0);
    start(&b);
    enum { N = 20000 };
    double n = 0.0;
    for (uint64_t ray = 0; ray < N; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        assert_near(h->step[0].colour[1], 1.0 / 3.0, 1e-15);
        assert_true(isnan(h->ending.wavelength_nm));
        if (h->ending.stop != RMAP_STOP_LEFT)
            continue;
        n += 1.0;
        assert_true(h->step[1].colour[0] == 0.0);
        assert_near(h->step[1].colour[1], 0.25, 1e-15);
        assert_near(h->step[1].colour[2], 0.75, 1e-15);
    }
    assert_mean(n, N, 0.4, 0.24);
    stop(&b);
}

/* The wavelength is drawn at the first dispersive refraction, in proportion to what is
 * transmitted, and refracts by its own index. */
static void dispersion(void **state)
{
    (void)state;
    struct bench b = {.scene = hand_scene(3)};
    hand_medium(b.scene, 1.0);
    int32_t glass = add_slab(b.scene, 1.5, 2.0, hand_surface(b.scene, RMAP_SURFACE_FRESNEL));
    struct rmap_medium *m = &b.scene->medium[glass];
    const double n[3] = {1.7, 1.6, 1.5}, share[3] = {0.5, 0.2, 0.3};
    memcpy(m->n, n, sizeof n);
    m->dispersive = true;
    memcpy(add_beam(b.scene, 60.0)->colour, share, sizeof share);
    start(&b);
    enum { N = 20000 };
    double count[3] = {0}, reflected = 0.0, r[3], r_sum = 0.0;
    for (int i = 0; i < 3; i++) {
        struct rmap_fresnel f = rmap_fresnel_dielectric(1.0, n[i], 0.5);
        r[i] = 0.5 * (f.rs + f.rp);
        r_sum += share[i] * r[i];
    }
    for (uint64_t ray = 0; ray < N; ray++) {
        const struct rmap_history *h = trace(&b, ray);
        const double *c = h->step[1].colour;
        if (h->step[0].events == RMAP_EVENT_REFLECT_SPECULAR) {
            reflected += 1.0;
            for (int i = 0; i < 3; i++)
                assert_near(c[i], share[i] * r[i] / r_sum, 1e-14);
            continue;
        }
        int channel = c[0] == 1.0 ? 0 : c[1] == 1.0 ? 1 : 2;
        assert_true(c[channel] == 1.0);
        assert_near(h->step[1].direction.x, sin(RMAP_PI / 3.0) / n[channel], 1e-15);
        assert_near(h->step[1].optical_path - h->step[0].optical_path,
                    n[channel] * h->step[1].length, 1e-13);
        assert_true(h->ending.wavelength_nm == 450.0 + 50.0 * channel);
        count[channel] += 1.0;
    }
    assert_mean(reflected, N, r_sum, r_sum * (1.0 - r_sum));
    for (int i = 0; i < 3; i++) {
        double p = share[i] * (1.0 - r[i]);
        assert_mean(count[i], N, p, p * (1.0 - p));
    }
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(beer_lambert),
        cmocka_unit_test(colour_of_survivors),
        cmocka_unit_test(colour_by_reflection),
        cmocka_unit_test(dispersion),
    };
    return cmocka_run_group_tests_name("tracer_colour", test, NULL, NULL);
}

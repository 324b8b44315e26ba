/* SPDX-License-Identifier: MIT
 *
 * The promise: light of a measured lamp leaves with the intensity of its table, from a body that is
 * as bright all over as it is seen.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>
#include <stdio.h>

#include "base/rng.h"
#include "scene/lamp.h"

static void near_to(double is, double want, double within)
{
    if (!(fabs(is - want) <= within))
        fail_msg("%.12g, not %.12g (off by %.2g)", is, want, is - want);
}

/* Type C: azimuth 90 degrees is -y. */
static void set_axes(struct rmap_lamp *lamp)
{
    lamp->axis[0] = rmap_vec3(1, 0, 0);
    lamp->axis[1] = rmap_vec3(0, -1, 0);
    lamp->axis[2] = rmap_vec3(0, 0, 1);
}

static struct rmap_lamp lamp_of(const double *around, size_t n_around, const double *polar,
                                size_t n_polar, const double *candela)
{
    struct rmap_lamp lamp = {.n_around = 0};
    struct rmap_error err;
    assert_int_equal(rmap_lamp_init(around, n_around, polar, n_polar, candela, &lamp, &err),
                     RMAP_OK);
    set_axes(&lamp);
    return lamp;
}

/* I = a + b cos(gamma) + c sin(gamma) cos(C): 4 pi a, and the parts alone. */
static void test_flux_and_intensity(void **state)
{
    enum { AROUND = 24, POLAR = 181 };
    static double around[AROUND], polar[POLAR], candela[AROUND * POLAR];
    const double a = 100, b = 60, c = 30;
    (void)state;
    for (int k = 0; k < AROUND; k++)
        around[k] = 15.0 * k;
    for (int i = 0; i < POLAR; i++)
        polar[i] = i;
    for (int k = 0; k < AROUND; k++)
        for (int i = 0; i < POLAR; i++)
            candela[k * POLAR + i] =
                a + b * cos(polar[i] * RMAP_PI / 180) +
                c * sin(polar[i] * RMAP_PI / 180) * cos(around[k] * RMAP_PI / 180);
    struct rmap_lamp lamp = lamp_of(around, AROUND, polar, POLAR, candela);
    near_to(lamp.flux / (4 * RMAP_PI * a), 1, 3e-5);
    for (double x = -1; x < 1.01; x += 0.25)
        for (double y = -1; y < 1.01; y += 0.25)
            for (double z = -1; z < 1.01; z += 0.25) {
                const struct rmap_vec3 d = rmap_normalize(rmap_vec3(x, y, z + 1e-3));
                near_to(lamp.flux * rmap_lamp_intensity(&lamp, d), a + b * d.z + c * d.x, 0.3);
            }
    rmap_lamp_fini(&lamp);
}

/* Planes and angles at uneven distances, no light beyond them; drawn in bins of equal solid angle.
 */
static void test_draws(void **state)
{
    enum { DRAWS = 400000, BANDS = 20, SECTORS = 24, FINE = 24 };
    static const double around[] = {0, 30, 100, 200, 330}, polar[] = {10, 20, 45, 90, 120};
    static const double candela[] = {9, 5, 3, 1, 0, 1, 2, 8, 1, 0, 0, 0, 1,
                                     4, 0, 7, 7, 7, 7, 7, 0, 0, 0, 9, 0};
    static double count[BANDS][SECTORS];
    double chi2 = 0, inside = 0;
    int n_bin = 0;
    struct rmap_lamp lamp = lamp_of(around, 5, polar, 5, candela);
    (void)state;
    for (uint64_t i = 0; i < DRAWS; i++) {
        double u[4];
        rmap_rng(5, i, 0, RMAP_RNG_EMIT_DIRECTION, u);
        const struct rmap_vec3 d = rmap_lamp_draw(&lamp, u);
        const double turn = atan2(d.y, d.x) / (2 * RMAP_PI);
        near_to(rmap_length(d), 1, 1e-14);
        int band = (int)((1 - d.z) / 2 * BANDS),
            sector = (int)((turn < 0 ? turn + 1 : turn) * SECTORS);
        count[band < BANDS ? band : BANDS - 1][sector < SECTORS ? sector : SECTORS - 1]++;
    }
    for (int b = 0; b < BANDS; b++)
        for (int s = 0; s < SECTORS; s++) {
            double sum = 0;
            for (int i = 0; i < FINE * FINE; i++) {
                const double z = 1 - 2 * (b + (i / FINE + 0.5) / FINE) / BANDS,
                             phi = 2 * RMAP_PI * (s + (i % FINE + 0.5) / FINE) / SECTORS,
                             r = sqrt(1 - z * z);
                sum += rmap_lamp_intensity(&lamp, rmap_vec3(r * cos(phi), r * sin(phi), z));
            }
            const double part = sum / (FINE * FINE) * 4 * RMAP_PI / (BANDS * SECTORS),
                         want = part * DRAWS;
            inside += part;
            if (want < 10)
                continue;
            n_bin++;
            chi2 += (count[b][s] - want) * (count[b][s] - want) / want;
        }
    near_to(inside, 1, 3e-3); /* the edges cut through bins */
    assert_true(n_bin > 150);
    if (!(chi2 < n_bin + 6 * sqrt(2.0 * n_bin)))
        fail_msg("chi2 %.1f of %d bins", chi2, n_bin);
    rmap_lamp_fini(&lamp);
}

static void test_nothing(void **state)
{
    static const double around[] = {0}, polar[] = {0, 90}, dark[] = {0, 0};
    struct rmap_lamp lamp = {.n_around = 0};
    struct rmap_error err;
    (void)state;
    assert_int_equal(rmap_lamp_init(around, 1, polar, 2, dark, &lamp, &err), RMAP_INPUT);
    rmap_lamp_fini(&lamp);
}

/* Mean and second moments of a place across a direction. */
struct moments {
    double sum, mean[2], square[3];
};

static void note(struct moments *m, struct rmap_vec3 p, struct rmap_vec3 d, double weight)
{
    struct rmap_vec3 x, y;
    rmap_basis(d, &x, &y);
    const double a = rmap_dot(p, x), b = rmap_dot(p, y);
    m->sum += weight;
    m->mean[0] += weight * a;
    m->mean[1] += weight * b;
    m->square[0] += weight * a * a;
    m->square[1] += weight * a * b;
    m->square[2] += weight * b * b;
}

/* Places of light of a direction are spread as the surface is that looks there. */
static void test_bodies(void **state)
{
    enum { DRAWS = 300000 };
    static const struct rmap_lamp body[] = {
        {.body = RMAP_LAMP_BOX, .size = {2, 1, 0}},
        {.body = RMAP_LAMP_BOX, .size = {2, 1, 0.5}, .side = {0.5, 0.5}},
        {.body = RMAP_LAMP_BOX, .size = {2, 1, 0.5}, .side = {0.5, 0.1}},
        {.body = RMAP_LAMP_CYLINDER, .along = 2, .size = {2, 1, 0}},
        {.body = RMAP_LAMP_CYLINDER, .along = 2, .size = {2, 1, 1.5}},
        {.body = RMAP_LAMP_CYLINDER, .along = 0, .size = {2, 0.7, 0.3}},
        {.body = RMAP_LAMP_CYLINDER, .along = 1, .size = {0.7, 2, 0.3}},
        {.body = RMAP_LAMP_ELLIPSOID, .size = {2, 1, 0.6}},
    };
    static const struct rmap_vec3 way[] = {{0, 0, 1}, {0.3, 0.4, -0.5}, {1, 0.2, 0.1}};
    (void)state;
    for (size_t k = 0; k < sizeof body / sizeof *body; k++)
        for (size_t j = 0; j < sizeof way / sizeof *way; j++) {
            const struct rmap_vec3 d = rmap_normalize(way[j]);
            struct moments drawn = {0}, seen = {0};
            for (uint64_t i = 0; i < DRAWS; i++) {
                struct rmap_vec3 facing;
                double u[4];
                rmap_rng(9, i, 0, RMAP_RNG_EMIT_POINT, u);
                note(&drawn, rmap_lamp_point(&body[k], d, u), d, 1);
                rmap_rng(9, i, 1, RMAP_RNG_EMIT_POINT, u);
                const struct rmap_vec3 p = rmap_lamp_surface(&body[k], u, &facing);
                note(&seen, p, d, fmax(rmap_dot(facing, d), 0));
            }
            near_to(seen.sum / DRAWS / rmap_lamp_seen_area(&body[k], d), 1, 0.012);
            for (int i = 0; i < 2; i++)
                near_to(drawn.mean[i] / drawn.sum, seen.mean[i] / seen.sum, 0.006);
            for (int i = 0; i < 3; i++)
                near_to(drawn.square[i] / drawn.sum, seen.square[i] / seen.sum, 0.006);
        }
}

/* A line has no area: its light leaves from all of it. */
static void test_line(void **state)
{
    const struct rmap_lamp line = {.body = RMAP_LAMP_BOX, .size = {0, 3, 0}};
    struct rmap_vec3 facing;
    const double u[] = {0.3, 0.9, 0.2};
    (void)state;
    const struct rmap_vec3 p = rmap_lamp_point(&line, rmap_vec3(0.6, 0, 0.8), u),
                           q = rmap_lamp_surface(&line, u, &facing);
    near_to(p.y, 1.2, 1e-15);
    near_to(q.y, 1.2, 1e-15);
    near_to(rmap_lamp_seen_area(&line, rmap_vec3(0.6, 0, 0.8)), 0, 0);
    near_to(rmap_length(facing), 0, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_flux_and_intensity),
                                       cmocka_unit_test(test_draws), cmocka_unit_test(test_nothing),
                                       cmocka_unit_test(test_bodies), cmocka_unit_test(test_line)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

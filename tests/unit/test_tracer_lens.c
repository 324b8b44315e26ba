/* SPDX-License-Identifier: MIT
 *
 * Sequential accuracy: a double Gauss f/2 (CODE V's sample lens ag_dblgauss, 100 mm) against its
 * published real marginal ray, and against an independent trace in extended precision.
 */
#include <float.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_bench.h"
#include "near.h"

#define N_SURFACE 12 /* the image plane included */

static const double curvature[N_SURFACE] = {0.0177928409409154,  0.00656660053692557,
                                            0.0265374329467098,  0.0,
                                            0.0412689287857008,  0.0,
                                            -0.0352394265442907, 0.0,
                                            -0.0263675082865771, 0.00563660495174855,
                                            -0.0125926458590576, 0.0};
static const double thickness[N_SURFACE] = {8.75,
                                            0.5,
                                            12.5,
                                            3.8,
                                            16.3694449265356,
                                            13.7479569638891,
                                            3.8,
                                            11.0,
                                            0.5,
                                            7.0,
                                            61.4875364179821 - 0.4002686453541377};
/* At 587.6 nm, after each surface. */
static const double index_after[N_SURFACE] = {1.62229150078871,
                                              1.0,
                                              1.60737885858432,
                                              1.60341717819097,
                                              1.0,
                                              1.0,
                                              1.60341717819097,
                                              1.62040793306981,
                                              1.0,
                                              1.62040793306981,
                                              1.0,
                                              1.0};

/* Rays travel along +z through surface after surface; nothing is reflected. */
static struct bench double_gauss(const struct rmap_list_ray *list, size_t n_list)
{
    struct bench bench = {.scene = hand_scene(1)};
    struct rmap_scene *scene = bench.scene;
    int32_t before = hand_medium(scene, 1.0);
    int32_t clear = hand_surface(scene, RMAP_SURFACE_FRESNEL);
    int32_t black = hand_surface(scene, RMAP_SURFACE_ABSORBER);
    scene->surface[clear].coat = RMAP_COAT_IDEAL;
    double z = 0.0;
    for (int i = 0; i < N_SURFACE; i++) {
        int32_t after = hand_medium(scene, index_after[i]);
        bool air = index_after[i] == 1.0;
        if (air)
            after = 0;
        int32_t cap = hand_shape(scene, (struct rmap_shape){.type = RMAP_SHAPE_CONIC,
                                                            .curvature = curvature[i],
                                                            .aperture = 26.0});
        if (i == N_SURFACE - 1)
            cap = hand_rectangle(scene, 100, 100);
        hand_object(scene, cap, i == N_SURFACE - 1 ? black : clear, hand_shift(0, 0, z), after,
                    before);
        z += thickness[i];
        before = after;
    }
    struct rmap_source *source =
        hand_source(scene, RMAP_SOURCE_RAYS, rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 1));
    source->n_list = n_list;
    source->list = rmap_alloc(n_list, sizeof *list);
    for (size_t i = 0; i < n_list; i++)
        source->list[i] = list[i];
    start(&bench);
    return bench;
}

/* Columns x, z of the surface, tangent after it, path to it (the first from its vertex plane). */
static void published_marginal_ray(void **state)
{
    (void)state;
    static const double row[N_SURFACE][4] = {
        {25.0, 5.866433, -0.185302, 5.866433},       {24.109772, 1.920632, -0.200953, 4.885983},
        {22.844992, 7.714534, -0.394267, 6.419725},  {20.958242, 0.0, -0.395393, 5.143978},
        {16.784894, 6.754936, -0.112583, 11.350044}, {15.702464, 0.0, -0.112583, 9.675248},
        {14.610682, -4.050377, 0.15343, 9.758844},   {15.815163, 0.0, 0.151784, 7.942241},
        {16.882946, -3.965091, -0.057039, 7.115484}, {16.583956, 0.776812, -0.071127, 5.250422},
        {16.261006, -1.682704, -0.258832, 4.551955}, {0.014138, 0.0, -0.258832, 64.838492}};
    struct rmap_list_ray ray = {rmap_vec3(25, 0, 0), rmap_vec3(0, 0, 1), 0};
    struct bench b = double_gauss(&ray, 1);
    const struct rmap_history *h = trace(&b, 0);
    assert_int_equal(h->n_step, N_SURFACE);
    double z = 0.0;
    for (int i = 0; i < N_SURFACE; i++) {
        const struct rmap_step *step = &h->step[i];
        assert_int_equal(step->object, i);
        assert_int_equal(step->events,
                         i == N_SURFACE - 1 ? RMAP_EVENT_ABSORB : RMAP_EVENT_TRANSMIT_SPECULAR);
        assert_near(step->position.x, row[i][0], 2e-6);
        assert_near(step->position.z - z, row[i][1], 2e-6);
        assert_near(step->length, row[i][3], 2e-6);
        if (i + 1 < N_SURFACE)
            assert_near(step[1].direction.x / step[1].direction.z, row[i][2], 2e-6);
        z += thickness[i];
    }
    stop(&b);
}

struct long_ray {
    long double p[3], d[3], optical_path; /* p from the vertex of the surface last met */
};

static long double dot(const long double a[3], const long double b[3])
{
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

/* Transfer to a sphere and refraction in the manner of Welford (Aberrations of Optical Systems,
 * 1986), written for this test. */
static void next_surface(struct long_ray *ray, long double c, long double n1, long double n2)
{
    long double f = c * dot(ray->p, ray->p) - 2.0L * ray->p[2];
    long double g = ray->d[2] - c * dot(ray->p, ray->d);
    long double t = f / (g + sqrtl(g * g - c * f));
    for (int k = 0; k < 3; k++)
        ray->p[k] += t * ray->d[k];
    ray->optical_path += n1 * t;
    long double normal[3] = {-c * ray->p[0], -c * ray->p[1], 1.0L - c * ray->p[2]};
    long double cos_i = dot(normal, ray->d), eta = n1 / n2;
    long double cos_t = sqrtl(1.0L - eta * eta * (1.0L - cos_i * cos_i));
    for (int k = 0; k < 3; k++)
        ray->d[k] = eta * ray->d[k] + (cos_t - eta * cos_i) * normal[k];
}

/* 1e-12 of the lens's size at every surface, for skew rays over the whole pupil. */
static void extended_precision(void **state)
{
    (void)state;
    if (LDBL_MANT_DIG < 64)
        skip();
    enum { N = 200 };
    struct rmap_list_ray list[N];
    for (int k = 0; k < N; k++) {
        double r = 24.0 * sqrt((k + 0.5) / N), phi = 2.399963 * k; /* a sunflower */
        struct rmap_vec3 way = rmap_vec3(0.03, -0.02, 1.0);
        list[k] = (struct rmap_list_ray){rmap_vec3(r * cos(phi) - 0.6, r * sin(phi) + 0.4, -20.0),
                                         rmap_normalize(way), 0};
    }
    struct bench b = double_gauss(list, N);
    const double scale = 100.0;
    for (uint64_t k = 0; k < N; k++) {
        const struct rmap_history *h = trace(&b, k);
        assert_int_equal(h->n_step, N_SURFACE);
        const struct rmap_list_ray *l = &list[k];
        struct long_ray ray = {
            {(long double)l->origin.x, (long double)l->origin.y, -20.0L},
            {(long double)l->direction.x, (long double)l->direction.y, (long double)l->direction.z},
            0.0L};
        long double norm = sqrtl(dot(ray.d, ray.d)), n1 = 1.0L, z = 0.0L;
        for (int i = 0; i < 3; i++)
            ray.d[i] /= norm;
        for (int i = 0; i < N_SURFACE; i++) {
            long double n2 = (long double)index_after[i];
            next_surface(&ray, (long double)curvature[i], n1, n2);
            const struct rmap_step *step = &h->step[i];
            assert_near(step->position.x, (double)ray.p[0], 1e-12 * scale);
            assert_near(step->position.y, (double)ray.p[1], 1e-12 * scale);
            assert_near(step->position.z, (double)(ray.p[2] + z), 1e-12 * scale);
            assert_near(step->optical_path, (double)ray.optical_path, 1e-12 * scale);
            if (i + 1 < N_SURFACE) {
                assert_near(step[1].direction.x, (double)ray.d[0], 1e-12);
                assert_near(step[1].direction.y, (double)ray.d[1], 1e-12);
            }
            ray.p[2] -= (long double)thickness[i];
            z += (long double)thickness[i];
            n1 = n2;
        }
    }
    stop(&b);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(published_marginal_ray),
        cmocka_unit_test(extended_precision),
    };
    return cmocka_run_group_tests_name("tracer_lens", test, NULL, NULL);
}

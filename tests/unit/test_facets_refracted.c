/* SPDX-License-Identifier: MIT
 *
 * The promise: a rough boundary of two media, of facets that reflect and refract by Fresnel's laws,
 * is reciprocal in what it lets pass, f(a -> b) / n_b^2 = f(-b -> -a) / n_a^2 (Walter et al. 2007,
 * section 2; Veach 1997, eq. 5.14), and what its BSDF sends over both hemispheres is what is told
 * of it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>
#include <math.h>

#include "base/portable.h"
#include "base/vec.h"
#include "trace/scattering.h"

enum { WAYS = 2, ROUGH = 6 };
static const double index_of[WAYS] = {1.0, 1.5}; /* above, below */

static struct rmap_scatter rough(enum rmap_scatter_model model, double alpha_x, double alpha_y)
{
    return (struct rmap_scatter){
        .model = model,
        .refracts = true,
        .amount = {1.0},
        .shape = {[RMAP_SHAPE_ALPHA_X] = {alpha_x}, [RMAP_SHAPE_ALPHA_Y] = {alpha_y}}};
}

/* A bare boundary; as light meets it from above (0), or from below. */
struct boundary {
    struct rmap_scene scene;
    struct rmap_surface surface;
    struct rmap_scatter scatter;
};
static void set(struct boundary *its, int k)
{
    const struct rmap_scatter all[ROUGH] = {
        rough(RMAP_SCATTER_GGX, 0.5, 0.5),      rough(RMAP_SCATTER_GGX, 0.15, 0.15),
        rough(RMAP_SCATTER_GGX, 0.5, 0.2),      rough(RMAP_SCATTER_BECKMANN, 0.5, 0.5),
        rough(RMAP_SCATTER_BECKMANN, 0.2, 0.2), rough(RMAP_SCATTER_BECKMANN, 0.2, 0.6)};
    its->scatter = all[k];
    its->surface = (struct rmap_surface){
        .type = RMAP_SURFACE_FRESNEL, .scatter_reflect = 1, .scatter_transmit = 1};
    its->scene.scatter = &its->scatter;
}

static struct rmap_scatter_side side_of(const struct boundary *its, int way)
{
    return (struct rmap_scatter_side){.scene = &its->scene,
                                      .surface = &its->surface,
                                      .front = way == 0,
                                      .near = way,
                                      .far = 1 - way,
                                      .n1 = index_of[way],
                                      .n2 = index_of[1 - way],
                                      .x = {1, 0, 0},
                                      .y = {0, 1, 0},
                                      .normal = {0, 0, way ? -1 : 1}};
}

static struct boundary boundary;

/* Upwards; even in the projected solid angle. */
static struct rmap_vec3 direction(double u, double v)
{
    const double s = sqrt(u), turn = 2.0 * RMAP_PI * v;
    return rmap_vec3(s * cos(turn), s * sin(turn), sqrt(1.0 - u));
}

/* A pair of ways through the boundary, and back. */
struct pair {
    struct rmap_vec3 in, out; /* downwards, of travel */
};
static double passed(int way, const struct pair *pair)
{
    const struct rmap_scatter_side side = side_of(&boundary, way);
    return (way ? rmap_scatter_bsdf(&side, rmap_scale(pair->out, -1.0), rmap_scale(pair->in, -1.0))
                : rmap_scatter_bsdf(&side, pair->in, pair->out)) /
           (side.n2 * side.n2);
}

/* Without Fresnel's share, as if facets let all pass; in the frame of the side that light meets. */
static double passed_by_facets(int way, const struct pair *pair, double *cosine)
{
    struct rmap_vec3 in = pair->in, out = pair->out;
    if (way) {
        in = rmap_vec3(-pair->out.x, -pair->out.y, pair->out.z);
        out = rmap_vec3(-pair->in.x, -pair->in.y, pair->in.z);
    }
    const struct rmap_scattering at = {.scatter = &boundary.scatter,
                                       .passes = true,
                                       .front = way == 0,
                                       .n1 = index_of[way],
                                       .n2 = index_of[1 - way],
                                       .in = in};
    return rmap_facet_bsdf(&at, out, cosine) / (at.n2 * at.n2);
}

static void same(double there, double back, double within, const struct pair *pair)
{
    if (!(fabs(there - back) <= within))
        fail_msg("%.16g there, %.16g back, from (%g, %g, %g) to (%g, %g, %g)", there, back,
                 pair->in.x, pair->in.y, pair->in.z, pair->out.x, pair->out.y, pair->out.z);
}

/* 1e-12 of what facets send; they themselves are the same to 1e-15. Light that meets a facet edge
 * on in the air meets it at the angle of total reflection in the glass, where the share that passes
 * has fewer digits (4e-11 in 20,000 pairs): it is left out. */
static void test_reciprocity(void **state)
{
    enum { PAIRS = 20000 };
    const double exact = 1e-12, edge_on = 1e-2;
    (void)state;
    for (int k = 0; k < ROUGH; k++) {
        int n_lit = 0;
        set(&boundary, k);
        for (uint64_t i = 0; i < PAIRS; i++) {
            double u[4], cosine[WAYS];
            rmap_rng(3, i, (uint32_t)k, RMAP_RNG_SURFACE, u);
            const struct pair pair = {rmap_scale(direction(u[0], u[1]), -1.0),
                                      rmap_scale(direction(u[2], u[3]), -1.0)};
            const double there = passed_by_facets(0, &pair, &cosine[0]),
                         back = passed_by_facets(1, &pair, &cosine[1]);
            same(there, back, exact * there, &pair);
            if (there > 0.0 && cosine[0] > edge_on)
                same(passed(0, &pair), passed(1, &pair), exact * there, &pair);
            n_lit += there > 0.0 && cosine[0] > edge_on;
        }
        assert_true(n_lit > PAIRS / 5);
    }
}

/* By rings of equal angle and equal turns. */
static double sent(const struct rmap_scatter_side *side, struct rmap_vec3 in, bool passes)
{
    enum { RINGS = 800, AROUND = 240 };
    const double sign = passes == (side->normal.z > 0.0) ? -1.0 : 1.0;
    double sum = 0.0;
    for (int i = 0; i < RINGS; i++) {
        const double theta = 0.5 * RMAP_PI * (i + 0.5) / RINGS, z = cos(theta), s = sin(theta);
        for (int j = 0; j < AROUND; j++) {
            const double turn = 2.0 * RMAP_PI * (j + 0.5) / AROUND;
            sum += z * s *
                   rmap_scatter_bsdf(side, in, rmap_vec3(s * cos(turn), s * sin(turn), sign * z));
        }
    }
    return sum * RMAP_PI * RMAP_PI / RINGS / AROUND;
}

/* Nothing is absorbed but by facets in the way: what is told sums to 1, and is what the BSDF sends
 * over both hemispheres. Both are quadratures: 1.3e-4 apart from the air, as GGX has upright facets
 * at which the BSDF of what passes ends in a step, and 4.1e-4 from the glass, where some facets
 * begin to reflect totally and the one over facets is the less exact. */
static void test_furnace(void **state)
{
    static const double within[WAYS] = {2e-4, 5e-4};
    (void)state;
    for (int k = 0; k < ROUGH; k++)
        for (int way = 0; way < WAYS; way++)
            for (int degrees = 0; degrees <= 80; degrees += 40) {
                set(&boundary, k);
                const struct rmap_scatter_side side = side_of(&boundary, way);
                const double t = degrees * RMAP_PI / 180.0;
                struct rmap_vec3 in = rmap_vec3(0.8 * sin(t), 0.6 * sin(t), -cos(t));
                const struct rmap_surface_shares told = rmap_scatter_shares(&side, in);
                in.z *= side.normal.z;
                const double off[2] = {sent(&side, in, false) - told.reflect_diffuse,
                                       sent(&side, in, true) - told.transmit_diffuse};
                assert_true(told.missing >= 0.0 && told.reflect_specular == 0.0 &&
                            told.transmit_specular == 0.0);
                if (!(fabs(told.reflect_diffuse + told.transmit_diffuse + told.missing - 1.0) <
                      1e-12))
                    fail_msg("shares of %.16g, %.16g and %.16g", told.reflect_diffuse,
                             told.transmit_diffuse, told.missing);
                if (!(fabs(off[0]) < within[way] && fabs(off[1]) < within[way]))
                    fail_msg("roughness %d, from %g, at %d degrees: off by %.2g reflected, %.2g "
                             "passing",
                             k, index_of[way], degrees, off[0], off[1]);
            }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_reciprocity),
        cmocka_unit_test(test_furnace),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

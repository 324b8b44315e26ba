/* SPDX-License-Identifier: MIT
 *
 * Shapes against brute force: the ray is sampled densely in long double, sign changes of the
 * shape's own equation are bisected, and the first root that belongs to the shape is compared.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "geometry/shape.h"
#include "sag_reference.h"

struct line {
    real p[3], d[3];
};

static real sag(const struct rmap_shape *s, real r2)
{
    real c = s->curvature;
    real z = c * r2 / (1 + sqrtl(fmaxl(0, 1 - (1 + s->conic) * c * c * r2)));
    real power = r2;
    for (int i = 0; i < s->n_asphere; i++, power *= r2)
        z += s->asphere[i] * power;
    return z;
}

/* Zero on the surface; NaN where it has no value. */
static real equation(const struct rmap_shape *s, const struct line *line, real t)
{
    real x = line->p[0] + t * line->d[0], y = line->p[1] + t * line->d[1];
    real z = line->p[2] + t * line->d[2], r2 = x * x + y * y;
    switch (s->type) {
    case RMAP_SHAPE_CONIC:
        return z - sag(s, r2);
    case RMAP_SHAPE_SAG:
        return z - sag_reference(s->sag[0], x, y);
    case RMAP_SHAPE_TUBE:
        return r2 - powl(s->radius + (s->radius2 - s->radius) * z / s->length, 2);
    case RMAP_SHAPE_SPHERE:
        return r2 + z * z - (real)s->radius * s->radius;
    default:
        return z;
    }
}

static bool inside(const struct rmap_shape *s, const struct line *line, real t)
{
    real x = line->p[0] + t * line->d[0], y = line->p[1] + t * line->d[1];
    real z = line->p[2] + t * line->d[2], r = sqrtl(x * x + y * y);
    switch (s->type) {
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC:
        return r <= s->aperture && r >= s->inner;
    case RMAP_SHAPE_RECTANGLE:
        return fabsl(x) <= 0.5L * s->size[0] && fabsl(y) <= 0.5L * s->size[1];
    case RMAP_SHAPE_SAG:
        x = (x - s->outline.at[0]) / s->outline.half[0];
        y = (y - s->outline.at[1]) / s->outline.half[1];
        if (hypotl(x * s->outline.half[0], y * s->outline.half[1]) < s->outline.inner)
            return false;
        return s->outline.rectangle ? fabsl(x) <= 1 && fabsl(y) <= 1 : x * x + y * y <= 1;
    case RMAP_SHAPE_TUBE:
        return z >= 0 && z <= s->length;
    default:
        return true;
    }
}

/* All roots in (low, high), in order; at most max. */
static int brute_force(const struct rmap_shape *s, const struct line *line, real low, real high,
                       real *root, int max)
{
    enum { STEPS = 1500 };
    int n = 0;
    real a = low, fa = equation(s, line, a);
    for (int i = 1; i <= STEPS && n < max; i++) {
        real b = low + (high - low) * i / STEPS, fb = equation(s, line, b);
        if ((fa < 0 && fb > 0) || (fa > 0 && fb < 0)) {
            real from = a, to = b;
            for (int k = 0; k < 80; k++) {
                real middle = 0.5L * (from + to), f = equation(s, line, middle);
                if ((f < 0) == (fa < 0))
                    from = middle;
                else
                    to = middle;
            }
            if (inside(s, line, from))
                root[n++] = from;
        }
        a = b;
        fa = fb;
    }
    return n;
}

static double uniform(uint64_t i, int k)
{
    double u[4];
    rmap_rng(31, i, (uint32_t)(k / 4), RMAP_RNG_SURFACE, u);
    return u[k % 4];
}

/* A ray that passes through a point near the shape, from `distance` away. */
static struct line make_line(const struct rmap_shape *shape, uint64_t i, double distance,
                             struct rmap_vec3 *p, struct rmap_vec3 *d)
{
    struct rmap_vec3 lower, upper;
    rmap_shape_bounds(shape, &lower, &upper);
    struct rmap_vec3 to = rmap_vec3(lower.x + (upper.x - lower.x) * uniform(i, 0),
                                    lower.y + (upper.y - lower.y) * uniform(i, 1),
                                    lower.z + (upper.z - lower.z) * uniform(i, 2));
    double z = 1 - 2 * uniform(i, 3), phi = 2 * RMAP_PI * uniform(i, 4), r = sqrt(1 - z * z);
    *d = rmap_vec3(r * cos(phi), r * sin(phi), z);
    if (i % 7 == 0)
        *d = rmap_vec3(0, 0, i % 2 ? 1 : -1); /* along the axis */
    if (i % 11 == 0)
        *d = rmap_vec3(cos(phi), sin(phi), 0); /* across it */
    if (i % 5 == 0)
        *d = rmap_scale(*d, 3.7); /* a direction of another length */
    *p = rmap_axpy(-distance / rmap_length(*d), *d, to);
    return (struct line){{p->x, p->y, p->z}, {d->x, d->y, d->z}};
}

static struct rmap_shape shapes[] = {
    {.type = RMAP_SHAPE_CONIC, .curvature = 1 / 50.0, .aperture = 12.5},
    {.type = RMAP_SHAPE_CONIC, .curvature = -1 / 13.0, .aperture = 13, .inner = 2},
    {.type = RMAP_SHAPE_CONIC, .curvature = 1 / 20.0, .conic = -1, .aperture = 15},
    {.type = RMAP_SHAPE_CONIC, .curvature = 1 / 5.0, .conic = -3.5, .aperture = 15},
    {.type = RMAP_SHAPE_CONIC, .curvature = -1 / 20.0, .conic = 0.7, .aperture = 15},
    {.type = RMAP_SHAPE_CONIC, .curvature = 1 / 20.0, .conic = -0.6, .aperture = 30},
    {.type = RMAP_SHAPE_CONIC, .curvature = 0, .aperture = 4},
    {.type = RMAP_SHAPE_CONIC, .curvature = 1e-7, .conic = -1, .aperture = 40},
    {.type = RMAP_SHAPE_CONIC,
     .curvature = 1 / 40.0,
     .conic = -1,
     .asphere = {0, 1e-5, -3e-8},
     .n_asphere = 3,
     .aperture = 12},
    {.type = RMAP_SHAPE_CONIC, /* a gull wing: up to four roots */
     .curvature = 1 / 10.0,
     .conic = 0.2,
     .asphere = {0.01, -1.5e-3, 1.2e-5},
     .n_asphere = 3,
     .aperture = 8.5,
     .inner = 0.5},
    {.type = RMAP_SHAPE_DISC, .aperture = 5, .inner = 2},
    {.type = RMAP_SHAPE_RECTANGLE, .size = {20, 10}},
    {.type = RMAP_SHAPE_TUBE, .radius = 5, .radius2 = 5, .length = 30},
    {.type = RMAP_SHAPE_TUBE, .radius = 5, .radius2 = 0, .length = 8},
    {.type = RMAP_SHAPE_TUBE, .radius = 1, .radius2 = 6, .length = 2},
    {.type = RMAP_SHAPE_SPHERE, .radius = 7},
    {.type = RMAP_SHAPE_SAG}, /* set_sags */
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
    {.type = RMAP_SHAPE_SAG},
};
enum { N_SHAPE = sizeof(shapes) / sizeof(shapes[0]), FIRST_SAG = 16 };

/* Terms of (degree, place): rmap_sag_term is no constant. */
#define TERM(degree, k) [(degree) * ((degree) + 1) / 2 + (k)]
static struct profile {
    struct rmap_sag sag;
    struct rmap_aperture outline;
} profiles[N_SHAPE - FIRST_SAG] = {
    /* odd powers without a tip, and with one */
    {{.curvature = {0.02, 0.02},
      .conic = {0.5, 0.5},
      .power = {0, 0, 2e-4, 1e-5, -3e-6},
      .n_power = 5},
     {.half = {12, 12}}},
    {{.curvature = {-0.01, -0.01}, .power = {0.2, 0.01, -1e-3}, .n_power = 3},
     {.half = {9, 9}, .inner = 0.5}},
    {{.base = RMAP_SAG_BICONIC, .curvature = {0.05, -0.02}, .conic = {-0.7, 2}},
     {.rectangle = true, .half = {12, 8}, .at = {1, -2}}},
    {{.base = RMAP_SAG_TOROID,
      .curvature = {1 / 30.0, 0.02},
      .conic = {0, -1},
      .power = {0.01, 0, 1e-4, 2e-5},
      .n_power = 4},
     {.half = {14, 9}}},
    {{.base = RMAP_SAG_TOROID, .curvature = {0, -0.06}}, {.rectangle = true, .half = {20, 10}}},
    /* a wavy plate that rays cross more than twice */
    {{.xy_norm = 5,
      .xy = {TERM(2, 0) = 0.3, TERM(3, 1) = -0.5, TERM(4, 0) = 0.2, TERM(5, 2) = 0.3,
             TERM(6, 6) = -0.1},
      .n_xy = 7},
     {.half = {6, 6}}},
    {{.curvature = {0.03, 0.03},
      .zernike_norm = 10,
      .zernike = {TERM(2, 0) = 0.4, TERM(3, 2) = -0.2, TERM(4, 2) = 0.3, TERM(8, 5) = 0.1,
                  TERM(9, 0) = 0.05},
      .n_zernike = 10},
     {.half = {10, 7}, .at = {0, 2}}},
    {{.curvature = {0.025, 0.025},
      .conic = {-1, -1},
      .qcon_norm = 11,
      .qcon = {1, -0.5, 0.3, 0.1, 0.05},
      .n_qcon = 5},
     {.half = {11, 11}, .inner = 2}},
    {{.curvature = {0.04, 0.04},
      .qbfs_norm = 10,
      .qbfs = {0.8, 0.3, -0.2, 0.1, 0, 0.05},
      .n_qbfs = 6},
     {.half = {10, 10}}},
};

static int set_sags(void **state)
{
    (void)state;
    for (int k = 0; k < N_SHAPE - FIRST_SAG; k++)
        assert_null(
            rmap_shape_of_sag(&shapes[FIRST_SAG + k], &profiles[k].sag, &profiles[k].outline));
    return 0;
}

/* Slope of the equation along the ray, per unit length: how well the root is determined. */
static double steepness(const struct rmap_shape *s, const struct line *line, real t)
{
    real h = 1e-5L;
    real f = (equation(s, line, t + h) - equation(s, line, t - h)) / (2 * h);
    if (s->type == RMAP_SHAPE_SPHERE || s->type == RMAP_SHAPE_TUBE)
        f /= 2 * fmax(s->radius, s->radius2);
    return (double)fabsl(f);
}

static void check_hit(int k, uint64_t i, const struct line *line, real root, bool found,
                      const struct rmap_shape_hit *hit, double distance)
{
    const struct rmap_shape *s = &shapes[k];
    if (!found)
        fail_msg("shape %d, ray %d: nothing instead of %.17g", k, (int)i, (double)root);
    double far = 1e-13 * (distance + 50) / fmax(steepness(s, line, root), 1e-6);
    if (fabsl(hit->t - root) > far)
        fail_msg("shape %d, ray %d: %.17g instead of %.17g", k, (int)i, hit->t, (double)root);
    struct line at = {{hit->point.x, hit->point.y, hit->point.z},
                      {hit->normal.x, hit->normal.y, hit->normal.z}};
    assert_true(fabsl(equation(s, &at, 0)) < 1e-12 * (distance + 50));
    assert_true(fabs(rmap_length(hit->normal) - 1) < 1e-14);
    /* the equation grows along the normal, as fast as along no other direction */
    real h = 1e-6L;
    struct rmap_vec3 u, v;
    rmap_basis(hit->normal, &u, &v);
    real slope = (equation(s, &at, h) - equation(s, &at, -h)) / (2 * h);
    struct line tangent = {{at.p[0], at.p[1], at.p[2]}, {u.x, u.y, u.z}};
    real across = (equation(s, &tangent, h) - equation(s, &tangent, -h)) / (2 * h);
    if (!(slope > 0) || fabsl(across) > 1e-4L * slope)
        fail_msg("shape %d, ray %d: normal off, %g along, %g across", k, (int)i, (double)slope,
                 (double)across);
}

static void check_against_brute_force(int k, double distance, uint64_t n)
{
    const struct rmap_shape *s = &shapes[k];
    int met = 0;
    if (s->type == RMAP_SHAPE_SAG)
        n /= 4; /* sums in long double take their time */
    assert_null(rmap_shape_check(s));
    for (uint64_t i = 1; i <= n; i++) {
        struct rmap_vec3 p, d;
        struct line line = make_line(s, i, distance, &p, &d);
        real length = sqrtl(line.d[0] * line.d[0] + line.d[1] * line.d[1] + line.d[2] * line.d[2]);
        real low = (distance - 100) / length, high = (distance + 100) / length, root[8];
        int n_root = brute_force(s, &line, low, high, root, 8);
        struct rmap_shape_hit hit;
        real t_min = low;
        bool rim = false; /* a root this near to the rim or tangent may go either way */
        for (int j = 0; j < n_root; j++)
            rim |= steepness(s, &line, root[j]) < 1e-3 || !inside(s, &line, root[j] + 1e-9L) ||
                   !inside(s, &line, root[j] - 1e-9L);
        if (rim)
            continue;
        for (int j = 0; j < n_root; j++) {
            bool found = rmap_shape_intersect(s, p, d, false, (double)t_min, (double)high, &hit);
            check_hit(k, i, &line, root[j], found, &hit, distance);
            t_min = root[j] + 1e-7L;
            met++;
        }
        if (rmap_shape_intersect(s, p, d, false, (double)t_min, (double)high, &hit)) {
            /* what sampling stepped over: two roots within a step, or one at the rim */
            struct line at = {{hit.point.x, hit.point.y, hit.point.z}, {0, 0, 0}};
            assert_true(fabsl(equation(s, &at, 0)) < 1e-12 * (distance + 50));
            assert_true(inside(s, &line, hit.t));
        }
    }
    if (met < (int)n / 5)
        fail_msg("shape %d: only %d hits", k, met);
}

static void test_roots_as_sampled(void **state)
{
    (void)state;
    for (int k = 0; k < N_SHAPE; k++)
        check_against_brute_force(k, 60, 1000);
}

static void test_roots_from_far_away(void **state)
{
    (void)state;
    for (int k = 0; k < N_SHAPE; k++)
        check_against_brute_force(k, 1e6, 300);
}

/* From each root the others are found, and it is not found again. */
static void test_starts_on_the_surface(void **state)
{
    (void)state;
    for (int k = 0; k < N_SHAPE; k++) {
        const struct rmap_shape *s = &shapes[k];
        int others = 0;
        for (uint64_t i = 1; i <= 1500; i++) {
            struct rmap_vec3 p, d;
            struct line line = make_line(s, i, 60, &p, &d);
            struct rmap_shape_hit first, next, again;
            if (!rmap_shape_intersect(s, p, d, false, 0, INFINITY, &first))
                continue;
            if (steepness(s, &line, first.t) < 1e-2)
                continue;
            double t = first.t + 1e-6;
            bool more = rmap_shape_intersect(s, p, d, false, t, INFINITY, &next);
            bool found = rmap_shape_intersect(s, first.point, d, true, 0, INFINITY, &again);
            if (more && steepness(s, &line, next.t) < 1e-2)
                continue;
            if (found != more)
                fail_msg("shape %d, ray %d: %d from the surface, %d from outside", k, (int)i, found,
                         more);
            if (!found)
                continue;
            others++;
            assert_true(fabs(again.t - (next.t - first.t)) < 1e-10);
            /* and backwards */
            found =
                rmap_shape_intersect(s, next.point, rmap_scale(d, -1), true, 0, INFINITY, &again);
            assert_true(found);
            assert_true(fabs(again.t - (next.t - first.t)) < 1e-10);
        }
        bool closed = s->type == RMAP_SHAPE_SPHERE || s->type == RMAP_SHAPE_TUBE;
        if (closed || k == 9)
            assert_true(others > 100);
    }
}

/* A chord so short that it is all rounding for a solver which keeps both roots. */
static void test_grazing_chords(void **state)
{
    (void)state;
    struct rmap_shape sphere = {.type = RMAP_SHAPE_SPHERE, .radius = 100};
    struct rmap_shape cap = {.type = RMAP_SHAPE_CONIC, .curvature = 0.01, .aperture = 90};
    struct rmap_shape bowl = cap;
    bowl.n_asphere = 1; /* the same surface through the other solver */
    for (double angle = 1e-1; angle > 1e-9; angle *= 0.5) {
        struct rmap_vec3 d = rmap_vec3(cos(angle), 0, sin(angle));
        struct rmap_shape_hit hit;
        double chord = 2 * 100 * sin(angle);
        assert_true(
            rmap_shape_intersect(&sphere, rmap_vec3(0, 0, -100), d, true, 0, INFINITY, &hit));
        assert_true(fabs(hit.t - chord) < 1e-12 * (1 + chord));
        if (chord > 80)
            continue;
        assert_true(rmap_shape_intersect(&cap, rmap_vec3(0, 0, 0), d, true, 0, INFINITY, &hit));
        assert_true(fabs(hit.t - chord) < 1e-12 * (1 + chord));
        assert_true(rmap_shape_intersect(&bowl, rmap_vec3(0, 0, 0), d, true, 0, INFINITY, &hit));
        assert_true(fabs(hit.t - chord) < 1e-9 * chord + 1e-12);
    }
}

/* Two roots within 1e-6 of one another, as only an isolating solver finds them. */
static void test_an_asphere_touched_from_below(void **state)
{
    (void)state;
    struct rmap_shape s = {.type = RMAP_SHAPE_CONIC,
                           .curvature = -0.02,
                           .asphere = {0, 1e-7},
                           .n_asphere = 2,
                           .aperture = 20};
    for (double depth = 1e-3; depth > 1e-12; depth *= 0.1) {
        /* across the vertex, `depth` below the top: z = -depth */
        struct rmap_shape_hit first, second;
        struct rmap_vec3 p = rmap_vec3(-50, 0, -depth), d = rmap_vec3(1, 0, 0);
        assert_true(rmap_shape_intersect(&s, p, d, false, 0, INFINITY, &first));
        assert_true(rmap_shape_intersect(&s, p, d, false, first.t + 1e-9, INFINITY, &second));
        double half = sqrt(depth / 0.01);
        assert_true(fabs((second.t - first.t) / (2 * half) - 1) < 1e-3);
        p.z = depth;
        assert_false(rmap_shape_intersect(&s, p, d, false, 0, INFINITY, &first));
    }
}

static void test_sag_and_bounds(void **state)
{
    (void)state;
    for (int k = 0; k < N_SHAPE; k++) {
        const struct rmap_shape *s = &shapes[k];
        if (s->type != RMAP_SHAPE_CONIC)
            continue;
        struct rmap_vec3 lower, upper;
        rmap_shape_bounds(s, &lower, &upper);
        for (int i = 0; i <= 1000; i++) {
            double r = s->inner + (s->aperture - s->inner) * i / 1000;
            double z = rmap_shape_sag(s, r);
            real root = 1 - (1 + s->conic) * (real)s->curvature * s->curvature * r * r;
            double steep = 1 / (double)sqrtl(fmaxl(root, 1e-14L));
            assert_true(fabs(z - (double)sag(s, (real)r * r)) < 1e-13 * steep);
            assert_true(z >= lower.z && z <= upper.z);
        }
    }
    struct rmap_shape ball = {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = 9};
    assert_true(isnan(rmap_shape_sag(&ball, 10.5)));
}

static void test_bad_numbers_are_refused(void **state)
{
    (void)state;
    const struct rmap_shape bad[] = {
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = 10.001},
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = 0},
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = -1},
        {.type = RMAP_SHAPE_CONIC, .curvature = NAN, .aperture = 1},
        {.type = RMAP_SHAPE_CONIC, .curvature = INFINITY, .aperture = 1},
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .conic = NAN, .aperture = 1},
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = 1, .inner = 1},
        {.type = RMAP_SHAPE_CONIC, .aperture = 1, .asphere = {NAN}, .n_asphere = 1},
        {.type = RMAP_SHAPE_CONIC, .aperture = 1, .n_asphere = 17},
        {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = 10, .n_asphere = 1},
        {.type = RMAP_SHAPE_CONIC, .aperture = 1e200, .asphere = {1, 1}, .n_asphere = 2},
        {.type = RMAP_SHAPE_DISC, .aperture = NAN},
        {.type = RMAP_SHAPE_DISC, .aperture = 1, .inner = -1},
        {.type = RMAP_SHAPE_RECTANGLE, .size = {1, 0}},
        {.type = RMAP_SHAPE_RECTANGLE, .size = {INFINITY, 1}},
        {.type = RMAP_SHAPE_TUBE, .radius = 0, .radius2 = 0, .length = 1},
        {.type = RMAP_SHAPE_TUBE, .radius = 1, .radius2 = -1, .length = 1},
        {.type = RMAP_SHAPE_TUBE, .radius = 1, .radius2 = 1, .length = 0},
        {.type = RMAP_SHAPE_SPHERE, .radius = 0},
        {.type = RMAP_SHAPE_SPHERE, .radius = NAN},
        {.type = (enum rmap_shape_type)99},
    };
    for (size_t k = 0; k < sizeof(bad) / sizeof(bad[0]); k++)
        if (!rmap_shape_check(&bad[k]))
            fail_msg("shape %zu was accepted", k);
    struct rmap_shape half = {.type = RMAP_SHAPE_CONIC, .curvature = 0.1, .aperture = 10};
    assert_null(rmap_shape_check(&half)); /* a whole half sphere */
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_roots_as_sampled),
        cmocka_unit_test(test_roots_from_far_away),
        cmocka_unit_test(test_starts_on_the_surface),
        cmocka_unit_test(test_grazing_chords),
        cmocka_unit_test(test_an_asphere_touched_from_below),
        cmocka_unit_test(test_sag_and_bounds),
        cmocka_unit_test(test_bad_numbers_are_refused),
    };
    return cmocka_run_group_tests(tests, set_sags, NULL);
}

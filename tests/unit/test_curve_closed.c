/* SPDX-License-Identifier: MIT
 *
 * Rays in closed form: against the error-controlled scheme at its finest, and against sines; dense
 * output, cuts, lengths and bend within what they promise; which fields have a closed form.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "gradient/curve.h"
#include "gradient/field_made.h"
#include "gradient/field_polynomial.h"
#include "gradient/models.h"
#include "near.h"

static struct rmap_error err;

static double apart(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_length(rmap_sub(a, b));
}

static struct rmap_gradient in_place(const struct rmap_field *field,
                                     const struct rmap_affine *to_world, double tolerance)
{
    struct rmap_gradient gradient = {
        .field = field,
        .to_world = *to_world,
        .size = 2.0,
        .options = {.scheme = RMAP_SCHEME_ADAPTIVE, .tolerance = tolerance}};
    assert_true(rmap_affine_invert(to_world, &gradient.to_local));
    return gradient;
}

/* n^2 = 4 + ..., by its terms 1, x, y, z, xx, xy, yy, xz, yz, zz: a bowl, a hill, a saddle, and
 * without second powers. */
static const double form[][10] = {{4.0, 0.1, -0.2, 0.3, -0.8, 0.3, -0.9, -0.2, 0.1, -1.1},
                                  {3.0, 0.2, 0.1, -0.1, 0.9, 0.2, 0.7, -0.3, 0.1, 1.2},
                                  {3.0, -0.1, 0.3, 0.2, 0.9, 0.4, -1.0, 0.3, -0.2, 0.2},
                                  {2.0, 0.3, -0.4, 0.5, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0}};

static struct rmap_field *field_of(const double term[10])
{
    static const int power[10][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {2, 0, 0},
                                     {1, 1, 0}, {0, 2, 0}, {1, 0, 1}, {0, 1, 1}, {0, 0, 2}};
    struct rmap_field *field = NULL;
    assert_int_equal(
        rmap_field_polynomial(&field, RMAP_SERIES_OF_N_SQUARED, 1, 10, power, term, &err), RMAP_OK);
    return field;
}

static const struct rmap_vec3 start = {-0.5, 0.2, 0.1};

/* The place, T, and both lengths after a time, by steps within 2e-13. */
struct known {
    struct rmap_vec3 r, T;
    double optical, length;
};

static struct known integrate(struct rmap_gradient gradient, struct rmap_vec3 direction, double t)
{
    struct rmap_curve curve;
    struct rmap_curve_step step;
    struct known known = {.optical = 0.0};
    gradient.options.scheme = RMAP_SCHEME_INTEGRATED;
    gradient.options.tolerance = 2e-13;
    assert_true(rmap_curve_begin(&curve, &gradient, 0, start, direction));
    assert_false(curve.closed);
    while (t > 0.0) {
        assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        if (step.h > t)
            assert_true(rmap_curve_cut(&curve, &step, t / step.h));
        t -= step.h;
        known.optical += step.optical;
        known.length += step.length;
    }
    known.r = curve.state.r;
    known.T = curve.state.T;
    return known;
}

/* A step of the closed form, from `before` on, inside and at its end; then cut. */
static void check_step(const struct rmap_gradient *gradient, struct rmap_curve *curve,
                       struct rmap_curve_step *step, struct rmap_vec3 direction, double before)
{
    enum { PARTS = 5 };
    const double tolerance = gradient->options.tolerance, rounding = 2e-12;
    struct known from = integrate(*gradient, direction, before);
    struct rmap_vec3 chord = rmap_sub(step->to.r, step->from.r);
    for (int i = 1; i <= PARTS; i++) {
        struct rmap_curve_step cut = *step;
        struct rmap_curve of = *curve;
        struct rmap_vec3 r, T;
        double theta = (double)i / PARTS, optical, length;
        struct known at = integrate(*gradient, direction, before + theta * step->h);
        rmap_curve_at(step, theta, &r, &T);
        rmap_curve_lengths(step, theta, &optical, &length);
        assert_near(apart(r, at.r), 0.0, tolerance + rounding);
        assert_near(apart(T, at.T), 0.0, 10.0 * tolerance * rmap_length(T) + rounding);
        assert_near(optical, at.optical - from.optical, 4.0 * tolerance + rounding);
        assert_near(length, at.length - from.length, 4.0 * tolerance + rounding);
        double along = rmap_dot(rmap_sub(r, step->from.r), chord) / rmap_dot(chord, chord);
        struct rmap_vec3 on_chord = rmap_axpy(along, chord, step->from.r);
        assert_true(apart(r, on_chord) <=
                    0.125 * rmap_curve_bend(step) * step->h * step->h + rounding);
        assert_true(rmap_curve_cut(&of, &cut, theta));
        assert_near(apart(of.state.r, at.r), 0.0, rounding);
        assert_near(apart(of.state.T, at.T), 0.0, rounding);
        assert_near(rmap_length(of.state.T), of.state.n, rounding);
        assert_near(cut.optical, at.optical - from.optical, 4.0 * tolerance + rounding);
    }
}

static void follows_integration(void **state)
{
    static const double tolerance[] = {1e-3, 1e-6, 1e-9, 1e-12};
    const struct rmap_affine place[] = {
        rmap_affine_identity(),
        {{{0.9, 0.3, 0.0}, {-0.2, 1.2, 0.4}, {0.1, 0.0, -0.8}}, {0.1, -0.05, 0.02}}};
    struct rmap_vec3 direction = rmap_normalize(rmap_vec3(0.8, -0.3, 0.4));
    (void)state;
    for (size_t f = 0; f < sizeof form / sizeof form[0]; f++) {
        struct rmap_field *field = field_of(form[f]);
        for (int k = 0; k < 8; k++) {
            struct rmap_gradient gradient = in_place(field, &place[k / 4], tolerance[k % 4]);
            struct rmap_curve curve;
            struct rmap_curve_step step;
            double t = 0.0, longest = 0.0;
            assert_true(rmap_curve_begin(&curve, &gradient, 0, start, direction));
            assert_true(curve.closed);
            for (int i = 0; i < 3; i++) {
                assert_true(rmap_curve_advance(&curve, INFINITY, &step));
                check_step(&gradient, &curve, &step, direction, t);
                t += step.h;
                longest = fmax(longest, step.h);
            }
            assert_true(curve.n_evaluation <= 8); /* uphill a step may prove too long */
            print_message("form %d, place %d, tolerance %g: steps up to %.3g\n", (int)f, k / 4,
                          tolerance[k % 4], longest);
        }
        rmap_field_destroy(field);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Luneburg 1944, sec. 28: r0 cos t + T0 sin t, to rounding, for as long as one likes. */
static void luneburg_is_exact(void **state)
{
    const struct rmap_luneburg parameter = {1.0, 1.0};
    const struct rmap_affine here = rmap_affine_identity();
    struct rmap_vec3 r0 = {-0.8, 0.6, 0.0}, T0 = {1.0, 0.0, 0.0};
    struct rmap_field *field = NULL;
    struct rmap_curve curve;
    struct rmap_curve_step step;
    long double sum = 0.0L; /* t: its own rounding would show */
    (void)state;
    assert_int_equal(rmap_field_luneburg(&field, 1, &parameter, &err), RMAP_OK);
    struct rmap_gradient gradient = in_place(field, &here, 2e-9);
    assert_true(rmap_curve_begin(&curve, &gradient, 0, r0, T0));
    for (int i = 0; i < 1000; i++) {
        assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        sum += step.h;
        double t = (double)remainderl(sum, 6.283185307179586476925286766559L);
        struct rmap_vec3 r = rmap_axpy(sin(t), T0, rmap_scale(r0, cos(t)));
        struct rmap_vec3 T = rmap_axpy(-sin(t), r0, rmap_scale(T0, cos(t)));
        assert_near(apart(curve.state.r, r), 0.0, 1e-15 * (i + 10));
        assert_near(apart(curve.state.T, T), 0.0, 1e-15 * (i + 10));
    }
    rmap_field_destroy(field);
}

/* From the centre straight out: n falls to 0 where T does, and light turns back there. */
static void turns_where_index_ends(void **state)
{
    const struct rmap_luneburg parameter = {1.0, 1.0};
    const struct rmap_affine here = rmap_affine_identity();
    struct rmap_field *field = NULL;
    struct rmap_curve curve;
    struct rmap_curve_step step;
    (void)state;
    assert_int_equal(rmap_field_luneburg(&field, 1, &parameter, &err), RMAP_OK);
    struct rmap_gradient gradient = in_place(field, &here, 2e-9);
    assert_true(
        rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(0, 0, 0), rmap_vec3(0.6, 0.0, 0.8)));
    while (rmap_length(curve.state.r) < 1.414 && curve.n_step < 10000)
        assert_true(rmap_curve_advance(&curve, INFINITY, &step));
    assert_true(curve.n_step < 10000);
    rmap_field_destroy(field);
}

static bool has_closed_form(struct rmap_field *field, double bend[3][3])
{
    assert_non_null(field);
    bool has = rmap_field_quadratic(field, 0, bend);
    rmap_field_destroy(field);
    return has;
}

static struct rmap_field *series(enum rmap_series_variable s, enum rmap_series_of q, int n,
                                 const double *coefficient)
{
    struct rmap_field *field = NULL;
    assert_int_equal(rmap_field_series(&field, s, q, 1, n, coefficient, &err), RMAP_OK);
    return field;
}

static void which_fields(void **state)
{
    static const double c[4] = {2.0, -0.1, -0.2, 0.0}, cubic[4] = {2.0, 0.1, 0.2, 1e-9};
    const struct rmap_parabolic rod = {1.5, 0.1};
    const struct rmap_selfoc selfoc = {1.5, 0.01};
    const struct rmap_maxwell maxwell = {2.0, 1.0};
    const struct rmap_dispersed dispersed = {0.5, 0.1};
    struct rmap_affine to_local = rmap_affine_identity();
    struct rmap_field *field = NULL;
    double bend[3][3];
    (void)state;
    assert_true(has_closed_form(series(RMAP_SERIES_Z, RMAP_SERIES_OF_N_SQUARED, 4, c), bend));
    assert_near(bend[2][2], -0.2, 0.0);
    assert_near(bend[0][0], 0.0, 0.0);
    assert_true(has_closed_form(series(RMAP_SERIES_R2, RMAP_SERIES_OF_N_SQUARED, 2, c), bend));
    assert_near(bend[2][2], -0.1, 0.0);
    assert_true(has_closed_form(series(RMAP_SERIES_RHO2, RMAP_SERIES_OF_N, 1, c), bend));
    assert_near(bend[0][0], 0.0, 0.0);
    assert_false(has_closed_form(series(RMAP_SERIES_R2, RMAP_SERIES_OF_N_SQUARED, 3, c), bend));
    assert_false(has_closed_form(series(RMAP_SERIES_Z, RMAP_SERIES_OF_N_SQUARED, 4, cubic), bend));
    assert_false(has_closed_form(series(RMAP_SERIES_Z, RMAP_SERIES_OF_N, 2, c), bend));
    assert_int_equal(rmap_field_selfoc(&field, 1, &selfoc, &err), RMAP_OK);
    assert_false(has_closed_form(field, bend));
    assert_int_equal(rmap_field_maxwell(&field, 1, &maxwell, &err), RMAP_OK);
    assert_false(has_closed_form(field, bend));
    assert_int_equal(rmap_field_parabolic(&field, 1, &rod, &err), RMAP_OK);
    assert_int_equal(rmap_field_dispersed(&field, field, 1, &dispersed, &err), RMAP_OK);
    assert_false(has_closed_form(field, bend));
    to_local.m[0][0] = 0.0;
    to_local.m[0][2] = 2.0;
    to_local.m[2][2] = 0.0;
    to_local.m[2][0] = -1.0;
    assert_int_equal(rmap_field_parabolic(&field, 1, &rod, &err), RMAP_OK);
    assert_int_equal(rmap_field_placed(&field, field, &to_local, &err), RMAP_OK);
    assert_true(has_closed_form(field, bend));
    assert_near(bend[0][0], 0.0, 0.0);
    assert_near(bend[1][1], -0.0225, 1e-16);
    assert_near(bend[2][2], -0.09, 1e-16);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(follows_integration), cmocka_unit_test(luneburg_is_exact),
        cmocka_unit_test(turns_where_index_ends), cmocka_unit_test(which_fields)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Rays in fields whose rays are known: the error-controlled scheme keeps its tolerance, its dense
 * output too; Sharma's scheme has the errors of its algebra.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_field.h"
#include "near.h"

static double apart(struct rmap_vec3 a, struct rmap_vec3 b)
{
    return rmap_length(rmap_sub(a, b));
}

/* Luneburg's ray at t: r0 cos t + T0 sin t. */
static struct rmap_vec3 luneburg_at(struct rmap_vec3 r0, struct rmap_vec3 T0, double t)
{
    return rmap_axpy(sin(t), T0, rmap_scale(r0, cos(t)));
}

/* Steps until r.direction > 0 turns false on the sphere of radius 1; the exit is found on the dense
 * output. */
static bool cut_on_sphere(struct rmap_curve *curve, struct rmap_curve_step *step)
{
    if (rmap_dot(step->to.r, step->to.r) < 1.0 || rmap_dot(step->to.r, step->to.T) < 0.0) {
        return false;
    }
    double low = 0.0;
    double high = 1.0;
    for (int i = 0; i < 60; i++) {
        struct rmap_vec3 r;
        struct rmap_vec3 T;
        double middle = (low + high) / 2;
        rmap_curve_at(step, middle, &r, &T);
        if (rmap_dot(r, r) > 1.0 && rmap_dot(r, T) > 0.0) {
            high = middle;
        } else {
            low = middle;
        }
    }
    assert_true(rmap_curve_cut(curve, step, high));
    return true;
}

struct passage {
    struct rmap_curve_state end;
    double optical, length;
    uint64_t n_evaluation, n_step;
};

static struct passage pass_sphere(const struct rmap_gradient *gradient, struct rmap_vec3 origin,
                                  struct rmap_vec3 direction)
{
    struct rmap_curve curve;
    struct rmap_curve_step step;
    struct passage passage = {0};
    bool out = false;
    assert_true(rmap_curve_begin(&curve, gradient, 0, origin, direction));
    while (!out) {
        assert_true(curve.n_step < 100000);
        assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        out = cut_on_sphere(&curve, &step);
        passage.optical += step.optical;
        passage.length += step.length;
    }
    passage.end = curve.state;
    passage.n_evaluation = curve.n_evaluation;
    passage.n_step = curve.n_step;
    return passage;
}

/* Luneburg 1944, Mathematical Theory of Optics, sec. 28; lengths from the closed form. */
static void luneburg_focuses(void **state)
{
    static const struct {
        double h, optical, length;
    } ray[] = {
        {0.1, 2.56578376390152, 1.99811039072191},  {0.3, 2.52473552821184, 1.98256005803073},
        {0.6, 2.3707963267949, 1.92297663892336},   {0.9, 2.00668622114896, 1.77288520139354},
        {0.99, 1.71186368659156, 1.63948492778588},
    };
    static const double tolerance[] = {1e-6, 1e-9, 1e-12};
    (void)state;
    struct hand_field field = hand_luneburg();
    for (int k = 0; k < 3; k++) {
        struct rmap_gradient gradient = hand_gradient(&field, 2.0, tolerance[k]);
        double within = 2.0 * tolerance[k] + 1e-13;
        for (size_t i = 0; i < sizeof ray / sizeof ray[0]; i++) {
            double h = ray[i].h;
            struct rmap_vec3 origin = {-sqrt(1.0 - h * h), h, 0.0};
            struct passage p = pass_sphere(&gradient, origin, rmap_vec3(1.0, 0.0, 0.0));
            print_message("h %g tol %g: %d steps %d evaluations, errors %.2g %.2g %.2g %.2g\n", h,
                          tolerance[k], (int)p.n_step, (int)p.n_evaluation,
                          apart(p.end.r, rmap_vec3(1.0, 0.0, 0.0)),
                          apart(p.end.T, rmap_vec3(sqrt(1.0 - h * h), -h, 0.0)),
                          p.optical - ray[i].optical, p.length - ray[i].length);
            assert_near(apart(p.end.r, rmap_vec3(1.0, 0.0, 0.0)), 0.0, within);
            assert_near(apart(p.end.T, rmap_vec3(sqrt(1.0 - h * h), -h, 0.0)), 0.0, within);
            assert_near(p.optical, ray[i].optical, within);
            assert_near(p.length, ray[i].length, within);
        }
    }
}

/* Errors of the scheme's algebra on a linear problem, to three digits: they tell it from any other
 * scheme of order 4 (computed with numpy from the three equations of Sharma et al. 1982). */
static void sharma_has_its_errors(void **state)
{
    static const struct {
        int steps;
        double r, T;
    } row[] = {
        {4, 0.000253733713447572, 0.000205170714931504},
        {8, 1.50422746288606e-05, 1.35266385768805e-05},
        {16, 9.15607443933278e-07, 8.68259441286014e-07},
        {32, 5.64725265662871e-08, 5.49930252595606e-08},
        {64, 3.50621140976744e-09, 3.45997827490607e-09},
    };
    (void)state;
    struct hand_field field = hand_luneburg();
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 1e-9);
    struct rmap_vec3 r0 = {-0.8, 0.6, 0.0};
    struct rmap_vec3 T0 = {1.0, 0.0, 0.0};
    gradient.options.scheme = RMAP_SCHEME_SHARMA_FIXED;
    for (size_t i = 0; i < sizeof row / sizeof row[0]; i++) {
        struct rmap_curve curve;
        struct rmap_curve_step step;
        double dt = RMAP_PI / 2 / row[i].steps;
        assert_true(rmap_curve_begin(&curve, &gradient, 0, r0, T0));
        for (int k = 0; k < row[i].steps; k++) {
            gradient.options.step = dt * curve.state.n;
            assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        }
        assert_int_equal(curve.n_evaluation, 1 + 3 * row[i].steps);
        assert_near(apart(curve.state.r, T0), row[i].r, 1e-3 * row[i].r);
        assert_near(apart(curve.state.T, rmap_scale(r0, -1.0)), row[i].T, 1e-3 * row[i].T);
    }
}

/* The dense output of every step, of either scheme, against the closed form. */
static void dense_output_follows(void **state)
{
    (void)state;
    struct hand_field field = hand_luneburg();
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 1e-9);
    struct rmap_vec3 r0 = {-0.8, 0.6, 0.0};
    struct rmap_vec3 T0 = {1.0, 0.0, 0.0};
    for (int scheme = RMAP_SCHEME_ADAPTIVE; scheme <= RMAP_SCHEME_SHARMA_FIXED; scheme++) {
        struct rmap_curve curve;
        struct rmap_curve_step step;
        double t = 0.0;
        double worst_r = 0.0;
        double worst_T = 0.0;
        gradient.options.scheme = (enum rmap_scheme)scheme;
        assert_true(rmap_curve_begin(&curve, &gradient, 0, r0, T0));
        while (t < 3.0) {
            assert_true(rmap_curve_advance(&curve, INFINITY, &step));
            for (int i = 0; i <= 10; i++) {
                struct rmap_vec3 r;
                struct rmap_vec3 T;
                double s = t + 0.1 * i * step.h;
                rmap_curve_at(&step, 0.1 * i, &r, &T);
                worst_r = fmax(worst_r, apart(r, luneburg_at(r0, T0, s)));
                worst_T = fmax(worst_T, apart(T, luneburg_at(T0, rmap_scale(r0, -1.0), s)));
            }
            t += step.h;
        }
        print_message("scheme %d: %d steps, worst %.2g %.2g\n", scheme, (int)curve.n_step, worst_r,
                      worst_T);
        assert_near(worst_r, 0.0, scheme == RMAP_SCHEME_ADAPTIVE ? 1e-9 : 1e-8);
        assert_near(worst_T, 0.0, scheme == RMAP_SCHEME_ADAPTIVE ? 1e-8 : 5e-8);
    }
}

/* Kepler's ellipse close to the singular centre: optical length pi + 2 sqrt(1 - h^2) (Eaton 1952);
 * straight into the centre: an end, not a hang. */
static void eaton_turns_back(void **state)
{
    static const double height[] = {0.2, 0.5, 0.8, 0.95, 0.02};
    (void)state;
    struct hand_field field = hand_other(&hand_eaton);
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 2e-9);
    for (size_t i = 0; i < sizeof height / sizeof height[0]; i++) {
        double h = height[i];
        double x = -sqrt(1.0 - h * h);
        struct passage p = pass_sphere(&gradient, rmap_vec3(x, h, 0.0), rmap_vec3(1.0, 0.0, 0.0));
        print_message("eaton %g: %d steps %d evaluations, error %.2g\n", h, (int)p.n_step,
                      (int)p.n_evaluation, apart(p.end.r, rmap_vec3(x, -h, 0.0)));
        assert_near(apart(p.end.r, rmap_vec3(x, -h, 0.0)), 0.0, 1e-5);
        assert_near(p.optical, RMAP_PI - 2.0 * x, 1e-5);
    }
    struct rmap_curve curve;
    struct rmap_curve_step step;
    assert_true(rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(-1.0, 0.0, 0.0),
                                 rmap_vec3(1.0, 0.0, 0.0)));
    while (curve.state.r.x < 0.0 && rmap_curve_advance(&curve, INFINITY, &step)) {
        assert_true(curve.n_step < 20000);
    }
}

/* The place on the fish-eye's circle after a time of 1.2 in so many equal steps. */
static struct rmap_vec3 fisheye_by_sharma(int steps)
{
    struct hand_field field = hand_other(&hand_fisheye);
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 1e-9);
    struct rmap_curve curve;
    struct rmap_curve_step step;
    gradient.options.scheme = RMAP_SCHEME_SHARMA_FIXED;
    assert_true(rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(-1.0, 0.0, 0.0),
                                 rmap_vec3(cos(0.5), sin(0.5), 0.0)));
    for (int k = 0; k < steps; k++) {
        gradient.options.step = 1.2 / steps * curve.state.n;
        assert_true(rmap_curve_advance(&curve, INFINITY, &step));
    }
    return curve.state.r;
}

/* Errors fall with the fourth power of the step where the problem is not linear either. */
static void sharma_is_of_order_4(void **state)
{
    (void)state;
    struct rmap_vec3 end = fisheye_by_sharma(4096);
    double before = apart(fisheye_by_sharma(64), end);
    for (int steps = 128; steps <= 512; steps *= 2) {
        double error = apart(fisheye_by_sharma(steps), end);
        assert_near(log2(before / error), 4.0, 0.2);
        before = error;
    }
}

/* |T| = n along 100,000 steps: of Sharma's scheme within its order, of the other within tolerance.
 */
static void drift_is_slow(void **state)
{
    (void)state;
    struct hand_field field = hand_rod(1.5, 0.1);
    struct rmap_gradient gradient = hand_gradient(&field, 16.0, 1.6e-8);
    struct rmap_vec3 direction = rmap_normalize(rmap_vec3(0.1, 0.2, 1.0));
    for (int k = 0; k < 2; k++) {
        struct rmap_curve curve;
        struct rmap_curve_step step;
        gradient.options.scheme = k ? RMAP_SCHEME_SHARMA_FIXED : RMAP_SCHEME_ADAPTIVE;
        gradient.options.step = 0.05;
        assert_true(rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(2.0, 0.0, 0.0), direction));
        struct rmap_curve_state start = curve.state;
        while (curve.n_step < 100000) {
            assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        }
        double drift = fabs(rmap_length(curve.state.T) / curve.state.n - 1.0);
        print_message("drift of %d steps to z = %g: %.2g\n", (int)curve.n_step, curve.state.r.z,
                      drift);
        assert_near(drift, 0.0, k ? 1e-9 : 1e-6);
        assert_near(curve.state.T.z, start.T.z, 0.0); /* nothing pulls along the rod */
    }
}

/* The end's light sent back; Bouguer's |r x T| is kept about a centre (Born & Wolf 3.2). */
static void light_goes_back(void **state)
{
    static const struct {
        const struct rmap_field_ops *ops;
        double x, y;
    } ray[] = {{&hand_fisheye, 0.9, 0.4}, {&hand_eaton, 1.0, 0.3}, {&hand_square, 1.0, 0.2}};
    static const double tolerance = 2e-9;
    (void)state;
    for (size_t i = 0; i < sizeof ray / sizeof ray[0]; i++) {
        struct hand_field field = hand_luneburg();
        field.field.ops = ray[i].ops;
        struct rmap_gradient gradient = hand_gradient(&field, 2.0, tolerance);
        struct rmap_curve curve;
        struct rmap_curve_step step;
        struct rmap_vec3 start = {-0.8, 0.4, 0.1};
        struct rmap_vec3 direction = rmap_normalize(rmap_vec3(ray[i].x, ray[i].y, 0.1));
        assert_true(rmap_curve_begin(&curve, &gradient, 0, start, direction));
        double bouguer = rmap_length(rmap_cross(curve.state.r, curve.state.T));
        double length = 0.0;
        for (int k = 0; k < 12; k++) {
            assert_true(rmap_curve_advance(&curve, INFINITY, &step));
            length += step.length;
            struct rmap_vec3 turn = rmap_cross(curve.state.r, curve.state.T);
            assert_near(rmap_length(turn), bouguer, 10 * tolerance);
            assert_near(rmap_length(curve.state.T), curve.state.n, 10 * tolerance * curve.state.n);
        }
        struct rmap_vec3 back = rmap_scale(curve.state.T, -1.0 / rmap_length(curve.state.T));
        assert_true(rmap_curve_begin(&curve, &gradient, 0, curve.state.r, back));
        while (length > 1e-12) {
            assert_true(rmap_curve_advance(&curve, length, &step));
            if (step.length > length) {
                double theta = 1.0;
                for (int k = 0; k < 5; k++) {
                    double optical;
                    double here;
                    rmap_curve_lengths(&step, theta, &optical, &here);
                    theta -= (here - length) / (step.h * step.to.n);
                }
                assert_true(rmap_curve_cut(&curve, &step, theta));
                break;
            }
            length -= step.length;
        }
        assert_near(apart(curve.state.r, start), 0.0, 10 * tolerance);
        assert_near(apart(curve.state.T, rmap_scale(direction, -curve.state.n)), 0.0,
                    10 * tolerance);
    }
}

/* Steps across a kink of the field keep the tolerance, and it costs a bounded number of them. */
static void kink_is_crossed(void **state)
{
    (void)state;
    struct hand_field field = hand_other(&hand_bend);
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 2e-9);
    struct rmap_vec3 direction = rmap_normalize(rmap_vec3(1.0, 0.0, 1.0));
    struct rmap_curve curve;
    struct rmap_curve_step step;
    double end[2];
    for (int k = 0; k < 2; k++) { /* from a way off; from the kink itself */
        struct rmap_vec3 start = rmap_scale(direction, k ? 0.0 : -0.7321);
        assert_true(rmap_curve_begin(&curve, &gradient, 0, start, direction));
        do {
            assert_true(curve.n_step < 200);
            assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        } while (curve.state.r.z < 1.0);
        double low = 0.0;
        double high = 1.0;
        struct rmap_vec3 r;
        struct rmap_vec3 T;
        for (int i = 0; i < 60; i++) {
            double middle = (low + high) / 2;
            rmap_curve_at(&step, middle, &r, &T);
            *(r.z > 1.0 ? &high : &low) = middle;
        }
        end[k] = r.x;
    }
    assert_near(end[0], end[1], 2e-8);
}

/* Where the field ends, the curve goes on a little, once: a surface there is met. */
static void field_ends(void **state)
{
    (void)state;
    struct hand_field field = {.field = {.ops = &hand_square, .n_channel = 1}, .a = 1.0};
    field.b = rmap_vec3(0.0, 0.0, -1.0); /* no value from z = 1 on */
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 2e-9);
    struct rmap_curve curve;
    struct rmap_curve_step step;
    gradient.options.scheme = RMAP_SCHEME_ADAPTIVE;
    field.a = 1.0;
    assert_true(rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(0.0, 0.0, 0.5),
                                 rmap_vec3(0.0, 0.0, -1.0)));
    assert_false(
        rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(0.0, 0.0, 1.5), rmap_vec3(0.0, 0.0, 1.0)));
    struct hand_field edge = hand_other(&hand_edge);
    gradient.field = &edge.field;
    for (int scheme = RMAP_SCHEME_ADAPTIVE; scheme <= RMAP_SCHEME_SHARMA_FIXED; scheme++) {
        gradient.options.scheme = (enum rmap_scheme)scheme;
        assert_true(rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(0.0, 0.0, 0.0),
                                     rmap_normalize(rmap_vec3(0.3, 0.0, 1.0))));
        while (rmap_curve_advance(&curve, INFINITY, &step)) {
            assert_true(curve.n_step < 100000);
        }
        assert_true(curve.state.r.z > 1.0);
        assert_true(curve.state.r.z < 1.0 + 1e-8);
        assert_true(curve.n_evaluation < 40000);
    }
}

/* Bounds of the sag against many points of the curve. */
static void sag_is_bounded(void **state)
{
    (void)state;
    struct hand_field field = hand_other(&hand_eaton);
    struct rmap_gradient gradient = hand_gradient(&field, 2.0, 2e-6);
    struct rmap_curve curve;
    struct rmap_curve_step step;
    assert_true(rmap_curve_begin(&curve, &gradient, 0, rmap_vec3(-0.8, 0.6, 0.0),
                                 rmap_vec3(1.0, 0.0, 0.0)));
    for (int k = 0; k < 20; k++) {
        assert_true(rmap_curve_advance(&curve, INFINITY, &step));
        struct rmap_vec3 a;
        struct rmap_vec3 b;
        struct rmap_vec3 p;
        struct rmap_vec3 T;
        double sag = 0.0;
        rmap_curve_at(&step, 0.1, &a, &T);
        rmap_curve_at(&step, 0.9, &b, &T);
        struct rmap_vec3 way = rmap_normalize(rmap_sub(b, a));
        for (int i = 0; i <= 1000; i++) {
            rmap_curve_at(&step, 0.1 + 0.0008 * i, &p, &T);
            sag = fmax(sag, rmap_length(rmap_cross(rmap_sub(p, a), way)));
        }
        double said = rmap_curve_sag(&step, 0.1, 0.9);
        assert_true(said >= sag);
        assert_true(said <= 1.1 * sag);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(luneburg_focuses),     cmocka_unit_test(sharma_has_its_errors),
        cmocka_unit_test(dense_output_follows), cmocka_unit_test(eaton_turns_back),
        cmocka_unit_test(sharma_is_of_order_4), cmocka_unit_test(drift_is_slow),
        cmocka_unit_test(light_goes_back),      cmocka_unit_test(kink_is_crossed),
        cmocka_unit_test(field_ends),           cmocka_unit_test(sag_is_bounded),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

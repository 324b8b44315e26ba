/* SPDX-License-Identifier: MIT
 *
 * Fields of noise, of formulas and on grids: values, gradients, edges, holes.
 */
#include <pthread.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "base/rng.h"
#include "gradient/field_formula.h"
#include "gradient/field_grid.h"
#include "gradient/field_noise.h"
#include "tests/unit/near.h"

static struct rmap_vec3 any_place(uint64_t i, double size)
{
    double u[4];
    rmap_rng(7, i, 0, RMAP_RNG_SURFACE, u);
    return rmap_vec3(size * (u[0] - 0.5), size * (u[1] - 0.5), size * (u[2] - 0.5));
}

static double value_at(const struct rmap_field *field, struct rmap_vec3 p)
{
    double n = 0;
    struct rmap_vec3 slope;
    assert_true(rmap_field_scalar(field, 0, p, &n, &slope));
    return n;
}

/* The gradient is the slope of the value: by differences of fourth order. */
static void assert_slope(const struct rmap_field *field, struct rmap_vec3 p, double h, double slack)
{
    double n;
    struct rmap_vec3 slope;
    assert_true(rmap_field_scalar(field, 0, p, &n, &slope));
    const double is[3] = {slope.x, slope.y, slope.z};
    for (int axis = 0; axis < 3; axis++) {
        const struct rmap_vec3 e = rmap_vec3(axis == 0, axis == 1, axis == 2);
        double one = value_at(field, rmap_axpy(h, e, p)) - value_at(field, rmap_axpy(-h, e, p));
        double two =
            value_at(field, rmap_axpy(2 * h, e, p)) - value_at(field, rmap_axpy(-2 * h, e, p));
        assert_near(is[axis], (8 * one - two) / (12 * h), slack);
    }
}

/* ---- noise ---- */

static struct rmap_field *noise_of(uint64_t seed, int n_octave)
{
    const struct rmap_noise parameter = {.mean = 1.3,
                                         .amplitude = 0.1,
                                         .length = 2,
                                         .persistence = 0.5,
                                         .lacunarity = 2,
                                         .n_octave = n_octave,
                                         .seed = seed};
    struct rmap_field *field = NULL;
    assert_int_equal(rmap_field_noise(&field, 1, &parameter, NULL), RMAP_OK);
    return field;
}

static void test_noise(void **state)
{
    (void)state;
    struct rmap_field *one = noise_of(3, 1), *many = noise_of(3, 4), *other = noise_of(4, 1);
    double most = 0, sum = 0, n_differ = 0;
    enum { N = 4000 };
    for (uint64_t i = 0; i < N; i++) {
        struct rmap_vec3 p = any_place(i, 100);
        double n = value_at(one, p);
        most = fmax(most, fabs(n - 1.3));
        sum += n - 1.3;
        n_differ += n != value_at(other, p);
        /* Period: 256 cells. */
        assert_near(value_at(one, rmap_add(p, rmap_vec3(512, -512, 1024))), n, 1e-11);
        if (i >= 100)
            continue;
        assert_slope(one, p, 1e-3, 1e-9);
        assert_slope(many, p, 1e-4, 1e-7);
    }
    assert_true(most > 0.06 && most <= 0.104);
    assert_near(sum / N, 0, 0.004);
    assert_true(n_differ > 0.99 * N);
    /* 0 at lattice points; its gradient there is that of the corner alone: length sqrt(2). */
    double n;
    struct rmap_vec3 slope;
    assert_true(rmap_field_at(one, 0, rmap_vec3(4, -6, 10), &n, &slope));
    assert_near(n, 1.3, 1e-15);
    assert_near(rmap_length(slope), 0.1 / 2 * sqrt(2), 1e-15);
    assert_false(rmap_field_at(one, 0, rmap_vec3((double)INFINITY, 0, 0), &n, &slope));
    rmap_field_destroy(one);
    rmap_field_destroy(many);
    rmap_field_destroy(other);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_noise_mistakes(void **state)
{
    (void)state;
    const struct rmap_noise good = {
        .mean = 1, .amplitude = 1, .length = 1, .persistence = 1, .lacunarity = 2, .n_octave = 1};
    struct rmap_noise bad[4] = {good, good, good, good};
    struct rmap_field *field = NULL;
    bad[0].length = 0;
    bad[1].n_octave = 0;
    bad[2].amplitude = (double)NAN;
    bad[3].lacunarity = -1;
    for (int i = 0; i < 4; i++)
        assert_int_equal(rmap_field_noise(&field, 1, &bad[i], NULL), RMAP_INPUT);
}

/* ---- grids ---- */

static struct rmap_grid *grid_of(const size_t n[3], double (*value)(struct rmap_vec3))
{
    struct rmap_grid *grid = NULL;
    const struct rmap_vec3 origin = {-1, -2, -3},
                           spacing = {2 / ((double)n[0] - 1), 4 / ((double)n[1] - 1),
                                      6 / ((double)n[2] - 1)};
    assert_int_equal(rmap_grid_create(n, origin, spacing, &grid, NULL), RMAP_OK);
    size_t at = 0;
    for (size_t i = 0; i < n[0]; i++)
        for (size_t j = 0; j < n[1]; j++)
            for (size_t k = 0; k < n[2]; k++)
                grid->value[at++] = value(rmap_vec3(origin.x + (double)i * spacing.x,
                                                    origin.y + (double)j * spacing.y,
                                                    origin.z + (double)k * spacing.z));
    return grid;
}

static struct rmap_field *field_of_grid(struct rmap_grid *grid, enum rmap_interpolation kind,
                                        double outside)
{
    struct rmap_field *field = NULL;
    assert_int_equal(rmap_field_grid(&field, grid, kind, outside, NULL), RMAP_OK);
    rmap_grid_drop(grid);
    return field;
}

static double quadratic(struct rmap_vec3 p)
{
    return 3 + p.x - 0.5 * p.y + 0.25 * p.z + 0.3 * p.x * p.x - 0.2 * p.y * p.z + 0.1 * p.z * p.z;
}

static double linear(struct rmap_vec3 p)
{
    return 3 + p.x - 0.5 * p.y + 0.25 * p.z;
}

static double wave(struct rmap_vec3 p)
{
    return 2 + 0.3 * sin(p.x + 0.4 * p.y) * cos(0.7 * p.z);
}

static struct rmap_vec3 inside(uint64_t i)
{
    struct rmap_vec3 p = any_place(i, 2);
    return rmap_vec3(p.x, 2 * p.y, 3 * p.z);
}

static void test_grids_are_exact(void **state)
{
    (void)state;
    const size_t n[3] = {6, 5, 7}, few[3] = {2, 3, 4};
    struct rmap_field *flat = field_of_grid(grid_of(n, linear), RMAP_TRILINEAR, (double)NAN);
    struct rmap_field *curved = field_of_grid(grid_of(n, quadratic), RMAP_TRICUBIC, (double)NAN);
    struct rmap_field *small = field_of_grid(grid_of(few, linear), RMAP_TRICUBIC, (double)NAN);
    for (uint64_t i = 0; i < 300; i++) {
        struct rmap_vec3 p = inside(i), slope;
        double value;
        assert_near(value_at(flat, p), linear(p), 1e-14);
        assert_near(value_at(small, p), linear(p), 1e-14);
        assert_near(value_at(curved, p), quadratic(p), 1e-14);
        assert_true(rmap_field_scalar(flat, 0, p, &value, &slope));
        assert_near(slope.x, 1, 1e-13);
        assert_near(slope.y, -0.5, 1e-13);
        assert_true(rmap_field_scalar(curved, 0, p, &value, &slope));
        assert_near(slope.x, 1 + 0.6 * p.x, 1e-13);
        assert_near(slope.y, -0.5 - 0.2 * p.z, 1e-13);
        assert_near(slope.z, 0.25 - 0.2 * p.y + 0.2 * p.z, 1e-13);
    }
    rmap_field_destroy(flat);
    rmap_field_destroy(curved);
    rmap_field_destroy(small);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Largest errors of value and gradient of a wave on a grid of n cells along each axis. */
static void errors(enum rmap_interpolation kind, size_t n, double error[2])
{
    const size_t nodes[3] = {n + 1, n + 1, n + 1};
    struct rmap_field *field = field_of_grid(grid_of(nodes, wave), kind, (double)NAN);
    error[0] = error[1] = 0;
    for (uint64_t i = 0; i < 2000; i++) {
        struct rmap_vec3 p = inside(i), slope;
        double value, u = p.x + 0.4 * p.y;
        assert_true(rmap_field_at(field, 0, p, &value, &slope));
        struct rmap_vec3 exact = {0.3 * cos(u) * cos(0.7 * p.z), 0.12 * cos(u) * cos(0.7 * p.z),
                                  -0.21 * sin(u) * sin(0.7 * p.z)};
        error[0] = fmax(error[0], fabs(value - wave(p)));
        error[1] = fmax(error[1], rmap_length(rmap_sub(slope, exact)));
    }
    rmap_field_destroy(field);
}

static void test_grids_converge(void **state)
{
    (void)state;
    const struct {
        enum rmap_interpolation kind;
        double order[2]; /* of value and gradient, at least */
    } wanted[] = {{RMAP_TRILINEAR, {1.9, 1.8}}, {RMAP_TRICUBIC, {2.8, 1.9}}};
    double cubic[2], straight[2];
    for (int i = 0; i < 2; i++) {
        double coarse[2], fine[2];
        errors(wanted[i].kind, 16, coarse);
        errors(wanted[i].kind, 32, fine);
        for (int k = 0; k < 2; k++)
            assert_true(log2(coarse[k] / fine[k]) > wanted[i].order[k]);
    }
    errors(RMAP_TRICUBIC, 24, cubic);
    errors(RMAP_TRILINEAR, 24, straight);
    assert_true(cubic[0] < 0.1 * straight[0] && cubic[1] < straight[1]);
}

/* The cubic's gradient is the slope of its value, also across the faces of its cells. */
static void test_cubic_slopes(void **state)
{
    (void)state;
    const size_t n[3] = {9, 9, 9};
    struct rmap_field *field = field_of_grid(grid_of(n, wave), RMAP_TRICUBIC, (double)NAN);
    for (uint64_t i = 0; i < 300; i++)
        assert_slope(field, rmap_scale(inside(i), 0.99), 1e-4, 1e-5);
    rmap_field_destroy(field);
}

static void test_grid_edges_and_holes(void **state)
{
    (void)state;
    const size_t n[3] = {9, 9, 9};
    struct rmap_grid *grid = grid_of(n, wave);
    grid->value[4 * 81 + 4 * 9 + 4] = (double)NAN; /* at the origin */
    struct rmap_field *field = field_of_grid(rmap_grid_hold(grid), RMAP_TRILINEAR, (double)NAN);
    struct rmap_field *open = field_of_grid(grid, RMAP_TRILINEAR, 1.25);
    double value;
    struct rmap_vec3 slope;
    assert_false(rmap_field_at(field, 0, rmap_vec3(0.1, 0.1, 0.1), &value, &slope));
    assert_true(rmap_field_at(field, 0, rmap_vec3(0.9, 0.9, 0.9), &value, &slope));
    /* A cell further it goes on; then there is nothing, or what the scene says. */
    assert_near(value_at(field, rmap_vec3(1.2, 0.9, 0.9)), wave(rmap_vec3(1.2, 0.9, 0.9)), 0.01);
    assert_false(rmap_field_at(field, 0, rmap_vec3(1.3, 0.9, 0.9), &value, &slope));
    assert_near(value_at(open, rmap_vec3(1.3, 0.9, 0.9)), 1.25, 0);
    assert_false(rmap_field_at(open, 0, rmap_vec3((double)NAN, 0, 0), &value, &slope));
    rmap_field_destroy(field);
    rmap_field_destroy(open);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* ---- formulas ---- */

static enum rmap_status make_formula(const char *text, const char *const slope[3], int n_channel,
                                     struct rmap_field **field, struct rmap_error *err)
{
    static const double nm[3] = {400, 500, 600}, value[] = {0.25};
    static const char *const name[] = {"k"};
    struct rmap_formula formula = {
        .text = text, .n_constant = 1, .constant = name, .constant_value = value, .size = 10};
    for (int i = 0; slope && i < 3; i++)
        formula.slope[i] = slope[i];
    return rmap_field_formula(field, n_channel, nm, &formula, err);
}

static void test_formulas(void **state)
{
    (void)state;
    struct rmap_field *field = NULL, *exact = NULL;
    static const char *const slope[3] = {"-k*x/r", "-k*y/r", "-k*z/r"};
    assert_int_equal(make_formula("3 - k*r", NULL, 3, &field, NULL), RMAP_OK);
    assert_int_equal(make_formula("3 - k*r", slope, 3, &exact, NULL), RMAP_OK);
    assert_int_equal(field->n_channel, 1);
    for (uint64_t i = 0; i < 200; i++) {
        struct rmap_vec3 p = rmap_add(any_place(i, 4), rmap_vec3(4, 0, 0)), a, b;
        double n, m;
        assert_true(rmap_field_at(field, 0, p, &n, &a));
        assert_true(rmap_field_at(exact, 0, p, &m, &b));
        assert_near(n, 3 - 0.25 * rmap_length(p), 1e-15);
        assert_true(n == m);
        assert_near(rmap_length(rmap_sub(a, b)), 0, 1e-11); /* rounding over the difference */
        assert_near(rmap_dot(b, p), -0.25 * rmap_length(p), 1e-13);
    }
    rmap_field_destroy(field);
    rmap_field_destroy(exact);
    assert_int_equal(make_formula("1.5 + 0.01/lambda^2", NULL, 3, &field, NULL), RMAP_OK);
    assert_int_equal(field->n_channel, 3);
    double n;
    struct rmap_vec3 a;
    assert_true(rmap_field_at(field, 1, rmap_vec3(0, 0, 0), &n, &a));
    assert_near(n, 1.54, 1e-15);
    rmap_field_destroy(field);
    /* Not above 0 and not finite are no indices. */
    assert_int_equal(make_formula("x", NULL, 1, &field, NULL), RMAP_OK);
    assert_false(rmap_field_at(field, 0, rmap_vec3(-1, 0, 0), &n, &a));
    assert_true(rmap_field_at(field, 0, rmap_vec3(1, 0, 0), &n, &a));
    rmap_field_destroy(field);
    assert_int_equal(make_formula("1 / (x - 1)", NULL, 1, &field, NULL), RMAP_OK);
    assert_false(rmap_field_at(field, 0, rmap_vec3(1, 0, 0), &n, &a));
    rmap_field_destroy(field);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_formula_mistakes(void **state)
{
    (void)state;
    static const struct {
        const char *text, *told;
    } mistake[] = {{"1 + foo", "foo"},
                   {"(1 + x", "arenthesis"},
                   {"1 +", "end of expression"},
                   {"1, 2", "comma"},
                   {"sin(x, y)", "Too many parameters"}};
    for (size_t i = 0; i < sizeof mistake / sizeof mistake[0]; i++) {
        struct rmap_field *field = NULL;
        struct rmap_error err = {0};
        assert_int_equal(make_formula(mistake[i].text, NULL, 1, &field, &err), RMAP_INPUT);
        if (!strstr(err.text, mistake[i].told))
            fail_msg("'%s': %s", mistake[i].text, err.text);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

/* muparser's messages repeat what they stumble over, in a buffer of 2 KiB. */
static void test_long_formula(void **state)
{
    (void)state;
    char text[8000] = "1.5+.nan";
    for (size_t used = strlen(text); used + 3 < sizeof text; used += 2)
        memcpy(text + used, "+x", 3);
    struct rmap_field *field = NULL;
    struct rmap_error err = {0};
    assert_int_equal(make_formula(text, NULL, 1, &field, &err), RMAP_INPUT);
    assert_int_equal(rmap_alloc_live(), 0);
}

struct crew {
    const struct rmap_field *field;
    double sum;
};

static void *work(void *argument)
{
    struct crew *crew = argument;
    for (uint64_t i = 0; i < 2000; i++)
        crew->sum += value_at(crew->field, any_place(i, 5));
    return NULL;
}

/* More threads than compiled formulas give one answer. */
static void test_formulas_of_threads(void **state)
{
    (void)state;
    enum { N = 12 };
    struct rmap_field *field = NULL;
    struct crew crew[N];
    pthread_t thread[N];
    assert_int_equal(make_formula("3 + sin(x)*cos(y) + 0.1*rho", NULL, 1, &field, NULL), RMAP_OK);
    for (int t = 0; t < N; t++) {
        crew[t] = (struct crew){field, 0};
        assert_int_equal(pthread_create(&thread[t], NULL, work, &crew[t]), 0);
    }
    for (int t = 0; t < N; t++)
        assert_int_equal(pthread_join(thread[t], NULL), 0);
    for (int t = 1; t < N; t++)
        assert_true(crew[t].sum == crew[0].sum);
    rmap_field_destroy(field);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_noise),           cmocka_unit_test(test_noise_mistakes),
        cmocka_unit_test(test_grids_are_exact), cmocka_unit_test(test_grids_converge),
        cmocka_unit_test(test_cubic_slopes),    cmocka_unit_test(test_grid_edges_and_holes),
        cmocka_unit_test(test_formulas),        cmocka_unit_test(test_formula_mistakes),
        cmocka_unit_test(test_long_formula),    cmocka_unit_test(test_formulas_of_threads),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

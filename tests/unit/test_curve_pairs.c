/* SPDX-License-Identifier: MIT
 *
 * The coefficients of the Runge-Kutta-Nystroem pairs meet their order conditions: one for every
 * special Nystroem tree (Hairer, Norsett, Wanner 1993, Solving Ordinary Differential Equations I,
 * sec. II.14).
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gradient/curve_step.h"
#include "near.h"

enum { STAGES = RMAP_CURVE_STAGES + 1, ORDER_MAX = 9, TREES_MAX = 400 };

/* A tree: its derivative of D at the stages, and at theta exactly: exact theta^(order - 1). */
struct tree {
    int order;
    double stage[STAGES], exact;
};

struct forest {
    int stages, n;
    double node[STAGES], coupling[STAGES][STAGES];
    struct tree tree[TREES_MAX];
};

/* Adds the trees that `stem` grows into with branches of `left` in order, none past `last`. */
static void grow(struct forest *forest, const struct tree *stem, int left, int last)
{
    struct tree tree = *stem; /* the rest of its order are factors of t */
    for (int i = 0; i < forest->stages; i++) {
        tree.stage[i] *= pow(forest->node[i], left);
    }
    assert_true(forest->n < TREES_MAX);
    forest->tree[forest->n++] = tree;
    for (int b = last; b >= 0; b--) {
        const struct tree *branch = &forest->tree[b];
        if (branch->order + 1 > left) {
            continue;
        }
        tree = *stem;
        for (int i = 0; i < forest->stages; i++) {
            double sum = 0.0;
            for (int j = 0; j < forest->stages; j++) {
                sum += forest->coupling[i][j] * branch->stage[j];
            }
            tree.stage[i] *= sum;
        }
        tree.exact *= branch->exact / (branch->order * (branch->order + 1));
        grow(forest, &tree, left - branch->order - 1, b);
    }
}

/* All trees up to an order. With a stage more, if wanted, at theta 1/2 of the interpolant. */
static void plant(struct forest *forest, const struct rmap_curve_pair *pair, bool middle)
{
    *forest = (struct forest){.stages = pair->stages + (middle ? 1 : 0)};
    for (int i = 0; i < pair->stages; i++) {
        forest->node[i] = pair->node[i];
        for (int j = 0; j < i; j++) {
            forest->coupling[i][j] = pair->coupling[i][j];
        }
    }
    if (middle) {
        forest->node[pair->stages] = 0.5;
        for (int j = 0; j < pair->stages; j++) {
            for (int k = 0; k < RMAP_CURVE_POWERS; k++) {
                forest->coupling[pair->stages][j] += pair->dense[k][j] * pow(0.5, k + 2);
            }
        }
    }
    for (int order = 1; order <= ORDER_MAX; order++) {
        struct tree stem = {.order = order, .exact = 1.0};
        for (int i = 0; i < forest->stages; i++) {
            stem.stage[i] = 1.0;
        }
        grow(forest, &stem, order - 1, forest->n - 1);
    }
}

/* Greatest residual of weights on the trees of an order; share: of what exactly belongs there. */
static double residual(const struct forest *forest, const double *weight, int order, double share)
{
    double worst = 0.0;
    for (int t = 0; t < forest->n; t++) {
        const struct tree *tree = &forest->tree[t];
        if (tree->order == order) {
            double sum = -share * tree->exact;
            for (int i = 0; i < forest->stages; i++) {
                sum += weight[i] * tree->stage[i];
            }
            worst = fmax(worst, fabs(sum));
        }
    }
    return worst;
}

static void pair_has_order(const struct rmap_curve_pair *pair, int p)
{
    struct forest forest;
    double weight_r[STAGES] = {0};
    plant(&forest, pair, false);
    for (int i = 0; i < pair->stages - 1; i++) {
        weight_r[i] = pair->coupling[pair->stages - 1][i];
    }
    for (int order = 1; order <= p; order++) {
        double of_T = 1.0 / order;
        double of_r = of_T / (order + 1);
        assert_near(residual(&forest, pair->weight_T, order, of_T), 0.0, 1e-14);
        if (order < p) {
            assert_near(residual(&forest, weight_r, order, of_r), 0.0, 1e-14);
        }
        if (order <= p - 2) {
            assert_near(residual(&forest, pair->defect_T, order, 0.0), 0.0, 1e-14);
        }
        if (order <= p - 3) {
            assert_near(residual(&forest, pair->defect_r, order, 0.0), 0.0, 1e-14);
        }
        if (order <= p - 4) {
            assert_near(residual(&forest, pair->rough, order, 0.0), 0.0, 1e-14);
        }
        if (order <= p - 6) {
            assert_near(residual(&forest, pair->rougher, order, 0.0), 0.0, 1e-14);
        }
    }
    assert_true(residual(&forest, pair->weight_T, p + 1, 1.0 / (p + 1)) > 1e-7);
    assert_true(residual(&forest, pair->defect_T, p - 1, 0.0) > 1e-5);
    assert_true(residual(&forest, pair->rough, p - 3, 0.0) > 1e-4);
}

static void pairs_have_their_orders(void **state)
{
    (void)state;
    pair_has_order(&rmap_curve_pair_6, 6);
    pair_has_order(&rmap_curve_pair_8, 8);
}

/* Weights of r and of T at theta, from coefficients of its powers. */
static void weights_at(double theta, int n, int powers, const double *coefficient, double *of_r,
                       double *of_T)
{
    for (int i = 0; i < n; i++) {
        of_r[i] = of_T[i] = 0.0;
        for (int k = 0; k < powers; k++) {
            of_r[i] += coefficient[k * n + i] * pow(theta, k + 2);
            of_T[i] += coefficient[k * n + i] * (k + 2) * pow(theta, k + 1);
        }
    }
}

static void dense_output_has_order(const struct rmap_curve_pair *pair, int order, double within_r,
                                   double within_T)
{
    struct forest forest;
    double of_r[STAGES] = {0};
    double of_T[STAGES] = {0};
    plant(&forest, pair, false);
    for (double theta = 0.1; theta < 1.05; theta += 0.1) {
        double exact = pow(theta, order) / order;
        weights_at(theta, RMAP_CURVE_STAGES, RMAP_CURVE_POWERS, &pair->dense[0][0], of_r, of_T);
        assert_near(residual(&forest, of_r, order, exact * theta / (order + 1)), 0.0, within_r);
        assert_near(residual(&forest, of_T, order, exact), 0.0, within_T);
    }
    for (int i = 0; i < pair->stages - 1; i++) {
        assert_near(of_r[i], pair->coupling[pair->stages - 1][i], 1e-13);
        assert_near(of_T[i], pair->weight_T[i], 1e-12);
    }
}

static void dense_outputs_have_their_orders(void **state)
{
    (void)state;
    for (int order = 1; order <= 5; order++) {
        dense_output_has_order(&rmap_curve_pair_6, order, 1e-14, 1e-13);
        dense_output_has_order(&rmap_curve_pair_8, order, 1e-13, 1e-12);
    }
    dense_output_has_order(&rmap_curve_pair_8, 6, 2e-9, 2e-8);
}

static void finer_output_has_its_order(void **state)
{
    static const double within[] = {0, 1e-12, 1e-12, 1e-12, 1e-12, 1e-12, 2e-8, 2e-6};
    (void)state;
    const struct rmap_curve_pair *pair = &rmap_curve_pair_8;
    struct forest forest;
    double of_r[STAGES];
    double of_T[STAGES];
    plant(&forest, pair, true);
    for (double theta = 0.1; theta < 1.05; theta += 0.1) {
        weights_at(theta, STAGES, RMAP_CURVE_POWERS + 1, &pair->finer[0][0], of_r, of_T);
        for (int order = 1; order <= 7; order++) {
            double exact = pow(theta, order) / order;
            assert_near(residual(&forest, of_T, order, exact), 0.0, within[order]);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(pairs_have_their_orders),
        cmocka_unit_test(dense_outputs_have_their_orders),
        cmocka_unit_test(finer_output_has_its_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

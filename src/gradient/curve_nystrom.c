/* SPDX-License-Identifier: MIT
 *
 * Runge-Kutta-Nystroem triple RKN6(4)6FD: order 6 for r and T, embedded order 4, free interpolant
 * of order 6, five evaluations a step as the last stage is the next step's first (Dormand, Prince
 * 1987, "Runge-Kutta-Nystrom triples", Comput. Math. Applic. 13, 937,
 * doi:10.1016/0898-1221(87)90066-8). The second stage has no weight in the result. A unit test
 * checks the order conditions.
 *
 * The integrals of n^2 and of n take the weights of T: for them they are components of T' that do
 * not act back, so the order is the same and n is known at every stage.
 */
#include "gradient/curve_internal.h"

enum { STAGES = 6, DEGREE = 5 };

static const double node[STAGES] = {
    0.0, 0.129295903136704415289, 0.258591806273408830578, 0.6702970826154800583109, 0.9, 1.0,
};

static const double coupling[STAGES][STAGES - 1] = {
    {0},
    {0.008358715283968025328221},
    {0.01114495371195736710429, 0.02228990742391473420859},
    {0.1454747428010917858959, -0.2298606405226474731203, 0.3090349872029675365287},
    {-0.2076682629507899543351, 0.6863667842925143122736, -0.1995492778723492522013,
     0.1258507565306248942629},
    {0.07811016144349477682811, 0.0, 0.2882917411897667776842, 0.1224255371745704101824,
     0.01117256019216803530529},
};

static const double weight_T[STAGES] = {
    0.07811016144349477682811, 0.0,  0.388843478705982602716, 0.371320757928842267403,
    0.1117256019216803530529,  0.05,
};

/* Order 6 less order 4. */
static const double defect_r[STAGES] = {
    -0.9807490989269235013919, 2.406751371924452053192,   -1.559600370364266997288,
    0.1224255371745704101824,  0.01117256019216803530529, 0.0,
};
static const double defect_T[STAGES] = {
    0.0235042735042735042735,  0.0,  -0.07242330719764424157873, 0.1754398984495296111112,
    -0.2765208647561588738059, 0.15,
};

/* r(theta) = r + theta h T + (theta h)^2 sum over the stages of D times a polynomial of theta, the
 * powers from 0. T(theta) is its derivative. */
static const double dense[STAGES][DEGREE] = {
    {0.5, -1.2450142450142450142, 1.5161443494776828110, -0.90669515669515669516,
     0.21367521367521367521},
    {0},
    {0.0, 1.9859371988705031985, -3.5776528722949209438, 2.5384011164109503556,
     -0.65839370179676583254},
    {0.0, -1.8559358276926614325, 5.5475867510523291130, -5.1641335539080937350,
     1.5949081677229964647},
    {0.0, 2.1786492374727668845, -6.9269873191441818893, 7.2733366851013909837,
     -2.5138260432378079437},
    {0.0, -1.0636363636363636364, 3.4409090909090909091, -3.7409090909090909091,
     1.3636363636363636364},
};

static struct rmap_vec3 combine(const double *weight, const struct rmap_vec3 *D, int count)
{
    struct rmap_vec3 sum = {0};
    for (int i = 0; i < count; i++) {
        sum = rmap_axpy(weight[i], D[i], sum);
    }
    return sum;
}

bool rmap_curve_nystrom(struct rmap_curve *curve, struct rmap_curve_step *step, double h)
{
    const struct rmap_curve_state *from = &step->from;
    struct rmap_curve_state at;
    step->h = step->whole = h;
    step->n_stage = STAGES;
    step->D[0] = from->D;
    step->n[0] = from->n;
    for (int i = 1; i < STAGES; i++) {
        struct rmap_vec3 bend = combine(coupling[i], step->D, i);
        at.r = rmap_axpy(h * h, bend, rmap_axpy(node[i] * h, from->T, from->r));
        if (!rmap_curve_evaluate(curve, &at)) {
            return false;
        }
        step->D[i] = at.D;
        step->n[i] = at.n;
    }
    at.T = rmap_axpy(h, combine(weight_T, step->D, STAGES), from->T);
    step->to = at;
    step->optical = step->length = 0.0;
    for (int i = 0; i < STAGES; i++) {
        step->optical += h * weight_T[i] * step->n[i] * step->n[i];
        step->length += h * weight_T[i] * step->n[i];
    }
    return true;
}

double rmap_curve_nystrom_error(const struct rmap_curve *curve, struct rmap_curve_step *step)
{
    const struct rmap_gradient *gradient = curve->gradient;
    double tolerance = gradient->options.tolerance;
    double h = step->h;
    double place = h * h * rmap_length(combine(defect_r, step->D, STAGES));
    double turn = h * rmap_length(combine(defect_T, step->D, STAGES)) / step->to.n;
    step->error = place;
    return fmax(place, turn * gradient->size) / tolerance;
}

/* Weights of r and of T at theta; (theta h)^2 and theta h belong to them. */
static void weights(double theta, double *of_r, double *of_T)
{
    for (int i = 0; i < STAGES; i++) {
        double r = 0.0;
        double T = 0.0;
        for (int k = DEGREE - 1; k >= 0; k--) {
            r = r * theta + dense[i][k];
            T = T * theta + (k + 2) * dense[i][k];
        }
        of_r[i] = r;
        of_T[i] = T;
    }
}

void rmap_curve_nystrom_at(const struct rmap_curve_step *step, double theta, struct rmap_vec3 *r,
                           struct rmap_vec3 *T)
{
    double of_r[STAGES];
    double of_T[STAGES];
    double t = theta * step->h;
    weights(t / step->whole, of_r, of_T);
    *r = rmap_axpy(t * t, combine(of_r, step->D, STAGES), rmap_axpy(t, step->from.T, step->from.r));
    *T = rmap_axpy(t, combine(of_T, step->D, STAGES), step->from.T);
}

void rmap_curve_nystrom_lengths(const struct rmap_curve_step *step, double theta, double *optical,
                                double *length)
{
    double of_r[STAGES];
    double of_T[STAGES];
    double t = theta * step->h;
    weights(t / step->whole, of_r, of_T);
    *optical = *length = 0.0;
    for (int i = 0; i < STAGES; i++) {
        *optical += t * of_T[i] * step->n[i] * step->n[i];
        *length += t * of_T[i] * step->n[i];
    }
}

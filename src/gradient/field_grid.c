/* SPDX-License-Identifier: MIT
 *
 * A field given at the nodes of a grid.
 */
#include "gradient/field_grid.h"

#include "base/alloc.h"
#include "gradient/field_internal.h"

enum { WINDOW = 4 };

struct gridded {
    struct rmap_field field;
    struct rmap_grid *grid; /* held */
    enum rmap_interpolation interpolation;
    double outside;
};

/* Along one axis: a window of nodes that take part, with their weights in the value and, in units
 * of the axis, in its slope. */
struct along {
    size_t first, n;
    double value[WINDOW], slope[WINDOW];
    double beyond; /* how far outside of the grid, in cells */
};

/* weight += factor * (difference of the values about a node): central, and at the ends the
 * one-sided one that is of second order too. */
static void add_difference(double *weight, size_t node, size_t n, double factor)
{
    if (n == 2) {
        weight[0] -= factor;
        weight[1] += factor;
    } else if (node == 0 || node == n - 1) {
        ptrdiff_t inward = node ? -1 : 1;
        double sign = node ? -0.5 : 0.5;
        weight[node] -= 3 * sign * factor;
        weight[(ptrdiff_t)node + inward] += 4 * sign * factor;
        weight[(ptrdiff_t)node + 2 * inward] -= sign * factor;
    } else {
        weight[node - 1] -= 0.5 * factor;
        weight[node + 1] += 0.5 * factor;
    }
}

static void weigh_linear(struct along *a, size_t node, size_t n, double t)
{
    a->value[node] = 1 - t;
    a->value[node + 1] = t;
    add_difference(a->slope, node, n, 1 - t);
    add_difference(a->slope, node + 1, n, t);
}

/* Hermite's cubic between the two nodes, with the differences as slopes. */
static void weigh_cubic(struct along *a, size_t node, size_t n, double t)
{
    double s = 1 - t;
    a->value[node] = s * s * (1 + 2 * t);
    a->value[node + 1] = t * t * (1 + 2 * s);
    add_difference(a->value, node, n, t * s * s);
    add_difference(a->value, node + 1, n, -t * t * s);
    a->slope[node] = -6 * t * s;
    a->slope[node + 1] = 6 * t * s;
    add_difference(a->slope, node, n, s * (1 - 3 * t));
    add_difference(a->slope, node + 1, n, t * (3 * t - 2));
}

/* False: more than a cell outside. */
static bool find_along(double u, size_t n, enum rmap_interpolation interpolation, struct along *a)
{
    double last = (double)(n - 1), inside = fmin(fmax(u, 0), last);
    *a = (struct along){.beyond = u - inside};
    if (!(fabs(a->beyond) <= 1))
        return false;
    size_t cell = (size_t)fmin(floor(inside), last - 1);
    double t = inside - (double)cell;
    a->n = n < WINDOW ? n : WINDOW;
    a->first = cell > 0 ? cell - 1 : 0;
    if (a->first + a->n > n)
        a->first = n - a->n;
    /* The window looks like a whole grid to differences at the ends: these are taken at its ends
     * only where they are the grid's. */
    if (interpolation == RMAP_TRICUBIC)
        weigh_cubic(a, cell - a->first, a->n, t);
    else
        weigh_linear(a, cell - a->first, a->n, t);
    return true;
}

/* Sums over the window. False where a hole takes part. */
static bool add_up(const struct rmap_grid *grid, const struct along a[3], double sum[4])
{
    for (size_t i = 0; i < a[0].n; i++) {
        for (size_t j = 0; j < a[1].n; j++) {
            const double vv = a[0].value[i] * a[1].value[j], sv = a[0].slope[i] * a[1].value[j];
            const double vs = a[0].value[i] * a[1].slope[j];
            if (vv == 0 && sv == 0 && vs == 0)
                continue;
            const double *row = grid->value +
                                ((a[0].first + i) * grid->n[1] + a[1].first + j) * grid->n[2] +
                                a[2].first;
            for (size_t k = 0; k < a[2].n; k++) {
                const double w = a[2].value[k],
                             factor[4] = {vv * w, sv * w, vs * w, vv * a[2].slope[k]};
                if (factor[0] == 0 && factor[1] == 0 && factor[2] == 0 && factor[3] == 0)
                    continue;
                for (int m = 0; m < 4; m++)
                    sum[m] += factor[m] * row[k];
            }
        }
    }
    return isfinite(sum[0] + sum[1] + sum[2] + sum[3]);
}

static bool at(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
               struct rmap_vec3 *gradient)
{
    const struct gridded *g = (const struct gridded *)field;
    const struct rmap_grid *grid = g->grid;
    const struct rmap_vec3 from = rmap_sub(p, grid->origin), h = grid->spacing;
    const double u[3] = {from.x / h.x, from.y / h.y, from.z / h.z};
    double sum[4] = {0};
    struct along a[3];
    (void)channel;
    for (int axis = 0; axis < 3; axis++) {
        if (find_along(u[axis], grid->n[axis], g->interpolation, &a[axis]))
            continue;
        *n = g->outside;
        *gradient = rmap_vec3(0, 0, 0);
        return isfinite(g->outside) && isfinite(rmap_dot(p, p));
    }
    if (!add_up(grid, a, sum))
        return false;
    *n = sum[0] + a[0].beyond * sum[1] + a[1].beyond * sum[2] + a[2].beyond * sum[3];
    *gradient = rmap_vec3(sum[1] / h.x, sum[2] / h.y, sum[3] / h.z);
    return true;
}

static double best_step(const struct rmap_field *field, struct rmap_vec3 p,
                        struct rmap_vec3 direction)
{
    const struct rmap_vec3 h = ((const struct gridded *)field)->grid->spacing;
    (void)p;
    (void)direction;
    return fmin(h.x, fmin(h.y, h.z));
}

static void destroy(struct rmap_field *field)
{
    rmap_grid_drop(((struct gridded *)field)->grid);
    rmap_free(field);
}

static const struct rmap_field_ops ops = {
    .model = "grid", .at = at, .best_step = best_step, .destroy = destroy};

enum rmap_status rmap_field_grid(struct rmap_field **field_ret, struct rmap_grid *grid,
                                 enum rmap_interpolation interpolation, double outside,
                                 struct rmap_error *err)
{
    struct gridded *g = (struct gridded *)rmap_field_new(sizeof *g, &ops, 1, err);
    if (!g)
        return RMAP_SYSTEM;
    g->grid = rmap_grid_hold(grid);
    g->interpolation = interpolation;
    g->outside = outside;
    g->field.step = 0.1 * best_step(&g->field, grid->origin, grid->origin);
    g->field.may_be_missing = true;
    *field_ret = &g->field;
    return RMAP_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * Index fields: the refractive index of a gradient medium as a function of place, in the medium's
 * own frame. One small module per model (field_*.c); a new one needs the operations below and a
 * line in the scene reader.
 *
 * Everything is immutable once it is made, thread-safe, and the same bits on every rank.
 */
#ifndef RMAP_FIELD_H
#define RMAP_FIELD_H

#include <stdbool.h>

#include "base/status.h"
#include "base/vec.h"

struct rmap_field;

struct rmap_field_ops {
    const char *model; /* "luneburg", for messages */

    /* Index and its gradient (per length unit of the frame) on a channel. False where the field has
     * no value: outside a grid, beyond a pole. That an index is finite and > 0 is checked by
     * rmap_field_at: the same field may stand for a temperature (rmap_field_scalar). */
    bool (*at)(const struct rmap_field *field, int channel, struct rmap_vec3 p, double *n,
               struct rmap_vec3 *gradient);

    /* Laplacian of n; NULL: central differences of the gradient. */
    bool (*laplacian)(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                      double *laplacian);

    /* Length over which the field may be taken for a polynomial, from a point in a direction
     * (unit): the integrator's first guess of a step, never its accuracy. INFINITY: uniform. NULL:
     * the size of what the medium fills. */
    double (*best_step)(const struct rmap_field *field, struct rmap_vec3 p,
                        struct rmap_vec3 direction);

    void (*destroy)(struct rmap_field *field);

    /* Where n^2 is a polynomial of second degree all over space, rays have a closed form: sets half
     * its second derivatives, A, so that n grad n grows by A (p' - p). False, or NULL: it is none.
     */
    bool (*quadratic)(const struct rmap_field *field, int channel, double bend[3][3]);
};

/* First member of every model's own structure. */
struct rmap_field {
    const struct rmap_field_ops *ops;
    int n_channel;       /* channels that differ: 1 without dispersion, else the scene's */
    double step;         /* of central differences, where the model has no gradient of its own */
    bool may_be_missing; /* `at` can be false inside the medium: checked when the scene is read */
};

/* Any finite value: a temperature, a salinity. */
static inline bool rmap_field_scalar(const struct rmap_field *field, int channel,
                                     struct rmap_vec3 p, double *value, struct rmap_vec3 *gradient)
{
    return field->ops->at(field, field->n_channel > 1 ? channel : 0, p, value, gradient) &&
           isfinite(*value) && isfinite(rmap_dot(*gradient, *gradient));
}

/* An index: finite and > 0. */
static inline bool rmap_field_at(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                                 double *n, struct rmap_vec3 *gradient)
{
    return rmap_field_scalar(field, channel, p, n, gradient) && *n > 0.0;
}

bool rmap_field_quadratic(const struct rmap_field *field, int channel, double bend[3][3]);

bool rmap_field_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                          double *laplacian);

/* Central differences of a scalar: gradient with error O(step^2). value: false where undefined. */
typedef bool rmap_field_value(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                              double *n);
bool rmap_field_differences(const struct rmap_field *field, rmap_field_value *value, int channel,
                            struct rmap_vec3 p, double *n, struct rmap_vec3 *gradient);

void rmap_field_destroy(struct rmap_field *field); /* NULL is fine */

#endif

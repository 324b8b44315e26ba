/* SPDX-License-Identifier: MIT
 *
 * Index fields: the refractive index of a gradient medium as a function of place, in the medium's
 * own frame.
 */
#include "gradient/field.h"

#include "base/alloc.h"
#include "gradient/field_internal.h"

/* Differences of a gradient with this step, relative to the place's own size, lose half the digits
 * to rounding and half to the cubic term. */
#define STEP_RELATIVE 6e-6

static double difference_step(const struct rmap_field *field, struct rmap_vec3 p)
{
    if (field->step > 0.0)
        return field->step;
    return STEP_RELATIVE * fmax(1.0, rmap_length(p));
}

static struct rmap_vec3 moved(struct rmap_vec3 p, int axis, double by)
{
    double *x[3] = {&p.x, &p.y, &p.z};
    *x[axis] += by;
    return p;
}

bool rmap_field_quadratic(const struct rmap_field *field, int channel, double bend[3][3])
{
    return field->ops->quadratic &&
           field->ops->quadratic(field, field->n_channel > 1 ? channel : 0, bend);
}

bool rmap_field_laplacian(const struct rmap_field *field, int channel, struct rmap_vec3 p,
                          double *laplacian)
{
    channel = field->n_channel > 1 ? channel : 0;
    if (field->ops->laplacian)
        return field->ops->laplacian(field, channel, p, laplacian);
    double step = difference_step(field, p), sum = 0.0;
    for (int axis = 0; axis < 3; axis++) {
        double n;
        struct rmap_vec3 above, below;
        if (!rmap_field_scalar(field, channel, moved(p, axis, step), &n, &above) ||
            !rmap_field_scalar(field, channel, moved(p, axis, -step), &n, &below))
            return false;
        struct rmap_vec3 change = rmap_sub(above, below);
        sum += axis == 0 ? change.x : axis == 1 ? change.y : change.z;
    }
    *laplacian = sum / (2.0 * step);
    return isfinite(*laplacian);
}

bool rmap_field_differences(const struct rmap_field *field, rmap_field_value *value, int channel,
                            struct rmap_vec3 p, double *n, struct rmap_vec3 *gradient)
{
    double step = difference_step(field, p), slope[3];
    if (!value(field, channel, p, n))
        return false;
    for (int axis = 0; axis < 3; axis++) {
        double above, below;
        if (!value(field, channel, moved(p, axis, step), &above) ||
            !value(field, channel, moved(p, axis, -step), &below))
            return false;
        slope[axis] = (above - below) / (2.0 * step);
    }
    *gradient = rmap_vec3(slope[0], slope[1], slope[2]);
    return true;
}

void rmap_field_destroy(struct rmap_field *field)
{
    if (!field)
        return;
    if (field->ops->destroy)
        field->ops->destroy(field);
    else
        rmap_free(field);
}

struct rmap_field *rmap_field_new(size_t size, const struct rmap_field_ops *ops, int n_channel,
                                  struct rmap_error *err)
{
    struct rmap_field *field = rmap_alloc(1, size);
    if (!field) {
        (void)rmap_error_set(err, RMAP_SYSTEM, "no memory for a gradient medium of %zu bytes",
                             size);
        return NULL;
    }
    field->ops = ops;
    field->n_channel = n_channel;
    return field;
}

enum rmap_status rmap_parameter_check(const char *model, const struct rmap_parameter *parameter,
                                      double value, struct rmap_error *err)
{
    static const char *const wanted[] = {"a finite number", "a number > 0", "a number other than 0",
                                         "a number >= 0"};
    bool good = isfinite(value);
    switch (parameter->need) {
    case RMAP_NEED_FINITE:
        break;
    case RMAP_NEED_POSITIVE:
        good = good && value > 0.0;
        break;
    case RMAP_NEED_NOT_ZERO:
        good = good && value != 0.0;
        break;
    case RMAP_NEED_NOT_NEGATIVE:
        good = good && value >= 0.0;
        break;
    }
    if (good)
        return RMAP_OK;
    return rmap_error_set(err, RMAP_INPUT, "%s: %s is %g; give %s", model, parameter->name, value,
                          wanted[parameter->need]);
}

double rmap_field_step_guess(double n, struct rmap_vec3 gradient, double laplacian)
{
    double bend = fabs(laplacian) + rmap_dot(gradient, gradient) / n;
    return bend > 0.0 ? 0.5 * sqrt(n / bend) : (double)INFINITY;
}

double rmap_field_best_step(const struct rmap_field *field, struct rmap_vec3 p,
                            struct rmap_vec3 direction)
{
    (void)direction;
    double n, laplacian;
    struct rmap_vec3 gradient;
    if (!rmap_field_at(field, 0, p, &n, &gradient) ||
        !rmap_field_laplacian(field, 0, p, &laplacian))
        return (double)INFINITY;
    return rmap_field_step_guess(n, gradient, laplacian);
}

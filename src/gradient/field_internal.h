/* SPDX-License-Identifier: MIT
 *
 * What the makers of fields share: checked parameters, and fields of one coordinate.
 *
 * Most models are a function of s = z, x^2 + y^2 or x^2 + y^2 + z^2 alone. Such a model gives the
 * jet q, dq/ds, d2q/ds2 of q = n or n^2; index, gradient, Laplacian and step follow here for all.
 */
#ifndef RMAP_FIELD_INTERNAL_H
#define RMAP_FIELD_INTERNAL_H

#include <stddef.h>

#include "gradient/field_polynomial.h"
#include "gradient/models.h"

enum rmap_need { RMAP_NEED_FINITE, RMAP_NEED_POSITIVE, RMAP_NEED_NOT_ZERO, RMAP_NEED_NOT_NEGATIVE };

struct rmap_parameter {
    const char *name;
    enum rmap_need need;
};

#define RMAP_JET_PARAMETER_MAX 4

/* parameter: what the model keeps per channel. False where there is no value. */
typedef bool rmap_jet(const double *parameter, int n_parameter, double s, double jet[3]);

struct rmap_jet_model {
    const char *model;
    enum rmap_series_variable s;
    enum rmap_series_of q;
    rmap_jet *jet;
    bool may_be_missing;
    int n_parameter; /* as given */
    struct rmap_parameter parameter[RMAP_JET_PARAMETER_MAX];
    /* From what is given to what is kept, RMAP_JET_PARAMETER_MAX numbers at most; NULL: the same.
     */
    void (*prepare)(const double *given, double *kept);
    int n_kept;
};

/* RMAP_INPUT with the parameter's name when it is not what it needs to be. */
enum rmap_status rmap_parameter_check(const char *model, const struct rmap_parameter *parameter,
                                      double value, struct rmap_error *err) RMAP_MUST_USE;

/* A field of `size` bytes, zeroed, whose first member is set up; NULL with *err when memory is
 * short. */
struct rmap_field *rmap_field_new(size_t size, const struct rmap_field_ops *ops, int n_channel,
                                  struct rmap_error *err);

/* parameter: [n_channel][model->n_parameter]. `model` must outlive the field. */
enum rmap_status rmap_field_of_model(struct rmap_field **field_ret,
                                     const struct rmap_jet_model *model, int n_channel,
                                     const void *parameter, struct rmap_error *err) RMAP_MUST_USE;

/* As above with the numbers that the jet uses, unchecked: [n_channel][n_kept]. */
enum rmap_status rmap_field_of_jet(struct rmap_field **field_ret,
                                   const struct rmap_jet_model *model, int n_channel, int n_kept,
                                   const double *kept, struct rmap_error *err) RMAP_MUST_USE;

/* The jet in s = r^2 (or rho^2) of a function f of r: f, df/dr, d2f/dr2. r > 0. */
void rmap_jet_of_radius(double r, const double f[3], double jet[3]);

/* q = sum of parameter[i] s^i */
bool rmap_jet_series(const double *parameter, int n_parameter, double s, double jet[3]);

/* Half the length over which light in such a field would turn round: sqrt(n / n''). */
double rmap_field_step_guess(double n, struct rmap_vec3 gradient, double laplacian);

/* best_step of any field that has a Laplacian. */
double rmap_field_best_step(const struct rmap_field *field, struct rmap_vec3 p,
                            struct rmap_vec3 direction);

#endif

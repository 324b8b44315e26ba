/* SPDX-License-Identifier: MIT
 *
 * A plug-in for Raymap: a rod whose gradient weakens along its axis,
 *     n^2 = n0^2 (1 - alpha(z)^2 (x^2 + y^2)),   alpha(z)^2 = alpha0^2 / (1 + z / length).
 * parameters: [n0, alpha0, length]. Build it beside the scene:
 *     cc -std=c17 -O2 -fPIC -shared -o rod.so rod.c -lm
 */
#include "raymap_field.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

struct rod {
    double n0, alpha2, length;
};

static int create(const struct raymap_field_setup *setup, void **state_ret, char *text,
                  size_t text_nbytes)
{
    if (setup->n_parameter != 3 || !(setup->parameter[0] > 0) || !(setup->parameter[2] > 0)) {
        snprintf(text, text_nbytes, "give [n0, alpha0, length], n0 and length greater than 0");
        return 1;
    }
    struct rod *rod = malloc(sizeof *rod);
    if (!rod)
        return 1;
    rod->n0 = setup->parameter[0];
    rod->alpha2 = setup->parameter[1] * setup->parameter[1];
    rod->length = setup->parameter[2];
    *state_ret = rod;
    return 0;
}

static int at(const void *state, size_t channel, const double p[3], double *n, double gradient[3])
{
    const struct rod *rod = state;
    (void)channel;
    double stretch = 1 + p[2] / rod->length, rho2 = p[0] * p[0] + p[1] * p[1];
    double alpha2 = rod->alpha2 / stretch, n2 = rod->n0 * rod->n0 * (1 - alpha2 * rho2);
    if (!(stretch > 0) || !(n2 > 0))
        return 1;
    *n = sqrt(n2);
    /* n dn/dx = 1/2 d(n^2)/dx */
    double half = rod->n0 * rod->n0 * alpha2 / *n;
    gradient[0] = -half * p[0];
    gradient[1] = -half * p[1];
    gradient[2] = 0.5 * half * rho2 / (rod->length * stretch);
    return 0;
}

static const struct raymap_field field = {
    .abi = RAYMAP_FIELD_ABI,
    .nbytes = sizeof(struct raymap_field),
    .name = "rod whose gradient weakens along its axis",
    .create = create,
    .at = at,
    .destroy = free,
};

const struct raymap_field *raymap_field(void)
{
    return &field;
}

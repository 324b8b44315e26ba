/* SPDX-License-Identifier: MIT
 *
 * A plug-in without a state and without a gradient of its own: n = 1.5 + 0.01 x + channel / 10.
 */
#include "gradient/raymap_field.h"

static int at(const void *state, size_t channel, const double p[3], double *n, double gradient[3])
{
    (void)state;
    (void)gradient;
    *n = 1.5 + 0.01 * p[0] + 0.1 * (double)channel;
    return 0;
}

const struct raymap_field *raymap_field(void)
{
    static const struct raymap_field field = {.abi = RAYMAP_FIELD_ABI,
                                              .nbytes = sizeof(struct raymap_field),
                                              .flags = RAYMAP_FIELD_DISPERSIVE |
                                                       RAYMAP_FIELD_NO_GRADIENT,
                                              .name = "plain",
                                              .at = at};
    return &field;
}

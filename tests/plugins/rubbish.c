/* SPDX-License-Identifier: MIT
 *
 * A plug-in that misbehaves: beyond x = 0 its index is not a number, beyond y = 0 its gradient, and
 * beyond z = 0 it says that it has none.
 */
#include <math.h>

#include "gradient/raymap_field.h"

static int at(const void *state, size_t channel, const double p[3], double *n, double gradient[3])
{
    (void)state;
    (void)channel;
    *n = p[0] > 0 ? (double)NAN : 1.5;
    gradient[0] = gradient[2] = 0;
    gradient[1] = p[1] > 0 ? (double)INFINITY : 0.01;
    return p[2] > 0;
}

const struct raymap_field *raymap_field(void)
{
    static const struct raymap_field field = {.abi = RAYMAP_FIELD_ABI,
                                              .nbytes = sizeof(struct raymap_field),
                                              .name = "rubbish",
                                              .at = at};
    return &field;
}

/* SPDX-License-Identifier: MIT */
#include "gradient/gradient.h"

bool rmap_gradient_at(const struct rmap_gradient *gradient, int channel, struct rmap_vec3 p,
                      double *n, struct rmap_vec3 *slope)
{
    struct rmap_vec3 local;
    if (!rmap_field_at(gradient->field, channel, rmap_affine_point(&gradient->to_local, p), n,
                       &local))
        return false;
    *slope = rmap_affine_transposed(&gradient->to_local, local);
    return true;
}

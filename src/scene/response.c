/* SPDX-License-Identifier: MIT
 *
 * What a detector makes of the light that it registers.
 */
#include "scene/response.h"

#include <math.h>

#include "base/alloc.h"

struct rmap_response *rmap_response_create(size_t n_angle, int n_channel)
{
    struct rmap_response *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return NULL;
    self->n_angle = n_angle;
    self->n_channel = n_channel;
    self->angle_deg = rmap_alloc(n_angle, sizeof *self->angle_deg);
    self->value = rmap_alloc(n_angle * (size_t)n_channel, sizeof *self->value);
    if (self->angle_deg && self->value)
        return self;
    rmap_response_destroy(self);
    return NULL;
}

void rmap_response_destroy(struct rmap_response *self)
{
    if (!self)
        return;
    rmap_free(self->angle_deg);
    rmap_free(self->value);
    rmap_free(self);
}

static double row_at(const struct rmap_response *self, const uint16_t *share, size_t row)
{
    const double *value = self->value + row * (size_t)self->n_channel;
    double sum = 0.0;
    for (int c = 0; c < self->n_channel; c++)
        sum += share[c] * value[c];
    return sum / 65535.0;
}

double rmap_response_at(const struct rmap_response *self, const uint16_t *share, double angle_deg)
{
    const double *angle = self->angle_deg;
    size_t next = 0;
    while (next < self->n_angle && angle[next] <= angle_deg)
        next++;
    if (next == 0 || next == self->n_angle)
        return row_at(self, share, next == 0 ? 0 : next - 1);
    const double t = (angle_deg - angle[next - 1]) / (angle[next] - angle[next - 1]);
    return (1.0 - t) * row_at(self, share, next - 1) + t * row_at(self, share, next);
}

double rmap_response_most(const struct rmap_response *self)
{
    double most = 0.0;
    for (size_t i = 0; i < self->n_angle * (size_t)self->n_channel; i++)
        most = fmax(most, self->value[i]);
    return most;
}

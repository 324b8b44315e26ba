/* SPDX-License-Identifier: MIT
 *
 * A few spheres before the sieve: a ball needs no frame of its own, and a ray that begins and ends
 * deep inside one does not meet its surface, as most chords of a curve in a gradient sphere do
 * not. Outer radii are wider than the float error and inner ones smaller, so nothing that Embree
 * would propose is lost.
 */
#include <math.h>

#include "accel/accel_internal.h"

enum { WIDE = RMAP_SIEVE_WIDE };

/* In roundings of the longest coordinate, as in accel_sieve.c. */
#define BALL_ERRORS 64

static bool is_ball(const struct rmap_accel_object *object)
{
    return object->shape && object->shape->type == RMAP_SHAPE_SPHERE && object->rigid;
}

static void add_ball(struct rmap_accel *accel, int32_t index, double tolerance)
{
    const struct rmap_accel_object *object = &accel->object[index];
    struct rmap_balls *balls = &accel->balls;
    struct rmap_vec3 at = rmap_sub(object->to_world.t, accel->centre);
    double longest = 2 * (accel->radius + accel->reach) + rmap_length(at);
    double pad = BALL_ERRORS * RMAP_FLOAT_EPS * longest + object->tolerance + tolerance;
    double outer = object->shape->radius + pad, inner = object->shape->radius - pad;
    int k = balls->n++;
    balls->x[k] = (float)at.x;
    balls->y[k] = (float)at.y;
    balls->z[k] = (float)at.z;
    balls->outer2[k] = (float)(outer * outer);
    balls->inner2[k] = inner > 0 ? (float)(inner * inner) : 0;
    balls->object[k] = index;
}

void rmap_balls_build(struct rmap_accel *accel)
{
    struct rmap_balls *balls = &accel->balls;
    double tolerance = 0; /* any surface may be the one that a ray starts from */
    int n = 0;
    for (size_t i = 0; i < accel->n_object; i++) {
        n += is_ball(&accel->object[i]);
        tolerance = rmap_greater(tolerance, accel->object[i].tolerance);
    }
    for (int k = 0; k < WIDE; k++)
        balls->outer2[k] = -1;
    for (size_t i = 0; n <= WIDE && i < accel->n_object; i++)
        if (is_ball(&accel->object[i])) {
            accel->object[i].ball = true;
            add_ball(accel, (int32_t)i, tolerance);
        }
}

/* Bits of the balls whose surface the ray may meet before `far`, and where it enters each. */
RMAP_WIDEST
static uint32_t sift(const struct rmap_balls *balls, const float o[restrict 3],
                     const float d[restrict 3], float far, float near[restrict WIDE])
{
    uint32_t bits = 0;
    for (int k = 0; k < WIDE; k++) {
        float x = balls->x[k] - o[0], y = balls->y[k] - o[1], z = balls->z[k] - o[2];
        float along = x * d[0] + y * d[1] + z * d[2];
        float ax = x - along * d[0], ay = y - along * d[1], az = z - along * d[2];
        float ex = x - far * d[0], ey = y - far * d[1], ez = z - far * d[2];
        float across2 = ax * ax + ay * ay + az * az;
        float half = sqrtf(across2 < balls->outer2[k] ? balls->outer2[k] - across2 : 0);
        int inside = (x * x + y * y + z * z < balls->inner2[k]) &
                     (ex * ex + ey * ey + ez * ez < balls->inner2[k]);
        near[k] = along - half;
        bits |= (across2 <= balls->outer2[k]) & (along + half >= 0) & (near[k] <= far) & !inside
                    ? 1U << k
                    : 0;
    }
    return bits;
}

void rmap_balls_search(struct rmap_query *query, const float origin[3], const float direction[3],
                       double shift)
{
    const struct rmap_balls *balls = &query->accel->balls;
    float near[WIDE];
    uint32_t left = sift(balls, origin, direction, rmap_far_end(query, shift), near);
    while (left) {
        int nearest = -1;
        float far = rmap_far_end(query, shift);
        for (uint32_t rest = left; rest; rest &= rest - 1) {
            int k = __builtin_ctz(rest);
            if (near[k] <= far) {
                far = near[k];
                nearest = k;
            }
        }
        if (nearest < 0)
            return;
        left &= ~(1U << nearest);
        (void)rmap_consider_shape(query, balls->object[nearest]);
    }
}

/* SPDX-License-Identifier: MIT
 *
 * The steps of a segment that both ways of tracing again share: one ray at a time (retrace.c) and
 * many side by side (batch.c).
 */
#ifndef RMAP_COMPACT_STEP_H
#define RMAP_COMPACT_STEP_H

#include "base/rng.h"
#include "compact/model.h"
#include "formula/turn.h"
#include "portion/event.h"
#include "trace/scattering.h"

static inline float rmap_step_float(double x)
{
    return x == x ? (float)x + 0.0f : (float)NAN;
}

static inline double rmap_step_double(double x)
{
    return x == x ? x + 0.0 : (double)NAN;
}

static inline void rmap_step_float3(struct rmap_vec3 v, float out[3])
{
    out[0] = rmap_step_float(v.x);
    out[1] = rmap_step_float(v.y);
    out[2] = rmap_step_float(v.z);
}

static inline int16_t rmap_step_cosine(double x)
{
    double bounded = x > -1.0 ? x < 1.0 ? x : 1.0 : -1.0; /* NaN: -1 */
    double scaled = 32767.0 * bounded;
    return (int16_t)(scaled + (scaled < 0.0 ? -0.5 : 0.5));
}

static inline void rmap_step_normal(struct rmap_vec3 normal, int16_t out[3])
{
    out[0] = rmap_step_cosine(normal.x);
    out[1] = rmap_step_cosine(normal.y);
    out[2] = rmap_step_cosine(normal.z);
}

static inline double rmap_step_distance_out(const struct rmap_scene *scene,
                                            struct rmap_vec3 position, struct rmap_vec3 direction)
{
    struct rmap_vec3 from = rmap_sub(position, scene->centre);
    double along = rmap_dot(from, direction);
    double gap = scene->radius * scene->radius - rmap_dot(from, from);
    if (!(gap > 0.0))
        return 0.0;
    double root = sqrt(along * along + gap);
    return along > 0.0 ? gap / (root + along) : root - along;
}

static inline const struct rmap_medium *rmap_step_medium(const struct rmap_compact_model *model,
                                                         int32_t medium)
{
    bool known = medium >= 0 && (size_t)medium < model->n_medium;
    return known ? &model->scene->medium[medium] : NULL;
}

static inline enum rmap_turn rmap_step_turn(uint32_t event)
{
    if (event & (RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE))
        return RMAP_TURN_DIFFUSE;
    if (event & (RMAP_EVENT_REFLECT_SPECULAR | RMAP_EVENT_TOTAL_REFLECTION))
        return RMAP_TURN_REFLECT;
    return event & RMAP_EVENT_TRANSMIT_SPECULAR ? RMAP_TURN_REFRACT : RMAP_TURN_NONE;
}

/* Events that end a segment inside its medium, as far as they are predicted. */
static inline uint32_t rmap_step_inside(bool turbid)
{
    return RMAP_EVENT_ABSORB |
           (turbid ? (uint32_t)(RMAP_EVENT_SCATTER_VOLUME | RMAP_EVENT_FLUORESCE) : 0);
}

/* What a turn depends on beside direction and normal. */
struct rmap_turning {
    uint64_t seed, ray;
    uint32_t step; /* of the random numbers: the segment's number from 1 */
    uint32_t event;
    const struct rmap_medium *near, *far; /* or NULL */
    int channel;                          /* that refracts */
    const struct rmap_scene *scene;
    int32_t object; /* that is met */
    int32_t primitive;
    bool front; /* on this side */
    struct rmap_vec3 position;
};

/* The side that is met, of a surface with a scatter model for the event. False: it has none; a path
 * may be of any events, and of any media. */
static inline bool rmap_step_side(const struct rmap_turning *turning, struct rmap_vec3 normal,
                                  struct rmap_scatter_side *side)
{
    const struct rmap_object *object = &turning->scene->object[turning->object];
    const struct rmap_medium *near = turning->near, *far = turning->far;
    const bool passes = (turning->event & RMAP_EVENT_TRANSMIT_DIFFUSE) != 0;
    *side = (struct rmap_scatter_side){
        .scene = turning->scene,
        .object = object,
        .front = turning->front,
        .position = turning->position,
        .primitive = turning->primitive,
        .surface =
            &turning->scene->surface[turning->front ? object->surface_front : object->surface_back],
        .channel = turning->channel,
        .normal = normal};
    if (!rmap_surface_scatter(turning->scene, side->surface, passes))
        return false;
    const int32_t beyond = turning->front ? object->medium_back : object->medium_front;
    if (!passes && beyond >= 0)
        far = &turning->scene->medium[beyond];
    side->near = near ? (int32_t)(near - turning->scene->medium) : 0;
    side->far = far ? (int32_t)(far - turning->scene->medium) : side->near;
    side->n1 = near ? near->n[turning->channel] : 1.0;
    side->n2 = far ? far->n[turning->channel] : side->n1;
    rmap_scatter_frame(side);
    return true;
}

/* Cosine at which the light met a facet, > 0; `cosine`: that at the surface, where the event is
 * none of a facet's, or does not depend on it. */
static inline double rmap_step_facet_cosine(const struct rmap_turning *turning, double cosine,
                                            struct rmap_vec3 direction, struct rmap_vec3 normal)
{
    const double least = 1e-300;
    struct rmap_scatter_side side;
    struct rmap_facet facet;
    if (!(turning->event & (RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE)) ||
        !rmap_step_side(turning, normal, &side) || !rmap_scatter_by_facet(&side))
        return cosine;
    const struct rmap_draw draw = {turning->seed, turning->ray, turning->step};
    rmap_facet_meet(&side, direction, &draw, &facet);
    return facet.cos_i > least ? facet.cos_i : least;
}

/* By the scatter model of the side that is met; direction after a diffuse event. */
static inline struct rmap_vec3 rmap_step_scattered(const struct rmap_turning *turning,
                                                   struct rmap_vec3 direction,
                                                   struct rmap_vec3 normal)
{
    const struct rmap_draw draw = {turning->seed, turning->ray, turning->step};
    struct rmap_scatter_side side;
    return rmap_step_side(turning, normal, &side)
               ? rmap_scatter_turned(&side, (turning->event & RMAP_EVENT_TRANSMIT_DIFFUSE) != 0,
                                     direction, &draw)
               : direction;
}

/* Direction after a surface, whose normal points to the light. */
static inline struct rmap_vec3 rmap_step_turned(const struct rmap_turning *turning,
                                                struct rmap_vec3 direction, struct rmap_vec3 normal)
{
    double u[4], total;
    struct rmap_vec3 refracted;
    switch (rmap_step_turn(turning->event)) {
    case RMAP_TURN_SCATTER:
    case RMAP_TURN_DIFFUSE: {
        const struct rmap_object *object = &turning->scene->object[turning->object];
        const struct rmap_surface *surface =
            &turning->scene->surface[turning->front ? object->surface_front : object->surface_back];
        if (rmap_surface_scatters(surface))
            return rmap_step_scattered(turning, direction, normal);
        rmap_rng(turning->seed, turning->ray, turning->step, RMAP_RNG_SURFACE, u);
        if (turning->event & RMAP_EVENT_TRANSMIT_DIFFUSE)
            normal = rmap_scale(normal, -1.0);
        return rmap_diffused(normal, u[2], u[3]);
    }
    case RMAP_TURN_REFLECT:
        return rmap_reflected(direction, normal);
    case RMAP_TURN_REFRACT:
        if (!turning->near || !turning->far)
            return direction;
        refracted = rmap_refracted(direction, normal, turning->near->n[turning->channel],
                                   turning->far->n[turning->channel], &total);
        return total > 0.0 ? rmap_reflected(direction, normal) : refracted;
    case RMAP_TURN_NONE:
        break;
    }
    return direction;
}

#endif

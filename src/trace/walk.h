/* SPDX-License-Identifier: MIT
 *
 * Light on its way, one leg at a time. The tracer records what happens at the end of each leg;
 * the renderer looks for light there. Both take the same steps:
 *
 *     rmap_walk_begin      and the colour
 *     rmap_walk_leg        to the end of the next leg
 *     rmap_interact        at a surface: what becomes of the light
 *     rmap_walk_depart     on from the surface
 *
 * Inline, as calls of these cost 2 % of a ray's instructions.
 */
#ifndef RMAP_WALK_H
#define RMAP_WALK_H

#include <math.h>

#include "trace/detector.h"
#include "trace/interact.h"
#include "trace/recorder.h"
#include "trace/tracer.h"

struct rmap_walk {
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_accel *accel; /* borrowed */
    struct rmap_recorder *recorder; /* told of detectors and curve points; NULL: nobody */
    struct rmap_draw draw;          /* step: legs so far */
    struct rmap_ray ray;            /* origin: where the next leg starts */
    struct rmap_colour colour;
    double weight, path_length, optical_path;
};

enum rmap_leg_end {
    RMAP_LEG_SURFACE,
    RMAP_LEG_ABSORBED,  /* inside the medium */
    RMAP_LEG_SCATTERED, /* inside the medium */
    RMAP_LEG_LEFT,      /* the scene; the leg does not count in the walk's path lengths */
    RMAP_LEG_LIMIT,     /* too many steps along a curve */
    RMAP_LEG_ERROR      /* the medium's field has no value there */
};

struct rmap_arrival {
    enum rmap_leg_end end;
    uint32_t events;     /* RMAP_EVENT_GRADIENT for a curved leg, else 0 */
    struct rmap_leg leg; /* to: its end; direction: there */
    struct rmap_hit hit; /* SURFACE */
};

/* Sets all but the colour. The ray: from anywhere; its contact is zero unless it starts where a
 * leg of another walk ended. */
static inline void rmap_walk_begin(struct rmap_walk *walk, const struct rmap_tracer *tracer,
                                   uint64_t ray_id, const struct rmap_ray *ray,
                                   struct rmap_recorder *recorder)
{
    walk->scene = tracer->scene;
    walk->accel = tracer->accel;
    walk->recorder = recorder;
    walk->draw = (struct rmap_draw){tracer->seed, ray_id, 0};
    walk->ray = *ray;
    walk->weight = 1.0;
    walk->path_length = walk->optical_path = 0.0;
}

/* Index along the leg; before the wavelength is drawn, the mean over the colour. */
static inline double rmap_walk_index(const struct rmap_walk *walk)
{
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    if (!medium->dispersive)
        return medium->n[walk->colour.begin];
    return rmap_colour_sum(&walk->colour, medium->n);
}

/* Distance to the scene's bounding sphere from inside; 0 from outside. */
static inline double rmap_walk_distance_out(const struct rmap_walk *walk)
{
    struct rmap_vec3 from = rmap_sub(walk->ray.origin, walk->scene->centre);
    double along = rmap_dot(from, walk->ray.direction);
    double gap = walk->scene->radius * walk->scene->radius - rmap_dot(from, from);
    if (!(gap > 0.0))
        return 0.0;
    double root = sqrt(along * along + gap);
    return along > 0.0 ? gap / (root + along) : root - along;
}

/* The next leg. The walk's colour becomes that on arrival, its direction that of arrival; its
 * origin stays. Detectors free in space and curve points are told to the recorder. */
static inline void rmap_walk_leg(struct rmap_walk *walk, struct rmap_arrival *arrival)
{
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    struct rmap_leg *leg = &arrival->leg;
    bool met = rmap_accel_next(walk->accel, &walk->ray, &arrival->hit);
    leg->from = walk->ray.origin;
    leg->direction = walk->ray.direction;
    leg->length = met ? arrival->hit.t : rmap_walk_distance_out(walk);
    leg->optical_from = walk->optical_path;
    leg->index = rmap_walk_index(walk);
    leg->segment = walk->draw.step++;
    double travelled = leg->length;
    if (medium->absorbing && leg->length > 0.0)
        travelled = rmap_absorb(medium, &walk->draw, leg->length, &walk->colour);
    bool absorbed = travelled < leg->length;
    leg->length = travelled;
    leg->to =
        met && !absorbed ? arrival->hit.position : rmap_axpy(travelled, leg->direction, leg->from);
    if (walk->recorder)
        rmap_detect_free(walk->scene, leg, walk->recorder);
    arrival->events = 0;
    arrival->end = absorbed ? RMAP_LEG_ABSORBED : met ? RMAP_LEG_SURFACE : RMAP_LEG_LEFT;
    if (arrival->end == RMAP_LEG_LEFT)
        return;
    walk->path_length += leg->length;
    walk->optical_path += leg->index * leg->length;
}

/* Does the scene's limit of steps or of weight end the ray at the end of this leg? */
static inline bool rmap_walk_limited(const struct rmap_walk *walk)
{
    uint64_t limit = walk->scene->limit_steps;
    if (limit > UINT32_MAX)
        limit = UINT32_MAX; /* rows of a ray are counted in 32 bits */
    return walk->draw.step >= limit || walk->weight < walk->scene->limit_weight;
}

/* On from the surface, as decided (neither ABSORB nor ERROR). */
static inline void rmap_walk_depart(struct rmap_walk *walk, const struct rmap_arrival *arrival,
                                    const struct rmap_decision *decision)
{
    rmap_decision_apply(decision, &walk->colour);
    if (decision->turned)
        rmap_contact_turn(&walk->ray.contact, &arrival->hit);
    else
        rmap_contact_pass(&walk->ray.contact, &arrival->hit);
    walk->ray.origin = arrival->hit.position;
    walk->ray.direction = decision->direction;
    walk->ray.medium = decision->medium;
    walk->ray.gradient = decision->gradient;
}

#endif

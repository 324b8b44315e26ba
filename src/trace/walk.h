/* SPDX-License-Identifier: MIT
 *
 * Light on its way, one segment at a time. The tracer records what happens at the end of each
 * segment; the renderer looks for light there. Both take the same steps:
 *
 *     rmap_walk_begin      and the colour
 *     rmap_walk_segment        to the end of the next segment
 *     rmap_interact        at a surface: what becomes of the light
 *     rmap_walk_depart     on from the surface, or
 *     rmap_walk_scatter, rmap_walk_reemit    on from inside the medium
 *
 * Inline, as calls of these cost 2 % of a ray's instructions.
 */
#ifndef RMAP_WALK_H
#define RMAP_WALK_H

#include <math.h>

#include "portion/recorder.h"
#include "trace/detector.h"
#include "trace/interact.h"
#include "trace/luminescence.h"
#include "trace/tracer.h"
#include "trace/turbid.h"

struct rmap_walk {
    const struct rmap_scene *scene; /* borrowed */
    const struct rmap_accel *accel; /* borrowed */
    struct rmap_recorder *recorder; /* told of detectors and curve points; NULL: nobody */
    struct rmap_draw draw;          /* step: segments so far */
    struct rmap_ray ray;            /* origin: where the next segment starts */
    struct rmap_vec3 start_normal;  /* of the surface that the segment starts on, if on any */
    struct rmap_colour colour;
    int first_channel; /* of a scene that fluoresces */
    double weight, path_length, optical_path;
    struct rmap_clock clock; /* of a timed scene */
    bool predicted;          /* so far every number was what src/compact predicts */
    const struct rmap_known_way *known;
    size_t n_known; /* segments that it still holds for; 0: `known` need not be there */
    bool rough;     /* nobody asks for lengths: those of curved segments may be estimates */
};

enum rmap_segment_end {
    RMAP_SEGMENT_SURFACE,
    RMAP_SEGMENT_ABSORBED,  /* inside the medium */
    RMAP_SEGMENT_SCATTERED, /* inside the medium */
    RMAP_SEGMENT_REEMITTED, /* inside the medium: absorbed, and given back */
    RMAP_SEGMENT_LEFT,      /* the scene; the segment does not count in the walk's path lengths */
    RMAP_SEGMENT_LIMIT,     /* curved: the medium's limit of steps */
    RMAP_SEGMENT_ERROR      /* curved: the field has no value there */
};

struct rmap_arrival {
    enum rmap_segment_end end;
    uint32_t events; /* RMAP_EVENT_GRADIENT for a curved segment, else 0 */
    struct rmap_segment
        segment;                      /* to: its end; direction: there. Curved: `index` is 0 and
                                 `optical_from`      the path at its end, or for one that left at its start */
    struct rmap_vec3 first_direction; /* of a curved segment */
    struct rmap_hit hit;              /* SURFACE */
    struct rmap_reemission back;      /* REEMITTED */
};

/* Sets all but the colour and the ray. That may start anywhere; its contact is zero unless it
 * starts where a segment of another walk ended. */
static inline void rmap_walk_begin(struct rmap_walk *walk, const struct rmap_tracer *tracer,
                                   uint64_t ray_id, struct rmap_recorder *recorder)
{
    walk->scene = tracer->scene;
    walk->accel = tracer->accel;
    walk->recorder = recorder;
    walk->draw = (struct rmap_draw){.seed = tracer->seed, .ray = ray_id};
    walk->weight = 1.0;
    walk->path_length = walk->optical_path = 0.0;
    walk->clock = (struct rmap_clock){.group_path = 0.0};
    walk->n_known = 0;
    walk->rough = false;
    walk->predicted = true;
}

/* Light that waits where it is: what comes later in the ray arrives later. */
static inline void rmap_walk_delay(struct rmap_walk *walk, double delay_ns)
{
    walk->clock.delay_ns += delay_ns;
    walk->predicted = false;
}

/* Index along the segment, n or n_group of the medium; before the wavelength is drawn, the mean
 * over the colour. */
static inline double rmap_walk_index(const struct rmap_walk *walk, const struct rmap_medium *medium,
                                     const double *n)
{
    if (!medium->dispersive)
        return n[walk->colour.begin];
    return rmap_colour_sum(&walk->colour, n);
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

/* rmap_accel_next where the walk's way is known. */
bool rmap_walk_known(struct rmap_walk *walk, struct rmap_hit *hit);

/* The next segment of light in a gradient medium. Not inline: it costs more than a call. */
void rmap_walk_curve(struct rmap_walk *walk, struct rmap_arrival *arrival);

static inline enum rmap_segment_end rmap_segment_end_of(uint32_t event)
{
    return event == RMAP_EVENT_ABSORB      ? RMAP_SEGMENT_ABSORBED
           : event == RMAP_EVENT_FLUORESCE ? RMAP_SEGMENT_REEMITTED
                                           : RMAP_SEGMENT_SCATTERED;
}

/* What happened at the end of a segment's free path, which ended it or not; as
 * rmap_free_path_end, and FLUORESCE. */
static inline uint32_t rmap_walk_inside(struct rmap_walk *walk, const struct rmap_medium *medium,
                                        const struct rmap_free_path *path, double length,
                                        bool ended, struct rmap_arrival *arrival)
{
    const uint32_t event = rmap_free_path_end(medium, path, length, ended, &walk->colour);
    return event == RMAP_EVENT_ABSORB && medium->n_species > 0 &&
                   rmap_colour_single(&walk->colour) &&
                   rmap_reemit(medium, walk->scene->channels.n, &walk->draw, walk->colour.begin,
                               &arrival->back)
               ? RMAP_EVENT_FLUORESCE
               : event;
}

/* The next segment. The walk's colour becomes that on arrival, its direction that of arrival; its
 * origin stays. Detectors free in space and curve points are told to the recorder. */
static inline void rmap_walk_segment(struct rmap_walk *walk, struct rmap_arrival *arrival)
{
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    struct rmap_segment *segment = &arrival->segment;
    if (walk->ray.gradient) {
        rmap_walk_curve(walk, arrival);
        return;
    }
    bool met = walk->draw.step < walk->n_known
                   ? rmap_walk_known(walk, &arrival->hit)
                   : rmap_accel_next(walk->accel, &walk->ray, &arrival->hit);
    uint32_t event = 0; /* inside the medium */
    if (met && !arrival->hit.predicted)
        walk->predicted = false;
    segment->from = walk->ray.origin;
    segment->direction = walk->ray.direction;
    segment->length = met ? arrival->hit.t : rmap_walk_distance_out(walk);
    segment->optical_from = walk->optical_path;
    segment->index = rmap_walk_index(walk, medium, medium->n);
    segment->segment = walk->draw.step++;
    segment->clock = NULL;
    if (walk->scene->timed) {
        segment->clock = &walk->clock;
        walk->clock.group_index = rmap_walk_index(walk, medium, medium->n_group);
    }
    if (rmap_medium_participates(medium) && segment->length > 0.0) {
        struct rmap_free_path path;
        walk->predicted = false;
        rmap_free_path_draw(medium, &walk->draw, &walk->colour, &path);
        bool ended = path.length < segment->length;
        segment->length = ended ? path.length : segment->length;
        event = rmap_walk_inside(walk, medium, &path, segment->length, ended, arrival);
    }
    arrival->events = 0;
    arrival->end = event ? rmap_segment_end_of(event)
                   : met ? RMAP_SEGMENT_SURFACE
                         : RMAP_SEGMENT_LEFT;
    segment->to = arrival->end == RMAP_SEGMENT_SURFACE
                      ? arrival->hit.position
                      : rmap_axpy(segment->length, segment->direction, segment->from);
    if (walk->recorder)
        rmap_detect_free(walk->scene, segment, walk->recorder);
    if (arrival->end == RMAP_SEGMENT_LEFT)
        return;
    walk->path_length += segment->length;
    walk->optical_path += segment->index * segment->length;
    if (!segment->clock)
        return;
    walk->clock.group_path += walk->clock.group_index * segment->length;
    walk->clock.group_index = 0.0;
}

/* Does the scene's limit of steps or of weight end the ray at the end of this segment? */
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
    walk->start_normal = arrival->hit.normal;
    if (!decision->predicted)
        walk->predicted = false;
}

/* On from a point inside the medium where the segment ended SCATTERED. */
static inline void rmap_walk_scatter(struct rmap_walk *walk, const struct rmap_arrival *arrival)
{
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    walk->ray.origin = arrival->segment.to;
    walk->ray.direction = rmap_scatter(medium, &walk->draw, &walk->colour, walk->ray.direction);
    rmap_contact_clear(&walk->ray.contact);
}

/* On from a point inside the medium where the segment ended REEMITTED. */
static inline void rmap_walk_reemit(struct rmap_walk *walk, const struct rmap_arrival *arrival)
{
    walk->ray.origin = arrival->segment.to;
    walk->ray.direction = rmap_reemit_direction(&walk->draw);
    rmap_colour_collapse(&walk->colour, arrival->back.channel);
    walk->weight = rmap_weight_after(walk->scene, walk->first_channel, arrival->back.channel);
    if (walk->scene->timed)
        rmap_walk_delay(walk, arrival->back.delay_ns);
    rmap_contact_clear(&walk->ray.contact);
}

#endif

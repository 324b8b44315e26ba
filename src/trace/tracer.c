/* SPDX-License-Identifier: MIT
 *
 * The tracer of one ray: emission, segments, surfaces, media, detectors, limits.
 */
#include "trace/tracer.h"

#include <math.h>

#include "trace/source.h"
#include "trace/walk.h"

/* A start that its file has rounded, and that lies on a surface to that rounding, is put there:
 * whether the ray still meets that is then decided as for any that starts on one. */
static void put_on_surface(const struct rmap_accel *accel, double loose, struct rmap_ray *ray,
                           struct rmap_emission *emission)
{
    struct rmap_hit hit;
    struct rmap_ray before = *ray;
    before.origin = rmap_axpy(-loose, ray->direction, ray->origin);
    if (!rmap_accel_next_within(accel, &before, 2.0 * loose, &hit))
        return;
    ray->origin = emission->position = hit.position;
    emission->predicted = false;
}

static void begin(struct rmap_walk *walk, const struct rmap_tracer *tracer, uint64_t ray,
                  struct rmap_recorder *recorder)
{
    struct rmap_emission emission;
    rmap_source_emit(tracer->scene, tracer->seed, ray, &walk->colour, &emission);
    rmap_walk_begin(walk, tracer, ray, recorder);
    walk->ray.origin = emission.position;
    walk->ray.direction = emission.direction;
    walk->ray.medium = emission.medium;
    walk->ray.gradient = tracer->scene->source[emission.source].gradient;
    rmap_contact_clear(&walk->ray.contact);
    walk->first_channel = walk->colour.begin;
    if (emission.loose > 0.0)
        put_on_surface(tracer->accel, emission.loose, &walk->ray, &emission);
    walk->predicted = emission.predicted;
    walk->clock.delay_ns += emission.delay_ns;
    recorder->emit(recorder, &emission);
}

static void end(struct rmap_walk *walk, enum rmap_stop stop)
{
    const struct rmap_channels *channels = &walk->scene->channels;
    struct rmap_ending ending = {.stop = stop,
                                 .weight = walk->weight,
                                 .wavelength_nm = (double)NAN,
                                 .path_length = walk->path_length,
                                 .optical_path = walk->optical_path,
                                 .group_path = walk->clock.group_path,
                                 .delay_ns = walk->clock.delay_ns,
                                 .predicted = walk->predicted};
    if (channels->mode == RMAP_COLOUR_SPECTRAL && rmap_colour_single(&walk->colour))
        ending.wavelength_nm = channels->wavelength_nm[walk->colour.begin];
    if (stop == RMAP_STOP_LEFT)
        ending.direction = walk->ray.direction;
    walk->recorder->end(walk->recorder, &ending);
}

static inline void record_step(struct rmap_walk *walk, const struct rmap_arrival *arrival,
                               uint32_t events)
{
    const struct rmap_segment *segment = &arrival->segment;
    const struct rmap_hit *hit = arrival->end == RMAP_SEGMENT_SURFACE ? &arrival->hit : NULL;
    struct rmap_step step = {.object = hit ? hit->object : -1,
                             .primitive = hit ? hit->primitive : -1,
                             .events = events | arrival->events,
                             .medium = walk->ray.medium,
                             .position = segment->to,
                             .direction = segment->direction,
                             .length = segment->length,
                             .optical_path = walk->optical_path,
                             .colour = walk->colour.share};
    if (hit)
        step.normal = hit->normal;
    if (arrival->events & RMAP_EVENT_GRADIENT)
        step.first_direction = arrival->first_direction;
    if (arrival->end == RMAP_SEGMENT_LEFT)
        step.length = 0.0;
    walk->recorder->step(walk->recorder, &step);
}

/* The surface at the end of a segment; true when the ray goes on. */
static bool meet_surface(struct rmap_walk *walk, const struct rmap_arrival *arrival)
{
    struct rmap_decision decision;
    if (rmap_walk_limited(walk)) {
        record_step(walk, arrival, RMAP_EVENT_LIMIT);
        end(walk, RMAP_STOP_LIMIT);
        return false;
    }
    rmap_interact(walk->scene, &walk->ray, &arrival->hit, &walk->colour, &walk->draw, &decision);
    record_step(walk, arrival, decision.events);
    if (decision.events & RMAP_EVENT_ERROR) {
        end(walk, RMAP_STOP_ERROR);
        return false;
    }
    rmap_detect_on(walk->scene, &arrival->segment, arrival->hit.object, arrival->hit.primitive,
                   walk->recorder);
    if (decision.events & RMAP_EVENT_ABSORB) {
        end(walk, RMAP_STOP_ABSORBED);
        return false;
    }
    rmap_walk_depart(walk, arrival, &decision);
    return true;
}

static bool stop_here(struct rmap_walk *walk, const struct rmap_arrival *arrival, uint32_t event,
                      enum rmap_stop stop)
{
    record_step(walk, arrival, event);
    if (stop == RMAP_STOP_LEFT && walk->scene->n_far_detector > 0) {
        rmap_detect_far(walk->scene, &arrival->segment, walk->recorder);
        walk->predicted = false; /* angles of another library */
    }
    end(walk, stop);
    return false;
}

static bool meet_particle(struct rmap_walk *walk, const struct rmap_arrival *arrival)
{
    const bool reemitted = arrival->end == RMAP_SEGMENT_REEMITTED;
    if (rmap_walk_limited(walk))
        return stop_here(walk, arrival, RMAP_EVENT_LIMIT, RMAP_STOP_LIMIT);
    record_step(walk, arrival, reemitted ? RMAP_EVENT_FLUORESCE : RMAP_EVENT_SCATTER_VOLUME);
    if (reemitted)
        rmap_walk_reemit(walk, arrival);
    else
        rmap_walk_scatter(walk, arrival);
    return true;
}

/* One segment; true when the ray goes on. */
static bool advance(struct rmap_walk *walk)
{
    struct rmap_arrival arrival;
    rmap_walk_segment(walk, &arrival);
    switch (arrival.end) {
    case RMAP_SEGMENT_SURFACE:
        return meet_surface(walk, &arrival);
    case RMAP_SEGMENT_ABSORBED:
        return stop_here(walk, &arrival, RMAP_EVENT_ABSORB, RMAP_STOP_ABSORBED);
    case RMAP_SEGMENT_LEFT:
        return stop_here(walk, &arrival, RMAP_EVENT_LEFT, RMAP_STOP_LEFT);
    case RMAP_SEGMENT_LIMIT:
        return stop_here(walk, &arrival, RMAP_EVENT_LIMIT, RMAP_STOP_LIMIT);
    case RMAP_SEGMENT_SCATTERED:
    case RMAP_SEGMENT_REEMITTED:
        return meet_particle(walk, &arrival);
    case RMAP_SEGMENT_ERROR:
        break;
    }
    return stop_here(walk, &arrival, RMAP_EVENT_ERROR, RMAP_STOP_ERROR);
}

bool rmap_walk_known(struct rmap_walk *walk, struct rmap_hit *hit)
{
    const struct rmap_known_way *way = walk->known;
    const int32_t old = way->object[walk->draw.step], primitive = way->primitive[walk->draw.step];
    const int32_t object = old < 0 ? -1 : way->number[old];
    if (object >= 0 && rmap_accel_meet(walk->accel, &walk->ray, object, primitive, hit) &&
        !rmap_places_meet(way->places, walk->ray.origin, hit->position))
        return true;
    const bool met = rmap_accel_next(walk->accel, &walk->ray, hit);
    if (!met || hit->object != object || hit->primitive != primitive)
        walk->n_known = 0;
    return met;
}

void rmap_trace_known(const struct rmap_tracer *tracer, uint64_t ray,
                      const struct rmap_known_way *way, struct rmap_recorder *recorder)
{
    struct rmap_walk walk;
    begin(&walk, tracer, ray, recorder);
    walk.known = way;
    walk.n_known = way->n;
    while (advance(&walk))
        continue;
}

void rmap_trace_ray(const struct rmap_tracer *tracer, uint64_t ray, struct rmap_recorder *recorder)
{
    rmap_trace_known(tracer, ray, &(struct rmap_known_way){.n = 0}, recorder);
}

/* SPDX-License-Identifier: MIT */
#include "trace/tracer.h"

#include <math.h>

#include "trace/detector.h"
#include "trace/interact.h"
#include "trace/source.h"

/* A ray on its way. */
struct walk {
    const struct rmap_scene *scene;
    struct rmap_recorder *recorder;
    struct rmap_draw draw; /* step: number of the leg in hand, from 1 */
    struct rmap_ray ray;
    struct rmap_colour colour;
    double weight, path_length, optical_path;
};

static void begin(struct walk *walk, const struct rmap_tracer *tracer, uint64_t ray)
{
    struct rmap_emission emission;
    walk->scene = tracer->scene;
    walk->draw = (struct rmap_draw){tracer->seed, ray, 0};
    walk->weight = 1.0;
    walk->path_length = walk->optical_path = 0.0;
    rmap_source_emit(tracer->scene, tracer->seed, ray, &walk->colour, &emission);
    walk->ray = (struct rmap_ray){
        .origin = emission.position, .direction = emission.direction, .medium = emission.medium};
    walk->recorder->emit(walk->recorder, &emission);
}

static void end(struct walk *walk, enum rmap_stop stop)
{
    const struct rmap_channels *channels = &walk->scene->channels;
    struct rmap_ending ending = {.stop = stop,
                                 .weight = walk->weight,
                                 .wavelength_nm = (double)NAN,
                                 .path_length = walk->path_length,
                                 .optical_path = walk->optical_path};
    if (channels->mode == RMAP_COLOUR_SPECTRAL && rmap_colour_single(&walk->colour))
        ending.wavelength_nm = channels->wavelength_nm[walk->colour.begin];
    if (stop == RMAP_STOP_LEFT)
        ending.direction = walk->ray.direction;
    walk->recorder->end(walk->recorder, &ending);
}

/* Index along the leg; before the wavelength is drawn, the mean over the colour. */
static double index_of(const struct walk *walk)
{
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    if (!medium->dispersive)
        return medium->n[walk->colour.begin];
    return rmap_colour_sum(&walk->colour, medium->n);
}

/* Distance to the scene's bounding sphere from inside; 0 from outside. */
static double distance_out(const struct walk *walk)
{
    struct rmap_vec3 from = rmap_sub(walk->ray.origin, walk->scene->centre);
    double along = rmap_dot(from, walk->ray.direction);
    double gap = walk->scene->radius * walk->scene->radius - rmap_dot(from, from);
    if (!(gap > 0.0))
        return 0.0;
    double root = sqrt(along * along + gap);
    return along > 0.0 ? gap / (root + along) : root - along;
}

static void record_step(struct walk *walk, const struct rmap_leg *leg, const struct rmap_hit *hit,
                        uint32_t events)
{
    struct rmap_step step = {.object = hit ? hit->object : -1,
                             .primitive = hit ? hit->primitive : -1,
                             .events = events,
                             .medium = walk->ray.medium,
                             .position = leg->to,
                             .direction = leg->direction,
                             .length = leg->length,
                             .optical_path = walk->optical_path,
                             .colour = walk->colour.share};
    if (hit)
        step.normal = hit->normal;
    if (events == RMAP_EVENT_LEFT)
        step.length = 0.0;
    walk->recorder->step(walk->recorder, &step);
}

static void leave(struct walk *walk, struct rmap_leg *leg)
{
    record_step(walk, leg, NULL, RMAP_EVENT_LEFT);
    rmap_detect_far(walk->scene, leg, walk->recorder);
    end(walk, RMAP_STOP_LEFT);
}

static bool limited(const struct walk *walk)
{
    uint64_t limit = walk->scene->limit_steps;
    if (limit > UINT32_MAX)
        limit = UINT32_MAX; /* rows of a ray are counted in 32 bits */
    return walk->draw.step >= limit || walk->weight < walk->scene->limit_weight;
}

/* The surface at the end of a leg; true when the ray goes on. */
static bool meet_surface(struct walk *walk, const struct rmap_leg *leg, const struct rmap_hit *hit)
{
    struct rmap_decision decision;
    if (limited(walk)) {
        record_step(walk, leg, hit, RMAP_EVENT_LIMIT);
        end(walk, RMAP_STOP_LIMIT);
        return false;
    }
    rmap_interact(walk->scene, &walk->ray, hit, &walk->colour, &walk->draw, &decision);
    record_step(walk, leg, hit, decision.events);
    if (decision.events & RMAP_EVENT_ERROR) {
        end(walk, RMAP_STOP_ERROR);
        return false;
    }
    rmap_detect_on(walk->scene, leg, hit->object, walk->recorder);
    if (decision.events & RMAP_EVENT_ABSORB) {
        end(walk, RMAP_STOP_ABSORBED);
        return false;
    }
    rmap_decision_apply(&decision, &walk->colour);
    if (decision.turned)
        rmap_contact_turn(&walk->ray.contact, hit);
    else
        rmap_contact_pass(&walk->ray.contact, hit);
    walk->ray.origin = hit->position;
    walk->ray.direction = decision.direction;
    walk->ray.medium = decision.medium;
    return true;
}

/* One leg; true when the ray goes on. */
static bool advance(struct walk *walk, const struct rmap_accel *accel)
{
    struct rmap_hit hit;
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    bool met = rmap_accel_next(accel, &walk->ray, &hit);
    struct rmap_leg leg = {.from = walk->ray.origin,
                           .direction = walk->ray.direction,
                           .length = met ? hit.t : distance_out(walk),
                           .optical_from = walk->optical_path,
                           .index = index_of(walk),
                           .segment = walk->draw.step++};
    double travelled = leg.length;
    if (medium->absorbing && leg.length > 0.0)
        travelled = rmap_absorb(medium, &walk->draw, leg.length, &walk->colour);
    bool absorbed = travelled < leg.length;
    leg.length = travelled;
    leg.to = met && !absorbed ? hit.position : rmap_axpy(travelled, leg.direction, leg.from);
    rmap_detect_free(walk->scene, &leg, walk->recorder);
    if (!met && !absorbed) {
        leave(walk, &leg);
        return false;
    }
    walk->path_length += leg.length;
    walk->optical_path += leg.index * leg.length;
    if (!absorbed)
        return meet_surface(walk, &leg, &hit);
    record_step(walk, &leg, NULL, RMAP_EVENT_ABSORB);
    end(walk, RMAP_STOP_ABSORBED);
    return false;
}

void rmap_trace_ray(const struct rmap_tracer *tracer, uint64_t ray, struct rmap_recorder *recorder)
{
    struct walk walk;
    walk.recorder = recorder;
    begin(&walk, tracer, ray);
    while (advance(&walk, tracer->accel))
        continue;
}

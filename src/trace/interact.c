/* SPDX-License-Identifier: MIT
 *
 * What becomes of light at a surface: one outcome drawn with its physical probability (analog
 * Monte Carlo).
 */
#include "trace/interact.h"

#include <math.h>
#include <string.h>

#include "base/rng.h"
#include "formula/turn.h"
#include "portion/event.h"
#include "scene/coat.h"
#include "trace/scattering.h"

/* The side of a surface that light meets. */
struct side {
    const struct rmap_object *object;
    bool front; /* light comes from there */
    const struct rmap_surface *surface;
    const struct rmap_hit *hit;
    int32_t far;             /* medium beyond; the light's own where none is stated */
    int32_t far_gradient;    /* its place, as struct rmap_ray has it */
    const double *n1, *n2;   /* indices per channel, here and beyond */
    struct rmap_vec3 normal; /* towards the light */
    double cos_i;
};

/* False when the light travels in another medium than the side says. */
static bool meet(const struct rmap_scene *scene, const struct rmap_ray *ray,
                 const struct rmap_hit *hit, struct side *side, struct rmap_decision *decision)
{
    const struct rmap_object *object = &scene->object[hit->object];
    double cosine = rmap_dot(ray->direction, hit->normal);
    bool front = cosine < 0.0;
    if (cosine == 0.0) /* grazing exactly: the side that the light can be on */
        front = object->medium_front == ray->medium || object->medium_back != ray->medium;
    decision->predicted = cosine != 0.0;
    int32_t near = front ? object->medium_front : object->medium_back;
    int32_t far = front ? object->medium_back : object->medium_front;
    if (near != RMAP_MEDIUM_ANY && near != ray->medium)
        return false;
    side->object = object;
    side->front = front;
    side->hit = hit;
    side->surface = &scene->surface[front ? object->surface_front : object->surface_back];
    side->far = ray->medium;
    side->far_gradient = ray->gradient;
    if (far != RMAP_MEDIUM_ANY) {
        side->far = far;
        side->far_gradient = front ? object->gradient_back : object->gradient_front;
    }
    side->normal = front ? hit->normal : rmap_scale(hit->normal, -1.0);
    side->cos_i = fabs(cosine) < 1.0 ? fabs(cosine) : 1.0;
    return true;
}

static void turn(struct rmap_decision *decision, uint32_t event, struct rmap_vec3 direction)
{
    decision->events = event;
    decision->turned = true;
    decision->direction = direction;
}

static void pass(const struct side *side, struct rmap_decision *decision)
{
    decision->medium = side->far;
    decision->gradient = side->far_gradient;
}

/* Transmission in the direction of channel i's index. Where rounding, or a mixture's surface,
 * meets total reflection, the light turns back. */
static void pass_specular(const struct rmap_ray *ray, const struct side *side, int channel,
                          struct rmap_decision *decision)
{
    double total;
    decision->direction =
        rmap_refracted(ray->direction, side->normal, side->n1[channel], side->n2[channel], &total);
    if (total > 0.0) {
        turn(decision, RMAP_EVENT_TOTAL_REFLECTION, rmap_reflected(ray->direction, side->normal));
        decision->predicted = false; /* the colour of what was drawn goes with it */
        return;
    }
    decision->events = RMAP_EVENT_TRANSMIT_SPECULAR;
    decision->turned = false;
    pass(side, decision);
}

/* The channel to refract with; draws one where the two media bend them apart. */
static int refracting_channel(const struct rmap_scene *scene, const struct rmap_ray *ray,
                              const struct side *side, const struct rmap_colour *colour,
                              const double *p, double u, struct rmap_decision *decision)
{
    if (rmap_colour_single(colour) ||
        !(scene->medium[ray->medium].dispersive || scene->medium[side->far].dispersive))
        return colour->begin;
    decision->collapse = rmap_colour_pick(colour, p, u);
    return decision->collapse;
}

static inline double reflectance(const struct side *side, int channel, bool *total)
{
    return rmap_coated_reflectance(side->surface, channel, side->n1[channel], side->n2[channel],
                                   side->cos_i, total);
}

static inline void draw_numbers(const struct rmap_draw *draw, double u[4])
{
    rmap_rng(draw->seed, draw->ray, draw->step, RMAP_RNG_SURFACE, u);
}

/* All live channels share one reflectance, or there is only one of them. */
static void fresnel_alike(const struct rmap_ray *ray, const struct side *side,
                          const struct rmap_colour *colour, const struct rmap_draw *draw,
                          struct rmap_decision *decision)
{
    int channel = colour->begin;
    bool total;
    double r = reflectance(side, channel, &total);
    double u[4] = {0.0};
    if (r > 0.0 && r < 1.0)
        draw_numbers(draw, u);
    if (u[0] < r)
        turn(decision, total ? RMAP_EVENT_TOTAL_REFLECTION : RMAP_EVENT_REFLECT_SPECULAR,
             rmap_reflected(ray->direction, side->normal));
    else
        pass_specular(ray, side, channel, decision);
}

/* Thin films absorb, too. */
static void decide_film(const struct rmap_scene *scene, const struct rmap_ray *ray,
                        const struct side *side, const struct rmap_colour *colour,
                        const struct rmap_draw *draw, struct rmap_decision *decision)
{
    double passed[RMAP_CHANNEL_MAX], *share = decision->scratch, u[4];
    bool all_total = true;
    for (int i = colour->begin; i < colour->end; i++) {
        const struct rmap_coat_shares its = rmap_thin_film_coat(
            scene, side->object, side->front, i, side->n1[i], side->n2[i], side->cos_i);
        share[i] = its.reflected;
        passed[i] = its.passed;
        all_total = all_total && (its.total || !(colour->share[i] > 0.0));
    }
    draw_numbers(draw, u);
    const double reflected = rmap_colour_sum(colour, share);
    decision->weigh = rmap_colour_single(colour) ? NULL : share;
    if (u[0] < reflected) {
        turn(decision, all_total ? RMAP_EVENT_TOTAL_REFLECTION : RMAP_EVENT_REFLECT_SPECULAR,
             rmap_reflected(ray->direction, side->normal));
        return;
    }
    if (u[0] >= reflected + rmap_colour_sum(colour, passed)) {
        decision->weigh = NULL;
        decision->events = RMAP_EVENT_ABSORB;
        return;
    }
    memcpy(share + colour->begin, passed + colour->begin,
           (size_t)(colour->end - colour->begin) * sizeof *share);
    pass_specular(ray, side, refracting_channel(scene, ray, side, colour, share, u[1], decision),
                  decision);
}

/* Without its channel and the numbers of that. */
static struct rmap_scatter_side scatter_side(const struct rmap_scene *scene,
                                             const struct rmap_ray *ray, const struct side *side)
{
    struct rmap_scatter_side its = {.scene = scene,
                                    .object = side->object,
                                    .front = side->front,
                                    .position = side->hit->position,
                                    .primitive = side->hit->primitive,
                                    .surface = side->surface,
                                    .near = ray->medium,
                                    .far = side->far,
                                    .normal = side->normal};
    rmap_scatter_frame(&its);
    return its;
}

static void on_channel(const struct side *side, int channel, struct rmap_scatter_side *its)
{
    its->channel = channel;
    its->n1 = side->n1[channel];
    its->n2 = side->n2[channel];
}

static bool alike(const struct rmap_colour *colour, const double *p)
{
    for (int i = colour->begin + 1; i < colour->end; i++)
        if (p[i] != p[colour->begin])
            return false;
    return true;
}

/* Shares of one outcome become those that the colour is weighed with. */
static void weigh_with(const struct rmap_scatter_side *its, bool passes,
                       const struct rmap_colour *colour, const double *p,
                       struct rmap_decision *decision)
{
    if (rmap_colour_single(colour) || decision->collapse >= 0 || alike(colour, p))
        return;
    memcpy(decision->scratch + colour->begin, p + colour->begin,
           (size_t)(colour->end - colour->begin) * sizeof *p);
    decision->weigh = decision->scratch;
    decision->predicted = decision->predicted && rmap_scatter_shares_follow(its, passes);
}

static void drawn_channel(const struct rmap_colour *colour, const double *p, double u,
                          struct rmap_decision *decision)
{
    if (!rmap_colour_single(colour))
        decision->collapse = rmap_colour_pick(colour, p, u);
}

static int channel_of(const struct rmap_colour *colour, const struct rmap_decision *decision)
{
    return decision->collapse >= 0 ? decision->collapse : colour->begin;
}

static void decide_lobes(const struct rmap_scene *scene, const struct rmap_ray *ray,
                         const struct side *side, const struct rmap_colour *colour,
                         const struct rmap_draw *draw, struct rmap_decision *decision)
{
    struct rmap_scatter_side its = scatter_side(scene, ray, side);
    double share[4][RMAP_CHANNEL_MAX], u[4], sum = 0.0;
    bool all_total = true;
    int chosen = 0;
    const struct rmap_vec3 in = {rmap_dot(ray->direction, its.x), rmap_dot(ray->direction, its.y),
                                 -side->cos_i};
    for (int i = colour->begin; i < colour->end; i++) {
        on_channel(side, i, &its);
        const struct rmap_surface_shares one = rmap_scatter_shares(&its, in);
        share[0][i] = one.reflect_diffuse;
        share[1][i] = one.reflect_specular;
        share[2][i] = one.transmit_specular;
        share[3][i] = one.transmit_diffuse;
        all_total = all_total &&
                    (!(colour->share[i] > 0.0) || (side->surface->type == RMAP_SURFACE_FRESNEL &&
                                                   rmap_smooth_shares(&its, side->cos_i).total));
    }
    draw_numbers(draw, u);
    for (; chosen < 4; chosen++) {
        sum += rmap_colour_sum(colour, share[chosen]);
        if (u[0] < sum)
            break;
    }
    if (chosen == 4) {
        decision->events = RMAP_EVENT_ABSORB;
    } else if (chosen == 1) {
        weigh_with(&its, false, colour, share[1], decision);
        turn(decision, all_total ? RMAP_EVENT_TOTAL_REFLECTION : RMAP_EVENT_REFLECT_SPECULAR,
             rmap_reflected(ray->direction, side->normal));
    } else if (chosen == 2) {
        const int channel = refracting_channel(scene, ray, side, colour, share[2], u[1], decision);
        weigh_with(&its, true, colour, share[2], decision);
        pass_specular(ray, side, channel, decision);
    } else {
        const struct rmap_scatter *lobe = rmap_surface_scatter(scene, side->surface, chosen == 3);
        if (rmap_scatter_by_channel(&its, lobe))
            drawn_channel(colour, share[chosen], u[1], decision);
        else if (!rmap_colour_single(colour) && !lobe->by_roughness)
            decision->weigh = lobe->amount; /* the rest of the shares is the same for all */
        else
            weigh_with(&its, chosen == 3, colour, share[chosen], decision);
        on_channel(side, channel_of(colour, decision), &its);
        decision->events = chosen == 3 ? RMAP_EVENT_TRANSMIT_DIFFUSE : RMAP_EVENT_REFLECT_DIFFUSE;
        decision->turned = chosen != 3;
        if (chosen == 3)
            pass(side, decision);
        decision->direction = rmap_scatter_turned(&its, chosen == 3, ray->direction, draw);
    }
}

static void decide_facets(const struct rmap_scene *scene, const struct rmap_ray *ray,
                          const struct side *side, const struct rmap_colour *colour,
                          const struct rmap_draw *draw, struct rmap_decision *decision)
{
    const struct rmap_scatter *model = rmap_surface_scatter(scene, side->surface, false);
    struct rmap_scatter_side its = scatter_side(scene, ray, side);
    struct rmap_facet facet;
    struct rmap_vec3 back = side->normal, on = side->normal;
    double reflected[RMAP_CHANNEL_MAX], passed[RMAP_CHANNEL_MAX], u[4], share = 1.0, part = 1.0;
    bool all_total = true;
    draw_numbers(draw, u);
    if (rmap_scatter_by_channel(&its, model))
        drawn_channel(colour, NULL, u[1], decision); /* facets differ: their shares come after */
    const int channel = channel_of(colour, decision);
    const bool drawn = decision->collapse >= 0;
    const int begin = drawn ? channel : colour->begin, end = drawn ? channel + 1 : colour->end;
    on_channel(side, channel, &its);
    rmap_facet_meet(&its, ray->direction, draw, &facet);
    for (int i = begin; i < end; i++) {
        on_channel(side, i, &its);
        const struct rmap_coat_shares one = rmap_smooth_shares(&its, facet.cos_i);
        reflected[i] = one.reflected;
        passed[i] = one.passed;
        all_total = all_total && one.total;
    }
    on_channel(side, channel, &its);
    const double r = drawn ? reflected[channel] : rmap_colour_sum(colour, reflected);
    const double t = drawn ? passed[channel] : rmap_colour_sum(colour, passed);
    const bool is_spike = facet.part == RMAP_PART_SPIKE;
    if (!is_spike) {
        share = rmap_facet_leave(&its, &facet, false, draw, &back);
        part = t > 0.0 ? rmap_facet_leave(&its, &facet, true, draw, &on) : 0.0;
    }
    if (u[0] < r * share) {
        weigh_with(&its, false, colour, reflected, decision);
        turn(decision,
             !is_spike   ? RMAP_EVENT_REFLECT_DIFFUSE
             : all_total ? RMAP_EVENT_TOTAL_REFLECTION
                         : RMAP_EVENT_REFLECT_SPECULAR,
             is_spike ? rmap_reflected(ray->direction, side->normal) : back);
        decision->sharp = facet.part == RMAP_PART_BACK;
    } else if (u[0] < r * share + t * part) {
        weigh_with(&its, true, colour, passed, decision);
        if (is_spike) {
            pass_specular(ray, side, channel, decision);
            return;
        }
        decision->events = RMAP_EVENT_TRANSMIT_DIFFUSE;
        pass(side, decision);
        decision->direction = on;
    } else {
        decision->events = RMAP_EVENT_ABSORB;
        decision->collapse = -1;
    }
}

static void decide_scatter(const struct rmap_scene *scene, const struct rmap_ray *ray,
                           const struct side *side, const struct rmap_colour *colour,
                           const struct rmap_draw *draw, struct rmap_decision *decision)
{
    const struct rmap_scatter *its = rmap_surface_scatter(scene, side->surface, false);
    if (its && rmap_scatter_is_facets(its))
        decide_facets(scene, ray, side, colour, draw, decision);
    else
        decide_lobes(scene, ray, side, colour, draw, decision);
}

static void decide_fresnel(const struct rmap_scene *scene, const struct rmap_ray *ray,
                           const struct side *side, const struct rmap_colour *colour,
                           const struct rmap_draw *draw, struct rmap_decision *decision)
{
    const struct rmap_medium *near = &scene->medium[ray->medium], *far = &scene->medium[side->far];
    bool dispersive = near->dispersive || far->dispersive;
    if (side->surface->coat == RMAP_COAT_FILM) {
        decide_film(scene, ray, side, colour, draw, decision);
        return;
    }
    if (rmap_colour_single(colour) ||
        (!dispersive && side->surface->coat != RMAP_COAT_REFLECTANCE)) {
        fresnel_alike(ray, side, colour, draw, decision);
        return;
    }
    bool all_total = true;
    double *r = decision->scratch;
    for (int i = colour->begin; i < colour->end; i++) {
        bool total;
        r[i] = reflectance(side, i, &total);
        all_total = all_total && (total || !(colour->share[i] > 0.0));
    }
    if (all_total) {
        turn(decision, RMAP_EVENT_TOTAL_REFLECTION, rmap_reflected(ray->direction, side->normal));
        return;
    }
    double u[4];
    draw_numbers(draw, u);
    decision->weigh = r;
    if (u[0] < rmap_colour_sum(colour, r)) {
        turn(decision, RMAP_EVENT_REFLECT_SPECULAR, rmap_reflected(ray->direction, side->normal));
        return;
    }
    for (int i = colour->begin; i < colour->end; i++)
        r[i] = 1.0 - r[i];
    int channel = refracting_channel(scene, ray, side, colour, r, u[1], decision);
    pass_specular(ray, side, channel, decision);
}

/* One outcome out of shares per channel; what is left over is absorbed. */
struct outcome {
    uint32_t event;
    const double *p;
};

static void decide_shares(const struct rmap_scene *scene, const struct rmap_ray *ray,
                          const struct side *side, const struct rmap_colour *colour,
                          const struct rmap_draw *draw, const struct outcome *outcome,
                          struct rmap_decision *decision)
{
    double u[4], sum = 0.0;
    draw_numbers(draw, u);
    const struct outcome *chosen = outcome;
    for (; chosen->event; chosen++) {
        sum += rmap_colour_sum(colour, chosen->p);
        if (u[0] < sum)
            break;
    }
    decision->weigh = rmap_colour_single(colour) ? NULL : chosen->p;
    switch (chosen->event) {
    case RMAP_EVENT_REFLECT_SPECULAR:
        turn(decision, chosen->event, rmap_reflected(ray->direction, side->normal));
        break;
    case RMAP_EVENT_REFLECT_DIFFUSE:
        turn(decision, chosen->event, rmap_diffused(side->normal, u[2], u[3]));
        break;
    case RMAP_EVENT_TRANSMIT_SPECULAR:
        pass_specular(ray, side,
                      refracting_channel(scene, ray, side, colour, chosen->p, u[1], decision),
                      decision);
        break;
    case RMAP_EVENT_TRANSMIT_DIFFUSE:
        decision->events = chosen->event;
        pass(side, decision);
        decision->direction = rmap_diffused(rmap_scale(side->normal, -1.0), u[2], u[3]);
        break;
    default:
        decision->events = RMAP_EVENT_ABSORB;
    }
}

static void decide_mirror(const struct rmap_scene *scene, const struct rmap_ray *ray,
                          const struct side *side, const struct rmap_colour *colour,
                          const struct rmap_draw *draw, struct rmap_decision *decision)
{
    const struct rmap_surface *surface = side->surface;
    struct outcome outcome[] = {{RMAP_EVENT_REFLECT_SPECULAR, surface->reflect_specular}, {0}};
    if (surface->is_metal) {
        decision->predicted =
            decision->predicted && (rmap_colour_single(colour) || surface->coat == RMAP_COAT_FILM);
        for (int i = colour->begin; i < colour->end; i++)
            decision->scratch[i] = rmap_metal_coat(scene, surface, i, side->n1[i], side->cos_i);
        outcome[0].p = decision->scratch;
    }
    decide_shares(scene, ray, side, colour, draw, outcome, decision);
}

static void decide_mixture(const struct rmap_scene *scene, const struct rmap_ray *ray,
                           const struct side *side, const struct rmap_colour *colour,
                           const struct rmap_draw *draw, struct rmap_decision *decision)
{
    const struct rmap_surface *surface = side->surface;
    const struct outcome outcome[] = {
        {RMAP_EVENT_REFLECT_SPECULAR, surface->reflect_specular},
        {RMAP_EVENT_REFLECT_DIFFUSE, surface->reflect_diffuse},
        {RMAP_EVENT_TRANSMIT_SPECULAR, surface->transmit_specular},
        {RMAP_EVENT_TRANSMIT_DIFFUSE, surface->transmit_diffuse},
        {0},
    };
    decide_shares(scene, ray, side, colour, draw, outcome, decision);
}

/* Where an index is needed. */
static bool refracts(const struct rmap_surface *surface)
{
    return surface->type == RMAP_SURFACE_FRESNEL || surface->type == RMAP_SURFACE_MIXTURE ||
           surface->is_metal || rmap_surface_scatters(surface);
}

/* Indices of the live channels in a gradient medium at a point of its boundary, which rounding may
 * have put outside: a field may end there. `within` leads inside. */
static bool index_at(const struct rmap_gradient *gradient, const struct rmap_colour *colour,
                     struct rmap_vec3 point, struct rmap_vec3 within, double *n)
{
    struct rmap_vec3 slope, inside = rmap_axpy(4.0 * gradient->options.tolerance, within, point);
    for (int i = colour->begin; i < colour->end; i++) {
        if (i > colour->begin && gradient->field->n_channel == 1)
            n[i] = n[i - 1];
        else if (!rmap_gradient_at(gradient, i, point, &n[i], &slope) &&
                 !rmap_gradient_at(gradient, i, inside, &n[i], &slope))
            return false;
    }
    return true;
}

/* False where a gradient medium has no index. near, far: room for its indices. */
static bool look_up(const struct rmap_scene *scene, const struct rmap_ray *ray,
                    const struct rmap_hit *hit, const struct rmap_colour *colour, struct side *side,
                    double *near, double *far, struct rmap_decision *decision)
{
    side->n1 = scene->medium[ray->medium].n;
    side->n2 = scene->medium[side->far].n;
    if (!(ray->gradient | side->far_gradient) || !refracts(side->surface))
        return true;
    decision->predicted = false;
    if (ray->gradient) {
        side->n1 = near;
        if (!index_at(&scene->gradient[ray->gradient - 1], colour, hit->position, side->normal,
                      near))
            return false;
    }
    if (side->far_gradient == ray->gradient) {
        side->n2 = side->n1;
    } else if (side->far_gradient) {
        side->n2 = far;
        return index_at(&scene->gradient[side->far_gradient - 1], colour, hit->position,
                        rmap_scale(side->normal, -1.0), far);
    }
    return true;
}

static void decide(const struct rmap_scene *scene, const struct rmap_ray *ray,
                   const struct rmap_hit *hit, const struct rmap_colour *colour,
                   const struct rmap_draw *draw, struct rmap_decision *decision)
{
    struct side side;
    double near[RMAP_CHANNEL_MAX], far[RMAP_CHANNEL_MAX];
    decision->turned = false;
    decision->medium = ray->medium;
    decision->gradient = ray->gradient;
    decision->collapse = -1;
    decision->weigh = NULL;
    decision->sharp = false;
    decision->events = RMAP_EVENT_ERROR;
    if (!meet(scene, ray, hit, &side, decision) ||
        !look_up(scene, ray, hit, colour, &side, near, far, decision))
        return;
    if (rmap_surface_scatters(side.surface)) {
        decide_scatter(scene, ray, &side, colour, draw, decision);
        return;
    }
    switch (side.surface->type) {
    case RMAP_SURFACE_FRESNEL:
        decide_fresnel(scene, ray, &side, colour, draw, decision);
        break;
    case RMAP_SURFACE_MIRROR:
        decide_mirror(scene, ray, &side, colour, draw, decision);
        break;
    case RMAP_SURFACE_LAMBERT: {
        const struct outcome outcome[] = {
            {RMAP_EVENT_REFLECT_DIFFUSE, side.surface->reflect_diffuse}, {0}};
        decide_shares(scene, ray, &side, colour, draw, outcome, decision);
        break;
    }
    case RMAP_SURFACE_ABSORBER:
        decision->events = RMAP_EVENT_ABSORB;
        break;
    case RMAP_SURFACE_SCATTER: /* without a model it is what its shares say */
    case RMAP_SURFACE_MIXTURE:
        decide_mixture(scene, ray, &side, colour, draw, decision);
        break;
    }
}

/* Light that the facets of a Fresnel surface would meet from their back, or send through the plane
 * on the wrong side, ends on the steps between them. */
static bool meets_step(const struct rmap_object *object, const struct rmap_ray *ray,
                       const struct rmap_hit *hit, const struct rmap_decision *decision)
{
    const struct rmap_vec3 up = rmap_affine_transposed(&object->to_local, rmap_vec3(0, 0, 1));
    const double in = rmap_dot(ray->direction, up);
    if (!decision)
        return in * rmap_dot(ray->direction, hit->normal) <= 0.0;
    return (decision->turned ? -in : in) * rmap_dot(decision->direction, up) <= 0.0;
}

static void decide_at_facets(const struct rmap_scene *scene, const struct rmap_ray *ray,
                             const struct rmap_hit *hit, const struct rmap_colour *colour,
                             const struct rmap_draw *draw, struct rmap_decision *decision)
{
    const struct rmap_object *object = &scene->object[hit->object];
    if (meets_step(object, ray, hit, NULL)) {
        *decision = (struct rmap_decision){.medium = ray->medium,
                                           .gradient = ray->gradient,
                                           .collapse = -1,
                                           .events = RMAP_EVENT_ABSORB};
        return;
    }
    decide(scene, ray, hit, colour, draw, decision);
    if (!(decision->events & (RMAP_EVENT_ABSORB | RMAP_EVENT_ERROR)) &&
        meets_step(object, ray, hit, decision))
        decision->events = RMAP_EVENT_ABSORB;
}

void rmap_interact(const struct rmap_scene *scene, const struct rmap_ray *ray,
                   const struct rmap_hit *hit, const struct rmap_colour *colour,
                   const struct rmap_draw *draw, struct rmap_decision *decision)
{
    if (scene->object[hit->object].faceted)
        decide_at_facets(scene, ray, hit, colour, draw, decision);
    else
        decide(scene, ray, hit, colour, draw, decision);
}

void rmap_decision_apply(const struct rmap_decision *decision, struct rmap_colour *colour)
{
    if (decision->collapse >= 0)
        rmap_colour_collapse(colour, decision->collapse);
    else if (decision->weigh)
        rmap_colour_weigh(colour, decision->weigh);
}

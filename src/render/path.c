/* SPDX-License-Identifier: MIT
 *
 * One path from the camera; see renderer.h.
 */
#include <string.h>

#include "base/rng.h"
#include "optics/spectrum.h"
#include "render/anywhere.h"
#include "render/camera_ray.h"
#include "render/renderer.h"
#include "trace/scattering.h"
#include "trace/walk.h"

struct path {
    struct rmap_recorder base; /* is told the points of curved segments */
    const struct rmap_renderer *renderer;
    struct rmap_render_counts *counts;
    struct rmap_walk walk;
    uint64_t pixel, sample;
    double left[2]; /* of the pixel's random numbers */

    double rgb[3];
    double cut;      /* luminance that the renderer's clamp took away */
    double scale;    /* of diffuse transmission between media of different index */
    bool looked;     /* at all lights, from where the segment in hand begins */
    bool lit_once;   /* lights have been looked at before */
    bool sees_light; /* an area light, without anything that scatters in between */

    struct rmap_vec3 point;    /* the segment in hand has been searched for light up to here, */
    double done;               /* over this length, */
    struct rmap_colour before; /* in a medium that weighs it: the colour that it began with */
};

/* Additive recurrence in six dimensions, with steps phi^-1 ... phi^-6, phi^7 = phi + 1 (Roberts
 * 2018, "The unreasonable effectiveness of quasirandom sequences"), turned for each pixel by random
 * numbers (Cranley & Patterson 1976, doi:10.1137/0713071): fills pixel, lens and the first light
 * evenly. */
static double evenly(double turned, uint64_t n, int dimension)
{
    static const double step[6] = {0.8986537126286993, 0.8075784952213448, 0.7257324129541098,
                                   0.6521813758735186, 0.5860842155744211, 0.5266857563519894};
    double place = turned + (double)n * step[dimension];
    return place - (double)(int64_t)place; /* floor() is a call */
}

/* A pinhole has no need of a place on a lens: its pixel's random numbers for that are left. */
static bool has_lens(const struct path *path)
{
    return path->renderer->camera->type != RMAP_CAMERA_PINHOLE;
}

static void draw_camera(struct path *path, double u[4])
{
    double turned[4];
    rmap_rng(path->walk.draw.seed, path->pixel, 0, RMAP_RNG_CAMERA, turned);
    path->left[0] = turned[2];
    path->left[1] = turned[3];
    for (int k = 0; k < (has_lens(path) ? 4 : 2); k++)
        u[k] = evenly(turned[k], path->sample, k);
}

static void draw_light(const struct path *path, int draw, double u[4])
{
    const struct rmap_draw *at = &path->walk.draw;
    uint32_t which = (uint32_t)draw << 28; /* above every step that a path can have */
    double turned[4] = {path->left[0], path->left[1]};
    if (path->lit_once || path->renderer->lights->four_numbers)
        rmap_rng(at->seed, at->ray, at->step | which, RMAP_RNG_LIGHT, u);
    if (path->lit_once)
        return;
    if (draw > 0 || has_lens(path))
        rmap_rng(at->seed, path->pixel, which, RMAP_RNG_LIGHT, turned);
    for (int k = 0; k < 2; k++)
        u[k] = evenly(turned[k], path->sample, 4 + k);
}

/* ---- light found ---- */

static double index_at(const struct rmap_scene *scene, int32_t medium, int32_t gradient,
                       struct rmap_vec3 p, int channel)
{
    double n = 0.0;
    struct rmap_vec3 slope;
    if (gradient > 0 && rmap_gradient_at(&scene->gradient[gradient - 1], channel, p, &n, &slope))
        return n;
    return scene->medium[medium].n[channel];
}

/* Of light that the path ran into after it had scattered, which few paths find: no more of it than
 * the clamp leaves. */
static void clamp(struct path *path, const double before[3])
{
    const double most = path->renderer->clamp;
    double found[3];
    if (!(most > 0.0) || !path->lit_once)
        return;
    for (int k = 0; k < 3; k++)
        found[k] = path->rgb[k] - before[k];
    const double luminance = rmap_rgb_luminance(found);
    if (!(luminance > most))
        return;
    for (int k = 0; k < 3; k++)
        path->rgb[k] = before[k] + found[k] * (most / luminance);
    path->cut += luminance - most;
}

/* Where light was found, and how much of it per channel: factor x colour, through `share`. */
struct found {
    struct rmap_vec3 at;
    int32_t medium, gradient;
    double factor;
    const double *share, *colour, *through; /* through: another factor per channel, or NULL */
};

static void add(struct path *path, const struct found *found)
{
    const struct rmap_renderer *renderer = path->renderer;
    const struct rmap_camera *camera = renderer->camera;
    const struct rmap_scene *scene = renderer->scene;
    bool same = found->medium == camera->medium && found->gradient == 0 && camera->gradient == 0;
    double factor = found->factor * path->scale;
    for (int i = path->walk.colour.begin; i < path->walk.colour.end; i++) {
        double light = factor * found->share[i] * found->colour[i];
        if (!(light > 0.0))
            continue;
        if (found->through)
            light *= found->through[i];
        if (!same) {
            double here = index_at(scene, found->medium, found->gradient, found->at, i);
            double there = index_at(scene, camera->medium, camera->gradient, camera->at, i);
            light *= there * there / (here * here);
        }
        for (int k = 0; k < 3; k++)
            path->rgb[k] += light * renderer->rgb[i][k];
    }
}

/* exp(-length (absorption + scattering)) per channel; NULL in a clear medium. */
static const double *transmittance(const struct path *path, int32_t medium, double length,
                                   double through[RMAP_CHANNEL_MAX])
{
    const struct rmap_medium *m = &path->renderer->scene->medium[medium];
    if (!m->absorbing && !m->scattering_at_all)
        return NULL;
    for (int i = path->walk.colour.begin; i < path->walk.colour.end; i++)
        through[i] = exp(-length * (m->absorption[i] + m->scattering[i]));
    return through;
}

/* ---- lights met along a segment ---- */

/* Over the channels that the path still has: a curved segment may have chosen one of them. */
static double live_sum(const struct path *path, const double *share, const double *factor)
{
    double sum = 0.0;
    for (int i = path->walk.colour.begin; i < path->walk.colour.end; i++)
        sum += share[i] * factor[i];
    return sum;
}

/* On from `point`, straight to `to`. A path that got so far has been weighed for it (analog): its
 * shares there are those it began with, times the transmittance, over their sum. */
static void search_near(struct path *path, struct rmap_vec3 to)
{
    const double touch = 1e-9; /* a lamp may lie in the very plane of a surface */
    const struct rmap_lights *lights = path->renderer->lights;
    const struct rmap_ray *ray = &path->walk.ray;
    struct rmap_vec3 way = rmap_sub(to, path->point);
    double length = rmap_length(way), distance, store[RMAP_CHANNEL_MAX];
    if (!(length > 0.0))
        return;
    struct rmap_way rest = {.from = path->point,
                            .direction = rmap_scale(way, 1.0 / length),
                            .length = length * (1.0 + touch)};
    for (size_t l = 0; l < lights->n_area; l++) {
        const struct rmap_light *light = &lights->light[l];
        for (rest.after = 0.0; rmap_light_met(lights, light, &rest, &distance);
             rest.after = distance) {
            struct found found = {.at = rmap_axpy(distance, rest.direction, rest.from),
                                  .medium = ray->medium,
                                  .gradient = ray->gradient,
                                  .factor = rmap_light_radiance(lights, light, rest.direction),
                                  .share = path->walk.colour.share,
                                  .colour = light->source->colour};
            found.through = transmittance(path, ray->medium, path->done + distance, store);
            if (found.through) {
                found.share = path->before.share;
                found.factor /= live_sum(path, path->before.share, store);
            }
            const double before[3] = {path->rgb[0], path->rgb[1], path->rgb[2]};
            add(path, &found);
            clamp(path, before);
            path->sees_light = path->sees_light || !path->lit_once;
        }
    }
    path->done += length;
    path->point = to;
}

/* Mostly there is no lamp near. */
static inline void search(struct path *path, const struct rmap_vec3 *to)
{
    const struct rmap_walk *walk = &path->walk;
    if (rmap_lights_aside(path->renderer->lights, path->point, *to) &&
        !rmap_medium_participates(&walk->scene->medium[walk->ray.medium]))
        path->point = *to;
    else
        search_near(path, *to);
}

static void keep_point(struct rmap_recorder *self, const struct rmap_curve_point *point)
{
    search((struct path *)self, &point->position);
}

static void keep_nothing(struct rmap_recorder *self, const struct rmap_registration *registration)
{
    (void)self;
    (void)registration;
}

/* ---- lights looked at ---- */

/* Where light scatters. Through `normal` (towards the side that is lit) by Lambert's law with
 * albedo `p`, or by the model of `side`; or about `direction` inside a medium. */
struct receiver {
    struct rmap_ray ray;        /* without its direction */
    struct rmap_vec3 direction; /* of the path, on arrival */
    bool inside;
    struct rmap_vec3 normal;
    const double *p;
    bool has_model;                /* or, inside, a phase function that differs between channels */
    struct rmap_scatter_side side; /* that the light meets */
    double factor;
};

static const struct rmap_medium *medium_of(const struct path *path, const struct receiver *receiver)
{
    return &path->renderer->scene->medium[receiver->ray.medium];
}

/* Radiance sent back along the path per irradiance from `light`. */
static double response(const struct path *path, const struct receiver *receiver,
                       struct rmap_vec3 light)
{
    double cosine = rmap_dot(light, receiver->normal);
    if (!receiver->inside)
        return cosine > 0.0
                   ? receiver->factor * cosine * (receiver->has_model ? 1.0 : 1.0 / RMAP_PI)
                   : 0.0;
    return receiver->has_model
               ? receiver->factor
               : rmap_phase_density(medium_of(path, receiver), path->walk.colour.begin,
                                    rmap_dot(light, receiver->direction));
}

/* BSDF, or phase function, of live channels from `light` to where the path came from; NULL: nothing
 * on any of them. */
static const double *towards_path(const struct path *path, struct receiver *receiver,
                                  struct rmap_vec3 light, double bsdf[RMAP_CHANNEL_MAX])
{
    bool some = false;
    for (int i = path->walk.colour.begin; i < path->walk.colour.end; i++) {
        if (receiver->inside) {
            bsdf[i] = rmap_phase_density(medium_of(path, receiver), i,
                                         rmap_dot(light, receiver->direction));
            some = some || bsdf[i] > 0.0;
            continue;
        }
        rmap_walk_side_on_channel(i, &receiver->side);
        bsdf[i] = rmap_scatter_bsdf(&receiver->side, rmap_scale(light, -1.0),
                                    rmap_scale(receiver->direction, -1.0));
        some = some || bsdf[i] > 0.0;
    }
    return some ? bsdf : NULL;
}

static bool unhindered(struct path *path, const struct rmap_ray *ray, double distance)
{
    const double touch = 1e-9; /* as in search() */
    struct rmap_hit hit;
    path->counts->n_look++;
    return !rmap_accel_next(path->renderer->accel, ray, &hit) || hit.t >= distance * (1.0 - touch);
}

static void look(struct path *path, struct receiver *receiver)
{
    const struct rmap_lights *lights = path->renderer->lights;
    struct rmap_light_sample sample;
    double u[4] = {0.0}, store[RMAP_CHANNEL_MAX], bsdf[RMAP_CHANNEL_MAX];
    for (int draw = 0; draw < rmap_lights_n_draw(lights); draw++) {
        draw_light(path, draw, u);
        if (!rmap_lights_draw(lights, draw, receiver->ray.origin, u, &sample))
            continue;
        double part = response(path, receiver, sample.direction);
        receiver->ray.direction = sample.direction;
        if (part > 0.0 && receiver->has_model &&
            !(receiver->p = towards_path(path, receiver, sample.direction, bsdf)))
            continue;
        if (!(part > 0.0) || !unhindered(path, &receiver->ray, sample.distance))
            continue;
        const double *through = transmittance(path, receiver->ray.medium, sample.distance, store);
        if (through && receiver->p)
            for (int i = path->walk.colour.begin; i < path->walk.colour.end; i++)
                store[i] *= receiver->p[i];
        add(path, &(struct found){.at = receiver->ray.origin,
                                  .medium = receiver->ray.medium,
                                  .factor = sample.irradiance * part,
                                  .share = path->walk.colour.share,
                                  .colour = sample.colour,
                                  .through = through ? through : receiver->p});
    }
    path->lit_once = true;
}

static double index_square_ratio(const struct path *path, int32_t far)
{
    const struct rmap_scene *scene = path->renderer->scene;
    int channel = path->walk.colour.begin;
    double near_n = scene->medium[path->walk.ray.medium].n[channel];
    double far_n = scene->medium[far].n[channel];
    return far_n * far_n / (near_n * near_n);
}

/* Light that arrives at the surface is looked for whatever becomes of the path: what is expected
 * of its diffuse outcomes has less variance than those of them that happen. */
static void look_from_surface(struct path *path, const struct rmap_arrival *arrival)
{
    const struct rmap_scene *scene = path->renderer->scene;
    const struct rmap_hit *hit = &arrival->hit;
    const struct rmap_object *object = &scene->object[hit->object];
    bool front = rmap_dot(arrival->segment.direction, hit->normal) < 0.0;
    int32_t index = front ? object->surface_front : object->surface_back;
    int32_t far = front ? object->medium_back : object->medium_front;
    if (!path->renderer->scatters[index])
        return;
    const struct rmap_surface *surface = &scene->surface[index];
    struct receiver receiver = {.ray = path->walk.ray, .factor = 1.0};
    struct rmap_vec3 normal = front ? hit->normal : rmap_scale(hit->normal, -1.0);
    receiver.ray.origin = hit->position;
    receiver.direction = arrival->segment.direction;
    if (receiver.ray.gradient == 0) {
        receiver.normal = normal;
        receiver.p = surface->reflect_diffuse;
        receiver.has_model = rmap_surface_scatters(surface);
        if (receiver.has_model)
            receiver.side = rmap_walk_side_met(&path->walk, hit, front, normal);
        rmap_contact_turn(&receiver.ray.contact, hit);
        look(path, &receiver);
    }
    const bool passes = receiver.has_model
                            ? rmap_surface_scatter(scene, surface, true) != NULL
                            : strchr(rmap_surface_model[surface->type].events, 'd') != NULL;
    if (!passes || (front ? object->gradient_back : object->gradient_front) != 0)
        return;
    receiver.ray.medium = far == RMAP_MEDIUM_ANY ? path->walk.ray.medium : far;
    receiver.ray.gradient = 0;
    receiver.ray.contact = path->walk.ray.contact;
    receiver.normal = rmap_scale(normal, -1.0);
    receiver.p = surface->transmit_diffuse;
    receiver.has_model = rmap_surface_scatters(surface);
    if (receiver.has_model)
        receiver.side = rmap_walk_side_met(&path->walk, hit, !front, receiver.normal);
    receiver.factor = index_square_ratio(path, receiver.ray.medium);
    rmap_contact_pass(&receiver.ray.contact, hit);
    look(path, &receiver);
}

/* ---- the path ---- */

static const uint32_t diffuse = RMAP_EVENT_REFLECT_DIFFUSE | RMAP_EVENT_TRANSMIT_DIFFUSE;

/* True when the path goes on. */
static bool meet_surface(struct path *path, const struct rmap_arrival *arrival)
{
    struct rmap_walk *walk = &path->walk;
    struct rmap_decision decision;
    struct rmap_anywhere any;
    if (rmap_walk_limited(walk)) {
        path->counts->n_limit++;
        return false;
    }
    const bool front = rmap_dot(arrival->segment.direction, arrival->hit.normal) < 0.0;
    rmap_anywhere_find(walk, &arrival->hit, front, &any);
    if (!rmap_anywhere_go(walk, arrival, front, &any, &decision))
        rmap_interact(walk->scene, &walk->ray, &arrival->hit, &walk->colour, &walk->draw,
                      &decision);
    if (decision.events & RMAP_EVENT_ERROR) {
        path->counts->n_error++;
        return false;
    }
    look_from_surface(path, arrival);
    if (decision.events & RMAP_EVENT_ABSORB)
        return false;
    if (decision.events & RMAP_EVENT_TRANSMIT_DIFFUSE)
        path->scale *= index_square_ratio(path, decision.medium);
    if (decision.events & diffuse)
        path->scale *= rmap_anywhere_way_back(walk, &arrival->hit, arrival->segment.direction, &any,
                                              &decision);
    else
        path->scale /= 1.0 - any.share;
    rmap_walk_depart(walk, arrival, &decision);
    path->looked = (decision.events & diffuse) && !decision.sharp && walk->ray.gradient == 0;
    return true;
}

/* True: scattering goes on, until a limit. */
static bool scatter(struct path *path, const struct rmap_arrival *arrival)
{
    struct rmap_walk *walk = &path->walk;
    if (rmap_walk_limited(walk)) {
        path->counts->n_limit++;
        return false;
    }
    struct receiver receiver = {
        .ray = walk->ray, .direction = walk->ray.direction, .inside = true, .factor = 1.0};
    receiver.has_model = medium_of(path, &receiver)->phase.n_profile > 1;
    receiver.ray.origin = arrival->segment.to;
    rmap_contact_clear(&receiver.ray.contact);
    path->looked = walk->ray.gradient == 0;
    if (path->looked)
        look(path, &receiver);
    rmap_walk_scatter(walk, arrival);
    return true;
}

/* Skies, unless they were looked at from where the segment begins. */
static void see_skies(struct path *path)
{
    const struct rmap_walk *walk = &path->walk;
    const struct rmap_lights *lights = path->renderer->lights;
    double colour[RMAP_CHANNEL_MAX];
    for (size_t l = 0; l < lights->n && lights->n_sky > 0 && !path->looked; l++) {
        const struct rmap_source *source = lights->light[l].source;
        const double before[3] = {path->rgb[0], path->rgb[1], path->rgb[2]};
        const double seen = source->sky ? rmap_sky_seen(source, walk->ray.direction,
                                                        walk->scene->channels.n, colour)
                                        : 0.0;
        if (!(seen > 0.0))
            continue;
        add(path, &(struct found){.at = path->point,
                                  .medium = walk->ray.medium,
                                  .gradient = walk->ray.gradient,
                                  .factor = seen,
                                  .share = walk->colour.share,
                                  .colour = colour});
        clamp(path, before);
    }
}

static void see_background(struct path *path)
{
    const struct rmap_walk *walk = &path->walk;
    add(path, &(struct found){.at = path->point,
                              .medium = walk->ray.medium,
                              .gradient = walk->ray.gradient,
                              .factor = 1.0,
                              .share = walk->colour.share,
                              .colour = walk->scene->background});
}

/* One segment; true when the path goes on. */
static bool advance(struct path *path)
{
    struct rmap_walk *walk = &path->walk;
    struct rmap_arrival arrival;
    const struct rmap_medium *medium = &walk->scene->medium[walk->ray.medium];
    const struct rmap_lights *lights = path->renderer->lights;
    size_t n_near = walk->ray.gradient > 0 ? lights->n_bent : lights->n_area;
    bool seek = !path->looked && n_near > 0;
    bool weighed = seek && (medium->absorbing || medium->scattering_at_all);
    if (weighed)
        path->before = walk->colour;
    path->point = walk->ray.origin;
    path->done = 0.0;
    walk->recorder = seek && walk->ray.gradient > 0 ? &path->base : NULL;
    rmap_walk_segment(walk, &arrival);
    path->counts->n_segment++;
    if (seek)
        search(path, &arrival.segment.to);
    switch (arrival.end) {
    case RMAP_SEGMENT_SURFACE:
        return meet_surface(path, &arrival);
    case RMAP_SEGMENT_LEFT:
        see_background(path);
        see_skies(path);
        return false;
    case RMAP_SEGMENT_LIMIT:
        path->counts->n_limit++;
        return false;
    case RMAP_SEGMENT_ABSORBED:
    case RMAP_SEGMENT_REEMITTED: /* at which wavelength it came is not known on the way back */
        return false;
    case RMAP_SEGMENT_SCATTERED:
        return scatter(path, &arrival);
    case RMAP_SEGMENT_ERROR:
        break;
    }
    path->counts->n_error++;
    return false;
}

void rmap_render_sample(const struct rmap_renderer *renderer, uint32_t x, uint32_t y,
                        uint64_t sample, struct rmap_render_counts *counts, double rgb[5])
{
    struct rmap_tracer tracer = {renderer->scene, renderer->accel, renderer->seed};
    struct path path;
    double u[4];
    uint64_t n_pixel = (uint64_t)renderer->size[0] * renderer->size[1];
    path.base = (struct rmap_recorder){.curve = keep_point, .registration = keep_nothing};
    path.renderer = renderer;
    path.counts = counts;
    path.pixel = (uint64_t)y * renderer->size[0] + x;
    path.sample = sample;
    path.rgb[0] = path.rgb[1] = path.rgb[2] = path.cut = 0.0;
    path.scale = 1.0;
    path.looked = path.lit_once = path.sees_light = false;
    rmap_walk_begin(&path.walk, &tracer, sample * n_pixel + path.pixel, NULL);
    draw_camera(&path, u);
    rmap_camera_ray(renderer->camera, renderer->size, x, y, u, &path.walk.ray);
    path.walk.rough = true;
    rmap_colour_set(&path.walk.colour, renderer->share, renderer->scene->channels.n);
    counts->n_path++;
    while (advance(&path))
        continue;
    for (int k = 0; k < 3; k++)
        rgb[k] = path.rgb[k];
    rgb[3] = path.sees_light;
    rgb[4] = path.cut;
}

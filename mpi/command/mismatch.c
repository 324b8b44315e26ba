/* SPDX-License-Identifier: MIT
 *
 * Rays that end in an error tell of media that do not fit: a surface whose near side is not the
 * medium that the light is in.
 */
#include "mpi/command/mismatch.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "mpi/parallel/progress.h"

enum { PAIR_MAX = 256, CROSSING_MAX = 64 };

/* Remembers the last two places of a ray's history. */
struct watcher {
    struct rmap_recorder base;
    int32_t source;
    int32_t left_object; /* -1: the source */
    int32_t met_object;  /* -1: none */
    int32_t medium;      /* of the last segment */
    bool from_front;
    struct rmap_vec3 direction; /* of the last segment */
    struct rmap_hit hit;        /* its end */
    enum rmap_stop stop;
    bool met_any;     /* an object, or a detector that registered it */
    uint8_t *reached; /* [detectors] are marked, or NULL */
};

/* Rays of a source, and those that met nothing. */
struct sent {
    uint64_t n, missed;
};

/* Rays that ended inside a gradient medium. */
struct ends {
    uint64_t left, error;
    struct rmap_vec3 first_error; /* where */
};

/* Pairs (surface left, surface met) that were told; a source counts as -1 - its index. */
struct probe {
    const struct rmap_tracer *tracer;
    struct rmap_diagnostics *diagnostics;
    struct ends *ends; /* [media] */
    struct sent *sent; /* [sources] */
    uint8_t *reached;  /* [detectors] */
    size_t n;
    struct pair {
        int32_t left, met;
    } seen[PAIR_MAX];
};

static void watch_emit(struct rmap_recorder *base, const struct rmap_emission *emission)
{
    struct watcher *self = (struct watcher *)base;
    self->source = emission->source;
    self->left_object = -1;
    self->met_object = emission->object;
}

static void watch_step(struct rmap_recorder *base, const struct rmap_step *step)
{
    struct watcher *self = (struct watcher *)base;
    self->left_object = self->met_object;
    self->met_object = step->object;
    self->met_any = self->met_any || step->object >= 0;
    self->medium = step->medium;
    self->from_front = rmap_dot(step->direction, step->normal) < 0.0;
    self->direction = step->direction;
    self->hit = (struct rmap_hit){.t = step->length,
                                  .position = step->position,
                                  .normal = step->normal,
                                  .object = step->object,
                                  .primitive = step->primitive};
}

static void watch_registration(struct rmap_recorder *base,
                               const struct rmap_registration *registration)
{
    struct watcher *self = (struct watcher *)base;
    self->met_any = self->met_any || registration->registered;
    if (self->reached && registration->registered)
        self->reached[registration->detector] = 1;
}

static void watch_end(struct rmap_recorder *base, const struct rmap_ending *ending)
{
    ((struct watcher *)base)->stop = ending->stop;
}

static struct watcher watch(const struct rmap_tracer *tracer, uint64_t ray, uint8_t *reached)
{
    struct watcher watcher = {.base = {.emit = watch_emit,
                                       .step = watch_step,
                                       .registration = watch_registration,
                                       .end = watch_end},
                              .left_object = -1,
                              .met_object = -1,
                              .medium = -1,
                              .reached = reached};
    rmap_trace_ray(tracer, ray, &watcher.base);
    return watcher;
}

static int32_t near_medium(const struct rmap_scene *scene, const struct watcher *watcher)
{
    const struct rmap_object *met = &scene->object[watcher->met_object];
    return watcher->from_front ? met->medium_front : met->medium_back;
}

static int32_t far_medium(const struct rmap_object *met, const struct watcher *watcher)
{
    return watcher->from_front ? met->medium_back : met->medium_front;
}

static bool is_mismatch(const struct rmap_scene *scene, const struct watcher *watcher)
{
    if (watcher->stop != RMAP_STOP_ERROR || watcher->met_object < 0 || watcher->medium < 0)
        return false;
    int32_t medium = near_medium(scene, watcher);
    return medium != RMAP_MEDIUM_ANY && medium != watcher->medium;
}

/* On the way, not at a surface whose media do not match. */
static bool ended_in_gradient(const struct rmap_scene *scene, const struct watcher *watcher)
{
    return watcher->medium >= 0 && scene->medium[watcher->medium].field &&
           !is_mismatch(scene, watcher);
}

static void describe(const struct rmap_scene *scene, const struct watcher *watcher, char *text,
                     size_t text_nbytes)
{
    const struct rmap_object *met =
        watcher->met_object >= 0 ? &scene->object[watcher->met_object] : NULL;
    bool from_source = watcher->left_object < 0;
    const char *left = from_source ? scene->source[watcher->source].name
                                   : scene->object[watcher->left_object].name;
    if (ended_in_gradient(scene, watcher) && watcher->stop == RMAP_STOP_ERROR) {
        struct rmap_vec3 p = watcher->hit.position;
        (void)snprintf(text, text_nbytes,
                       "a ray of source '%s' came to (%.6g, %.6g, %.6g) in medium '%s', which has "
                       "no index there",
                       scene->source[watcher->source].name, p.x, p.y, p.z,
                       scene->medium[watcher->medium].name);
        return;
    }
    int32_t beyond = met ? far_medium(met, watcher) : -1;
    if (!is_mismatch(scene, watcher) && beyond >= 0 && scene->medium[beyond].field) {
        struct rmap_vec3 p = watcher->hit.position;
        (void)snprintf(text, text_nbytes,
                       "a ray of source '%s' could not go on at '%s': medium '%s' behind it has no "
                       "index at (%.6g, %.6g, %.6g)",
                       scene->source[watcher->source].name, met->name, scene->medium[beyond].name,
                       p.x, p.y, p.z);
        return;
    }
    if (!is_mismatch(scene, watcher)) {
        (void)snprintf(text, text_nbytes, "a ray of source '%s' could not go on%s%s%s",
                       scene->source[watcher->source].name, met ? " at '" : "",
                       met ? met->name : "", met ? "'" : "");
        return;
    }
    (void)snprintf(text, text_nbytes,
                   "a ray leaves '%s' in '%s' but meets '%s', whose near side (%s) is '%s'; state "
                   "the media (front and back, or inside and outside%s) so that they match",
                   left, scene->medium[watcher->medium].name, met->name,
                   watcher->from_front ? "front" : "back",
                   scene->medium[near_medium(scene, watcher)].name,
                   from_source ? ", and the source's medium" : "");
}

static void tell(struct probe *probe, const struct watcher *watcher)
{
    struct pair pair = {watcher->left_object, watcher->met_object};
    if (pair.left < 0)
        pair.left = -1 - watcher->source;
    size_t i = 0;
    while (i < probe->n && (probe->seen[i].left != pair.left || probe->seen[i].met != pair.met))
        i++;
    if (i < probe->n || i == PAIR_MAX)
        return;
    probe->seen[probe->n++] = pair;
    const struct rmap_scene *scene = probe->tracer->scene;
    const struct rmap_object *met = &scene->object[pair.met];
    char text[RMAP_ERROR_TEXT_LEN];
    describe(scene, watcher, text, sizeof text);
    rmap_diagnostics_add(probe->diagnostics, RMAP_SEVERITY_ERROR, met->line, met->column, "%s",
                         text);
}

/* Behind a mistake the light goes straight on, in the medium that the surface names there, so
 * that what it would meet next is told in the same run. */
static bool go_on(const struct rmap_tracer *tracer, struct watcher *watcher, struct rmap_ray *ray)
{
    const struct rmap_scene *scene = tracer->scene;
    const struct rmap_object *met = &scene->object[watcher->met_object];
    int32_t surface = watcher->from_front ? met->surface_front : met->surface_back;
    ray->medium = watcher->from_front ? met->medium_back : met->medium_front;
    if (!rmap_scene_transmits(scene, surface) || ray->medium == RMAP_MEDIUM_ANY)
        return false;
    ray->origin = watcher->hit.position;
    rmap_contact_pass(&ray->contact, &watcher->hit);
    watcher->left_object = watcher->met_object;
    if (!rmap_accel_next(tracer->accel, ray, &watcher->hit))
        return false;
    watcher->met_object = watcher->hit.object;
    watcher->medium = ray->medium;
    watcher->from_front = rmap_dot(ray->direction, watcher->hit.normal) < 0.0;
    return true;
}

static void count_end(struct probe *probe, const struct watcher *watcher)
{
    const struct rmap_scene *scene = probe->tracer->scene;
    int32_t medium = watcher->medium;
    if (watcher->stop == RMAP_STOP_ERROR && !is_mismatch(scene, watcher) &&
        watcher->met_object >= 0)
        medium = far_medium(&scene->object[watcher->met_object], watcher);
    if (medium < 0 || !scene->medium[medium].field || is_mismatch(scene, watcher))
        return;
    struct ends *ends = &probe->ends[medium];
    if (watcher->stop == RMAP_STOP_LEFT)
        ends->left++;
    else if (watcher->stop == RMAP_STOP_ERROR && ends->error++ == 0)
        ends->first_error = watcher->hit.position;
}

static void tell_ends(const struct probe *probe, uint64_t n_ray)
{
    const struct rmap_scene *scene = probe->tracer->scene;
    for (size_t m = 0; m < scene->n_medium; m++) {
        const struct ends *ends = &probe->ends[m];
        const struct rmap_vec3 p = ends->first_error;
        if (ends->left)
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, 0, 0,
                "gradient medium '%s' has no closed boundary: %llu of %llu probing rays left the "
                "scene inside of it; close the body, unless the medium fills the surroundings",
                scene->medium[m].name, (unsigned long long)ends->left, (unsigned long long)n_ray);
        if (ends->error)
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, 0, 0,
                "gradient medium '%s' has no index where light comes, as at (%.6g, %.6g, %.6g): "
                "%llu of %llu probing rays end there with 'error'",
                scene->medium[m].name, p.x, p.y, p.z, (unsigned long long)ends->error,
                (unsigned long long)n_ray);
    }
}

enum { RAYS_MIN = 32 }; /* of a source: fewer tell nothing */

/* Light that goes nowhere, and detectors that none reaches. */
static void tell_lost(const struct probe *probe, uint64_t n_ray)
{
    const struct rmap_scene *scene = probe->tracer->scene;
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct sent *sent = &probe->sent[s];
        const char *name = scene->source[s].name;
        if (sent->n >= RAYS_MIN && sent->missed == sent->n)
            rmap_diagnostics_add(probe->diagnostics, RMAP_SEVERITY_WARNING, 0, 0,
                                 "source '%s' hits nothing: all of its %llu probing rays leave the "
                                 "scene without meeting an object or a detector; look at its place "
                                 "and direction",
                                 name, (unsigned long long)sent->n);
        else if (sent->n >= RAYS_MIN && 4 * sent->missed > 3 * sent->n)
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, 0, 0,
                "%.0f %% of source '%s' leaves the scene without meeting an object "
                "or a detector: a smaller shape or cone costs fewer rays",
                100.0 * (double)sent->missed / (double)sent->n, name);
    }
    for (size_t d = 0; d < scene->n_detector && n_ray >= RAYS_MIN; d++)
        if (!probe->reached[d])
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, 0, 0,
                "none of %llu probing rays is registered on detector '%s': look at "
                "its place, side and max_angle, or trace many rays",
                (unsigned long long)n_ray, scene->detector[d].name);
}

static void probe_destroy(struct probe *probe)
{
    rmap_free(probe->ends);
    rmap_free(probe->sent);
    rmap_free(probe->reached);
    rmap_free(probe);
}

enum rmap_status rmap_mismatch_probe(const struct rmap_tracer *tracer,
                                     struct rmap_mismatch_effort *effort,
                                     struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    struct probe *probe = rmap_alloc(1, sizeof *probe);
    if (!probe)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    *probe = (struct probe){.tracer = tracer, .diagnostics = diagnostics};
    probe->ends = rmap_alloc(tracer->scene->n_medium, sizeof *probe->ends);
    probe->sent = rmap_alloc(tracer->scene->n_source + 1, sizeof *probe->sent);
    probe->reached = rmap_alloc(tracer->scene->n_detector + 1, 1);
    if (!probe->ends || !probe->sent || !probe->reached) {
        probe_destroy(probe);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    }
    double until = rmap_clock_seconds() + effort->seconds;
    effort->n_sent = 0;
    effort->cut = false;
    while (effort->n_sent < effort->n_ray && probe->n < PAIR_MAX && !effort->cut) {
        struct watcher watcher = watch(tracer, effort->n_sent++, probe->reached);
        probe->sent[watcher.source].n++;
        probe->sent[watcher.source].missed += (uint64_t)!watcher.met_any;
        effort->cut = effort->n_sent < effort->n_ray && rmap_clock_seconds() > until;
        count_end(probe, &watcher);
        if (!is_mismatch(tracer->scene, &watcher))
            continue;
        tell(probe, &watcher);
        struct rmap_ray ray = {.direction = watcher.direction};
        for (int k = 0; k < CROSSING_MAX && go_on(tracer, &watcher, &ray); k++)
            if (is_mismatch(tracer->scene, &watcher))
                tell(probe, &watcher);
    }
    tell_ends(probe, effort->n_sent);
    if (probe->n == 0) /* or else rays ended early */
        tell_lost(probe, effort->n_sent);
    probe_destroy(probe);
    return RMAP_OK;
}

void rmap_mismatch_describe(const struct rmap_tracer *tracer, uint64_t ray, char *text,
                            size_t text_nbytes)
{
    struct watcher watcher = watch(tracer, ray, NULL);
    describe(tracer->scene, &watcher, text, text_nbytes);
}

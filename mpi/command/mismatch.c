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

enum { PAIR_MAX = 256, CROSSING_MAX = 64, TOUCH_MAX = 16 };

/* Surface left, surface met; a source counts as -1 - its index. */
struct pair {
    int32_t left, met;
};

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
    const struct rmap_scene *scene;
    struct pair
        touch;       /* surfaces of two bodies that both let light through and lie on each other; */
    int32_t between; /* medium there. met -1: none */
};

/* Rays of a source, and those that met nothing. */
struct sent {
    uint64_t n, missed;
};

/* Rays that ended inside a gradient medium, or left the scene in another medium than their
 * source's. */
struct ends {
    uint64_t left, error;
    int32_t last_object;          /* that one which left met last */
    struct rmap_vec3 first_error; /* where */
};

struct probe {
    const struct rmap_tracer *tracer;
    struct rmap_diagnostics *diagnostics;
    struct ends *ends; /* [media] */
    struct sent *sent; /* [sources] */
    uint8_t *reached;  /* [detectors] */
    int32_t around;    /* medium of the surroundings */
    size_t n, n_touch;
    struct pair seen[PAIR_MAX], touch[TOUCH_MAX]; /* that were told */
};

/* Of a body of several surfaces, as a lens: that. */
static const char *body_name(const struct rmap_scene *scene, int32_t object)
{
    const int32_t parent = scene->object[object].parent;
    return parent >= 0 ? scene->group[parent].name : scene->object[object].name;
}

static bool same_body(const struct rmap_scene *scene, int32_t a, int32_t b)
{
    const int32_t parent = scene->object[a].parent;
    return a == b || (parent >= 0 && parent == scene->object[b].parent);
}

static bool lets_through(const struct rmap_scene *scene, int32_t object)
{
    return rmap_scene_transmits(scene, scene->object[object].surface_front);
}

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
    if (step->length == 0.0 && step->object >= 0 && self->left_object >= 0 &&
        lets_through(self->scene, step->object) && lets_through(self->scene, self->left_object) &&
        !same_body(self->scene, step->object, self->left_object)) {
        self->touch = (struct pair){self->left_object, step->object};
        self->between = step->medium;
    }
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
                              .reached = reached,
                              .scene = tracer->scene,
                              .touch = {-1, -1}};
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

/* The light is inside a body and meets another one from outside: straight on, it comes out of the
 * body that it was in first before it leaves the other one. */
static bool is_overlap(const struct rmap_tracer *tracer, const struct watcher *watcher)
{
    const struct rmap_scene *scene = tracer->scene;
    const int32_t inside = watcher->medium, met = watcher->met_object;
    struct rmap_ray ray = {.origin = watcher->hit.position,
                           .direction = watcher->direction,
                           .medium = far_medium(&scene->object[met], watcher)};
    struct rmap_hit hit = watcher->hit;
    if (watcher->left_object < 0 || same_body(scene, watcher->left_object, met))
        return false;
    for (int k = 0; k < CROSSING_MAX; k++) {
        rmap_contact_pass(&ray.contact, &hit);
        if (!rmap_accel_next(tracer->accel, &ray, &hit))
            return false;
        const struct rmap_object *next = &scene->object[hit.object];
        const bool front = rmap_dot(ray.direction, hit.normal) < 0.0;
        const int32_t near = front ? next->medium_front : next->medium_back;
        const int32_t far = front ? next->medium_back : next->medium_front;
        if (same_body(scene, hit.object, met))
            return false;
        if (near == inside && far != inside && same_body(scene, hit.object, watcher->left_object))
            return true;
        ray.origin = hit.position;
    }
    return false;
}

static void describe(const struct rmap_tracer *tracer, const struct watcher *watcher, char *text,
                     size_t text_nbytes)
{
    const struct rmap_scene *scene = tracer->scene;
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
    if (from_source && !watcher->from_front) {
        const char *near = scene->medium[near_medium(scene, watcher)].name;
        (void)snprintf(
            text, text_nbytes,
            "source '%s' stands inside '%s', in '%s', but its light starts in '%s'; give "
            "the source 'medium: %s'",
            left, body_name(scene, watcher->met_object), near, scene->medium[watcher->medium].name,
            near);
        return;
    }
    if (is_overlap(tracer, watcher)) {
        const struct rmap_vec3 p = watcher->hit.position;
        (void)snprintf(
            text, text_nbytes,
            "bodies '%s' and '%s' overlap, as at (%.6g, %.6g, %.6g): light inside '%s' "
            "meets the outside of '%s' there; move one of them, or cut it to the face of "
            "the other (faces may coincide)",
            body_name(scene, watcher->left_object), body_name(scene, watcher->met_object), p.x, p.y,
            p.z, body_name(scene, watcher->left_object), body_name(scene, watcher->met_object));
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

/* The same mistake as one that was told: of a pair, or of its like on the way back. */
static bool is_told(const struct rmap_scene *scene, const struct pair *told,
                    const struct pair *pair)
{
    return (told->left == pair->left && told->met == pair->met) ||
           (told->left >= 0 && pair->left >= 0 && same_body(scene, told->left, pair->met) &&
            same_body(scene, told->met, pair->left));
}

static void tell(struct probe *probe, const struct watcher *watcher)
{
    struct pair pair = {watcher->left_object, watcher->met_object};
    if (pair.left < 0)
        pair.left = -1 - watcher->source;
    size_t i = 0;
    while (i < probe->n && !is_told(probe->tracer->scene, &probe->seen[i], &pair))
        i++;
    if (i < probe->n || i == PAIR_MAX)
        return;
    probe->seen[probe->n++] = pair;
    const struct rmap_scene *scene = probe->tracer->scene;
    const struct rmap_object *met = &scene->object[pair.met];
    char text[RMAP_ERROR_TEXT_LEN];
    describe(probe->tracer, watcher, text, sizeof text);
    rmap_diagnostics_add(probe->diagnostics, RMAP_SEVERITY_ERROR, met->line, met->column, "%s",
                         text);
}

/* Another opaque surface where the ray was absorbed: -1: none. */
static int32_t find_behind(const struct rmap_tracer *tracer, const struct watcher *watcher)
{
    struct rmap_ray ray = {.origin = watcher->hit.position,
                           .direction = watcher->direction,
                           .medium = watcher->medium};
    struct rmap_hit hit = watcher->hit;
    if (watcher->stop != RMAP_STOP_ABSORBED || watcher->met_object < 0)
        return -1;
    rmap_contact_pass(&ray.contact, &hit);
    if (!rmap_accel_next(tracer->accel, &ray, &hit) || hit.t != 0.0 ||
        lets_through(tracer->scene, hit.object) ||
        same_body(tracer->scene, hit.object, watcher->met_object))
        return -1;
    return hit.object;
}

static bool is_new_touch(struct probe *probe, struct pair pair)
{
    size_t i = 0;
    while (i < probe->n_touch && !is_told(probe->tracer->scene, &probe->touch[i], &pair))
        i++;
    if (i == TOUCH_MAX || i < probe->n_touch)
        return false;
    probe->touch[probe->n_touch++] = pair;
    return true;
}

/* Surfaces that lie on each other, where that leaves open what happens there. */
static void tell_touches(struct probe *probe, const struct watcher *watcher)
{
    const struct rmap_scene *scene = probe->tracer->scene;
    const struct pair gap = watcher->touch;
    const struct pair opaque = {watcher->met_object, find_behind(probe->tracer, watcher)};
    const struct rmap_vec3 p = watcher->hit.position;
    if (gap.met >= 0 && is_new_touch(probe, gap))
        rmap_diagnostics_add(
            probe->diagnostics, RMAP_SEVERITY_WARNING, scene->object[gap.met].line,
            scene->object[gap.met].column,
            "'%s' and '%s' touch with '%s' between them, where light is reflected at both as in a "
            "gap of no thickness; for cemented parts write one 'lens' of three surfaces, or take "
            "one "
            "of the two faces away",
            body_name(scene, gap.left), body_name(scene, gap.met),
            scene->medium[watcher->between].name);
    if (opaque.met >= 0 && is_new_touch(probe, opaque))
        rmap_diagnostics_add(
            probe->diagnostics, RMAP_SEVERITY_WARNING, scene->object[opaque.left].line,
            scene->object[opaque.left].column,
            "'%s' and '%s' lie on each other, as at (%.6g, %.6g, %.6g), and the scene does not say "
            "which of them light meets; take one away, or move it a little",
            body_name(scene, opaque.left), body_name(scene, opaque.met), p.x, p.y, p.z);
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
    if (medium < 0 || is_mismatch(scene, watcher))
        return;
    struct ends *ends = &probe->ends[medium];
    if (watcher->stop == RMAP_STOP_LEFT && watcher->left_object >= 0 &&
        medium != scene->source[watcher->source].medium && medium != probe->around)
        ends->last_object = watcher->left_object;
    else if (!scene->medium[medium].field)
        return;
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
        const struct rmap_object *last = &scene->object[ends->last_object];
        if (ends->left && !scene->medium[m].field)
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, last->line, last->column,
                "%llu of %llu probing rays leave the scene inside a body, in '%s' behind '%s': "
                "close "
                "it there, as with an edge, unless that medium fills the surroundings",
                (unsigned long long)ends->left, (unsigned long long)n_ray, scene->medium[m].name,
                last->name);
        else if (ends->left)
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
    const bool for_pictures = scene->n_camera > 0 && scene->n_detector == 0;
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct sent *sent = &probe->sent[s];
        const struct rmap_source *source = &scene->source[s];
        if (sent->n >= RAYS_MIN && sent->missed == sent->n)
            rmap_diagnostics_add(probe->diagnostics, RMAP_SEVERITY_WARNING, source->line,
                                 source->column,
                                 "source '%s' hits nothing: all of its %llu probing rays leave the "
                                 "scene without meeting an object or a detector; look at its place "
                                 "and direction",
                                 source->name, (unsigned long long)sent->n);
        else if (sent->n >= RAYS_MIN && 2 * sent->missed > sent->n && !for_pictures)
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, source->line, source->column,
                "%.0f %% of source '%s' leaves the scene without meeting an object "
                "or a detector: a smaller shape or cone costs fewer rays",
                100.0 * (double)sent->missed / (double)sent->n, source->name);
    }
    for (size_t d = 0; d < scene->n_detector && n_ray >= RAYS_MIN; d++)
        if (!probe->reached[d])
            rmap_diagnostics_add(
                probe->diagnostics, RMAP_SEVERITY_WARNING, scene->detector[d].line,
                scene->detector[d].column,
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
    *probe = (struct probe){.tracer = tracer,
                            .diagnostics = diagnostics,
                            .around = rmap_scene_surrounding_medium(tracer->scene)};
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
        tell_touches(probe, &watcher);
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
    describe(tracer, &watcher, text, text_nbytes);
}

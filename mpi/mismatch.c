/* SPDX-License-Identifier: MIT */
#include "mpi/mismatch.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"

enum { PAIR_MAX = 256 };

/* Remembers the last two places of a ray's history. */
struct watcher {
    struct rmap_recorder base;
    int32_t source;
    int32_t left_object; /* -1: the source */
    int32_t met_object;  /* -1: none */
    int32_t medium;      /* of the last leg */
    bool from_front;
    enum rmap_stop stop;
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
    self->medium = step->medium;
    self->from_front = rmap_dot(step->direction, step->normal) < 0.0;
}

static void watch_registration(struct rmap_recorder *base,
                               const struct rmap_registration *registration)
{
    (void)base;
    (void)registration;
}

static void watch_end(struct rmap_recorder *base, const struct rmap_ending *ending)
{
    ((struct watcher *)base)->stop = ending->stop;
}

static struct watcher watch(const struct rmap_tracer *tracer, uint64_t ray)
{
    struct watcher watcher = {.base = {watch_emit, watch_step, watch_registration, watch_end},
                              .left_object = -1,
                              .met_object = -1,
                              .medium = -1};
    rmap_trace_ray(tracer, ray, &watcher.base);
    return watcher;
}

static int32_t near_medium(const struct rmap_scene *scene, const struct watcher *watcher)
{
    const struct rmap_object *met = &scene->object[watcher->met_object];
    return watcher->from_front ? met->medium_front : met->medium_back;
}

static bool is_mismatch(const struct rmap_scene *scene, const struct watcher *watcher)
{
    if (watcher->stop != RMAP_STOP_ERROR || watcher->met_object < 0 || watcher->medium < 0)
        return false;
    int32_t medium = near_medium(scene, watcher);
    return medium != RMAP_MEDIUM_ANY && medium != watcher->medium;
}

static void describe(const struct rmap_scene *scene, const struct watcher *watcher, char *text,
                     size_t text_nbytes)
{
    const struct rmap_object *met =
        watcher->met_object >= 0 ? &scene->object[watcher->met_object] : NULL;
    bool from_source = watcher->left_object < 0;
    const char *left = from_source ? scene->source[watcher->source].name
                                   : scene->object[watcher->left_object].name;
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

enum rmap_status rmap_mismatch_probe(const struct rmap_tracer *tracer, uint64_t n_ray,
                                     struct rmap_diagnostics *diagnostics, struct rmap_error *err)
{
    const struct rmap_scene *scene = tracer->scene;
    struct pair {
        int32_t left, met;
    } *seen = rmap_alloc(PAIR_MAX, sizeof *seen);
    if (!seen)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    size_t n = 0;
    for (uint64_t ray = 0; ray < n_ray && n < PAIR_MAX; ray++) {
        struct watcher watcher = watch(tracer, ray);
        if (!is_mismatch(scene, &watcher))
            continue;
        struct pair pair = {watcher.left_object, watcher.met_object};
        if (pair.left < 0)
            pair.left = -1 - watcher.source;
        size_t i = 0;
        while (i < n && (seen[i].left != pair.left || seen[i].met != pair.met))
            i++;
        if (i < n)
            continue;
        seen[n++] = pair;
        char text[RMAP_ERROR_TEXT_LEN];
        describe(scene, &watcher, text, sizeof text);
        rmap_diagnostics_add(diagnostics, RMAP_SEVERITY_ERROR, scene->object[pair.met].line, 1,
                             "%s", text);
    }
    rmap_free(seen);
    return RMAP_OK;
}

void rmap_mismatch_describe(const struct rmap_tracer *tracer, uint64_t ray, char *text,
                            size_t text_nbytes)
{
    struct watcher watcher = watch(tracer, ray);
    describe(tracer->scene, &watcher, text, text_nbytes);
}

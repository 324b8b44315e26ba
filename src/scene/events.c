/* SPDX-License-Identifier: MIT
 *
 * Which event a ray is of.
 */
#include "scene/events.h"

#include <stdlib.h>

#include "base/alloc.h"

static bool numbers_events(const struct rmap_source *source)
{
    return source->steps || (source->rays && source->rays->event);
}

bool rmap_scene_has_events(const struct rmap_scene *scene)
{
    bool any = false;
    for (size_t s = 0; s < scene->n_source; s++)
        any = any || numbers_events(&scene->source[s]);
    return any;
}

const char *rmap_scene_events_trouble(const struct rmap_scene *scene)
{
    bool steps = false;
    for (size_t s = 0; s < scene->n_source; s++)
        steps = steps || scene->source[s].steps;
    if (!rmap_scene_has_events(scene))
        return "no source of this map numbers events: sources of type steps do, and of type "
               "ray_file whose file has a column 'event'";
    return steps && scene->is_mixed
               ? "parts of this map were traced in other wavelengths: the events of steps can be "
                 "asked of maps that have the same ones throughout"
               : NULL;
}

bool rmap_scene_event(const struct rmap_scene *scene, uint64_t ray, uint64_t *event_ret)
{
    uint64_t ordinal = 0;
    const struct rmap_source *source = &scene->source[rmap_scene_source_of(scene, ray, &ordinal)];
    if (!numbers_events(source))
        return false;
    *event_ret = source->steps ? rmap_scene_track_step(scene, scene->seed, ray)->event
                               : source->rays->event[rmap_file_rays_row(source->rays, ordinal)];
    return *event_ret != RMAP_NO_EVENT;
}

static int compare(const void *a, const void *b)
{
    const uint64_t x = *(const uint64_t *)a, y = *(const uint64_t *)b;
    return (x > y) - (x < y);
}

enum rmap_status rmap_scene_events(const struct rmap_scene *scene, uint64_t **event_ret,
                                   size_t *n_ret, struct rmap_error *err)
{
    size_t n = 0, n_unique = 0;
    for (size_t s = 0; s < scene->n_source; s++)
        if (numbers_events(&scene->source[s]))
            n += scene->source[s].steps ? scene->source[s].steps->n : scene->source[s].rays->n;
    uint64_t *event = rmap_alloc(n + 1, sizeof *event);
    if (!event)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the events of %zu rows", n);
    n = 0;
    for (size_t s = 0; s < scene->n_source; s++) {
        const struct rmap_source *source = &scene->source[s];
        const size_t n_row = !numbers_events(source) ? 0
                             : source->steps         ? source->steps->n
                                                     : source->rays->n;
        for (size_t i = 0; i < n_row; i++) {
            const uint64_t its =
                source->steps ? source->steps->step[i].event : source->rays->event[i];
            if (its != RMAP_NO_EVENT && (n == 0 || event[n - 1] != its))
                event[n++] = its;
        }
    }
    qsort(event, n, sizeof *event, compare);
    for (size_t i = 0; i < n; i++)
        if (i == 0 || event[i] != event[n_unique - 1])
            event[n_unique++] = event[i];
    *event_ret = event;
    *n_ret = n_unique;
    return RMAP_OK;
}

size_t rmap_event_index(const uint64_t *event, size_t n, uint64_t of)
{
    size_t low = 0, high = n;
    while (high - low > 1) {
        const size_t middle = low + (high - low) / 2;
        if (event[middle] <= of)
            low = middle;
        else
            high = middle;
    }
    return low;
}

/* First step whose event is `event` or a later one. */
static size_t first_step(const struct rmap_steps *steps, uint64_t event)
{
    size_t low = 0, high = steps->n;
    while (low < high) {
        const size_t middle = low + (high - low) / 2;
        if (steps->step[middle].event < event)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

/* Photons of the steps before it. */
static uint64_t photons_before(const struct rmap_steps *steps, size_t step)
{
    return step > 0 ? (uint64_t)steps->photons[step * RMAP_PHOTON_KINDS - 1] : 0;
}

void rmap_scene_rays_of_events(const struct rmap_scene *scene, uint64_t low, uint64_t high,
                               uint64_t *first_ret, uint64_t *last_ret)
{
    const struct rmap_steps *steps = scene->n_source == 1 ? scene->source[0].steps : NULL;
    *first_ret = 0;
    *last_ret = UINT64_MAX;
    if (!steps || !steps->counted)
        return;
    const size_t end = high < UINT64_MAX ? first_step(steps, high + 1) : steps->n;
    const uint64_t from = photons_before(steps, first_step(steps, low)),
                   to = photons_before(steps, end);
    *first_ret = from < to ? from : 1; /* 1 > 0: none */
    *last_ret = from < to ? to - 1 : 0;
}

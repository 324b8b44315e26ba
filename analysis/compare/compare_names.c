/* SPDX-License-Identifier: MIT */
#include <stdlib.h>
#include <string.h>

#include "analysis/compare/compare_internal.h"
#include "base/alloc.h"

static const char *source_name(const struct rmap_scene *scene, size_t i)
{
    return scene->source[i].name;
}

static const char *detector_name(const struct rmap_scene *scene, size_t i)
{
    return scene->detector[i].name;
}

static const char *object_name(const struct rmap_scene *scene, size_t i)
{
    return scene->object[i].name;
}

static const char *medium_name(const struct rmap_scene *scene, size_t i)
{
    return scene->medium[i].name;
}

struct rmap_names rmap_names_of_sources(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "source", scene->n_source, source_name};
}

struct rmap_names rmap_names_of_detectors(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "detector", scene->n_detector, detector_name};
}

struct rmap_names rmap_names_of_objects(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "object", scene->n_object, object_name};
}

struct rmap_names rmap_names_of_media(const struct rmap_scene *scene)
{
    return (struct rmap_names){scene, "medium", scene->n_medium, medium_name};
}

struct entry {
    const char *name;
    int32_t at;
};

static int by_name(const void *a, const void *b)
{
    return strcmp(((const struct entry *)a)->name, ((const struct entry *)b)->name);
}

enum rmap_status rmap_names_pair(const struct rmap_names *own, const struct rmap_names *other,
                                 int32_t **pair_ret, struct rmap_error *err)
{
    struct entry *entry = rmap_alloc(other->n + 1, sizeof *entry);
    int32_t *pair = rmap_alloc(own->n + 1, sizeof *pair);
    if (!entry || !pair) {
        rmap_free(entry);
        rmap_free(pair);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu names", own->n + other->n);
    }
    for (size_t i = 0; i < other->n; i++)
        entry[i] = (struct entry){other->name(other->scene, i), (int32_t)i};
    qsort(entry, other->n, sizeof *entry, by_name);
    for (size_t i = 0; i < own->n; i++) {
        const struct entry key = {own->name(own->scene, i), 0};
        const struct entry *found = bsearch(&key, entry, other->n, sizeof key, by_name);
        pair[i] = found ? found->at : -1;
    }
    rmap_free(entry);
    *pair_ret = pair;
    return RMAP_OK;
}

/* SPDX-License-Identifier: MIT
 *
 * Leaves out of a scene what does not take part, and what nothing refers to.
 */
#include <stdint.h>
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_reader.h"

/* New index of each old one; -1: left out. */
static int32_t *renumber(struct rmap_reader *reader, const bool *keep, size_t n, size_t *n_ret)
{
    int32_t *index = rmap_reader_alloc(reader, n, sizeof *index);
    *n_ret = 0;
    for (size_t i = 0; index && i < n; i++)
        index[i] = keep[i] ? (int32_t)(*n_ret)++ : -1;
    return index;
}

static void reduce_sources(struct rmap_scene *scene, const bool *keep)
{
    size_t n = 0;
    for (size_t i = 0; i < scene->n_source; i++) {
        if (keep[i])
            scene->source[n++] = scene->source[i];
        else
            rmap_source_fini(&scene->source[i]);
    }
    scene->n_source = n;
}

static void reduce_objects(struct rmap_scene *scene, const bool *keep)
{
    size_t n = 0;
    for (size_t i = 0; i < scene->n_object; i++) {
        if (keep[i])
            scene->object[n++] = scene->object[i];
        else
            rmap_free(scene->object[i].name);
    }
    scene->n_object = n;
}

/* A group stays while anything stands in it. Objects are reduced already. */
static void reduce_groups(struct rmap_reader *reader, int32_t **index_ret)
{
    struct rmap_scene *scene = reader->scene;
    bool *keep = rmap_reader_alloc(reader, scene->n_group, sizeof *keep);
    size_t n = 0;
    if (!keep)
        return;
    for (size_t i = 0; i < scene->n_object; i++)
        for (int32_t g = scene->object[i].parent; g >= 0 && !keep[g]; g = scene->group[g].parent)
            keep[g] = true;
    for (size_t i = 0; i < scene->n_source; i++)
        for (int32_t g = scene->source[i].parent; g >= 0 && !keep[g]; g = scene->group[g].parent)
            keep[g] = true;
    int32_t *index = renumber(reader, keep, scene->n_group, &n);
    for (size_t i = 0; index && i < scene->n_group; i++) {
        struct rmap_group group = scene->group[i];
        if (!keep[i]) {
            rmap_free(group.name);
            continue;
        }
        group.parent = group.parent >= 0 ? index[group.parent] : -1;
        scene->group[index[i]] = group;
    }
    if (!index)
        return;
    for (size_t i = 0; i < scene->n_object; i++)
        if (scene->object[i].parent >= 0)
            scene->object[i].parent = index[scene->object[i].parent];
    for (size_t i = 0; i < scene->n_source; i++)
        if (scene->source[i].parent >= 0)
            scene->source[i].parent = index[scene->source[i].parent];
    scene->n_group = n;
    *index_ret = index;
}

/* A detector goes with what it lies on. */
static void reduce_detectors(struct rmap_reader *reader, const bool *keep, const int32_t *object,
                             const int32_t *group)
{
    struct rmap_scene *scene = reader->scene;
    size_t n = 0;
    for (size_t i = 0; i < scene->n_detector; i++) {
        struct rmap_detector detector = scene->detector[i];
        bool lies_on = rmap_detector_lies_on(&detector);
        if (detector.on_object >= 0)
            detector.on_object = object[detector.on_object];
        if (detector.on_group >= 0)
            detector.on_group = group[detector.on_group];
        bool lost = lies_on && !rmap_detector_lies_on(&detector);
        if (lost && i >= scene->n_detector - reader->n_receiver)
            rmap_diagnostics_add(reader->receivers->diagnostics, RMAP_SEVERITY_ERROR, 0, 0,
                                 "what receiver '%.60s' lies on was left out of the trace",
                                 detector.name);
        else if (lost && keep[i])
            rmap_reader_warn(reader, NULL, "detector '%.60s' is left out with what it lies on",
                             detector.name);
        if (keep[i] && !lost) {
            scene->detector[n++] = detector;
            continue;
        }
        rmap_free(detector.name);
        rmap_free(detector.face);
        rmap_response_destroy(detector.response);
    }
    scene->n_detector = n;
}

static void move_volumes(struct rmap_scene *scene, const int32_t *object, const int32_t *group)
{
    for (size_t i = 0; i < scene->n_source; i++) {
        struct rmap_volume *volume = scene->source[i].volume;
        if (volume && volume->on_object >= 0)
            volume->on_object = object[volume->on_object];
        if (volume && volume->on_group >= 0)
            volume->on_group = group[volume->on_group];
    }
}

static void reduce_geometries(struct rmap_reader *reader)
{
    struct rmap_scene *scene = reader->scene;
    bool *keep = rmap_reader_alloc(reader, scene->n_geometry, sizeof *keep);
    size_t n = 0;
    if (!keep)
        return;
    for (size_t i = 0; i < scene->n_object; i++)
        keep[scene->object[i].geometry] = true;
    for (size_t i = 0; i < scene->n_source; i++)
        if (scene->source[i].shape_geometry >= 0)
            keep[scene->source[i].shape_geometry] = true;
    int32_t *index = renumber(reader, keep, scene->n_geometry, &n);
    for (size_t i = 0; index && i < scene->n_geometry; i++) {
        if (keep[i]) {
            scene->geometry[index[i]] = scene->geometry[i];
            continue;
        }
        rmap_free(scene->geometry[i].name);
        rmap_mesh_destroy(scene->geometry[i].mesh);
        rmap_shape_release(&scene->geometry[i].shape);
    }
    if (!index)
        return;
    scene->n_geometry = n;
    for (size_t i = 0; i < scene->n_object; i++)
        scene->object[i].geometry = index[scene->object[i].geometry];
    for (size_t i = 0; i < scene->n_source; i++)
        if (scene->source[i].shape_geometry >= 0)
            scene->source[i].shape_geometry = index[scene->source[i].shape_geometry];
}

void rmap_reader_reduce(struct rmap_reader *reader, const struct rmap_keep *keep)
{
    size_t n = 0;
    int32_t *group = NULL;
    int32_t *object = renumber(reader, keep->object, reader->scene->n_object, &n);
    if (!object)
        return;
    reduce_sources(reader->scene, keep->source);
    reduce_objects(reader->scene, keep->object);
    reduce_groups(reader, &group);
    if (group)
        reduce_detectors(reader, keep->detector, object, group);
    if (group)
        move_volumes(reader->scene, object, group);
    reduce_geometries(reader);
}

/* SPDX-License-Identifier: MIT */
#include "bench_questions.h"

#include <fnmatch.h>
#include <math.h>
#include <string.h>

#include "base/alloc.h"
#include "base/vec.h"
#include "portion/event.h"

enum { ANY = 1 << 30 };

/* Sorted by scene. */
static const struct rmap_bench_question question_table[] = {
    {.scene = "double-gauss",
     .class = "objects",
     .text = "source(star) and hit('lens.*', reflect_specular) >= 2 and "
             "registered(sensor, rect(-6.1, -4.1, 6.1, 4.1))",
     .like = "source(sun) and hit('cover.*', reflect_specular) >= 1 and "
             "registered(sensor, rect(-5, -4.5, 6, 4))",
     .source = "star",
     .objects = "lens.*",
     .events = RMAP_EVENT_REFLECT_SPECULAR,
     .at_least = 2,
     .at_most = ANY,
     .detector = "sensor",
     .half_size = {6.1, 4.1}},
    {.scene = "double-gauss",
     .class = "never",
     .text = "not hit(cover.*)",
     .like = "not hit(barrel)",
     .objects = "cover.*",
     .events = UINT32_MAX},
    {.scene = "double-gauss",
     .class = "numbers",
     .text = "registered(sensor, rect(-6.1, -4.1, 6.1, 4.1) where angle < 12 deg) and "
             "path_length < 170 mm",
     .like = "registered(sensor, rect(-5, -4.5, 6, 4) where angle < 10 deg) and "
             "path_length < 160 mm",
     .objects = "*",
     .events = UINT32_MAX,
     .at_most = ANY,
     .detector = "sensor",
     .half_size = {6.1, 4.1},
     .within_deg = 12,
     .longest = 170,
     .tolerance = 1e-3},
    {.scene = "double-gauss",
     .class = "path",
     .text = "path(\"T@lens.1 .* R@'lens.*' .* R@'lens.*' .* V@sensor .*\")",
     .like = "path(\"T@cover.1 .* R@'lens.*' .* V@sensor .*\")",
     .objects = "*",
     .events = UINT32_MAX,
     .at_most = ANY,
     .element = {{RMAP_EVENT_TRANSMIT_SPECULAR, "lens.1"},
                 {RMAP_EVENT_REFLECT_SPECULAR, "lens.*"},
                 {RMAP_EVENT_REFLECT_SPECULAR, "lens.*"},
                 {0, "sensor"}},
     .n_element = 4},
    {.scene = "double-gauss", .text = "source(sun) and ended(absorbed, barrel) and bounces > 3"},
    {.scene = "room",
     .class = "objects",
     .text = "source(lamp) and hit('*_wall', reflect_specular) >= 2 and "
             "registered(floor_map, rect(-1.01, -1.01, 1.01, 1.01))",
     .like = "source(lamp) and hit('board*', transmit) >= 1 and "
             "registered(floor_map, rect(-0.9, -1.2, 1.1, 0.8))",
     .source = "lamp",
     .objects = "*_wall",
     .events = RMAP_EVENT_REFLECT_SPECULAR,
     .at_least = 2,
     .at_most = ANY,
     .detector = "floor_map",
     .half_size = {1.01, 1.01}},
    {.scene = "room",
     .class = "never",
     .text = "not hit('*_wall')",
     .like = "not hit(shelves)",
     .objects = "*_wall",
     .events = UINT32_MAX},
    {.scene = "room",
     .class = "numbers",
     .text = "registered(floor_map, rect(-1.01, -1.01, 1.01, 1.01) where angle < 30 deg) and "
             "path_length < 8 m",
     .like = "registered(floor_map, rect(-0.9, -1.2, 1.1, 0.8) where angle < 25 deg) and "
             "path_length < 7 m",
     .objects = "*",
     .events = UINT32_MAX,
     .at_most = ANY,
     .detector = "floor_map",
     .half_size = {1.01, 1.01},
     .within_deg = 30,
     .longest = 8,
     .tolerance = 1e-3},
    {.scene = "room",
     .class = "path",
     .text = "path(\"D@floor .* R@'*_wall' .* T@'board*' .* V@floor_map .*\")",
     .like = "path(\"D@floor .* R@'*_wall' .* V@floor_map .*\")",
     .objects = "*",
     .events = UINT32_MAX,
     .at_most = ANY,
     .element = {{RMAP_EVENT_REFLECT_DIFFUSE, "floor"},
                 {RMAP_EVENT_REFLECT_SPECULAR, "*_wall"},
                 {RMAP_EVENT_TRANSMIT_SPECULAR, "board*"},
                 {0, "floor_map"}},
     .n_element = 4},
    {.scene = "room", .text = "ended(absorbed, shelves) and bounces > 6"},
};

size_t rmap_bench_questions(const char *scene, const struct rmap_bench_question **first_ret)
{
    size_t n = sizeof question_table / sizeof *question_table, first = 0, last;
    while (first < n && strcmp(question_table[first].scene, scene) != 0)
        first++;
    for (last = first; last < n && strcmp(question_table[last].scene, scene) == 0;)
        last++;
    *first_ret = question_table + first;
    return last - first;
}

static enum rmap_status mark(const struct rmap_scene *scene, const char *pattern, bool *in_set,
                             struct rmap_error *err)
{
    bool found = false;
    for (size_t o = 0; o < scene->n_object; o++) {
        in_set[o] = fnmatch(pattern, scene->object[o].name, 0) == 0;
        found = found || in_set[o];
    }
    return found ? RMAP_OK : rmap_error_set(err, RMAP_INPUT, "no object '%s'", pattern);
}

static enum rmap_status find_detector(const struct rmap_scene *scene, const char *name,
                                      int32_t *index_ret, struct rmap_error *err)
{
    for (size_t d = 0; d < scene->n_detector; d++)
        if (strcmp(scene->detector[d].name, name) == 0) {
            *index_ret = (int32_t)d;
            return RMAP_OK;
        }
    return rmap_error_set(err, RMAP_INPUT, "no detector '%s'", name);
}

static enum rmap_status pose_detector(const struct rmap_bench_question *question,
                                      const struct rmap_scene *scene,
                                      struct rmap_seed_question *asked, struct rmap_error *err)
{
    enum rmap_status st = find_detector(scene, question->detector, &asked->detector, err);
    for (int k = 0; k < 2 && st == RMAP_OK; k++) {
        double half = question->half_size[k] / scene->detector[asked->detector].size[k];
        asked->from[k] = half > 0.0 ? 0.5 - half : 0.0;
        asked->to[k] = half > 0.0 ? 0.5 + half : 1.0;
    }
    if (question->within_deg > 0.0)
        asked->least_cosine = cos(question->within_deg * RMAP_PI / 180.0);
    return st;
}

enum rmap_status rmap_bench_question_pose(const struct rmap_bench_question *question,
                                          const struct rmap_scene *scene,
                                          struct rmap_seed_question *asked, bool **in_set_ret,
                                          struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = scene->n_object;
    *asked = (struct rmap_seed_question){.source = -1,
                                         .n_object = n,
                                         .events = question->events,
                                         .at_least = question->at_least,
                                         .at_most = question->at_most,
                                         .detector = -1,
                                         .least_cosine = -2.0,
                                         .longest = question->longest > 0.0 ? question->longest
                                                                            : (double)INFINITY,
                                         .n_element = question->n_element};
    bool *in_set = *in_set_ret = rmap_alloc(n * (RMAP_SEED_ELEMENT_MAX + 1), sizeof *in_set);
    if (!in_set)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory");
    RMAP_TRY(mark(scene, question->objects, in_set, err));
    asked->in_set = in_set;
    for (size_t s = 0; question->source && s < scene->n_source; s++)
        if (strcmp(scene->source[s].name, question->source) == 0)
            asked->source = (int32_t)s;
    if (question->source && asked->source < 0)
        RMAP_TRY(rmap_error_set(err, RMAP_INPUT, "no source '%s'", question->source));
    if (question->detector)
        RMAP_TRY(pose_detector(question, scene, asked, err));
    for (int k = 0; k < question->n_element; k++) {
        struct rmap_seed_element *element = &asked->element[k];
        element->events = question->element[k].events;
        if (element->events)
            RMAP_TRY(mark(scene, question->element[k].name, in_set + n * (size_t)(k + 1), err));
        else
            RMAP_TRY(find_detector(scene, question->element[k].name, &element->detector, err));
        element->in_set = in_set + n * (size_t)(k + 1);
    }
out:
    return st;
}

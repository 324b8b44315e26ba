/* SPDX-License-Identifier: MIT */
#include "analysis/paths/path_label.h"

#include "base/alloc.h"

const char *rmap_path_level_word(enum rmap_path_level level)
{
    static const char *const word[] = {"surface", "object", "group"};
    return word[level];
}

/* What lies below a group: how many objects, and whether one entry of the scene file made them. */
struct members {
    size_t n;
    int32_t line, column;
    bool mixed;
};

static void add_member(struct members *members, const struct rmap_object *object)
{
    if (members->n > 0 && (members->line != object->line || members->column != object->column))
        members->mixed = true;
    members->line = object->line;
    members->column = object->column;
    members->n++;
}

/* The group that stands for the object, or -1: the object itself. */
static int32_t choose_group(const struct rmap_scene *scene, const struct rmap_object *object,
                            enum rmap_path_level level, const struct members *members)
{
    int32_t chosen = -1;
    if (level == RMAP_PATH_SURFACE)
        return -1;
    for (int32_t g = object->parent; g >= 0; g = scene->group[g].parent) {
        bool wider = members[g].n > (chosen < 0 ? 1 : members[chosen].n);
        if (level == RMAP_PATH_GROUP || (!members[g].mixed && wider))
            chosen = g;
    }
    return chosen;
}

enum rmap_status rmap_path_labels_init(struct rmap_path_labels *labels,
                                       const struct rmap_scene *scene, enum rmap_path_level level,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int32_t *of_group = rmap_alloc(scene->n_group + 1, sizeof *of_group);
    struct members *members = rmap_alloc(scene->n_group + 1, sizeof *members);
    *labels = (struct rmap_path_labels){
        .name = rmap_alloc(scene->n_object + 1, sizeof *labels->name),
        .of_object = rmap_alloc(scene->n_object + 1, sizeof *labels->of_object)};
    if (!of_group || !members || !labels->name || !labels->of_object) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the names of %zu objects",
                            scene->n_object);
        goto out;
    }
    for (size_t o = 0; o < scene->n_object; o++)
        for (int32_t g = scene->object[o].parent; g >= 0; g = scene->group[g].parent)
            add_member(&members[g], &scene->object[o]);
    for (size_t o = 0; o < scene->n_object; o++) {
        int32_t group = choose_group(scene, &scene->object[o], level, members);
        int32_t label = group < 0 ? 0 : of_group[group];
        if (label == 0) {
            labels->name[labels->n++] =
                group < 0 ? scene->object[o].name : scene->group[group].name;
            label = (int32_t)labels->n;
        }
        if (group >= 0)
            of_group[group] = label;
        labels->of_object[o] = label - 1;
    }
out:
    rmap_free(of_group);
    rmap_free(members);
    return st;
}

void rmap_path_labels_fini(struct rmap_path_labels *labels)
{
    rmap_free(labels->name);
    rmap_free(labels->of_object);
    *labels = (struct rmap_path_labels){0};
}

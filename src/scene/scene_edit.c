/* SPDX-License-Identifier: MIT
 *
 * A scene in memory in which something is moved.
 */
#include "scene/scene_edit.h"

#include <string.h>

#include "base/alloc.h"
#include "scene/bounds.h"

bool rmap_scene_part_find(const struct rmap_scene *scene, const char *name,
                          struct rmap_scene_part *part)
{
    *part = (struct rmap_scene_part){-1, -1};
    for (size_t i = 0; i < scene->n_group; i++)
        if (strcmp(scene->group[i].name, name) == 0)
            part->group = (int32_t)i;
    for (size_t i = 0; part->group < 0 && i < scene->n_object; i++)
        if (strcmp(scene->object[i].name, name) == 0)
            part->object = (int32_t)i;
    return part->group >= 0 || part->object >= 0;
}

struct rmap_affine rmap_scene_frame_of(const struct rmap_scene *scene, const char *name)
{
    struct rmap_scene_part part;
    int32_t parent = -1;
    if (rmap_scene_part_find(scene, name, &part))
        parent =
            part.group < 0 ? scene->object[part.object].parent : scene->group[part.group].parent;
    for (size_t i = 0; part.group < 0 && part.object < 0 && i < scene->n_source; i++)
        if (strcmp(scene->source[i].name, name) == 0)
            parent = scene->source[i].parent;
    return parent < 0 ? rmap_affine_identity() : scene->group[parent].to_world;
}

static bool holds(const struct rmap_scene *scene, struct rmap_scene_part part, size_t object)
{
    return part.group < 0 ? (size_t)part.object == object
                          : rmap_scene_in_group(scene, (int32_t)object, part.group);
}

static bool is_held_within(const struct rmap_scene *scene, struct rmap_scene_part part,
                           int32_t group)
{
    return part.group >= 0 && group >= 0 && rmap_scene_group_within(scene, group, part.group);
}

bool rmap_scene_part_is_movable(const struct rmap_scene *scene, struct rmap_scene_part part)
{
    const struct rmap_standing *standing =
        part.group < 0 ? &scene->object[part.object].standing : &scene->group[part.group].standing;
    bool movable = !standing->as_group && !rmap_scene_is_curved(scene);
    for (size_t i = 0; i < scene->n_source; i++) {
        const struct rmap_source *source = &scene->source[i];
        movable = movable && !source->volume && !source->sky && !source->fills &&
                  !is_held_within(scene, part, source->parent);
    }
    for (size_t i = 0; i < scene->n_detector && movable; i++) {
        const struct rmap_detector *detector = &scene->detector[i];
        movable = !is_held_within(scene, part, detector->on_group) &&
                  (detector->on_object < 0 || !holds(scene, part, (size_t)detector->on_object));
        for (size_t o = 0; detector->on_group >= 0 && movable && o < scene->n_object; o++)
            movable = !holds(scene, part, o) || !rmap_detector_lies_at(scene, detector, o);
    }
    return movable;
}

/* The objects and groups that move, and where they stood. */
struct move {
    struct rmap_scene *scene;
    int32_t *object;
    size_t n_object;
    struct rmap_affine *object_before, *group_before;
    struct rmap_standing standing_before;
};

static struct rmap_standing *standing_of(struct rmap_scene *scene, struct rmap_scene_part part)
{
    return part.group < 0 ? &scene->object[part.object].standing
                          : &scene->group[part.group].standing;
}

static struct rmap_affine stand(const struct rmap_scene *scene, int32_t parent,
                                const struct rmap_standing *standing)
{
    const struct rmap_affine around =
        parent < 0 ? rmap_affine_identity() : scene->group[parent].to_world;
    return standing->as_group ? around : rmap_affine_compose(&around, &standing->placement);
}

static enum rmap_status begin(struct move *self, struct rmap_scene_part part,
                              struct rmap_error *err)
{
    struct rmap_scene *scene = self->scene;
    const size_t most = part.group < 0 ? 1 : scene->n_object;
    self->object = rmap_alloc(most, sizeof *self->object);
    self->object_before = rmap_alloc(most, sizeof *self->object_before);
    self->group_before = rmap_alloc(scene->n_group, sizeof *self->group_before);
    if (!self->object || !self->object_before || !self->group_before)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory to move %zu objects", most);
    for (size_t i = 0; i < scene->n_group; i++)
        self->group_before[i] = scene->group[i].to_world;
    for (size_t i = 0; part.group >= 0 && i < scene->n_object; i++)
        if (holds(scene, part, i))
            self->object[self->n_object++] = (int32_t)i;
    if (part.group < 0)
        self->object[self->n_object++] = part.object;
    for (size_t i = 0; i < self->n_object; i++)
        self->object_before[i] = scene->object[self->object[i]].to_world;
    self->standing_before = *standing_of(scene, part);
    return RMAP_OK;
}

static enum rmap_status settle(const struct move *self, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < self->n_object; i++) {
        RMAP_TRY(rmap_object_invert(&self->scene->object[self->object[i]], err));
        rmap_scene_bound_object(self->scene, (size_t)self->object[i]);
    }
    RMAP_TRY(rmap_scene_bound(self->scene, err));
out:
    return st;
}

static enum rmap_status go(const struct move *self, struct rmap_scene_part part,
                           const struct rmap_affine *placement, struct rmap_error *err)
{
    struct rmap_scene *scene = self->scene;
    standing_of(scene, part)->placement = *placement;
    for (size_t i = 0; i < scene->n_group; i++) /* parents come first */
        if (is_held_within(scene, part, (int32_t)i))
            scene->group[i].to_world =
                stand(scene, scene->group[i].parent, &scene->group[i].standing);
    for (size_t i = 0; i < self->n_object; i++) {
        struct rmap_object *object = &scene->object[self->object[i]];
        object->to_world = stand(scene, object->parent, &object->standing);
    }
    return settle(self, err);
}

static void go_back(const struct move *self, struct rmap_scene_part part)
{
    struct rmap_scene *scene = self->scene;
    struct rmap_error none = {0};
    *standing_of(scene, part) = self->standing_before;
    for (size_t i = 0; i < scene->n_group; i++)
        scene->group[i].to_world = self->group_before[i];
    for (size_t i = 0; i < self->n_object; i++)
        scene->object[self->object[i]].to_world = self->object_before[i];
    (void)settle(self, &none);
}

enum rmap_status rmap_scene_move(struct rmap_scene *scene, struct rmap_scene_part part,
                                 const struct rmap_affine *placement, int32_t **object_ret,
                                 size_t *n_object_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct move self = {.scene = scene};
    if (!rmap_scene_part_is_movable(scene, part))
        return rmap_error_set(err, RMAP_USAGE, "more than objects hangs on where it stands");
    RMAP_TRY(begin(&self, part, err));
    st = go(&self, part, placement, err);
    if (st != RMAP_OK) {
        go_back(&self, part);
        goto out;
    }
    *object_ret = self.object;
    *n_object_ret = self.n_object;
    self.object = NULL;
out:
    rmap_free(self.object);
    rmap_free(self.object_before);
    rmap_free(self.group_before);
    return st;
}

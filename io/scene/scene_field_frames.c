/* SPDX-License-Identifier: MIT
 *
 * Where gradient media stand: the frames of their index. rmap_scene_finish merges equal places and
 * drops those that nothing refers to.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/scene/scene_field_frames.h"
#include "io/scene/scene_reader.h"

static struct rmap_medium_frame *frame_of(struct rmap_reader *reader, int32_t medium)
{
    for (size_t i = 0; i < reader->n_frame; i++)
        if (reader->frame[i].medium == medium)
            return &reader->frame[i];
    return NULL;
}

static void add_place(struct rmap_reader *reader, const struct rmap_medium_frame *frame,
                      const struct rmap_affine *to_world, int32_t *gradient_ret)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_gradient *gradient =
        RMAP_READER_NEW(reader, scene->gradient, scene->n_gradient, reader->cap_gradient);
    if (!gradient)
        return;
    gradient->medium = frame->medium;
    gradient->to_world = rmap_affine_compose(to_world, &frame->placement);
    *gradient_ret = (int32_t)scene->n_gradient;
}

/* The one place of a medium whose frame is the world's, or a name's: that one is found later. */
static void share_place(struct rmap_reader *reader, struct rmap_medium_frame *frame,
                        int32_t *gradient_ret)
{
    const struct rmap_affine world = rmap_affine_identity();
    if (!frame->shared)
        add_place(reader, frame, &world, &frame->shared);
    *gradient_ret = frame->shared;
}

void rmap_reader_place_side(struct rmap_reader *reader, const struct rmap_object_side *side,
                            int32_t *gradient_ret)
{
    struct rmap_medium_frame *frame = frame_of(reader, side->medium);
    *gradient_ret = 0;
    if (!frame)
        return;
    if (frame->kind != RMAP_FRAME_OBJECT) {
        share_place(reader, frame, gradient_ret);
        return;
    }
    add_place(reader, frame, side->to_world, gradient_ret);
    const struct rmap_gradient *made = &reader->scene->gradient[*gradient_ret - 1];
    frame->open |= !side->closes;
    if (frame->first < 0) {
        frame->first = *gradient_ret - 1;
        frame->first_object = side->object;
    } else if (memcmp(&reader->scene->gradient[frame->first].to_world, &made->to_world,
                      sizeof made->to_world) != 0) {
        frame->other_object = side->object;
    }
}

static bool frame_of_member(struct rmap_reader *reader, const struct rmap_name *member,
                            struct rmap_affine *to_world)
{
    if (!member || member->index < 0 ||
        (member->kind != RMAP_MEMBER_OBJECT && member->kind != RMAP_MEMBER_GROUP))
        return false;
    *to_world = member->kind == RMAP_MEMBER_OBJECT ? reader->scene->object[member->index].to_world
                                                   : reader->scene->group[member->index].to_world;
    return true;
}

static void settle_named(struct rmap_reader *reader, struct rmap_medium_frame *frame)
{
    const struct rmap_yaml_node *at = rmap_yaml_get(frame->node, "frame");
    const struct rmap_name *member = rmap_names_find(&reader->members, at->text);
    struct rmap_affine to_world;
    if (!member)
        (void)rmap_reader_find(reader, &reader->members, "frame", at, at->text);
    else if (member->index < 0) /* complained of already */
        return;
    else if (!frame_of_member(reader, member, &to_world))
        rmap_reader_error(reader, at,
                          "'%.60s' is no object or group: a frame is one of these, or "
                          "'world', or 'object'",
                          at->text);
    else
        frame->placement = rmap_affine_compose(&to_world, &frame->placement);
    if (frame->shared)
        reader->scene->gradient[frame->shared - 1].to_world = frame->placement;
}

void rmap_reader_settle_frames(struct rmap_reader *reader)
{
    const struct rmap_scene *scene = reader->scene;
    for (size_t i = 0; i < reader->n_frame; i++) {
        struct rmap_medium_frame *frame = &reader->frame[i];
        if (frame->kind == RMAP_FRAME_NAMED)
            settle_named(reader, frame);
        if (frame->kind == RMAP_FRAME_OBJECT && frame->open && frame->other_object >= 0)
            rmap_reader_error(
                reader, frame->node,
                "medium '%.60s' stands beside surfaces with frames of their own ('%.60s', "
                "'%.60s'): say where its index lives, with 'frame:' and the name of an object or "
                "group, or 'frame: world'",
                scene->medium[frame->medium].name, scene->object[frame->first_object].name,
                scene->object[frame->other_object].name);
    }
}

/* The place of the medium on a side of the object, or of the objects of a group, when it is one. */
static int32_t place_within(const struct rmap_scene *scene, const struct rmap_name *member,
                            int32_t medium)
{
    int32_t found = 0;
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_object *object = &scene->object[o];
        bool inside = member->kind == RMAP_MEMBER_OBJECT
                          ? (int32_t)o == member->index
                          : rmap_scene_in_group(scene, (int32_t)o, member->index);
        if (!inside)
            continue;
        int32_t here = object->medium_back == medium    ? object->gradient_back
                       : object->medium_front == medium ? object->gradient_front
                                                        : 0;
        if (!found)
            found = here;
        else if (here &&
                 memcmp(&scene->gradient[here - 1].to_world, &scene->gradient[found - 1].to_world,
                        sizeof scene->gradient[0].to_world) != 0)
            return -1;
    }
    return found;
}

void rmap_reader_place_within(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              int32_t medium, int32_t *gradient_ret)
{
    struct rmap_medium_frame *frame = frame_of(reader, medium);
    const struct rmap_yaml_node *at = rmap_yaml_get(node, "within");
    const char *name = rmap_reader_text(reader, node, "within", RMAP_OPTIONAL);
    const char *medium_name = medium >= 0 ? reader->scene->medium[medium].name : "";
    if (frame && frame->kind != RMAP_FRAME_OBJECT) {
        share_place(reader, frame, gradient_ret);
        return;
    }
    if (!name)
        return;
    if (!frame) {
        rmap_reader_error(reader, at, "'within' is for gradient media, which '%.60s' is not",
                          medium_name);
        return;
    }
    const struct rmap_name *member = rmap_reader_find_body(reader, "object or group", at, name);
    if (!member)
        return;
    int32_t place = place_within(reader->scene, member, medium);
    if (place <= 0)
        rmap_reader_error(reader, at,
                          place
                              ? "medium '%.60s' stands in several places within '%.60s': name one "
                                "body"
                              : "medium '%.60s' is on no side of '%.60s'",
                          medium_name, name);
    *gradient_ret = place > 0 ? place : 0;
}

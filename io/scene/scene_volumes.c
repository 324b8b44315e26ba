/* SPDX-License-Identifier: MIT
 *
 * Sources that shine from within a body, along a track, or from the cells of a grid.
 */
#include "io/scene/scene_volumes.h"

#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/scene/scene_field.h"
#include "io/scene/scene_placement.h"

static bool find_body(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      struct rmap_volume *volume)
{
    const char *name = rmap_reader_text(reader, node, "in", RMAP_OPTIONAL);
    const struct rmap_name *member =
        name ? rmap_reader_find_body(reader, "object or group", rmap_yaml_get(node, "in"), name)
             : NULL;
    if (!member)
        return false;
    volume->on_object = member->kind == RMAP_MEMBER_OBJECT ? member->index : -1;
    volume->on_group = member->kind == RMAP_MEMBER_GROUP ? member->index : -1;
    return member->index >= 0;
}

static void read_track(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_source *source)
{
    struct rmap_vec3 from = {0, 0, 0}, to = {0, 0, 0};
    for (int k = 0; k < 2; k++)
        if (!rmap_yaml_get(node, k ? "to" : "from"))
            rmap_reader_error(reader, node, "'%s' is missing: a track has two ends",
                              k ? "to" : "from");
    (void)rmap_reader_vec3(reader, node, "from", &rmap_range_length, &from);
    (void)rmap_reader_vec3(reader, node, "to", &rmap_range_length, &to);
    const struct rmap_vec3 way = rmap_sub(to, from);
    source->frame.t = from;
    source->frame.m[0][2] = way.x;
    source->frame.m[1][2] = way.y;
    source->frame.m[2][2] = way.z;
}

static void read_deposits(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_source *source)
{
    struct rmap_grid *grid = NULL;
    char name[280];
    (void)snprintf(name, sizeof name, "source/%.200s", source->name ? source->name : "");
    (void)rmap_reader_placement(reader, node, &source->frame);
    rmap_reader_find_grid(reader, node, name, &grid);
    if (grid)
        rmap_reader_made(reader, rmap_yaml_get(node, "file"),
                         rmap_volume_take_grid(source->volume, grid, &reader->failure));
}

void rmap_reader_read_volume(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             struct rmap_source *source)
{
    static const char *const of_grid[] = {"dataset", "axes", "lower",  "upper", "spacing", "origin",
                                          "unit",    "at",   "rotate", "scale", "matrix"};
    struct rmap_volume *volume = rmap_alloc(1, sizeof *volume);
    source->type = RMAP_SOURCE_VOLUME;
    source->volume = volume;
    if (!volume) {
        rmap_reader_no_memory(reader);
        return;
    }
    volume->on_object = volume->on_group = -1;
    const bool track = rmap_yaml_get(node, "from") || rmap_yaml_get(node, "to"),
               grid = rmap_yaml_get(node, "file") != NULL;
    volume->kind = track ? RMAP_VOLUME_TRACK : grid ? RMAP_VOLUME_GRID : RMAP_VOLUME_BODY;
    for (size_t i = 0; i < RMAP_COUNT(of_grid) && !grid; i++)
        if (rmap_yaml_get(node, of_grid[i]))
            rmap_reader_error(
                reader, rmap_yaml_get(node, of_grid[i]),
                "'%s' is of a grid in a 'file': a body or a track shines where it stands",
                of_grid[i]);
    if (track && grid)
        rmap_reader_error(reader, rmap_yaml_get(node, "file"),
                          "give a track 'from' and 'to' or a 'file', not both");
    else if (!track && !grid && !rmap_yaml_get(node, "in"))
        rmap_reader_error(reader, node,
                          "'in' is missing: the body that shines; or 'from' and 'to' of a track, "
                          "or the 'file' of a grid");
    else if (track)
        read_track(reader, node, source);
    else if (grid)
        read_deposits(reader, node, source);
    if (!find_body(reader, node, volume) || source->medium >= 0)
        return;
    source->medium = rmap_volume_medium(reader->scene, volume);
    if (source->medium < 0)
        rmap_reader_error(reader, rmap_yaml_get(node, "in"),
                          "'%.60s' has not one medium inside: say which, with 'medium'",
                          rmap_yaml_get(node, "in")->text);
}

/* SPDX-License-Identifier: MIT
 *
 * The tree of objects: groups, instances, their surfaces and media.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "geometry/sag.h"
#include "io/scene/scene_attributes.h"
#include "io/scene/scene_bodies.h"
#include "io/scene/scene_faces.h"
#include "io/scene/scene_field_frames.h"
#include "io/scene/scene_films.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_lens.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_objects.h"
#include "io/scene/scene_placement.h"
#include "io/scene/scene_reader.h"
#include "io/scene/scene_scatter.h"
#include "io/scene/scene_surfaces.h"

/* Digits alone are decimal; with letters or 0x hexadecimal; absent: the hash of the name. */
static uint64_t read_id(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        const char *name)
{
    const char *text = rmap_reader_text(reader, node, "id", RMAP_OPTIONAL);
    if (!text)
        return XXH3_64bits(name, strlen(name));
    bool prefix = text[0] == '0' && (text[1] == 'x' || text[1] == 'X');
    const char *digits = prefix ? text + 2 : text;
    size_t len = strlen(digits);
    bool hex = prefix || strspn(digits, "0123456789") != len;
    uint64_t id = 0;
    bool good = len > 0 && strspn(digits, "0123456789abcdefABCDEF") == len;
    for (size_t i = 0; good && i < len; i++) {
        char c = digits[i];
        uint64_t digit = (uint64_t)(c <= '9' ? c - '0' : (c | 32) - 'a' + 10);
        uint64_t base = hex ? 16 : 10;
        good = id <= (UINT64_MAX - digit) / base;
        id = id * base + digit;
    }
    if (!good)
        rmap_reader_error(reader, rmap_yaml_get(node, "id"),
                          "'id' must be a whole number of 64 bits or up to 16 hexadecimal digits, "
                          "not '%.40s'",
                          text);
    return id;
}

/* Places of gradient media on both sides. Only elements of lenses have frames of their own. */
static void place_sides(struct rmap_reader *reader, const struct rmap_object_plan *plan,
                        int32_t index)
{
    int32_t front = 0, back = 0;
    const struct rmap_geometry *geometry = &reader->scene->geometry[plan->geometry];
    bool body =
        geometry->kind == RMAP_GEOMETRY_MESH || rmap_shape_model[geometry->shape.type].closed;
    const struct rmap_object_side side[2] = {
        {index, plan->medium_front, plan->element_front ? plan->element_front : &plan->to_world,
         plan->element_front != NULL},
        {index, plan->medium_back, plan->element_back ? plan->element_back : &plan->to_world,
         plan->element_back || body}};
    rmap_reader_place_side(reader, &side[0], &front);
    rmap_reader_place_side(reader, &side[1], &back);
    reader->scene->object[index].gradient_front = front;
    reader->scene->object[index].gradient_back = back;
}

static struct rmap_standing standing_of(const struct rmap_affine *placement)
{
    return (struct rmap_standing){!placement, placement ? *placement : rmap_affine_identity()};
}

void rmap_reader_add_object(struct rmap_reader *reader, const struct rmap_object_plan *plan)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_object *object =
        RMAP_READER_NEW(reader, scene->object, scene->n_object, reader->cap_object);
    if (!object)
        return;
    *object = (struct rmap_object){
        .name = rmap_reader_strdup(reader, plan->name),
        .id = plan->derived ? XXH3_64bits(plan->name, strlen(plan->name))
                            : read_id(reader, plan->node, plan->name),
        .parent = plan->parent,
        .geometry = plan->geometry,
        .to_world = plan->to_world,
        .to_local = rmap_affine_identity(),
        .standing = standing_of(plan->placement),
        .surface_front = plan->surface_front,
        .surface_back = plan->surface_back,
        .medium_front = plan->medium_front,
        .medium_back = plan->medium_back,
        .medium_outside = plan->in_lens ? plan->outside : plan->medium_front,
        .line = plan->node->line,
        .column = plan->node->column,
    };
    const struct rmap_shape *shape = &scene->geometry[plan->geometry].shape;
    object->faceted = shape->type == RMAP_SHAPE_SAG && shape->sag[0]->fresnel;
    if (!object->name)
        return;
    place_sides(reader, plan, (int32_t)(scene->n_object - 1));
    rmap_reader_check_films(reader, plan->node, object);
    rmap_reader_check_scatter(reader, plan->node, object);
    rmap_reader_add_member(reader, object->name, RMAP_MEMBER_OBJECT, (int32_t)(scene->n_object - 1),
                           plan->node);
}

void rmap_reader_add_group(struct rmap_reader *reader, const char *name,
                           const struct rmap_yaml_node *node, int32_t parent,
                           const struct rmap_affine *to_world, const struct rmap_affine *placement,
                           bool derived, int32_t *group_ret)
{
    struct rmap_scene *scene = reader->scene;
    struct rmap_group *group =
        RMAP_READER_NEW(reader, scene->group, scene->n_group, reader->cap_group);
    if (!group)
        return;
    group->name = rmap_reader_strdup(reader, name);
    group->id = derived ? XXH3_64bits(name, strlen(name)) : read_id(reader, node, name);
    group->parent = parent;
    group->to_world = *to_world;
    group->standing = standing_of(placement);
    *group_ret = (int32_t)(scene->n_group - 1);
    if (!group->name)
        return;
    rmap_reader_add_member(reader, group->name, RMAP_MEMBER_GROUP, *group_ret, node);
}

/* One medium under either of its two keys. */
static void read_side(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const char *key, const char *other, int32_t *medium, bool *stated)
{
    const struct rmap_yaml_node *second = rmap_yaml_get(node, other);
    *stated = second || rmap_yaml_get(node, key);
    if (second && rmap_yaml_get(node, key))
        rmap_reader_error(reader, second, "give '%s' or '%s', not both: they are the same side",
                          key, other);
    rmap_reader_medium(reader, node, second ? other : key, medium);
}

void rmap_reader_sides(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct rmap_object_plan *plan)
{
    bool front = false, back = false;
    const bool had_front = plan->medium_front != RMAP_MEDIUM_ANY,
               had_back = plan->medium_back != RMAP_MEDIUM_ANY;
    read_side(reader, node, "front", "outside", &plan->medium_front, &front);
    read_side(reader, node, "back", "inside", &plan->medium_back, &back);
    front |= had_front;
    back |= had_back;
    int32_t clear = rmap_scene_transmits(reader->scene, plan->surface_front) ? plan->surface_front
                                                                             : plan->surface_back;
    if ((front && back) || !rmap_scene_transmits(reader->scene, clear))
        return;
    rmap_reader_error(reader, node,
                      "surface '%.60s' of object '%.60s' lets light through: name the media on "
                      "both sides, with %s",
                      reader->scene->surface[clear].name, plan->name,
                      front  ? "'inside' (or 'back')"
                      : back ? "'outside' (or 'front')"
                             : "'inside' and 'outside' (or 'back' and 'front')");
}

enum { OBJECT, LENS, GROUP };
const struct rmap_mapping rmap_object_keys = {
    "objects",
    NULL,
    {{"an object", "name geometry at rotate scale matrix copies surface front back inside outside "
                   "id faces by_face color material"},
     {"an instance of a lens",
      "name geometry at rotate scale matrix copies outside front id surface edge color material"},
     {"a group", "name objects sources at rotate scale matrix copies id"}}};

static void read_lens_instance(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               const struct rmap_geometry_entry *entry,
                               struct rmap_object_plan *plan)
{
    int32_t outside = -1;
    bool stated = false;
    (void)rmap_reader_known(reader, node, &rmap_object_keys, LENS);
    plan->surface_front = entry->lens->surface_front;
    plan->surface_back = entry->lens->surface_back;
    rmap_reader_surface_pair(reader, node, "surface", &plan->surface_front, &plan->surface_back);
    read_side(reader, node, "front", "outside", &outside, &stated);
    if (!stated)
        rmap_reader_error(reader, node, "'outside' is missing: name the medium around lens '%.60s'",
                          plan->name);
    rmap_reader_expand_lens(reader, entry, plan, outside);
}

static void read_instance(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct rmap_object_plan *plan)
{
    const char *geometry = rmap_reader_text(reader, node, "geometry", RMAP_REQUIRED);
    int32_t index = !geometry ? -1
                              : rmap_reader_find(reader, &reader->geometries, "geometry",
                                                 rmap_yaml_get(node, "geometry"), geometry);
    const struct rmap_geometry_entry *entry = index >= 0 ? &reader->entry[index] : NULL;
    if (entry && entry->lens && !entry->broken) {
        read_lens_instance(reader, node, entry, plan);
        return;
    }
    if (!entry || !entry->lens)
        (void)rmap_reader_known(reader, node, &rmap_object_keys, OBJECT);
    if (entry && entry->lens) {
        rmap_reader_add_member(reader, plan->name, RMAP_MEMBER_OBJECT, -1, node);
        return;
    }
    plan->surface_front = plan->surface_back = -1;
    if (!rmap_yaml_get(node, "surface"))
        rmap_reader_error(reader, node, "'surface' is missing: name the surface of object '%.60s'",
                          plan->name);
    rmap_reader_surface_pair(reader, node, "surface", &plan->surface_front, &plan->surface_back);
    plan->medium_front = plan->medium_back = RMAP_MEDIUM_ANY;
    rmap_reader_sides(reader, node, plan);
    rmap_reader_check_labels(reader, node);
    if (!entry || entry->broken) {
        rmap_reader_add_member(reader, plan->name, RMAP_MEMBER_OBJECT, -1, node);
        return;
    }
    plan->geometry = entry->geometry;
    if (rmap_yaml_get(node, "faces") || rmap_yaml_get(node, "by_face"))
        rmap_reader_expand_faces(reader, node, plan);
    else if (entry->closed)
        rmap_reader_expand_closed(reader, entry, plan);
    else
        rmap_reader_add_object(reader, plan);
}

/* Where the items of a list stand. */
struct place {
    const char *prefix; /* of their names, within a copy: "desk.3."; else "" */
    int32_t parent;
    struct rmap_affine to_world;
};

static void read_list(struct rmap_reader *reader, const struct rmap_yaml_node *list,
                      const struct place *place);

/* "prefix" + "name" + "end"; what cannot be a name is RMAP_UNNAMED. */
static const char *full_name(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                             const char *prefix, const char *name, const char *end)
{
    size_t nbytes = strlen(prefix) + strlen(name) + strlen(end) + 1;
    char *text = rmap_reader_alloc(reader, nbytes, 1);
    if (!text || name[0] == RMAP_UNNAMED[0])
        return RMAP_UNNAMED;
    (void)snprintf(text, nbytes, "%s%s%s", prefix, name, end);
    return rmap_reader_check_name(reader, node, text) ? text : RMAP_UNNAMED;
}

/* They are read with the others, once all objects are. */
static void note_sources(struct rmap_reader *reader, const struct rmap_yaml_node *list,
                         const struct place *place)
{
    if (!list || !rmap_reader_check_list(reader, list, "'sources'"))
        return;
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *node = list->item[i].value;
        struct rmap_placed_source *placed =
            RMAP_READER_NEW(reader, reader->placed, reader->n_placed, reader->cap_placed);
        if (!placed)
            return;
        *placed = (struct rmap_placed_source){
            .node = node, .parent = place->parent, .to_world = place->to_world};
        placed->name = node->kind == RMAP_YAML_MAP ? full_name(reader, node, place->prefix,
                                                               rmap_reader_name(reader, node), "")
                                                   : RMAP_UNNAMED;
    }
}

static void read_group(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_object_plan *plan, const char *prefix)
{
    struct place inside = {prefix, -1, plan->to_world};
    (void)rmap_reader_known(reader, node, &rmap_object_keys, GROUP);
    rmap_reader_add_group(reader, plan->name, node, plan->parent, &plan->to_world, plan->placement,
                          plan->derived, &inside.parent);
    if (rmap_yaml_get(node, "objects"))
        read_list(reader, rmap_yaml_get(node, "objects"), &inside);
    note_sources(reader, rmap_yaml_get(node, "sources"), &inside);
}

static void read_one(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                     const struct rmap_object_plan *plan, const char *prefix)
{
    struct rmap_object_plan one = *plan;
    if (rmap_yaml_get(node, "objects") || rmap_yaml_get(node, "sources"))
        read_group(reader, node, &one, prefix);
    else
        read_instance(reader, node, &one);
}

enum { COPIES_MAX = 1000000 };

/* `copies:`, along the axes that `at` is measured by. */
struct copies {
    double count[3], step[3];
    size_t n;
};

static bool read_copies(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                        struct copies *copies)
{
    static const struct rmap_range whole = {1, COPIES_MAX, "a whole number from 1 to 1,000,000"};
    const struct rmap_yaml_node *given = rmap_yaml_get(node, "copies");
    size_t n_count = 0, n_step = 0;
    *copies = (struct copies){{1, 1, 1}, {0, 0, 0}, 0};
    if (!rmap_reader_check_map(reader, given, "copies", "count step"))
        return false;
    bool good = rmap_reader_numbers(reader, given, "count", RMAP_REQUIRED, &whole, 1, 3,
                                    copies->count, &n_count);
    good &= rmap_reader_numbers(reader, given, "step", RMAP_REQUIRED, &rmap_range_length, 1, 3,
                                copies->step, &n_step);
    if (!good)
        return false;
    double n = copies->count[0] * copies->count[1] * copies->count[2];
    for (int k = 0; k < 3; k++)
        good &= copies->count[k] == floor(copies->count[k]);
    if (n_count != n_step)
        rmap_reader_error(reader, given, "'count' has %zu numbers, 'step' has %zu: along x, y, z",
                          n_count, n_step);
    else if (!good || n > COPIES_MAX)
        rmap_reader_error(reader, given,
                          "'count' must be whole numbers, for 1,000,000 copies at most");
    else if (rmap_yaml_get(node, "id"))
        rmap_reader_error(reader, rmap_yaml_get(node, "id"),
                          "copies have ids of their own: leave 'id' out");
    else
        copies->n = (size_t)n;
    return copies->n > 0;
}

/* A group of the item's name, with the copies name.1, name.2, ..., x first. A mistake in the item
 * is told of its first copy. */
static void read_all_copies(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const struct rmap_object_plan *plan, const struct place *place)
{
    struct copies copies;
    int32_t group = -1;
    const size_t before = reader->diagnostics->n_error;
    if (!read_copies(reader, node, &copies)) {
        rmap_reader_add_member(reader, plan->name, RMAP_MEMBER_OBJECT, -1, node);
        return;
    }
    rmap_reader_add_group(reader, plan->name, node, plan->parent, &place->to_world, NULL, true,
                          &group);
    size_t nx = (size_t)copies.count[0], ny = (size_t)copies.count[1];
    for (size_t i = 0; i < copies.n && reader->diagnostics->n_error == before; i++) {
        const struct rmap_vec3 shift =
            rmap_vec3(copies.step[0] * (double)(i % nx), copies.step[1] * (double)(i / nx % ny),
                      copies.step[2] * (double)(i / nx / ny));
        const struct rmap_affine move =
            rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(0, 0, 0), shift);
        struct rmap_affine own;
        struct rmap_object_plan copy = *plan;
        char end[24];
        (void)snprintf(end, sizeof end, ".%zu", i + 1);
        (void)rmap_reader_placement(reader, node, &own);
        own = rmap_affine_compose(&move, &own);
        copy.to_world = rmap_affine_compose(&place->to_world, &own);
        copy.placement = &own;
        copy.name = full_name(reader, node, "", plan->name, end);
        copy.parent = group;
        copy.derived = true;
        if (copy.name[0] == RMAP_UNNAMED[0])
            return;
        read_one(reader, node, &copy, full_name(reader, node, copy.name, ".", ""));
    }
}

static void read_item(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                      const struct place *place)
{
    const char *name = rmap_reader_name(reader, node);
    struct rmap_affine placement;
    struct rmap_object_plan plan = {.name = name,
                                    .node = node,
                                    .parent = place->parent,
                                    .derived = place->prefix[0] != 0,
                                    .surface_front = -1,
                                    .surface_back = -1};
    if (plan.derived)
        plan.name = full_name(reader, node, place->prefix, name, "");
    if (plan.derived && rmap_yaml_get(node, "id"))
        rmap_reader_error(reader, rmap_yaml_get(node, "id"),
                          "copies have ids of their own: leave 'id' out");
    if (rmap_yaml_get(node, "copies")) {
        read_all_copies(reader, node, &plan, place);
        return;
    }
    (void)rmap_reader_placement(reader, node, &placement);
    plan.to_world = rmap_affine_compose(&place->to_world, &placement);
    plan.placement = &placement;
    read_one(reader, node, &plan, place->prefix);
}

static void read_list(struct rmap_reader *reader, const struct rmap_yaml_node *list,
                      const struct place *place)
{
    struct rmap_scene *scene = reader->scene;
    if (!rmap_reader_check_list(reader, list, "'objects'"))
        return;
    if (RMAP_RESERVE(scene->object, reader->cap_object, scene->n_object + list->n_item, NULL) !=
        RMAP_OK)
        rmap_reader_no_memory(reader);
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *node = list->item[i].value;
        if (node->kind == RMAP_YAML_MAP)
            read_item(reader, node, place);
        else
            rmap_reader_error(reader, node, "an object must be a mapping, as in {name: lens, ...}");
    }
}

/* ---- ids ---- */

struct id_of {
    uint64_t id;
    const char *name;
};

static int by_id(const void *a, const void *b)
{
    const struct id_of *left = a, *right = b;
    return (left->id > right->id) - (left->id < right->id);
}

static void check_ids(struct rmap_reader *reader)
{
    const struct rmap_scene *scene = reader->scene;
    size_t n = scene->n_object + scene->n_group;
    struct id_of *list = rmap_reader_alloc(reader, n, sizeof *list);
    if (!list)
        return;
    for (size_t i = 0; i < scene->n_object; i++)
        list[i] = (struct id_of){scene->object[i].id, scene->object[i].name};
    for (size_t i = 0; i < scene->n_group; i++)
        list[scene->n_object + i] = (struct id_of){scene->group[i].id, scene->group[i].name};
    if (n)
        qsort(list, n, sizeof *list, by_id);
    for (size_t i = 1; i < n; i++) {
        if (list[i].id != list[i - 1].id || strcmp(list[i].name, list[i - 1].name) == 0)
            continue;
        const struct rmap_name *a = rmap_names_find(&reader->members, list[i].name);
        const struct rmap_name *b = rmap_names_find(&reader->members, list[i - 1].name);
        const struct rmap_yaml_node at = {
            .line = a && b ? (a->line > b->line ? a->line : b->line) : 0, .column = 1};
        rmap_reader_error(reader, &at, "'%.60s' and '%.60s' have the same id, %llx: ids are unique",
                          list[i - 1].name, list[i].name, (unsigned long long)list[i].id);
    }
}

void rmap_reader_read_objects(struct rmap_reader *reader)
{
    const struct place world = {"", -1, rmap_affine_identity()};
    const struct rmap_yaml_node *objects = rmap_yaml_get(reader->root, "objects");
    if (!objects)
        return;
    read_list(reader, objects, &world);
    check_ids(reader);
}

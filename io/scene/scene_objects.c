/* SPDX-License-Identifier: MIT
 *
 * The tree of objects: groups, instances, their surfaces and media. An instance of a prescription
 * is a group of caps, edges and the plate of the stop; instances share the geometries.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_reader.h"

/* Objects as they are made. */
struct object_plan {
    const char *name;
    const struct rmap_yaml_node *node;
    bool derived; /* part of a lens: its id comes from its name, not from the node */
    int32_t parent, geometry;
    struct rmap_affine to_world;
    int32_t surface_front, surface_back, medium_front, medium_back;
    /* Of an element of a lens: the frame of a gradient medium on that side; NULL: to_world. */
    const struct rmap_affine *element_front, *element_back;
};

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
static void place_sides(struct rmap_reader *reader, const struct object_plan *plan, int32_t index)
{
    int32_t front = 0, back = 0;
    const struct rmap_geometry *geometry = &reader->scene->geometry[plan->geometry];
    bool body = geometry->kind == RMAP_GEOMETRY_MESH || geometry->shape.type == RMAP_SHAPE_SPHERE;
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

static void add_object(struct rmap_reader *reader, const struct object_plan *plan)
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
        .surface_front = plan->surface_front,
        .surface_back = plan->surface_back,
        .medium_front = plan->medium_front,
        .medium_back = plan->medium_back,
        .line = plan->node->line,
        .column = plan->node->column,
    };
    if (!object->name)
        return;
    place_sides(reader, plan, (int32_t)(scene->n_object - 1));
    rmap_reader_add_member(reader, object->name, RMAP_MEMBER_OBJECT, (int32_t)(scene->n_object - 1),
                           plan->node);
}

static void add_group(struct rmap_reader *reader, const char *name,
                      const struct rmap_yaml_node *node, int32_t parent,
                      const struct rmap_affine *to_world, bool derived, int32_t *group_ret)
{
    struct rmap_scene *scene = reader->scene;
    size_t n = scene->n_group;
    struct rmap_affine *place =
        RMAP_READER_NEW(reader, reader->group_to_world, n, reader->cap_group_to_world);
    if (!place)
        return;
    *place = *to_world;
    struct rmap_group *group =
        RMAP_READER_NEW(reader, scene->group, scene->n_group, reader->cap_group);
    if (!group)
        return;
    group->name = rmap_reader_strdup(reader, name);
    group->id = derived ? XXH3_64bits(name, strlen(name)) : read_id(reader, node, name);
    group->parent = parent;
    *group_ret = (int32_t)(scene->n_group - 1);
    if (!group->name)
        return;
    rmap_reader_add_member(reader, group->name, RMAP_MEMBER_GROUP, *group_ret, node);
}

/* ---- instances of prescriptions ---- */

struct expansion {
    struct rmap_reader *reader;
    struct rmap_lens *lens;
    const struct object_plan *plan; /* of the whole: name, place, surfaces of the caps */
    const char *geometry;           /* name of the prescription */
    int32_t group, outside;
    int32_t edge_front, edge_back;
    int n_edge, n_stop;
};

static char *compose(struct rmap_reader *reader, const char *format, ...) RMAP_PRINTF(2, 3);

static char *compose(struct rmap_reader *reader, const char *format, ...)
{
    enum { LONGEST = 256 };
    char *text = rmap_reader_alloc(reader, LONGEST, 1);
    va_list args;
    va_start(args, format);
    if (text)
        (void)vsnprintf(text, LONGEST, format, args);
    va_end(args);
    return text;
}

/* The lens's frame, shifted along its axis: of a part, and of the index of an element, whose origin
 * is the vertex of the surface before it. */
static struct rmap_affine frame_at(const struct expansion *e, double z)
{
    const struct rmap_affine shift =
        rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(0, 0, 0), rmap_vec3(0, 0, z));
    return rmap_affine_compose(&e->plan->to_world, &shift);
}

/* A part of the instance at z of the lens's axis. */
static void add_part(struct expansion *e, const char *name, int32_t parent, int32_t geometry,
                     double z, const struct object_plan *sides)
{
    struct object_plan part = *sides;
    part.name = name;
    part.node = e->plan->node;
    part.parent = parent;
    part.geometry = geometry;
    part.to_world = frame_at(e, z);
    part.derived = true;
    add_object(e->reader, &part);
}

static bool is_hole(const struct expansion *e, size_t k)
{
    const struct rmap_lens_row *row = &e->lens->row[k];
    int32_t before = k ? e->lens->row[k - 1].medium : e->outside;
    return row->stop && row->shape.curvature == 0 && row->shape.n_asphere == 0 &&
           row->medium == before;
}

/* z of the surface behind which the medium of row k begins. */
static double element_z(const struct expansion *e, size_t k)
{
    while (k && is_hole(e, k))
        k--;
    return e->lens->row[k].z;
}

static void add_cap(struct expansion *e, size_t k)
{
    struct rmap_lens_row *row = &e->lens->row[k];
    char *name = compose(e->reader, "%s.%zu", e->plan->name, k + 1);
    if (!name)
        return;
    if (row->geometry < 0) {
        char *shape_name = compose(e->reader, "%s.%zu", e->geometry, k + 1);
        if (!shape_name)
            return;
        rmap_reader_add_shape(e->reader, shape_name, &row->shape, &row->geometry);
    }
    const struct rmap_affine after = frame_at(e, row->z);
    const struct rmap_affine before = frame_at(e, element_z(e, k ? k - 1 : k));
    const struct object_plan sides = {
        .surface_front = e->plan->surface_front,
        .surface_back = e->plan->surface_back,
        .medium_front = row->medium,
        .medium_back = k ? e->lens->row[k - 1].medium : e->outside,
        .element_front = k + 1 < e->lens->n_row ? &after : NULL,
        .element_back = k ? &before : NULL,
    };
    add_part(e, name, e->group, row->geometry, row->z, &sides);
}

/* The plate of a stop must stop light even where the edges let it through. */
static void stop_surface(struct expansion *e, int32_t *front, int32_t *back)
{
    *front = e->edge_front;
    *back = e->edge_back;
    if (!rmap_scene_transmits(e->reader->scene, *front) &&
        !rmap_scene_transmits(e->reader->scene, *back))
        return;
    rmap_reader_builtin_surface(e->reader, RMAP_SURFACE_ABSORBER, front);
    *back = *front;
}

static void add_stop(struct expansion *e, size_t k, int32_t parent)
{
    struct rmap_lens_row *row = &e->lens->row[k];
    double inner = row->shape.aperture;
    int number = ++e->n_stop;
    char *name = number == 1 ? compose(e->reader, "%s.stop", e->plan->name)
                             : compose(e->reader, "%s.stop.%d", e->plan->name, number);
    if (!name)
        return;
    if (row->stop_geometry < 0) {
        const struct rmap_shape plate = {
            .type = RMAP_SHAPE_DISC,
            .inner = inner,
            .aperture = e->lens->widest > inner ? e->lens->widest : 1.5 * inner,
        };
        char *shape_name = compose(e->reader, "%s.stop.%zu", e->geometry, k + 1);
        if (!shape_name)
            return;
        rmap_reader_add_shape(e->reader, shape_name, &plate, &row->stop_geometry);
    }
    struct object_plan sides = {.medium_front = RMAP_MEDIUM_ANY, .medium_back = RMAP_MEDIUM_ANY};
    stop_surface(e, &sides.surface_front, &sides.surface_back);
    add_part(e, name, parent, row->stop_geometry, row->rim_z, &sides);
}

static void add_row(struct expansion *e, size_t k)
{
    int32_t parent = e->group;
    if (is_hole(e, k)) {
        char *name = compose(e->reader, "%s.%zu", e->plan->name, k + 1);
        if (!name)
            return;
        add_group(e->reader, name, e->plan->node, e->group, &e->plan->to_world, true, &parent);
    } else {
        add_cap(e, k);
    }
    if (e->lens->row[k].stop)
        add_stop(e, k, parent);
}

/* The surface of revolution between two rims, from its lower end, and on which side of its normal
 * the glass lies. Where the second rim lies before the first, the glass is outside the cone. */
struct edge {
    struct rmap_shape shape;
    double z;
    bool exists, glass_in_front;
};

static struct edge edge_between(const struct rmap_lens_row *a, const struct rmap_lens_row *b)
{
    double ra = a->shape.aperture, rb = b->shape.aperture, length = b->rim_z - a->rim_z;
    struct edge edge = {.exists = true, .z = fmin(a->rim_z, b->rim_z)};
    if (fabs(length) > 1e-12 * (fabs(a->rim_z) + fabs(b->rim_z) + ra)) {
        edge.shape = (struct rmap_shape){.type = RMAP_SHAPE_TUBE,
                                         .radius = length > 0 ? ra : rb,
                                         .radius2 = length > 0 ? rb : ra,
                                         .length = fabs(length)};
        edge.glass_in_front = length < 0;
        return edge;
    }
    edge.shape = (struct rmap_shape){
        .type = RMAP_SHAPE_DISC, .inner = fmin(ra, rb), .aperture = fmax(ra, rb)};
    edge.exists = ra != rb;
    edge.glass_in_front = rb > ra;
    return edge;
}

static void add_edge(struct expansion *e, size_t k, size_t next)
{
    struct rmap_lens_row *row = &e->lens->row[k];
    const struct edge edge = edge_between(row, &e->lens->row[next]);
    if (!edge.exists)
        return;
    char *name = compose(e->reader, "%s.edge.%d", e->plan->name, ++e->n_edge);
    if (!name)
        return;
    if (row->edge_geometry < 0) {
        char *shape_name = compose(e->reader, "%s.edge.%d", e->geometry, ++e->lens->n_edge);
        if (!shape_name)
            return;
        rmap_reader_add_shape(e->reader, shape_name, &edge.shape, &row->edge_geometry);
    }
    const struct rmap_affine element = frame_at(e, element_z(e, k));
    /* The edge's `front` surface is the outer one. */
    const struct object_plan sides = {
        .surface_front = edge.glass_in_front ? e->edge_back : e->edge_front,
        .surface_back = edge.glass_in_front ? e->edge_front : e->edge_back,
        .medium_front = edge.glass_in_front ? row->medium : e->outside,
        .medium_back = edge.glass_in_front ? e->outside : row->medium,
        .element_front = edge.glass_in_front ? &element : NULL,
        .element_back = edge.glass_in_front ? NULL : &element,
    };
    add_part(e, name, e->group, row->edge_geometry, edge.z, &sides);
}

static void expand_lens(struct rmap_reader *reader, const struct rmap_geometry_entry *entry,
                        const struct object_plan *plan, int32_t outside)
{
    struct rmap_lens *lens = entry->lens;
    struct expansion e = {.reader = reader,
                          .lens = lens,
                          .plan = plan,
                          .geometry = entry->name,
                          .outside = outside,
                          .edge_front = lens->edge_front,
                          .edge_back = lens->edge_back};
    rmap_reader_surface_pair(reader, plan->node, "edge", &e.edge_front, &e.edge_back);
    add_group(reader, plan->name, plan->node, plan->parent, &plan->to_world, false, &e.group);
    for (size_t k = 0; k < lens->n_row; k++)
        add_row(&e, k);
    for (size_t k = 0, next; k + 1 < lens->n_row; k = next) {
        next = k + 1;
        while (next + 1 < lens->n_row && is_hole(&e, next))
            next++;
        if (!is_hole(&e, k) && !is_hole(&e, next) && lens->row[k].medium != outside)
            add_edge(&e, k, next);
    }
}

/* ---- items of the tree ---- */

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

static void read_media(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       struct object_plan *plan)
{
    bool front = false, back = false;
    plan->medium_front = plan->medium_back = RMAP_MEDIUM_ANY;
    read_side(reader, node, "front", "outside", &plan->medium_front, &front);
    read_side(reader, node, "back", "inside", &plan->medium_back, &back);
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
    {{"an object", "name geometry at rotate scale matrix surface front back inside outside id"},
     {"an instance of a lens",
      "name geometry at rotate scale matrix outside front id surface edge"},
     {"a group", "name objects at rotate scale matrix id"}}};

static void read_lens_instance(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                               const struct rmap_geometry_entry *entry, struct object_plan *plan)
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
    expand_lens(reader, entry, plan, outside);
}

static void read_instance(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                          struct object_plan *plan)
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
    read_media(reader, node, plan);
    if (!entry || entry->broken) {
        rmap_reader_add_member(reader, plan->name, RMAP_MEMBER_OBJECT, -1, node);
        return;
    }
    plan->geometry = entry->geometry;
    add_object(reader, plan);
}

static void read_list(struct rmap_reader *reader, const struct rmap_yaml_node *list, int32_t parent,
                      const struct rmap_affine *parent_to_world);

static void read_group(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct object_plan *plan)
{
    int32_t group = -1;
    (void)rmap_reader_known(reader, node, &rmap_object_keys, GROUP);
    add_group(reader, plan->name, node, plan->parent, &plan->to_world, false, &group);
    read_list(reader, rmap_yaml_get(node, "objects"), group, &plan->to_world);
}

static void read_list(struct rmap_reader *reader, const struct rmap_yaml_node *list, int32_t parent,
                      const struct rmap_affine *parent_to_world)
{
    if (!rmap_reader_check_list(reader, list, "'objects'"))
        return;
    for (size_t i = 0; i < list->n_item; i++) {
        const struct rmap_yaml_node *node = list->item[i].value;
        struct rmap_affine placement;
        if (node->kind != RMAP_YAML_MAP) {
            rmap_reader_error(reader, node, "an object must be a mapping, as in {name: lens, ...}");
            continue;
        }
        struct object_plan plan = {.name = rmap_reader_name(reader, node),
                                   .node = node,
                                   .parent = parent,
                                   .surface_front = -1,
                                   .surface_back = -1};
        (void)rmap_reader_placement(reader, node, &placement);
        plan.to_world = rmap_affine_compose(parent_to_world, &placement);
        bool group = rmap_yaml_get(node, "objects") != NULL;
        if (group)
            read_group(reader, node, &plan);
        else
            read_instance(reader, node, &plan);
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
    const struct rmap_affine identity = rmap_affine_identity();
    const struct rmap_yaml_node *objects = rmap_yaml_get(reader->root, "objects");
    if (!objects)
        return;
    read_list(reader, objects, -1, &identity);
    check_ids(reader);
}

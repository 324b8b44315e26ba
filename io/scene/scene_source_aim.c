/* SPDX-License-Identifier: MIT
 *
 * Collimated sources that say what they fill instead of where they stand.
 */
#include "io/scene/scene_source_aim.h"

#include <math.h>

#include "io/scene/scene_placement.h"
#include "scene/bounds.h"

/* The object of that name; of a group its first one, which of a lens is its front surface. -1 after
 * a complaint. */
static int32_t find_target(struct rmap_reader *reader, const struct rmap_yaml_node *at)
{
    const struct rmap_scene *scene = reader->scene;
    const struct rmap_name *name = rmap_names_find(&reader->members, at->text);
    if (!name) {
        (void)rmap_reader_find(reader, &reader->members, "object", at, at->text);
        return -1;
    }
    if (name->kind == RMAP_MEMBER_OBJECT)
        return name->index;
    for (size_t i = 0; name->kind == RMAP_MEMBER_GROUP && i < scene->n_object; i++)
        if (rmap_scene_in_group(scene, (int32_t)i, name->index))
            return (int32_t)i;
    rmap_reader_error(reader, at, "'%.60s' is no object that light could fill", at->text);
    return -1;
}

/* A sphere about an object. */
static double enclose(const struct rmap_scene *scene, const struct rmap_object *object,
                      struct rmap_vec3 *centre)
{
    const struct rmap_geometry *geometry = &scene->geometry[object->geometry];
    struct rmap_vec3 lower, upper;
    rmap_geometry_bounds(geometry, &lower, &upper);
    const struct rmap_vec3 half = rmap_scale(rmap_sub(upper, lower), 0.5);
    const bool is_round =
        geometry->kind == RMAP_GEOMETRY_SHAPE && rmap_shape_model[geometry->shape.type].revolved;
    const double across = is_round ? fmax(half.x, half.y) : hypot(half.x, half.y);
    *centre = rmap_affine_point(&object->to_world, rmap_scale(rmap_add(lower, upper), 0.5));
    double stretch = 0;
    for (int j = 0; j < 3; j++)
        stretch =
            fmax(stretch, rmap_length(rmap_vec3(object->to_world.m[0][j], object->to_world.m[1][j],
                                                object->to_world.m[2][j])));
    return hypot(across, half.z) * stretch;
}

/* A sphere about all objects. */
static double enclose_all(const struct rmap_scene *scene, struct rmap_vec3 *centre)
{
    struct rmap_bounds box = rmap_bounds_empty();
    for (size_t i = 0; i < scene->n_object; i++)
        rmap_bounds_include_geometry(&box, &scene->geometry[scene->object[i].geometry],
                                     &scene->object[i].to_world);
    *centre = rmap_scale(rmap_add(box.lower, box.upper), 0.5);
    return 0.5 * rmap_length(rmap_sub(box.upper, box.lower));
}

/* Field angles from the object's axis, its local z, towards its x and y; one number is towards y.
 */
static bool read_field(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                       const struct rmap_affine *to_world, struct rmap_vec3 *direction)
{
    static const struct rmap_range angle = {-89, 89, "an angle between -89 and 89 degrees",
                                            RMAP_DIMENSION_ANGLE};
    double field[2] = {0, 0};
    size_t n = 0;
    if (!rmap_reader_numbers(reader, node, "field", RMAP_OPTIONAL, &angle, 1, 2, field, &n))
        return false;
    if (n == 1) {
        field[1] = field[0];
        field[0] = 0;
    }
    struct rmap_vec3 axis[3];
    rmap_placement_axes(to_world, axis);
    const double degree = RMAP_PI / 180;
    *direction = rmap_normalize(rmap_axpy(tan(field[0] * degree), axis[0],
                                          rmap_axpy(tan(field[1] * degree), axis[1], axis[2])));
    return true;
}

bool rmap_reader_aim_source(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            struct rmap_source *source)
{
    static const char *const other[] = {"shape", "at", "direction", "rotate", "matrix"};
    const struct rmap_yaml_node *fills = rmap_yaml_get(node, "fills");
    const struct rmap_yaml_node *field = rmap_yaml_get(node, "field");
    if (!fills && field)
        rmap_reader_error(reader, field,
                          "'field' is the angle to the axis of what the source fills: "
                          "give 'fills', the name of a lens or an object, too");
    if (!fills)
        return field != NULL;
    source->fills = true;
    for (size_t i = 0; i < RMAP_COUNT(other); i++)
        if (rmap_yaml_get(node, other[i]))
            rmap_reader_error(reader, rmap_yaml_get(node, other[i]),
                              "give 'fills' or '%s', not both", other[i]);
    if (!rmap_reader_text(reader, node, "fills", RMAP_REQUIRED))
        return true;
    const int32_t target = find_target(reader, fills);
    struct rmap_vec3 centre, middle, direction;
    if (target < 0)
        return true;
    const struct rmap_object *object = &reader->scene->object[target];
    if (!read_field(reader, node, &object->to_world, &direction))
        return true;
    const double radius = enclose(reader->scene, object, &centre);
    const double reach = enclose_all(reader->scene, &middle);
    /* In front of everything: what stands in the way is in the light, too. */
    const double before = rmap_length(rmap_sub(centre, middle)) + reach + radius;
    source->shape = RMAP_EMITTER_DISC;
    source->shape_size[0] = radius + before * tan(source->cone_rad);
    source->frame = rmap_affine_frame(direction, rmap_axpy(-before, direction, centre));
    return true;
}

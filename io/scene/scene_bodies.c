/* SPDX-License-Identifier: MIT
 *
 * Closed bodies: `box` and `prism`, which become meshes, and tubes with caps, which stay exact.
 */
#include "io/scene/scene_bodies.h"

#include <math.h>
#include <stdio.h>

#include "base/alloc.h"
#include "geometry/prism.h"
#include "io/scene/scene_geometries.h"
#include "io/scene/scene_objects.h"

/* ---- meshes ---- */

static void name_face(struct rmap_reader *reader, struct rmap_mesh *mesh, size_t face,
                      const char *name)
{
    mesh->face_name[face] = rmap_reader_strdup(reader, name);
}

static struct rmap_mesh *make_prism(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                    const double (*corner)[2], size_t n, double length)
{
    struct rmap_mesh *mesh = NULL;
    rmap_reader_made(reader, node, rmap_mesh_prism(corner, n, length, &mesh, &reader->failure));
    if (!mesh)
        return NULL;
    name_face(reader, mesh, 0, "bottom");
    name_face(reader, mesh, 1, "top");
    return mesh;
}

struct rmap_mesh *rmap_reader_box(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    static const char *const side[] = {"-y", "+x", "+y", "-x"};
    double size[3];
    size_t n = 0;
    if (!rmap_reader_numbers(reader, node, "size", RMAP_REQUIRED, &rmap_range_positive_length, 3, 3,
                             size, &n))
        return NULL;
    const double x = size[0] / 2, y = size[1] / 2;
    const double corner[4][2] = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
    struct rmap_mesh *mesh = make_prism(reader, node, corner, 4, size[2]);
    for (size_t i = 0; mesh && i < RMAP_COUNT(side); i++)
        name_face(reader, mesh, 2 + i, side[i]);
    return mesh;
}

static size_t regular_polygon(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                              double (**corner_ret)[2])
{
    uint64_t n = 0;
    double radius = 0;
    if (!rmap_reader_whole(reader, node, "sides", 3, RMAP_PRISM_SIDES_MAX, &n) ||
        !rmap_reader_number(reader, node, "radius", RMAP_REQUIRED, &rmap_range_positive_length,
                            &radius))
        return 0;
    double(*corner)[2] = rmap_reader_alloc(reader, n, sizeof *corner);
    for (size_t i = 0; corner && i < n; i++) {
        corner[i][0] = radius * cos(2 * RMAP_PI * (double)i / (double)n);
        corner[i][1] = radius * sin(2 * RMAP_PI * (double)i / (double)n);
    }
    *corner_ret = corner;
    return corner ? n : 0;
}

static size_t polygon(struct rmap_reader *reader, const struct rmap_yaml_node *points,
                      double (**corner_ret)[2])
{
    const size_t n = points->n_item;
    if (!rmap_reader_check_list(reader, points, "'points'"))
        return 0;
    if (n < 3 || n > RMAP_PRISM_SIDES_MAX) {
        rmap_reader_error(reader, points, "'points' must be 3 to %d points [x, y], not %zu",
                          RMAP_PRISM_SIDES_MAX, n);
        return 0;
    }
    double(*corner)[2] = rmap_reader_alloc(reader, n, sizeof *corner);
    bool good = corner != NULL;
    for (size_t i = 0; corner && i < n; i++) {
        const struct rmap_yaml_node *point = points->item[i].value;
        bool pair = point->kind == RMAP_YAML_LIST && point->n_item == 2;
        if (!pair)
            rmap_reader_error(reader, point, "a point must be a list [x, y]");
        for (size_t k = 0; pair && k < 2; k++)
            pair &= rmap_reader_scalar(reader, point->item[k].value, "a coordinate",
                                       &rmap_range_length, &corner[i][k]);
        good &= pair;
    }
    *corner_ret = corner;
    return good ? n : 0;
}

struct rmap_mesh *rmap_reader_prism(struct rmap_reader *reader, const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node *points = rmap_yaml_get(node, "points");
    double(*corner)[2] = NULL, length = 0;
    char name[32];
    bool regular = rmap_yaml_get(node, "sides") != NULL;
    bool good = rmap_reader_number(reader, node, "length", RMAP_REQUIRED,
                                   &rmap_range_positive_length, &length);
    if (!points == !regular || (points && rmap_yaml_get(node, "radius"))) {
        rmap_reader_error(reader, node,
                          "a prism has 'points', or 'sides' and 'radius' for a regular one");
        return NULL;
    }
    size_t n = points ? polygon(reader, points, &corner) : regular_polygon(reader, node, &corner);
    struct rmap_mesh *mesh = good && n ? make_prism(reader, points ? points : node,
                                                    (const double(*)[2])corner, n, length)
                                       : NULL;
    for (size_t i = 0; mesh && i < n; i++) {
        (void)snprintf(name, sizeof name, "side.%zu", i + 1);
        name_face(reader, mesh, 2 + i, name);
    }
    return mesh;
}

/* ---- closed tubes ---- */

enum { NAME_NBYTES = 256 };

static void add_cap(struct rmap_reader *reader, const char *tube, const char *end, double radius,
                    int32_t *geometry)
{
    const struct rmap_shape disc = {.type = RMAP_SHAPE_DISC, .aperture = radius};
    char name[NAME_NBYTES];
    if (!(radius > 0))
        return;
    (void)snprintf(name, sizeof name, "%s.%s", tube, end);
    rmap_reader_add_shape(reader, name, &disc, geometry);
}

void rmap_reader_add_caps(struct rmap_reader *reader, const struct rmap_shape *tube,
                          struct rmap_geometry_entry *entry)
{
    entry->closed = true;
    entry->length = tube->length;
    entry->bottom = entry->top = -1;
    add_cap(reader, entry->name, "bottom", tube->radius, &entry->bottom);
    add_cap(reader, entry->name, "top", tube->radius2, &entry->top);
}

static void add_part(struct rmap_reader *reader, const struct rmap_object_plan *plan, int32_t group,
                     const char *name, int32_t geometry, const struct rmap_affine *placement)
{
    struct rmap_object_plan part = *plan;
    char full[NAME_NBYTES];
    if (geometry < 0)
        return;
    (void)snprintf(full, sizeof full, "%s.%s", plan->name, name);
    part.name = full;
    part.derived = true;
    part.parent = group;
    part.geometry = geometry;
    part.to_world = rmap_affine_compose(&plan->to_world, placement);
    part.placement = placement;
    part.element_back = &plan->to_world;
    rmap_reader_add_object(reader, &part);
}

void rmap_reader_expand_closed(struct rmap_reader *reader, const struct rmap_geometry_entry *entry,
                               const struct rmap_object_plan *plan)
{
    const struct rmap_vec3 none = {0, 0, 0}, end = {0, 0, entry->length};
    const struct rmap_affine here = rmap_affine_identity();
    /* Half a turn about x: the disc's front is the outside. */
    const struct rmap_affine down = rmap_affine_placement(rmap_vec3(1, -1, -1), none, none);
    const struct rmap_affine up = rmap_affine_placement(rmap_vec3(1, 1, 1), none, end);
    int32_t group = -1;
    rmap_reader_add_group(reader, plan->name, plan->node, plan->parent, &plan->to_world,
                          plan->placement, false, &group);
    add_part(reader, plan, group, "side", entry->geometry, &here);
    add_part(reader, plan, group, "bottom", entry->bottom, &down);
    add_part(reader, plan, group, "top", entry->top, &up);
}

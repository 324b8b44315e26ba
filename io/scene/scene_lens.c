/* SPDX-License-Identifier: MIT
 *
 * `lens`: the table of a prescription.
 */
#include <math.h>
#include <stdarg.h>
#include <stdio.h>

#include "geometry/sag.h"
#include "io/scene/scene_geometries.h"
#include "io/scene/scene_keys.h"
#include "io/scene/scene_lens.h"
#include "io/scene/scene_media.h"
#include "io/scene/scene_objects.h"
#include "io/scene/scene_reader.h"
#include "io/scene/scene_surfaces.h"

const struct rmap_mapping rmap_lens_row_keys = {
    "lens",
    NULL,
    {{"a row of a lens",
      "radius curvature thickness medium aperture conic asphere toroid zernike xy "
      "qcon qbfs fresnel stop surface"}}};

static const struct rmap_range thickness_range = {0, RMAP_OBJECTS_RADIUS_MAX, "0 or greater",
                                                  RMAP_DIMENSION_LENGTH};

static void read_row(struct rmap_reader *reader, const struct rmap_yaml_node *node, bool last,
                     double *thickness, struct rmap_lens_row *row, bool *good)
{
    row->node = node;
    row->geometry = row->stop_geometry = -1;
    for (int side = 0; side < 4; side++)
        row->edge_geometry[side] = -1;
    row->medium = row->surface_front = row->surface_back = -1;
    *good = rmap_reader_known(reader, node, &rmap_lens_row_keys, 0);
    if (!*good)
        return;
    *good = rmap_reader_conic(reader, node, &row->shape);
    *good &= rmap_reader_number(reader, node, "thickness", last ? RMAP_OPTIONAL : RMAP_REQUIRED,
                                &thickness_range, thickness);
    *good &= rmap_reader_bool(reader, node, "stop", &row->stop);
    if (!rmap_yaml_get(node, "medium"))
        rmap_reader_error(reader, node, "'medium' is missing: name the medium after the surface");
    rmap_reader_medium(reader, node, "medium", &row->medium);
    rmap_reader_surface_pair(reader, node, "surface", &row->surface_front, &row->surface_back);
    *good &= row->medium >= 0;
    const struct rmap_aperture outline = rmap_shape_outline(&row->shape);
    if (*good && row->stop && !rmap_aperture_is_circle(&outline)) {
        rmap_reader_error(reader, node,
                          "the plate of a stop has a round hole: give the row a radius for its "
                          "aperture, and its shape to a plate of its own");
        *good = false;
    }
}

/* Of places over both apertures the one where the second surface lies least behind the first: of
 * surfaces of revolution at the smaller rim. How far from the axis it is. */
static double tightest(const struct rmap_lens_row *a, const struct rmap_lens_row *b, double z[2])
{
    enum { AROUND = 64, INWARD = 8 };
    const struct rmap_aperture outline[2] = {rmap_shape_outline(&a->shape),
                                             rmap_shape_outline(&b->shape)};
    double r = fmin(a->shape.aperture, b->shape.aperture);
    z[0] = a->z + rmap_shape_sag(&a->shape, r);
    z[1] = b->z + rmap_shape_sag(&b->shape, r);
    if (rmap_shape_is_revolved(&a->shape) && rmap_shape_is_revolved(&b->shape))
        return r;
    z[1] = HUGE_VAL;
    for (int i = 0; i < 2 * AROUND * INWARD; i++) {
        const struct rmap_vec3 p = rmap_aperture_chart(
            &outline[i % 2], (double)(i / 2 % AROUND) / AROUND, (double)(i / 2 / AROUND) / INWARD);
        const double za = a->z + rmap_shape_height(&a->shape, p.x, p.y),
                     zb = b->z + rmap_shape_height(&b->shape, p.x, p.y);
        if (!rmap_aperture_has(&outline[1 - i % 2], p.x, p.y) || zb - za >= z[1] - z[0])
            continue;
        z[0] = za;
        z[1] = zb;
        r = hypot(p.x, p.y);
    }
    return r;
}

/* Where both surfaces stand, the second must not lie before the first: rays would meet them in
 * the wrong order. */
static void check_order(struct rmap_reader *reader, const struct rmap_lens *lens, size_t k)
{
    const struct rmap_lens_row *a = &lens->row[k], *b = &lens->row[k + 1];
    double z[2];
    const double r = tightest(a, b, z), za = z[0], zb = z[1];
    double slack = 1e-9 * (fabs(za) + fabs(zb) + r);
    if (!(za > zb + slack))
        return;
    bool plate =
        (a->stop && rmap_shape_is_flat(&a->shape)) || (b->stop && rmap_shape_is_flat(&b->shape));
    if (plate)
        rmap_reader_warn(reader, b->node,
                         "rows %zu and %zu cross at radius %g: the plate of the stop cuts the "
                         "surface beside it",
                         k + 1, k + 2, r);
    else
        rmap_reader_error(reader, b->node,
                          "rows %zu and %zu cross at radius %g (by %g): make the thickness "
                          "larger or an aperture smaller",
                          k + 1, k + 2, r, za - zb);
}

static void read_rows(struct rmap_reader *reader, const struct rmap_yaml_node *rows,
                      struct rmap_lens *lens, bool *good)
{
    double z = 0;
    lens->row = rmap_reader_alloc(reader, rows->n_item, sizeof *lens->row);
    if (!lens->row)
        return;
    size_t n_stop = 0;
    lens->n_row = rows->n_item;
    for (size_t k = 0; k < lens->n_row; k++) {
        struct rmap_lens_row *row = &lens->row[k];
        double thickness = 0;
        bool row_good = false;
        read_row(reader, rows->item[k].value, k + 1 == lens->n_row, &thickness, row, &row_good);
        n_stop += row->stop;
        if (row->stop && n_stop == 2)
            rmap_reader_warn(reader, row->node,
                             "a second 'stop: true': both plates are there, and the smaller one "
                             "limits the light");
        *good &= row_good;
        if (!row_good)
            continue;
        row->z = z;
        row->rim_z = z + rmap_shape_sag(&row->shape, row->shape.aperture);
        lens->widest = fmax(lens->widest, row->shape.aperture);
        z += thickness;
    }
    for (size_t k = 0; *good && k + 1 < lens->n_row; k++)
        check_order(reader, lens, k);
}

void rmap_reader_read_lens(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           struct rmap_geometry_entry *entry)
{
    bool good = true;
    const struct rmap_yaml_node *rows = rmap_yaml_get(node, "surfaces");
    struct rmap_lens *lens = rmap_reader_alloc(reader, 1, sizeof *lens);
    if (!lens)
        return;
    lens->surface_front = lens->surface_back = lens->edge_front = lens->edge_back = -1;
    rmap_reader_surface_pair(reader, node, "surface", &lens->surface_front, &lens->surface_back);
    rmap_reader_surface_pair(reader, node, "edge", &lens->edge_front, &lens->edge_back);
    if (lens->surface_front < 0 || lens->surface_back < 0) {
        rmap_reader_builtin_surface(reader, RMAP_SURFACE_FRESNEL, &lens->surface_front);
        lens->surface_back = lens->surface_front;
    }
    if (lens->edge_front < 0 || lens->edge_back < 0) {
        rmap_reader_builtin_surface(reader, RMAP_SURFACE_ABSORBER, &lens->edge_front);
        lens->edge_back = lens->edge_front;
    }
    if (!rows)
        rmap_reader_error(reader, node, "'surfaces' is missing: list the rows of the table");
    else if (rmap_reader_check_list(reader, rows, "'surfaces'") && !rows->n_item)
        rmap_reader_error(reader, rows, "'surfaces' is empty: list the rows of the table");
    else if (rows->kind == RMAP_YAML_LIST) {
        read_rows(reader, rows, lens, &good);
        entry->lens = lens;
        entry->broken = !good;
    }
}

/* An instance of a prescription: a group of caps, edges and the stop's plate. Instances share the
 * geometries. */

struct expansion {
    struct rmap_reader *reader;
    struct rmap_lens *lens;
    const struct rmap_object_plan *plan; /* of the whole: name, place, surfaces of the caps */
    const char *geometry;                /* name of the prescription */
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
static struct rmap_affine shift_to(double z)
{
    return rmap_affine_placement(rmap_vec3(1, 1, 1), rmap_vec3(0, 0, 0), rmap_vec3(0, 0, z));
}

static struct rmap_affine frame_at(const struct expansion *e, double z)
{
    const struct rmap_affine shift = shift_to(z);
    return rmap_affine_compose(&e->plan->to_world, &shift);
}

/* A part of the instance at z of the lens's axis. */
static void add_part(struct expansion *e, const char *name, int32_t parent, int32_t geometry,
                     double z, const struct rmap_object_plan *sides)
{
    struct rmap_object_plan part = *sides;
    part.name = name;
    part.node = e->plan->node;
    part.parent = parent;
    part.geometry = geometry;
    const struct rmap_affine shift = shift_to(z);
    part.to_world = frame_at(e, z);
    part.placement = &shift;
    part.derived = true;
    part.in_lens = true;
    part.outside = e->outside;
    rmap_reader_add_object(e->reader, &part);
}

static bool is_hole(const struct expansion *e, size_t k)
{
    const struct rmap_lens_row *row = &e->lens->row[k];
    int32_t before = k ? e->lens->row[k - 1].medium : e->outside;
    return row->stop && rmap_shape_is_flat(&row->shape) && row->medium == before;
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
    const bool own = row->surface_front >= 0 && row->surface_back >= 0;
    const struct rmap_affine after = frame_at(e, row->z);
    const struct rmap_affine before = frame_at(e, element_z(e, k ? k - 1 : k));
    const struct rmap_object_plan sides = {
        .surface_front = own ? row->surface_front : e->plan->surface_front,
        .surface_back = own ? row->surface_back : e->plan->surface_back,
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
    struct rmap_object_plan sides = {.medium_front = RMAP_MEDIUM_ANY,
                                     .medium_back = RMAP_MEDIUM_ANY};
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
        rmap_reader_add_group(e->reader, name, e->plan->node, e->group, &e->plan->to_world, NULL,
                              true, &parent);
    } else {
        add_cap(e, k);
    }
    if (e->lens->row[k].stop)
        add_stop(e, k, parent);
}

/* The surface of revolution, or straight wall, between two rims, from its lower end, and on which
 * side of its normal the glass lies. Where the second rim lies before the first, the glass is
 * outside the cone. */
struct edge {
    struct rmap_shape shape;
    double z;
    bool exists, glass_in_front;
};

/* Between rims that are not plane. */
static struct edge wall_between(struct rmap_reader *reader, const struct rmap_lens_row *a,
                                const struct rmap_lens_row *b, int side)
{
    const struct rmap_aperture outline = rmap_shape_outline(&a->shape),
                               other = rmap_shape_outline(&b->shape);
    struct edge edge = {.exists = false, .z = a->z};
    struct rmap_sag *sag = rmap_reader_alloc(reader, 2, sizeof *sag);
    if (!sag)
        return edge;
    if (!rmap_aperture_same(&outline, &other)) {
        rmap_reader_error(
            reader, b->node,
            "this row and the one before it need the same aperture, as the edge of a "
            "body between rims that are no circles about the axis is a straight wall: "
            "give both the outline that the body is cut to, and what is clear of it by "
            "a screen (an object with a hole) in front");
        return edge;
    }
    rmap_shape_as_sag(&a->shape, &sag[0]);
    rmap_shape_as_sag(&b->shape, &sag[1]);
    const char *wrong =
        rmap_shape_of_wall(&edge.shape, &sag[0], &sag[1], b->z - a->z, &outline, side);
    if (wrong)
        rmap_reader_error(reader, b->node, "this is no edge: %s", wrong);
    edge.exists = !wrong;
    return edge;
}

static struct edge edge_between(struct rmap_reader *reader, const struct rmap_lens_row *a,
                                const struct rmap_lens_row *b, int side)
{
    if (!rmap_shape_is_revolved(&a->shape) || !rmap_shape_is_revolved(&b->shape))
        return wall_between(reader, a, b, side);
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

static void add_edge(struct expansion *e, size_t k, size_t next, int side)
{
    struct rmap_lens_row *row = &e->lens->row[k];
    const struct edge edge = edge_between(e->reader, row, &e->lens->row[next], side);
    if (!edge.exists)
        return;
    char *name = compose(e->reader, "%s.edge.%d", e->plan->name, ++e->n_edge);
    if (!name)
        return;
    if (row->edge_geometry[side] < 0) {
        char *shape_name = compose(e->reader, "%s.edge.%d", e->geometry, ++e->lens->n_edge);
        if (!shape_name)
            return;
        rmap_reader_add_shape(e->reader, shape_name, &edge.shape, &row->edge_geometry[side]);
    }
    const struct rmap_affine element = frame_at(e, element_z(e, k));
    /* The edge's `front` surface is the outer one. */
    const struct rmap_object_plan sides = {
        .surface_front = edge.glass_in_front ? e->edge_back : e->edge_front,
        .surface_back = edge.glass_in_front ? e->edge_front : e->edge_back,
        .medium_front = edge.glass_in_front ? row->medium : e->outside,
        .medium_back = edge.glass_in_front ? e->outside : row->medium,
        .element_front = edge.glass_in_front ? &element : NULL,
        .element_back = edge.glass_in_front ? NULL : &element,
    };
    add_part(e, name, e->group, row->edge_geometry[side], edge.z, &sides);
}

/* Of a rectangle its four sides. */
static void add_edges(struct expansion *e, size_t k, size_t next)
{
    const struct rmap_shape *shape = &e->lens->row[k].shape;
    const bool sides = shape->type == RMAP_SHAPE_SAG && shape->outline.rectangle;
    for (int side = 0; side < (sides ? 4 : 1) && !e->reader->diagnostics->n_error; side++)
        add_edge(e, k, next, side);
}

void rmap_reader_expand_lens(struct rmap_reader *reader, const struct rmap_geometry_entry *entry,
                             const struct rmap_object_plan *plan, int32_t outside)
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
    rmap_reader_add_group(reader, plan->name, plan->node, plan->parent, &plan->to_world,
                          plan->placement, false, &e.group);
    for (size_t k = 0; k < lens->n_row; k++)
        add_row(&e, k);
    for (size_t k = 0, next; k + 1 < lens->n_row; k = next) {
        next = k + 1;
        while (next + 1 < lens->n_row && is_hole(&e, next))
            next++;
        if (!is_hole(&e, k) && !is_hole(&e, next) && lens->row[k].medium != outside)
            add_edges(&e, k, next);
    }
}

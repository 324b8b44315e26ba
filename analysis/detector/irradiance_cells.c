/* SPDX-License-Identifier: MIT
 *
 * The surface of objects, cut into cells.
 */
#include "analysis/detector/irradiance_cells.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "analysis/criterion/criterion_names.h"
#include "base/alloc.h"
#include "scene/bounds.h"

/* Cells are so long, as a part of the box about the objects, where nobody says. */
static const double USUAL_PART = 1.0 / 40.0;

/* Rows of a curved profile, and cells around an axis, at least: that bodies look round; and how
 * many cells of one row lie at a cell of the next, at most. */
enum { ROWS_MIN = 6, AROUND_MIN = 6, PROFILE_STEPS = 64, FINER_MAX = 16 };

static enum rmap_status add_cell(struct rmap_irradiance_cells *self,
                                 const struct rmap_irradiance_cell *given,
                                 const struct rmap_vec3 *corner, struct rmap_error *err)
{
    if (self->n_cell == RMAP_IRRADIANCE_CELLS_MAX)
        return rmap_error_set(err, RMAP_USAGE,
                              "more than %u cells no longer than %.4g %s: ask for longer --cells",
                              RMAP_IRRADIANCE_CELLS_MAX, self->shape_length, self->scene->unit);
    enum rmap_status st = RMAP_RESERVE(self->cell, self->cap_cell, self->n_cell + 1, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->corner, self->cap_corner, self->n_corner + given->n_corner, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_irradiance_cell *cell = &self->cell[self->n_cell++];
    *cell = *given;
    cell->part = (uint32_t)self->n_part - 1;
    cell->corner = self->n_corner;
    for (uint32_t k = 0; k < given->n_corner; k++)
        self->corner[self->n_corner++] = corner[k];
    self->part[cell->part].area += cell->area;
    self->part[cell->part].n++;
    return RMAP_OK;
}

/* ---- meshes ---- */

static enum rmap_status split(struct rmap_irradiance_cells *self, size_t node, int32_t triangle,
                              const struct rmap_vec3 c[3], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint32_t edge = 0;
    double longest = 0.0;
    for (uint32_t k = 0; k < 3; k++) {
        const double length = rmap_length(rmap_sub(c[(k + 1) % 3], c[k]));
        if (length > longest) {
            longest = length;
            edge = k;
        }
    }
    if (!(longest > self->length)) {
        const struct rmap_vec3 across = rmap_cross(rmap_sub(c[1], c[0]), rmap_sub(c[2], c[0]));
        self->node[node] =
            (struct rmap_irradiance_node){(uint32_t)self->n_cell, RMAP_IRRADIANCE_LEAF};
        return add_cell(self,
                        &(struct rmap_irradiance_cell){
                            .area = 0.5 * rmap_length(across), .n_corner = 3, .triangle = triangle},
                        c, err);
    }
    const size_t half = self->n_node;
    const struct rmap_vec3 middle = rmap_scale(rmap_add(c[edge], c[(edge + 1) % 3]), 0.5);
    const struct rmap_vec3 first[3] = {c[edge], middle, c[(edge + 2) % 3]};
    const struct rmap_vec3 second[3] = {middle, c[(edge + 1) % 3], c[(edge + 2) % 3]};
    RMAP_TRY(RMAP_RESERVE(self->node, self->cap_node, half + 2, err));
    self->n_node += 2;
    self->node[node] = (struct rmap_irradiance_node){(uint32_t)half, edge};
    RMAP_TRY(split(self, half, triangle, first, err));
    RMAP_TRY(split(self, half + 1, triangle, second, err));
out:
    return st;
}

static void corners_of(const struct rmap_object *object, const struct rmap_mesh *mesh,
                       size_t triangle, struct rmap_vec3 corner[3])
{
    rmap_mesh_corners(mesh, triangle, corner);
    for (int k = 0; k < 3; k++)
        corner[k] = rmap_affine_point(&object->to_world, corner[k]);
}

static bool has_face(const struct rmap_irradiance_choice *choice, const struct rmap_mesh *mesh,
                     size_t triangle)
{
    const uint32_t face = mesh->face[triangle];
    const char *name = mesh->face_name[face];
    char number[16];
    bool found = choice->n_face == 0;
    (void)snprintf(number, sizeof number, "%u", (unsigned)face);
    for (size_t i = 0; i < choice->n_face && !found; i++)
        found = strcmp(choice->face[i], number) == 0 || (name && rmap_glob(choice->face[i], name));
    return found;
}

static enum rmap_status cut_mesh(struct rmap_irradiance_cells *self,
                                 const struct rmap_irradiance_choice *choice,
                                 const struct rmap_object *object, const struct rmap_mesh *mesh,
                                 struct rmap_error *err)
{
    const size_t first = self->n_node;
    enum rmap_status st =
        RMAP_RESERVE(self->node, self->cap_node, first + mesh->n_triangle + 1, err);
    self->n_node += mesh->n_triangle;
    for (size_t i = 0; i < mesh->n_triangle && st == RMAP_OK; i++) {
        struct rmap_vec3 corner[3];
        corners_of(object, mesh, i, corner);
        self->node[first + i] = (struct rmap_irradiance_node){0, RMAP_IRRADIANCE_NONE};
        if (has_face(choice, mesh, i))
            st = split(self, first + i, (int32_t)i, corner, err);
    }
    return st;
}

/* Where a point of the triangle's plane lies: shares of the corners, their sum 1. */
static void shares_of(const struct rmap_vec3 c[3], struct rmap_vec3 p, double share[3])
{
    const struct rmap_vec3 a = rmap_sub(c[1], c[0]), b = rmap_sub(c[2], c[0]);
    const struct rmap_vec3 d = rmap_sub(p, c[0]), n = rmap_cross(a, b);
    const double whole = rmap_dot(n, n);
    share[1] = rmap_dot(rmap_cross(d, b), n) / whole;
    share[2] = rmap_dot(rmap_cross(a, d), n) / whole;
    share[0] = 1.0 - share[1] - share[2];
}

static size_t find_in_triangle(const struct rmap_irradiance_cells *self,
                               const struct rmap_irradiance_node *node,
                               const struct rmap_vec3 corner[3], struct rmap_vec3 place)
{
    double share[3];
    if (node->edge >= RMAP_IRRADIANCE_LEAF)
        return node->edge == RMAP_IRRADIANCE_LEAF ? node->at : SIZE_MAX;
    shares_of(corner, place, share);
    while (node->edge != RMAP_IRRADIANCE_LEAF) {
        const double i = share[node->edge], j = share[(node->edge + 1) % 3];
        share[2] = share[(node->edge + 2) % 3];
        share[0] = i >= j ? i - j : 2.0 * i;
        share[1] = i >= j ? 2.0 * j : j - i;
        node = &self->node[node->at + (i >= j ? 0 : 1)];
    }
    return node->at;
}

/* ---- shapes: u around the axis, or along x; v along the profile, or y; both 0 to 1 ---- */

static struct rmap_vec3 chart(const struct rmap_shape *shape, double u, double v)
{
    double r = 0.0, z = 0.0;
    switch (shape->type) {
    case RMAP_SHAPE_RECTANGLE:
        return rmap_vec3((u - 0.5) * shape->size[0], (v - 0.5) * shape->size[1], 0.0);
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC: /* inwards, so that u, v and the normal are right-handed */
        r = shape->aperture + v * (shape->inner - shape->aperture);
        z = shape->type == RMAP_SHAPE_CONIC ? rmap_shape_sag(shape, r) : 0.0;
        z = isfinite(z) ? z : 0.0;
        break;
    case RMAP_SHAPE_TUBE:
        r = shape->radius + v * (shape->radius2 - shape->radius);
        z = v * shape->length;
        break;
    case RMAP_SHAPE_SPHERE:
        r = shape->radius * sin(RMAP_PI * v);
        z = -shape->radius * cos(RMAP_PI * v);
        break;
    }
    return rmap_vec3(r * cos(2.0 * RMAP_PI * u), r * sin(2.0 * RMAP_PI * u), z);
}

static void find_on_chart(const struct rmap_shape *shape, struct rmap_vec3 p, double *u, double *v)
{
    const double r = sqrt(p.x * p.x + p.y * p.y);
    *u = atan2(p.y, p.x) / (2.0 * RMAP_PI);
    *u -= floor(*u);
    switch (shape->type) {
    case RMAP_SHAPE_RECTANGLE:
        *u = p.x / shape->size[0] + 0.5;
        *v = p.y / shape->size[1] + 0.5;
        break;
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC:
        *v = (shape->aperture - r) / (shape->aperture - shape->inner);
        break;
    case RMAP_SHAPE_TUBE:
        *v = p.z / shape->length;
        break;
    case RMAP_SHAPE_SPHERE:
        *v = atan2(r, -p.z) / RMAP_PI;
        break;
    }
}

/* A shape in its place. */
struct body {
    const struct rmap_shape *shape;
    const struct rmap_affine *to_world;
    double size; /* length of its profile */
};

static struct rmap_vec3 at(const struct body *body, double u, double v)
{
    return rmap_affine_point(body->to_world, chart(body->shape, u, v));
}

/* Length in the world of a line of constant u or v. */
static double line_length(const struct body *body, bool along_v, double other)
{
    double length = 0.0;
    struct rmap_vec3 from = {0, 0, 0};
    for (int k = 0; k <= PROFILE_STEPS; k++) {
        const double x = (double)k / PROFILE_STEPS;
        const struct rmap_vec3 to = along_v ? at(body, other, x) : at(body, x, other);
        length += k > 0 ? rmap_length(rmap_sub(to, from)) : 0.0;
        from = to;
    }
    return length;
}

/* Of the patch between two corners of the chart, by n x n plane pieces. */
static double pieces_area(const struct body *body, const double low[2], const double high[2], int n)
{
    double area = 0.0;
    for (int i = 0; i < n; i++)
        for (int j = 0; j < n; j++) {
            struct rmap_vec3 p[4];
            for (int k = 0; k < 4; k++)
                p[k] = at(body, low[0] + (high[0] - low[0]) * (i + (k & 1)) / n,
                          low[1] + (high[1] - low[1]) * (j + (k >> 1)) / n);
            area += 0.5 * rmap_length(rmap_cross(rmap_sub(p[3], p[0]), rmap_sub(p[2], p[1])));
        }
    return area;
}

/* Their error falls with the square of n, and its first term is taken out (Richardson 1911). */
static double patch_area(const struct body *body, const double low[2], const double high[2])
{
    return (4.0 * pieces_area(body, low, high, 4) - pieces_area(body, low, high, 2)) / 3.0;
}

/* Corners along a row's border; n: cells of the finer of the rows there. At a pole it is one. */
static uint32_t put_border(const struct body *body, double from, double to, double v, uint32_t n,
                           struct rmap_vec3 *corner)
{
    const uint32_t parts = (uint32_t)rint(fabs(to - from) * n);
    for (uint32_t k = 0; k <= parts; k++)
        corner[k] = at(body, from + (to - from) * k / parts, v);
    const bool pole = !(rmap_length(rmap_sub(corner[parts], corner[0])) > 1e-9 * body->size);
    return pole ? 1 : parts + 1;
}

/* As many around as keep cells short: rows next to each other differ by powers of two. */
static uint32_t cells_across(const struct rmap_irradiance_cells *self, const struct body *body,
                             const double v[2])
{
    const double longest = fmax(line_length(body, false, v[0]), line_length(body, false, v[1]));
    const double wanted = fmin(ceil(longest / self->shape_length), RMAP_IRRADIANCE_CELLS_MAX);
    uint32_t n = AROUND_MIN;
    if (!rmap_shape_model[body->shape->type].revolved)
        return wanted > 1.0 ? (uint32_t)wanted : 1;
    while (n < wanted)
        n *= 2;
    return n;
}

/* Of a cell, along both borders: a finer neighbour's corners are its own too, so that nothing
 * gapes. */
static enum rmap_status add_patch(struct rmap_irradiance_cells *self, const struct body *body,
                                  const double low[2], const double high[2],
                                  const uint32_t border[2], struct rmap_error *err)
{
    struct rmap_vec3 corner[2 * (FINER_MAX + 1)];
    uint32_t n = put_border(body, low[0], high[0], low[1], border[0], corner);
    n += put_border(body, high[0], low[0], high[1], border[1], corner + n);
    return add_cell(self,
                    &(struct rmap_irradiance_cell){
                        .area = patch_area(body, low, high), .n_corner = n, .triangle = -1},
                    corner, err);
}

static enum rmap_status cut_row(struct rmap_irradiance_cells *self, const struct body *body,
                                size_t row, const double v[2], const uint32_t border[2],
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint32_t n = self->row[row].n;
    self->row[row].first = self->n_cell;
    for (uint32_t j = 0; j < n && st == RMAP_OK; j++) {
        const double low[2] = {(double)j / n, v[0]}, high[2] = {(j + 1.0) / n, v[1]};
        st = add_patch(self, body, low, high, border, err);
    }
    return st;
}

static enum rmap_status cut_shape(struct rmap_irradiance_cells *self,
                                  const struct rmap_object *object, const struct rmap_shape *shape,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct body body = {.shape = shape, .to_world = &object->to_world};
    const struct rmap_shape_model *model = &rmap_shape_model[shape->type];
    const bool curved = shape->type == RMAP_SHAPE_CONIC || model->closed;
    body.size = fmax(line_length(&body, true, 0.0), line_length(&body, true, 0.25));
    const double wanted =
        fmin(ceil(body.size / self->shape_length), (double)RMAP_IRRADIANCE_CELLS_MAX);
    const size_t n = (size_t)fmax(wanted, curved ? ROWS_MIN : 1), first = self->n_row;
    RMAP_TRY(RMAP_RESERVE(self->row, self->cap_row, first + n, err));
    self->n_row += n;
    self->part[self->n_part - 1].n_row = n;
    for (size_t i = 0; i < n; i++) {
        const double v[2] = {(double)i / (double)n, (double)(i + 1) / (double)n};
        self->row[first + i].n = cells_across(self, &body, v);
    }
    for (size_t i = 0; i < n; i++) {
        const double v[2] = {(double)i / (double)n, (double)(i + 1) / (double)n};
        uint32_t border[2] = {self->row[first + i].n, self->row[first + i].n};
        for (int k = 0; k < 2; k++)
            if (k == 0 ? i > 0 : i + 1 < n) {
                const uint32_t beside = self->row[k == 0 ? first + i - 1 : first + i + 1].n;
                if (beside > border[k] && beside <= FINER_MAX * border[k])
                    border[k] = beside;
            }
        RMAP_TRY(cut_row(self, &body, first + i, v, border, err));
    }
out:
    return st;
}

/* ---- all ---- */

static enum rmap_status cut_object(struct rmap_irradiance_cells *self,
                                   const struct rmap_irradiance_choice *choice, size_t index,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_object *object = &self->scene->object[index];
    const struct rmap_geometry *geometry = &self->scene->geometry[object->geometry];
    const bool mesh = geometry->kind == RMAP_GEOMETRY_MESH;
    self->part_of[index] = (int32_t)self->n_part;
    self->part[self->n_part++] =
        (struct rmap_irradiance_part){.object = (int32_t)index,
                                      .first = self->n_cell,
                                      .look_up = mesh ? self->n_node : self->n_row};
    if (mesh)
        st = cut_mesh(self, choice, object, geometry->mesh, err);
    else if (choice->n_face == 0)
        st = cut_shape(self, object, &geometry->shape, err);
    if (self->part[self->n_part - 1].n == 0) {
        self->part_of[index] = -1;
        self->n_part--;
    }
    return st;
}

/* Why there are no cells. */
static enum rmap_status tell_faces(const struct rmap_irradiance_cells *self,
                                   const struct rmap_irradiance_choice *choice,
                                   struct rmap_error *err)
{
    char known[300] = "";
    size_t len = 0;
    for (size_t o = 0; o < self->scene->n_object && choice->n_face > 0; o++) {
        const struct rmap_mesh *mesh =
            choice->object[o] ? self->scene->geometry[self->scene->object[o].geometry].mesh : NULL;
        for (size_t f = 0; mesh && f < mesh->n_face && len < sizeof known / 2; f++)
            len += (size_t)snprintf(known + len, sizeof known - len, "%s%zu %.40s",
                                    len > 0 ? ", " : "", f,
                                    mesh->face_name[f] ? mesh->face_name[f] : "");
        if (len > 0)
            return rmap_error_set(err, RMAP_INPUT, "no face '%.60s': the mesh of '%.60s' has %s",
                                  choice->face[0], self->scene->object[o].name, known);
    }
    return rmap_error_set(err, RMAP_INPUT,
                          choice->n_face > 0 ? "--faces are of meshes, and none of these objects is"
                                             : "these objects have no surface");
}

enum rmap_status rmap_irradiance_cells_create(const struct rmap_scene *scene,
                                              const struct rmap_irradiance_choice *choice,
                                              struct rmap_irradiance_cells **cells_ret,
                                              struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bounds box = rmap_bounds_empty();
    struct rmap_irradiance_cells *self = rmap_alloc(1, sizeof *self);
    if (!self)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells");
    self->scene = scene;
    self->part_of = rmap_alloc(scene->n_object + 1, sizeof *self->part_of);
    self->part = rmap_alloc(scene->n_object + 1, sizeof *self->part);
    if (!self->part_of || !self->part)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells"));
    for (size_t o = 0; o < scene->n_object; o++)
        if (choice->object[o])
            rmap_bounds_include_geometry(&box, &scene->geometry[scene->object[o].geometry],
                                         &scene->object[o].to_world);
    const double usual = USUAL_PART * rmap_length(rmap_sub(box.upper, box.lower));
    self->length = choice->length > 0.0 ? choice->length : usual;
    self->shape_length = isfinite(self->length) ? self->length : usual;
    for (size_t o = 0; o < scene->n_object; o++) {
        self->part_of[o] = -1;
        if (choice->object[o])
            RMAP_TRY(cut_object(self, choice, o, err));
    }
    if (self->n_cell == 0)
        RMAP_TRY(tell_faces(self, choice, err));
    *cells_ret = self;
    self = NULL;
out:
    rmap_irradiance_cells_destroy(self);
    return st;
}

void rmap_irradiance_cells_destroy(struct rmap_irradiance_cells *self)
{
    if (!self)
        return;
    rmap_free(self->part_of);
    rmap_free(self->part);
    rmap_free(self->cell);
    rmap_free(self->row);
    rmap_free(self->node);
    rmap_free(self->corner);
    rmap_free(self);
}

static size_t step(double x, size_t n)
{
    return (size_t)fmin(fmax(floor(x * (double)n), 0.0), (double)(n - 1));
}

size_t rmap_irradiance_cells_find(const struct rmap_irradiance_cells *self, size_t part,
                                  struct rmap_vec3 place, int32_t primitive)
{
    const struct rmap_irradiance_part *of = &self->part[part];
    const struct rmap_object *object = &self->scene->object[of->object];
    const struct rmap_geometry *geometry = &self->scene->geometry[object->geometry];
    if (geometry->kind == RMAP_GEOMETRY_MESH) {
        struct rmap_vec3 corner[3];
        if (primitive < 0 || (size_t)primitive >= geometry->mesh->n_triangle)
            return SIZE_MAX;
        corners_of(object, geometry->mesh, (size_t)primitive, corner);
        return find_in_triangle(self, &self->node[of->look_up + (size_t)primitive], corner, place);
    }
    double u = 0.0, v = 0.0;
    find_on_chart(&geometry->shape, rmap_affine_point(&object->to_local, place), &u, &v);
    const struct rmap_irradiance_row *row = &self->row[of->look_up + step(v, of->n_row)];
    return row->first + step(u, row->n);
}

struct rmap_vec3 rmap_irradiance_cells_centre(const struct rmap_irradiance_cells *self, size_t cell)
{
    const struct rmap_irradiance_cell *of = &self->cell[cell];
    struct rmap_vec3 sum = {0, 0, 0};
    for (uint32_t k = 0; k < of->n_corner; k++)
        sum = rmap_add(sum, self->corner[of->corner + k]);
    return rmap_scale(sum, 1.0 / of->n_corner);
}

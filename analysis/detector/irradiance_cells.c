/* SPDX-License-Identifier: MIT
 *
 * The surface of objects, cut into cells.
 */
#include "analysis/detector/irradiance_facets.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "analysis/criterion/criterion_names.h"
#include "base/alloc.h"
#include "base/glob.h"
#include "scene/bounds.h"

/* Cells are so long, as a part of the box about the objects, where nobody says. */
static const double USUAL_PART = 1.0 / 40.0;

/* Triangles with edges shorter than this part of that are joined. */
static const double SMALL = 0.5;

/* Cubes are numbered up to here. */
static const double FARTHEST = 0x1p62;

enum rmap_status rmap_irradiance_too_many(const struct rmap_irradiance_cells *self,
                                          struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_USAGE,
                          "more than %u triangles or cells of %.4g %s: ask for longer --cells, "
                          "fewer objects or --faces",
                          RMAP_IRRADIANCE_CELLS_MAX, self->shape_length, self->scene->unit);
}

enum rmap_status rmap_irradiance_add_facet(struct rmap_irradiance_cells *self,
                                           const struct rmap_irradiance_facet *given,
                                           const struct rmap_vec3 *corner, struct rmap_error *err)
{
    if (self->n_facet == RMAP_IRRADIANCE_CELLS_MAX)
        return rmap_irradiance_too_many(self, err);
    enum rmap_status st = RMAP_RESERVE(self->facet, self->cap_facet, self->n_facet + 1, err);
    if (st == RMAP_OK)
        st = RMAP_RESERVE(self->corner, self->cap_corner, self->n_corner + given->n_corner, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_irradiance_facet *facet = &self->facet[self->n_facet++];
    *facet = *given;
    facet->corner = self->n_corner;
    for (uint32_t k = 0; k < given->n_corner; k++)
        self->corner[self->n_corner++] = corner[self->mirrored ? given->n_corner - 1 - k : k];
    self->part[self->n_part - 1].n_facet++;
    return RMAP_OK;
}

static struct rmap_vec3 centre_of(const struct rmap_irradiance_cells *self,
                                  const struct rmap_irradiance_facet *facet)
{
    struct rmap_vec3 sum = {0, 0, 0};
    for (uint32_t k = 0; k < facet->n_corner; k++)
        sum = rmap_add(sum, self->corner[facet->corner + k]);
    return rmap_scale(sum, 1.0 / facet->n_corner);
}

/* ---- joining: of facets that lie in one cube and look to the same of its sides ---- */

struct place {
    int64_t cube[3];
    int side; /* -1: by itself */
    size_t facet;
};

static struct place place_of(const struct rmap_irradiance_cells *self, size_t index)
{
    const struct rmap_irradiance_facet *facet = &self->facet[index];
    const struct rmap_vec3 *c = self->corner + facet->corner;
    struct place place = {.cube = {(int64_t)index}, .side = -1, .facet = index};
    double longest = 0.0;
    for (uint32_t k = 0; k < facet->n_corner; k++)
        longest = fmax(longest, rmap_length(rmap_sub(c[(k + 1) % facet->n_corner], c[k])));
    if (self->uv[0] > 0) {
        place.cube[0] = facet->cell;
        place.side = 0;
        return place;
    }
    if (facet->triangle < 0 || !(longest < SMALL * self->length) || !isfinite(self->length))
        return place;
    const struct rmap_vec3 middle = centre_of(self, facet);
    const struct rmap_vec3 normal = rmap_cross(rmap_sub(c[1], c[0]), rmap_sub(c[2], c[0]));
    const double m[3] = {middle.x, middle.y, middle.z}, n[3] = {normal.x, normal.y, normal.z};
    int most = 0;
    for (int k = 0; k < 3; k++) {
        place.cube[k] = (int64_t)fmin(fmax(floor(m[k] / self->length), -FARTHEST), FARTHEST);
        most = fabs(n[k]) > fabs(n[most]) ? k : most;
    }
    place.side = 2 * most + (n[most] > 0.0);
    return place;
}

static int by_place(const void *a, const void *b)
{
    const struct place *left = a, *right = b;
    if (left->side != right->side)
        return left->side < right->side ? -1 : 1;
    for (int k = 0; k < 3; k++)
        if (left->cube[k] != right->cube[k])
            return left->cube[k] < right->cube[k] ? -1 : 1;
    return (left->facet > right->facet) - (left->facet < right->facet);
}

static void take_in(struct rmap_irradiance_cells *self, struct rmap_irradiance_cell *cell,
                    struct rmap_irradiance_facet *facet)
{
    cell->triangle = cell->n_facet == 0 ? facet->triangle : -1;
    cell->n_facet++;
    cell->area += facet->area;
    cell->centre = rmap_axpy(facet->area, centre_of(self, facet), cell->centre);
    facet->cell = (uint32_t)(cell - self->cell);
}

/* Cells of the last part, of its facets. */
static enum rmap_status join(struct rmap_irradiance_cells *self, struct rmap_error *err)
{
    struct rmap_irradiance_part *part = &self->part[self->n_part - 1];
    const size_t n = part->n_facet;
    struct place *place = rmap_alloc(n + 1, sizeof *place);
    enum rmap_status st = place ? RMAP_RESERVE(self->cell, self->cap_cell, self->n_cell + n, err)
                                : rmap_error_set(err, RMAP_SYSTEM, "out of memory for cells");
    for (size_t i = 0; i < n && st == RMAP_OK; i++)
        place[i] = place_of(self, part->first_facet + i);
    if (st == RMAP_OK)
        qsort(place, n, sizeof *place, by_place);
    for (size_t i = 0; i < n && st == RMAP_OK; i++) {
        const bool same = i > 0 && place[i].side == place[i - 1].side &&
                          memcmp(place[i].cube, place[i - 1].cube, sizeof place[i].cube) == 0;
        if (!same)
            self->cell[self->n_cell++] = (struct rmap_irradiance_cell){
                .part = (uint32_t)self->n_part - 1, .uv = (uint32_t)place[i].cube[0]};
        take_in(self, &self->cell[self->n_cell - 1], &self->facet[place[i].facet]);
    }
    part->n = self->n_cell - part->first;
    for (size_t c = part->first; c < self->n_cell; c++) {
        struct rmap_irradiance_cell *cell = &self->cell[c];
        if (cell->area > 0.0)
            cell->centre = rmap_scale(cell->centre, 1.0 / cell->area);
        part->area += cell->area;
    }
    rmap_free(place);
    return st;
}

/* ---- meshes ---- */

static double area_of(const struct rmap_vec3 c[3])
{
    return 0.5 * rmap_length(rmap_cross(rmap_sub(c[1], c[0]), rmap_sub(c[2], c[0])));
}

/* More than there may be, even if all were equilateral. */
static bool is_too_large(const struct rmap_irradiance_cells *self, const struct rmap_vec3 c[3])
{
    return area_of(c) / RMAP_IRRADIANCE_CELLS_MAX > 0.25 * sqrt(3.0) * self->length * self->length;
}

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
        self->node[node] =
            (struct rmap_irradiance_node){(uint32_t)self->n_facet, RMAP_IRRADIANCE_LEAF};
        return rmap_irradiance_add_facet(self,
                                         &(struct rmap_irradiance_facet){.area = area_of(c),
                                                                         .n_corner = 3,
                                                                         .triangle = triangle},
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

void rmap_irradiance_corners(const struct rmap_object *object, const struct rmap_mesh *mesh,
                             size_t triangle, struct rmap_vec3 corner[3])
{
    rmap_mesh_corners(mesh, triangle, corner);
    for (int k = 0; k < 3; k++)
        corner[k] = rmap_affine_point(&object->to_world, corner[k]);
}

bool rmap_irradiance_has_face(const struct rmap_irradiance_choice *choice,
                              const struct rmap_mesh *mesh, size_t triangle)
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
        rmap_irradiance_corners(object, mesh, i, corner);
        self->node[first + i] = (struct rmap_irradiance_node){0, RMAP_IRRADIANCE_NONE};
        if (rmap_irradiance_has_face(choice, mesh, i))
            st = is_too_large(self, corner) ? rmap_irradiance_too_many(self, err)
                                            : split(self, first + i, (int32_t)i, corner, err);
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

/* ---- all ---- */

static enum rmap_status cut_object(struct rmap_irradiance_cells *self,
                                   const struct rmap_irradiance_choice *choice, size_t index,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_object *object = &self->scene->object[index];
    const struct rmap_geometry *geometry = &self->scene->geometry[object->geometry];
    const bool mesh = geometry->kind == RMAP_GEOMETRY_MESH;
    self->mirrored = rmap_affine_determinant(&object->to_world) < 0.0;
    self->part_of[index] = (int32_t)self->n_part;
    self->part[self->n_part++] =
        (struct rmap_irradiance_part){.object = (int32_t)index,
                                      .first = self->n_cell,
                                      .first_facet = self->n_facet,
                                      .look_up = mesh ? self->n_node : self->n_row};
    if (self->uv[0] > 0)
        st = rmap_irradiance_cut_uv(self, choice, object, geometry->mesh, err);
    else if (mesh)
        st = cut_mesh(self, choice, object, geometry->mesh, err);
    else if (choice->n_face == 0)
        st = rmap_irradiance_cut_shape(self, object, &geometry->shape, err);
    if (st == RMAP_OK)
        st = join(self, err);
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
    memcpy(self->uv, choice->uv, sizeof self->uv);
    self->shape_length = isfinite(self->length) ? self->length : usual;
    for (size_t o = 0; o < scene->n_object; o++) {
        self->part_of[o] = -1;
        if (choice->object[o])
            RMAP_TRY(cut_object(self, choice, o, err));
    }
    if (self->n_cell == 0)
        RMAP_TRY(tell_faces(self, choice, err));
    if (self->uv[0] > 0)
        RMAP_TRY(rmap_irradiance_index_uv(self, err));
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
    rmap_free(self->uv_cell);
    rmap_free(self->part);
    rmap_free(self->cell);
    rmap_free(self->facet);
    rmap_free(self->row);
    rmap_free(self->node);
    rmap_free(self->corner);
    rmap_free(self);
}

size_t rmap_irradiance_cells_find(const struct rmap_irradiance_cells *self, size_t part,
                                  struct rmap_vec3 place, int32_t primitive)
{
    const struct rmap_irradiance_part *of = &self->part[part];
    const struct rmap_object *object = &self->scene->object[of->object];
    const struct rmap_geometry *geometry = &self->scene->geometry[object->geometry];
    if (geometry->kind != RMAP_GEOMETRY_MESH)
        return self->facet[rmap_irradiance_find_on_shape(self, of, object, &geometry->shape, place)]
            .cell;
    struct rmap_vec3 corner[3];
    if (primitive < 0 || (size_t)primitive >= geometry->mesh->n_triangle)
        return SIZE_MAX;
    rmap_irradiance_corners(object, geometry->mesh, (size_t)primitive, corner);
    if (self->uv[0] > 0) {
        double share[3];
        shares_of(corner, place, share);
        return rmap_irradiance_find_by_uv(self, part, geometry->mesh, (size_t)primitive, share);
    }
    const struct rmap_irradiance_node *node = &self->node[of->look_up + (size_t)primitive];
    if (node->edge >= RMAP_IRRADIANCE_LEAF) /* whole, or none of the faces asked about */
        return node->edge == RMAP_IRRADIANCE_LEAF ? self->facet[node->at].cell : SIZE_MAX;
    return self->facet[find_in_triangle(self, node, corner, place)].cell;
}

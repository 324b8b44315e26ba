/* SPDX-License-Identifier: MIT
 *
 * Every geometry as a triangle mesh with shared vertices, for drawing: analytic surfaces are
 * tessellated, meshes welded.
 */
#include "analysis/figure/tessellation.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "geometry/sag.h"

enum { RINGS = 24 }; /* of a curved cap; half as many again from pole to pole of a sphere */

/* A surface of revolution: n points (radius, z) from first to last, turned about the axis. A
 * radius of 0 at an end is a pole. Triangles face the side that lies to the right when looking
 * along the profile with the axis on the left. */
struct profile {
    int n;
    double r[2 * RINGS + 1], z[2 * RINGS + 1];
};

static void put_vertex(struct rmap_mesh *mesh, size_t at, double x, double y, double z)
{
    mesh->vertex[at][0] = (float)x;
    mesh->vertex[at][1] = (float)y;
    mesh->vertex[at][2] = (float)z;
}

static void put_triangle(struct rmap_mesh *mesh, uint32_t a, uint32_t b, uint32_t c)
{
    if (a == b || b == c || a == c)
        return;
    uint32_t *corner = mesh->triangle[mesh->n_triangle++];
    corner[0] = a;
    corner[1] = b;
    corner[2] = c;
}

/* Vertex k around ring i; all of a pole's are one. */
static uint32_t on_ring(const struct profile *profile, int i, int k)
{
    bool pole = !(profile->r[i] > 0.0);
    return (uint32_t)(i * RMAP_FACETS + (pole ? 0 : k % RMAP_FACETS));
}

static enum rmap_status revolve(const struct profile *profile, struct rmap_mesh **mesh_ret,
                                struct rmap_error *err)
{
    struct rmap_mesh *mesh = NULL;
    size_t n_ring = (size_t)profile->n;
    enum rmap_status st =
        rmap_mesh_create(n_ring * RMAP_FACETS, 2 * (n_ring - 1) * RMAP_FACETS, 1, &mesh, err);
    if (st != RMAP_OK)
        return st;
    for (int i = 0; i < profile->n; i++)
        for (int k = 0; k < RMAP_FACETS; k++) {
            double angle = 2.0 * RMAP_PI * k / RMAP_FACETS, c = cos(angle), s = sin(angle);
            c = fabs(c) < 1e-12 ? 0.0 : c; /* cos(pi / 2) is not quite 0 */
            s = fabs(s) < 1e-12 ? 0.0 : s;
            put_vertex(mesh, (size_t)(i * RMAP_FACETS + k), profile->r[i] * c, profile->r[i] * s,
                       profile->z[i]);
        }
    mesh->n_triangle = 0;
    for (int i = 0; i + 1 < profile->n; i++)
        for (int k = 0; k < RMAP_FACETS; k++) {
            uint32_t a = on_ring(profile, i, k), b = on_ring(profile, i + 1, k);
            uint32_t c = on_ring(profile, i + 1, k + 1), d = on_ring(profile, i, k + 1);
            put_triangle(mesh, a, b, c);
            put_triangle(mesh, a, c, d);
        }
    *mesh_ret = mesh;
    return RMAP_OK;
}

static enum rmap_status tessellate_cap(const struct rmap_shape *shape, struct rmap_mesh **mesh_ret,
                                       struct rmap_error *err)
{
    struct profile profile = {.n = RINGS + 1};
    bool flat = shape->type == RMAP_SHAPE_DISC ||
                (!(fabs(shape->curvature) > 0.0) && shape->n_asphere == 0);
    if (flat)
        profile.n = 2;
    for (int i = 0; i < profile.n; i++) {
        double r = shape->inner + (shape->aperture - shape->inner) * i / (profile.n - 1);
        double z = flat ? 0.0 : rmap_shape_sag(shape, r);
        profile.r[i] = r;
        profile.z[i] = isfinite(z) ? z : 0.0;
    }
    return revolve(&profile, mesh_ret, err);
}

static enum rmap_status tessellate_tube(const struct rmap_shape *shape, struct rmap_mesh **mesh_ret,
                                        struct rmap_error *err)
{
    /* From the far end to the near one, so that triangles face outwards. */
    struct profile profile = {
        .n = 2, .r = {shape->radius2, shape->radius}, .z = {shape->length, 0.0}};
    return revolve(&profile, mesh_ret, err);
}

static enum rmap_status tessellate_sphere(const struct rmap_shape *shape,
                                          struct rmap_mesh **mesh_ret, struct rmap_error *err)
{
    struct profile profile = {.n = 2 * RINGS + 1};
    for (int i = 0; i < profile.n; i++) {
        double angle = RMAP_PI * i / (profile.n - 1);
        profile.r[i] = i == 0 || i == profile.n - 1 ? 0.0 : shape->radius * sin(angle);
        profile.z[i] = shape->radius * cos(angle);
    }
    return revolve(&profile, mesh_ret, err);
}

static enum rmap_status tessellate_rectangle(const struct rmap_shape *shape,
                                             struct rmap_mesh **mesh_ret, struct rmap_error *err)
{
    struct rmap_mesh *mesh = NULL;
    enum rmap_status st = rmap_mesh_create(4, 2, 1, &mesh, err);
    if (st != RMAP_OK)
        return st;
    double x = 0.5 * shape->size[0], y = 0.5 * shape->size[1];
    put_vertex(mesh, 0, -x, -y, 0.0);
    put_vertex(mesh, 1, x, -y, 0.0);
    put_vertex(mesh, 2, x, y, 0.0);
    put_vertex(mesh, 3, -x, y, 0.0);
    mesh->n_triangle = 0;
    put_triangle(mesh, 0, 1, 2);
    put_triangle(mesh, 0, 2, 3);
    *mesh_ret = mesh;
    return RMAP_OK;
}

/* Along a side of a rectangle there and back. */
static double around(const struct rmap_shape *shape, int k)
{
    const double u = (double)k / RMAP_FACETS;
    if (shape->type != RMAP_SHAPE_WALL || !shape->outline.rectangle)
        return u;
    const double on_side = 0.25 * (shape->side - 0.5 + (u < 0.5 ? 2.0 * u : 2.0 - 2.0 * u));
    return on_side - floor(on_side);
}

/* A sag or a wall: rings as of a surface of revolution, in the shape of the outline and at the
 * heights that the surface has. */
static enum rmap_status tessellate_outline(const struct rmap_shape *shape,
                                           struct rmap_mesh **mesh_ret, struct rmap_error *err)
{
    const bool wall = shape->type == RMAP_SHAPE_WALL;
    struct profile profile = {.n = wall ? 2 : RINGS + 1};
    for (int i = 0; i < profile.n; i++)
        profile.r[i] = wall || shape->outline.inner > 0.0 ? 1.0 : i;
    enum rmap_status st = revolve(&profile, mesh_ret, err);
    if (st != RMAP_OK)
        return st;
    for (int i = 0; i < profile.n; i++)
        for (int k = 0; k < RMAP_FACETS; k++) {
            const double v = wall ? 0.0 : 1.0 - (double)i / (profile.n - 1);
            struct rmap_vec3 p = rmap_aperture_chart(&shape->outline, around(shape, k), v);
            const int end = wall && i == 0; /* from the far end, so that triangles face outwards */
            p.z = rmap_sag_height(shape->sag[end], p.x, p.y).z + (end ? shape->length : 0.0);
            put_vertex(*mesh_ret, (size_t)(i * RMAP_FACETS + k), p.x, p.y, p.z);
        }
    return RMAP_OK;
}

enum rmap_status rmap_shape_tessellate(const struct rmap_shape *shape, struct rmap_mesh **mesh_ret,
                                       struct rmap_error *err)
{
    switch (shape->type) {
    case RMAP_SHAPE_CONIC:
    case RMAP_SHAPE_DISC:
        return tessellate_cap(shape, mesh_ret, err);
    case RMAP_SHAPE_RECTANGLE:
        return tessellate_rectangle(shape, mesh_ret, err);
    case RMAP_SHAPE_TUBE:
        return tessellate_tube(shape, mesh_ret, err);
    case RMAP_SHAPE_SPHERE:
        return tessellate_sphere(shape, mesh_ret, err);
    case RMAP_SHAPE_SAG:
    case RMAP_SHAPE_WALL:
        return tessellate_outline(shape, mesh_ret, err);
    }
    return rmap_error_set(err, RMAP_INTERNAL, "unknown shape %d", (int)shape->type);
}

struct corner {
    float at[3];
    uint32_t index;
};

static int by_place(const void *a, const void *b)
{
    const struct corner *left = a, *right = b;
    for (int k = 0; k < 3; k++)
        if (left->at[k] < right->at[k] || left->at[k] > right->at[k])
            return left->at[k] < right->at[k] ? -1 : 1;
    return (left->index > right->index) - (left->index < right->index);
}

static bool same_place(const struct corner *a, const struct corner *b)
{
    for (int k = 0; k < 3; k++)
        if (a->at[k] < b->at[k] || a->at[k] > b->at[k])
            return false;
    return true;
}

enum rmap_status rmap_mesh_weld(const struct rmap_mesh *mesh, struct rmap_mesh **mesh_ret,
                                struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_mesh *welded = NULL;
    struct corner *corner = rmap_alloc(mesh->n_vertex, sizeof *corner);
    uint32_t *same = rmap_alloc(mesh->n_vertex, sizeof *same);
    if (!corner || !same)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for drawing a mesh"));
    RMAP_TRY(rmap_mesh_create(mesh->n_vertex, mesh->n_triangle, 1, &welded, err));
    memcpy(welded->vertex, mesh->vertex, mesh->n_vertex * sizeof *mesh->vertex);
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        memcpy(corner[i].at, mesh->vertex[i], sizeof corner[i].at);
        corner[i].index = (uint32_t)i;
    }
    qsort(corner, mesh->n_vertex, sizeof *corner, by_place);
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        bool repeated = i > 0 && same_place(&corner[i], &corner[i - 1]);
        same[corner[i].index] = repeated ? same[corner[i - 1].index] : corner[i].index;
    }
    welded->n_triangle = 0;
    for (size_t i = 0; i < mesh->n_triangle; i++) {
        welded->face[welded->n_triangle] = mesh->face[i];
        put_triangle(welded, same[mesh->triangle[i][0]], same[mesh->triangle[i][1]],
                     same[mesh->triangle[i][2]]);
    }
    *mesh_ret = welded;
    welded = NULL;
out:
    rmap_mesh_destroy(welded);
    rmap_free(corner);
    rmap_free(same);
    return st;
}

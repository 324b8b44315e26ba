/* SPDX-License-Identifier: MIT
 *
 * The true surfaces of a mesh's faces.
 */
#include <stdlib.h>
#include <string.h>

#include "base/alloc.h"
#include "geometry/mesh.h"

static bool is_finite(double value)
{
    return value - value == 0;
}

const char *rmap_true_surface_finish(struct rmap_true_surface *surface)
{
    const struct rmap_vec3 at = surface->at, axis = surface->axis;
    const double radius = surface->radius, second = surface->second;
    const enum rmap_true_kind kind = surface->kind;
    if (kind == RMAP_TRUE_NONE)
        return NULL;
    if (!is_finite(at.x + at.y + at.z) || !is_finite(radius) || !is_finite(second))
        return "one of its numbers is not finite";
    if (!(fabs(rmap_length(axis) - 1) <= 1e-12))
        return "its axis has no direction";
    if ((kind == RMAP_TRUE_CYLINDER || kind >= RMAP_TRUE_SPHERE) && !(radius > 0))
        return "its radius must be > 0";
    if (kind == RMAP_TRUE_CONE && (!(radius >= 0) || second == 0))
        return "its radius must be >= 0 and its half angle not 0";
    if (kind == RMAP_TRUE_TORUS && !(second > 0))
        return "its smaller radius must be > 0";
    rmap_basis(axis, &surface->x, &surface->y);
    return NULL;
}

/* Faces of one surface: a modeller cuts a cylinder at its seam, or into halves. */

/* As a share of the lengths that a surface has. */
#define ALIKE 1e-12

static bool same_surface(const struct rmap_true_surface *a, const struct rmap_true_surface *b)
{
    struct rmap_vec3 off = rmap_sub(a->at, b->at);
    double size = rmap_length(a->at) + rmap_length(b->at) + a->radius + fabs(a->second);
    double along = rmap_dot(off, a->axis);
    if (a->kind != b->kind || fabs(a->radius - b->radius) > ALIKE * size ||
        fabs(a->second - b->second) > ALIKE * (size + 1))
        return false;
    if (a->kind == RMAP_TRUE_SPHERE)
        return rmap_length(off) <= ALIKE * size;
    double sine = rmap_length(rmap_cross(a->axis, b->axis));
    if (sine > ALIKE || (a->kind == RMAP_TRUE_CONE && rmap_dot(a->axis, b->axis) < 0))
        return false;
    if (a->kind == RMAP_TRUE_PLANE)
        return fabs(along) <= ALIKE * size;
    if (a->kind == RMAP_TRUE_CYLINDER)
        return rmap_length(rmap_axpy(-along, a->axis, off)) <= ALIKE * size;
    return rmap_length(off) <= ALIKE * size;
}

struct ordered {
    double radius;
    int kind;
    uint32_t face;
};

static int compare(const void *left, const void *right)
{
    const struct ordered *a = left, *b = right;
    if (a->kind != b->kind)
        return a->kind < b->kind ? -1 : 1;
    if (a->radius != b->radius)
        return a->radius < b->radius ? -1 : 1;
    return a->face < b->face ? -1 : a->face > b->face;
}

enum rmap_status rmap_mesh_share_surfaces(struct rmap_mesh *mesh, struct rmap_error *err)
{
    enum { LATEST = 256 }; /* of one radius, which surfaces are held against */
    if (!mesh->surface)
        return RMAP_OK;
    struct ordered *order = rmap_alloc(mesh->n_face, sizeof *order);
    if (!order)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for %zu faces", mesh->n_face);
    for (size_t i = 0; i < mesh->n_face; i++)
        order[i] = (struct ordered){mesh->surface[i].radius, mesh->surface[i].kind, (uint32_t)i};
    qsort(order, mesh->n_face, sizeof *order, compare);
    for (size_t i = 1; i < mesh->n_face; i++)
        for (size_t k = i > LATEST ? i - LATEST : 0; k < i; k++) {
            const struct rmap_true_surface *first = &mesh->surface[order[k].face];
            struct rmap_true_surface *own = &mesh->surface[order[i].face];
            if (!same_surface(first, own))
                continue;
            *own = *first;
            break;
        }
    rmap_free(order);
    return RMAP_OK;
}

/* The point of the surface that is nearest to one beside it. */
static struct rmap_vec3 nearest(const struct rmap_true_surface *surface, struct rmap_vec3 p,
                                struct rmap_vec3 *normal)
{
    double distance = rmap_true_distance(surface, p, normal);
    return rmap_axpy(-distance, *normal, p);
}

void rmap_mesh_lift(const struct rmap_mesh *mesh, size_t triangle, struct rmap_vec3 *point,
                    struct rmap_vec3 *normal)
{
    const struct rmap_true_surface *surface = rmap_mesh_surface(mesh, triangle);
    struct rmap_vec3 across;
    if (!surface)
        return;
    *point = nearest(surface, *point, &across);
    *normal = rmap_scale(across, rmap_dot(across, *normal) < 0 ? -1.0 : 1.0);
}

/* The distance is greatest near the middle of the triangle or of an edge: half as much again, and
 * what single precision takes from the corners. */
double rmap_mesh_bulge(const struct rmap_mesh *mesh, size_t triangle)
{
    const struct rmap_true_surface *surface = rmap_mesh_surface(mesh, triangle);
    struct rmap_vec3 corner[3], across, far = {0, 0, 0};
    double most = 0;
    if (!surface)
        return 0;
    rmap_mesh_corners(mesh, triangle, corner);
    for (int k = 0; k < 3; k++) {
        struct rmap_vec3 middle = rmap_scale(rmap_add(corner[k], corner[(k + 1) % 3]), 0.5);
        most = rmap_max(most, fabs(rmap_true_distance(surface, middle, &across)));
        far = rmap_vec3(rmap_max(far.x, fabs(corner[k].x)), rmap_max(far.y, fabs(corner[k].y)),
                        rmap_max(far.z, fabs(corner[k].z)));
    }
    struct rmap_vec3 middle =
        rmap_scale(rmap_add(corner[0], rmap_add(corner[1], corner[2])), 1.0 / 3);
    most = rmap_max(most, fabs(rmap_true_distance(surface, middle, &across)));
    return 1.5 * most + 0x1p-21 * rmap_length(far);
}

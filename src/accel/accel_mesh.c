/* SPDX-License-Identifier: MIT
 *
 * The lower level of one mesh: Embree's tree, and what queries need of its triangles.
 */
#include <math.h>
#include <string.h>

#include "accel/accel_bottom.h"
#include "accel/accel_build.h"
#include "accel/accel_cell.h"
#include "base/alloc.h"

/* Embree's float test is not watertight where many triangles share a
 * corner that the ray meets from far away (0.2 % of rays aimed at vertices of a ball five radii
 * away slip through, ROBUST or not). So each triangle is handed over a little larger than it is,
 * by more than the float error, and Embree reports every triangle that the ray can possibly
 * cross; which one it is is decided in double. */

/* A triangle and its neighbour may both be seen edge on, and the float ray pass both: the farther
 * they reach, the flatter both must lie. As a share of the inscribed circle's radius; rays that
 * hit the margin only, a few in a hundred, cost a look at the neighbours where those may be seen
 * edge on. */
#define LEAST_MARGIN 0.003

/* By how much a triangle is widened in its plane; area: twice its own, perimeter: of its sides. */
static double margin_of(double area, double perimeter, double wider)
{
    return perimeter > 0 ? rmap_greater(LEAST_MARGIN * area / perimeter, wider) : wider;
}

/* At a corner between a and b the sides meet again, moved out by the margin, where it stands less
 * margin / sine * (a / |a| + b / |b|); |a| |b| sine is the area. */
static void widen(const struct rmap_mesh *mesh, size_t triangle, double wider, float out[9])
{
    struct rmap_vec3 corner[3], side[3]; /* from the k-th corner to the next */
    double length[3];
    rmap_mesh_corners(mesh, triangle, corner);
    for (int k = 0; k < 3; k++) {
        side[k] = rmap_sub(corner[(k + 1) % 3], corner[k]);
        length[k] = rmap_length(side[k]);
    }
    const double area = rmap_length(rmap_cross(side[0], side[1]));
    const double margin = margin_of(area, length[0] + length[1] + length[2], wider);
    for (int k = 0; k < 3; k++) {
        const int last = (k + 2) % 3;
        const double least = RMAP_NEEDLE_SINE * length[k] * length[last];
        struct rmap_vec3 p = corner[k];
        if (least > 0) {
            const double share = margin / rmap_greater(area, least);
            p = rmap_axpy(-share * length[last], side[k], p);
            p = rmap_axpy(share * length[k], side[last], p);
        }
        out[3 * k] = (float)p.x;
        out[3 * k + 1] = (float)p.y;
        out[3 * k + 2] = (float)p.z;
    }
}

static enum rmap_status check(const struct rmap_geometry *geometry, struct rmap_error *err)
{
    const struct rmap_mesh *mesh = geometry->mesh;
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            if (mesh->triangle[i][k] >= mesh->n_vertex)
                return rmap_error_set(err, RMAP_INPUT, "mesh '%s': triangle %zu has no vertex %u",
                                      geometry->name ? geometry->name : "", i,
                                      (unsigned)mesh->triangle[i][k]);
    return RMAP_OK;
}

/* Of one geometry, which it takes over. */
static enum rmap_status build_tree(struct rmap_accel *accel, RTCGeometry geometry,
                                   RTCScene *scene_ret, struct rmap_error *err)
{
    rtcCommitGeometry(geometry);
    *scene_ret = rtcNewScene(accel->device->embree);
    rtcSetSceneFlags(*scene_ret, RTC_SCENE_FLAG_NONE);
    rtcAttachGeometry(*scene_ret, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(*scene_ret);
    return rmap_accel_failed(accel, "building a mesh", err);
}

/* The boxes of cells. */
static void cell_bounds(const struct RTCBoundsFunctionArguments *args)
{
    const struct rmap_cells *cells = args->geometryUserPtr;
    const float *box = cells->box[args->primID];
    struct RTCBounds *to = args->bounds_o;
    to->lower_x = box[0];
    to->lower_y = box[1];
    to->lower_z = box[2];
    to->upper_x = box[3];
    to->upper_y = box[4];
    to->upper_z = box[5];
}

static enum rmap_status cells_tree(struct rmap_accel *accel, struct rmap_cells *cells,
                                   RTCScene *scene_ret, struct rmap_error *err)
{
    RTCGeometry user = rtcNewGeometry(accel->device->embree, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(
        user, (unsigned)(cells->whole.n_triangle - cells->whole.n_triangle_beyond));
    rtcSetGeometryUserData(user, cells);
    rtcSetGeometryBoundsFunction(user, cell_bounds, NULL);
    rtcSetGeometryIntersectFunction(user, rmap_accel_cell);
    return build_tree(accel, user, scene_ret, err);
}

/* Of the mesh's triangles, `wider` on every side. *widened_ret: these, which the tree uses;
 * rmap_free after it, whatever the status. */
static enum rmap_status widened_tree(struct rmap_accel *accel, const struct rmap_geometry *geometry,
                                     double wider, RTCScene *scene_ret, void **widened_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_mesh *mesh = geometry->mesh;
    const size_t n = mesh->n_triangle;
    RTCGeometry triangles = NULL;
    RMAP_TRY(check(geometry, err));
    triangles = rtcNewGeometry(accel->device->embree, RTC_GEOMETRY_TYPE_TRIANGLE);
    /* Memory of ours is on huge pages. Embree reads 16 bytes of the last corner. */
    float *vertex = rmap_alloc_unset(12 * n + 1, 4);
    if (!vertex)
        RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles", n));
    *widened_ret = vertex;
    uint32_t *index = (void *)(vertex + 9 * n + 1);
    rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, vertex, 0,
                               12, 3 * n);
    rtcSetSharedGeometryBuffer(triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, index, 0, 12,
                               n);
    RMAP_TRY(rmap_accel_failed(accel, "making room for a mesh", err));
    for (size_t i = 0; i < n; i++)
        widen(mesh, i, wider, &vertex[9 * i]);
    vertex[9 * n] = 0;
    for (size_t i = 0; i < 3 * n; i++)
        index[i] = (uint32_t)i;
    rtcSetGeometryIntersectFilterFunction(triangles, rmap_accel_triangle);
    st = build_tree(accel, triangles, scene_ret, err);
    triangles = NULL;
out:
    if (triangles)
        rtcReleaseGeometry(triangles);
    return st;
}

/* The triangles around each vertex of a mesh. Vertices at the same place are one, whether or not
 * the file shared them. */

/* A ray begins this share of the float error that it may be off behind its start: see
 * RMAP_REACH_ERRORS. */
#define LEAST_COSINE (4.0 / RMAP_REACH_ERRORS)

static bool same_place(const float a[3], const float b[3])
{
    return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

/* The same of both zeros. */
static size_t hash_of(const float at[3])
{
    uint64_t hash = 0;
    for (int k = 0; k < 3; k++) {
        const float number = at[k] + 0.0f;
        uint32_t bits;
        memcpy(&bits, &number, sizeof bits);
        hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
        hash ^= hash >> 32;
    }
    return (size_t)hash;
}

/* same[v]: the first vertex at the place of v. Slots of a table hold vertices plus 1. */
static bool join_vertices(const struct rmap_mesh *mesh, uint32_t *same)
{
    size_t n_slot = 4;
    while (n_slot < 2 * mesh->n_vertex)
        n_slot *= 2;
    uint32_t *slot = rmap_alloc(n_slot, sizeof *slot);
    if (!slot)
        return false;
    for (size_t i = 0; i < mesh->n_vertex; i++) {
        size_t at = hash_of(mesh->vertex[i]) & (n_slot - 1);
        while (slot[at] && !same_place(mesh->vertex[slot[at] - 1], mesh->vertex[i]))
            at = (at + 1) & (n_slot - 1);
        if (!slot[at])
            slot[at] = (uint32_t)i + 1;
        same[i] = slot[at] - 1;
    }
    rmap_free(slot);
    return true;
}

/* At RMAP_NEEDLE_SINE a triangle is not wide enough to be safe from any side. */
static void set_sight(const struct rmap_facets *facets, size_t i, double wider, float sight[4])
{
    struct rmap_vec3 corner[3];
    rmap_facets_corners(facets, (int32_t)i, corner);
    struct rmap_vec3 e1 = rmap_sub(corner[1], corner[0]), e2 = rmap_sub(corner[2], corner[0]);
    struct rmap_vec3 e0 = rmap_sub(e2, e1), n = rmap_cross(e1, e2);
    const double side[3] = {rmap_length(e0), rmap_length(e1), rmap_length(e2)};
    double area = rmap_length(n), cosine = HUGE_VAL;
    double longest = rmap_max(side[0], rmap_max(side[1], side[2]));
    if (area > RMAP_NEEDLE_SINE * longest * longest) {
        const double margin = margin_of(area, side[0] + side[1] + side[2], wider);
        cosine = rmap_max(wider / margin, LEAST_COSINE) * (1 + 1e-5);
        n = rmap_scale(n, 1 / area);
    }
    sight[0] = (float)n.x;
    sight[1] = (float)n.y;
    sight[2] = (float)n.z;
    sight[3] = (float)cosine;
}

static enum rmap_status facets_build(const struct rmap_mesh *mesh, double wider,
                                     struct rmap_facets *facets, struct rmap_error *err)
{
    facets->same = rmap_alloc_unset(mesh->n_vertex, sizeof(*facets->same));
    facets->first = rmap_alloc(mesh->n_vertex + 2, sizeof(*facets->first));
    facets->fan = rmap_alloc_unset(3 * mesh->n_triangle, sizeof(*facets->fan));
    facets->corner = rmap_alloc_unset(mesh->n_triangle, sizeof(*facets->corner));
    facets->sight = rmap_alloc_unset(mesh->n_triangle, sizeof(*facets->sight));
    if (!facets->corner || !facets->sight || !facets->same || !facets->first || !facets->fan ||
        !join_vertices(mesh, facets->same))
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh of %zu triangles",
                              mesh->n_triangle);
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            memcpy(&facets->corner[i][3 * k], mesh->vertex[mesh->triangle[i][k]],
                   sizeof(*mesh->vertex));
    /* counts two places on, so that filling them leaves the starts where they belong */
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            facets->first[facets->same[mesh->triangle[i][k]] + 2]++;
    for (size_t v = 2; v < mesh->n_vertex + 2; v++)
        facets->first[v] += facets->first[v - 1];
    for (size_t i = 0; i < mesh->n_triangle; i++)
        for (int k = 0; k < 3; k++)
            facets->fan[facets->first[facets->same[mesh->triangle[i][k]] + 1]++] = (uint32_t)i;
    for (size_t i = 0; i < mesh->n_triangle; i++)
        set_sight(facets, i, wider, facets->sight[i]);
    return RMAP_OK;
}

static void facets_release(struct rmap_facets *facets)
{
    rmap_free(facets->corner);
    rmap_free(facets->sight);
    rmap_free(facets->same);
    rmap_free(facets->first);
    rmap_free(facets->fan);
    rmap_cells_destroy(facets->cells);
}

void rmap_bottom_release(struct rmap_bottom *bottom)
{
    if (!bottom || bottom->n_more-- > 0)
        return;
    facets_release(&bottom->facets);
    if (bottom->scene)
        rtcReleaseScene(bottom->scene);
    rmap_free(bottom->widened);
    rmap_mesh_destroy(bottom->mesh);
    rmap_free(bottom);
}

/* Triangles are widened by the float error and the rounding of the widened corners. */
enum rmap_status rmap_bottom_create(struct rmap_accel *accel, const struct rmap_geometry *geometry,
                                    struct rmap_bottom **bottom_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_vec3 lower, upper;
    rmap_mesh_bounds(geometry->mesh, &lower, &upper);
    const double reach = rmap_mesh_rounding(lower, upper);
    const double wider = RMAP_LOCAL_ERRORS * reach + 2 * reach;
    if (!(wider > 0) || geometry->mesh->n_triangle == 0)
        return RMAP_OK;
    struct rmap_bottom *bottom = rmap_alloc(1, sizeof(*bottom));
    if (!bottom)
        return rmap_error_set(err, RMAP_SYSTEM, "no memory for a mesh");
    *bottom_ret = bottom;
    bottom->mesh = rmap_mesh_hold(geometry->mesh);
    bottom->lower = lower;
    bottom->upper = upper;
    if (geometry->mesh->surface) {
        const struct rmap_mesh whole = rmap_mesh_with_beyond(geometry->mesh);
        RMAP_TRY(facets_build(&whole, wider, &bottom->facets, err));
        RMAP_TRY(
            rmap_cells_build(geometry->mesh, &bottom->facets, wider, &bottom->facets.cells, err));
        RMAP_TRY(cells_tree(accel, bottom->facets.cells, &bottom->scene, err));
    } else {
        RMAP_TRY(widened_tree(accel, geometry, wider, &bottom->scene, &bottom->widened, err));
        RMAP_TRY(facets_build(geometry->mesh, wider, &bottom->facets, err));
    }
    accel->build.n_built++;
out:
    return st;
}

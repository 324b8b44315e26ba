/* SPDX-License-Identifier: MIT
 *
 * The bottom level of a mesh. Embree's float test is not watertight where many triangles share a
 * corner that the ray meets from far away (0.2 % of rays aimed at vertices of a ball five radii
 * away slip through, ROBUST or not). So each triangle is handed over a little larger than it is,
 * by more than the float error, and Embree reports every triangle that the ray can possibly
 * cross; which one it is is decided in double.
 */
#include "accel/accel_internal.h"

/* A triangle and its neighbour may both be seen edge on, and the float ray pass both: the farther
 * they reach, the flatter both must lie. As a share of the inscribed circle's radius; rays that
 * hit the margin only, a few in a hundred, cost a look at the neighbours where those may be seen
 * edge on. */
#define LEAST_MARGIN 0.003

static struct rmap_vec3 unit(struct rmap_vec3 v)
{
    double length = rmap_length(v);
    return length > 0 ? rmap_scale(v, 1 / length) : v;
}

double rmap_facet_margin(struct rmap_vec3 e1, struct rmap_vec3 e2, double wider)
{
    double perimeter = rmap_length(e1) + rmap_length(e2) + rmap_length(rmap_sub(e2, e1));
    if (!(perimeter > 0))
        return wider;
    return fmax(wider, LEAST_MARGIN * rmap_length(rmap_cross(e1, e2)) / perimeter);
}

static void widen(const struct rmap_mesh *mesh, size_t triangle, double wider, float out[9])
{
    struct rmap_vec3 corner[3];
    rmap_mesh_corners(mesh, triangle, corner);
    wider =
        rmap_facet_margin(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]), wider);
    for (int k = 0; k < 3; k++) {
        struct rmap_vec3 a = unit(rmap_sub(corner[(k + 1) % 3], corner[k]));
        struct rmap_vec3 b = unit(rmap_sub(corner[(k + 2) % 3], corner[k]));
        double sine = fmax(rmap_length(rmap_cross(a, b)), RMAP_NEEDLE_SINE);
        struct rmap_vec3 p = rmap_axpy(-wider / sine, rmap_add(a, b), corner[k]);
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

enum rmap_status rmap_accel_mesh(struct rmap_accel *accel, const struct rmap_geometry *geometry,
                                 double wider, RTCScene *scene_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_mesh *mesh = geometry->mesh;
    RTCGeometry triangles = NULL;
    RMAP_TRY(check(geometry, err));
    triangles = rtcNewGeometry(accel->device, RTC_GEOMETRY_TYPE_TRIANGLE);
    float *vertex = rtcSetNewGeometryBuffer(triangles, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                            12, 3 * mesh->n_triangle);
    uint32_t *index = rtcSetNewGeometryBuffer(triangles, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                              12, mesh->n_triangle);
    RMAP_TRY(rmap_accel_failed(accel, "making room for a mesh", err));
    for (size_t i = 0; i < mesh->n_triangle; i++)
        widen(mesh, i, wider, &vertex[9 * i]);
    for (size_t i = 0; i < 3 * mesh->n_triangle; i++)
        index[i] = (uint32_t)i;
    rtcSetGeometryIntersectFilterFunction(triangles, rmap_accel_triangle);
    rtcCommitGeometry(triangles);
    *scene_ret = rtcNewScene(accel->device);
    rtcSetSceneFlags(*scene_ret, RTC_SCENE_FLAG_NONE);
    rtcAttachGeometry(*scene_ret, triangles);
    rtcCommitScene(*scene_ret);
    RMAP_TRY(rmap_accel_failed(accel, "building a mesh", err));
out:
    if (triangles)
        rtcReleaseGeometry(triangles);
    return st;
}

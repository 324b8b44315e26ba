/* SPDX-License-Identifier: MIT
 *
 * Scenes put together by hand, for tests of the geometry. Meshes wind outward.
 */
#ifndef BUILD_SCENE_H
#define BUILD_SCENE_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "accel/accel.h"
#include "base/alloc.h"
#include "base/rng.h"
#include "scene/scene.h"

struct builder {
    struct rmap_scene *scene;
    struct rmap_accel *accel;
};

static inline void builder_open(struct builder *b, size_t max)
{
    struct rmap_error err = {0};
    memset(b, 0, sizeof(*b));
    assert_int_equal(rmap_scene_create(&b->scene, &err), RMAP_OK);
    b->scene->geometry = rmap_alloc(max, sizeof(*b->scene->geometry));
    b->scene->object = rmap_alloc(max, sizeof(*b->scene->object));
    assert_non_null(b->scene->geometry);
    assert_non_null(b->scene->object);
}

static inline int32_t builder_shape(struct builder *b, struct rmap_shape shape)
{
    assert_null(rmap_shape_check(&shape));
    assert_true(rmap_shape_own(&shape));
    b->scene->geometry[b->scene->n_geometry].kind = RMAP_GEOMETRY_SHAPE;
    b->scene->geometry[b->scene->n_geometry].shape = shape;
    return (int32_t)b->scene->n_geometry++;
}

static inline int32_t builder_mesh(struct builder *b, struct rmap_mesh *mesh)
{
    b->scene->geometry[b->scene->n_geometry].kind = RMAP_GEOMETRY_MESH;
    b->scene->geometry[b->scene->n_geometry].mesh = mesh;
    return (int32_t)b->scene->n_geometry++;
}

static inline int32_t builder_object(struct builder *b, int32_t geometry, struct rmap_affine place,
                                     int32_t front, int32_t back)
{
    struct rmap_object *object = &b->scene->object[b->scene->n_object];
    object->parent = -1;
    object->geometry = geometry;
    object->to_world = place;
    object->medium_front = front;
    object->medium_back = back;
    return (int32_t)b->scene->n_object++;
}

static inline void builder_close(struct builder *b)
{
    struct rmap_error err = {0};
    if (rmap_scene_finish(b->scene, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    if (rmap_accel_create(b->scene, 1, &b->accel, &err) != RMAP_OK)
        fail_msg("%s", err.text);
}

static inline void builder_destroy(struct builder *b)
{
    rmap_accel_destroy(b->accel);
    rmap_scene_destroy(b->scene);
}

static inline void set_vertex(struct rmap_mesh *mesh, size_t i, double x, double y, double z)
{
    mesh->vertex[i][0] = (float)x;
    mesh->vertex[i][1] = (float)y;
    mesh->vertex[i][2] = (float)z;
}

/* |x|, |y|, |z| <= half: 8 vertices, 12 triangles, each side a face. */
static inline struct rmap_mesh *make_cube(double half)
{
    static const uint32_t side[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                                        {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    struct rmap_mesh *mesh = NULL;
    struct rmap_error err = {0};
    assert_int_equal(rmap_mesh_create(8, 12, 6, &mesh, &err), RMAP_OK);
    for (unsigned i = 0; i < 8; i++)
        set_vertex(mesh, i, i & 1 ? half : -half, i & 2 ? half : -half, i & 4 ? half : -half);
    for (uint32_t f = 0; f < 6; f++)
        for (uint32_t k = 0; k < 2; k++) {
            uint32_t *triangle = mesh->triangle[2 * f + k];
            triangle[0] = side[f][0];
            triangle[1] = side[f][1 + k];
            triangle[2] = side[f][2 + k];
            mesh->face[2 * f + k] = f;
        }
    return mesh;
}

/* Unit sphere: the octahedron's faces cut into n x n triangles each and pushed outward. Vertices
 * are shared, so that the mesh is watertight. */
static inline struct rmap_mesh *make_ball(uint32_t n)
{
    /* vertices by their integer place (i, j, k), |i| + |j| + |k| = n, searched for linearly */
    struct rmap_mesh *mesh = NULL;
    struct rmap_error err = {0};
    size_t n_triangle = (size_t)8 * n * n, n_vertex = 4 * (size_t)n * n + 2, used = 0;
    assert_int_equal(rmap_mesh_create(n_vertex, n_triangle, 1, &mesh, &err), RMAP_OK);
    int(*place)[3] = rmap_alloc(n_vertex, sizeof(*place));
    assert_non_null(place);
    size_t t = 0;
    for (int octant = 0; octant < 8; octant++) {
        int sx = octant & 1 ? -1 : 1, sy = octant & 2 ? -1 : 1, sz = octant & 4 ? -1 : 1;
        for (int i = 0; i < (int)n; i++)
            for (int j = 0; j < (int)n - i; j++)
                for (int half = 0; half < (i + j < (int)n - 1 ? 2 : 1); half++) {
                    int grid[3][2] = {{i + half, j + half}, {i + 1, j}, {i, j + 1}};
                    for (int k = 0; k < 3; k++) {
                        int a = grid[k][0], c = grid[k][1];
                        int p[3] = {sx * a, sy * c, sz * ((int)n - a - c)};
                        size_t v = 0;
                        while (v < used && memcmp(place[v], p, sizeof(p)) != 0)
                            v++;
                        if (v == used) {
                            memcpy(place[used++], p, sizeof(p));
                            struct rmap_vec3 u =
                                rmap_normalize(rmap_vec3((double)p[0], (double)p[1], (double)p[2]));
                            set_vertex(mesh, v, u.x, u.y, u.z);
                        }
                        mesh->triangle[t][k] = (uint32_t)v;
                    }
                    struct rmap_vec3 corner[3];
                    rmap_mesh_corners(mesh, t, corner);
                    struct rmap_vec3 normal =
                        rmap_cross(rmap_sub(corner[1], corner[0]), rmap_sub(corner[2], corner[0]));
                    if (rmap_dot(normal, corner[0]) < 0) {
                        uint32_t swap = mesh->triangle[t][1];
                        mesh->triangle[t][1] = mesh->triangle[t][2];
                        mesh->triangle[t][2] = swap;
                    }
                    t++;
                }
    }
    assert_int_equal(t, n_triangle);
    assert_int_equal(used, n_vertex);
    rmap_free(place);
    return mesh;
}

static inline struct rmap_affine linear(double a, double b, double c, double d, double e, double f,
                                        double g, double h, double i, struct rmap_vec3 t)
{
    return (struct rmap_affine){{{a, b, c}, {d, e, f}, {g, h, i}}, t};
}

/* Uniform on the sphere, from a counter. */
static inline struct rmap_vec3 any_direction(uint64_t i, uint32_t step)
{
    double u[4];
    rmap_rng(1, i, step, RMAP_RNG_EMIT_DIRECTION, u);
    double z = 1 - 2 * u[0], r = sqrt(1 - z * z);
    return rmap_vec3(r * cos(2 * RMAP_PI * u[1]), r * sin(2 * RMAP_PI * u[1]), z);
}

#endif

/* SPDX-License-Identifier: MIT
 *
 * A room of shapes with meshes in it: segments in its empty middle are not held against the walls.
 * A mesh far outside, which no ray can reach, turns that off: every hit must be the same.
 */
#include <math.h>

#include "build_scene.h"

enum { MOST = 16, RAYS = 4000, SEGMENTS = 12, ON_WALL = 6 };

static struct rmap_shape rectangle(double width, double height)
{
    return (struct rmap_shape){.type = RMAP_SHAPE_RECTANGLE, .size = {width, height}};
}

/* z' along the axis: a wall that looks inward. */
static struct rmap_affine wall(int axis, double at)
{
    struct rmap_affine place = {0};
    for (int k = 0; k < 3; k++)
        place.m[(axis + 1 + k) % 3][k] = 1;
    double *t[3] = {&place.t.x, &place.t.y, &place.t.z};
    *t[axis] = at;
    return place;
}

static struct rmap_affine at(double size, double x, double y, double z)
{
    return linear(size, 0, 0, 0, size, 0, 0, 0, size, rmap_vec3(x, y, z));
}

static void add(struct builder *b, int32_t geometry, struct rmap_affine place)
{
    (void)builder_object(b, geometry, place, RMAP_MEDIUM_ANY, RMAP_MEDIUM_ANY);
}

static void build(struct builder *b, bool mesh_outside)
{
    builder_open(b, MOST);
    int32_t side = builder_shape(b, rectangle(4, 4)), picture = builder_shape(b, rectangle(1, 0.5));
    int32_t lamp = builder_shape(b, (struct rmap_shape){.type = RMAP_SHAPE_DISC, .aperture = 0.3});
    int32_t globe = builder_shape(b, (struct rmap_shape){.type = RMAP_SHAPE_SPHERE, .radius = 0.2});
    int32_t ball = builder_mesh(b, make_ball(6)), cube = builder_mesh(b, make_cube(1));
    for (int axis = 0; axis < 3; axis++) {
        add(b, side, wall(axis, -2));
        add(b, side, wall(axis, 2));
    }
    add(b, picture, wall(0, 2));        /* ON_WALL: the wall comes first, and turns all rays */
    add(b, picture, wall(1, 2 - 1e-5)); /* before it, less than the float error */
    add(b, picture,
        linear(0.6, 0, 0.8, 0, 1, 0, -0.8, 0, 0.6, rmap_vec3(-1.6, 0, -1.6))); /* in a corner */
    add(b, lamp, at(1, 0.4, 0.2, 1.9));
    add(b, globe, at(1, 1.7, 1.7, 1.7));
    add(b, ball, at(0.5, 0.3, -0.4, 0.1));
    add(b, cube, at(0.3, -0.9, 0.8, -1.7)); /* stands on the floor */
    add(b, ball, at(0.25, 1.2, 0.9, -0.6));
    if (mesh_outside)
        add(b, cube, at(1, 40, 0, 0));
    builder_close(b);
}

static bool same(const struct rmap_hit *a, const struct rmap_hit *b)
{
    return a->object == b->object && a->primitive == b->primitive && a->t == b->t &&
           a->position.x == b->position.x && a->position.y == b->position.y &&
           a->position.z == b->position.z;
}

/* Into any direction, but away from the side that it came to when it turns. */
static void go_on(struct rmap_ray *ray, const struct rmap_hit *hit, uint64_t i, uint32_t segment)
{
    struct rmap_vec3 d = any_direction(i, segment);
    bool turns = hit->object < 6 || segment % 3;
    double came = rmap_dot(ray->direction, hit->normal), goes = rmap_dot(d, hit->normal);
    if ((came * goes < 0) != turns)
        d = rmap_scale(d, -1);
    if (turns)
        rmap_contact_turn(&ray->contact, hit);
    else
        rmap_contact_pass(&ray->contact, hit);
    ray->direction = d;
    ray->origin = hit->position;
}

static void test_segments_of_a_room_are_the_same_with_its_walls_asked_or_not(void **state)
{
    (void)state;
    struct builder room, outside;
    int met[MOST] = {0};
    build(&room, false);
    build(&outside, true);
    for (uint64_t i = 0; i < RAYS; i++) {
        struct rmap_ray ray = {.origin = {-0.5, -1.1, 0.7}, .direction = any_direction(i, 1000)};
        for (uint32_t segment = 0; segment < SEGMENTS; segment++) {
            struct rmap_hit hit, other;
            assert_true(rmap_accel_next(room.accel, &ray, &hit));
            assert_true(rmap_accel_next(outside.accel, &ray, &other));
            assert_true(same(&hit, &other));
            met[hit.object]++;
            go_on(&ray, &hit, i, segment);
        }
    }
    for (size_t i = 0; i < room.scene->n_object; i++)
        if (i != ON_WALL)
            assert_true(met[i] > 10);
    builder_destroy(&room);
    builder_destroy(&outside);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_segments_of_a_room_are_the_same_with_its_walls_asked_or_not),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Boxes of random media packed face to face: light that goes straight on, is reflected or
 * scattered at every face, on either side, always meets the next face from the medium it is in.
 */
#include <math.h>

#include "build_scene.h"

static void open_tiles(struct builder *b, uint32_t scene, const struct rmap_affine *place)
{
    builder_open(b, 32);
    int32_t cube = builder_mesh(b, make_cube(0.35));
    for (int k = 0; k < 27; k++) {
        double u[4];
        rmap_rng(41, (uint64_t)k, scene, RMAP_RNG_EMIT_POINT, u);
        struct rmap_affine local = rmap_affine_identity();
        local.t = rmap_vec3(0.7 * (k % 3), 0.7 * (k / 3 % 3), 0.7 * (k / 9));
        if (u[3] > 0.2)
            builder_object(b, cube, rmap_affine_compose(place, &local), 0, (int32_t)(4 * u[0]));
    }
    builder_close(b);
}

/* Mirrored, scattered or straight on; passes when u[0] says so. */
static void go_on(struct rmap_ray *ray, const struct rmap_hit *hit, int32_t far_medium,
                  const double u[4], struct rmap_vec3 scattered)
{
    bool passes = u[0] < 0.6;
    double from = rmap_dot(ray->direction, hit->normal) > 0 ? 1 : -1;
    if (u[1] < 0.4)
        ray->direction =
            rmap_normalize(rmap_axpy((passes ? 1.0001 : -1.0001) * from, hit->normal, scattered));
    else if (!passes)
        ray->direction =
            rmap_axpy(-2 * rmap_dot(ray->direction, hit->normal), hit->normal, ray->direction);
    if (passes) {
        rmap_contact_pass(&ray->contact, hit);
        ray->medium = far_medium;
    } else {
        rmap_contact_turn(&ray->contact, hit);
    }
    ray->origin = hit->position;
}

static void test_faces_are_met_from_the_medium_before_them(void **state)
{
    (void)state;
    for (uint32_t scene = 0; scene < 8; scene++) {
        struct rmap_affine place =
            rmap_affine_placement(rmap_vec3(1 + 0.1 * scene, 1 - 0.07 * scene, 1),
                                  rmap_vec3(3 * scene, 7 * scene, scene), rmap_vec3(scene, 2, 3));
        struct builder b;
        open_tiles(&b, scene, &place);
        for (uint64_t i = 0; i < 8000; i++) {
            double u[4];
            rmap_rng(42, i, scene, RMAP_RNG_EMIT_POINT, u);
            struct rmap_vec3 d = any_direction(i, scene);
            struct rmap_vec3 to =
                rmap_vec3(2.1 * u[0] - 0.35, 2.1 * u[1] - 0.35, 2.1 * u[2] - 0.35);
            struct rmap_ray ray = {.origin = rmap_affine_point(&place, rmap_axpy(-5, d, to))};
            ray.direction = rmap_normalize(rmap_affine_vector(&place, d));
            struct rmap_hit hit;
            for (uint32_t step = 0; step < 40 && rmap_accel_next(b.accel, &ray, &hit); step++) {
                const struct rmap_object *o = &b.scene->object[hit.object];
                bool front = rmap_dot(hit.normal, ray.direction) < 0;
                int32_t near_medium = front ? o->medium_front : o->medium_back;
                if (near_medium != ray.medium)
                    fail_msg("scene %u, ray %d, step %u: medium %d where %d was", scene, (int)i,
                             step, near_medium, ray.medium);
                rmap_rng(43, i, 64 * scene + step, RMAP_RNG_SURFACE, u);
                go_on(&ray, &hit, front ? o->medium_back : o->medium_front, u,
                      any_direction(i, 64 * scene + step));
            }
        }
        builder_destroy(&b);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faces_are_met_from_the_medium_before_them),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

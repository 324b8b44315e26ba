/* SPDX-License-Identifier: MIT
 *
 * Emission: moments of positions and directions against their integrals.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/count.h"
#include "formula/azimuth.h"
#include "hand_scene.h"
#include "near.h"
#include "trace/source.h"

#define N 40000

static struct rmap_scene *scene_of(enum rmap_source_type type, struct rmap_source **source)
{
    struct rmap_scene *scene = hand_scene(3);
    hand_medium(scene, 1.0);
    *source = hand_source(scene, type, rmap_vec3(10, 20, 30), rmap_vec3(1, -2, 0.5));
    return scene;
}

static void finish(struct rmap_scene *scene)
{
    struct rmap_error err = {0};
    if (rmap_scene_finish(scene, &err) != RMAP_OK)
        fail_msg("%s", err.text);
}

/* Sums over N rays, in the source's frame. */
struct moments {
    struct rmap_vec3 position, position2, direction; /* sums of components and squares */
    double z2, z_min;
};

static struct moments measure(const struct rmap_scene *scene)
{
    struct moments m = {.z_min = 1.0};
    struct rmap_affine to_local;
    assert_true(rmap_affine_invert(&scene->source[0].frame, &to_local));
    for (uint64_t ray = 0; ray < N; ray++) {
        struct rmap_colour colour;
        struct rmap_emission e;
        rmap_source_emit(scene, 42, ray, &colour, &e);
        assert_true(e.ray == ray && e.source == 0 && e.object == -1 && e.medium == 0);
        assert_near(rmap_length(e.direction), 1.0, 1e-15);
        struct rmap_vec3 p = rmap_affine_point(&to_local, e.position);
        struct rmap_vec3 d = rmap_affine_vector(&to_local, e.direction);
        m.position = rmap_add(m.position, p);
        m.position2 = rmap_add(m.position2, rmap_vec3(p.x * p.x, p.y * p.y, p.z * p.z));
        m.direction = rmap_add(m.direction, d);
        m.z2 += d.z * d.z;
        m.z_min = fmin(m.z_min, d.z);
    }
    return m;
}

/* Against the C library, whose argument here is rounded to 4e-16. */
static void azimuth(void **state)
{
    (void)state;
    for (int i = 0; i <= 100000; i++) {
        double turns = i / 100000.0, c, s;
        rmap_azimuth(turns, &c, &s);
        assert_near(c, cos(2.0 * RMAP_PI * turns), 1e-15);
        assert_near(s, sin(2.0 * RMAP_PI * turns), 1e-15);
        assert_near(c * c + s * s, 1.0, 4.5e-16);
    }
}

static void isotropic(void **state)
{
    (void)state;
    struct rmap_source *source;
    struct rmap_scene *scene = scene_of(RMAP_SOURCE_POINT, &source);
    source->distribution = RMAP_DISTRIBUTION_ISOTROPIC;
    finish(scene);
    struct moments m = measure(scene);
    assert_mean(m.direction.x, N, 0.0, 1.0 / 3.0);
    assert_mean(m.direction.y, N, 0.0, 1.0 / 3.0);
    assert_mean(m.direction.z, N, 0.0, 1.0 / 3.0);
    assert_mean(m.z2, N, 1.0 / 3.0, 4.0 / 45.0);
    assert_near(m.position2.x / N, 0.0, 1e-20);
    rmap_scene_destroy(scene);
}

/* Uniform in solid angle: cos(theta) uniform in [cos(cone), 1]. */
static void cone(void **state)
{
    (void)state;
    const double half[] = {20.0, 150.0, 0.01};
    for (int k = 0; k < 3; k++) {
        struct rmap_source *source;
        struct rmap_scene *scene = scene_of(RMAP_SOURCE_POINT, &source);
        source->distribution = RMAP_DISTRIBUTION_CONE;
        source->cone_rad = half[k] * RMAP_PI / 180.0;
        finish(scene);
        struct moments m = measure(scene);
        double low = cos(source->cone_rad), width = 1.0 - low;
        assert_true(m.z_min >= low - 1e-15);
        assert_near(m.direction.z / N, 1.0 - 0.5 * width, 4.0 * width / sqrt(12.0 * N) + 1e-15);
        assert_mean(m.direction.x, N, 0.0, 0.5 * (1.0 - low * low));
        rmap_scene_destroy(scene);
    }
}

/* I ~ cos^p over the hemisphere: <cos> = (p + 1) / (p + 2), <cos^2> = (p + 1) / (p + 3). */
/* Of a damaged map. */
static void cone_of_no_angle(void **state)
{
    (void)state;
    static const double angle[] = {-1.0, 14.0, 1e300, HUGE_VAL, (double)NAN};
    static const double u[2] = {0.9, 0.3};
    struct rmap_source source = {.distribution = RMAP_DISTRIBUTION_CONE, .cone_rad = 1.0};
    assert_near(rmap_source_cone(&source), 1.0 - cos(1.0), 1e-15);
    for (size_t i = 0; i < RMAP_COUNT(angle); i++) {
        source.cone_rad = angle[i];
        assert_true(rmap_source_cone(&source) == 0.0);
        assert_true(rmap_source_about_z(&source, u).z == 1.0);
    }
}

static void cosine_power(void **state)
{
    (void)state;
    const double power[] = {0.0, 1.0, 5.0, 40.5};
    for (int k = 0; k < 4; k++) {
        struct rmap_source *source;
        struct rmap_scene *scene = scene_of(RMAP_SOURCE_POINT, &source);
        source->distribution = RMAP_DISTRIBUTION_COSINE;
        source->cosine_power = power[k];
        finish(scene);
        struct moments m = measure(scene);
        double mean = (power[k] + 1) / (power[k] + 2), square = (power[k] + 1) / (power[k] + 3);
        assert_true(m.z_min > 0.0);
        assert_mean(m.direction.z, N, mean, square - mean * mean);
        assert_mean(m.direction.x, N, 0.0, 0.5 * (1.0 - square));
        rmap_scene_destroy(scene);
    }
}

/* cos(theta) at every degree; a band, where cos(theta) is uniform between its edges. */
static void table(void **state)
{
    (void)state;
    double angle[91], value[91];
    for (int i = 0; i <= 90; i++) {
        angle[i] = i;
        value[i] = 7.0 * cos(i * RMAP_PI / 180.0);
    }
    for (int k = 0; k < 2; k++) {
        struct rmap_source *source;
        struct rmap_scene *scene = scene_of(RMAP_SOURCE_POINT, &source);
        struct rmap_error err = {0};
        const double band[] = {60.0, 120.0}, even[] = {2.0, 2.0};
        source->distribution = RMAP_DISTRIBUTION_TABLE;
        assert_int_equal(rmap_profile_init(k ? band : angle, k ? even : value, k ? 2 : 91,
                                           &source->profile, &err),
                         RMAP_OK);
        finish(scene);
        struct moments m = measure(scene);
        assert_mean(m.direction.z, N, k ? 0.0 : 2.0 / 3.0, k ? 1.0 / 12.0 : 1.0 / 18.0);
        assert_near(m.z2 / N, k ? 1.0 / 12.0 : 0.5, 4.0 / sqrt(12.0 * N));
        assert_true(m.z_min >= (k ? -0.5 - 1e-15 : 0.0));
        double peak = rmap_profile_intensity(&source->profile, k ? 1.0 : 0.0);
        assert_near(peak, k ? 0.5 / RMAP_PI : 1.0 / RMAP_PI, 1e-4);
        assert_near(rmap_profile_intensity(&source->profile, 1.8), 0.0, 0.0);
        rmap_scene_destroy(scene);
    }
}

/* The sun's disc: cos(theta) uniform within it, places uniform as without. */
static void angular_diameter(void **state)
{
    (void)state;
    struct rmap_source *source;
    struct rmap_scene *scene = scene_of(RMAP_SOURCE_COLLIMATED, &source);
    source->shape = RMAP_EMITTER_DISC;
    source->shape_size[0] = 2.0;
    source->distribution = RMAP_DISTRIBUTION_CONE;
    source->cone_rad = 0.265 * RMAP_PI / 180.0;
    finish(scene);
    struct moments m = measure(scene);
    double drop = 1.0 - cos(source->cone_rad);
    assert_true(m.z_min >= 1.0 - drop - 1e-15);
    assert_near(1.0 - m.direction.z / N, 0.5 * drop, 4.0 * drop / sqrt(12.0 * N) + 1e-15);
    assert_mean(m.position.x, N, 0.0, 1.0);
    rmap_scene_destroy(scene);
}

static void collimated_disc(void **state)
{
    (void)state;
    struct rmap_source *source;
    struct rmap_scene *scene = scene_of(RMAP_SOURCE_COLLIMATED, &source);
    source->shape = RMAP_EMITTER_DISC;
    source->shape_size[0] = 12.0;
    finish(scene);
    struct moments m = measure(scene);
    assert_near(m.direction.z / N, 1.0, 1e-13);
    assert_true(m.z_min > 1.0 - 1e-14);
    /* <x^2> = R^2 / 4, <x^4> = R^4 / 8 */
    assert_mean(m.position.x, N, 0.0, 36.0);
    assert_mean(m.position2.x, N, 36.0, 20736.0 / 8.0 - 36.0 * 36.0);
    assert_mean(m.position2.y, N, 36.0, 20736.0 / 8.0 - 36.0 * 36.0);
    assert_near(m.position2.z / N, 0.0, 1e-20);
    rmap_scene_destroy(scene);
}

/* Lambertian: <cos> = 2/3, <cos^2> = 1/2. */
static void area_rectangle(void **state)
{
    (void)state;
    struct rmap_source *source;
    struct rmap_scene *scene = scene_of(RMAP_SOURCE_AREA, &source);
    source->shape = RMAP_EMITTER_RECTANGLE;
    source->shape_size[0] = 6.0;
    source->shape_size[1] = 2.0;
    finish(scene);
    struct moments m = measure(scene);
    assert_mean(m.direction.z, N, 2.0 / 3.0, 0.5 - 4.0 / 9.0);
    assert_mean(m.direction.y, N, 0.0, 0.25);
    assert_true(m.z_min > 0.0);
    assert_mean(m.position2.x, N, 3.0, 81.0 / 5.0 - 9.0);
    assert_mean(m.position2.y, N, 1.0 / 3.0, 1.0 / 5.0 - 1.0 / 9.0);
    rmap_scene_destroy(scene);
}

/* Two triangles of areas 3 : 1 and a degenerate one between them; mirrored in x. */
static void area_mesh(void **state)
{
    (void)state;
    struct rmap_source *source;
    struct rmap_scene *scene = scene_of(RMAP_SOURCE_AREA, &source);
    struct rmap_mesh *mesh = NULL;
    assert_int_equal(rmap_mesh_create(6, 3, 1, &mesh, NULL), RMAP_OK);
    const float vertex[6][3] = {{0, 0, 0}, {3, 0, 0}, {0, 2, 0}, {0, 0, 1}, {1, 0, 1}, {0, 2, 1}};
    const uint32_t triangle[3][3] = {{0, 1, 2}, {0, 1, 1}, {3, 4, 5}};
    for (int i = 0; i < 6; i++)
        for (int k = 0; k < 3; k++)
            mesh->vertex[i][k] = vertex[i][k];
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++)
            mesh->triangle[i][k] = triangle[i][k];
    scene->geometry[0].kind = RMAP_GEOMETRY_MESH;
    scene->geometry[0].mesh = mesh;
    scene->n_geometry = 1;
    source->shape = RMAP_EMITTER_MESH;
    source->shape_geometry = 0;
    source->frame = rmap_affine_identity();
    source->frame.m[0][0] = -1.0;
    finish(scene);
    struct moments m = measure(scene);
    assert_mean(m.direction.z, N, 2.0 / 3.0, 0.5 - 4.0 / 9.0);
    assert_true(m.z_min > 0.0);
    assert_mean(m.position.z, N, 0.25, 0.25 * 0.75); /* share of the second triangle */
    /* centroid x: 3/4 of 3/3, 1/4 of 1/3; variance at most E x^2 = 3/4 9/6 + 1/4 1/6 */
    assert_mean(m.position.x, N, 0.75 + 1.0 / 12.0, 1.125 + 1.0 / 24.0);
    assert_mean(m.position.y, N, 2.0 / 3.0, 2.0 / 9.0);
    rmap_scene_destroy(scene);
}

/* Row k of the list for the source's k-th ray, whatever other sources there are. */
/* Shares of bands are float: what they leave out of 1 is nobody's. */
static void sky_channel(void **state)
{
    (void)state;
    static float band[2][3] = {{0.5F, 0.49999997F, 0.0F}, {0.5F, 0.49999994F, 3e-8F}};
    double edge[2] = {0, 1}, radiance = 1, below = 1, way[4] = {0.5, 0.5, 0.5, 1 - 0x1p-33};
    static const double place[4] = {0.5, 0.5, 0.5, 0.5};
    struct rmap_sky sky = {
        .n_row = 1, .n_around = 1, .edge = edge, .radiance = &radiance, .below = &below};
    struct rmap_source source = {.type = RMAP_SOURCE_SKY,
                                 .sky = &sky,
                                 .shape_size = {1, 0},
                                 .frame = rmap_affine_identity()};
    for (int c = 0; c < RMAP_CHANNEL_MAX; c++) {
        sky.mix[0][c] = sky.mix[1][c] = c < 2 ? 0.5 * c : 1.0;
        sky.mix[2][c] = c < 2 ? 0.0 : 1.0;
    }
    for (int k = 0; k < 2; k++) {
        struct rmap_vec3 position;
        int channel;
        sky.band = band[k];
        (void)rmap_sky_draw(&source, place, way, &position, &channel);
        assert_int_equal(channel, 2);
    }
}

static void list_of_rays(void **state)
{
    (void)state;
    struct rmap_source *source;
    struct rmap_scene *scene = scene_of(RMAP_SOURCE_RAYS, &source);
    hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 1))->share = 3.0;
    source->n_list = 5;
    source->list = rmap_alloc(5, sizeof *source->list);
    for (int i = 0; i < 5; i++)
        source->list[i] =
            (struct rmap_list_ray){rmap_vec3(i, 0, 0), rmap_vec3(0, 0, 1), i < 3 ? i : -1};
    finish(scene);
    int seen = 0;
    for (uint64_t ray = 0; ray < 100; ray++) {
        struct rmap_colour colour;
        struct rmap_emission e;
        rmap_source_emit(scene, 1, ray, &colour, &e);
        if (e.source != 0)
            continue;
        int row = seen++ % 5;
        assert_true(e.position.x == row && e.direction.z == 1.0);
        assert_true(rmap_colour_single(&colour) == (row < 3));
        assert_near(colour.share[row % 3], row < 3 ? 1.0 : 1.0 / 3.0, 1e-15);
        assert_near(colour.share[0] + colour.share[1] + colour.share[2], 1.0, 1e-15);
    }
    assert_int_equal(seen, 25);
    rmap_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(azimuth),
        cmocka_unit_test(isotropic),
        cmocka_unit_test(cone),
        cmocka_unit_test(cone_of_no_angle),
        cmocka_unit_test(cosine_power),
        cmocka_unit_test(table),
        cmocka_unit_test(angular_diameter),
        cmocka_unit_test(collimated_disc),
        cmocka_unit_test(area_rectangle),
        cmocka_unit_test(area_mesh),
        cmocka_unit_test(sky_channel),
        cmocka_unit_test(list_of_rays),
    };
    return cmocka_run_group_tests_name("source", test, NULL, NULL);
}

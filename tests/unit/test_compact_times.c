/* SPDX-License-Identifier: MIT
 *
 * Group paths and delays of timed runs: predicted, bit by bit, where the path tells them.
 */
#include "compact_rig.h"

#define SCENE(light, gradient)                                                                     \
    "raymap: 1\nunits: mm\ntime: on\nspectrum: " light "\n"                                        \
    "media:\n  air: {index: 1}\n  glass: {glass: N-BK7}\n" gradient                                \
    "surfaces: {clear: {type: fresnel}, black: {type: absorber}, white: {type: lambert, "          \
    "reflectance: 0.8}}\n"                                                                         \
    "geometries:\n  ball: {type: sphere, radius: 3}\n  wall: {type: rectangle, size: [40, 40]}\n"  \
    "objects:\n"                                                                                   \
    "  - {name: lens, geometry: ball, at: [0, 0, 5], surface: clear, inside: %s, outside: air}\n"  \
    "  - {name: back, geometry: wall, at: [0, 0, 20], surface: white, front: air, back: air}\n"    \
    "  - {name: front, geometry: wall, at: [0, 0, -20], surface: white, front: air, back: air}\n"  \
    "sources:\n"                                                                                   \
    "  - {name: lamp, type: point, at: [0, 0, -4], flux: 1 W, medium: air}\n"                      \
    "detectors:\n"                                                                                 \
    "  - {name: free, type: plane, at: [0, 0, 12], direction: [0, 0, -1], size: [30, 30], cells: " \
    "[3, 3], side: both}\n"                                                                        \
    "  - {name: on, type: plane, on: back, cells: [4, 4]}\n"

enum { RAYS = 3000 };

static void survives(const char *light, const char *gradient, const char *inside, bool predicted)
{
    char text[4000];
    struct rig rig;
    struct rmap_unpredicted told;
    (void)snprintf(text, sizeof text, SCENE("%s", "%s"), light, gradient, inside);
    rig_open_text(&rig, text);
    assert_true(rig.scene->timed);
    struct rmap_portion *portion = rig_trace_told(&rig, 0, RAYS, &told);
    double most = 0.0;
    for (size_t i = 0; i < RAYS; i++) {
        const double phase = portion->ray.optical_path[i], group = portion->ray.group_path[i];
        assert_true(group >= phase * (1 - 1e-12));
        most = group > most * phase ? group / phase : most;
    }
    assert_true(rig.scene->channels.mode == RMAP_COLOUR_RGB ? most == 1.0 : most > 1.001);
    assert_int_equal(told.n == 0, predicted);
    rig_roundtrip(&rig, RIG_SEED, portion);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

static void test_times(void **state)
{
    (void)state;
    survives("{wavelengths: [420, 500, 650]}", "", "glass", true);
    survives("{wavelengths: [420]}", "", "glass", true);
    survives("{mode: rgb}", "", "glass", true);
}

/* What delays light on its way is stored. */
static void test_delays(void **state)
{
    (void)state;
    struct rig rig;
    char text[4000];
    struct rmap_unpredicted told;
    (void)snprintf(text, sizeof text, SCENE("{wavelengths: [420, 650]}", ""), "glass");
    rig_open_text(&rig, text);
    struct rmap_portion *portion = rig_trace_told(&rig, 0, RAYS, &told);
    for (size_t i = 0; i < RAYS; i += 3)
        portion->ray.delay[i] = (double)i;
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_REGISTRATION]; i += 7)
        portion->registration.delay[i] = 0.5 * (double)i;
    rig_roundtrip(&rig, RIG_SEED, portion);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* What delays light at its source follows from the ray's number. */
static void test_emission_delays(void **state)
{
    (void)state;
    static const double delay[] = {0, 2.5, -40};
    struct rig rig;
    char text[4000];
    struct rmap_unpredicted told;
    (void)snprintf(text, sizeof text, SCENE("{wavelengths: [420, 650]}", ""), "glass");
    rig_open_text(&rig, text);
    struct rmap_source *source = &rig.scene->source[0];
    source->type = RMAP_SOURCE_RAYS;
    source->list = rmap_alloc(3, sizeof *source->list);
    source->n_list = 3;
    for (int i = 0; i < 3; i++)
        source->list[i] =
            (struct rmap_list_ray){{0.1 * i, 0, -4}, {0, 0.6 * i / 2, 0}, -1, delay[i]};
    for (int i = 0; i < 3; i++)
        source->list[i].direction.z = sqrt(1 - 0.09 * i * i);
    struct rmap_portion *portion = rig_trace_told(&rig, 0, RAYS, &told);
    assert_int_equal(told.n, 0);
    size_t row = 0;
    for (size_t i = 0; i < RAYS; i++) {
        assert_true(portion->ray.delay[i] == delay[i % 3]);
        for (uint32_t k = 0; k < portion->ray.registration_count[i]; k++)
            assert_true(portion->registration.delay[row++] == delay[i % 3]);
    }
    assert_true(row > RAYS / 2);
    rig_roundtrip(&rig, RIG_SEED, portion);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* Along a curve: quadrature of n - wavelength dn/dwavelength over the rod's axis. */
static void test_gradient(void **state)
{
    (void)state;
    survives("{wavelengths: [420, 650]}",
             "  rod: {gradient: {type: luneburg, radius: 3, dispersion: {glass: N-BK7, mode: "
             "multiplicative}}}\n",
             "rod", false);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_times), cmocka_unit_test(test_delays),
                                       cmocka_unit_test(test_emission_delays),
                                       cmocka_unit_test(test_gradient)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Every word of the criterion language, true and false, on twelve rays with known histories.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/criterion_tree.h"
#include "base/alloc.h"
#include "tests/criterion_letters.h"
#include "tests/criterion_scene.h"

enum { N_RAY = 12, ALL = (1 << N_RAY) - 1 };
#define RAY(i) (1u << (i))

/* Weight 2 = 1 W from the lamp, 1 W = 4 from the sun. */
static const double flux_per_weight[] = {0.5, 0.25};

static const struct test_ray ray_table[N_RAY] = {
    {100, 0, RMAP_STOP_ABSORBED, 1.0, 550.0, 120.0, 130.0, {0, 0, 0}},
    {101, 0, RMAP_STOP_ABSORBED, 2.0, NAN, 240.0, 260.0, {0, 0, 0}},
    {102, 1, RMAP_STOP_LEFT, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
    {103, 1, RMAP_STOP_LEFT, 1.0, 500.0, 10.0, 10.0, {0, 0, 9}},
    {104, 1, RMAP_STOP_ABSORBED, 1.0, 600.0, 10.0, 10.0, {0, 0, -9}},
    {105, 1, RMAP_STOP_ABSORBED, 1.0, 700.0, 10.0, 10.0, {0, 0, 0}},
    {106, 1, RMAP_STOP_LIMIT, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
    {107, 1, RMAP_STOP_ERROR, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
    {108, 1, RMAP_STOP_LEFT, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
    {109, 1, RMAP_STOP_LEFT, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
    {110, 1, RMAP_STOP_ABSORBED, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
    {111, 1, RMAP_STOP_LEFT, 1.0, 400.0, 10.0, 10.0, {0, 0, 0}},
};

#define UP                                                                                         \
    {                                                                                              \
        0, 0, 32767                                                                                \
    }
static const struct {
    int ray;
    struct test_step step;
} step_table[] = {
    /* 0: straight through the lens to face 1 of the tube */
    {0, {LENS1, 0, T, AIR, {0, 0, 1}, UP}},
    {0, {LENS2, 0, T, GLASS, {0, 0, 2}, UP}},
    {0, {TUBE, 4, A, AIR, {0, 0, 3}, UP}},
    /* 1: a ghost */
    {1, {LENS1, 0, T, AIR, {0, 0, 1}, UP}},
    {1, {LENS2, 0, R, GLASS, {0, 0, 2}, UP}},
    {1, {LENS1, 0, R, GLASS, {0, 0, 1}, UP}},
    {1, {LENS2, 0, T, GLASS, {0, 0, 2}, UP}},
    {1, {ODD, 0, A, AIR, {0, 0, 3}, UP}},
    /* 2: total reflection, then away */
    {2, {LENS1, 0, I, GLASS, {0, 0, 1}, UP}},
    {2, {-1, -1, X, AIR, {0, 0, 99}, {0, 0, 0}}},
    /* 3: down on the cover's front; twice, the second time over a segment of no length */
    {3, {COVER, 0, D, AIR, {0, 0, 1}, UP}},
    {3, {COVER, 0, D, AIR, {0, 0, 1}, UP}},
    {3, {-1, -1, X, AIR, {0, 0, 99}, {0, 0, 0}}},
    /* 4: up on the cover's back */
    {4, {COVER, 0, A, AIR, {0, 0, 1}, UP}},
    /* 5: into the tube's face 2, then absorbed in ink */
    {5, {TUBE, 7, T, AIR, {0, 0, 1}, UP}},
    {5, {-1, -1, A, INK, {0, 0, 2}, {0, 0, 0}}},
    /* 6: limit on arrival at the tube */
    {6, {TUBE, 0, K, AIR, {0, 0, 1}, UP}},
    /* 7: error at the mirror, in ink */
    {7, {MIRROR, 0, E, INK, {0, 0, 1}, UP}},
    /* 8 */
    {8, {-1, -1, X, AIR, {0, 0, 99}, {0, 0, 0}}},
    /* 9: a curved segment to the mirror's front */
    {9, {MIRROR, 0, G | R, AIR, {0, 0, 1}, UP}},
    {9, {-1, -1, X, AIR, {0, 0, 99}, {0, 0, 0}}},
    /* 10: the mirror's back, told by the medium although the segment runs against the normal */
    {10, {MIRROR, 0, A, GLASS, {0, 0, -1}, UP}},
    /* 11: scattering, fluorescence, an element, diffuse transmission */
    {11, {-1, -1, S, INK, {0, 0, 1}, {0, 0, 0}}},
    {11, {-1, -1, F, INK, {0, 0, 2}, {0, 0, 0}}},
    {11, {ODD, 0, O, AIR, {0, 0, 3}, UP}},
    {11, {ODD, 0, RMAP_EVENT_TRANSMIT_DIFFUSE, AIR, {0, 0, 4}, UP}},
    {11, {-1, -1, X, AIR, {0, 0, 99}, {0, 0, 0}}},
};

/* sensor: 36 x 24 mm, axis -z. relative 32768 is just right of the centre (0.27 um). */
static const struct {
    int ray;
    struct test_registration registration;
} registration_table[] = {
    {0, {SENSOR, {1, 2}, {32768, 32768}, 1, {0, 0, 1}, 130.0, 2}},
    {1, {SENSOR, {3, 2}, {65535, 0}, 1, {0.5f, 0, 0.8660254f}, 260.0, 4}},
    {8, {SENSOR, {0, 0}, {0, 0}, 0, {0, 0, -1}, 10.0}},
    {9, {SCREEN, {0, 0}, {0, 65535}, 1, {-1, 0, 0}, 299.792458}},
    {9, {SCREEN, {9, 9}, {65535, 0}, 1, {-0.8660254f, 0.5f, 0}, 599.584916, 1}},
    {9, {FAR_GRID, {0, 0}, {16384, 32768}, 1, {0, 0.7071068f, 0.7071068f}, 700.0, 1}},
};

static struct rmap_portion *make_portion(void)
{
    struct rmap_portion *portion = NULL;
    size_t s = 0, g = 0;
    assert_int_equal(rmap_portion_create(N_RAY, 3, &portion, NULL), RMAP_OK);
    for (int i = 0; i < N_RAY; i++) {
        assert_true(test_add_ray(portion, &ray_table[i]));
        for (; s < sizeof step_table / sizeof *step_table && step_table[s].ray == i; s++)
            assert_true(test_add_step(portion, &step_table[s].step));
        for (; g < sizeof registration_table / sizeof *registration_table &&
               registration_table[g].ray == i;
             g++)
            assert_true(test_add_registration(portion, &registration_table[g].registration));
    }
    return portion;
}

static const struct {
    const char *text;
    unsigned rays;
} case_table[] = {
    {"all", ALL},
    {"not all", 0},
    {"all >= 2", 0},
    {"all == 1", ALL},
    {"source(lamp)", RAY(0) | RAY(1)},
    {"source(s*)", ALL & ~(RAY(0) | RAY(1))},
    {"source(*)", ALL},
    {"source(sun) == 0", RAY(0) | RAY(1)},
    /* hit */
    {"hit(lens.1)", RAY(0) | RAY(1) | RAY(2)},
    {"hit(lens.1) >= 2", RAY(1)},
    {"hit(lens.1) == 0", ALL & ~(RAY(0) | RAY(1) | RAY(2))},
    {"hit(lens.1) in 1..1", RAY(0) | RAY(2)},
    {"hit(lens.1) in 2..4", RAY(1)},
    {"hit(lens) == 4", RAY(1)},
    {"hit(lens) != 4", ALL & ~RAY(1)},
    {"hit(lens) < 2", ALL & ~(RAY(0) | RAY(1))},
    {"hit(lens) <= 1", ALL & ~(RAY(0) | RAY(1))},
    {"hit(lens) > 2", RAY(1)},
    {"hit(lens) > 1.5", RAY(0) | RAY(1)},
    {"hit(lens) >= -1", ALL},
    {"hit(lens) == 1.5", 0},
    {"hit(lens) != 1.5", ALL},
    {"hit(lens) < 0", 0},
    {"hit(lens) >= 1e300", 0},
    {"hit(housing)", RAY(0) | RAY(1) | RAY(2) | RAY(3) | RAY(4) | RAY(5) | RAY(6)},
    {"hit(housing) >= 3", RAY(0) | RAY(1)},
    {"hit(lens*) == 4", RAY(1)}, /* group and members match, each step counts once */
    {"hit(?ens.1)", RAY(0) | RAY(1) | RAY(2)},
    {"hit(*)", ALL & ~RAY(8)},
    {"hit('odd n\xc3\xa4me')", RAY(1) | RAY(11)},
    {"hit('odd*')", RAY(1) | RAY(11)},
    {"hit(lens.2, reflect_specular)", RAY(1)},
    {"hit(lens.2, transmit_specular) == 1", RAY(0) | RAY(1)},
    {"hit(lens, reflect_specular) == 2", RAY(1)},
    {"hit(lens, total_reflection)", RAY(2)},
    {"hit(lens, reflect)", RAY(1) | RAY(2)},
    {"hit(*, specular) == 4", RAY(1)},
    {"hit(tube, face 1)", RAY(0)},
    {"hit(tube, face 1, absorb)", RAY(0)},
    {"hit(tube, absorb, face 1)", RAY(0)},
    {"hit(tube, face 1, transmit)", 0},
    {"hit(tube, face 0..1)", RAY(0) | RAY(6)},
    {"hit(tube, face 2)", RAY(5)},
    {"hit(tube, triangle 4..7)", RAY(0) | RAY(5)},
    {"hit(tube, triangle 5..6)", 0},
    {"hit(tube, triangle 0, limit)", RAY(6)},
    {"hit(lens.1, face 0)", RAY(0) | RAY(1) | RAY(2)},
    {"hit(housing, face 1)", RAY(0)},
    /* event */
    {"event(scatter_volume)", RAY(11)},
    {"event(fluoresce)", RAY(11)},
    {"event(element)", RAY(11)},
    {"event(gradient)", RAY(9)},
    {"event(scatter)", RAY(3) | RAY(11)},
    {"event(scatter) >= 2", RAY(3) | RAY(11)},
    {"event(diffuse)", RAY(3) | RAY(11)},
    {"event(transmit)", RAY(0) | RAY(1) | RAY(5) | RAY(11)},
    {"event(transmit_diffuse)", RAY(11)},
    {"event(reflect_specular)", RAY(1) | RAY(9)},
    {"event(absorb)", RAY(0) | RAY(1) | RAY(4) | RAY(5) | RAY(10)},
    {"event(left)", RAY(2) | RAY(3) | RAY(8) | RAY(9) | RAY(11)},
    {"event(limit)", RAY(6)},
    {"event(error)", RAY(7)},
    /* medium */
    {"medium(ink)", RAY(5) | RAY(7) | RAY(11)},
    {"medium(glass) == 3", RAY(1)},
    {"medium(*) == 3", RAY(0) | RAY(3)},
    /* surface */
    {"surface(polished)", RAY(0) | RAY(1) | RAY(2)},
    {"surface(white)", RAY(3)},
    {"surface(white) == 2", RAY(3)},
    {"surface(black)", RAY(0) | RAY(4) | RAY(5) | RAY(6) | RAY(10)},
    {"surface(black, absorb)", RAY(0) | RAY(4) | RAY(10)},
    {"surface(mixed)", RAY(1) | RAY(9) | RAY(11)},
    {"surface(reflectance < 0.1)",
     RAY(0) | RAY(1) | RAY(4) | RAY(5) | RAY(6) | RAY(10)}, /* black, coated; not bare glass */
    {"surface(reflectance > 0.79)", RAY(3)},
    {"surface(reflectance >= 0)", ALL & ~(RAY(2) | RAY(8))},
    {"surface(reflectance != 7)", ALL & ~(RAY(2) | RAY(8))},
    {"not surface(reflectance >= 0)", RAY(2) | RAY(8)},
    {"surface(reflectance in 0.04..0.06)", RAY(0) | RAY(1)},
    {"surface(transmit_specular > 0.9)", RAY(0) | RAY(1)},
    {"surface(transmit_specular > 0.2, transmit_diffuse)", RAY(11)},
    {"surface(absorb in 0.24..0.26)", RAY(1) | RAY(9) | RAY(11)},
    {"surface(reflect_specular > 5)", 0},
    /* ended */
    {"ended(absorbed)", RAY(0) | RAY(1) | RAY(4) | RAY(5) | RAY(10)},
    {"ended(left)", RAY(2) | RAY(3) | RAY(8) | RAY(9) | RAY(11)},
    {"ended(limit)", RAY(6)},
    {"ended(error)", RAY(7)},
    {"ended(absorbed, housing)", RAY(0) | RAY(4)},
    {"ended(absorbed, ink)", RAY(5)},
    {"ended(absorbed, air)", 0}, /* at objects, not in the air before them */
    {"ended(limit, tube)", RAY(6)},
    {"ended(absorbed, tube) == 0", ALL & ~RAY(0)},
    {"ended(left, air)", RAY(2) | RAY(3) | RAY(8) | RAY(9) | RAY(11)},
    /* numbers of a ray */
    {"segments == 5", RAY(1) | RAY(11)},
    {"segments in 3..5", RAY(0) | RAY(1) | RAY(3) | RAY(11)},
    {"bounces == 4", RAY(1) | RAY(11)},
    {"bounces == 0", RAY(4) | RAY(6) | RAY(7) | RAY(8) | RAY(10)},
    {"wavelength == 550", RAY(0)},
    {"wavelength != 550", ALL & ~(RAY(0) | RAY(1))},
    {"not wavelength != 550", RAY(0) | RAY(1)},
    {"wavelength in 0.5..0.6 um", RAY(0) | RAY(3) | RAY(4)},
    {"wavelength in 500 nm..0.6 um", RAY(0) | RAY(3) | RAY(4)},
    {"wavelength > 600", RAY(5)},
    {"flux > 500 mW", RAY(1)},
    {"flux >= 0.5", RAY(0) | RAY(1)},
    {"flux < 0.5 W", ALL & ~(RAY(0) | RAY(1))},
    {"path_length > 12 cm", RAY(1)},
    {"path_length >= 120 mm", RAY(0) | RAY(1)},
    {"path_length == 120", RAY(0)},
    {"optical_path in 129..131", RAY(0)},
    {"ray == 105", RAY(5)},
    {"ray in 103..105", RAY(3) | RAY(4) | RAY(5)},
    {"ray < 102", RAY(0) | RAY(1)},
    /* registrations */
    {"registered(sensor)", RAY(0) | RAY(1)},
    {"crossed(sensor)", RAY(0) | RAY(1) | RAY(8)},
    {"crossed(sensor) and not registered(sensor)", RAY(8)},
    {"registered(s*)", RAY(0) | RAY(1) | RAY(9)},
    {"registered(screen) == 2", RAY(9)},
    {"registered(*) == 3", RAY(9)},
    {"registered(far)", RAY(9)},
    {"registered(sensor, rect(-1, -1, 1, 1))", RAY(0)},
    {"registered(sensor, rect(1, 1, -1, -1))", RAY(0)},
    {"registered(sensor, rect(0, -12, 18, 0))", RAY(1)}, /* the corner is closed */
    {"registered(sensor, rect(0, -12, 17.9999, 0))", 0},
    {"registered(sensor, rect(0, -1.2 cm, 1.8 cm, 0))", RAY(1)},
    {"registered(sensor, rect(0.9, 0, 1, 0.1, rel))", RAY(1)},
    {"crossed(sensor, rect(-18, -12, 0, 0))", RAY(8)},
    {"registered(sensor, ellipse(18, -12, 1, 1))", RAY(1)},
    {"registered(sensor, ellipse(0, 0, 0.001, 2))", RAY(0)},
    {"registered(sensor, ellipse(17, -12, 1, 5))", RAY(1)}, /* on its rim */
    {"registered(sensor, ellipse(16.9, -12, 1, 5))", 0},
    {"registered(sensor, ellipse(17, -11, 0.5, 1.5))", 0},
    {"registered(sensor, ellipse(17, -11, 0.5, 1.5, 45))", RAY(1)}, /* counterclockwise */
    {"registered(sensor, ellipse(17, -11, 0.5, 1.5, -45 deg))", 0},
    {"registered(sensor, polygon(-1,-1, 1,-1, 0,1))", RAY(0)},
    {"registered(sensor, polygon(18,-12, 18,0, 10,-12))", RAY(1)}, /* its corner */
    {"registered(sensor, polygon(17,0, 18,-12, 10,-12, rel))", 0},
    {"registered(sensor, cells(1..3, 2))", RAY(0) | RAY(1)},
    {"registered(sensor, cells(1..2, 0..2))", RAY(0)},
    {"registered(sensor, cells(0, 0))", 0},
    {"crossed(sensor, cells(0, 0))", RAY(8)},
    {"angle(sensor) == 0", RAY(0)},
    {"angle(sensor) < 10 deg", RAY(0)},
    {"angle(sensor) in 29.9..30.1", RAY(1)},
    {"angle(sensor) > 0.5 rad", RAY(1)},
    {"angle(sensor) != 0", RAY(1)},
    {"not angle(sensor) != 0", ALL & ~RAY(1)},
    {"angle(far) in 44.9..45.1", RAY(9)},
    {"x(far) in 44.9..45.1 deg", RAY(9)},
    {"y(far) in 179.9..180.1", RAY(9)},
    {"registered(far, rect(40 deg, 170, 50, 190))", RAY(9)},
    {"x(sensor) > 0", RAY(0) | RAY(1)},
    {"x(sensor) == 18", RAY(1)},
    {"y(sensor) < -1 cm", RAY(1)},
    {"time(screen) <= 1 ns", RAY(9)},
    {"time(screen) < 0.9999 ns", 0},
    {"time(screen) in 1.9..2.1 ns", RAY(9)},
    {"x(screen) < 0 and y(screen) < 0", RAY(9)},
    {"registered(screen where x < 0 and y < 0)", 0},
    {"registered(screen where x < 0 and y > 0)", RAY(9)},
    {"registered(screen where x < 0 or y < 0) == 2", RAY(9)},
    {"registered(screen where not (x < 0)) == 1", RAY(9)},
    {"registered(screen where angle < 10 deg and x == -1)", RAY(9)},
    {"registered(screen where angle > 10 deg and x == -1)", 0},
    {"registered(screen, rect(-1, -1, 0, 1) where time > 1.5 ns)", 0},
    {"registered(screen, rect(0, -1, 1, 1) where time > 1.5 ns)", RAY(9)},
    {"registered(screen, rect(0, -1, 1, 1), where time > 1.5 ns)", RAY(9)},
    /* orders, of the ray and of what came before a registration */
    {"ghost_order == 2", RAY(1)},
    {"ghost_order == 1", RAY(9)},
    {"ghost_order == 0", ALL & ~(RAY(1) | RAY(9))},
    {"scatter_order == 2", RAY(3) | RAY(11)},
    {"scatter_order in 1..9", RAY(3) | RAY(11)},
    {"registered(sensor where ghost_order == 2)", RAY(1)},
    {"registered(sensor where ghost_order == 0)", RAY(0)},
    {"registered(sensor where ghost_order == 2 and angle > 20)", RAY(1)},
    {"registered(sensor where ghost_order == 2 and angle < 20)", 0},
    {"registered(screen where ghost_order == 0)", RAY(9)},
    {"registered(screen where ghost_order >= 0) == 2", RAY(9)},
    {"registered(screen where ghost_order == 1 and x < 0)", 0},
    {"registered(screen where ghost_order == 1 and x > 0)", RAY(9)},
    {"registered(* where scatter_order > 0)", 0},
    {"registered(screen where hit(mirror)) == 1", RAY(9)},
    {"registered(sensor where hit(lens.1) == 2)", RAY(1)},
    {"registered(sensor where hit(lens) in 2..3)", RAY(0)},
    {"registered(sensor where hit(tube))", 0},
    {"registered(sensor where not hit(tube) or bounces == 9)", RAY(0) | RAY(1)},
    {"registered(sensor where surface(coated, reflect))", RAY(1)},
    {"registered(sensor where event(transmit) == 2 and medium(glass) >= 2)", RAY(1)},
    {"registered(sensor where bounces in 3..4)", RAY(1)},
    {"registered(sensor where after(lens.2))", RAY(0) | RAY(1)},
    {"registered(sensor where after(lens))", RAY(0) | RAY(1)},
    {"registered(sensor where after(lens.1))", 0},
    {"registered(sensor where after(lens.2, reflect))", 0},
    {"crossed(sensor where not hit(*))", RAY(8)},
    {"crossed(sensor where not after(*))", RAY(8)},
    /* sides, the step at the registration's own place, and the history up to it */
    {"hit(mirror, side front)", RAY(9)},
    {"hit(mirror, side back)", RAY(10)},
    {"hit(cover, side front) == 2", RAY(3)},
    {"hit(cover, side back, absorb)", RAY(4)},
    {"registered(screen where at(mirror)) == 1", RAY(9)},
    {"registered(screen where at(mirror, reflect))", RAY(9)},
    {"registered(screen where at(mirror, absorb))", 0},
    {"registered(screen where at(mirror, gradient, side front, face 0))", RAY(9)},
    {"registered(screen where at(mirror, side back))", 0},
    {"registered(screen where at(reflect))", 0}, /* of the object that it lies on */
    {"registered(screen where not hit(*) and at(mirror))", RAY(9)},
    {"registered(* where at(*)) == 1", RAY(9)},
    {"registered(* where not at(*)) == 2", RAY(9)},
    {"registered(sensor where path(\"TTV\"))", RAY(0)},
    {"registered(sensor where path(\"TTVA\"))", 0},
    {"registered(sensor where path(\".* R .* R .* V@sensor\"))", RAY(1)},
    {"registered(sensor where path(\".* R .*\") == 0)", RAY(0)},
    {"registered(screen where path(\"R@mirror V\")) == 1", RAY(9)},
    {"registered(screen where path(\".* V\") and path(\"R .*\")) == 2", RAY(9)},
    {"registered(far where path(\"R V@screen X V@screen V@far\"))", RAY(9)},
    {"registered(* where not path(\".* V@'s*'\"))", RAY(9)},
    {"crossed(sensor where path(\"V?\"))", RAY(8)}, /* not registered: no part of the history */
    {"crossed(sensor where path(\".\"))", 0},
    /* logic */
    {"hit(lens.1) and not registered(sensor)", RAY(2)},
    {"source(lamp) & segments == 3 | event(limit)", RAY(0) | RAY(6)},
    {"event(limit) or source(lamp) and segments == 3", RAY(0) | RAY(6)},
    {"(event(limit) or source(lamp)) and segments == 3", RAY(0)},
    {"not source(lamp) and segments == 1", RAY(4) | RAY(6) | RAY(7) | RAY(8) | RAY(10)},
    {"not (source(lamp) or segments >= 2)", RAY(4) | RAY(6) | RAY(7) | RAY(8) | RAY(10)},
    {"!source(lamp) && segments==1 || !all", RAY(4) | RAY(6) | RAY(7) | RAY(8) | RAY(10)},
    {"! ! source(lamp)", RAY(0) | RAY(1)},
};

static unsigned evaluate(const char *text, const struct rmap_scene *scene,
                         const struct rmap_portion *portion)
{
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[N_RAY];
    unsigned rays = 0;
    if (rmap_criterion_compile(text, scene, &criterion, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    memset(match, 7, sizeof match);
    if (rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, &err) != RMAP_OK)
        fail_msg("%s: %s", text, err.text);
    for (int i = 0; i < N_RAY; i++) {
        assert_in_range(match[i], 0, 1);
        rays |= (unsigned)match[i] << i;
    }
    rmap_criterion_destroy(criterion);
    return rays;
}

static void test_words(void **state)
{
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    struct rmap_portion *portion = make_portion();
    int n_wrong = 0;
    for (size_t i = 0; i < sizeof case_table / sizeof *case_table; i++) {
        unsigned rays = evaluate(case_table[i].text, &t.scene, portion);
        if (rays != case_table[i].rays) {
            print_error("%s: rays %03x, expected %03x\n", case_table[i].text, rays,
                        case_table[i].rays);
            n_wrong++;
        }
    }
    assert_int_equal(n_wrong, 0);
    rmap_portion_destroy(portion);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* A portion is read with the criterion's own columns alone: the others must not be touched. */
static void test_only_its_columns(void **state)
{
    (void)state;
    struct test_scene t;
    test_scene_init(&t);
    struct rmap_portion *whole = make_portion();
    for (size_t i = 0; i < sizeof case_table / sizeof *case_table; i++) {
        struct rmap_criterion *criterion = NULL;
        struct rmap_portion part = *whole;
        uint8_t match[N_RAY];
        unsigned rays = 0;
        assert_int_equal(rmap_criterion_compile(case_table[i].text, &t.scene, &criterion, NULL),
                         RMAP_OK);
        for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
            if (!(rmap_criterion_columns(criterion) & RMAP_COLUMN_BIT(c)))
                *rmap_portion_column_address(&part, (enum rmap_column)c) = NULL;
        assert_int_equal(rmap_criterion_evaluate(criterion, &part, flux_per_weight, match, NULL),
                         RMAP_OK);
        for (int r = 0; r < N_RAY; r++)
            rays |= (unsigned)match[r] << r;
        assert_int_equal(rays, case_table[i].rays);
        rmap_criterion_destroy(criterion);
    }
    rmap_portion_destroy(whole);
}

static void test_missing_column(void **state)
{
    (void)state;
    struct test_scene t;
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[N_RAY];
    test_scene_init(&t);
    struct rmap_portion *portion = make_portion();
    assert_int_equal(rmap_criterion_compile("hit(lens.1)", &t.scene, &criterion, &err), RMAP_OK);
    struct rmap_portion part = *portion;
    part.segment.object = NULL;
    assert_int_equal(rmap_criterion_evaluate(criterion, &part, flux_per_weight, match, &err),
                     RMAP_INTERNAL);
    assert_non_null(strstr(err.text, "/segment/object"));
    portion->ray.segment_count[3]++;
    assert_int_equal(rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, &err),
                     RMAP_FORMAT);
    rmap_criterion_destroy(criterion);
    rmap_portion_destroy(portion);
}

/* Numbers out of range in stored rows match nothing and harm nothing. */
static void test_damaged_indices(void **state)
{
    (void)state;
    static const char *const text[] = {"hit(*)",
                                       "hit(lens)",
                                       "hit(tube, face 1)",
                                       "surface(white)",
                                       "medium(*)",
                                       "registered(*)",
                                       "source(*)",
                                       "flux > 0",
                                       "ended(absorbed, housing)",
                                       "angle(sensor) < 90"};
    static const int32_t value[] = {INT32_MAX, INT32_MIN, 6, -2};
    struct test_scene t;
    test_scene_init(&t);
    for (size_t v = 0; v < sizeof value / sizeof *value; v++) {
        struct rmap_portion *portion = make_portion();
        for (size_t i = 0; i < portion->n_row[RMAP_TABLE_SEGMENT]; i++) {
            portion->segment.object[i] = value[v];
            portion->segment.medium[i] = (int16_t)value[v];
        }
        for (int i = 0; i < N_RAY; i++)
            portion->ray.source[i] = value[v];
        for (size_t i = 0; i < portion->n_row[RMAP_TABLE_REGISTRATION]; i++)
            portion->registration.detector[i] = value[v];
        for (size_t i = 0; i < sizeof text / sizeof *text; i++)
            if ((int16_t)value[v] < 0 || (int16_t)value[v] > 2)
                assert_int_equal(evaluate(text[i], &t.scene, portion), 0);
        portion->segment.object[0] = TUBE;
        portion->segment.primitive[0] = value[v] == 6 ? 8 : value[v];
        assert_int_equal(evaluate("hit(tube, face 0..2)", &t.scene, portion), 0);
        rmap_portion_destroy(portion);
    }
}

/* Rays longer than a strip of rows, rays with none, and an empty portion. */
static void test_long_rays(void **state)
{
    (void)state;
    struct test_scene t;
    struct rmap_criterion *criterion = NULL;
    struct rmap_portion *portion = NULL;
    static const size_t length[] = {0, 5000, 0, 9000, 1, 4096, 8192, 0, 3, 0};
    enum { N = sizeof length / sizeof *length };
    uint8_t match[N];
    test_scene_init(&t);
    assert_int_equal(rmap_portion_create(N, 3, &portion, NULL), RMAP_OK);
    assert_int_equal(rmap_criterion_compile("hit(tube) == 4096", &t.scene, &criterion, NULL),
                     RMAP_OK);
    assert_int_equal(rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, NULL),
                     RMAP_OK);
    for (size_t i = 0; i < N; i++) {
        assert_true(test_add_ray(portion, &ray_table[0]));
        for (size_t s = 0; s < length[i]; s++)
            assert_true(test_add_step(portion, &(struct test_step){s % 2 ? TUBE : LENS1}));
    }
    for (size_t want = 0; want < 5000; want += 1) {
        char text[64];
        bool known = false;
        for (size_t i = 0; i < N; i++)
            known |= length[i] / 2 == want;
        if (!known)
            continue;
        rmap_criterion_destroy(criterion);
        snprintf(text, sizeof text, "hit(tube) == %zu", want);
        assert_int_equal(rmap_criterion_compile(text, &t.scene, &criterion, NULL), RMAP_OK);
        assert_int_equal(rmap_criterion_evaluate(criterion, portion, flux_per_weight, match, NULL),
                         RMAP_OK);
        for (size_t i = 0; i < N; i++)
            assert_int_equal(match[i], length[i] / 2 == want);
    }
    rmap_criterion_destroy(criterion);
    rmap_portion_destroy(portion);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_words),          cmocka_unit_test(test_only_its_columns),
        cmocka_unit_test(test_missing_column), cmocka_unit_test(test_damaged_indices),
        cmocka_unit_test(test_long_rays),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

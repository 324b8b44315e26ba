/* SPDX-License-Identifier: MIT
 *
 * Gradient media of scene files: their fields, the places in which they stand, and mistakes.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "gradient/curve.h"
#include "tests/unit/near.h"
#include "tests/unit/read_text.h"

/* A scene around a medium `m` and a list of objects and sources. */
static struct rmap_scene *scene_of(const char *medium, const char *objects, const char *sources,
                                   char **told)
{
    static char text[16384];
    (void)snprintf(text, sizeof text,
                   "raymap: 1\n"
                   "units: mm\n"
                   "spectrum: {wavelengths: [400, 500, 700]}\n"
                   "media:\n"
                   "  air: {index: 1}\n"
                   "  m: %s\n"
                   "geometries:\n"
                   "  ball: {type: sphere, radius: 2}\n"
                   "  tube: {type: cylinder, radius: 1, length: 4}\n"
                   "  end: {type: disc, radius: 1}\n"
                   "  lens:\n"
                   "    type: lens\n"
                   "    surfaces:\n"
                   "      - {radius: 50, thickness: 3, medium: m, aperture: 5}\n"
                   "      - {radius: -50, thickness: 2, medium: air, aperture: 5}\n"
                   "      - {radius: 40, thickness: 1, medium: m, aperture: 5}\n"
                   "      - {radius: inf, thickness: 1, medium: m, aperture: 4, stop: true}\n"
                   "      - {radius: -40, medium: air, aperture: 5}\n"
                   "objects:\n%s\n"
                   "sources:\n%s\n",
                   medium, objects, sources);
    return read_text(text, told);
}

static const char beam[] = "  - {name: s, type: collimated, shape: {disc: 1}, at: [0, 0, -9]}";
static const char rod[] =
    "  - name: rod\n"
    "    at: [1, 2, 3]\n"
    "    objects:\n"
    "      - {name: side, geometry: tube, surface: fresnel, outside: air, inside: m}\n"
    "      - {name: in, geometry: end, surface: fresnel, back: air, front: m}\n"
    "      - {name: out, geometry: end, at: [0, 0, 4], surface: fresnel, back: m, front: air}";

static struct rmap_scene *good_scene(const char *medium, const char *objects, const char *sources)
{
    char *told = NULL;
    struct rmap_scene *scene = scene_of(medium, objects, sources, &told);
    if (!scene)
        fail_msg("%s: %s", medium, told);
    free(told);
    return scene;
}

static double index_at(const struct rmap_gradient *gradient, double x, double y, double z)
{
    double n = 0;
    struct rmap_vec3 slope;
    struct rmap_vec3 local = rmap_affine_point(&gradient->to_local, rmap_vec3(x, y, z));
    assert_true(rmap_field_at(gradient->field, 0, local, &n, &slope));
    return n;
}

static void test_places_of_bodies(void **state)
{
    (void)state;
    struct rmap_scene *scene = good_scene(
        "{gradient: {type: luneburg, radius: 2, at: [0, 0, 0.5], tolerance: 1e-5, scheme: sharma, "
        "step_max: 0.5}}",
        "  - {name: a, geometry: ball, surface: fresnel, outside: air, inside: m}\n"
        "  - {name: b, geometry: ball, at: [10, 0, 0], scale: 2, surface: fresnel, outside: air, "
        "inside: m}",
        beam);
    assert_int_equal(scene->n_gradient, 2);
    assert_int_equal(scene->object[0].gradient_front, 0);
    assert_int_equal(scene->object[0].gradient_back, 1);
    assert_int_equal(scene->object[1].gradient_back, 2);
    assert_int_equal(scene->source[0].gradient, 0);
    const struct rmap_gradient *a = &scene->gradient[0], *b = &scene->gradient[1];
    assert_ptr_equal(a->field, scene->medium[a->medium].field);
    assert_near(index_at(a, 0, 0, 0.5), sqrt(2), 1e-14);
    assert_near(index_at(b, 10, 0, 1), sqrt(2), 1e-14);
    assert_near(index_at(b, 10, 4, 1), 1, 1e-14);
    assert_near(a->size, 4 * sqrt(3), 1e-12);
    assert_int_equal(a->options.scheme, RMAP_SCHEME_SHARMA);
    assert_true(a->options.tolerance == 1e-5 && a->options.step_max == 0.5);
    assert_near(a->options.step_min, 1e-4 * a->size, 1e-15);
    assert_int_equal(a->options.max_steps, 1000000);
    rmap_scene_destroy(scene);
}

/* Luneburg's rays have a closed form; `integrated` leaves it alone. */
static void test_closed_form(void **state)
{
    static const char *const body =
        "  - {name: a, geometry: ball, surface: fresnel, outside: air, inside: m}";
    static const char *const medium[2] = {
        "{gradient: {type: luneburg, radius: 2}}",
        "{gradient: {type: luneburg, radius: 2, scheme: integrated}}"};
    (void)state;
    for (int i = 0; i < 2; i++) {
        struct rmap_scene *scene = good_scene(medium[i], body, beam);
        struct rmap_curve curve;
        assert_true(rmap_curve_begin(&curve, &scene->gradient[0], 0, rmap_vec3(0, 0, 0.5),
                                     rmap_vec3(0, 0, 1)));
        assert_int_equal(scene->gradient[0].options.scheme,
                         i ? RMAP_SCHEME_INTEGRATED : RMAP_SCHEME_ADAPTIVE);
        assert_int_equal(curve.closed, i == 0);
        rmap_scene_destroy(scene);
    }
}

static void test_frames(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        good_scene("{gradient: {type: parabolic, n0: 1.6, alpha: 0.1, frame: rod}}", rod, beam);
    assert_int_equal(scene->n_gradient, 1);
    for (int o = 0; o < 3; o++)
        assert_int_equal(scene->object[o].gradient_front + scene->object[o].gradient_back, 1);
    assert_near(index_at(&scene->gradient[0], 1, 2, 99), 1.6, 1e-14);
    assert_near(index_at(&scene->gradient[0], 2, 2, 3), 1.6 * sqrt(1 - 0.01), 1e-14);
    rmap_scene_destroy(scene);

    scene = good_scene("{gradient: {type: axial, coefficients: [1.5, 0.1], frame: world}}", rod,
                       "  - {name: s, type: point, at: [0, 0, -9], medium: m}");
    assert_int_equal(scene->n_gradient, 1);
    assert_int_equal(scene->source[0].gradient, 1);
    assert_near(index_at(&scene->gradient[0], 0, 0, 2), 1.7, 1e-14);
    rmap_scene_destroy(scene);
}

/* Each element stands behind the vertex of its first surface, whatever bounds it. */
static void test_places_of_a_lens(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        good_scene("{gradient: {type: axial, coefficients: [1.5, 0.1]}}",
                   "  - {name: l, geometry: lens, at: [0, 0, 7], outside: air}", beam);
    assert_int_equal(scene->n_gradient, 2);
    for (size_t o = 0; o < scene->n_object; o++) {
        const struct rmap_object *object = &scene->object[o];
        int32_t place = object->gradient_front + object->gradient_back;
        bool second = strcmp(object->name, "l.3") >= 0 && object->name[2] != 'e';
        if (strcmp(object->name, "l.edge.1") == 0 || strcmp(object->name, "l.edge.2") == 0)
            second = object->name[7] == '2';
        else if (strncmp(object->name, "l.stop", 6) == 0)
            continue;
        assert_int_equal(place, second ? 2 : 1);
    }
    assert_near(index_at(&scene->gradient[0], 0, 0, 8), 1.6, 1e-14);
    assert_near(index_at(&scene->gradient[1], 0, 0, 13), 1.6, 1e-14);
    rmap_scene_destroy(scene);
}

static void test_sources_within(void **state)
{
    (void)state;
    static const char two[] =
        "  - {name: a, geometry: ball, surface: fresnel, outside: air, inside: m}\n"
        "  - {name: b, geometry: ball, at: [10, 0, 0], surface: fresnel, outside: air, inside: m}";
    struct rmap_scene *scene =
        good_scene("{gradient: {type: maxwell, radius: 2}}", two,
                   "  - {name: s, type: point, at: [10, 0, 0], medium: m, within: b}");
    assert_int_equal(scene->source[0].gradient, 2);
    rmap_scene_destroy(scene);
}

static void test_dispersion_and_scattering(void **state)
{
    (void)state;
    struct rmap_scene *scene = good_scene(
        "{gradient: {type: constant, index: {wavelength: [400, 700], value: [1.6, 1.3]}}, "
        "scattering: 0.5, scattering_g: 0.9, absorption: 0.1}",
        "  - {name: a, geometry: ball, surface: fresnel, outside: air, inside: m}", beam);
    const struct rmap_medium *medium = &scene->medium[1];
    assert_true(medium->dispersive && medium->scattering_at_all && medium->absorbing);
    assert_int_equal(medium->field->n_channel, 3);
    assert_near(medium->n[1], 1.5, 1e-14);
    assert_true(medium->scattering[2] == 0.5 && medium->scattering_g == 0.9);
    rmap_scene_destroy(scene);
}

/* Every model, at (1, 0.5, 0.25) of a ball of radius 2 and 500 nm. */
static const struct {
    const char *gradient;
    double n;
} models[] = {
    {"type: constant, index: 1.5", 1.5},
    {"type: luneburg, radius: 2", 1.2930100540985752},         /* sqrt(2 - 21 / 64) */
    {"type: maxwell, radius: 2", 1.5058823529411764},          /* 2 / (1 + 21 / 64) */
    {"type: eaton, radius: 2", 1.5784442479149772},            /* sqrt(4 / r - 1), r^2 = 21 / 16 */
    {"type: gutman, radius: 2, focus: 4", 1.0807260291119114}, /* sqrt(1 + (4 - 21/16) / 16) */
    {"type: parabolic, n0: 1.6, alpha: 0.1", 1.5899685531481433},
    {"type: selfoc, n0: 1.6, A: 0.02", 1.5800000000000001},
    {"type: axial, coefficients: [1.5, 0.1]", 1.525},
    {"type: radial, coefficients: [2.25, -0.04], of: n^2", 1.4832396974191326},
    {"type: spherical, coefficients: [1.5, -0.01]", 1.4868749999999999},
    {"type: polynomial, terms: [{power: [0, 0, 0], value: 1.5}, {power: [1, 1, 0], value: 0.1}]",
     1.55},
    {"type: zemax, gradient: 4, parameters: {n0: 1.5, nx1: 0.01, ny2: 0.02, nz1: 0.04}", 1.525},
    {"type: exponential, refractivity: 0.5, scale_height: 0.25", 1.1839397205857212},
    {"type: profile, along: z, coordinate: [0, 1, 2], n: [3, 4, 5]", 3.25},
    {"type: noise, mean: 1.4, amplitude: 0, length: 1, octaves: 3, seed: 2", 1.4},
    {"type: formula, formula: 'a + 0.1 * x * y', constants: {a: 1.3}", 1.35},
    {"type: formula, formula: '1 + lambda'", 1.5},
    {"type: sum, terms: [{type: constant, index: 1.2}, {type: constant, index: 1.3, weight: 0.5}]",
     1.35},
    {"type: sum, terms: [{type: axial, coefficients: [1, 1], at: [0, 0, -1]}]", 2.25},
    {"type: index_of, law: linear, n0: 1.3, slope: 0.1, field: {type: formula, formula: '-y'}",
     1.25},
    {"type: index_of, law: gladstone_dale, n0: 1.0003, reference: 1.2, field: {type: formula, "
     "formula: '2.4 * x'}",
     1.0006},
    {"type: index_of, law: table, table: {value: [0, 1, 2], n: [1.3, 1.4, 1.5]}, field: {type: "
     "sum, terms: [{type: formula, formula: y}, {type: formula, formula: y}]}",
     1.4},
    {"type: constant, index: 1.5, dispersion: {table: {wavelength: [400, 600], n: [1.6, 1.4]}, "
     "reference: 600}",
     1.6},
    {"type: constant, index: 1.5, dispersion: {table: {wavelength: [400, 600], n: [1.6, 1.4]}, "
     "reference: 600, mode: refractivity}",
     1.625},
    {"type: constant, index: 1.5, dispersion: {sellmeier: {B: [1.25], C: [0]}, mode: "
     "multiplicative}",
     1.5},
};

static const char one_ball[] =
    "  - {name: a, geometry: ball, surface: fresnel, outside: air, inside: m}";

static void test_models(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof models / sizeof models[0]; i++) {
        char medium[512];
        double n = 0;
        struct rmap_vec3 slope;
        (void)snprintf(medium, sizeof medium, "{gradient: {%s}}", models[i].gradient);
        struct rmap_scene *scene = good_scene(medium, one_ball, beam);
        assert_int_equal(scene->n_gradient, 1);
        assert_true(
            rmap_field_at(scene->gradient[0].field, 1, rmap_vec3(1, 0.5, 0.25), &n, &slope));
        if (!(fabs(n - models[i].n) < 1e-12))
            fail_msg("%s: %.17g", models[i].gradient, n);
        rmap_scene_destroy(scene);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

/* Physical laws are in their own tests: here, that their keys reach them. */
static void test_laws(void **state)
{
    (void)state;
    static const struct {
        const char *gradient;
        double from, to;
    } law[] = {
        {"type: standard_atmosphere", 1.00027, 1.00029},
        {"type: standard_atmosphere, temperature: 100, pressure: 50000", 1.00009, 1.00012},
        {"type: index_of, law: air, unit: K, field: {type: formula, formula: '288.15'}", 1.00027,
         1.00029},
        {"type: index_of, law: air, pressure: 202650, field: {type: formula, formula: '15'}",
         1.00054, 1.00058},
        {"type: index_of, law: seawater_salinity, temperature: 20, field: {type: formula, formula: "
         "'0'}",
         1.33, 1.34},
        {"type: index_of, law: seawater_temperature, salinity: 35, field: {type: formula, formula: "
         "'20'}",
         1.34, 1.35},
    };
    for (size_t i = 0; i < sizeof law / sizeof law[0]; i++) {
        char medium[512];
        double n = 0;
        struct rmap_vec3 slope;
        (void)snprintf(medium, sizeof medium, "{gradient: {%s}}", law[i].gradient);
        struct rmap_scene *scene = good_scene(medium, one_ball, beam);
        assert_true(rmap_field_at(scene->gradient[0].field, 1, rmap_vec3(0, 0, 0), &n, &slope));
        if (!(n > law[i].from && n < law[i].to))
            fail_msg("%s: %.17g", law[i].gradient, n);
        rmap_scene_destroy(scene);
    }
}

/* What is told about a medium `m` that fills a ball, or about objects and sources. */
static const struct {
    const char *medium, *objects, *sources, *told;
} mistakes[] = {
    {"{gradient: {type: luneberg, radius: 2}}", NULL, NULL,
     "unknown type 'luneberg' (did you mean 'luneburg'?)"},
    {"{gradient: {type: luneburg}}", NULL, NULL, "s:6:17: error: 'radius' is missing: add it"},
    {"{gradient: {type: luneburg, radius: 0}}", NULL, NULL, "s:6:17: error: "},
    {"{gradient: {type: luneburg, radius: 2, size: 1}}", NULL, NULL,
     "s:6:45: error: unknown key in a gradient of type luneburg: 'size'"},
    {"{gradient: {type: luneburg, radius: 2, tolerance: 0}}", NULL, NULL,
     "s:6:56: error: 'tolerance' must be greater than 0, not 0"},
    {"{gradient: {type: luneburg, radius: 2, step: 1}}", NULL, NULL,
     "'step' is for 'scheme: fixed': the scheme here is adaptive"},
    {"{gradient: {type: luneburg, radius: 2, scheme: sharma, step_min: 2, step_max: 1}}", NULL,
     NULL, "'step_min' must not be above 'step_max'"},
    {"{gradient: {type: luneburg, radius: 2, scale: 0}}", NULL, NULL, "this transform is singular"},
    {"{gradient: {type: luneburg, radius: 2, frame: nobody}}", NULL, NULL,
     "unknown frame 'nobody'"},
    {"{gradient: {type: luneburg, radius: 2, frame: s}}", NULL, NULL,
     "'s' is no object or group: a frame is one of these, or 'world', or 'object'"},
    {"{gradient: luneburg}", NULL, NULL, "a gradient must be a mapping"},
    {"{gradient: {type: axial, coefficients: []}}", NULL, NULL,
     "'coefficients' must be a list of 1 to 32 numbers"},
    {"{gradient: {type: axial, coefficients: [1, {wavelength: [1], value: [1, 2]}]}}", NULL, NULL,
     "'value' has 2 entries, 'wavelength' has 1"},
    {"{gradient: {type: polynomial, terms: [{power: [0, 0, 0.5], value: 1}]}}", NULL, NULL,
     "powers are whole numbers"},
    {"{gradient: {type: zemax, gradient: 8, parameters: {n0: 1}}}", NULL, NULL,
     "there is no gradient 8 here"},
    {"{gradient: {type: zemax, gradient: 5, parameters: {n0: 1, nq: 2}}}", NULL, NULL,
     "s:6:64: error: unknown key in a Zemax gradient: 'nq'"},
    {"{gradient: {type: noise, mean: 1, amplitude: 0.1, length: 0}}", NULL, NULL,
     "'length' must be greater than 0, not 0"},
    {"{gradient: {type: formula, formula: 1 + foo}}", NULL, NULL,
     "s:6:42: error: the formula is wrong: Unexpected token \"foo\" found at position 4."},
    {"{gradient: {type: formula, formula: x, slope: [1, 0]}}", NULL, NULL,
     "'slope' must be a list of 3 formulas"},
    {"{gradient: {type: formula, formula: x, constants: {x: 1}}}", NULL, NULL,
     "the formula is wrong"},
    {"{gradient: {type: sum, terms: []}}", NULL, NULL, "'terms' must be a list"},
    {"{gradient: {type: sum, terms: [{type: constant, index: 1, weight: no}]}}", NULL, NULL,
     "'weight' must be a finite number, not 'no'"},
    {"{gradient: {type: sum, terms: [{type: sum, terms: [{type: none}]}]}}", NULL, NULL,
     "unknown type 'none'"},
    {"{gradient: {type: index_of, law: linear, n0: 1, slope: 1}}", NULL, NULL,
     "'field' is missing"},
    {"{gradient: {type: index_of, law: air, n0: 1, field: {type: formula, formula: x}}}", NULL,
     NULL, "'n0' has no part in 'law: air'"},
    {"{gradient: {type: grid, file: absent.h5}}", NULL, NULL,
     "s:6:36: error: ./absent.h5 cannot be opened as an HDF5 file"},
    {"{gradient: {type: grid, file: a, origin: [0, 0, 0], lower: [0, 0, 0]}}", NULL, NULL,
     "give 'origin' or 'lower', not both"},
    {"{gradient: {type: grid, file: a, spacing: 1}}", NULL, NULL,
     "'spacing' must be a list of 3 numbers"},
    {"{gradient: {type: constant, index: 1.5, dispersion: {}}}", NULL, NULL,
     "dispersion needs one of glass, sellmeier, table"},
    {"{gradient: {type: constant, index: 1.5, dispersion: {glass: N-BK8}}}", NULL, NULL,
     "unknown glass 'N-BK8' (did you mean 'BK8', 'N-BK7'?"},
    {"{gradient: {type: constant, index: 1.5, dispersion: {sellmeier: {B: [-9], C: [0]}}}}", NULL,
     NULL, "the dispersion has no index at 587.56 nm"},
    {"{gradient: {type: luneburg, radius: 2}, index: 1}", NULL, NULL,
     "needs one of index, glass, sellmeier, table, gradient, not several"},
    {"{index: 1, scattering_g: 0.5}", NULL, NULL, "give that too"},
    {"{index: 1, scattering: -1}", NULL, NULL, "'scattering' must be 0 or greater, not -1"},
    {"{index: 1, scattering: 1, scattering_g: 1}", NULL, NULL, "'scattering_g' must be"},
    {"{index: 1, scattering: {coefficient: 1}, scattering_g: 0}", NULL, NULL, "'g' stands in"},
    {"{index: 1, scattering: {g: 0.5}}", NULL, NULL, "scattering has a 'coefficient'"},
    {"{index: 1, scattering: {coefficient: 1, g: 0, phase: rayleigh}}", NULL, NULL,
     "give it or 'phase'"},
    {"{index: 1, scattering: {coefficient: 1, phase: raleigh}}", NULL, NULL,
     "unknown phase 'raleigh' (did you mean 'rayleigh'?)"},
    {"{index: 1, scattering: {coefficient: 1, reference: 550}}", NULL, NULL,
     "'reference' is the wavelength of the coefficient of 'phase: rayleigh'"},
    {"{index: 1, scattering: {coefficient: 1, phase: {angle: [0, 180], value: [0, 0]}}}", NULL,
     NULL, "values above 0 somewhere"},
    {"{index: 1, scattering: {coefficient: 1, phase: {angle: [90], value: [1]}}}", NULL, NULL,
     "values above 0 somewhere"},
    {"{index: 1, scattering: {coefficient: 1, mie: {diameter: 1 um, n: 1.5, share: 0.1}}}", NULL,
     NULL, "or 'mie' alone"},
    {"{index: 1, scattering: {haze: 8 %, thickness: 3 mm}}", NULL, NULL, "mean cosine 'g'"},
    {"{index: 1, scattering: {mie: {diameter: 1 um, n: 1.5}}}", NULL, NULL,
     "how many spheres? Give 'share' of the volume, or 'density', their number per mm^3"},
    {"{index: 1, scattering: {mie: {diameter: 10, n: 1.5, share: 0.1}}}", NULL, NULL,
     "too large for 'mie' (is the unit right, as in 0.5 um?)"},
    {"{index: 1, scattering: {mie: {diameter: 1 um, share: 0.1}}}", NULL, NULL,
     "'mie' has one of material, n (and k), table"},
    {"{gradient: {type: parabolic, n0: 1.6, alpha: 0.1}}", rod, NULL,
     "medium 'm' stands beside surfaces with frames of their own ('side', 'out'): say where its "
     "index lives"},
    {"{gradient: {type: parabolic, n0: 1.6, alpha: 0.1}}", NULL,
     "  - {name: s, type: point, medium: air, within: a}", "'within' is for gradient media"},
    {"{gradient: {type: parabolic, n0: 1.6, alpha: 0.1}}", NULL,
     "  - {name: s, type: point, medium: m, within: b}", "unknown object or group 'b'"},
    {"{gradient: {type: parabolic, n0: 1.6, alpha: 0.1}}",
     "  - {name: a, geometry: ball, surface: absorber}",
     "  - {name: s, type: point, medium: m, within: a}", "medium 'm' is on no side of 'a'"},
    {"{gradient: {type: parabolic, n0: 1.6, alpha: 0.1}}",
     "  - {name: a, geometry: ball, surface: absorber}", "  - {name: s, type: point, medium: m}",
     "'s' stands in medium 'm', which stands in no place"},
};

static void test_mistakes(void **state)
{
    (void)state;
    for (size_t i = 0; i < sizeof mistakes / sizeof mistakes[0]; i++) {
        char *told = NULL;
        struct rmap_scene *scene =
            scene_of(mistakes[i].medium, mistakes[i].objects ? mistakes[i].objects : one_ball,
                     mistakes[i].sources ? mistakes[i].sources : beam, &told);
        if (scene || !strstr(told, mistakes[i].told))
            fail_msg("case %zu: told\n%sexpected\n%s", i, told, mistakes[i].told);
        free(told);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places_of_bodies),
        cmocka_unit_test(test_closed_form),
        cmocka_unit_test(test_frames),
        cmocka_unit_test(test_places_of_a_lens),
        cmocka_unit_test(test_sources_within),
        cmocka_unit_test(test_dispersion_and_scattering),
        cmocka_unit_test(test_mistakes),
        cmocka_unit_test(test_models),
        cmocka_unit_test(test_laws),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

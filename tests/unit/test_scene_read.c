/* SPDX-License-Identifier: MIT
 *
 * What a scene file says is what the scene holds.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

#include "optics/spectrum.h"
#include "tests/unit/near.h"
#include "tests/unit/read_text.h"

static struct rmap_scene *must_read(const char *text)
{
    char *told = NULL;
    struct rmap_scene *scene = read_text(text, &told);
    if (!scene)
        printf("%s", told);
    assert_non_null(scene);
    free(told);
    return scene;
}

static int index_of(const struct rmap_scene *scene, const char *name)
{
    for (size_t i = 0; i < scene->n_object; i++)
        if (strcmp(scene->object[i].name, name) == 0)
            return (int)i;
    for (size_t i = 0; i < scene->n_medium; i++)
        if (strcmp(scene->medium[i].name, name) == 0)
            return (int)i;
    for (size_t i = 0; i < scene->n_surface; i++)
        if (strcmp(scene->surface[i].name, name) == 0)
            return (int)i;
    return -1;
}

static void assert_vec(struct rmap_vec3 v, double x, double y, double z)
{
    assert_near(v.x, x, 1e-12);
    assert_near(v.y, y, 1e-12);
    assert_near(v.z, z, 1e-12);
}

#define SOURCE "sources: [{name: s, type: point}]\n"

/* ---- closed bodies ---- */

static void test_bodies(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "geometries:\n"
        "  brick: {type: box, size: [2, 4, 6]}\n"
        "  bar: {type: prism, points: [[0, 0], [1 cm, 0], [0, 5]], length: 3}\n"
        "  hexagon: {type: prism, sides: 6, radius: 2, length: 1}\n"
        "  rod: {type: cylinder, radius: 2, length: 7, closed: true}\n"
        "  tip: {type: cone, radius: 0, radius2: 3, length: 7, closed: true}\n"
        "objects:\n"
        "  - {name: a, geometry: brick, surface: absorber}\n"
        "  - {name: b, geometry: rod, at: [1, 0, 0], surface: absorber}\n"
        "  - {name: c, geometry: tip, surface: absorber}\n"
        "detectors:\n"
        "  - {name: d, type: plane, on: {object: a, faces: [-x, top]}, cells: 1}\n" SOURCE);
    const struct rmap_mesh *brick = scene->geometry[0].mesh;
    struct rmap_vec3 lower, upper;
    rmap_mesh_bounds(brick, &lower, &upper);
    assert_vec(lower, -1, -2, 0);
    assert_vec(upper, 1, 2, 6);
    assert_int_equal(brick->n_triangle, 12);
    assert_string_equal(brick->face_name[3], "+x");
    assert_int_equal(scene->detector[0].face[1], 1);
    assert_int_equal(scene->detector[0].face[5], 1);
    assert_int_equal(scene->detector[0].face[3], 0);
    assert_int_equal(scene->n_object, 1 + 3 + 2); /* no bottom at the tip */
    int bottom = index_of(scene, "b.bottom"), top = index_of(scene, "b.top");
    assert_vec(scene->object[bottom].to_world.t, 1, 0, 0);
    assert_near(scene->object[bottom].to_world.m[2][2], -1, 0);
    assert_vec(scene->object[top].to_world.t, 1, 0, 7);
    assert_near(scene->geometry[scene->object[top].geometry].shape.aperture, 2, 0);
    assert_int_equal(index_of(scene, "c.bottom"), -1);
    rmap_scene_destroy(scene);
}

/* ---- copies ---- */

static void test_copies(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read("raymap: 1\n"
                  "geometries:\n"
                  "  ball: {type: sphere, radius: 1}\n"
                  "  rod: {type: cylinder, radius: 2, length: 7, closed: true}\n"
                  "objects:\n"
                  "  - name: hall\n"
                  "    scale: 2\n"
                  "    objects:\n"
                  "      - name: desk\n"
                  "        copies: {count: [3, 2], step: [10, 2 cm]}\n"
                  "        at: [1, 0, 0]\n"
                  "        rotate: [0, 0, 90]\n"
                  "        objects:\n"
                  "          - {name: bead, geometry: ball, surface: absorber, at: [5, 0, 0],\n"
                  "             copies: {count: 2, step: 3}}\n"
                  "          - {name: rod, geometry: rod, surface: absorber}\n" SOURCE);
    assert_int_equal(scene->n_geometry, 4);
    assert_int_equal(scene->n_object, 3 * 2 * (2 + 3));
    assert_int_equal(scene->n_group, 1 + 1 + 6 * 3); /* hall, desk, desk.N, its bead, its rod */
    /* The fifth: second along x, second along y. Within it x is turned to y. */
    int bead = index_of(scene, "desk.5.bead.2");
    assert_true(bead >= 0);
    assert_vec(scene->object[bead].to_world.t, 2 * (1 + 10), 2 * (20 + 5 + 3), 0);
    const struct rmap_group *group = &scene->group[scene->object[bead].parent];
    assert_string_equal(group->name, "desk.5.bead");
    assert_string_equal(scene->group[group->parent].name, "desk.5");
    assert_true(index_of(scene, "desk.6.rod.top") >= 0);
    rmap_scene_destroy(scene);
}

/* Sources stand in a group's frame, are copied and made larger with it. */
static void test_sources_in_groups(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "geometries: {ball: {type: sphere, radius: 1}}\n"
        "objects:\n"
        "  - name: hall\n"
        "    scale: 2\n"
        "    at: [0, 0, 5]\n"
        "    objects:\n"
        "      - name: lamp\n"
        "        copies: {count: 3, step: 10}\n"
        "        rotate: [180, 0, 0]\n"
        "        sources:\n"
        "          - {name: panel, type: area, shape: {rectangle: [3, 1]}, at: [1, 0, 1], "
        "spectrum: "
        "{lines: {500: 1}}, direction: [0, 0, 1]}\n"
        "          - {name: ray, type: rays, rays: [{origin: [0, 1, 0], direction: [0, 0, 1], "
        "wavelength: 600}]}\n"
        "        objects: [{name: bead, geometry: ball, surface: absorber}]\n");
    assert_int_equal(scene->n_source, 6);
    assert_int_equal(scene->channels.n, 2); /* wavelengths of sources in groups, too */
    assert_string_equal(scene->source[2].name, "lamp.2.panel");
    assert_string_equal(scene->group[scene->source[2].parent].name, "lamp.2");
    assert_vec(scene->source[2].frame.t, 2 * (10 + 1), 0, 5 - 2 * 1);
    assert_vec(rmap_affine_vector(&scene->source[2].frame, rmap_vec3(0, 0, 1)), 0, 0, -1);
    assert_near(scene->source[2].shape_size[0], 6, 1e-12);
    assert_near(scene->source[2].shape_size[1], 2, 1e-12);
    assert_vec(scene->source[5].list[0].origin, 2 * 20, -2, 5);
    assert_vec(scene->source[5].list[0].direction, 0, 0, -1);
    rmap_scene_destroy(scene);
}

/* A beam that fills an object: through its middle, as wide as it, along its axis turned by the
 * field angles, from in front of everything. */
static void test_filling_beam(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "geometries: {pane: {type: disc, radius: 3}, wall: {type: rectangle, size: [40, 40]}}\n"
        "objects:\n"
        "  - {name: pane, geometry: pane, at: [1, 2, 30], rotate: [0, 90, 0], surface: absorber}\n"
        "  - {name: wall, geometry: wall, at: [-50, 0, 0], surface: absorber}\n"
        "sources:\n"
        "  - {name: sun, type: collimated, fills: pane, field: 30 deg}\n"
        "  - {name: moon, type: collimated, fills: pane, field: [-10, 0]}\n");
    const struct rmap_source *sun = &scene->source[0], *moon = &scene->source[1];
    const struct rmap_vec3 way = rmap_affine_vector(&sun->frame, rmap_vec3(0, 0, 1));
    assert_near(sun->shape_size[0], 3, 1e-9);
    assert_vec(way, cos(RMAP_PI / 6), sin(RMAP_PI / 6), 0);
    const struct rmap_vec3 gap = rmap_sub(rmap_vec3(1, 2, 30), sun->frame.t);
    assert_near(rmap_length(rmap_cross(gap, way)), 0, 1e-9);
    assert_true(rmap_dot(gap, way) > 51);
    /* Local x of the pane is -z of the world. */
    assert_vec(rmap_affine_vector(&moon->frame, rmap_vec3(0, 0, 1)), cos(RMAP_PI / 18), 0,
               sin(RMAP_PI / 18));
    rmap_scene_destroy(scene);
}

/* ---- merge keys ---- */

static void test_merge_keys(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read("raymap: 1\n"
                                         "media:\n"
                                         "  one: &one {index: 1.5, absorption: 1}\n"
                                         "  two: {<<: *one, index: 2}\n"
                                         "  three: {<<: [{absorption: 3}, *one]}\n"
                                         "  four: &four {<<: &base {<<: *one, absorption: 4}}\n"
                                         "  five: {<<: *four}\n"
                                         "  six: {<<: *base}\n" SOURCE);
    static const double want[6][2] = {{1.5, 1}, {2, 1}, {1.5, 3}, {1.5, 4}, {1.5, 4}, {1.5, 4}};
    for (int i = 0; i < 6; i++) {
        assert_near(scene->medium[i].n[0], want[i][0], 0);
        assert_near(scene->medium[i].absorption[0], want[i][1], 0);
    }
    rmap_scene_destroy(scene);
}

/* ---- units ---- */

static void test_units(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "\xef\xbb\xbfraymap: 1\nunits: m\n"
        "spectrum: {wavelengths: [632.8 nm, 0.4861 um]}\n"
        "media:\n"
        "  ink: {index: 1, absorption: 3 /cm, scattering: 2 /m}\n"
        "  oil: {table: {wavelength: [0.4 um, 700 nm], n: [1.5, 1.4]}, wavelength_unit: um}\n"
        "surfaces: {grey: {type: lambert, reflectance: 7 %}}\n"
        "geometries: {ball: {type: sphere, radius: 5 mm}}\n"
        "objects:\n"
        "  - {name: bead, geometry: ball, surface: grey, at: [1, 2 in, 3 cm],\n"
        "     rotate: [0, 0, 100 mrad]}\n"
        "sources:\n"
        "  - {name: s, type: point, cone: 0.5 rad, spectrum: {lines: {632.8 nm: 1}}}\n"
        "  - {name: hot, type: point, spectrum: {blackbody: 4000 K}}\n");
    assert_near(scene->channels.wavelength_nm[0], 486.1, 1e-12);
    assert_near(scene->channels.wavelength_nm[1], 632.8, 0);
    assert_near(scene->medium[0].absorption[0], 300, 0);
    assert_near(scene->medium[0].scattering[0], 2, 0);
    assert_near(scene->medium[1].n[1], 1.5 - 0.1 * (632.8 - 400) / 300, 1e-12);
    assert_near(scene->surface[0].reflect_diffuse[0], 0.07, 0);
    assert_near(scene->geometry[0].shape.radius, 0.005, 0);
    assert_vec(scene->object[0].to_world.t, 1, 0.0508, 0.03);
    assert_near(scene->object[0].to_world.m[1][0], sin(0.1), 1e-15);
    assert_near(scene->source[0].cone_rad, 0.5, 1e-15);
    assert_near(scene->source[0].colour[1], 1, 0);
    rmap_scene_destroy(scene);
}

/* ---- channels ---- */

static void test_wavelengths(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read("raymap: 1\nspectrum: {wavelengths: [656, 486, 588]}\n" SOURCE);
    assert_int_equal(scene->channels.n, 3);
    assert_near(scene->channels.wavelength_nm[0], 486, 0);
    assert_near(scene->channels.wavelength_nm[2], 656, 0);
    rmap_scene_destroy(scene);

    scene =
        must_read("raymap: 1\nspectrum: {wavelengths: {from: 400, to: 700, step: 100}}\n" SOURCE);
    assert_int_equal(scene->channels.n, 4);
    assert_near(scene->channels.wavelength_nm[3], 700, 1e-9);
    rmap_scene_destroy(scene);

    scene = must_read("raymap: 1\n" SOURCE);
    assert_int_equal(scene->channels.n, 41);
    assert_near(scene->channels.wavelength_nm[40], 780, 1e-9);
    rmap_scene_destroy(scene);

    scene = must_read("raymap: 1\nsources:\n"
                      "  - {name: a, type: point, spectrum: {lines: {550: 1, 633: 2}}}\n"
                      "  - {name: b, type: rays, rays: [{origin: [0,0,0], direction: [0,0,2], "
                      "wavelength: 488}]}\n");
    assert_int_equal(scene->channels.n, 3);
    assert_near(scene->channels.wavelength_nm[0], 488, 0);
    assert_near(scene->source[0].colour[2], 2.0 / 3, 1e-15);
    assert_int_equal(scene->source[1].list[0].channel, 0);
    assert_vec(scene->source[1].list[0].direction, 0, 0, 1);
    rmap_scene_destroy(scene);
}

static void test_rgb_takes_the_d_line(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read("raymap: 1\nspectrum: {mode: rgb}\n"
                                         "media: {glass: {glass: N-BK7}}\n" SOURCE);
    assert_int_equal(scene->channels.mode, RMAP_COLOUR_RGB);
    assert_int_equal(scene->channels.n, 3);
    /* n_d of N-BK7: 1.5168 (SCHOTT data sheet) */
    for (int i = 0; i < 3; i++)
        assert_near(scene->medium[0].n[i], 1.5168, 5e-6);
    assert_false(scene->medium[0].dispersive);
    rmap_scene_destroy(scene);
}

/* ---- media and surfaces ---- */

static void test_media(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\nunits: mm\nspectrum: {wavelengths: [500, 600]}\n"
        "media:\n"
        "  air: {index: 1}\n"
        "  bk7: {glass: n-bk7, absorption: 0.01}\n"
        "  own: {sellmeier: {B: [1.03961212, 0.231792344, 1.01046945], C: [6000.69867, 20017.9144, "
        "103560653]}, wavelength_unit: nm}\n"
        "  ink: {table: {wavelength: [500, 600], n: [1.3, 1.4], k: [0, 1.0e-6]}, "
        "absorption: {wavelength: [500, 600], value: [0.5, 1]}}\n" SOURCE);
    const struct rmap_medium *bk7 = &scene->medium[1], *own = &scene->medium[2],
                             *ink = &scene->medium[3];
    assert_int_equal(scene->n_medium, 4);
    assert_true(bk7->dispersive && bk7->absorbing);
    assert_near(bk7->absorption[1], 0.01, 0);
    assert_near(own->n[0], bk7->n[0], 1e-12);
    assert_near(own->n[1], bk7->n[1], 1e-12);
    assert_near(ink->n[1], 1.4, 0);
    assert_near(ink->absorption[0], 0.5, 0);
    /* 4 pi k / lambda = 4 pi 1e-6 / 600e-6 mm */
    assert_near(ink->absorption[1], 1 + 4 * RMAP_PI * 1e-6 / 600e-6, 1e-12);
    assert_false(scene->medium[0].absorbing || scene->medium[0].dispersive);
    assert_string_equal(scene->medium[0].description, "index 1");
    rmap_scene_destroy(scene);
}

/* 25 mm of N-BK7 let 0.992 of 400 nm through and 0.994 of 580 nm; the means of bands lie about
 * that. */
static void test_absorption_of_the_catalogue(void **state)
{
    (void)state;
    static const char *const said[] = {"{glass: N-BK7}", "{glass: N-BK7, absorption: catalogue}"};
    for (int asked = 0; asked < 2; asked++)
        for (int rgb = 0; rgb < 2; rgb++) {
            char text[512];
            (void)snprintf(
                text, sizeof text,
                "raymap: 1\nunits: cm\nspectrum: {%s}\nmedia: {air: {index: 1}, bk7: %s}\n%s",
                rgb ? "mode: rgb" : "wavelengths: [400, 580]", said[asked], SOURCE);
            struct rmap_scene *scene = must_read(text);
            const struct rmap_medium *bk7 = &scene->medium[1];
            assert_true(bk7->absorbing == (asked == 1));
            const int blue = rgb ? 2 : 0, red = rgb ? 0 : 1;
            const double slack = rgb ? 0.3 : 1e-12;
            assert_near(bk7->absorption[blue], asked ? -log(0.992) / 2.5 : 0, slack * 0.004);
            assert_near(bk7->absorption[red], asked ? -log(0.995) / 2.5 : 0, slack * 0.004);
            rmap_scene_destroy(scene);
        }
}

static void test_surfaces(void **state)
{
    (void)state;
    struct rmap_scene *scene =
        must_read("raymap: 1\nspectrum: {wavelengths: [450, 550, 650]}\n"
                  "surfaces:\n"
                  "  coated: {type: fresnel, coat: {reflectance: {wavelength: [450, 650], value: "
                  "[0, 0.2]}}}\n"
                  "  ideal: {type: fresnel, coat: ideal}\n"
                  "  silver: {type: mirror, metal: {table: {wavelength: [400, 700], n: [0.1, 0.1], "
                  "k: [1, 4]}}}\n"
                  "  gold: {type: mirror, metal: {n: 0.2, k: 3}}\n"
                  "  glossy: {type: mirror, reflectance: 0.9}\n"
                  "  paint: {type: lambert, reflectance: {rgb: [0.8, 0.5, 0.1]}}\n"
                  "  milk: {type: mixture, reflect_diffuse: 0.5, transmit_diffuse: 0.5}\n"
                  "  plated: {type: mirror, metal: ag}\n" SOURCE);
    const struct rmap_surface *s = scene->surface;
    assert_int_equal(scene->n_surface, 8);
    assert_int_equal(s[0].coat, RMAP_COAT_REFLECTANCE);
    assert_near(s[0].reflect_specular[1], 0.1, 1e-15);
    assert_int_equal(s[1].coat, RMAP_COAT_IDEAL);
    assert_true(s[2].is_metal);
    assert_near(s[2].metal_k[1], 2.5, 1e-12);
    assert_near(s[3].metal_n[2], 0.2, 0);
    assert_near(s[4].reflect_specular[0], 0.9, 0);
    assert_near(s[5].reflect_diffuse[0], 0.1, 0); /* 450 nm: blue */
    assert_near(s[5].reflect_diffuse[2], 0.8, 0);
    assert_near(s[6].transmit_diffuse[1], 0.5, 0);
    assert_true(s[7].is_metal); /* Johnson & Christy 1972: 548.6 nm 0.06 + 3.586 i */
    assert_near(s[7].metal_n[1], 0.06, 2e-3);
    assert_near(s[7].metal_k[1], 3.586, 2e-2);
    rmap_scene_destroy(scene);
}

/* ---- geometries and places ---- */

static void test_geometries(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "geometries:\n"
        "  asphere: {type: conic, radius: 40, conic: -1, asphere: {4: 1.0e-6, 8: 2.0e-12}, "
        "aperture: 5, inner: 1}\n"
        "  plane: {type: conic, radius: inf, aperture: 5}\n"
        "  plate: {type: rectangle, size: [2, 3]}\n"
        "  ring: {type: disc, radius: 4, inner: 2}\n"
        "  pipe: {type: cylinder, radius: 3, length: 7}\n"
        "  funnel: {type: cone, radius: 3, radius2: 0, length: 7}\n"
        "  ball: {type: sphere, radius: 6}\n"
        "objects:\n"
        "  - {name: a, geometry: asphere, surface: absorber}\n"
        "  - {name: b, geometry: plane, surface: absorber}\n"
        "  - {name: c, geometry: plate, surface: absorber}\n"
        "  - {name: d, geometry: ring, surface: absorber}\n"
        "  - {name: e, geometry: pipe, surface: absorber}\n"
        "  - {name: f, geometry: funnel, surface: absorber}\n"
        "  - {name: g, geometry: ball, surface: absorber}\n"
        "  - {name: h, geometry: ball, surface: absorber}\n" SOURCE);
    const struct rmap_geometry *g = scene->geometry;
    assert_int_equal(scene->n_geometry, 7);
    assert_near(g[0].shape.curvature, 0.025, 0);
    assert_near(g[0].shape.asphere[1], 1e-6, 0);
    assert_near(g[0].shape.asphere[3], 2e-12, 0);
    assert_int_equal(g[0].shape.n_asphere, 4);
    assert_near(g[1].shape.curvature, 0, 0);
    assert_near(g[2].shape.size[1], 3, 0);
    assert_near(g[3].shape.inner, 2, 0);
    assert_near(g[4].shape.radius2, 3, 0);
    assert_near(g[5].shape.radius2, 0, 0);
    assert_int_equal(g[6].shape.type, RMAP_SHAPE_SPHERE);
    assert_int_equal(scene->object[6].geometry, scene->object[7].geometry);
    rmap_scene_destroy(scene);
}

static void test_places_compose(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "media: {air: {index: 1}, glass: {index: 1.5}}\n"
        "geometries: {ball: {type: sphere, radius: 1}}\n"
        "objects:\n"
        "  - name: outer\n"
        "    at: [100, 0, 0]\n"
        "    rotate: [0, 0, 90]\n"
        "    objects:\n"
        "      - name: inner\n"
        "        scale: [1, 2, -3]\n"
        "        objects:\n"
        "          - {name: ball, geometry: ball, at: [1, 1, 1], surface: {front: fresnel, back: "
        "absorber}, inside: glass, outside: air, id: 7c1f0a52}\n"
        "  - {name: free, geometry: ball, matrix: [2,0,0,5, 0,1,0,6, 0,0,1,7], surface: absorber, "
        "id: 42}\n" SOURCE);
    const struct rmap_object *ball = &scene->object[0], *other = &scene->object[1];
    /* (1, 1, 1) -> (1, 2, -3) -> turned about z (-2, 1, -3) -> (98, 1, -3) */
    assert_vec(rmap_affine_point(&ball->to_world, rmap_vec3(0, 0, 0)), 98, 1, -3);
    assert_vec(rmap_affine_vector(&ball->to_world, rmap_vec3(0, 0, 1)), 0, 0, -3);
    assert_true(ball->id == 0x7c1f0a52 && other->id == 42);
    assert_string_equal(scene->medium[ball->medium_front].name, "air");
    assert_string_equal(scene->medium[ball->medium_back].name, "glass");
    assert_int_equal(scene->surface[ball->surface_front].type, RMAP_SURFACE_FRESNEL);
    assert_int_equal(scene->surface[ball->surface_back].type, RMAP_SURFACE_ABSORBER);
    assert_int_equal(other->medium_front, RMAP_MEDIUM_ANY);
    assert_vec(rmap_affine_point(&other->to_world, rmap_vec3(1, 1, 1)), 7, 7, 8);
    assert_int_equal(scene->n_group, 2);
    assert_int_equal(ball->parent, 1);
    assert_int_equal(scene->group[1].parent, 0);
    assert_int_equal(ball->line, 12);
    rmap_scene_destroy(scene);
}

/* ---- sources ---- */

static void test_sources(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\nspectrum: {wavelengths: [500, 555, 600]}\n"
        "media: {water: {index: 1.33}}\n"
        "sources:\n"
        "  - {name: a, type: collimated, shape: {rectangle: [2, 4]}, at: [1, 2, 3], direction: [0, "
        "0, -2], flux: 5 mW, rays_share: 3}\n"
        "  - {name: b, type: point, distribution: {cone: 30}, flux: 2}\n"
        "  - {name: c, type: point, cosine_power: 5, direction: [1, 0, 0]}\n"
        "  - {name: d, type: area, shape: {disc: 2}, distribution: lambertian, rotate: [90, 0, 0], "
        "flux: 683 lm, spectrum: {lines: {555: 1}}, medium: water}\n"
        "  - {name: e, type: point, distribution: {table: {angle: [0, 0.5 rad], value: [3, 3]}}}\n"
        "  - {name: f, type: collimated, shape: {disc: 2}, angular_diameter: 0.5 deg}\n");
    const struct rmap_source *s = scene->source;
    assert_int_equal(s[4].distribution, RMAP_DISTRIBUTION_TABLE);
    assert_near(s[4].profile.knot[0].intensity * 2 * RMAP_PI * (1 - cos(0.5)), 1, 1e-12);
    assert_int_equal(s[5].distribution, RMAP_DISTRIBUTION_CONE);
    assert_near(s[5].cone_rad, 0.25 * RMAP_PI / 180, 1e-15);
    assert_int_equal(scene->flux_unit, RMAP_FLUX_W);
    assert_near(s[0].flux, 5e-3, 1e-18);
    assert_near(s[0].share, 3, 0);
    assert_vec(rmap_affine_vector(&s[0].frame, rmap_vec3(0, 0, 1)), 0, 0, -1);
    assert_vec(s[0].frame.t, 1, 2, 3);
    assert_near(s[0].colour[0] + s[0].colour[1] + s[0].colour[2], 1, 1e-15);
    assert_int_equal(s[1].distribution, RMAP_DISTRIBUTION_CONE);
    assert_near(s[1].cone_rad, RMAP_PI / 6, 1e-15);
    assert_int_equal(s[2].distribution, RMAP_DISTRIBUTION_COSINE);
    assert_near(s[2].cosine_power, 5, 0);
    assert_vec(rmap_affine_vector(&s[2].frame, rmap_vec3(0, 0, 1)), 1, 0, 0);
    assert_vec(rmap_affine_vector(&s[3].frame, rmap_vec3(0, 0, 1)), 0, -1, 0);
    assert_near(s[3].flux, 1 / rmap_luminous_efficiency(555), 1e-6); /* lm turned into W */
    /* No air, no vacuum, nothing stands in the water: the rest is a vacuum. */
    assert_string_equal(scene->medium[s[0].medium].name, "vacuum");
    assert_string_equal(scene->medium[s[3].medium].name, "water");
    rmap_scene_destroy(scene);

    scene = must_read("raymap: 1\nsources: [{name: a, type: point, flux: 2 klm, spectrum: D65}]\n");
    assert_int_equal(scene->flux_unit, RMAP_FLUX_LM);
    assert_near(scene->source[0].flux, 2000, 0);
    rmap_scene_destroy(scene);
}

/* ---- detectors ---- */

static void test_detectors(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "geometries: {plate: {type: rectangle, size: [4, 2]}}\n"
        "objects:\n"
        "  - {name: floor, geometry: plate, at: [0, 0, 7], rotate: [90, 0, 0], surface: absorber}\n"
        "  - {name: pair, objects: [{name: p1, geometry: plate, at: [5, 0, 0], surface: "
        "absorber}]}\n"
        "detectors:\n"
        "  - {name: a, type: plane, size: [3, 2], cells: [30, 20], at: [1, 2, 3]}\n"
        "  - {name: b, type: plane, size: 1, cells: 4, direction: [1, 0, 0], side: back, "
        "max_angle: "
        "30}\n"
        "  - {name: c, type: plane, on: floor, cells: [8, 4]}\n"
        "  - {name: d, type: plane, on: pair, cells: 2}\n"
        "  - {name: e, type: intensity, cells: [18, 36], axis: [0, 1, 0]}\n" SOURCE);
    const struct rmap_detector *d = scene->detector;
    assert_vec(d[0].axis, 0, 0, -1);
    assert_vec(d[0].x, 1, 0, 0);
    assert_vec(d[0].y, 0, 1, 0);
    assert_vec(d[0].origin, 1, 2, 3);
    assert_int_equal(d[0].side, RMAP_SIDE_FRONT);
    assert_near(d[0].max_angle_rad, RMAP_PI / 2, 1e-15);
    assert_vec(d[1].x, 0, 1, 0);
    assert_vec(d[1].y, 0, 0, 1);
    assert_near(d[1].size[1], 1, 0);
    assert_int_equal(d[1].cells[1], 4);
    assert_int_equal(d[1].side, RMAP_SIDE_BACK);
    assert_int_equal(d[2].on_object, 0);
    assert_int_equal(d[2].side, RMAP_SIDE_BOTH);
    assert_vec(d[2].origin, 0, 0, 7);
    assert_vec(d[2].axis, 0, -1, 0);
    assert_vec(d[2].x, 1, 0, 0);
    assert_vec(d[2].y, 0, 0, 1);
    assert_near(d[2].size[0], 4, 1e-12);
    assert_near(d[2].size[1], 2, 1e-12);
    assert_int_equal(d[3].on_group, 0);
    assert_near(d[3].size[0], 14, 1e-12); /* the plate reaches x = 7 from the group's origin */
    assert_int_equal(d[4].type, RMAP_DETECTOR_INTENSITY);
    assert_vec(d[4].axis, 0, 1, 0);
    assert_vec(d[4].x, 1, 0, 0);
    assert_near(d[4].size[1], 2 * RMAP_PI, 1e-12);
    rmap_scene_destroy(scene);
}

static void test_turned_frames(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read(
        "raymap: 1\n"
        "sources:\n"
        "  - {name: s, type: area, shape: {disc: 1}, matrix: [0,0,5,1, 0,5,0,2, -5,0,0,3]}\n"
        "detectors:\n"
        "  - {name: a, type: plane, size: 1, cells: 2, rotate: [0, 90, 0], at: [1, 2, 3]}\n"
        "  - {name: b, type: plane, size: 1, cells: 2, matrix: [2,0,0,7, 0,-3,0,8, 0,0,4,9]}\n"
        "  - {name: c, type: intensity, cells: 2, rotate: [90, 0, 0]}\n");
    const struct rmap_detector *d = scene->detector;
    /* Of a source's matrix only place and orientation count. */
    assert_vec(rmap_affine_vector(&scene->source[0].frame, rmap_vec3(0, 0, 1)), 1, 0, 0);
    assert_vec(rmap_affine_vector(&scene->source[0].frame, rmap_vec3(1, 0, 0)), 0, 0, -1);
    assert_vec(scene->source[0].frame.t, 1, 2, 3);
    assert_vec(d[0].axis, 1, 0, 0);
    assert_vec(d[0].x, 0, 0, -1);
    assert_vec(d[0].origin, 1, 2, 3);
    assert_vec(d[1].y, 0, -1, 0);
    assert_vec(d[1].axis, 0, 0, 1);
    assert_vec(d[1].origin, 7, 8, 9);
    assert_vec(d[2].axis, 0, -1, 0);
    assert_vec(d[2].x, 1, 0, 0);
    rmap_scene_destroy(scene);
}

/* An L of two plates as a mesh, and a closed box whose normals cancel. */
static const char *const obj_of_l = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\nv 0 0 2\nv 0 1 2\n"
                                    "f 1 2 3 4\nf 1 4 6 5\n";
static const char *const obj_of_box = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n"
                                      "f 1 4 3\nf 2 3 4\n";

static void write_text(const char *path, const char *text)
{
    FILE *out = fopen(path, "w");
    assert_non_null(out);
    assert_true(fputs(text, out) >= 0);
    assert_int_equal(fclose(out), 0);
}

static void test_detectors_on_meshes(void **state)
{
    (void)state;
    char text[1500], l[64], box[64], *told = NULL;
    (void)snprintf(l, sizeof l, "l-%ld.obj", (long)getpid());
    (void)snprintf(box, sizeof box, "box-%ld.obj", (long)getpid());
    write_text(l, obj_of_l);
    write_text(box, obj_of_box);
    (void)snprintf(
        text, sizeof text,
        "raymap: 1\ngeometries: {l: {type: mesh, file: %s}, box: {type: mesh, file: %s}}\n"
        "objects:\n"
        "  - {name: o, geometry: l, at: [10, 0, 0], surface: absorber}\n"
        "  - {name: b, geometry: box, surface: absorber}\n"
        "detectors:\n"
        "  - {name: d, type: plane, on: o, cells: 2}\n"
        "  - {name: e, type: plane, on: b, cells: 2%s}\n" SOURCE,
        l, box, ", direction: [0, 0, 1]");
    struct rmap_scene *scene = must_read(text);
    const struct rmap_detector *d = scene->detector;
    /* Equal areas facing +z and +x; the box of the mesh is 2 x 1 x 2 about (1, 0.5, 1). */
    assert_vec(d[0].axis, sqrt(0.5), 0, sqrt(0.5));
    assert_vec(d[0].origin, 11, 0.5, 1);
    assert_vec(d[0].x, sqrt(0.5), 0, -sqrt(0.5));
    assert_vec(d[0].y, 0, 1, 0);
    assert_near(d[0].size[0], 2 * sqrt(2), 1e-6);
    assert_near(d[0].size[1], 1, 1e-6);
    assert_vec(d[1].axis, 0, 0, 1);
    assert_vec(d[1].origin, 0.5, 0.5, 0.5);
    rmap_scene_destroy(scene);

    char *choice = strstr(text, ", direction: [0, 0, 1]");
    memset(choice, ' ', strlen(", direction: [0, 0, 1]"));
    assert_null(read_text(text, &told));
    assert_string_equal(told,
                        "s:8:5: error: the normals of mesh 'b' cancel: say where detector 'e' "
                        "faces, with 'direction'\n");
    free(told);
    assert_int_equal(unlink(l), 0);
    assert_int_equal(unlink(box), 0);
}

/* ---- what takes part ---- */

static const char *const chosen_text =
    "raymap: 1\n"
    "geometries: {ball: {type: sphere, radius: 1}, disc: {type: disc, radius: 1}}\n"
    "objects:\n"
    "  - {name: box, objects: [{name: b1, geometry: ball, surface: absorber}, {name: b2, geometry: "
    "ball, surface: absorber}]}\n"
    "  - {name: wall, geometry: disc, surface: absorber}\n"
    "sources: [{name: s1, type: point}, {name: s2, type: point}]\n"
    "detectors:\n"
    "  - {name: d1, type: plane, on: wall, cells: 1}\n"
    "  - {name: d2, type: intensity, cells: [2, 2]}\n"
    "simulations:\n"
    "  - {name: quick, rays: 1e5, time_limit: 2 min, without: [box], sources: [s2], detectors: "
    "[d2],"
    " color: rgb, record: false, limits: {steps: 7}}\n";

static struct rmap_scene *choose(struct rmap_scene_options options, const char *told_expected)
{
    struct rmap_bundle *bundle = bundle_of(".", chosen_text);
    char *told = NULL;
    bundle->options = options;
    struct rmap_scene *scene = read_bundle(bundle, &told);
    assert_string_equal(told, told_expected);
    rmap_bundle_destroy(bundle);
    free(told);
    return scene;
}

static void test_simulation(void **state)
{
    (void)state;
    struct rmap_scene_options options = {.simulation = rmap_strdup("quick")};
    struct rmap_scene *scene = choose(options, "");
    assert_non_null(scene);
    assert_int_equal(scene->n_object, 1);
    assert_int_equal(scene->n_group, 0);
    assert_int_equal(scene->n_geometry, 1);
    assert_int_equal(scene->object[0].geometry, 0);
    assert_int_equal(scene->n_source, 1);
    assert_string_equal(scene->source[0].name, "s2");
    assert_int_equal(scene->n_detector, 1);
    assert_int_equal(scene->channels.mode, RMAP_COLOUR_RGB);
    assert_int_equal(scene->limit_steps, 7);
    assert_string_equal(scene->simulation.name, "quick");
    assert_int_equal(scene->simulation.rays, 100000);
    assert_near(scene->simulation.time_limit_s, 120, 0);
    assert_false(scene->simulation.record);
    rmap_scene_destroy(scene);

    options = (struct rmap_scene_options){.color = rmap_strdup("spectrl")};
    assert_null(
        choose(options, "s: error: unknown --color 'spectrl' (did you mean 'spectral'?)\n"));
    options = (struct rmap_scene_options){.simulation = rmap_strdup("quik")};
    assert_null(choose(options, "s: error: unknown simulation 'quik' (did you mean 'quick'?)\n"));
}

static void test_only_and_without(void **state)
{
    (void)state;
    struct rmap_scene_options options = {.color = rmap_strdup("spectral")};
    add_word(&options.only, &options.n_only, "box");
    add_word(&options.without, &options.n_without, "b1");
    struct rmap_scene *scene =
        choose(options, "s: warning: detector 'd1' is left out with what it lies on\n");
    assert_non_null(scene);
    assert_int_equal(scene->n_object, 1);
    assert_string_equal(scene->object[0].name, "b2");
    assert_int_equal(scene->object[0].parent, 0);
    assert_int_equal(scene->n_source, 2);
    assert_int_equal(scene->n_detector, 1);
    assert_false(scene->simulation.name);
    rmap_scene_destroy(scene);

    options = (struct rmap_scene_options){0};
    add_word(&options.without, &options.n_without, "s1");
    add_word(&options.without, &options.n_without, "s2");
    assert_null(choose(options, "s: error: no sources: all of them are left out\n"));

    options = (struct rmap_scene_options){0};
    add_word(&options.only, &options.n_only, "bx");
    assert_null(choose(options, "s: error: unknown name in --only: 'bx' (did you mean 'box'?)\n"));
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_set(void **state)
{
    (void)state;
    struct rmap_scene_options options = {0};
    add_word(&options.set, &options.n_set, "objects.b2.at=[0, 0, 3]");
    add_word(&options.set, &options.n_set, "sources.1.flux=3 W");
    add_word(&options.set, &options.n_set, "limits.steps=5");
    add_word(&options.set, &options.n_set, "geometries.ball.radius=2");
    struct rmap_scene *scene = choose(options, "");
    assert_non_null(scene);
    assert_near(scene->object[index_of(scene, "b2")].to_world.t.z, 3, 0);
    assert_near(scene->source[0].flux, 3, 0);
    assert_int_equal(scene->limit_steps, 5);
    assert_near(scene->geometry[0].shape.radius, 2, 0);
    rmap_scene_destroy(scene);

    options = (struct rmap_scene_options){0};
    add_word(&options.set, &options.n_set, "objects.wal.at=[0, 0, 3]");
    add_word(&options.set, &options.n_set, "limits.stps=5");
    add_word(&options.set, &options.n_set, "limits");
    add_word(&options.set, &options.n_set, "limits.steps={");
    char expected[] =
        "s: error: --set objects.wal.at=[0, 0, 3]: no item named 'wal' (did you mean 'wall'?) "
        "(items of a list: by name, or by number from 1)\n"
        "s: error: --set limits: write key.path=value\n"
        "s: error: --set limits.steps={: the value is not YAML: this is not YAML: did not find "
        "expected node content while parsing a flow node\n"
        "s: error: --set limits.stps=5: unknown key in limits: 'stps' (did you mean 'steps'?)\n";
    assert_null(choose(options, expected));
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_order_of_sections_is_free(void **state)
{
    (void)state;
    struct rmap_scene *scene = must_read("sources: [{name: s, type: point, medium: fog}]\n"
                                         "objects: [{name: b, geometry: g, surface: absorber}]\n"
                                         "geometries: {g: {type: sphere, radius: 1.5}}\n"
                                         "media: {fog: {index: 1.25}}\n"
                                         "raymap: 1\n");
    assert_near(scene->geometry[0].shape.radius, 1.5, 0);
    assert_near(scene->medium[scene->source[0].medium].n[0], 1.25, 0);
    rmap_scene_destroy(scene);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_bodies),
        cmocka_unit_test(test_copies),
        cmocka_unit_test(test_sources_in_groups),
        cmocka_unit_test(test_filling_beam),
        cmocka_unit_test(test_merge_keys),
        cmocka_unit_test(test_units),
        cmocka_unit_test(test_wavelengths),
        cmocka_unit_test(test_rgb_takes_the_d_line),
        cmocka_unit_test(test_media),
        cmocka_unit_test(test_absorption_of_the_catalogue),
        cmocka_unit_test(test_surfaces),
        cmocka_unit_test(test_geometries),
        cmocka_unit_test(test_places_compose),
        cmocka_unit_test(test_sources),
        cmocka_unit_test(test_detectors),
        cmocka_unit_test(test_turned_frames),
        cmocka_unit_test(test_detectors_on_meshes),
        cmocka_unit_test(test_simulation),
        cmocka_unit_test(test_only_and_without),
        cmocka_unit_test(test_set),
        cmocka_unit_test(test_order_of_sections_is_free),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

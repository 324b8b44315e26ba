/* SPDX-License-Identifier: MIT
 *
 * A bundle opens from a file, travels as bytes, and gives the same scene at the other end; no
 * lack of memory on the way leaks or crashes.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "io/mesh/bundle_pack.h"
#include "tests/unit/read_text.h"

static const char *const scene_text =
    "raymap: 1\n"
    "spectrum: {wavelengths: {from: 400, to: 700, step: 100}}\n"
    "media:\n"
    "  air: {index: 1}\n"
    "  ink: {table: {wavelength: [400, 700], n: [1.3, 1.4], k: [0, 1.0e-6]}}\n"
    "  fog: {gradient: {type: sum, frame: l, terms: [{type: parabolic, n0: 1.5, alpha: 0.01}, "
    "{type: noise, mean: 1, amplitude: 0.01, length: 2, at: [0, 0, 1]}], dispersion: {glass: "
    "N-BK7}}}\n"
    "  hot: {gradient: {type: index_of, law: air, field: {type: formula, formula: 20 + a * z, "
    "constants: {a: 2}}}, scattering: 0.1}\n"
    "surfaces:\n"
    "  silver: {type: mirror, metal: {n: 0.2, k: 3}, scatter: {model: ggx, alpha: [0.1, 0.3]}, "
    "frame: uv}\n"
    "  coat: {type: fresnel, coat: {reflectance: {wavelength: [400, 700], value: [0, 0.1]}}}\n"
    "geometries:\n"
    "  body: {type: mesh, file: tetra.obj, scale: cm, uv: true}\n"
    "  ball: {type: sphere, radius: 2}\n"
    "  lens: {type: lens, surface: coat, surfaces: [{radius: 50, thickness: 5, medium: N-BK7, "
    "aperture: 9}, {medium: air, thickness: 1, aperture: 8}, {medium: air, aperture: 5, stop: "
    "true}]}\n"
    "objects:\n"
    "  - {name: l, geometry: lens, outside: air}\n"
    "  - {name: g, at: [0, 0, 90], objects: [{name: m, geometry: body, surface: silver}]}\n"
    "  - {name: b, geometry: ball, surface: coat, inside: fog, outside: air, at: [0, 30, 0]}\n"
    "  - {name: c, geometry: ball, surface: coat, inside: hot, outside: air, at: [0, 60, 0]}\n"
    "sources:\n"
    "  - {name: s, type: collimated, shape: {disc: 3}, spectrum: {lines: {400: 1, 500: 2}}}\n"
    "  - {name: t, type: area, shape: {mesh: body}, flux: 5 lm, spectrum: {blackbody: 3000}}\n"
    "  - {name: r, type: rays, rays: [{origin: [0, 0, 0], direction: [0, 0, 1]}]}\n"
    "detectors:\n"
    "  - {name: d, type: plane, on: m, cells: [2, 2], direction: [0, 0, -1]}\n"
    "  - {name: f, type: intensity, cells: [2, 2]}\n"
    "simulations:\n"
    "  - {name: q, rays: 7, without: [r]}\n";

static const char *const tetra = "g sides\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                 "vt 0 0\nvt 1 0\nvt 0 1\nvt 1 1\n"
                                 "f 1/1 3/3 2/2\nf 1/1 2/2 4/4\ng slope\n"
                                 "f 1/1 4/4 3/3\nf 2/2 3/3 4/4\n";

static void write_file(const char *path, const void *bytes, size_t n)
{
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(bytes, 1, n, out), n);
    assert_int_equal(fclose(out), 0);
}

/* A folder with the scene and its mesh; left behind for the next test. */
static int set_up(void **state)
{
    static char folder[] = "bundle-XXXXXX";
    if (!mkdtemp(folder))
        return -1;
    char path[64];
    (void)snprintf(path, sizeof path, "%s/tetra.obj", folder);
    write_file(path, tetra, strlen(tetra));
    *state = folder;
    return 0;
}

static int tear_down(void **state)
{
    char path[64];
    (void)snprintf(path, sizeof path, "%s/tetra.obj", (char *)*state);
    return unlink(path) || rmdir(*state);
}

static struct rmap_bundle *whole_bundle(const char *folder)
{
    struct rmap_bundle *bundle = bundle_of(folder, scene_text);
    if (!bundle)
        return NULL;
    bundle->options.simulation = rmap_strdup("q");
    add_word(&bundle->options.set, &bundle->options.n_set, "limits.steps=9");
    return bundle;
}

/* Numbers and names of a scene as text, everything the tracer would use. */
static char *portrait(const struct rmap_scene *scene)
{
    char *text = NULL;
    size_t nbytes = 0;
    FILE *out = open_memstream(&text, &nbytes);
    fprintf(out, "%s %a %d %d %llu\n", scene->unit, scene->unit_m, scene->channels.n,
            (int)scene->flux_unit, (unsigned long long)scene->limit_steps);
    for (size_t i = 0; i < scene->n_medium; i++)
        fprintf(out, "%s %a %a\n", scene->medium[i].name, scene->medium[i].n[1],
                scene->medium[i].absorption[1]);
    for (size_t i = 0; i < scene->n_surface; i++)
        fprintf(out, "%s %d %a %a\n", scene->surface[i].name, (int)scene->surface[i].type,
                scene->surface[i].reflect_specular[1], scene->surface[i].metal_k[0]);
    for (size_t i = 0; i < scene->n_geometry; i++) {
        const struct rmap_mesh *mesh = scene->geometry[i].mesh;
        fprintf(out, "%s %a\n", scene->geometry[i].name, scene->geometry[i].shape.curvature);
        for (size_t k = 0; mesh && k < mesh->n_triangle; k++) {
            struct rmap_vec3 c[3];
            rmap_mesh_corners(mesh, k, c);
            fprintf(out, "%a %a %a %s\n", c[0].x, c[1].y, c[2].z, mesh->face_name[mesh->face[k]]);
            assert_non_null(mesh->tangent);
            for (int axis = 0; axis < 3; axis++)
                fprintf(out, "%a\n", (double)mesh->tangent[k][axis]);
            assert_non_null(mesh->uv);
            for (int j = 0; j < 6; j++)
                fprintf(out, "%a\n", (double)mesh->uv[k][j]);
        }
    }
    for (size_t i = 0; i < scene->n_object; i++)
        fprintf(out, "%s %llx %d %d %d %a\n", scene->object[i].name,
                (unsigned long long)scene->object[i].id, scene->object[i].geometry,
                scene->object[i].medium_front, scene->object[i].line,
                scene->object[i].to_local.t.z);
    for (size_t i = 0; i < scene->n_source; i++)
        fprintf(out, "%s %a %a\n", scene->source[i].name, scene->source[i].flux,
                scene->source[i].colour[1]);
    for (size_t i = 0; i < scene->n_detector; i++)
        fprintf(out, "%s %a %d\n", scene->detector[i].name, scene->detector[i].size[0],
                scene->detector[i].on_object);
    (void)fclose(out);
    return text;
}

static void test_a_packed_scene_is_the_same(void **state)
{
    struct rmap_bundle *bundle = whole_bundle(*state), *copy = NULL;
    char *told = NULL;
    uint8_t *blob = NULL, *again = NULL;
    size_t nbytes = 0, nbytes_again = 0;
    struct rmap_scene *scene = read_bundle(bundle, &told);
    assert_string_equal(told, "");
    assert_non_null(scene);
    assert_true(bundle->meshes_complete);
    assert_int_equal(bundle->n_mesh, 1);
    assert_int_equal(scene->n_source, 2);
    free(told);
    assert_int_equal(rmap_bundle_pack(bundle, &blob, &nbytes, NULL), RMAP_OK);
    rmap_bundle_destroy(bundle);

    assert_int_equal(rmap_bundle_unpack(blob, nbytes, &copy, NULL), RMAP_OK);
    rmap_free(copy->path); /* no file is looked at any more */
    copy->path = rmap_strdup("/nowhere/scene.yaml");
    struct rmap_scene *second = read_bundle(copy, &told);
    assert_string_equal(told, "");
    assert_non_null(second);
    char *a = portrait(scene), *b = portrait(second);
    assert_string_equal(a, b);
    assert_non_null(strstr(a, "slope"));
    free(a);
    free(b);
    free(told);
    rmap_free(copy->path);
    char path[64];
    (void)snprintf(path, sizeof path, "%s/scene.yaml", (char *)*state);
    copy->path = rmap_strdup(path);
    assert_int_equal(rmap_bundle_pack(copy, &again, &nbytes_again, NULL), RMAP_OK);
    assert_int_equal(nbytes, nbytes_again);
    assert_memory_equal(blob, again, nbytes);
    rmap_free(blob);
    rmap_free(again);
    rmap_scene_destroy(scene);
    rmap_scene_destroy(second);
    rmap_bundle_destroy(copy);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_damaged_bytes_are_refused(void **state)
{
    struct rmap_bundle *bundle = whole_bundle(*state), *copy = NULL;
    char *told = NULL;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    struct rmap_error err = {0};
    rmap_scene_destroy(read_bundle(bundle, &told));
    free(told);
    assert_int_equal(rmap_bundle_pack(bundle, &blob, &nbytes, NULL), RMAP_OK);
    rmap_bundle_destroy(bundle);
    for (size_t cut = 0; cut < nbytes; cut++) { /* every shorter one */
        uint8_t *part = rmap_alloc(cut, 1);
        memcpy(part, blob, cut);
        assert_int_equal(rmap_bundle_unpack(part, cut, &copy, &err), RMAP_FORMAT);
        rmap_free(part);
    }
    for (size_t i = 0; i < nbytes; i++) { /* every byte made huge: refused, or still a bundle */
        uint8_t kept = blob[i];
        blob[i] ^= 0x80;
        enum rmap_status st = rmap_bundle_unpack(blob, nbytes, &copy, &err);
        assert_true(st == RMAP_OK || st == RMAP_FORMAT);
        if (st == RMAP_OK)
            rmap_bundle_destroy(copy);
        blob[i] = kept;
    }
    uint8_t *longer = rmap_alloc(nbytes + 1, 1);
    memcpy(longer, blob, nbytes);
    assert_int_equal(rmap_bundle_unpack(longer, nbytes + 1, &copy, &err), RMAP_FORMAT);
    rmap_free(longer);
    rmap_free(blob);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Fails the n-th allocation of reading and packing, for every n: until ten in a row went well, so
 * that the few whose lack does no harm do not end the loop. */
static void starve(const char *folder, const char *text, enum rmap_status when_fed)
{
    int64_t n = 1;
    for (int fed = 0; fed < 10; n++) {
        struct rmap_bundle *bundle = bundle_of(folder, text);
        struct rmap_scene *scene = NULL;
        struct rmap_diagnostics d;
        struct rmap_error err = {0};
        uint8_t *blob = NULL;
        size_t nbytes = 0;
        bundle->options.simulation = rmap_strdup("q");
        add_word(&bundle->options.set, &bundle->options.n_set, "limits.steps=9");
        rmap_diagnostics_init(&d, "s");
        rmap_alloc_fail_at(n);
        enum rmap_status st = rmap_scene_read(bundle, &scene, &d, &err);
        if (st == RMAP_OK)
            st = rmap_bundle_pack(bundle, &blob, &nbytes, &err);
        rmap_alloc_fail_at(0);
        fed = st == when_fed ? fed + 1 : 0;
        assert_true(st == when_fed || st == RMAP_SYSTEM);
        rmap_free(blob);
        rmap_scene_destroy(scene);
        rmap_bundle_destroy(bundle);
        rmap_diagnostics_fini(&d);
        assert_int_equal(rmap_alloc_live(), 0);
        assert_true(n < 100000);
    }
    print_message("%lld allocations, each failed once\n", (long long)n - 11);
}

static void test_short_memory_neither_leaks_nor_crashes(void **state)
{
    starve(*state, scene_text, RMAP_OK);
    starve(
        *state,
        "raymap: 1\nspectrum: {wavelengths: [500, 600]}\n"
        "media:\n"
        "  air: {index: 1, absorption: {wavelength: [400, 700], value: [0, 1]}}\n"
        "  a: {gradient: {type: sum, frame: world, terms: [{type: noise, mean: 1.3, amplitude: "
        "0.01, length: 3},\n"
        "      {type: polynomial, terms: [{power: [1, 0, 0], value: 0.001}, {power: [0, 0, 0], "
        "value: 1}], at: [0, 0, 1]}]}}\n"
        "  b: {gradient: {type: index_of, law: table, table: {value: [0, 9], n: [1, 1.1]}, field: "
        "{type: constant, index: 3},\n"
        "      dispersion: {glass: N-BK7}}}\n"
        "  c: {gradient: {type: formula, formula: 1.3 + a * x, constants: {a: 1e-6}, frame: g}}\n"
        "  d: {gradient: {type: zemax, gradient: 5, parameters: {n0: 1.5}}}\n"
        "  e: {gradient: {type: profile, along: r, coordinate: [0, 5, 99], n: [1.5, 1.4, 1.3]}}\n"
        "surfaces: {m: {type: mixture, reflect_diffuse: {rgb: [0, 0, 1]}}, s: {type: mirror, "
        "metal: {table: {wavelength: [400, 700], n: [1, 1], k: [2, 2]}}}}\n"
        "geometries:\n"
        "  ball: {type: sphere, radius: 2}\n"
        "  l: {type: lens, surfaces: [{radius: 50, thickness: 1, medium: N-BK7, aperture: 3},\n"
        "      {thickness: 1, medium: air, aperture: 2}, {aperture: 2, thickness: 1, medium: air, "
        "stop: true}, {radius: 9, medium: air, aperture: 2}]}\n"
        "objects:\n"
        "  - {name: g, at: [0, 0, 50], objects: [{name: 1, geometry: ball, surface: fresnel, "
        "outside: air, inside: a},\n"
        "     {name: 2, geometry: ball, at: [9, 0, 0], surface: {front: m, back: s}, outside: air, "
        "inside: b}]}\n"
        "  - {name: 3, geometry: ball, at: [0, 9, 0], surface: fresnel, outside: air, inside: c}\n"
        "  - {name: 4, geometry: ball, at: [0, -9, 0], surface: fresnel, outside: air, inside: d}\n"
        "  - {name: 5, geometry: ball, at: [0, -19, 0], surface: fresnel, outside: air, inside: "
        "e}\n"
        "  - {name: n, geometry: l, at: [0, 0, -19], outside: air}\n"
        "sources:\n"
        "  - {name: r, type: rays, rays: [{origin: [0, 0, 99], direction: [0, 0, 1], wavelength: "
        "500}]}\n"
        "  - {name: p, type: point, spectrum: {lines: {500: 1}}, flux: 1 lm}\n"
        "detectors: [{name: x, type: plane, on: g, cells: 3, size: 3}, {name: y, type: intensity, "
        "cells: 3}]\n"
        "cameras: [{name: k, at: [0, 0, 99], direction: [0, 1, 0]}]\n"
        "background: {radiance: 1}\n"
        "simulations: [{name: q, without: [2, p]}]\n",
        RMAP_OK);
    starve(
        *state,
        "raymap: 1\nmedai: {}\nmedia: {a: &x {index: 0}, b: *x, b: {glass: N-BK}}\n"
        "geometries: {m: {type: mesh, file: none.stl}, c: {type: conic, radius: 1, aperture: 2}}\n"
        "objects: [{name: c, geometry: cc, surface: no}, {name: c, geometry: m, surface: no}]\n"
        "detectors: [{name: c, type: plane, on: nothing, cells: 0}]\n",
        RMAP_INPUT);
}

static void test_short_memory_in_unpack(void **state)
{
    struct rmap_bundle *bundle = whole_bundle(*state), *copy = NULL;
    char *told = NULL;
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    rmap_scene_destroy(read_bundle(bundle, &told));
    free(told);
    assert_int_equal(rmap_bundle_pack(bundle, &blob, &nbytes, NULL), RMAP_OK);
    rmap_bundle_destroy(bundle);
    enum rmap_status st = RMAP_SYSTEM;
    for (int64_t n = 1; st != RMAP_OK; n++) {
        rmap_alloc_fail_at(n);
        st = rmap_bundle_unpack(blob, nbytes, &copy, NULL);
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        assert_int_equal(st == RMAP_OK ? 0 : 1, rmap_alloc_live() == 1);
    }
    rmap_bundle_destroy(copy);
    rmap_free(blob);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void assert_not_opened(const char *path, enum rmap_status expected, const char *told)
{
    struct rmap_bundle *bundle = NULL;
    struct rmap_error err = {0};
    struct rmap_scene_options options = {.color = rmap_strdup("rgb")};
    assert_int_equal(rmap_bundle_open(path, &options, &bundle, &err), expected);
    if (!strstr(err.text, told))
        fail_msg("'%s' does not say '%s'", err.text, told);
    assert_null(options.color); /* taken over all the same */
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_what_cannot_be_opened(void **state)
{
    char path[64];
    (void)snprintf(path, sizeof path, "%s/x", (char *)*state);
    assert_not_opened(path, RMAP_INPUT, "No such file");
    assert_not_opened(*state, RMAP_INPUT, "is a directory");
    write_file(path, "", 0);
    assert_not_opened(path, RMAP_INPUT, "is empty");
    write_file(path, "raymap: 1\0\n", 11);
    assert_not_opened(path, RMAP_INPUT, "is binary");
    assert_int_equal(truncate(path, ((off_t)64 << 20) + 1), 0);
    assert_not_opened(path, RMAP_INPUT, "64 MiB at most");
    assert_int_equal(unlink(path), 0);
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_not_opened(path, RMAP_INPUT, "is empty"); /* nobody writes */
    assert_int_equal(unlink(path), 0);
    write_file(path, "raymap: 1\n", 10);
    if (geteuid() != 0) {
        assert_int_equal(chmod(path, 0), 0);
        assert_not_opened(path, RMAP_SYSTEM, "Permission denied");
    }
    assert_int_equal(unlink(path), 0);
}

static void test_open(void **state)
{
    char path[64];
    struct rmap_bundle *bundle = NULL;
    (void)snprintf(path, sizeof path, "%s/y", (char *)*state);
    write_file(path, "raymap: 1\n", 10);
    assert_int_equal(rmap_bundle_open(path, NULL, &bundle, NULL), RMAP_OK);
    assert_string_equal(bundle->text, "raymap: 1\n");
    assert_int_equal(bundle->text_nbytes, 10);
    assert_string_equal(bundle->path, path);
    rmap_bundle_destroy(bundle);
    assert_int_equal(unlink(path), 0);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_a_packed_scene_is_the_same),
        cmocka_unit_test(test_damaged_bytes_are_refused),
        cmocka_unit_test(test_short_memory_neither_leaks_nor_crashes),
        cmocka_unit_test(test_short_memory_in_unpack),
        cmocka_unit_test(test_what_cannot_be_opened),
        cmocka_unit_test(test_open),
    };
    return cmocka_run_group_tests(tests, set_up, tear_down);
}

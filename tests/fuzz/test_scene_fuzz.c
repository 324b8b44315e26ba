/* SPDX-License-Identifier: MIT
 *
 * Damaged input, always the same: scene texts, edits and PLY files with bytes, words and lines
 * changed. Whatever comes in, the answer is a scene or a list of mistakes, and no block of
 * memory stays behind.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/rng.h"
#include "io/mesh/mesh_read.h"
#include "tests/unit/read_text.h"

enum { LONGEST = 1 << 16 };

static const char *const seed_text =
    "raymap: 1\n"
    "units: mm\n"
    "spectrum: {mode: spectral, wavelengths: [486, 588, 656]}\n"
    "limits: {steps: 100, flux: 0.001}\n"
    "media:\n"
    "  air: {index: 1}\n"
    "  bk7: {glass: N-BK7, absorption: 0.01}\n"
    "  own: {sellmeier: {B: [1.03, 0.23], C: [0.006, 0.02]}, wavelength_unit: um}\n"
    "  ink: {table: {wavelength: [400, 700], n: [1.3, 1.4], k: [0, 1.0e-6]}}\n"
    "  fog: {gradient: {type: sum, frame: group, terms: [{type: luneburg, radius: 9, weight: 0.5}, "
    "{type: noise, mean: 1.3, amplitude: 0.1, length: 2, octaves: 3}], dispersion: {glass: "
    "N-BK7}}, scattering: 0.1, scattering_g: 0.5}\n"
    "  hot: {gradient: {type: index_of, law: air, field: {type: formula, formula: 20 + a * z, "
    "constants: {a: 2}}, scheme: sharma, step_max: 0.1, tolerance: 1.0e-6}}\n"
    "  rod: {gradient: {type: radial, coefficients: [2.25, -0.01], of: n^2, at: [0, 0, 1]}}\n"
    "films:\n"
    "  ar: {reference: 550, layers: [{material: MgF2, quarter: 1}, {n: 2, k: 0.1, thickness: 30 "
    "nm}]}\n"
    "  cut: {substrate: back, layers: [{table: {wavelength: [400, 700], n: [2, 2.1], k: [0, "
    "0.1]}, thickness: 1 um}]}\n"
    "surfaces:\n"
    "  blue: {type: fresnel, coat: {film: ar}}\n"
    "  clear: {type: fresnel, coat: {reflectance: {wavelength: [400, 700], value: [0, 0.1]}}}\n"
    "  silver: {type: mirror, metal: {n: 0.2, k: 3}}\n"
    "  white: {type: lambert, reflectance: {rgb: [0.9, 0.8, 0.7]}}\n"
    "  milk: {type: mixture, reflect_diffuse: 0.5, transmit_diffuse: 0.5}\n"
    "geometries:\n"
    "  cap: {type: conic, radius: 50, conic: -1, asphere: {4: 1.0e-6}, aperture: 9, inner: 1}\n"
    "  pipe: {type: cone, radius: 3, radius2: 2, length: 7}\n"
    "  plate: {type: rectangle, size: [20, 10]}\n"
    "  ball: {type: sphere, radius: 4}\n"
    "  form: {type: conic, radius: [50, 40], conic: [0, -1], aperture: {ellipse: [9, 7], at: [0, "
    "1]}, inner: 1, xy: {norm: 9, terms: {x2y0: 0.1}}}\n"
    "  wave: {type: conic, radius: 50, aperture: {rectangle: [8, 6]}, zernike: {norm: 9, order: "
    "noll, terms: {4: 0.1 um}}, qcon: {norm: 9, terms: [0.1]}}\n"
    "  echelon: {type: conic, radius: 50, aperture: 9, fresnel: true, asphere: {3: 1.0e-5}, qbfs: "
    "{norm: 9, terms: [0.1]}}\n"
    "  block: {type: box, size: [4, 4, 2]}\n"
    "  rod2: {type: lens, surfaces: [{radius: 50, toroid: inf, thickness: 5, medium: bk7, "
    "aperture: 9}, {medium: air, aperture: 9}]}\n"
    "  doublet:\n"
    "    type: lens\n"
    "    surface: clear\n"
    "    surfaces: [{radius: 50, thickness: 5, medium: bk7, aperture: 9}, {thickness: 1, medium: "
    "air, aperture: 8}, {medium: air, aperture: 5, stop: true}]\n"
    "objects:\n"
    "  - &l {name: lens, geometry: doublet, outside: air}\n"
    "  - name: group\n"
    "    rotate: [0, 90, 0]\n"
    "    objects:\n"
    "      - {name: a, geometry: cap, surface: blue, front: air, back: own, id: 7c1f0a52}\n"
    "      - {name: b, geometry: plate, surface: {front: white, back: milk}, inside: air, outside: "
    "air, matrix: [1,0,0,0, 0,1,0,0, 0,0,1,5]}\n"
    "  - {name: drop, geometry: ball, surface: clear, outside: air, inside: fog}\n"
    "  - {name: bead, geometry: ball, surface: clear, outside: air, inside: hot, at: [9, 0, 0]}\n"
    "  - {name: pill, geometry: ball, surface: clear, outside: air, inside: rod, at: [0, 9, 0]}\n"
    "  - {name: e, geometry: form, surface: fresnel, front: air, back: air, at: [0, 30, 0]}\n"
    "  - {name: w, geometry: wave, surface: silver, front: air, back: air, at: [0, 60, 0]}\n"
    "  - {name: h, geometry: echelon, surface: fresnel, front: air, back: bk7, at: [0, 90, 0]}\n"
    "  - {name: y, geometry: rod2, outside: air, at: [0, 120, 0]}\n"
    "  - {name: brick, geometry: block, surface: clear, inside: bk7, outside: air, material: PMMA, "
    "faces: [{faces: [0, 3..5], surface: white}, {faces: top, outside: own}], at: [0, 150, 0]}\n"
    "attributes:\n"
    "  - {match: {name: 'b*', material: [PMMA, acrylic]}, set: {surface: clear, outside: air}}\n"
    "sources:\n"
    "  - {name: s, type: collimated, shape: {disc: 3}, flux: 1 W, spectrum: {lines: {486: 1}}}\n"
    "  - {name: t, type: point, distribution: {cone: 20}, flux: 5 lm, spectrum: D65, at: [9, 0, "
    "0], medium: hot, within: bead}\n"
    "  - {name: r, type: rays, rays: [{origin: [0, 0, -9], direction: [0, 0, 1], wavelength: "
    "588}]}\n"
    "detectors:\n"
    "  - {name: d, type: plane, on: b, cells: [20, 10], side: both}\n"
    "  - {name: f, type: intensity, cells: [18, 36], axis: [0, 1, 0]}\n"
    "simulations:\n"
    "  - {name: q, rays: 7, time_limit: 5 min, without: [r], detectors: [d]}\n";

static const char *const words[] = {"-1",        "0",
                                    "1e308",     ".nan",
                                    "inf",       "99999999999999999999",
                                    "[]",        "{}",
                                    "*l",        "~",
                                    "\"",        "'",
                                    "&l ",       "- {name: s}\n",
                                    "D65",       "!!binary ",
                                    "[[[[[[[[",  "]",
                                    "}",         "\n",
                                    "\t",        "{a: ",
                                    "air",       "lens.1",
                                    ": ",        "- ",
                                    "lens",      "mesh",
                                    "world",     "formula",
                                    "x ? 1 : ",  "((((((((((",
                                    "%",         "\xff",
                                    "#",         "\xc3\xa9",
                                    "zernike",   "xy",
                                    "qcon",      "qbfs",
                                    "toroid",    "fresnel",
                                    "rectangle", "ellipse",
                                    "at",        "norm",
                                    "order",     "terms",
                                    "faces",     "match"};

struct dice {
    uint64_t ray;
    uint32_t step;
};

static size_t roll(struct dice *dice, size_t n)
{
    double uniform[4];
    rmap_rng(20240229, dice->ray, dice->step++, RMAP_RNG_SURFACE, uniform);
    return (size_t)(uniform[0] * (double)n);
}

static const char *any_word(struct dice *dice)
{
    return words[roll(dice, sizeof words / sizeof words[0])];
}

/* Puts `n_in` bytes in place of `n_out` at `at`, as far as there is room. */
static size_t splice(char *text, size_t len, size_t at, size_t n_out, const char *in, size_t n_in)
{
    char kept[64];
    if (n_in > sizeof kept || len - n_out + n_in >= LONGEST)
        return len;
    memcpy(kept, in, n_in); /* it may point into the text */
    memmove(text + at + n_in, text + at + n_out, len - at - n_out);
    memcpy(text + at, kept, n_in);
    return len - n_out + n_in;
}

static size_t mutate(struct dice *dice, char *text, size_t len)
{
    size_t at = roll(dice, len), n = 1 + roll(dice, 20);
    const char *word = any_word(dice);
    if (n > len - at)
        n = len - at;
    switch (roll(dice, 6)) {
    case 0:
        text[at] = (char)(1 + roll(dice, 255));
        return len;
    case 1: /* a number or word becomes another */
        while (at > 0 && !strchr(" :[,{", text[at - 1]))
            at--;
        for (n = 0; at + n < len && !strchr(" :],}\n", text[at + n]);)
            n++;
        return splice(text, len, at, n, word, strlen(word));
    case 2:
        return splice(text, len, at, 0, word, strlen(word));
    case 3:
        return splice(text, len, at, n, "", 0);
    case 4: /* a piece of the text again, elsewhere */
        return splice(text, len, roll(dice, len), 0, text + at, n);
    default:
        return roll(dice, 4) == 0 ? at + 1 : len;
    }
}

static void test_damaged_scenes(void **state)
{
    (void)state;
    enum { N = 6000 };
    int n_good = 0;
    for (uint64_t i = 0; i < N; i++) {
        static char text[LONGEST];
        struct dice dice = {i, 0};
        size_t len = strlen(seed_text), n_change = 1 + roll(&dice, 4);
        char *told = NULL;
        memcpy(text, seed_text, len);
        for (size_t k = 0; k < n_change && len; k++)
            len = mutate(&dice, text, len);
        text[len] = 0;
        /* read_bundle aborts where status and mistakes disagree. */
        struct rmap_scene *scene = read_text(text, &told);
        n_good += scene != NULL;
        rmap_scene_destroy(scene);
        free(told);
        if (rmap_alloc_live() != 0)
            fail_msg("case %d leaves %lld blocks", (int)i, (long long)rmap_alloc_live());
    }
    print_message("%d of %d are scenes all the same\n", n_good, N);
    assert_true(n_good > N / 50 && n_good < N / 2);
}

static void test_damaged_edits(void **state)
{
    (void)state;
    static const char *const path[] = {"objects.lens.at",
                                       "sources.s.flux",
                                       "media.air",
                                       "geometries.doublet.surfaces.1",
                                       "spectrum.wavelengths",
                                       "simulations.1",
                                       "limits",
                                       "objects",
                                       "new.key"};
    for (uint64_t i = 0; i < 600; i++) {
        struct dice dice = {1000000 + i, 0};
        char assignment[200], *told = NULL;
        struct rmap_bundle *bundle = bundle_of(".", seed_text);
        const char *where = path[roll(&dice, sizeof path / sizeof path[0])];
        const char *first = any_word(&dice), *second = any_word(&dice);
        (void)snprintf(assignment, sizeof assignment, "%s=%s%s", where, first, second);
        add_word(&bundle->options.set, &bundle->options.n_set, assignment);
        rmap_scene_destroy(read_bundle(bundle, &told));
        rmap_bundle_destroy(bundle);
        free(told);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

static const char ply_text[] = "ply\nformat ascii 1.0\ncomment made here\nelement vertex 4\n"
                               "property float x\nproperty float y\nproperty float z\n"
                               "element face 3\nproperty list uchar int vertex_indices\n"
                               "property uchar red\nend_header\n"
                               "0 0 0\n1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2 7\n4 0 1 2 3 8\n3 2 1 0 9\n";

static const char surface_text[] =
    "ply\nformat ascii 1.0\ncomment face 0 a plane\nelement vertex 4\n"
    "property float x\nproperty float y\nproperty float z\n"
    "element face 2\nproperty list uchar int vertex_indices\nproperty int face\n"
    "element surface 2\nproperty int kind\nproperty double ox\nproperty double ax\n"
    "property double ay\nproperty double az\nproperty double r1\nproperty double r2\nend_header\n"
    "0 0 0\n1 0 0\n1 1 0\n0 1 0\n3 0 1 2 1\n3 0 2 3 0\n1 0 0 0 1 0 0\n5 0 0 0 1 2 0.1\n";

/* Two triangles in little-endian bytes, their coordinates in three types. */
static size_t binary_ply(char *to)
{
    static const char head[] =
        "ply\nformat binary_little_endian 1.0\nelement vertex 4\n"
        "property double x\nproperty float y\nproperty short z\n"
        "element face 2\nproperty list uchar uint vertex_index\nend_header\n";
    static const double x[4] = {0, 1, 1, 0};
    static const float y[4] = {0, 0, 1, 1};
    size_t n = sizeof head - 1;
    memcpy(to, head, n);
    for (int i = 0; i < 4; i++) {
        const int16_t z = (int16_t)-i;
        memcpy(to + n, &x[i], 8);
        memcpy(to + n + 8, &y[i], 4);
        memcpy(to + n + 12, &z, 2);
        n += 14;
    }
    for (uint32_t i = 0; i < 2; i++) {
        const uint32_t corner[3] = {0, 1 + i, 2 + i};
        to[n++] = 3;
        memcpy(to + n, corner, sizeof corner);
        n += sizeof corner;
    }
    return n;
}

static enum rmap_status read_mesh(const char *name, const char *bytes, size_t n, size_t *n_triangle)
{
    struct rmap_mesh *mesh = NULL;
    struct rmap_mesh_left_out left_out;
    FILE *out = fopen(name, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(bytes, 1, n, out), n);
    assert_int_equal(fclose(out), 0);
    enum rmap_status st =
        rmap_mesh_read(name, &(struct rmap_mesh_reading){.scale = 1, .keep = RMAP_MESH_TANGENTS},
                       &mesh, &left_out, NULL);
    *n_triangle = st == RMAP_OK ? mesh->n_triangle : 0;
    if (st == RMAP_OK)
        rmap_mesh_destroy(mesh);
    assert_int_equal(rmap_alloc_live(), 0);
    return st;
}

static void test_damaged_ply(void **state)
{
    (void)state;
    char name[64], whole[3][1024];
    size_t len[3] = {sizeof ply_text - 1, binary_ply(whole[1]), sizeof surface_text - 1};
    size_t n_triangle = 0;
    memcpy(whole[0], ply_text, len[0]);
    memcpy(whole[2], surface_text, len[2]);
    (void)snprintf(name, sizeof name, "fuzz-%ld.ply", (long)getpid());
    assert_int_equal(read_mesh(name, whole[0], len[0], &n_triangle), RMAP_OK);
    assert_int_equal(n_triangle, 4);
    assert_int_equal(read_mesh(name, whole[1], len[1], &n_triangle), RMAP_OK);
    assert_int_equal(n_triangle, 2);
    assert_int_equal(read_mesh(name, whole[2], len[2], &n_triangle), RMAP_OK);
    assert_int_equal(n_triangle, 2);
    for (size_t cut = 1; cut < len[1]; cut++)
        assert_int_equal(read_mesh(name, whole[1], cut, &n_triangle), RMAP_INPUT);
    for (uint64_t i = 0; i < 6000; i++) {
        static char text[LONGEST];
        struct dice dice = {2000000 + i, 0};
        size_t n = len[i % 3], n_change = 1 + roll(&dice, 3);
        memcpy(text, whole[i % 3], n);
        for (size_t k = 0; k < n_change && n; k++)
            n = mutate(&dice, text, n);
        enum rmap_status st = read_mesh(name, text, n, &n_triangle);
        assert_true(st == RMAP_OK || st == RMAP_INPUT);
    }
    assert_int_equal(unlink(name), 0);
}

static const char gltf_text[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
    "\"nodes\":[{\"mesh\":0,\"scale\":[1,2,-1],\"children\":[1]},{\"mesh\":1}],\"meshes\":[{"
    "\"name\":"
    "\"a\",\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"mode\":5}]},"
    "{\"primitives\":[{\"attributes\":{\"POSITION\":2}}]}],\"accessors\":[{\"bufferView\":0,"
    "\"componentType\":5126,\"count\":4,\"type\":\"VEC3\"},{\"bufferView\":1,\"byteOffset\":1,"
    "\"componentType\":5121,\"count\":4,\"type\":\"SCALAR\"},{\"bufferView\":0,\"componentType\":"
    "5126,"
    "\"count\":3,\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":1,"
    "\"byteOffset\":2,\"componentType\":5121},\"values\":{\"bufferView\":0,\"byteOffset\":36}}}],"
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":48},{\"buffer\":0,\"byteOffset\":48,"
    "\"byteLength\":5}],\"buffers\":[{\"byteLength\":53,\"uri\":\"data:;base64,"
    /* (0,0,0) (1,0,0) (0,1,0) (0,0,1), then 9 0 1 2 3 */
    "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/CQABAgM=\"}]}";

static void test_damaged_gltf(void **state)
{
    (void)state;
    char name[64];
    const size_t len = sizeof gltf_text - 1;
    size_t n_triangle = 0, n_read = 0;
    (void)snprintf(name, sizeof name, "fuzz-%ld.gltf", (long)getpid());
    assert_int_equal(read_mesh(name, gltf_text, len, &n_triangle), RMAP_OK);
    assert_int_equal(n_triangle, 3);
    for (size_t cut = 1; cut < len; cut++)
        assert_int_equal(read_mesh(name, gltf_text, cut, &n_triangle), RMAP_INPUT);
    for (uint64_t i = 0; i < 3000; i++) {
        static char text[LONGEST];
        struct dice dice = {3000000 + i, 0};
        size_t n = len, n_change = 1 + roll(&dice, 3);
        memcpy(text, gltf_text, n);
        for (size_t k = 0; k < n_change && n; k++)
            n = mutate(&dice, text, n);
        enum rmap_status st = read_mesh(name, text, n, &n_triangle);
        assert_true(st == RMAP_OK || st == RMAP_INPUT);
        n_read += st == RMAP_OK;
    }
    assert_true(n_read > 200); /* the checks behind the text were reached */
    assert_int_equal(unlink(name), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_damaged_scenes),
        cmocka_unit_test(test_damaged_edits),
        cmocka_unit_test(test_damaged_ply),
        cmocka_unit_test(test_damaged_gltf),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

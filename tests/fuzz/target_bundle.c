/* SPDX-License-Identifier: MIT
 *
 * The scene inside a foreign map: unpacking and reading it end in a scene or a message, and no
 * file is opened that the map names. What is unpacked packs to a bundle that is the same again.
 */
#include <string.h>

#include "base/alloc.h"
#include "io/mesh/bundle.h"
#include "io/mesh/bundle_pack.h"
#include "target.h"

const unsigned rmap_fuzz_rounds = 60000;

static const char scene_text[] =
    "raymap: 1\n"
    "units: mm\n"
    "spectrum: {mode: spectral, wavelengths: [486, 588, 656]}\n"
    "media:\n"
    "  air: {index: 1}\n"
    "  bk7: {glass: N-BK7, absorption: 0.01}\n"
    "surfaces:\n"
    "  clear: {type: fresnel}\n"
    "  white: {type: lambert, reflectance: 0.8}\n"
    "geometries:\n"
    "  ball: {type: sphere, radius: 5}\n"
    "  body: {type: mesh, file: body.ply}\n"
    "  form: {type: conic, radius: [50, 40], aperture: {ellipse: [9, 7], at: [0, 1]}, xy: {norm: "
    "9, terms: {x2y0: 0.1}}, zernike: {norm: 9, order: noll, terms: {4: 0.1}}, qcon: {norm: 9, "
    "terms: [0.1]}}\n"
    "  step: {type: conic, radius: 50, aperture: {rectangle: [8, 6]}, fresnel: true, qbfs: {norm: "
    "9, terms: [0.1]}}\n"
    "  rod: {type: lens, surfaces: [{radius: 50, toroid: inf, thickness: 5, medium: bk7, aperture: "
    "{rectangle: [9, 9]}}, {medium: air, aperture: {rectangle: [9, 9]}}]}\n"
    "objects:\n"
    "  - {name: lens, geometry: ball, surface: clear, inside: bk7, outside: air}\n"
    "  - {name: box, geometry: body, surface: white, front: air, back: air, faces: [{faces: [0], "
    "surface: clear}], material: PMMA}\n"
    "  - {name: e, geometry: form, surface: clear, front: air, back: air, at: [0, 30, 0]}\n"
    "  - {name: h, geometry: step, surface: clear, front: air, back: bk7, at: [0, 60, 0]}\n"
    "  - {name: y, geometry: rod, outside: air, at: [0, 90, 0]}\n"
    "attributes:\n"
    "  - {match: {name: 'b*', material: [PMMA, acrylic]}, set: {surface: white}}\n"
    "sources:\n"
    "  - {name: s, type: collimated, shape: {disc: 3}, at: [0, 0, -9], flux: 1 W, medium: air}\n"
    "detectors:\n"
    "  - {name: d, type: plane, size: [8, 6], cells: [16, 9], at: [0, 0, 50]}\n";

/* With gradient media: their grid lies in the bundle, their plug-in is not loaded. */
static const char field_text[] =
    "raymap: 1\n"
    "units: mm\n"
    "media:\n"
    "  air: {index: 1}\n"
    "  fog: {gradient: {type: grid, file: fog.h5, interpolation: trilinear, outside: 1}}\n"
    "  odd: {gradient: {type: plugin, file: odd.so, parameters: [1, 2]}}\n"
    "  hot: {gradient: {type: formula, formula: 1.5 - 0.01 * r^2, frame: world}}\n"
    "geometries: {ball: {type: sphere, radius: 5}, body: {type: mesh, file: body.ply}}\n"
    "objects:\n"
    "  - {name: a, geometry: ball, surface: fresnel, inside: fog, outside: air}\n"
    "  - {name: b, geometry: ball, surface: fresnel, inside: odd, outside: hot, at: [20, 0, 0]}\n"
    "sources:\n"
    "  - {name: s, type: collimated, shape: {disc: 3}, at: [0, 0, -9], flux: 1 W, medium: air}\n";

static void add_fields(struct rmap_bundle *bundle)
{
    struct rmap_error err = {0};
    struct rmap_grid *grid = NULL;
    const size_t n[3] = {2, 3, 2};
    rmap_fuzz_demand(
        rmap_grid_create(n, rmap_vec3(-5, -5, -5), rmap_vec3(10, 5, 10), &grid, &err) == RMAP_OK,
        "a grid");
    for (size_t i = 0; i < rmap_grid_count(grid); i++)
        grid->value[i] = 1.3 + 0.01 * (double)i;
    rmap_fuzz_demand(rmap_bundle_add_grid(bundle, "fog", grid, &err) == RMAP_OK &&
                         rmap_bundle_add_plugin(bundle, "odd", 0x1234, &err) == RMAP_OK,
                     "fields");
}

static struct rmap_mesh *make_mesh(void)
{
    struct rmap_mesh *mesh = NULL;
    struct rmap_error err = {0};
    rmap_fuzz_demand(rmap_mesh_create(4, 2, 2, &mesh, &err) == RMAP_OK, "a mesh");
    for (int i = 0; i < 4; i++) {
        mesh->vertex[i][0] = (float)(i % 2);
        mesh->vertex[i][1] = (float)(i / 2);
        mesh->vertex[i][2] = 20.0f;
    }
    const uint32_t corner[2][3] = {{0, 1, 2}, {2, 1, 3}};
    memcpy(mesh->triangle, corner, sizeof corner);
    mesh->face[1] = 1;
    mesh->face_name[0] = rmap_strdup("front");
    mesh->face_name[1] = rmap_strdup("rear");
    mesh->surface = rmap_alloc(2, sizeof *mesh->surface);
    rmap_fuzz_demand(mesh->surface != NULL, "memory");
    mesh->surface[0] =
        (struct rmap_true_surface){.kind = RMAP_TRUE_PLANE, .at = {0, 0, 20}, .axis = {0, 0, 1}};
    rmap_fuzz_demand(!rmap_true_surface_finish(mesh->surface), "a plane");
    return mesh;
}

static void add_word(char ***list, size_t *n, const char *word)
{
    *list = rmap_realloc(*list, *n + 1, sizeof **list);
    rmap_fuzz_demand(*list != NULL, "memory");
    (*list)[(*n)++] = rmap_strdup(word);
}

static void read_scene(struct rmap_bundle *bundle)
{
    struct rmap_scene *scene = NULL;
    struct rmap_diagnostics diagnostics;
    struct rmap_error err = {0};
    rmap_fuzz_demand(bundle->meshes_complete, "a packed scene is complete: it names no files");
    rmap_diagnostics_init(&diagnostics, "fuzz");
    enum rmap_status st = rmap_scene_read(bundle, &scene, &diagnostics, &err);
    rmap_fuzz_demand(st != RMAP_OK || scene != NULL, "a scene or a message");
    rmap_scene_destroy(scene);
    rmap_diagnostics_fini(&diagnostics);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t nbytes)
{
    struct rmap_bundle *bundle = NULL, *twin = NULL;
    struct rmap_error err = {0};
    uint8_t *blob = NULL, *again = NULL;
    size_t n_blob = 0, n_again = 0;
    int64_t live = rmap_alloc_live();
    enum rmap_status st = rmap_bundle_unpack(data, nbytes, &bundle, &err);
    rmap_fuzz_demand(st == RMAP_OK || st == RMAP_FORMAT, "status of a foreign bundle");
    if (st == RMAP_OK) {
        rmap_fuzz_demand(rmap_bundle_pack(bundle, &blob, &n_blob, &err) == RMAP_OK &&
                             rmap_bundle_unpack(blob, n_blob, &twin, &err) == RMAP_OK &&
                             rmap_bundle_pack(twin, &again, &n_again, &err) == RMAP_OK,
                         "packing what was unpacked");
        rmap_fuzz_demand(n_blob == n_again && memcmp(blob, again, n_blob) == 0, "the same bundle");
        read_scene(bundle);
    }
    rmap_bundle_destroy(bundle);
    rmap_bundle_destroy(twin);
    rmap_free(blob);
    rmap_free(again);
    rmap_fuzz_demand(rmap_alloc_live() == live, "memory is given back");
    return 0;
}

size_t rmap_fuzz_seed(unsigned k, uint8_t *to, size_t cap)
{
    struct rmap_error err = {0};
    uint8_t *blob = NULL;
    size_t nbytes = 0;
    if (k >= 3)
        return 0;
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    rmap_fuzz_demand(bundle != NULL, "memory");
    bundle->path = rmap_strdup("a/scene.yaml");
    bundle->text = rmap_strdup(k == 2 ? field_text : scene_text);
    bundle->text_nbytes = strlen(bundle->text);
    bundle->meshes_complete = 1;
    if (k == 1) {
        bundle->options.color = rmap_strdup("rgb");
        add_word(&bundle->options.only, &bundle->options.n_only, "lens");
        add_word(&bundle->options.without, &bundle->options.n_without, "d");
        add_word(&bundle->options.set, &bundle->options.n_set, "geometries.ball.radius=4");
    }
    if (k == 2)
        add_fields(bundle);
    rmap_fuzz_demand(rmap_bundle_add_mesh(bundle, "body", make_mesh(), &err) == RMAP_OK &&
                         rmap_bundle_pack(bundle, &blob, &nbytes, &err) == RMAP_OK && nbytes <= cap,
                     "a seed");
    memcpy(to, blob, nbytes);
    rmap_free(blob);
    rmap_bundle_destroy(bundle);
    return nbytes;
}

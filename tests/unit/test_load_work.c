/* SPDX-License-Identifier: MIT
 *
 * What loading a scene costs, counted rather than timed: this program's own strcmp and
 * rtcCommitScene stand before those of the C library and of Embree.
 */
#define _GNU_SOURCE
#include <dlfcn.h>

#include "build_scene.h"
#include "io/mesh/bundle.h"

static uint64_t n_compared, n_committed;

int strcmp(const char *a, const char *b)
{
    n_compared++;
    while (*a && *a == *b) {
        a++;
        b++;
    }
    return (unsigned char)*a - (unsigned char)*b;
}

void rtcCommitScene(void *scene);

void rtcCommitScene(void *scene)
{
    void (*commit)(void *);
    *(void **)&commit = dlsym(RTLD_NEXT, "rtcCommitScene");
    n_committed++;
    commit(scene);
}

static struct rmap_mesh *triangle(void)
{
    static const float corner[3][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    static const uint32_t index[3] = {0, 1, 2};
    struct rmap_mesh *mesh = NULL;
    struct rmap_error err = {0};
    assert_int_equal(rmap_mesh_create(3, 1, 1, &mesh, &err), RMAP_OK);
    memcpy(mesh->vertex, corner, sizeof corner);
    memcpy(mesh->triangle, index, sizeof index);
    return mesh;
}

/* As a map has it: the text, and a mesh for each of its geometries. */
static struct rmap_bundle *bundle_of(size_t n)
{
    struct rmap_error err = {0};
    struct rmap_bundle *bundle = rmap_alloc(1, sizeof *bundle);
    size_t nbytes = 1000 + 200 * n, used = 0;
    assert_non_null(bundle);
    bundle->text = rmap_alloc(nbytes, 1);
    bundle->path = rmap_strdup("scene.yaml");
    assert_true(bundle->text && bundle->path);
#define PUT(...) used += (size_t)snprintf(bundle->text + used, nbytes - used, __VA_ARGS__)
    PUT("raymap: 1\nunits: mm\nspectrum: {wavelengths: [550]}\nmedia: {air: {index: 1}}\n"
        "surfaces: {black: {type: absorber}}\ngeometries:\n");
    for (size_t i = 0; i < n; i++) {
        char name[32];
        (void)snprintf(name, sizeof name, "tile%zu", i);
        assert_int_equal(rmap_bundle_add_mesh(bundle, name, triangle(), &err), RMAP_OK);
        PUT("  %s: {type: mesh, file: %s.stl}\n", name, name);
    }
    PUT("objects:\n");
    for (size_t i = 0; i < n; i++)
        PUT("  - {name: o%zu, geometry: tile%zu, at: &at%zu [%zu, 0, 0], rotate: *at0, surface: "
            "black, front: air, back: air}\n",
            i, i, i, 2 * i);
    PUT("sources:\n  - {name: lamp, type: point, at: [0, 0, 9], direction: [0, 0, -1], "
        "distribution: {cone: 15}, flux: 1 W, medium: air}\n");
#undef PUT
    bundle->text_nbytes = used;
    bundle->meshes_complete = 1;
    return bundle;
}

static uint64_t compared_for(size_t n)
{
    struct rmap_error err = {0};
    struct rmap_diagnostics diagnostics;
    struct rmap_scene *scene = NULL;
    struct rmap_bundle *bundle = bundle_of(n);
    rmap_diagnostics_init(&diagnostics, "scene");
    n_compared = 0;
    assert_int_equal(rmap_scene_read(bundle, &scene, &diagnostics, &err), RMAP_OK);
    const uint64_t compared = n_compared;
    assert_int_equal(scene->n_object, n);
    rmap_scene_destroy(scene);
    rmap_bundle_destroy(bundle);
    rmap_diagnostics_fini(&diagnostics);
    return compared;
}

static void test_names_are_compared_in_proportion(void **state)
{
    (void)state;
    const uint64_t few = compared_for(1000), many = compared_for(4000);
    print_message("1000 meshes: %llu names compared, 4000: %llu\n", (unsigned long long)few,
                  (unsigned long long)many);
    assert_true(few > 1000);
    assert_true(many < 5 * few);
}

/* One for the mesh, and one for what the prefilter of the shapes does not hold, or for everything.
 */
static void test_each_surface_is_built_once(void **state)
{
    (void)state;
    const struct rmap_affine identity = rmap_affine_identity();
    const struct rmap_shape disc = {.type = RMAP_SHAPE_SPHERE, .radius = 1};
    struct builder b;
    builder_open(&b, 2);
    (void)builder_object(&b, builder_shape(&b, disc), identity, 0, 0);
    (void)builder_object(&b, builder_mesh(&b, triangle()), identity, 0, 0);
    n_committed = 0;
    builder_close(&b);
    assert_int_equal(n_committed, 2);
    builder_destroy(&b);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_names_are_compared_in_proportion),
        cmocka_unit_test(test_each_surface_is_built_once),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

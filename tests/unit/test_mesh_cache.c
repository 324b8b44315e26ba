/* SPDX-License-Identifier: MIT
 *
 * What is kept of a mesh is that mesh, for as long as its file is the same; what is damaged is told
 * and made anew; a folder that cannot be written fails nothing.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "io/file/input_file.h"
#include "io/mesh/mesh_cache.h"
#include "io/mesh/mesh_origin.h"
#include "scene/scene_same.h"

enum { SIDE = 40 }; /* 3200 triangles, 100 KB of text */

static const struct rmap_mesh_reading plain = {.scale = 2, .keep = 3};

/* A hilly square with texture coordinates, of two groups, one triangle without an area. */
static void write_hills(const char *path, double height)
{
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    for (int i = 0; i <= SIDE; i++)
        for (int j = 0; j <= SIDE; j++)
            fprintf(out, "v %d %d %.9g\nvt %.9g %.9g\n", i, j, height * (i * j % 7),
                    (double)i / SIDE, (double)j / SIDE);
    for (int i = 0; i < SIDE; i++) {
        fprintf(out, "g %s\n", i < SIDE / 2 ? "west" : "east");
        for (int j = 0; j < SIDE; j++) {
            const int a = (SIDE + 1) * i + j + 1, b = a + SIDE + 1;
            fprintf(out, "f %d/%d %d/%d %d/%d\n", a, a, b, b, b + 1, b + 1);
            fprintf(out, "f %d/%d %d/%d %d/%d\n", a, a, b + 1, b + 1, a + 1, a + 1);
        }
    }
    fputs("f 1/1 1/1 2/2\n", out);
    assert_int_equal(fclose(out), 0);
}

/* With its note's status; the mesh is that without a cache. */
static enum rmap_status check_read(const char *path, const char *cache)
{
    struct rmap_mesh *mesh = NULL, *reference = NULL;
    struct rmap_mesh_left_out left_out = {0}, reference_left_out = {0};
    struct rmap_error err = {0}, note = {0};
    struct rmap_mesh_reading how = plain;
    assert_int_equal(rmap_mesh_read(path, &how, &reference, &reference_left_out, &err), RMAP_OK);
    how.cache = cache;
    how.note = &note;
    assert_int_equal(rmap_mesh_read(path, &how, &mesh, &left_out, &err), RMAP_OK);
    assert_true(rmap_same_mesh(mesh, reference));
    assert_memory_equal(mesh->tangent, reference->tangent,
                        mesh->n_triangle * sizeof *mesh->tangent);
    assert_memory_equal(mesh->uv, reference->uv, mesh->n_triangle * sizeof *mesh->uv);
    assert_string_equal(mesh->face_name[1], "east");
    assert_int_equal(left_out.degenerate, 1);
    assert_memory_equal(&left_out, &reference_left_out, sizeof left_out);
    rmap_mesh_destroy(mesh);
    rmap_mesh_destroy(reference);
    assert_int_equal(note.status != RMAP_OK, note.text[0] != 0);
    return note.status;
}

static uint8_t *read_file(const char *path, size_t *nbytes)
{
    uint8_t *bytes = NULL;
    assert_int_equal(rmap_input_file_read(path, SIZE_MAX - 1, &bytes, nbytes, NULL), RMAP_OK);
    return bytes;
}

/* Where it is kept. */
static void find_kept(const char *path, struct rmap_kept *kept)
{
    struct rmap_mesh_reading how = plain;
    size_t nbytes = 0;
    uint8_t *bytes = read_file(path, &nbytes);
    *kept = (struct rmap_kept){0};
    how.cache = "kept/here";
    assert_int_equal(rmap_mesh_kept_init(kept, path, &how, bytes, nbytes, NULL), RMAP_OK);
    rmap_free(bytes);
}

static void test_is_used(void **state)
{
    (void)state;
    struct rmap_mesh *other = NULL, *mesh = NULL;
    struct rmap_mesh_left_out left_out = {0};
    struct rmap_mesh_reading how = plain;
    struct rmap_kept kept;
    write_hills("a.obj", 1);
    write_hills("b.obj", 2);
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_OK);
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_OK);
    /* what says that it is of a.obj is believed */
    assert_int_equal(rmap_mesh_read("b.obj", &how, &other, &left_out, NULL), RMAP_OK);
    find_kept("a.obj", &kept);
    assert_int_equal(rmap_mesh_kept_write(&kept, other, &left_out, NULL), RMAP_OK);
    how.cache = "kept/here";
    assert_int_equal(rmap_mesh_read("a.obj", &how, &mesh, &left_out, NULL), RMAP_OK);
    assert_true(rmap_same_mesh(mesh, other));
    rmap_mesh_destroy(mesh);
    /* read in another way it is another mesh */
    how.scale = 1;
    assert_int_equal(rmap_mesh_read("a.obj", &how, &mesh, &left_out, NULL), RMAP_OK);
    assert_false(rmap_same_mesh(mesh, other));
    rmap_mesh_destroy(mesh);
    rmap_mesh_destroy(other);
    /* the file changed, and what was of it before is written over */
    write_hills("a.obj", 3);
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_OK);
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_OK);
    assert_int_equal(unlink("b.obj"), 0);
    rmap_kept_fini(&kept);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* The mesh that a bundle has of the file as it is now; NULL: none. */
static const struct rmap_mesh *again(const struct rmap_bundle *bundle,
                                     const struct rmap_mesh_reading *how)
{
    struct rmap_mesh_left_out left_out = {0};
    struct rmap_mesh_origin *origin = rmap_mesh_origin_create("a.obj", how);
    struct rmap_mesh *mesh = rmap_mesh_again(bundle, origin, &left_out);
    rmap_mesh_origin_destroy(origin);
    assert_int_equal(left_out.degenerate, mesh ? 1 : 0);
    rmap_mesh_destroy(mesh); /* the bundle has it */
    return mesh;
}

static void test_is_taken_over(void **state)
{
    (void)state;
    struct rmap_bundle *bundle = NULL;
    struct rmap_mesh *mesh = NULL;
    struct rmap_mesh_left_out left_out = {0};
    struct rmap_mesh_reading other = plain;
    write_hills("a.obj", 1);
    assert_int_equal(rmap_bundle_of_text("", "", NULL, &bundle, NULL), RMAP_OK);
    struct rmap_mesh_origin *origin = rmap_mesh_origin_create("a.obj", &plain);
    assert_int_equal(rmap_mesh_read("a.obj", &plain, &mesh, &left_out, NULL), RMAP_OK);
    assert_int_equal(rmap_bundle_add_mesh(bundle, "hills", mesh, NULL), RMAP_OK);
    assert_null(again(bundle, &plain)); /* of what file it is has not been said */
    rmap_mesh_origin_keep(bundle, origin, &left_out);
    assert_ptr_equal(again(bundle, &plain), mesh);
    assert_null(again(NULL, &plain));
    other.scale = 1;
    assert_null(again(bundle, &other));
    other = plain;
    other.keep = RMAP_MESH_FLAT;
    assert_null(again(bundle, &other));
    write_hills("a.obj", 2); /* as long as before */
    assert_null(again(bundle, &plain));
    assert_int_equal(unlink("a.obj"), 0);
    assert_null(again(bundle, &plain));
    rmap_bundle_destroy(bundle);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_damage(void **state)
{
    (void)state;
    struct rmap_kept kept;
    write_hills("a.obj", 1);
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_OK);
    find_kept("a.obj", &kept);
    size_t nbytes = 0;
    uint8_t *whole = read_file(kept.path, &nbytes);
    for (size_t i = 0; i < 40; i++) { /* one bit, then a cut; the head's bytes one by one */
        const size_t at = i < 20 ? 4 * i : i * (nbytes / 40);
        for (int cut = 0; cut < 2; cut++) {
            struct rmap_mesh *mesh = NULL;
            struct rmap_mesh_left_out left_out;
            struct rmap_error err = {0};
            FILE *out = fopen(kept.path, "wb");
            assert_non_null(out);
            whole[at] ^= (uint8_t)(cut ? 0 : 1 << i % 8);
            assert_int_equal(fwrite(whole, 1, cut ? at : nbytes, out), cut ? at : nbytes);
            whole[at] ^= (uint8_t)(cut ? 0 : 1 << i % 8);
            assert_int_equal(fclose(out), 0);
            assert_int_equal(rmap_mesh_kept_read(&kept, &mesh, &left_out, &err), RMAP_FORMAT);
            assert_non_null(strstr(err.text, kept.path));
        }
    }
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_FORMAT); /* and made anew */
    assert_int_equal(check_read("a.obj", "kept/here"), RMAP_OK);
    rmap_free(whole);
    rmap_kept_fini(&kept);
}

static void test_no_place(void **state)
{
    (void)state;
    assert_int_not_equal(check_read("a.obj", "a.obj"), RMAP_OK);
    assert_int_not_equal(check_read("a.obj", "/proc/nowhere"), RMAP_OK);
}

static void test_short_memory(void **state)
{
    (void)state;
    enum rmap_status st = RMAP_SYSTEM;
    struct rmap_mesh_reading how = plain;
    bool noted = false;
    how.cache = "kept/here";
    for (int n = 1; st != RMAP_OK || noted; n++) {
        struct rmap_mesh *mesh = NULL;
        struct rmap_mesh_left_out left_out;
        struct rmap_error note = {0};
        how.note = &note;
        rmap_alloc_fail_at(n);
        st = rmap_mesh_read("a.obj", &how, &mesh, &left_out, NULL);
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        noted = note.status != RMAP_OK;
        rmap_mesh_destroy(mesh);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_is_used),      cmocka_unit_test(test_is_taken_over),
        cmocka_unit_test(test_damage),       cmocka_unit_test(test_no_place),
        cmocka_unit_test(test_short_memory),
    };
    char folder[] = "kept-XXXXXX";
    if (!mkdtemp(folder) || chdir(folder) != 0)
        return 1;
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return chdir("..") || system("rm -r kept-??????") ? 1 : failures;
}

/* SPDX-License-Identifier: MIT
 *
 * Meshes of every format that is promised, and files that are none: an error, never a crash.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <unistd.h>

#include <cmocka.h>

#include "io/mesh/mesh_read.h"
#include "tests/unit/near.h"
#include "tests/unit/read_text.h"

/* assimp leaks what it had begun when an ASCII STL ends early; ours is counted by rmap_alloc_live.
 */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libassimp";
}

static const struct rmap_mesh_reading plain = {.scale = 1, .keep = RMAP_MESH_TANGENTS};

static void write_file(const char *path, const void *bytes, size_t n)
{
    FILE *out = fopen(path, "wb");
    assert_non_null(out);
    assert_int_equal(fwrite(bytes, 1, n, out), n);
    assert_int_equal(fclose(out), 0);
}

static enum rmap_status read_bytes(const char *name, const void *bytes, size_t n, double scale,
                                   struct rmap_mesh **mesh, struct rmap_mesh_left_out *left_out,
                                   char told[1024])
{
    struct rmap_error err = {0};
    write_file(name, bytes, n);
    *mesh = NULL;
    *left_out = (struct rmap_mesh_left_out){0};
    enum rmap_status st = rmap_mesh_read(
        name, &(struct rmap_mesh_reading){.scale = scale, .keep = RMAP_MESH_TANGENTS}, mesh,
        left_out, &err);
    memcpy(told, err.text, 1024);
    assert_int_equal(unlink(name), 0);
    return st;
}

static struct rmap_mesh *must_read(const char *name, const void *bytes, size_t n, double scale)
{
    struct rmap_mesh *mesh;
    struct rmap_mesh_left_out left_out;
    char told[1024];
    enum rmap_status st = read_bytes(name, bytes, n, scale, &mesh, &left_out, told);
    if (st != RMAP_OK)
        print_error("%s\n", told);
    assert_int_equal(st, RMAP_OK);
    assert_int_equal(left_out.degenerate, 0);
    return mesh;
}

static void must_refuse(const char *name, const void *bytes, size_t n, const char *expected)
{
    struct rmap_mesh *mesh;
    struct rmap_mesh_left_out left_out;
    char told[1024];
    assert_int_equal(read_bytes(name, bytes, n, 1, &mesh, &left_out, told), RMAP_INPUT);
    if (!strstr(told, expected))
        fail_msg("'%s' does not say '%s'", told, expected);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Signed volume under the triangles: right-handed, outward normals make it positive. */
static double volume(const struct rmap_mesh *mesh)
{
    double sum = 0;
    for (size_t t = 0; t < mesh->n_triangle; t++) {
        struct rmap_vec3 c[3];
        rmap_mesh_corners(mesh, t, c);
        sum += rmap_dot(c[0], rmap_cross(c[1], c[2])) / 6;
    }
    return sum;
}

static const char *const tetra_obj = "o tetra\ng sides\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                     "f 1 3 2\nf 1 2 4\nf 1 4 3\ng slope\nf 2 3 4\n";

static const int tetra_face[4][3] = {{0, 2, 1}, {0, 1, 3}, {0, 3, 2}, {1, 2, 3}};
static const float tetra_vertex[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

static size_t binary_stl(uint8_t *to)
{
    memset(to, 0, 84);
    to[80] = 4;
    for (size_t t = 0; t < 4; t++) {
        uint8_t *record = to + 84 + 50 * t;
        memset(record, 0, 50);
        for (size_t k = 0; k < 3; k++)
            memcpy(record + 12 + 12 * k, tetra_vertex[tetra_face[t][k]], 12);
    }
    return 84 + 200;
}

static size_t ascii_stl(char *to, size_t room)
{
    size_t n = (size_t)snprintf(to, room, "solid tetra\n");
    for (size_t t = 0; t < 4; t++) {
        n += (size_t)snprintf(to + n, room - n, "facet normal 0 0 0\nouter loop\n");
        for (size_t k = 0; k < 3; k++) {
            const float *v = tetra_vertex[tetra_face[t][k]];
            n += (size_t)snprintf(to + n, room - n, "vertex %g %g %g\n", (double)v[0], (double)v[1],
                                  (double)v[2]);
        }
        n += (size_t)snprintf(to + n, room - n, "endloop\nendfacet\n");
    }
    return n + (size_t)snprintf(to + n, room - n, "endsolid tetra\n");
}

static void assert_tetra(const struct rmap_mesh *mesh, double scale)
{
    assert_int_equal(mesh->n_triangle, 4);
    assert_int_equal(mesh->n_vertex, 4); /* shared, so that the body is closed to the bit */
    assert_near(volume(mesh), scale * scale * scale / 6, 1e-6 * scale * scale * scale);
}

static void test_obj_groups_are_faces(void **state)
{
    (void)state;
    struct rmap_mesh *mesh = must_read("a.obj", tetra_obj, strlen(tetra_obj), 1);
    assert_tetra(mesh, 1);
    assert_int_equal(mesh->n_face, 2);
    assert_string_equal(mesh->face_name[0], "sides");
    assert_string_equal(mesh->face_name[1], "slope");
    assert_int_equal(mesh->face[0], 0);
    assert_int_equal(mesh->face[3], 1);
    rmap_mesh_destroy(mesh);
}

static void test_obj_materials_are_faces(void **state)
{
    (void)state;
    const char *text = "g part\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nusemtl red\nf 1 2 3 4\n"
                       "usemtl blue\nf 4 3 2 1\n";
    struct rmap_mesh *mesh = must_read("a.obj", text, strlen(text), 1);
    assert_int_equal(mesh->n_triangle, 4); /* two squares */
    assert_int_equal(mesh->n_vertex, 4);
    assert_int_equal(mesh->n_face, 2);
    rmap_mesh_destroy(mesh);
}

static void test_stl(void **state)
{
    (void)state;
    uint8_t binary[400];
    char ascii[2000];
    struct rmap_mesh *mesh = must_read("a.stl", binary, binary_stl(binary), 25.4);
    assert_tetra(mesh, 25.4);
    rmap_mesh_destroy(mesh);
    mesh = must_read("A.STL", ascii, ascii_stl(ascii, sizeof ascii), 1);
    assert_tetra(mesh, 1);
    assert_string_equal(mesh->face_name[0], "tetra");
    rmap_mesh_destroy(mesh);
}

static void test_ply(void **state)
{
    (void)state;
    const char *text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\n"
                       "property float y\nproperty float z\nelement face 4\n"
                       "property list uchar int vertex_indices\nend_header\n"
                       "0 0 0\n1 0 0\n0 1 0\n0 0 1\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n";
    struct rmap_mesh *mesh = must_read("a.ply", text, strlen(text), 1);
    assert_tetra(mesh, 1);
    rmap_mesh_destroy(mesh);
}

#define SURFACE_HEAD                                                                               \
    "ply\nformat ascii 1.0\ncomment face 1 the round one\ncomment face 7 of none\n"                \
    "element vertex 4\nproperty double x\nproperty double y\nproperty double z\n"                  \
    "element face 2\nproperty list uchar int vertex_indices\nproperty int face\n"                  \
    "element surface 3\nproperty int kind\nproperty double ox\nproperty double oy\n"               \
    "property double oz\nproperty double ax\nproperty double ay\nproperty double az\n"             \
    "property double r1\nproperty double r2\nproperty uchar red\nproperty uchar green\n"           \
    "property uchar blue\nend_header\n"

/* Faces in the order of their numbers whatever that of the triangles; one that has none, and one
 * whose triangles lie elsewhere. */
static void test_ply_surfaces(void **state)
{
    (void)state;
    static const char points[] = SURFACE_HEAD "3 0 4\n0 3 4\n-3 0 4\n5 0 0\n3 0 1 2 1\n3 0 1 3 2\n";
    char text[2000], told[1024];
    struct rmap_mesh *mesh;
    struct rmap_mesh_left_out left_out;
    (void)snprintf(text, sizeof text,
                   "%s1 0 0 4 0 0 2 0 0 9 9 9\n4 0 0 0 0 0 0 5 0 1 2 3\n"
                   "2 0 0 0 0 0 1 4 0 1 2 3\n",
                   points);
    assert_int_equal(read_bytes("a.ply", text, strlen(text), 10, &mesh, &left_out, told), RMAP_OK);
    assert_int_equal(mesh->n_face, 2);
    assert_int_equal(left_out.untrue, 1);
    assert_string_equal(mesh->face_name[0], "the round one");
    assert_null(mesh->face_name[1]);
    assert_int_equal(mesh->surface[0].kind, RMAP_TRUE_SPHERE);
    assert_near(mesh->surface[0].radius, 50, 0);
    assert_int_equal(mesh->surface[1].kind, RMAP_TRUE_NONE);
    rmap_mesh_destroy(mesh);
    static const char *const wrong[][2] = {
        {"9 0 0 4 0 0 2 0 0 9 9 9\n", "face 0 lies on a surface of kind 9"},
        {"2 0 0 4 0 0 2 0 0 9 9 9\n", "the surface of face 0 is none: its radius must be > 0"},
        {"5 0 0 4 0 0 2 1 0 9 9 9\n", "its smaller radius"},
        {"3 0 0 4 0 0 2 1 0 9 9 9\n", "its half angle not 0"},
        {"1 0 0 4 0 0 0 0 0 9 9 9\n", "its axis has no direction"},
        {"1 nan 0 4 0 0 1 0 0 9 9 9\n", "not finite"}};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        (void)snprintf(text, sizeof text, "%s%s0 0 0 0 0 0 0 5 0 1 2 3\n0 0 0 0 0 0 1 4 0 1 2 3\n",
                       points, wrong[i][0]);
        must_refuse("a.ply", text, strlen(text), wrong[i][1]);
    }
    (void)snprintf(text, sizeof text, "%s",
                   SURFACE_HEAD "3 0 4\n0 3 4\n-3 0 4\n5 0 0\n3 0 1 2 3\n"
                                "3 0 1 3 2\n0 0 0 0 0 0 0 0 0 0 0 0\n"
                                "0 0 0 0 0 0 0 0 0 0 0 0\n0 0 0 0 0 0 0 0 0 0 0 0\n");
    must_refuse("a.ply", text, strlen(text), "belongs to a face that has no surface");
}

/* One triangle; its node is mirrored, moved and scaled, which must not turn it inside out: in the
 * node's frame the triangle faces +z, and z is mirrored. */
static void test_gltf_nodes_are_placed(void **state)
{
    (void)state;
    const char *text =
        "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],"
        "\"nodes\":[{\"name\":\"outer\",\"translation\":[10,0,0],\"children\":[1]},"
        "{\"name\":\"inner\",\"mesh\":0,\"scale\":[2,2,-2]}],"
        "\"meshes\":[{\"name\":\"tri\",\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"
        "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
        "\"min\":[0,0,0],\"max\":[1,1,1]}],"
        "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
        "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
        /* (0,0,1) (1,0,1) (0,1,1) */
        "AAAAAAAAAAAAAIA/AACAPwAAAAAAAIA/AAAAAAAAgD8AAIA/\"}]}";
    struct rmap_mesh *mesh = must_read("a.gltf", text, strlen(text), 1);
    assert_int_equal(mesh->n_triangle, 1);
    struct rmap_vec3 c[3];
    rmap_mesh_corners(mesh, 0, c);
    struct rmap_vec3 normal = rmap_cross(rmap_sub(c[1], c[0]), rmap_sub(c[2], c[0]));
    assert_near(c[0].z, -2, 1e-6);
    assert_near(c[1].x + c[0].x + c[2].x, 32, 1e-5);
    assert_near(normal.z, -4, 1e-5);
    rmap_mesh_destroy(mesh);
}

static void test_degenerate_triangles_are_dropped(void **state)
{
    (void)state;
    const char *text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 2 0 0\nv 0 0 0\nv -0 0 0\nf 1 2 3\nf 1 2 4\n"
                       "f 1 1 2\nf 1 5 2\nf 6 2 3\n";
    struct rmap_mesh *mesh;
    struct rmap_mesh_left_out left_out;
    char told[1024];
    assert_int_equal(read_bytes("a.obj", text, strlen(text), 1, &mesh, &left_out, told), RMAP_OK);
    assert_int_equal(mesh->n_triangle, 2);
    assert_int_equal(left_out.degenerate, 3);
    assert_int_equal(mesh->n_vertex, 3); /* -0 is 0 */
    rmap_mesh_destroy(mesh);

    uint8_t stl[400];
    size_t n = binary_stl(stl);
    memcpy(stl + 84 + 12, "\0\0\xc0\x7f", 4);      /* NaN */
    memcpy(stl + 84 + 50 + 12, "\0\0\x80\x7f", 4); /* infinity */
    assert_int_equal(read_bytes("a.stl", stl, n, 1, &mesh, &left_out, told), RMAP_OK);
    assert_int_equal(mesh->n_triangle, 2);
    assert_int_equal(left_out.undefined, 2);
    assert_int_equal(left_out.first, 1);
    rmap_mesh_destroy(mesh);
    must_refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", 32, "has an area");
}

static void test_what_is_no_mesh(void **state)
{
    (void)state;
    uint8_t stl[500] = {0};
    char ascii[2000];
    size_t n = binary_stl(stl), n_ascii = ascii_stl(ascii, sizeof ascii);
    must_refuse("a.stl", "", 0, "is empty");
    must_refuse("a.txt", "v 0 0 0\n", 8, "must end in");
    must_refuse("a.stl",
                "\x7f"
                "ELF, surely not a mesh",
                23, "cannot read mesh a.stl");
    must_refuse("a.stl", stl, n - 1, "cannot read mesh a.stl");
    must_refuse("a.stl", stl, n + 7, "cannot read mesh a.stl");
    must_refuse("a.stl", stl, 84, "cannot read mesh a.stl");
    stl[83] = 0x7f; /* two thousand million triangles */
    must_refuse("a.stl", stl, n, "cannot read mesh a.stl");
    must_refuse("a.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n", 23, "cannot read mesh a.obj");
    must_refuse("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", 32, "cannot read mesh a.obj");
    must_refuse("a.ply", "ply\nformat ascii 1.0\nelement vertex 99999999\n", 46,
                "cannot read mesh a.ply");
    must_refuse("a.gltf", "{\"asset\":", 9, "cannot read mesh a.gltf");
    must_refuse("a.glb", "glTF\2\0\0\0\xff\xff\xff\x7f", 12, "cannot read mesh a.glb");
    (void)n_ascii;
}

/* Every truncation: refused, or a smaller mesh; never a crash. */
static void test_truncations(void **state)
{
    (void)state;
    uint8_t stl[400];
    char ascii[2000];
    struct rmap_mesh *mesh;
    struct rmap_mesh_left_out left_out;
    size_t n = binary_stl(stl), n_ascii = ascii_stl(ascii, sizeof ascii);
    char told[1024];
    for (size_t cut = 1; cut < n; cut++)
        assert_int_equal(read_bytes("a.stl", stl, cut, 1, &mesh, &left_out, told), RMAP_INPUT);
    for (size_t cut = 1; cut < n_ascii; cut++) {
        enum rmap_status st = read_bytes("a.stl", ascii, cut, 1, &mesh, &left_out, told);
        assert_true(st == RMAP_OK || st == RMAP_INPUT);
        if (st == RMAP_OK)
            rmap_mesh_destroy(mesh);
    }
    for (size_t cut = 1; cut < strlen(tetra_obj); cut++) {
        enum rmap_status st = read_bytes("a.obj", tetra_obj, cut, 1, &mesh, &left_out, told);
        assert_true(st == RMAP_OK || st == RMAP_INPUT);
        if (st == RMAP_OK)
            rmap_mesh_destroy(mesh);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_what_is_no_file(void **state)
{
    (void)state;
    struct rmap_mesh *mesh = NULL;
    struct rmap_error err = {0};
    struct rmap_mesh_left_out left_out;
    assert_int_equal(rmap_mesh_read("missing.stl", &plain, &mesh, &left_out, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "No such file"));
    assert_int_equal(rmap_mesh_read("/tmp/.", &plain, &mesh, &left_out, &err), RMAP_INPUT);
}

static void test_short_memory(void **state)
{
    (void)state;
    write_file("b.obj", tetra_obj, strlen(tetra_obj));
    enum rmap_status st = RMAP_SYSTEM;
    for (int n = 1; st != RMAP_OK; n++) {
        struct rmap_mesh *mesh = NULL;
        struct rmap_mesh_left_out left_out;
        rmap_alloc_fail_at(n);
        st = rmap_mesh_read("b.obj", &plain, &mesh, &left_out, NULL);
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        if (st == RMAP_OK) {
            assert_true(n > 6);
            assert_string_equal(mesh->face_name[0], "sides");
        }
        rmap_mesh_destroy(st == RMAP_OK ? mesh : NULL);
        assert_int_equal(rmap_alloc_live(), 0);
    }
    assert_int_equal(unlink("b.obj"), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_obj_groups_are_faces),
        cmocka_unit_test(test_obj_materials_are_faces),
        cmocka_unit_test(test_stl),
        cmocka_unit_test(test_ply),
        cmocka_unit_test(test_ply_surfaces),
        cmocka_unit_test(test_gltf_nodes_are_placed),
        cmocka_unit_test(test_degenerate_triangles_are_dropped),
        cmocka_unit_test(test_what_is_no_mesh),
        cmocka_unit_test(test_truncations),
        cmocka_unit_test(test_what_is_no_file),
        cmocka_unit_test(test_short_memory),
    };
    char folder[] = "mesh-XXXXXX";
    if (!mkdtemp(folder) || chdir(folder) != 0)
        return 1;
    int failures = cmocka_run_group_tests(tests, NULL, NULL);
    return chdir("..") || rmdir(folder) ? 1 : failures;
}

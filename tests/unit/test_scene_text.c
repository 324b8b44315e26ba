/* SPDX-License-Identifier: MIT
 *
 * Edits of a scene's text: a tree that follows them is that of the text read anew, to each line and
 * column; what it cannot follow has none. What others have by an alias stays. Where a node stands
 * is the same from wherever reading begins. A tree that is packed is the same afterwards; bytes
 * that are none are refused.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "base/count.h"
#include "io/file/input_file.h"
#include "io/scene/scene_text.h"
#include "io/scene/yaml_pack.h"
#include "io/scene/yaml_span.h"

static void check_same(const struct rmap_yaml_node *a, const struct rmap_yaml_node *b)
{
    assert_int_equal(a->kind, b->kind);
    assert_int_equal(a->line, b->line);
    assert_int_equal(a->column, b->column);
    assert_int_equal(a->quoted, b->quoted);
    assert_int_equal(a->text != NULL, b->text != NULL);
    if (a->text)
        assert_string_equal(a->text, b->text);
    assert_int_equal(a->n_item, b->n_item);
    for (size_t i = 0; i < a->n_item; i++) {
        assert_int_equal(a->item[i].line, b->item[i].line);
        assert_int_equal(a->item[i].column, b->item[i].column);
        assert_int_equal(a->item[i].key != NULL, b->item[i].key != NULL);
        if (a->item[i].key)
            assert_string_equal(a->item[i].key, b->item[i].key);
        check_same(a->item[i].value, b->item[i].value);
    }
}

static void check_packed(const struct rmap_yaml_node *root)
{
    struct rmap_yaml_node *again = NULL;
    uint8_t *bytes = NULL;
    size_t nbytes = 0;
    assert_int_equal(rmap_yaml_pack(root, &bytes, &nbytes, NULL), RMAP_OK);
    assert_int_equal(rmap_yaml_unpack(bytes, nbytes, &again, NULL), RMAP_OK);
    check_same(root, again);
    rmap_yaml_destroy(again);
    rmap_free(bytes);
}

static void check_tree(const struct rmap_scene_text *scene)
{
    struct rmap_yaml_node *root = NULL;
    struct rmap_diagnostics found;
    struct rmap_error err = {0};
    rmap_diagnostics_init(&found, "scene");
    assert_int_equal(rmap_yaml_parse(scene->text, strlen(scene->text), &root, &found, &err),
                     RMAP_OK);
    assert_int_equal(found.n, 0);
    check_same(scene->root, root);
    rmap_yaml_destroy(root);
    rmap_diagnostics_fini(&found);
    check_packed(scene->root);
}

static uint64_t random_state = 1;

static unsigned draw(size_t below)
{
    random_state = random_state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (unsigned)((random_state >> 33) % below);
}

/* Down a random way through the tree; it ends somewhere. */
static void random_path(const struct rmap_yaml_node *node, char *path, size_t nbytes)
{
    path[0] = 0;
    while (node->n_item > 0 && draw(8)) {
        const size_t at = draw(node->n_item), used = strlen(path);
        if (node->item[at].key)
            (void)snprintf(path + used, nbytes - used, "%s%s", used ? "." : "", node->item[at].key);
        else
            (void)snprintf(path + used, nbytes - used, "%s%zu", used ? "." : "", at + 1);
        node = node->item[at].value;
    }
}

static const char *const value_text[] = {"3.25",
                                         "\"a\\u2028b\"",
                                         "-17",
                                         "true",
                                         "null",
                                         "\"white\"",
                                         "\"2 mm\"",
                                         "\"a: b # c\"",
                                         "\"\"",
                                         "\"é ü\"",
                                         "[1, 2.5, -3e-7]",
                                         "[\"a, b\", \"{\"]",
                                         "{\"type\": \"lambert\"}",
                                         "[[1, 2], [3]]"};

static bool read_tree(struct rmap_scene_text *scene)
{
    struct rmap_diagnostics found;
    struct rmap_error err = {0};
    rmap_diagnostics_init(&found, "scene");
    scene->is_sound =
        rmap_yaml_parse(scene->text, strlen(scene->text), &scene->root, &found, &err) == RMAP_OK;
    rmap_diagnostics_fini(&found);
    return scene->is_sound;
}

/* How many of the edits a tree followed. */
static size_t edit(const char *path, const char *text, size_t n_edit)
{
    struct rmap_scene_text scene = {0};
    size_t nbytes = 0, n_followed = 0;
    uint8_t *bytes = NULL;
    if (path)
        assert_int_equal(rmap_input_file_read(path, 1 << 20, &bytes, &nbytes, NULL), RMAP_OK);
    const char *whole = path ? (const char *)bytes : text;
    for (size_t i = 0; i < n_edit; i++) {
        struct rmap_scene_text next = {0};
        struct rmap_error err = {0};
        char at[400];
        /* After so many a scene is hardly one any more; an anchor that an alias needs may go. */
        if (i % 20 == 0 || (!scene.root && !read_tree(&scene))) {
            rmap_scene_text_fini(&scene);
            scene.text = rmap_strdup(whole);
            assert_true(read_tree(&scene));
        }
        random_path(scene.root, at, sizeof at);
        json_t *value = json_loads(value_text[draw(RMAP_COUNT(value_text))], JSON_DECODE_ANY, NULL);
        json_t *values = json_pack("{s:o}", at, value);
        const enum rmap_status st = rmap_scene_text_change(&scene, NULL, values, &next, &err);
        json_decref(values);
        if (st != RMAP_OK) {
            assert_int_equal(st, RMAP_INPUT);
            continue;
        }
        n_followed += next.root != NULL;
        if (next.root)
            check_tree(&next);
        else if (!strchr(next.text, '&'))
            assert_true(read_tree(&next));
        check_tree(&scene); /* which is as it was */
        rmap_scene_text_fini(&scene);
        scene = next;
    }
    rmap_scene_text_fini(&scene);
    rmap_free(bytes);
    assert_int_equal(rmap_alloc_live(), 0);
    return n_followed;
}

static void test_follows(void **state)
{
    (void)state;
    static const char *const example[] = {"double-gauss", "room", "luneburg", "light-guide"};
    for (size_t i = 0; i < RMAP_COUNT(example); i++) {
        char path[400];
        (void)snprintf(path, sizeof path, "%s/examples/%s/scene.yaml", RAYMAP_SOURCE_DIR,
                       example[i]);
        assert_in_range(edit(path, NULL, 400), 100, 400);
    }
    assert_in_range(
        edit(NULL, "a:\n- 1\n- - 2\n  - {b: 3}\nc: # d\n- e: 5\n  f:\n  - 6\n  g: 7\nh: i\n", 200),
        20, 200);
    assert_in_range(edit(NULL,
                         "a: |\n  x\n\nb:\n- >-\n  y\n\n  z # no comment\n- - |+\n    w\n\n  - "
                         "1\n- c: |2\n     d\n"
                         "  e: [f]\n# g\nh: |\n\ni: >\n  j\n",
                         400),
                    20, 400);
    assert_in_range(
        edit(NULL, "\xEF\xBB\xBF\"é\": {ü: [1, 'ö', {ä: 5}], b: 7, c: {d: e}} # ß\n", 200), 50,
        200);
}

/* An anchor's copies follow: the text is read anew. */
static void test_anchors_follow(void **state)
{
    (void)state;
    assert_in_range(edit(NULL, "a: [&x {b: 1}, 4]\n\"*c\": {d: *x}\ne: [1, 2]\n", 60), 20, 60);
}

/* What others have by an alias or a merge key stays, or the edit is refused. */
static void test_others_stay(void **state)
{
    (void)state;
    static const struct {
        const char *text, *path, *value, *changed; /* value NULL: taken away */
    } edits[] = {
        {"a:\n- &R {n: 1, at: [0, 0]}\n- {<<: *R, name: m}\n", "a.m.at", "[1, 2]",
         "a:\n- &R {n: 1, at: [0, 0]}\n- {<<: *R, name: m, at: [1, 2]}\n"},
        {"a:\n- &R {n: 1}\n- &S # ß\n  <<: *R\n  name: m\n- *S\n", "a.1.n", "2", NULL},
        {"a:\n- &R {n: 1}\n- &S # ß\n  <<: *R\n  name: m\n", "a.m.n", "2",
         "a:\n- &R {n: 1}\n- &S # ß\n  n: 2\n  <<: *R\n  name: m\n"},
        {"a: &p [1, 2]\nb: {c: *p, d: 5}\n", "b.c", "[3]", "a: &p [1, 2]\nb: {c: [3], d: 5}\n"},
        {"a: &p [1, 2]\nb:\n- *p\n- 4\n", "b.1", "\"x\"", "a: &p [1, 2]\nb:\n- x\n- 4\n"},
        {"a: &p [1, 2]\nb: {c: *p, d: 5}\n", "b.c", NULL, "a: &p [1, 2]\nb: {d: 5}\n"},
        {"a: &p [1, 2]\nb: {c: *p, d: 5}\n", "b.c.2", "3", NULL},
        {"a: &p [1, 2]\nb: {c: *p, d: 5}\n", "a.2", "3", NULL},
        {"a: &p [1, 2]\nb: {c: *p, d: 5}\n", "a", "[3]", NULL},
        {"a: &p [1, 2]\nb: {c: *p, d: 5}\n", "a", NULL, NULL},
        {"a: &p [1, 2]\nb: {d: 5}\n", "a", "[3]", "a: &p [3]\nb: {d: 5}\n"},
        {"a: &p\nb: {d: 5}\n", "a", "[3]", "a: &p [3]\nb: {d: 5}\n"},
        {"a: &p\n- 1\n- 2\nb: 4\n", "a", "[3]", "a: &p\n [3]\nb: 4\n"},
        {"a: &p {x: 1, y: 2}\nb: {<<: *p, x: 3}\n", "a.x", "4",
         "a: &p {x: 4, y: 2}\nb: {<<: *p, x: 3}\n"},
        {"a: &p {x: 1, y: 2}\nb: {<<: *p, x: 3}\n", "a.y", "4", NULL},
        {"a: &p {x: 1, y: 2}\nb: {<<: *p, x: 3}\n", "b.x", NULL,
         "a: &p {x: 1, y: 2}\nb: {<<: *p}\n"},
        {"a: &p {x: 1, y: 2}\nb: {<<: *p, x: 3}\n", "b.y", NULL, NULL},
        {"a: {s: &s {f: 1}, <<: *s}\n", "a.f", "2", "a: {s: &s {f: 1}, <<: *s, f: 2}\n"},
        {"a: &l\n  - {name: x}\n", "a.y", "{}", "a: &l\n  - {name: x}\n  - {name: y}\n"},
        {"a: [{name: g, objects: &o [{name: x, v: 1}]}, {name: h, objects: *o}]\n", "a.x.v", "2",
         NULL},
    };
    for (size_t i = 0; i < RMAP_COUNT(edits); i++) {
        struct rmap_scene_text scene = {.text = rmap_strdup(edits[i].text)}, next = {0};
        struct rmap_error err = {0};
        json_t *value = edits[i].value ? json_loads(edits[i].value, JSON_DECODE_ANY, NULL) : NULL;
        json_t *remove = value ? NULL : json_pack("[s]", edits[i].path);
        json_t *values = value ? json_pack("{s:o}", edits[i].path, value) : NULL;
        const enum rmap_status st = rmap_scene_text_change(&scene, remove, values, &next, &err);
        assert_int_equal(st, edits[i].changed ? RMAP_OK : RMAP_INPUT);
        if (edits[i].changed) {
            assert_string_equal(next.text, edits[i].changed);
            check_tree(&next);
        } else {
            assert_true(strstr(err.text, "anchor") || strstr(err.text, "'<<'") ||
                        strstr(err.text, "alias"));
        }
        json_decref(remove);
        json_decref(values);
        rmap_scene_text_fini(&next);
        rmap_scene_text_fini(&scene);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* What is no scene for another reason than an anchor says that. */
static void test_true_reason(void **state)
{
    (void)state;
    struct rmap_scene_text scene = {.text = rmap_strdup("a: &p [1, 2]\na: 3\nb: {c: *p, d: 5}\n")},
                           next = {0};
    struct rmap_error err = {0};
    json_t *value = json_integer(5);
    for (size_t i = 0; i < RMAP_YAML_DEPTH_MAX; i++)
        value = json_pack("[o]", value);
    json_t *values = json_pack("{s:o}", "b.d", value);
    assert_int_equal(rmap_scene_text_change(&scene, NULL, values, &next, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, RMAP_YAML_TOO_DEEP));
    json_decref(values);
    rmap_scene_text_fini(&scene);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* How many nodes and entries have been found in a text from within, where reading the whole of it
 * finds them. */
static size_t check_spans(const char *text, const struct rmap_yaml_node *root,
                          const struct rmap_yaml_node *node)
{
    const struct rmap_yaml_node nothing = {0};
    size_t n = 0;
    for (size_t i = 0; i <= 2 * node->n_item; i++) {
        const struct rmap_yaml_item *item = i > 0 ? &node->item[(i - 1) / 2] : NULL;
        const bool is_entry = item && i % 2 == 1;
        const struct rmap_yaml_node *of = item ? item->value : node;
        const int line = is_entry ? item->line : of->line,
                  column = is_entry ? item->column : of->column;
        const bool scalar = (is_entry && item->key) || of->kind == RMAP_YAML_SCALAR;
        struct rmap_yaml_span found = {0}, right = {0};
        const int n_node = is_entry && item->key ? 2 : 1;
        const bool is = rmap_yaml_span(text, &nothing, line, column, scalar, n_node, &right);
        assert_int_equal(rmap_yaml_span(text, root, line, column, scalar, n_node, &found), is);
        if (!right.in_flow)
            found.before = right.before = 0;
        assert_memory_equal(&found, &right, sizeof right);
        n += is;
    }
    for (size_t i = 0; i < node->n_item; i++)
        n += check_spans(text, root, node->item[i].value);
    return n;
}

static void test_spans(void **state)
{
    (void)state;
    static const char *const text[] = {
        "raymap: 1\nobjects:\n  - {name: a, at: [1, 2]} # x\n  - name: b\n    at:\n      - 1\n"
        "      - - 2\n        - 3\n  -\n    name: c\nlist:\n- 1\n- two\n  words\n-\nend: 'x\n  "
        "y'\n",
        "\xEF\xBB\xBF\"a\": &x\n  b: [1,\n  2]\n  c: {d: e,\n   f: 1}\ng: *x\nh: !!str 5\ni: |\n  "
        "j: k\n"
        "  l\nm: {<<: *x, n: 1}\n",
        "{\n\"a\": [\n1,\n2],\n\"b\":\n{\"c\": 1}}\n",
        "a:\n  surface: &s {\n    front: air,\n    back: glass\n    }\n  <<: *s\n  u: 1\n",
        "a: 1\r\nb:\r  - 'x\xE2\x80\xA8y'\r  - \xC3\xA9: {\xE2\x82\xAC: [1, 2], c: 3}\nd: &y "
        "[1]\ne: {f: *y}\n"};
    size_t n = 0;
    for (size_t i = 0; i < RMAP_COUNT(text); i++) {
        struct rmap_scene_text scene = {.text = rmap_strdup(text[i])};
        assert_true(read_tree(&scene));
        n += check_spans(scene.text, scene.root, scene.root);
        rmap_scene_text_fini(&scene);
    }
    assert_true(n > 100);
}

/* The comma before a bracket is not one of what stands in it. */
static void test_last_entry_goes(void **state)
{
    (void)state;
    struct rmap_scene_text scene = {.text = rmap_strdup("a: [1, {b: 2}]\n")}, next = {0};
    json_t *remove = json_pack("[s]", "a.2.b");
    assert_int_equal(rmap_scene_text_change(&scene, remove, NULL, &next, NULL), RMAP_OK);
    assert_string_equal(next.text, "a: [1, {}]\n");
    json_decref(remove);
    rmap_scene_text_fini(&next);
    rmap_scene_text_fini(&scene);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* A block's text ends before the line behind it. */
static void test_block_scalars(void **state)
{
    (void)state;
    static const struct {
        const char *path, *value, *changed; /* value NULL: taken away */
    } edits[] = {
        {"a.x", "5", "a:\r\n  x: 5\r\n  y: {z: 1}\r\nl:\n- |\n  e\n\nf: >-\n  g"},
        {"a.x", NULL, "a:\r\n  y: {z: 1}\r\nl:\n- |\n  e\n\nf: >-\n  g"},
        {"l.1", "5", "a:\r\n  x: >-\r\n    b\r\n  y: {z: 1}\r\nl:\n- 5\nf: >-\n  g"},
        {"l.h", "{}",
         "a:\r\n  x: >-\r\n    b\r\n  y: {z: 1}\r\nl:\n- |\n  e\n\n- {name: h}\nf: >-\n  g"},
        {"f", "5", "a:\r\n  x: >-\r\n    b\r\n  y: {z: 1}\r\nl:\n- |\n  e\n\nf: 5"}};
    for (size_t i = 0; i < RMAP_COUNT(edits); i++) {
        struct rmap_scene_text
            next = {0},
            scene = {.text = rmap_strdup(
                         "a:\r\n  x: >-\r\n    b\r\n  y: {z: 1}\r\nl:\n- |\n  e\n\nf: >-\n  g")};
        json_t *value = edits[i].value ? json_loads(edits[i].value, JSON_DECODE_ANY, NULL) : NULL;
        json_t *remove = value ? NULL : json_pack("[s]", edits[i].path);
        json_t *values = value ? json_pack("{s:o}", edits[i].path, value) : NULL;
        assert_int_equal(rmap_scene_text_change(&scene, remove, values, &next, NULL), RMAP_OK);
        assert_string_equal(next.text, edits[i].changed);
        assert_true(next.root || read_tree(&next));
        check_tree(&next);
        json_decref(remove);
        json_decref(values);
        rmap_scene_text_fini(&next);
        rmap_scene_text_fini(&scene);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* For another folder: names of files, and of nothing else. */
static void test_other_folder(void **state)
{
    (void)state;
    static const char text[] =
        "media: {table: N-BK7, file: N-SF6, m: {gradient: {type: grid, file: g.h5}}}\n"
        "surfaces: {table: Acktar Metal Velvet, file: &f black, s: {reflect: {file: r.csv}}}\n"
        "films: {c: {table: {file: c.csv}}}\n"
        "geometries:\n  media:\n    file: >-\n      sub/b.obj\n  file: {type: mesh, file: ./b.obj "
        "# b\n   }\n"
        "objects: [{name: file, surface: *f, sources: [{name: table, distribution: {table: "
        "t.ies}}]}]\n"
        "background: {file: /sky.hdr}\n"
        "simulations: [{name: q, set: {surfaces.table: white, surfaces.file: black, media.m.table: "
        "q,\n"
        "  geometries.media.file: 'a b.stl', objects.file.sources.1.distribution.table: u.ies}}]\n";
    static const char led[] =
        "media: {table: N-BK7, file: N-SF6, m: {gradient: {type: grid, file: \"../g.h5\"}}}\n"
        "surfaces: {table: Acktar Metal Velvet, file: &f black, s: {reflect: {file: "
        "\"../r.csv\"}}}\n"
        "films: {c: {table: {file: \"../c.csv\"}}}\n"
        "geometries:\n  media:\n    file: \"../sub/b.obj\"\n  file: {type: mesh, file: "
        "\"../b.obj\" # b\n   }\n"
        "objects: [{name: file, surface: *f, sources: [{name: table, distribution: {table: "
        "\"../t.ies\"}}]}]\n"
        "background: {file: /sky.hdr}\n"
        "simulations: [{name: q, set: {surfaces.table: white, surfaces.file: black, media.m.table: "
        "q,\n"
        "  geometries.media.file: \"../a b.stl\", objects.file.sources.1.distribution.table: "
        "\"../u.ies\"}}]\n";
    char *written = NULL;
    assert_int_equal(rmap_scene_text_lead(text, "../", &written, NULL), RMAP_OK);
    assert_string_equal(written, led);
    rmap_free(written);
    enum rmap_status st = RMAP_SYSTEM;
    for (int64_t i = 1; st != RMAP_OK; i++) { /* nothing is left out for want of memory */
        written = NULL;
        rmap_alloc_fail_at(i);
        st = rmap_scene_text_lead(text, "../", &written, NULL);
        assert_true(st == RMAP_OK ? strcmp(written, led) == 0 : st == RMAP_SYSTEM && !written);
    }
    rmap_alloc_fail_at(0);
    rmap_free(written);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_hostile_bytes(void **state)
{
    (void)state;
    static const char text[] = "a: {b: [1, 'two', {c: d}], e: }\nf: [[], {}, \"\"]\n";
    struct rmap_scene_text scene = {.text = rmap_strdup(text)};
    uint8_t *bytes = NULL, *copy = NULL;
    size_t nbytes = 0, n_refused = 0;
    assert_true(read_tree(&scene));
    assert_int_equal(rmap_yaml_pack(scene.root, &bytes, &nbytes, NULL), RMAP_OK);
    for (size_t i = 0; i < 20000; i++) {
        struct rmap_yaml_node *root = NULL;
        const size_t cut = draw(2) ? nbytes : draw(nbytes);
        copy = rmap_alloc(cut + 1, 1); /* so that reading beyond is seen */
        memcpy(copy, bytes, cut);
        for (size_t k = draw(4); cut > 0 && k > 0; k--)
            copy[draw(cut)] = (uint8_t)draw(256);
        const enum rmap_status st = rmap_yaml_unpack(copy, cut, &root, NULL);
        assert_true(st == RMAP_OK || (st == RMAP_FORMAT && !root));
        n_refused += st != RMAP_OK;
        if (root)
            check_packed(root);
        rmap_yaml_destroy(root);
        rmap_free(copy);
    }
    assert_in_range(n_refused, 10000, 19000);
    rmap_free(bytes);
    rmap_scene_text_fini(&scene);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_follows),         cmocka_unit_test(test_anchors_follow),
        cmocka_unit_test(test_others_stay),     cmocka_unit_test(test_spans),
        cmocka_unit_test(test_last_entry_goes), cmocka_unit_test(test_true_reason),
        cmocka_unit_test(test_block_scalars),   cmocka_unit_test(test_other_folder),
        cmocka_unit_test(test_hostile_bytes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

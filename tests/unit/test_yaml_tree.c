/* SPDX-License-Identifier: MIT
 *
 * Places, limits and edits of YAML trees.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "io/scene/yaml_tree.h"
#include "tests/unit/read_text.h"

/* The tree of a text, or NULL; in either case what was said. */
static struct rmap_yaml_node *parse(const char *text, char **told_ret)
{
    struct rmap_yaml_node *root = NULL;
    struct rmap_diagnostics d;
    struct rmap_error err = {0};
    rmap_diagnostics_init(&d, "t");
    enum rmap_status st = rmap_yaml_parse(text, strlen(text), &root, &d, &err);
    assert_int_equal(st == RMAP_OK, root != NULL);
    *told_ret = printed(&d);
    rmap_diagnostics_fini(&d);
    return root;
}

static void assert_refused(const char *text, const char *expected)
{
    char *told = NULL;
    struct rmap_yaml_node *root = parse(text, &told);
    assert_null(root);
    assert_string_equal(told, expected);
    free(told);
    assert_int_equal(rmap_alloc_live(), 0);
}

static char *repeat(const char *piece, int n, const char *end)
{
    size_t len = strlen(piece);
    char *text = calloc(len * (size_t)n + strlen(end) + 1, 1);
    for (int i = 0; i < n; i++)
        memcpy(text + len * (size_t)i, piece, len);
    memcpy(text + len * (size_t)n, end, strlen(end));
    return text;
}

static void test_places(void **state)
{
    (void)state;
    char *told = NULL;
    struct rmap_yaml_node *root = parse("# head\na: {b: 1, c: [x, 'y']}\nd:\n  e: \n", &told);
    assert_string_equal(told, "");
    free(told);
    const struct rmap_yaml_node *a = rmap_yaml_get(root, "a"), *c = rmap_yaml_get(a, "c");
    assert_int_equal(root->line, 2);
    assert_int_equal(a->line, 2);
    assert_int_equal(a->column, 4);
    assert_int_equal(a->item[1].column, 11);
    assert_int_equal(c->item[1].value->column, 18);
    assert_true(c->item[1].value->quoted && !c->item[0].value->quoted);
    assert_null(rmap_yaml_get(rmap_yaml_get(root, "d"), "e")); /* nothing stands behind it */
    assert_null(rmap_yaml_get(c, "a"));
    rmap_yaml_destroy(root);
}

static void test_refusals(void **state)
{
    (void)state;
    assert_refused("", "t: error: the text is empty\n");
    assert_refused("# only a comment\n", "t: error: the text is empty\n");
    assert_refused("a: 1\n---\nb: 2\n",
                   "t:2:1: error: a second document: a scene is one document\n");
    assert_refused("a: [1, 2\n",
                   "t:2:1: error: this is not YAML: did not find expected ',' or ']' "
                   "while parsing a flow sequence: what is opened in line 1, column 4 is "
                   "not closed\n");
    assert_refused(
        "a: 1\nb\n\tc: 2\n",
        "t:3:1: error: this is not YAML: found a tab character that violates "
        "indentation while scanning a plain scalar (a tab indents this line: indent with "
        "spaces)\n");
    assert_refused("ab\n c\xff: 1\n",
                   "t:2:3: error: this is not YAML: invalid leading UTF-8 octet\n");
    assert_refused("a: \"x\\0y\"\n", "t:1:4: error: a NUL character in a value\n");
    assert_refused("? [a, b]\n: 1\n", "t:1:3: error: a key must be a plain word\n");
    assert_refused("a: &x [*x]\n",
                   "t:1:8: error: an alias refers to nothing that is complete before it\n");
}

static void test_depth(void **state)
{
    (void)state;
    char *deep = repeat("[", 65, "");
    assert_refused(deep, "t:1:65: error: nested too deeply (at most 64 levels)\n");
    free(deep);
    deep = repeat("[", 100000, "");
    assert_refused(deep, "t:1:65: error: nested too deeply (at most 64 levels)\n");
    free(deep);
    deep = repeat("{a: ", 100000, "");
    assert_refused(deep, "t:1:257: error: nested too deeply (at most 64 levels)\n");
    free(deep);
    deep = repeat("- ", 100000, "");
    assert_refused(deep, "t:1:129: error: nested too deeply (at most 64 levels)\n");
    free(deep);
    /* Aliases count with the depth of what they stand for. */
    char *half = repeat("[", 40, ""), *close = repeat("]", 40, "");
    char text[400];
    (void)snprintf(text, sizeof text, "a: &x %s%s\nb: %s*x%s\n", half, close, half, close);
    assert_refused(text, "t:2:44: error: nested too deeply (at most 64 levels)\n");
    free(half);
    free(close);
}

/* Nine levels of nine: 387 million nodes if it were let. */
static void test_aliases_cannot_explode(void **state)
{
    (void)state;
    char text[1000] = "a0: &a0 [x,x,x,x,x,x,x,x,x]\n";
    for (int i = 1; i < 10; i++) {
        size_t len = strlen(text);
        (void)snprintf(text + len, sizeof text - len,
                       "a%d: &a%d [*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d,*a%d]\n", i, i, i - 1,
                       i - 1, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1, i - 1);
    }
    char *told = NULL;
    assert_null(parse(text, &told));
    assert_non_null(strstr(told, "error: this alias expands to too much\n"));
    free(told);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_aliases_are_copies(void **state)
{
    (void)state;
    char *told = NULL;
    struct rmap_yaml_node *root = parse("a: &x {k: 1}\nb: *x\n", &told);
    free(told);
    const struct rmap_yaml_node *a = rmap_yaml_get(root, "a"), *b = rmap_yaml_get(root, "b");
    assert_ptr_not_equal(a, b);
    assert_string_equal(rmap_yaml_get(b, "k")->text, "1");
    assert_int_equal(rmap_yaml_get(b, "k")->line, 1);
    rmap_yaml_destroy(root);
}

static void test_duplicate_keys(void **state)
{
    (void)state;
    char *told = NULL;
    struct rmap_yaml_node *root = parse("a: 1\nb: 2\na: 3\n", &told);
    assert_string_equal(
        told, "t:3:1: error: duplicate key 'a' (first on line 1): remove or rename one\n");
    assert_string_equal(rmap_yaml_get(root, "a")->text, "1");
    rmap_yaml_destroy(root);
    free(told);
}

static void test_edit(void **state)
{
    (void)state;
    char *told = NULL;
    struct rmap_diagnostics d;
    struct rmap_yaml_node *root =
        parse("a: {b: 1, x.y: 2}\n"
              "list: [{name: one, v: 1}, {name: g, objects: [{name: in, v: 5}]}]\n"
              "none:\n",
              &told);
    free(told);
    static const char *const edit[] = {"a.b=[1, 2]", "a.x.y=3",      "a.new.deep=4", "list.one.v=6",
                                       "list.2.w=7", "list.in.v={}", "none.x=8"};
    rmap_diagnostics_init(&d, "t");
    for (size_t i = 0; i < sizeof edit / sizeof edit[0]; i++)
        assert_int_equal(rmap_yaml_edit(root, edit[i], -1, &d, NULL), RMAP_OK);
    assert_int_equal(d.n, 0);
    const struct rmap_yaml_node *a = rmap_yaml_get(root, "a");
    const struct rmap_yaml_node *list = rmap_yaml_get(root, "list");
    assert_int_equal(rmap_yaml_get(a, "b")->n_item, 2);
    assert_int_equal(rmap_yaml_get(a, "b")->line, -1);
    assert_string_equal(rmap_yaml_get(a, "x.y")->text, "3");
    assert_string_equal(rmap_yaml_get(rmap_yaml_get(a, "new"), "deep")->text, "4");
    assert_string_equal(rmap_yaml_get(list->item[0].value, "v")->text, "6");
    assert_string_equal(rmap_yaml_get(list->item[1].value, "w")->text, "7");
    const struct rmap_yaml_node *in = rmap_yaml_get(list->item[1].value, "objects")->item[0].value;
    assert_int_equal(rmap_yaml_get(in, "v")->kind, RMAP_YAML_MAP);
    assert_string_equal(rmap_yaml_get(rmap_yaml_get(root, "none"), "x")->text, "8");

    static const char *const wrong[] = {"", "=1", "a..b=1", ".a=1", "a.=1", "list.3=1", "a.b.9=1"};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        assert_int_equal(rmap_yaml_edit(root, wrong[i], -1, &d, NULL), RMAP_OK);
        assert_int_equal(d.n_error, i + 1);
    }
    rmap_diagnostics_fini(&d);
    rmap_yaml_destroy(root);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_places),
        cmocka_unit_test(test_refusals),
        cmocka_unit_test(test_depth),
        cmocka_unit_test(test_aliases_cannot_explode),
        cmocka_unit_test(test_aliases_are_copies),
        cmocka_unit_test(test_duplicate_keys),
        cmocka_unit_test(test_edit),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

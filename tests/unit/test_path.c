/* SPDX-License-Identifier: MIT
 *
 * path("..."): every sign of the expressions on histories written by hand, and random expressions
 * against a matcher of another kind, which walks over the expression's tree with sets of places.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "base/alloc.h"
#include "tests/criterion_letters.h"
#include "tests/criterion_scene.h"

enum { N_RAY = 14, ALL = (1 << N_RAY) - 1 };
#define RAY(i) (1u << (i))

struct test_path {
    struct test_scene scene;
    struct rmap_portion *portion;
};

/* A row of a ray's history: a step, or a registration on `object` when its event is HIT or MISS
 * (crossed only), on the segment of the next step or, behind the last, of that one. */
enum { HIT = 1 << 30, MISS = 1 << 29 };
struct row {
    int ray;
    int32_t object;
    uint32_t event;
    int16_t medium;
};

static const struct row history[] = {
    /* 0: through the lens onto the tube, on which lies the screen, by the sensor */
    {0, LENS1, T, AIR},
    {0, LENS2, T, GLASS},
    {0, SENSOR, HIT, 0},
    {0, TUBE, A, AIR},
    {0, SCREEN, HIT, 0},
    /* 1: a ghost, twice over the sensor, once only crossed */
    {1, LENS1, T, AIR},
    {1, LENS2, R, GLASS},
    {1, LENS1, R, GLASS},
    {1, LENS2, T, GLASS},
    {1, SENSOR, HIT, 0},
    {1, SENSOR, MISS, 0},
    {1, COVER, D, AIR},
    {1, NONE, X, AIR},
    /* 2: straight out */
    {2, FAR_GRID, HIT, 0},
    {2, NONE, X, AIR},
    /* 3: absorbed in ink */
    {3, ODD, T, AIR},
    {3, NONE, A, INK},
    /* 4: scattered in ink, absorbed at the cover after travelling ink */
    {4, NONE, S, INK},
    {4, COVER, A, INK},
    /* 5: total reflection, an element, fluorescence, diffuse transmission, stopped */
    {5, LENS1, I, GLASS},
    {5, COVER, O | T, AIR},
    {5, COVER, F | D, AIR},
    {5, COVER, d, AIR},
    {5, MIRROR, K | R, AIR},
    /* 6: an error */
    {6, LENS1, T | G, AIR},
    {6, LENS2, E | T, AIR},
    /* 7, 8, 9: nothing but mirrors, 1, 2 and 3 of them */
    {7, MIRROR, R, AIR},
    {8, MIRROR, R, AIR},
    {8, MIRROR, R, AIR},
    {9, MIRROR, R, AIR},
    {9, MIRROR, R, AIR},
    {9, MIRROR, R, AIR},
    /* 10: nothing at all */
    /* 11: fluorescence inside ink */
    {11, NONE, F, INK},
    {11, NONE, X, AIR},
    /* 12: curved and lettered by nothing else */
    {12, LENS1, G, AIR},
    /* 13: diffuse and specular at once is S I R T before D d */
    {13, LENS1, R | T | D, AIR},
    {13, LENS1, D | d | A, AIR},
};

static bool add_row(struct rmap_portion *p, const struct row *row, size_t n_step_left)
{
    uint32_t segment = p->ray.segment_count[p->n_row[RMAP_TABLE_RAY] - 1];
    if (!(row->event & (HIT | MISS)))
        return test_add_step(
            p,
            &(struct test_step){.object = row->object, .event = row->event, .medium = row->medium});
    return test_add_registration(
        p, &(struct test_registration){.detector = row->object,
                                       .registered = row->event == HIT,
                                       .segment = n_step_left ? segment : segment - 1});
}

static struct rmap_portion *make_portion(void)
{
    const size_t n_row = sizeof history / sizeof *history;
    struct rmap_portion *p = NULL;
    assert_int_equal(rmap_portion_create(N_RAY, 3, &p, NULL), RMAP_OK);
    size_t row = 0;
    for (int ray = 0; ray < N_RAY; ray++) {
        assert_true(test_add_ray(p, &(struct test_ray){.id = (uint64_t)ray}));
        for (; row < n_row && history[row].ray == ray; row++) {
            size_t n_left = 0;
            for (size_t i = row + 1; i < n_row && history[i].ray == ray; i++)
                n_left += !(history[i].event & (HIT | MISS));
            assert_true(add_row(p, &history[row], n_left));
        }
    }
    return p;
}

static int setup(void **state)
{
    struct test_path *t = rmap_alloc(1, sizeof *t);
    test_scene_init(&t->scene);
    t->portion = make_portion();
    *state = t;
    return 0;
}

static int teardown(void **state)
{
    struct test_path *t = *state;
    rmap_portion_destroy(t->portion);
    rmap_free(t);
    assert_int_equal(rmap_alloc_live(), 0);
    return 0;
}

static unsigned evaluate(const struct test_path *t, const char *text)
{
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    const double flux[2] = {1.0, 1.0};
    uint8_t match[N_RAY];
    if (rmap_criterion_compile(text, &t->scene.scene, &criterion, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    assert_int_equal(rmap_criterion_evaluate(criterion, t->portion, flux, match, &err), RMAP_OK);
    rmap_criterion_destroy(criterion);
    unsigned set = 0;
    for (int i = 0; i < N_RAY; i++)
        set |= (unsigned)match[i] << i;
    return set;
}

struct expected {
    const char *path;
    unsigned rays;
};

static void check(const struct test_path *t, const struct expected *table, size_t n)
{
    char text[512];
    for (size_t i = 0; i < n; i++) {
        (void)snprintf(text, sizeof text, "path(\"%s\")", table[i].path);
        unsigned set = evaluate(t, text);
        if (set != table[i].rays)
            fail_msg("%s: rays %04x, expected %04x", text, set, table[i].rays);
    }
}

#define CHECK(t, table) check(t, table, sizeof(table) / sizeof *(table))

static void letters_match_the_whole_history(void **state)
{
    static const struct expected table[] = {
        {"TTVAV", RAY(0)},   {"T T V A V", RAY(0)},
        {"TTVA", 0},         {"TVAV", 0},
        {"TRRTVDX", RAY(1)}, {"VX", RAY(2)},
        {"XV", 0},           {"TA", RAY(3)},
        {"SA", RAY(4)},      {"IOFdK", RAY(5)},
        {"TE", RAY(6)},      {"R", RAY(7)},
        {"RR", RAY(8)},      {"FX", RAY(11)},
        {"RD", RAY(13)},     {"..", RAY(2) | RAY(3) | RAY(4) | RAY(6) | RAY(8) | RAY(11) | RAY(13)},
    };
    CHECK((struct test_path *)*state, table);
}

static void a_step_has_one_letter(void **state)
{
    static const struct expected table[] = {{"IOFdR", 0}, {"ITFdK", 0}, {"IODdK", 0},
                                            {"TT", 0},    {"TD", 0},    {"RA", 0}};
    CHECK((struct test_path *)*state, table);
}

static void quantifiers_and_choices(void **state)
{
    static const struct expected table[] = {
        {"R*", RAY(7) | RAY(8) | RAY(9) | RAY(10)},
        {"R+", RAY(7) | RAY(8) | RAY(9)},
        {"R?", RAY(7) | RAY(10)},
        {"R{2}", RAY(8)},
        {"R{2,3}", RAY(8) | RAY(9)},
        {"R{2,}", RAY(8) | RAY(9)},
        {"R{0}", RAY(10)},
        {"R{0,1}", RAY(7) | RAY(10)},
        {"R{ 1 , 2 }", RAY(7) | RAY(8)},
        {"(RR)+", RAY(8)},
        {"(RR|R)R", RAY(8) | RAY(9)},
        {"(R?){3}", RAY(7) | RAY(8) | RAY(9) | RAY(10)},
        {"(R*)*", RAY(7) | RAY(8) | RAY(9) | RAY(10)},
        {"RR|VX|SA", RAY(2) | RAY(4) | RAY(8)},
        {"R|RR|RRR", RAY(7) | RAY(8) | RAY(9)},
        {"((((R))))", RAY(7)},
        {".*", ALL & ~RAY(12)}, /* no letter, and so no step of any expression */
        {".+", ALL & ~RAY(12) & ~RAY(10)},
        {".*X", RAY(1) | RAY(2) | RAY(11)},
        {"T.*", RAY(0) | RAY(1) | RAY(3) | RAY(6)},
        {".*R.*R.*", RAY(1) | RAY(8) | RAY(9)},
        {".*(R.*){2}", RAY(1) | RAY(8) | RAY(9)},
        {"(T|R)+V[DX]*", RAY(1)},
    };
    CHECK((struct test_path *)*state, table);
}

static void sets_of_letters(void **state)
{
    static const struct expected table[] = {
        {"[TR]+VDX", RAY(1)},
        {"[^A]*", RAY(1) | RAY(2) | RAY(5) | RAY(6) | RAY(7) | RAY(8) | RAY(9) | RAY(10) | RAY(11) |
                      RAY(13)},
        {"[^V]*", ALL & ~(RAY(0) | RAY(1) | RAY(2) | RAY(12))},
        {"[^EKOFSIRTDdAXV]*", RAY(10)},
        {"[ T R ] A", RAY(3)},
        {"[TR]@lens+ V.*", RAY(0) | RAY(1)},
    };
    CHECK((struct test_path *)*state, table);
}

static void names_of_steps(void **state)
{
    static const struct expected table[] = {
        {"T@lens.1 T@lens.2 V A@tube V", RAY(0)},
        {"T@lens+ .*", RAY(0) | RAY(1) | RAY(6)},
        {"T@lens.1.*", RAY(0) | RAY(1) | RAY(6)},
        {"T@housing+ VA@housing V", RAY(0)},
        {"T@'lens.*'+ .*", RAY(0) | RAY(1) | RAY(6)},
        {"T@'lens.?' E@'*'", RAY(6)},
        {"T@'odd n\xc3\xa4me' A", RAY(3)},
        {"T@'odd n\xc3\xa4me'A@ink", RAY(3)},
        {".*A@ink", RAY(3)}, /* inside it; not at the cover after travelling it */
        {"S@ink A@cover", RAY(4)},
        {"S@glass A@cover", 0},
        {".@ink .*", RAY(4)}, /* F inside ink is no step at an object, and F knows no media */
        {"[SF]@ink .*", RAY(4)},
        {".@lens.1{2}", RAY(13)},
        {"X@mirror", 0},
        {"R@mirror{2,}", RAY(8) | RAY(9)},
    };
    CHECK((struct test_path *)*state, table);
}

static void registrations(void **state)
{
    static const struct expected table[] = {
        {"T T V@sensor A V@screen", RAY(0)},
        {"T T V@screen A V@sensor", 0},
        {".* V@sensor .*", RAY(0) | RAY(1)},
        {".* V@sensor .* V@sensor .*", 0}, /* a crossing that is not registered is no V */
        {".* V@'s*' .*", RAY(0) | RAY(1)},
        {".* A@tube V@screen", RAY(0)},
        {"V@far X", RAY(2)},
        {".* .@sensor .*", RAY(0) | RAY(1)},
        {".* [TV]@sensor .*", RAY(0) | RAY(1)},
        {".* [^V]", ALL & ~(RAY(0) | RAY(10) | RAY(12))},
    };
    CHECK((struct test_path *)*state, table);
}

static void a_path_is_a_count_of_none_or_one(void **state)
{
    const struct test_path *t = *state;
    assert_int_equal(evaluate(t, "path(\"R+\") == 0"), ALL & ~(RAY(7) | RAY(8) | RAY(9)));
    assert_int_equal(evaluate(t, "path(\"R+\") >= 1"), RAY(7) | RAY(8) | RAY(9));
    assert_int_equal(evaluate(t, "path(\"R+\") in 0..1"), ALL);
    assert_int_equal(evaluate(t, "path(\"R+\") > 1"), 0);
    assert_int_equal(evaluate(t, "not path(\"R+\") and hit(mirror)"), RAY(5));
}

struct mistake {
    const char *text, *message;
};

static void mistakes_are_pointed_at(void **state)
{
    const struct test_path *t = *state;
    static const struct mistake table[] = {
        {"path(\"\")", "criterion:1:6: error: the path is empty"},
        {"path(\"  \")", "criterion:1:6: error: the path is empty"},
        {"path(T)", "criterion:1:6: error: expected a sequence in double quotes"},
        {"path(\"T\"", "criterion:1:9: error: expected ')'"},
        {"path(\"TQ\")", "criterion:1:8: error: expected a step"},
        {"path(\"Tt\")", "criterion:1:8: error: 't' is no letter of a step (did you mean 'T'"},
        {"path(\"T@\")", "criterion:1:9: error: expected a name behind '@'"},
        {"path(\"@lens\")", "criterion:1:7: error: a name follows a letter"},
        {"path(\"T@lense.1\")", "did you mean 'lens.1'?"},
        {"path(\"T@sensor\")", "'sensor' is a detector, not an object (in a path: V@sensor)"},
        {"path(\"V@lens\")", "'lens' is no detector"},
        {"path(\"T@ink\")", "'ink' is a medium; only A and S happen inside one"},
        {"path(\"V@sensr\")", "no detector named 'sensr' in this map (did you mean 'sensor'?)"},
        {"path(\"A@inx\")", "no object or medium named 'inx'"},
        {"path(\"T@'x*'\")", "no object in this map matches 'x*'"},
        {"path(\"(T\")", "criterion:1:7: error: this parenthesis is never closed"},
        {"path(\"T)\")", "criterion:1:8: error: no parenthesis is open here"},
        {"path(\"()\")", "criterion:1:8: error: expected a step"},
        {"path(\"T|\")", "criterion:1:9: error: expected a step"},
        {"path(\"*T\")", "criterion:1:7: error: there is nothing before '*' to repeat"},
        {"path(\"T**\")", "criterion:1:9: error: one quantifier behind another"},
        {"path(\"T{2,1}\")", "criterion:1:8: error: the second number is less than the first"},
        {"path(\"T{,1}\")", "criterion:1:9: error: expected a number of times"},
        {"path(\"T{1\")", "criterion:1:10: error: expected ',' or '}'"},
        {"path(\"[T\")", "criterion:1:7: error: this bracket is never closed"},
        {"path(\"[]\")", "criterion:1:7: error: no letter stands between these brackets"},
        {"path(\"[T-X]\")", "criterion:1:9: error: expected one of T R I"},
        {"path(\"T@'lens\")", "criterion:1:9: error: this quote is never closed"},
        {"path(\".{1,100000}\")", "this path is too complex"},
        {"path(\".*R.{14}\")", "this path is too complex: it needs more than 16384 states"},
        {"path(\"((((T{0}){1000000}){1000000}){1000000})\")", "this path is too complex"},
        {"path(\"T{99999999999}\")", "this path is too complex"},
    };
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        struct rmap_criterion *criterion = NULL;
        struct rmap_error err = {0};
        assert_int_equal(rmap_criterion_compile(table[i].text, &t->scene.scene, &criterion, &err),
                         RMAP_INPUT);
        if (!strstr(err.text, table[i].message))
            fail_msg("%s\n%s\nexpected: %s", table[i].text, err.text, table[i].message);
    }
}

/* ---- another matcher ---- */

enum { TREE_MAX = 64, LONGEST = 40 };

struct tree {
    enum { ATOM, SEQUENCE, CHOICE, REPEAT } kind;
    int left, right; /* nodes */
    int least, most; /* REPEAT; most -1: any */
    uint32_t events; /* ATOM: letters as first bits of events; 1 << 31: registrations */
    int32_t object;  /* -2: any */
};

struct expression {
    struct tree node[TREE_MAX];
    int n;
    char text[4096];
};

static uint64_t next_random(uint64_t *random)
{
    *random ^= *random << 13;
    *random ^= *random >> 7;
    *random ^= *random << 17;
    return *random;
}

#define HITS (1u << 31)
static const struct {
    const char *text;
    uint32_t events;
    int32_t object;
} atom_table[] = {
    {"T", T, -2},
    {"R", R, -2},
    {".", ~0u, -2},
    {"[TR]", T | R, -2},
    {"V", HITS, -2},
    {"[^A]", ~(uint32_t)A, -2},
    {"T@lens.1", T, LENS1},
    {".@lens.2", ~HITS, LENS2},
    {"V@sensor", HITS, SENSOR},
    {"A", A, -2},
    {"R@mirror", R, MIRROR},
    {"[VX]", HITS | X, -2},
};

static int grow(struct expression *e, uint64_t *random, int depth)
{
    if (e->n + 4 >= TREE_MAX)
        depth = 0;
    int index = e->n++;
    struct tree node = {.kind = ATOM, .left = -1, .right = -1};
    unsigned pick = depth > 0 ? (unsigned)(next_random(random) % 8) : 0;
    size_t len = strlen(e->text);
    char *to = e->text + len;
    size_t room = sizeof e->text - len;
    if (pick < 2) {
        size_t atom = next_random(random) % (sizeof atom_table / sizeof *atom_table);
        node.events = atom_table[atom].events;
        node.object = atom_table[atom].object;
        (void)snprintf(to, room, "%s", atom_table[atom].text);
    } else if (pick < 6) {
        node.kind = pick < 5 ? SEQUENCE : CHOICE;
        (void)snprintf(to, room, "(");
        node.left = grow(e, random, depth - 1);
        strncat(e->text, node.kind == CHOICE ? "|" : " ", sizeof e->text - strlen(e->text) - 1);
        node.right = grow(e, random, depth - 1);
        strncat(e->text, ")", sizeof e->text - strlen(e->text) - 1);
    } else {
        static const struct {
            const char *text;
            int least, most;
        } times[] = {{"*", 0, -1}, {"+", 1, -1}, {"?", 0, 1}, {"{2}", 2, 2}, {"{1,3}", 1, 3}};
        size_t k = next_random(random) % (sizeof times / sizeof *times);
        node.kind = REPEAT;
        node.least = times[k].least;
        node.most = times[k].most;
        (void)snprintf(to, room, "(");
        node.left = grow(e, random, depth - 1);
        strncat(e->text, ")", sizeof e->text - strlen(e->text) - 1);
        strncat(e->text, times[k].text, sizeof e->text - strlen(e->text) - 1);
    }
    e->node[index] = node;
    return index;
}

/* One ray's history as the definition has it. */
struct word {
    int n;
    uint32_t event[LONGEST]; /* one letter's bit, or HITS */
    int32_t object[LONGEST];
};

/* Places reached from a set of places (bit p: p letters are read). */
static uint64_t reach(const struct expression *e, int index, const struct word *word, uint64_t from)
{
    const struct tree *node = &e->node[index];
    uint64_t to = 0;
    switch (node->kind) {
    case ATOM:
        for (int i = 0; i < word->n; i++) {
            bool is_hit = word->event[i] == HITS;
            bool fits = word->event[i] & node->events &&
                        (node->object == -2 ||
                         (word->object[i] == node->object && is_hit == (node->events == HITS)));
            if (from >> i & 1 && fits)
                to |= (uint64_t)1 << (i + 1);
        }
        return to;
    case SEQUENCE:
        return reach(e, node->right, word, reach(e, node->left, word, from));
    case CHOICE:
        return reach(e, node->left, word, from) | reach(e, node->right, word, from);
    case REPEAT:
        break;
    }
    for (int i = 0; from && (node->most < 0 || i <= node->most); i++) {
        if (i >= node->least) {
            from &= ~to; /* what follows those is known */
            to |= from;
        }
        from = reach(e, node->left, word, from);
    }
    return to;
}

enum { RANDOM_RAYS = 300 };

/* Random rays of 0 to 12 steps with registrations before some of them. */
static struct rmap_portion *random_portion(uint64_t *random, struct word *word)
{
    static const uint32_t event[] = {T, T, T, R, R, A, X, D};
    struct rmap_portion *p = NULL;
    assert_int_equal(rmap_portion_create(RANDOM_RAYS, 3, &p, NULL), RMAP_OK);
    for (int ray = 0; ray < RANDOM_RAYS; ray++) {
        struct word *its = &word[ray];
        assert_true(test_add_ray(p, &(struct test_ray){.id = (uint64_t)ray}));
        its->n = 0;
        uint32_t n_step = (uint32_t)(next_random(random) % 13);
        for (uint32_t step = 0; step < n_step; step++) {
            int32_t object = (int32_t)(next_random(random) % 6);
            uint32_t what = event[next_random(random) % 8];
            if (next_random(random) % 5 == 0) {
                int32_t detector = next_random(random) % 2 ? SENSOR : FAR_GRID;
                assert_true(test_add_registration(
                    p, &(struct test_registration){
                           .detector = detector, .registered = 1, .segment = step}));
                its->object[its->n] = detector;
                its->event[its->n++] = HITS;
            }
            assert_true(test_add_step(p, &(struct test_step){.object = object, .event = what}));
            its->object[its->n] = object;
            its->event[its->n++] = what;
        }
    }
    return p;
}

static void random_expressions_agree_with_another_matcher(void **state)
{
    const struct test_path *t = *state;
    const double flux[2] = {1.0, 1.0};
    static struct word word[RANDOM_RAYS];
    static struct expression e;
    uint64_t random = 20261121;
    struct rmap_portion *portion = random_portion(&random, word);
    size_t n_match = 0;
    for (int turn = 0; turn < 3000; turn++) {
        struct rmap_criterion *criterion = NULL;
        struct rmap_error err = {0};
        uint8_t match[RANDOM_RAYS];
        char text[sizeof e.text + 16];
        e.n = 0;
        e.text[0] = 0;
        (void)grow(&e, &random, 5);
        (void)snprintf(text, sizeof text, "path(\"%s\")", e.text);
        if (rmap_criterion_compile(text, &t->scene.scene, &criterion, &err) != RMAP_OK)
            fail_msg("%s\n%s", text, err.text);
        assert_int_equal(rmap_criterion_evaluate(criterion, portion, flux, match, &err), RMAP_OK);
        for (int ray = 0; ray < RANDOM_RAYS; ray++) {
            bool expected = reach(&e, 0, &word[ray], 1) >> word[ray].n & 1;
            n_match += expected;
            if (match[ray] != expected)
                fail_msg("turn %d, ray %d: %s is %d, expected %d", turn, ray, text, match[ray],
                         expected);
        }
        rmap_criterion_destroy(criterion);
    }
    assert_true(n_match > 10000);
    rmap_portion_destroy(portion);
}

/* Rays longer than what is handled at a time, and none in between. */
static void long_rays_and_empty_ones(void **state)
{
    const struct test_path *t = *state;
    const double flux[2] = {1.0, 1.0};
    struct rmap_portion *p = NULL;
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[5];
    static const uint32_t length[5] = {0, 20000, 0, 20001, 3};
    assert_int_equal(rmap_portion_create(5, 3, &p, NULL), RMAP_OK);
    for (int ray = 0; ray < 5; ray++) {
        assert_true(test_add_ray(p, &(struct test_ray){.id = (uint64_t)ray}));
        for (uint32_t i = 0; i < length[ray]; i++)
            assert_true(test_add_step(p, &(struct test_step){.object = MIRROR, .event = R}));
    }
    assert_int_equal(rmap_criterion_compile("path(\"(RR)*\")", &t->scene.scene, &criterion, &err),
                     RMAP_OK);
    assert_int_equal(rmap_criterion_evaluate(criterion, p, flux, match, &err), RMAP_OK);
    assert_memory_equal(match, ((uint8_t[]){1, 1, 1, 0, 0}), 5);
    rmap_criterion_destroy(criterion);
    rmap_portion_destroy(p);
}

static void memory_may_run_short(void **state)
{
    const struct test_path *t = *state;
    const double flux[2] = {1.0, 1.0};
    int n_failed = 0;
    for (int64_t at = 1; at < 1000; at++) {
        struct rmap_criterion *criterion = NULL;
        struct rmap_error err = {0};
        uint8_t match[N_RAY];
        rmap_alloc_fail_at(at);
        enum rmap_status st = rmap_criterion_compile(
            "path(\"T@'lens.*'+ ([RI]@lens|A@ink{1,3})* V.*\")", &t->scene.scene, &criterion, &err);
        if (st == RMAP_OK)
            st = rmap_criterion_evaluate(criterion, t->portion, flux, match, &err);
        rmap_alloc_fail_at(0);
        rmap_criterion_destroy(criterion);
        if (st == RMAP_OK)
            break;
        assert_int_equal(st, RMAP_SYSTEM);
        n_failed++;
    }
    assert_in_range(n_failed, 15, 900);
}

/* Numbers that no scene has, as a damaged map may hold them. */
static void foreign_numbers_match_no_name(void **state)
{
    const struct test_path *t = *state;
    struct test_path other = {.scene = t->scene};
    static const int32_t object[] = {6, INT32_MAX, INT32_MIN, -7};
    const double flux[2] = {1.0, 1.0};
    struct rmap_portion *p = NULL;
    struct rmap_criterion *criterion = NULL;
    struct rmap_error err = {0};
    uint8_t match[4];
    assert_int_equal(rmap_portion_create(4, 3, &p, NULL), RMAP_OK);
    for (int ray = 0; ray < 4; ray++) {
        assert_true(test_add_ray(p, &(struct test_ray){.id = (uint64_t)ray}));
        assert_true(test_add_registration(p, &(struct test_registration){.detector = object[ray],
                                                                         .registered = 1,
                                                                         .segment = UINT32_MAX}));
        assert_true(test_add_step(p, &(struct test_step){.object = object[ray],
                                                         .event = A | ~0x1fffu,
                                                         .medium = INT16_MIN}));
    }
    assert_int_equal(
        rmap_criterion_compile("path(\".* .@'*' .*\")", &other.scene.scene, &criterion, &err),
        RMAP_OK);
    assert_int_equal(rmap_criterion_evaluate(criterion, p, flux, match, &err), RMAP_OK);
    assert_memory_equal(match, ((uint8_t[]){0, 0, 0, 0}), 4);
    rmap_criterion_destroy(criterion);
    rmap_portion_destroy(p);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(letters_match_the_whole_history, setup, teardown),
        cmocka_unit_test_setup_teardown(a_step_has_one_letter, setup, teardown),
        cmocka_unit_test_setup_teardown(quantifiers_and_choices, setup, teardown),
        cmocka_unit_test_setup_teardown(sets_of_letters, setup, teardown),
        cmocka_unit_test_setup_teardown(names_of_steps, setup, teardown),
        cmocka_unit_test_setup_teardown(registrations, setup, teardown),
        cmocka_unit_test_setup_teardown(a_path_is_a_count_of_none_or_one, setup, teardown),
        cmocka_unit_test_setup_teardown(mistakes_are_pointed_at, setup, teardown),
        cmocka_unit_test_setup_teardown(random_expressions_agree_with_another_matcher, setup,
                                        teardown),
        cmocka_unit_test_setup_teardown(long_rays_and_empty_ones, setup, teardown),
        cmocka_unit_test_setup_teardown(memory_may_run_short, setup, teardown),
        cmocka_unit_test_setup_teardown(foreign_numbers_match_no_name, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

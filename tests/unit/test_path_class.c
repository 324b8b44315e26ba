/* SPDX-License-Identifier: MIT
 *
 * Classes of paths: on random histories each class's criterion selects exactly its rays, at every
 * level; labels, ranks and orders.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/criterion/criterion.h"
#include "analysis/criterion/path_order.h"
#include "analysis/paths/path_class.h"
#include "base/alloc.h"
#include "tests/criterion_letters.h"
#include "tests/criterion_scene.h"

enum { N_RAY = 1200 };

static const double flux_per_weight[] = {0.5, 0.25};

/* The scene's media 1 and 2 have names of an object and of a group. */
static void make_scene(struct test_scene *t)
{
    static const int32_t line[6] = {1, 2, 1, 3, 4, 5};
    test_scene_init(t);
    for (int i = 0; i < 6; i++)
        t->object[i].line = line[i];
    t->medium[1].name = test_name(t, "mirror");
    t->medium[2].name = test_name(t, "housing");
    t->medium[1].absorbing = t->medium[2].scattering_at_all = true;
}

static uint32_t draw(uint64_t *state, uint32_t n)
{
    *state = *state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (uint32_t)((*state >> 33) % n);
}

static void add_hit(struct rmap_portion *p, int32_t detector, uint32_t segment, uint32_t registered)
{
    assert_true(test_add_registration(
        p, &(struct test_registration){
               .detector = detector, .segment = segment, .registered = (uint8_t)registered}));
}

/* A segment that goes on, and what detectors see of it. */
static void add_segment(struct rmap_portion *p, uint64_t *state, uint32_t segment)
{
    static const uint32_t event[] = {T, R, I, D, T | G};
    struct test_step step = {.object = (int32_t)draw(state, 6), .medium = (int16_t)draw(state, 3)};
    step.event = event[draw(state, 5)];
    if (draw(state, 6) == 0) {
        step.object = -1;
        step.event = S;
    }
    if (draw(state, 5) == 0)
        add_hit(p, SENSOR, segment, draw(state, 3) > 0);
    assert_true(test_add_step(p, &step));
    if (step.object == TUBE && draw(state, 2) == 0)
        add_hit(p, SCREEN, segment, draw(state, 3) > 0);
}

static void add_end(struct rmap_portion *p, uint64_t *state, uint32_t segment)
{
    static const uint32_t event[] = {A, A, X, K, E};
    static const uint8_t stop[] = {RMAP_STOP_ABSORBED, RMAP_STOP_ABSORBED, RMAP_STOP_LEFT,
                                   RMAP_STOP_LIMIT, RMAP_STOP_ERROR};
    struct test_step step = {.object = (int32_t)draw(state, 7) - 1,
                             .medium = (int16_t)draw(state, 3)};
    const uint32_t k = draw(state, 5);
    step.event = event[k];
    if (step.event == X)
        step.object = -1;
    p->ray.stop[p->n_row[RMAP_TABLE_RAY] - 1] = stop[k];
    if (step.event == X && draw(state, 2) == 0)
        add_hit(p, FAR_GRID, segment, 1);
    assert_true(test_add_step(p, &step));
    if (step.object == TUBE && draw(state, 2) == 0)
        add_hit(p, SCREEN, segment, 1);
}

static struct rmap_portion *make_rays(void)
{
    struct rmap_portion *p = NULL;
    uint64_t state = 2026;
    assert_int_equal(rmap_portion_create(N_RAY, 3, &p, NULL), RMAP_OK);
    p->first_ray = 100;
    for (uint64_t i = 0; i < N_RAY; i++) {
        const struct test_ray ray = {
            .id = 100 + i, .source = (int32_t)draw(&state, 2), .weight = 1.0};
        uint32_t n = draw(&state, 4), segment = 0;
        assert_true(test_add_ray(p, &ray));
        for (; segment < n; segment++)
            add_segment(p, &state, segment);
        if (draw(&state, 50) > 0)
            add_end(p, &state, segment);
    }
    return p;
}

/* The class's criterion and its rays. */
static void check_class(const struct rmap_path_classes *classes, size_t k,
                        const struct rmap_scene *scene, const struct rmap_portion *p)
{
    struct rmap_error err = {0};
    struct rmap_criterion *criterion = NULL;
    uint8_t *match = rmap_alloc(N_RAY, 1);
    char *text = NULL;
    size_t n = 0;
    assert_non_null(match);
    assert_int_equal(rmap_path_class_criterion(classes, k, &text, &err), RMAP_OK);
    assert_non_null(text);
    if (rmap_criterion_compile(text, scene, &criterion, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    assert_int_equal(rmap_criterion_evaluate(criterion, p, flux_per_weight, match, &err), RMAP_OK);
    for (size_t i = 0; i < N_RAY; i++) {
        if (match[i] != (classes->of_ray[i] == k))
            fail_msg("ray %zu, class %zu: %s", i, k, text);
        n += match[i];
    }
    assert_int_equal(n, classes->path[k].rays);
    rmap_criterion_destroy(criterion);
    rmap_free(match);
    rmap_free(text);
}

static void check_view(const struct rmap_path_view *view, const struct rmap_portion *p,
                       struct test_scene *t, size_t *n_ret)
{
    struct rmap_error err = {0};
    struct rmap_path_classes *classes = NULL;
    size_t n_ray = 0;
    assert_int_equal(rmap_path_classes_create(&t->scene, view, p, flux_per_weight, &classes, &err),
                     RMAP_OK);
    for (size_t k = 0; k < classes->n; k++) {
        const struct rmap_path_class *path = &classes->path[k];
        n_ray += path->rays;
        assert_true(path->flux == flux_per_weight[path->source] * (double)path->rays);
        if (k > 0)
            assert_true(path->flux < path[-1].flux ||
                        (path->flux == path[-1].flux && path->first_ray > path[-1].first_ray));
        check_class(classes, k, &t->scene, p);
    }
    if (view->until_detector)
        assert_true(n_ray > 0 && n_ray < N_RAY);
    else
        assert_int_equal(n_ray, N_RAY);
    *n_ret = classes->n;
    rmap_path_classes_destroy(classes);
}

static void test_every_class_is_exactly_its_criterion(void **state)
{
    (void)state;
    struct test_scene t;
    make_scene(&t);
    struct rmap_portion *p = make_rays();
    size_t n[4][RMAP_PATH_LEVEL_COUNT];
    for (int level = 0; level < RMAP_PATH_LEVEL_COUNT; level++)
        for (int way = 0; way < 4; way++)
            for (int32_t detector = -1; detector < 3; detector++) {
                const struct rmap_path_view view = {.level = (enum rmap_path_level)level,
                                                    .without_events = way & 1,
                                                    .collapsed = way & 2,
                                                    .until_detector = detector >= 0,
                                                    .detector = detector};
                size_t n_class = 0;
                check_view(&view, p, &t, &n_class);
                if (detector < 0)
                    n[way][level] = n_class;
            }
    for (int way = 0; way < 4; way++) {
        assert_true(n[way][RMAP_PATH_OBJECT] < n[way][RMAP_PATH_SURFACE]);
        assert_true(n[way][RMAP_PATH_GROUP] < n[way][RMAP_PATH_OBJECT]);
    }
    assert_true(n[1][0] < n[0][0] && n[2][0] < n[0][0] && n[3][0] < n[1][0]);
    rmap_portion_destroy(p);
}

static char *label_of(const struct test_scene *t, const struct rmap_path_view *view,
                      const struct rmap_portion *p, size_t most)
{
    struct rmap_path_classes *classes = NULL;
    char *text = NULL;
    assert_int_equal(rmap_path_classes_create(&t->scene, view, p, flux_per_weight, &classes, NULL),
                     RMAP_OK);
    assert_int_equal(rmap_path_class_label(classes, 0, most, &text, NULL), RMAP_OK);
    rmap_path_classes_destroy(classes);
    return text;
}

static void test_labels(void **state)
{
    (void)state;
    static const struct {
        struct rmap_path_view view;
        size_t most;
        const char *text;
    } table[] = {
        {{.level = RMAP_PATH_SURFACE},
         0,
         "lamp: T@lens.1 R@lens.2 T@lens.1 V@sensor T@'odd n\xc3\xa4me'{2} A@tube V@screen"},
        {{.level = RMAP_PATH_SURFACE}, 40, "lamp: T@lens.1 R@lens.2 T@lens.1 ... V@screen"},
        {{.level = RMAP_PATH_OBJECT, .without_events = true},
         0,
         "lamp: .@lens{3} V@sensor .@'odd n\xc3\xa4me'{2} .@tube V@screen"},
        {{.level = RMAP_PATH_GROUP, .without_events = true, .collapsed = true},
         0,
         "lamp: [^SV]@housing V@sensor .@'odd n\xc3\xa4me' [^SV]@housing V@screen"},
        {{.until_detector = true, .detector = SENSOR},
         0,
         "lamp: T@lens.1 R@lens.2 T@lens.1 V@sensor"},
    };
    static const struct test_step step[] = {{LENS1, 0, T, AIR}, {LENS2, 0, R, AIR},
                                            {LENS1, 0, T, AIR}, {ODD, 0, T, AIR},
                                            {ODD, 0, T, AIR},   {TUBE, 0, A, AIR}};
    struct test_scene t;
    struct rmap_portion *p = NULL;
    make_scene(&t);
    assert_int_equal(rmap_portion_create(1, 3, &p, NULL), RMAP_OK);
    assert_true(test_add_ray(p, &(struct test_ray){.weight = 1.0}));
    for (size_t i = 0; i < sizeof step / sizeof *step; i++)
        assert_true(test_add_step(p, &step[i]));
    add_hit(p, SENSOR, 3, 1);
    add_hit(p, SENSOR, 4, 0);
    add_hit(p, SCREEN, 5, 1);
    for (size_t i = 0; i < sizeof table / sizeof *table; i++) {
        char *text = label_of(&t, &table[i].view, p, table[i].most);
        assert_string_equal(text, table[i].text);
        rmap_free(text);
    }
    rmap_portion_destroy(p);
}

/* Reflections at lens, 'odd' (a mixture that transmits) and mirror (likewise); not at the cover. */
static void test_orders(void **state)
{
    (void)state;
    const struct test_step step[] = {{LENS1, 0, R, AIR}, {COVER, 0, R, AIR}, {COVER, 0, D, AIR},
                                     {-1, 0, S, AIR},    {LENS2, 0, I, AIR}, {ODD, 0, R, AIR},
                                     {TUBE, 0, d, AIR}};
    struct test_scene t;
    struct rmap_portion *p = NULL;
    struct rmap_path_order order;
    uint32_t ghost[3], scatter[3];
    test_scene_init(&t);
    assert_int_equal(rmap_path_order_init(&order, &t.scene, NULL), RMAP_OK);
    assert_int_equal(rmap_portion_create(1, 3, &p, NULL), RMAP_OK);
    assert_true(test_add_ray(p, &(struct test_ray){.weight = 1.0}));
    for (size_t i = 0; i < sizeof step / sizeof *step; i++)
        assert_true(test_add_step(p, &step[i]));
    add_hit(p, SENSOR, 1, 1);
    add_hit(p, SENSOR, 3, 1);
    add_hit(p, SCREEN, 6, 1);
    rmap_path_orders_of_rays(&order, p, ghost, scatter);
    assert_int_equal(ghost[0], 2);
    assert_int_equal(scatter[0], 3);
    rmap_path_orders_of_registrations(&order, p, ghost, scatter);
    assert_int_equal(ghost[0] * 10 + scatter[0], 10);
    assert_int_equal(ghost[1] * 10 + scatter[1], 11);
    assert_int_equal(ghost[2] * 10 + scatter[2], 22);
    rmap_portion_destroy(p);
    rmap_path_order_fini(&order);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_every_class_is_exactly_its_criterion),
        cmocka_unit_test(test_labels),
        cmocka_unit_test(test_orders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

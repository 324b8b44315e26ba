/* SPDX-License-Identifier: MIT
 *
 * The recorder of one ray: keeps everything in order, can be used again, and says when memory
 * ran short. Sums: their block fails whole.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "hand_scene.h"
#include "portion/history.h"
#include "trace/tally.h"

/* A ray of n steps with a registration each; step k has colour (k, -k). */
static void tell(struct rmap_recorder *recorder, uint64_t ray, int n)
{
    double colour[2] = {0.0, 0.0};
    struct rmap_emission emission = {.ray = ray, .object = -1, .colour = colour};
    recorder->emit(recorder, &emission);
    for (int k = 1; k <= n; k++) {
        colour[0] = k;
        colour[1] = -k;
        struct rmap_step step = {.object = k, .colour = colour};
        struct rmap_registration registration = {.segment = (uint32_t)k - 1};
        recorder->step(recorder, &step);
        recorder->registration(recorder, &registration);
    }
    struct rmap_ending ending = {.stop = RMAP_STOP_LIMIT, .path_length = n};
    recorder->end(recorder, &ending);
}

static void keeps_all_in_order(void **state)
{
    (void)state;
    struct rmap_history history;
    rmap_history_init(&history, 2);
    for (int n = 100; n > 0; n -= 33) {
        tell(&history.base, (uint64_t)n, n);
        assert_int_equal(history.status, RMAP_OK);
        assert_int_equal(history.emission.ray, n);
        assert_int_equal(history.n_step, n);
        assert_int_equal(history.n_registration, n);
        assert_true(history.ending.path_length == n);
        for (int k = 1; k <= n; k++) {
            assert_int_equal(history.step[k - 1].object, k);
            assert_true(history.step[k - 1].colour[0] == k);
            assert_true(history.step[k - 1].colour[1] == -k);
            assert_int_equal(history.registration[k - 1].segment, k - 1);
        }
    }
    rmap_history_fini(&history);
}

static void memory_runs_short(void **state)
{
    (void)state;
    int64_t before = rmap_alloc_live();
    int failures = 0;
    for (int64_t fail_at = 1;; fail_at++) {
        struct rmap_history history;
        rmap_history_init(&history, 2);
        rmap_alloc_fail_at(fail_at);
        tell(&history.base, 1, 100);
        rmap_alloc_fail_at(0);
        enum rmap_status st = history.status;
        assert_true(st == RMAP_SYSTEM || history.n_step == 100);
        tell(&history.base, 1, 100); /* and it recovers with the next ray */
        assert_int_equal(history.status, RMAP_OK);
        assert_int_equal(history.n_step, 100);
        rmap_history_fini(&history);
        assert_int_equal(rmap_alloc_live(), before);
        if (st == RMAP_OK)
            break;
        failures++;
    }
    assert_true(failures >= 6);
}

static void sums_of_no_size(void **state)
{
    (void)state;
    struct rmap_scene *scene = hand_scene(1);
    hand_source(scene, RMAP_SOURCE_POINT, rmap_vec3(0, 0, 0), rmap_vec3(0, 0, 1));
    struct rmap_detector *detector = hand_detector(scene, rmap_vec3(0, 0, 0), 1.0, 1.0);
    struct rmap_tally *tally = NULL;
    struct rmap_error err = {0};
    int64_t before = rmap_alloc_live();
    for (int64_t fail_at = 1; fail_at <= 3; fail_at++) {
        rmap_alloc_fail_at(fail_at);
        assert_int_equal(rmap_tally_create(scene, &tally, &err), RMAP_SYSTEM);
        rmap_alloc_fail_at(0);
    }
    detector->cells[0] = detector->cells[1] = UINT32_MAX; /* cells that do not fit */
    assert_int_equal(rmap_tally_create(scene, &tally, &err), RMAP_SYSTEM);
    assert_int_equal(rmap_alloc_live(), before);
    rmap_scene_destroy(scene);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(keeps_all_in_order),
        cmocka_unit_test(memory_runs_short),
        cmocka_unit_test(sums_of_no_size),
    };
    return cmocka_run_group_tests_name("history", test, NULL, NULL);
}

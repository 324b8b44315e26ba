/* SPDX-License-Identifier: MIT
 *
 * Numbers picked by the turns of a cycle: as one at a time are.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/turns.h"

enum { N = 700 };

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

/* Memory of just this size, so that tools see who reads or writes beyond it. */
static double *room_for(size_t n)
{
    double *room = malloc(n * sizeof *room + 1);
    assert_non_null(room);
    return room;
}

static void compare(const int32_t *cycle, size_t period, size_t phase, size_t n)
{
    double *value = room_for(n);
    for (size_t k = 0; k < n; k++)
        value[k] = (double)(k + 1);
    for (int32_t which = 0; which < 4; which++) {
        struct rmap_turns turns;
        double wanted[N];
        size_t n_wanted = 0;
        for (size_t k = 0; k < n; k++)
            if (cycle[(k + phase) % period] == which)
                wanted[n_wanted++] = value[k];
        double *to = room_for(n_wanted);
        rmap_turns_init(&turns, cycle, period, phase, which);
        assert_int_equal(rmap_turns_pick(&turns, value, n, to), n_wanted);
        assert_memory_equal(to, wanted, n_wanted * sizeof *to);
        free(to);
    }
    free(value);
}

static void test_cycles(void **state)
{
    (void)state;
    uint32_t random = 7;
    for (int round = 0; round < 3000; round++) {
        int32_t cycle[RMAP_TURNS_MOST];
        const size_t period = 1 + next(&random) % RMAP_TURNS_MOST;
        const uint32_t one_in = 1 + next(&random) % 4; /* some take no turn, or all */
        for (size_t k = 0; k < period; k++)
            cycle[k] = (int32_t)(next(&random) % one_in);
        compare(cycle, period, next(&random) % period, next(&random) % N);
    }
}

/* One in few and one in many: near and far apart. */
static void test_shares(void **state)
{
    (void)state;
    for (size_t period = 2; period <= RMAP_TURNS_MOST; period++)
        for (size_t at = 0; at < period; at += 1 + period / 5) {
            int32_t cycle[RMAP_TURNS_MOST] = {0};
            cycle[at] = 1;
            compare(cycle, period, 0, N - 1);
        }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_cycles),
                                       cmocka_unit_test(test_shares)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

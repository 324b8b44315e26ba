/* SPDX-License-Identifier: MIT
 *
 * Numbers picked four at a time: as one at a time picks them.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/pick.h"

enum { N = 300 };

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static void test_pick(void **state)
{
    (void)state;
    uint32_t random = 5;
    for (int round = 0; round < 400; round++) {
        double value[N], wanted[N], to[N + RMAP_PICK_MORE];
        uint8_t match[N];
        int32_t of[N];
        const size_t n = next(&random) % (N + 1);
        const uint32_t one_in = 1 + next(&random) % 5;
        size_t n_wanted = 0;
        for (size_t k = 0; k < n; k++) {
            value[k] = (double)next(&random) - 1e6;
            of[k] = (int32_t)(next(&random) % one_in) - 1;
            match[k] = of[k] == -1;
            wanted[n_wanted] = value[k];
            n_wanted += match[k];
        }
        assert_int_equal(rmap_pick_count(match, n), n_wanted);
        assert_int_equal(rmap_pick_matching(value, match, n, to), n_wanted);
        assert_memory_equal(to, wanted, n_wanted * sizeof *to);
        memset(to, 0, sizeof to);
        assert_int_equal(rmap_pick_of(value, of, -1, n, to), n_wanted);
        assert_memory_equal(to, wanted, n_wanted * sizeof *to);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_pick)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * A set of ray ids, added in any order and twice, against a flag per id.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/id_set.h"

enum { N = 3000 };

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static void test_against_flags(void **state)
{
    (void)state;
    uint32_t random = 27;
    for (int round = 0; round < 60; round++) {
        const uint64_t base = round % 3 == 0 ? UINT64_MAX - N + 1 : (uint64_t)round;
        uint8_t flag[N] = {0}, inside[N];
        uint64_t id[N], count = 0;
        struct rmap_id_set set = {0}, more = {0};
        for (uint32_t k = next(&random) % (round < 30 ? 20 : 2 * N); k > 0; k--) {
            const uint32_t i = next(&random) % N;
            flag[i] = 1;
            assert_int_equal(rmap_id_set_add(k % 2 ? &set : &more, base + i, NULL), RMAP_OK);
        }
        assert_int_equal(rmap_id_set_add_words(&set, more.at, more.n, NULL), RMAP_OK);
        rmap_id_set_settle(&set);
        for (uint64_t i = 0; i < N; i++) {
            id[i] = base + i;
            count += flag[i];
        }
        assert_int_equal(rmap_id_set_count(&set), count);
        rmap_id_set_mark(&set, id, N, inside);
        assert_memory_equal(inside, flag, N);
        for (size_t i = 0; i < N; i++) /* ids that do not ascend */
            id[i] = base + next(&random) % N;
        rmap_id_set_mark(&set, id, N, inside);
        for (size_t i = 0; i < N; i++)
            assert_int_equal(inside[i], flag[id[i] - base]);
        for (int k = 0; k < 200; k++) {
            const size_t first = next(&random) % N, n = 1 + next(&random) % 150;
            const size_t last = first + n < N ? first + n - 1 : N - 1;
            assert_int_equal(rmap_id_set_meets(&set, base + first, base + last),
                             memchr(flag + first, 1, last - first + 1) != NULL);
        }
        rmap_id_set_fini(&more);
        rmap_id_set_fini(&set);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_against_flags)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

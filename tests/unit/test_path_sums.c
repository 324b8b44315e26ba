/* SPDX-License-Identifier: MIT
 *
 * Sums by keys: what was put in is what is there, however much it is. Keys of paths.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/paths/path_key.h"
#include "analysis/table/key_sums.h"
#include "base/alloc.h"

static struct rmap_key key_of(uint64_t number)
{
    return (struct rmap_key){number % 7, number / 7 + 1};
}

/* Keys come three times each; no more than the most are taken, whichever came first. */
static void test_sums(void **state)
{
    (void)state;
    static const size_t mosts[] = {1, 2, 1023, 1024, 1025, 12288, 12289, 50000};
    for (size_t m = 0; m < sizeof mosts / sizeof *mosts; m++) {
        const size_t most = mosts[m];
        struct rmap_key_sums sums;
        struct rmap_error err;
        struct rmap_key_sum *sum;
        rmap_key_sums_init(&sums, most);
        assert_null(rmap_key_sums_find(&sums, key_of(0)));
        for (size_t k = 0; k < 3 * (most + 10); k++) {
            const size_t number = k % (most + 10);
            assert_int_equal(rmap_key_sums_enter(&sums, key_of(number), &sum, &err), RMAP_OK);
            assert_int_equal(sum != NULL, number < most);
            if (sum)
                sum->number[0] += number + 1;
        }
        assert_int_equal(sums.n, most);
        for (size_t k = 0; k < most; k++) {
            sum = rmap_key_sums_find(&sums, key_of(k));
            assert_ptr_equal(sum, &sums.entry[k]);
            assert_int_equal(sum->number[0], 3 * (k + 1));
        }
        rmap_key_sums_fini(&sums);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Paths that differ in a step, its place, their length or their source have other keys. */
static void test_keys(void **state)
{
    (void)state;
    enum { N = 40 };
    rmap_path_step step[N] = {0};
    struct rmap_key seen[4 * N];
    size_t n_seen = 0;
    for (size_t n = 0; n < N; n++) {
        seen[n_seen++] = rmap_path_key_hash(step, n, 0);
        seen[n_seen++] = rmap_path_key_hash(step, n, 1);
        step[n] = 17;
        seen[n_seen++] = rmap_path_key_hash(step, N, 5);
        step[n] = 18;
        seen[n_seen++] = rmap_path_key_hash(step, N, 5);
        step[n] = 0;
    }
    for (size_t a = 0; a < n_seen; a++)
        for (size_t b = 0; b < a; b++)
            assert_false(rmap_keys_equal(seen[a], seen[b]));
    assert_int_equal(rmap_path_source_of(rmap_path_key_hash(step, 3, 1048575)), 1048575);
    assert_true(rmap_keys_equal(rmap_path_key_hash(step, N, 1), rmap_path_key_hash(step, N, 1)));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sums), cmocka_unit_test(test_keys)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

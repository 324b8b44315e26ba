/* SPDX-License-Identifier: MIT
 *
 * Sums by keys, and the steps of classes: what was put in is what is there, however much it is.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/key_sums.h"
#include "analysis/path_steps.h"
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

static size_t length_of(size_t class, size_t longest)
{
    return longest == 1 ? 1 : class * 2654435761u % (longest + 1);
}

/* Filled to the last word, and beyond: what was taken stays. */
static void test_steps(void **state)
{
    (void)state;
    static rmap_path_step step[5000];
    static const size_t longest[] = {1, 2, 3, 30, 4999};
    for (size_t l = 0; l < sizeof longest / sizeof *longest; l++) {
        struct rmap_path_steps steps = {0};
        struct rmap_error err;
        for (size_t class = 0; class < 1000000 && !steps.is_closed; class ++) {
            const size_t n = length_of(class, longest[l]);
            for (size_t k = 0; k < n; k++)
                step[k] = (rmap_path_step)(class + 31 * k);
            const size_t before = steps.n;
            assert_int_equal(rmap_path_steps_add(&steps, 3 * class, step, n, &err), RMAP_OK);
            steps.is_closed = steps.n == before;
        }
        assert_true(steps.is_closed);
        assert_in_range(steps.n, RMAP_PATH_STEPS_MOST / (longest[l] + 2), RMAP_PATH_STEPS_MOST);
        for (size_t class = 0; class < steps.n; class ++) {
            size_t n;
            assert_null(rmap_path_steps_of(&steps, 3 * class + 1, &n));
            const rmap_path_step *its = rmap_path_steps_of(&steps, 3 * class, &n);
            assert_int_equal(n, length_of(class, longest[l]));
            for (size_t k = 0; k < n; k++)
                if (its[k] != (rmap_path_step)(class + 31 * k))
                    fail_msg("class %zu, step %zu", class, k);
        }
        size_t n;
        assert_null(rmap_path_steps_of(&steps, 3 * steps.n, &n));
        rmap_path_steps_fini(&steps);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sums), cmocka_unit_test(test_steps)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

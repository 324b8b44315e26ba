/* SPDX-License-Identifier: MIT
 *
 * Hashes of rows of steps: the same by any instructions, whatever stands around a row; and none
 * twice among rows that differ in little.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/paths/step_hash.h"

enum { LONGEST = RMAP_STEP_HASH_BLOCK * RMAP_STEP_HASH_BLOCKS / 2 + 40 };

struct hashes {
    uint64_t low[LONGEST + 1], high[LONGEST + 1];
};

/* Rows of all lengths at all places, with other bytes behind them. */
static void check_rows(bool is_narrow)
{
    enum { WIDEST = 4 };
    static uint8_t steps[WIDEST * 2 * LONGEST + RMAP_STEP_HASH_BEHIND];
    static uint32_t first[LONGEST + 1], count[LONGEST + 1];
    static struct rmap_step_hash_keys keys;
    static struct hashes wide, plain, moved;
    const size_t width = is_narrow ? 2 : 4;
    struct rmap_step_rows rows = {steps, is_narrow, first, count, LONGEST + 1};
    rmap_step_hash_keys_init(&keys);
    for (size_t i = 0; i < sizeof steps; i++)
        steps[i] = (uint8_t)(i * 2654435761u >> 13);
    for (uint32_t n = 0; n <= LONGEST; n++) {
        first[n] = n % 37;
        count[n] = n;
    }
    for (rows.n = 0; rows.n < 9; rows.n++) {
        memset(&wide, 0, sizeof wide);
        memset(&plain, 0, sizeof plain);
        rmap_step_hash_rows(&keys, &rows, wide.low, wide.high);
        rmap_step_hash_rows_plain(&keys, &rows, plain.low, plain.high);
        assert_memory_equal(&wide, &plain, sizeof wide);
    }
    rows.n = LONGEST + 1;
    rmap_step_hash_rows(&keys, &rows, wide.low, wide.high);
    rmap_step_hash_rows_plain(&keys, &rows, plain.low, plain.high);
    assert_memory_equal(&wide, &plain, sizeof wide);
    for (uint32_t n = 0; n <= LONGEST; n++) {
        static uint8_t other[WIDEST * (LONGEST + 5) + RMAP_STEP_HASH_BEHIND];
        const uint32_t at = 5;
        const struct rmap_step_rows row = {other, is_narrow, &at, &n, 1};
        memset(other, (int)(n % 256), sizeof other);
        memcpy(other + at * width, steps + first[n] * width, n * width);
        rmap_step_hash_rows(&keys, &row, &moved.low[n], &moved.high[n]);
    }
    assert_memory_equal(&wide, &moved, sizeof wide);
}

static void test_wide(void **state)
{
    (void)state;
    check_rows(true);
    check_rows(false);
}

static int compare_halves(const void *a_, const void *b_)
{
    const uint64_t *a = a_, *b = b_;
    return (*a > *b) - (*a < *b);
}

static void assert_different(uint64_t *half, size_t n)
{
    qsort(half, n, sizeof *half, compare_halves);
    for (size_t i = 1; i < n; i++)
        assert_true(half[i] != half[i - 1]);
}

enum { N_VALUE = 24, N_PLACE = 40 };

static void hash_row(const struct rmap_step_hash_keys *keys, const uint16_t *steps, uint32_t n,
                     uint64_t *low, uint64_t *high)
{
    const uint32_t first = 0;
    const struct rmap_step_rows row = {steps, true, &first, &n, 1};
    rmap_step_hash_rows(keys, &row, low, high);
    *high <<= 20;
}

/* Zeros of every length, then two steps of small numbers anywhere in such a row: either half of a
 * hash, and the 43 bits that a key keeps of the upper one, tell all of them apart. */
static void test_different(void **state)
{
    (void)state;
    static uint16_t steps[N_PLACE + RMAP_STEP_HASH_BEHIND];
    static struct rmap_step_hash_keys keys;
    const size_t most = N_PLACE + 1 + N_PLACE * N_PLACE / 2 * N_VALUE * N_VALUE;
    uint64_t *low = malloc(most * sizeof *low), *high = malloc(most * sizeof *high);
    assert_non_null(low);
    assert_non_null(high);
    size_t n = 0;
    rmap_step_hash_keys_init(&keys);
    for (uint32_t length = 0; length <= N_PLACE; length++, n++)
        hash_row(&keys, steps, length, &low[n], &high[n]);
    for (size_t a = 0; a < N_PLACE; a++)
        for (size_t b = 0; b < a; b++)
            for (uint16_t value = 0; value < N_VALUE * N_VALUE; value++, n++) {
                steps[a] = (uint16_t)(1 + value % N_VALUE);
                steps[b] = (uint16_t)(1 + value / N_VALUE);
                hash_row(&keys, steps, N_PLACE, &low[n], &high[n]);
                steps[a] = steps[b] = 0;
            }
    assert_true(n <= most);
    assert_different(low, n);
    assert_different(high, n);
    free(low);
    free(high);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_wide),
                                       cmocka_unit_test(test_different)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

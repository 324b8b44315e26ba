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

#include "analysis/step_hash.h"

enum { LONGEST = RMAP_STEP_HASH_BLOCK * RMAP_STEP_HASH_BLOCKS + 40 };

/* Rows of all lengths at all places, with other bytes behind them. */
static void test_wide(void **state)
{
    (void)state;
    static uint8_t steps[2 * LONGEST + RMAP_STEP_HASH_BEHIND];
    static struct rmap_step_hash_keys keys;
    static struct rmap_step_row row[LONGEST + 1];
    static struct rmap_step_hash wide[LONGEST + 1], plain[LONGEST + 1], moved[LONGEST + 1];
    rmap_step_hash_keys_init(&keys);
    for (size_t i = 0; i < sizeof steps; i++)
        steps[i] = (uint8_t)(i * 2654435761u >> 13);
    for (size_t n = 0; n <= LONGEST; n++)
        row[n] = (struct rmap_step_row){n % 37, n};
    rmap_step_hash_rows(&keys, steps, row, LONGEST + 1, wide);
    rmap_step_hash_rows_plain(&keys, steps, row, LONGEST + 1, plain);
    assert_memory_equal(wide, plain, sizeof wide);
    for (size_t n = 0; n <= LONGEST; n++) {
        const struct rmap_step_row at = {5, n};
        static uint8_t other[LONGEST + RMAP_STEP_HASH_BEHIND + 5];
        memset(other, (int)(n % 256), sizeof other);
        memcpy(other + 5, steps + row[n].first, n);
        rmap_step_hash_rows(&keys, other, &at, 1, &moved[n]);
    }
    assert_memory_equal(wide, moved, sizeof wide);
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
    for (size_t length = 0; length <= N_PLACE; length++) {
        const struct rmap_step_row row = {0, length * sizeof *steps};
        struct rmap_step_hash hash;
        rmap_step_hash_rows(&keys, (const uint8_t *)steps, &row, 1, &hash);
        low[n] = hash.low;
        high[n++] = hash.high << 20;
    }
    for (size_t a = 0; a < N_PLACE; a++)
        for (size_t b = 0; b < a; b++)
            for (uint16_t value = 0; value < N_VALUE * N_VALUE; value++) {
                const struct rmap_step_row row = {0, N_PLACE * sizeof *steps};
                struct rmap_step_hash hash;
                steps[a] = (uint16_t)(1 + value % N_VALUE);
                steps[b] = (uint16_t)(1 + value / N_VALUE);
                rmap_step_hash_rows(&keys, (const uint8_t *)steps, &row, 1, &hash);
                steps[a] = steps[b] = 0;
                low[n] = hash.low;
                high[n++] = hash.high << 20;
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

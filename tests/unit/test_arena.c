/* SPDX-License-Identifier: MIT
 *
 * What is kept between questions stays within its budget, whatever is asked of it, and is less
 * where the machine has no memory.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "io/map/arena.h"
#include "io/map/column_store.h"

enum { N_BLOCK = 4000 };

/* Blocks of many sizes, none of which overlaps another; how many there was room for. */
static size_t fill(struct rmap_arena *arena, uint8_t *block[N_BLOCK], size_t nbytes[N_BLOCK])
{
    size_t n = 0;
    for (size_t i = 0; i < N_BLOCK; i++) {
        nbytes[n] = i * i % 7919 + (i % 500 == 0 ? 100000 : 0);
        block[n] = rmap_arena_room(arena, nbytes[n]);
        if (!block[n])
            continue;
        assert_int_equal((uintptr_t)block[n] % 64, 0);
        memset(block[n], (int)(n % 251), nbytes[n]);
        n++;
    }
    for (size_t k = 0; k < n; k++)
        for (size_t i = 0; i < nbytes[k]; i++)
            assert_int_equal(block[k][i], k % 251);
    return n;
}

static void test_budget_holds(void **state)
{
    static uint8_t *block[N_BLOCK];
    static size_t nbytes[N_BLOCK];
    const size_t limit[] = {0, 1, 63, 64, 5000, 1 << 18, 3 << 20, 1 << 24, SIZE_MAX / 2, SIZE_MAX};
    size_t before = 0;
    (void)state;
    for (size_t l = 0; l < sizeof limit / sizeof *limit; l++) {
        struct rmap_arena *arena = NULL;
        struct rmap_error err = {0};
        assert_int_equal(rmap_arena_create(limit[l], &arena, &err), RMAP_OK);
        size_t n = fill(arena, block, nbytes), sum = 0;
        for (size_t k = 0; k < n; k++)
            sum += nbytes[k];
        assert_true(sum <= rmap_arena_nbytes(arena));
        assert_true(rmap_arena_nbytes(arena) <= rmap_arena_limit(arena));
        assert_true(n >= before);
        before = n;
        assert_null(rmap_arena_room(arena, SIZE_MAX));
        rmap_arena_destroy(arena);
    }
    assert_int_equal(before, N_BLOCK);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_without_memory_less_is_kept(void **state)
{
    struct rmap_column_store *store = NULL;
    struct rmap_error err = {0};
    const uint64_t rows[] = {3, 1, 4, 1, 5};
    (void)state;
    assert_int_equal(rmap_column_store_create(2, 1 << 20, &store, &err), RMAP_OK);
    rmap_alloc_fail_at(1);
    rmap_column_store_offer(store, 0, RMAP_RAY_id, rows, sizeof rows);
    rmap_alloc_fail_at(0);
    assert_null(rmap_column_store_get(store, 0, RMAP_RAY_id));
    assert_int_equal(rmap_column_store_taken(store), 0);
    assert_int_equal(rmap_column_store_nbytes(store, false), 0);
    rmap_column_store_offer(store, 0, RMAP_RAY_id, rows, sizeof rows);
    assert_memory_equal(rmap_column_store_get(store, 0, RMAP_RAY_id), rows, sizeof rows);
    assert_null(rmap_column_store_get(store, 1, RMAP_RAY_id));
    rmap_column_store_destroy(store);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_budget_holds),
        cmocka_unit_test(test_without_memory_less_is_kept),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * The promise: what the chunk caches of a cursor hold together stays within their budget, however
 * many shards a map has and however small it is, and a chunk that is found is the one asked for.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "io/map/chunk_cache.h"

enum { N_CACHE = 6, N_SHARD = 40, N_VISIT = 20000 };

static void visit(struct rmap_chunk_cache *cache, size_t piece, uint64_t index, size_t nbytes,
                  size_t *n_found)
{
    uint8_t *plane;
    const uint8_t *found = rmap_chunk_cache_find(cache, piece, index);
    const size_t key[] = {piece, (size_t)index};
    if (found) {
        assert_memory_equal(found, key, sizeof key);
        *n_found += 1;
        return;
    }
    assert_int_equal(rmap_chunk_cache_room(cache, piece, index, &plane, NULL), RMAP_OK);
    memset(plane, 0, nbytes);
    memcpy(plane, key, sizeof key);
    rmap_chunk_cache_keep(cache, piece, index);
}

/* Shards in turn, all columns of each, some blocks out of order. */
static void run(size_t limit_nbytes, size_t n_shard, size_t *most_ret, size_t *n_found)
{
    struct rmap_chunk_budget budget = {.limit_nbytes = limit_nbytes};
    struct rmap_chunk_cache *cache[N_CACHE];
    size_t nbytes[N_CACHE];
    uint64_t random = 7;
    *most_ret = *n_found = 0;
    for (size_t c = 0; c < N_CACHE; c++) {
        nbytes[c] = (size_t)1024 << c;
        assert_int_equal(rmap_chunk_cache_create(&budget, nbytes[c], n_shard, &cache[c], NULL),
                         RMAP_OK);
    }
    for (size_t k = 0; k < N_VISIT; k++) {
        random = random * UINT64_C(6364136223846793005) + 1;
        size_t c = (random >> 40) % N_CACHE;
        visit(cache[c], k % n_shard, k / 2000 + (random >> 60) % 2, nbytes[c], n_found);
        *most_ret = budget.nbytes > *most_ret ? budget.nbytes : *most_ret;
    }
    for (size_t c = 0; c < N_CACHE; c++)
        rmap_chunk_cache_destroy(cache[c]);
    assert_int_equal(budget.nbytes, 0);
    assert_null(budget.first);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_budget(void **state)
{
    (void)state;
    const size_t sum = (1024 << N_CACHE) - 1024;
    size_t most, n_found, n_found_in_little;
    run(3 * sum, N_SHARD, &most, &n_found_in_little);
    assert_in_range(most, 2 * sum, 3 * sum);
    run(sum, N_SHARD, &most, &n_found); /* less than two chunks of each */
    assert_in_range(most, sum / 2, sum);
    run(1, N_SHARD, &most, &n_found); /* none but the one in hand */
    assert_int_equal(most, (size_t)1024 << (N_CACHE - 1));
    run(1000 * sum, N_SHARD, &most, &n_found);
    assert_true(n_found > N_VISIT / 2 && n_found > n_found_in_little);
}

/* One shard alone needs no more than it did. */
static void test_one_shard(void **state)
{
    (void)state;
    size_t most, n_found;
    run((size_t)1 << 26, 1, &most, &n_found);
    assert_true(most <= 4 * ((size_t)1024 << N_CACHE) && n_found > N_VISIT * 9 / 10);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_budget),
        cmocka_unit_test(test_one_shard),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * The N rays with the smallest keys: those that sorting everything gives, in any order of coming.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/query/sample.h"
#include "base/alloc.h"

enum { N = 3000 };

static uint64_t next(uint64_t *state)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return *state >> 16;
}

static int by_key(const void *a, const void *b)
{
    const struct rmap_sample_ray *x = a, *y = b;
    if (x->key != y->key)
        return x->key < y->key ? -1 : 1;
    return (x->id > y->id) - (x->id < y->id);
}

static int by_number(const void *a, const void *b)
{
    const uint64_t *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* keys: how many different ones; few make many equal. */
static void compare(uint64_t most, uint64_t keys, uint64_t seed)
{
    struct rmap_error err = {0};
    static struct rmap_sample_ray ray[N];
    static uint64_t want[N];
    uint64_t *id = NULL;
    struct rmap_sample sample = {.most = most};
    for (size_t i = 0; i < N; i++) { /* ids in no order, each once */
        ray[i] = (struct rmap_sample_ray){next(&seed) % keys, (i * 1009) % N};
        assert_int_equal(rmap_sample_add(&sample, ray[i], &err), RMAP_OK);
    }
    qsort(ray, N, sizeof *ray, by_key);
    size_t n = most < N ? (size_t)most : N;
    for (size_t i = 0; i < n; i++)
        want[i] = ray[i].id;
    qsort(want, n, sizeof *want, by_number);
    assert_int_equal(sample.n, n);
    assert_int_equal(rmap_sample_ids(&sample, &id, &err), RMAP_OK);
    assert_memory_equal(id, want, n * sizeof *want);
    rmap_free(id);
    rmap_sample_fini(&sample);
}

static void the_smallest_are_kept(void **state)
{
    (void)state;
    for (uint64_t seed = 1; seed < 6; seed++) {
        compare(1, UINT64_MAX, seed);
        compare(2, UINT64_MAX, seed);
        compare(100, UINT64_MAX, seed);
        compare(100, 7, seed);
        compare(N - 1, 50, seed);
        compare(N, UINT64_MAX, seed);
        compare(10 * N, 3, seed);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* The key is part of the language: a sample of today must be found again. In Python:
 * xxhash.xxh3_64_intdigest(struct.pack("<QQ", seed, id)). */
static void keys_are_those_documented(void **state)
{
    (void)state;
    const struct {
        uint64_t seed, id, key;
    } known[] = {{1, 0u, 0x26f2a1148cf52011u},
                 {1, 1u, 0x6ca7f978e15828a6u},
                 {0, 0u, 0xd0a66a65c7528968u},
                 {7, 1099511627779u, 0x95fca652526bc0a0u}};
    for (size_t i = 0; i < sizeof known / sizeof *known; i++)
        assert_int_equal(rmap_sample_key(known[i].seed, known[i].id), known[i].key);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(the_smallest_are_kept),
        cmocka_unit_test(keys_are_those_documented),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

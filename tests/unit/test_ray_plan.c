/* SPDX-License-Identifier: MIT
 *
 * Sets of ray ids and the blocks they are cut into, up to the largest id there is.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "portion/portion.h"
#include "portion/ray_plan.h"

static struct rmap_ray_set make(const struct rmap_ray_range *range, size_t n)
{
    struct rmap_ray_set set;
    assert_int_equal(rmap_ray_set_make(range, n, &set, NULL), RMAP_OK);
    return set;
}

static void expect(const struct rmap_ray_set *set, const struct rmap_ray_range *range, size_t n)
{
    assert_int_equal(set->n, n);
    if (n > 0)
        assert_memory_equal(set->range, range, n * sizeof *range);
}
#define LIST(...)   ((const struct rmap_ray_range[]){__VA_ARGS__})
#define COUNT(list) (sizeof(list) / sizeof *(list))

static void unions(void **state)
{
    (void)state;
    struct rmap_ray_set set = make(NULL, 0);
    expect(&set, NULL, 0);
    set = make(LIST({5, 5}, {9, 3}), 2); /* nothing in either */
    expect(&set, NULL, 0);
    set = make(LIST({10, 20}, {0, 5}, {5, 7}, {15, 30}, {12, 13}, {40, 41}), 6);
    expect(&set, LIST({0, 7}, {10, 30}, {40, 41}), 3);
    assert_true(rmap_ray_set_count(&set) == 28);
    rmap_ray_set_fini(&set);
    set = make(LIST({RMAP_RAY_END - 1, RMAP_RAY_END}, {0, 1}, {0, RMAP_RAY_END}), 3);
    expect(&set, LIST({0, RMAP_RAY_END}), 1);
    assert_true(rmap_ray_set_count(&set) == RMAP_RAY_END);
    rmap_ray_set_fini(&set);
}

static void check_minus(const struct rmap_ray_range *a, size_t n_a, const struct rmap_ray_range *b,
                        size_t n_b, const struct rmap_ray_range *want, size_t n_want)
{
    struct rmap_ray_set from = make(a, n_a), other = make(b, n_b), rest;
    assert_int_equal(rmap_ray_set_minus(&from, &other, &rest, NULL), RMAP_OK);
    expect(&rest, want, n_want);
    rmap_ray_set_fini(&from);
    rmap_ray_set_fini(&other);
    rmap_ray_set_fini(&rest);
}

static void differences(void **state)
{
    (void)state;
    const uint64_t end = RMAP_RAY_END;
    check_minus(LIST({0, 10}), 1, NULL, 0, LIST({0, 10}), 1);
    check_minus(NULL, 0, LIST({0, 10}), 1, NULL, 0);
    check_minus(LIST({0, 10}), 1, LIST({0, 10}), 1, NULL, 0);
    check_minus(LIST({5, 10}), 1, LIST({0, 20}), 1, NULL, 0);
    check_minus(LIST({0, 20}), 1, LIST({5, 10}), 1, LIST({0, 5}, {10, 20}), 2);
    check_minus(LIST({0, 20}), 1, LIST({0, 10}), 1, LIST({10, 20}), 1);
    check_minus(LIST({0, 20}), 1, LIST({10, 20}), 1, LIST({0, 10}), 1);
    check_minus(LIST({0, 20}), 1, LIST({20, 30}), 1, LIST({0, 20}), 1);
    check_minus(LIST({10, 20}), 1, LIST({5, 10}), 1, LIST({10, 20}), 1);
    /* one cut through two ranges, two cuts through one */
    check_minus(LIST({0, 10}, {20, 30}), 2, LIST({5, 25}), 1, LIST({0, 5}, {25, 30}), 2);
    check_minus(LIST({0, 30}, {40, 50}), 2, LIST({1, 2}, {3, 45}), 2,
                LIST({0, 1}, {2, 3}, {45, 50}), 3);
    check_minus(LIST({0, end}), 1, LIST({1, end - 1}), 1, LIST({0, 1}, {end - 1, end}), 2);
    check_minus(LIST({0, end}), 1, LIST({end - 1, end}), 1, LIST({0, end - 1}), 1);
}

/* Against a table of flags, with many random sets. */
static void random_differences(void **state)
{
    (void)state;
    enum { IDS = 64 };
    srand(11);
    for (int round = 0; round < 2000; round++) {
        struct rmap_ray_range range[2][6];
        char in[2][IDS] = {{0}};
        for (int k = 0; k < 2; k++)
            for (int i = 0; i < 6; i++) {
                range[k][i].first = (uint64_t)(rand() % IDS);
                range[k][i].end = range[k][i].first + (uint64_t)(rand() % 16);
                for (uint64_t id = range[k][i].first; id < range[k][i].end && id < IDS; id++)
                    in[k][id] = 1;
                if (range[k][i].end > IDS)
                    range[k][i].end = IDS;
            }
        struct rmap_ray_set from = make(range[0], 6), other = make(range[1], 6), rest;
        assert_int_equal(rmap_ray_set_minus(&from, &other, &rest, NULL), RMAP_OK);
        char found[IDS] = {0};
        for (size_t i = 0; i < rest.n; i++) {
            assert_true(rest.range[i].first < rest.range[i].end);
            assert_true(i == 0 || rest.range[i].first > rest.range[i - 1].end);
            for (uint64_t id = rest.range[i].first; id < rest.range[i].end; id++)
                found[id] = 1;
        }
        for (int id = 0; id < IDS; id++)
            assert_int_equal(found[id], in[0][id] && !in[1][id]);
        assert_int_equal(rmap_ray_set_join(&rest, &other, NULL), RMAP_OK);
        uint64_t either = 0;
        for (int id = 0; id < IDS; id++)
            either += (uint64_t)(in[0][id] || in[1][id]);
        assert_true(rmap_ray_set_count(&rest) == either);
        assert_int_equal(rmap_ray_set_join(&from, &other, NULL), RMAP_OK);
        assert_int_equal(from.n, rest.n);
        assert_memory_equal(from.range, rest.range, rest.n * sizeof *rest.range);
        rmap_ray_set_fini(&from);
        rmap_ray_set_fini(&other);
        rmap_ray_set_fini(&rest);
    }
}

/* Blocks ascend, tile the set, and never cross a multiple of RMAP_BLOCK_RAYS. */
static void check_plan(const struct rmap_ray_range *range, size_t n, uint64_t n_block)
{
    struct rmap_ray_set set = make(range, n);
    struct rmap_ray_plan plan;
    assert_int_equal(rmap_ray_plan_init(&plan, &set, NULL), RMAP_OK);
    assert_true(plan.n_block == n_block);
    struct rmap_ray_range *block = rmap_alloc((size_t)n_block + 1, sizeof *block);
    uint64_t rays = 0;
    for (uint64_t b = 0; b < n_block; b++) {
        block[b] = rmap_ray_plan_block(&plan, b);
        assert_true(block[b].first < block[b].end);
        assert_true(block[b].first / RMAP_BLOCK_RAYS == (block[b].end - 1) / RMAP_BLOCK_RAYS);
        assert_true(b == 0 || block[b].first >= block[b - 1].end);
        rays += block[b].end - block[b].first;
    }
    assert_true(rays == plan.n_ray);
    struct rmap_ray_set again = make(block, (size_t)n_block);
    expect(&again, set.range, set.n);
    rmap_ray_set_fini(&again);
    rmap_free(block);
    rmap_ray_plan_fini(&plan);
    rmap_ray_set_fini(&set);
}

static void blocks(void **state)
{
    (void)state;
    const uint64_t far = (uint64_t)1 << 40, end = RMAP_RAY_END;
    check_plan(NULL, 0, 0);
    check_plan(LIST({0, 1}), 1, 1);
    check_plan(LIST({0, 4096}), 1, 1);
    check_plan(LIST({0, 4097}), 1, 2);
    check_plan(LIST({4095, 4097}), 1, 2);
    check_plan(LIST({1, 4096}, {5000, 20000}, {20001, 20002}), 3, 6);
    check_plan(LIST({far + 5, far + 10000}), 1, 3);
    check_plan(LIST({end - 5000, end}), 1, 2);
    check_plan(LIST({end - 1, end}), 1, 1);
    struct rmap_ray_set all = make(LIST({0, end}), 1);
    struct rmap_ray_plan plan;
    assert_int_equal(rmap_ray_plan_init(&plan, &all, NULL), RMAP_OK);
    assert_true(plan.n_block == (uint64_t)1 << 52 && plan.n_ray == end);
    struct rmap_ray_range last = rmap_ray_plan_block(&plan, plan.n_block - 1);
    assert_true(last.first == end - 4095 && last.end == end);
    rmap_ray_plan_fini(&plan);
    rmap_ray_set_fini(&all);
}

/* As a map of 10 million rays that lost every other block. */
static void many_holes(void **state)
{
    (void)state;
    enum { N = 1221 };
    static struct rmap_ray_range hole[N];
    for (uint64_t i = 0; i < N; i++)
        hole[N - 1 - i] = (struct rmap_ray_range){i * 8192, i * 8192 + 4096};
    check_plan(hole, N, N);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(unions),
        cmocka_unit_test(differences),
        cmocka_unit_test(random_differences),
        cmocka_unit_test(blocks),
        cmocka_unit_test(many_holes),
    };
    return cmocka_run_group_tests_name("ray_plan", test, NULL, NULL);
}

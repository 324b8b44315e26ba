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

#include "analysis/paths/path_steps.h"
#include "analysis/table/class_cache.h"
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

static struct rmap_class_sum sum_of(size_t number, uint64_t rays, uint64_t first, double weight)
{
    return (struct rmap_class_sum){{key_of(number), rays, first},
                                   {(double)rays * weight, (double)rays * weight * weight,
                                    rays * (number % 5 + 1), rays * (number % 3)}};
}

static void check_class(const struct rmap_class_sums *classes, size_t number, uint64_t rays,
                        double weight)
{
    size_t slot;
    const size_t at =
        rmap_class_sums_look(classes, key_of(number), rmap_key_mixed(key_of(number)), &slot);
    assert_int_equal(at, number);
    const struct rmap_class_sum its = rmap_class_sums_at(classes, at);
    assert_int_equal(its.entry.rays, rays);
    assert_int_equal(its.entry.first_ray, 100 + number);
    assert_int_equal(its.more.segments, rays * (number % 5 + 1));
    assert_int_equal(its.more.registrations, rays * (number % 3));
    assert_true(its.more.weight == weight);
}

/* Each class gets a ray, then two; in the third turn rays of another weight, if any, for which the
 * table grows wide. No more classes are taken than may be. */
static void check_classes(bool is_wide, double weight, size_t most)
{
    struct rmap_class_sums classes;
    struct rmap_error err;
    rmap_class_sums_init(&classes, is_wide, most);
    for (size_t k = 0; k < 3 * (most + 10); k++) {
        const size_t number = k % (most + 10), turn = k / (most + 10);
        const struct rmap_class_sum more =
            sum_of(number, turn == 1 ? 2 : 1, turn == 1 ? 100 + number : 5000000 - k,
                   turn == 2 ? weight : 1.0);
        size_t index;
        uint64_t before;
        assert_int_equal(rmap_class_sums_add(&classes, &more, &index, &before, &err), RMAP_OK);
        assert_int_equal(index, number < most ? number : RMAP_KEY_SLOTS_NONE);
        assert_int_equal(before, number < most ? (turn == 2 ? 3 : turn) : 0);
    }
    assert_int_equal(classes.n, most);
    assert_int_equal(classes.is_wide, is_wide || weight != 1.0);
    for (size_t k = 0; k < most; k++)
        check_class(&classes, k, 4, 3.0 + weight);
    rmap_class_sums_fini(&classes);
}

static void test_classes(void **state)
{
    (void)state;
    static const size_t mosts[] = {1, 1023, 1024, 1025, 12289, 50000};
    for (size_t m = 0; m < sizeof mosts / sizeof *mosts; m++) {
        check_classes(false, 1.0, mosts[m]);
        check_classes(true, 1.0, mosts[m]);
        check_classes(false, 0.5, mosts[m]);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* The classes of many rays are noted, each once, and no others. */
static void check_many(const struct rmap_class_sums *classes)
{
    const struct rmap_class_many *many = classes->many;
    size_t n = 0;
    uint8_t *is_noted = rmap_alloc(classes->n, 1);
    assert_non_null(is_noted);
    for (size_t i = 0; i < many->n; i++) {
        assert_int_equal(is_noted[many->class[i]], 0);
        is_noted[many->class[i]] = 1;
    }
    for (size_t k = 0; k < classes->n; k++) {
        assert_int_equal(is_noted[k], classes->entry[k].rays >= many->least);
        n += is_noted[k];
    }
    assert_int_equal(n, many->n);
    rmap_free(is_noted);
}

/* More classes of many rays than are noted: in the end those of the most. */
static void test_many(void **state)
{
    (void)state;
    enum { N = 3 * RMAP_CLASS_MANY, TURNS = 8 };
    struct rmap_class_sums classes;
    struct rmap_error err;
    rmap_class_sums_init(&classes, false, N);
    for (size_t k = 0; k < (size_t)TURNS * N; k++) {
        const struct rmap_class_sum more = sum_of(k % N, 1 + k % N % 16, 1, 1.0);
        size_t index;
        uint64_t before;
        assert_int_equal(rmap_class_sums_add(&classes, &more, &index, &before, &err), RMAP_OK);
        if (k % (N / 2) == 0)
            check_many(&classes);
    }
    check_many(&classes);
    assert_true(classes.many->n > 0 && classes.many->least > RMAP_CLASS_MANY_LEAST);
    rmap_class_sums_fini(&classes);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* What is counted in the cache and what the table gets is all that came; `wide_at`: when the table
 * grows wide. */
static void check_cache(size_t n_class, size_t wide_at)
{
    static struct rmap_class_cache cache;
    struct rmap_class_sums classes;
    struct rmap_error err;
    const size_t n_ray = 20 * n_class;
    size_t n_cached = 0;
    memset(&cache, 0, sizeof cache);
    rmap_class_sums_init(&classes, false, n_class);
    for (size_t k = 0; k < n_ray; k++) {
        const size_t number = k < n_class ? k : k * k % n_class;
        const uint64_t id = k < n_ray - n_class ? 100000000 + k : 100 + (k - n_ray + n_class);
        const size_t its = k < n_ray - n_class ? number : k - n_ray + n_class;
        const uint64_t mixed = rmap_key_mixed(key_of(its));
        if (k == wide_at)
            assert_int_equal(rmap_class_sums_widen(&classes, &err), RMAP_OK);
        if (k == n_ray - n_class)
            rmap_class_cache_empty(&cache, &classes);
        if (rmap_class_cache_count(&cache, key_of(its), mixed)) {
            n_cached++;
            continue;
        }
        const struct rmap_class_sum more = sum_of(its, 1, id, 1.0);
        size_t index;
        uint64_t before;
        assert_int_equal(rmap_class_sums_add(&classes, &more, &index, &before, &err), RMAP_OK);
        if (before > 0)
            rmap_class_cache_meet(&cache, key_of(its), mixed, index, &classes);
    }
    for (size_t i = 0; i < RMAP_CLASS_CACHE_LINES; i++)
        rmap_class_cache_flush(&cache, i, &classes);
    check_many(&classes);
    uint64_t rays = 0;
    for (size_t k = 0; k < n_class; k++) {
        const struct rmap_class_sum its = rmap_class_sums_at(&classes, k);
        rays += its.entry.rays;
        check_class(&classes, k, its.entry.rays, (double)its.entry.rays);
    }
    assert_int_equal(rays, n_ray);
    assert_true(n_cached > 0);
    rmap_class_sums_fini(&classes);
}

static void test_cache(void **state)
{
    (void)state;
    static const size_t counts[] = {1, 100, 1000, 20000};
    for (size_t c = 0; c < sizeof counts / sizeof *counts; c++) {
        check_cache(counts[c], SIZE_MAX);
        check_cache(counts[c], 15 * counts[c]);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

RMAP_KEY_LANES_WIDE static struct rmap_key_lanes wide_lanes(const uint32_t *slot, uint32_t number,
                                                            uint32_t bits)
{
    return rmap_key_lanes_of(slot, number, bits, true);
}

/* Slots filled to some place, with few different bits above the index. */
static void test_lanes(void **state)
{
    (void)state;
    const uint32_t number = 0xfffff;
    uint32_t slot[RMAP_KEY_SLOTS_TOGETHER];
    for (uint32_t k = 0; k < 3000; k++) {
        const uint32_t taken = k % (RMAP_KEY_SLOTS_TOGETHER + 1), bits = (k % 5) << 20;
        uint32_t alike = 0, free = 0;
        for (uint32_t i = 0; i < RMAP_KEY_SLOTS_TOGETHER; i++) {
            const uint32_t its = (k * 31 + i * 2654435761u) >> 16;
            slot[i] = i < taken ? its % 6 << 20 | (its + 1) : 0;
            alike |= (uint32_t)(i < taken && (slot[i] & ~number) == bits) << i;
            free |= (uint32_t)(i >= taken) << i;
        }
        struct rmap_key_lanes lanes = rmap_key_lanes_of(slot, number, bits, false);
        assert_int_equal(lanes.alike, alike);
        assert_int_equal(lanes.free, free);
        if (!rmap_key_lanes_are_wide())
            continue;
        lanes = wide_lanes(slot, number, bits);
        assert_int_equal(lanes.alike, alike);
        assert_int_equal(lanes.free, free);
    }
    assert_int_equal(rmap_key_lane(1), 0);
    assert_int_equal(rmap_key_lane(0x8030), 4);
}

static size_t length_of(size_t class, size_t longest)
{
    return longest == 1 ? 1 : class * 2654435761u % (longest + 1);
}

/* Numbers with gaps, descending in part. */
static size_t class_of(size_t k)
{
    return k % 2 ? 3 * k - 3 : 3 * k + 3;
}

static void check_room(size_t n_class, size_t longest, size_t n_word)
{
    assert_in_range(n_class, n_word / (longest + 2) - 1, n_word);
}

/* The class among others, one of which is not there. */
static void check_found(const struct rmap_path_steps *steps, const uint32_t *number, size_t class)
{
    const size_t wanted[] = {class_of(0), 1, class};
    uint32_t found[3];
    rmap_path_steps_find(steps, wanted, 3, found);
    assert_int_equal(found[0], number[class_of(0)]);
    assert_int_equal(found[1], 0);
    assert_int_equal(found[2], number[class]);
}

/* Filled to the last word, and beyond: what was taken stays. Of one ray, then of two, then those of
 * other threads. */
static void test_steps(void **state)
{
    (void)state;
    static rmap_path_step step[5000];
    static const size_t longest[] = {1, 2, 3, 30, 4999};
    for (size_t l = 0; l < sizeof longest / sizeof *longest; l++) {
        struct rmap_path_steps steps = {0};
        struct rmap_error err;
        uint32_t *number;
        for (size_t k = 0, others = 0; k == steps.n; k++) {
            const size_t n = length_of(k, longest[l]);
            rmap_path_step *room = NULL;
            for (size_t i = 0; i < n; i++)
                step[i] = (rmap_path_step)(k + 31 * i);
            while (!room && !steps.is_full) {
                const uint64_t rays = steps.is_closed ? 2 : 1;
                assert_int_equal(rmap_path_steps_make_room(&steps, n, rays, &room, &err), RMAP_OK);
                if (!room)
                    check_room(k, longest[l],
                               rays < 2 ? RMAP_PATH_STEPS_FIRST : RMAP_PATH_STEPS_SCANNED);
            }
            others += !room;
            if (room) {
                memcpy(room, step, n * sizeof *step);
                rmap_path_steps_end_class(&steps, class_of(k), n);
            } else
                assert_int_equal(rmap_path_steps_add(&steps, class_of(k), step, n, &err), RMAP_OK);
            if (k == steps.n)
                assert_true(others > 1);
        }
        check_room(steps.n, longest[l], RMAP_PATH_STEPS_MOST);
        assert_int_equal(rmap_path_steps_index(&steps, 3 * steps.n + 4, &number, &err), RMAP_OK);
        for (size_t k = 0; k < steps.n; k++) {
            size_t n;
            const rmap_path_step *its = rmap_path_steps_at(&steps, number[class_of(k)], &n);
            assert_int_equal(n, length_of(k, longest[l]));
            for (size_t i = 0; i < n; i++)
                if (its[i] != (rmap_path_step)(k + 31 * i))
                    fail_msg("class %zu, step %zu", class_of(k), i);
            if (k % 1000 == 0)
                check_found(&steps, number, class_of(k));
            assert_int_equal(number[class_of(k) + 1], 0);
        }
        rmap_free(number);
        rmap_path_steps_fini(&steps);
    }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* New classes are kept until there are many; then those that have become two rays. */
static void test_want(void **state)
{
    (void)state;
    struct rmap_path_steps steps = {.n_first = 10};
    assert_true(rmap_path_steps_want(&steps, 10, 0, 1));
    assert_false(rmap_path_steps_want(&steps, 9, 1, 2));
    steps.is_closed = true;
    assert_false(rmap_path_steps_want(&steps, 10, 0, 1));
    assert_true(rmap_path_steps_want(&steps, 10, 0, 3));
    assert_true(rmap_path_steps_want(&steps, 10, 1, 2));
    assert_false(rmap_path_steps_want(&steps, 10, 2, 3));
    steps.is_full = true;
    assert_false(rmap_path_steps_want(&steps, 10, 1, 2));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_sums),  cmocka_unit_test(test_classes),
                                       cmocka_unit_test(test_many),  cmocka_unit_test(test_cache),
                                       cmocka_unit_test(test_lanes), cmocka_unit_test(test_steps),
                                       cmocka_unit_test(test_want)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

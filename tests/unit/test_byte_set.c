/* SPDX-License-Identifier: MIT
 *
 * Bytes against sets, and bits counted in groups: as a byte at a time says it.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/byte_set.h"

enum { N = 1000 };

static uint32_t next(uint32_t *state)
{
    *state = *state * 1664525u + 1013904223u;
    return *state >> 8;
}

static void test_members(void **state)
{
    (void)state;
    uint32_t random = 7;
    for (int round = 0; round < 200; round++) {
        uint8_t byte[N], flag[N], member[256], some[256];
        uint64_t bits[N / 64 + 1];
        size_t n = next(&random) % (N + 1), n_some = 0;
        for (size_t i = 0; i < n; i++)
            byte[i] = (uint8_t)next(&random);
        for (int b = 0; b < 256; b++)
            if ((member[b] = next(&random) % (round % 2 ? 3 : 30) == 0))
                some[n_some++] = (uint8_t)b;
        rmap_bytes_among(byte, n, some, n_some, bits);
        rmap_byte_set_flags(byte, n, member, flag);
        for (size_t i = 0; i < n; i++) {
            assert_int_equal(flag[i], member[byte[i]]);
            assert_int_equal(bits[i / 64] >> i % 64 & 1, member[byte[i]]);
        }
        if (n % 64 > 0)
            assert_int_equal(bits[n / 64] >> n % 64, 0);
        rmap_byte_set_flags(byte, n, member, byte); /* in place */
        assert_memory_equal(byte, flag, n);
    }
}

/* More bytes than are looked at at a time. */
static void test_list(void **state)
{
    static uint8_t byte[9001];
    uint32_t at[9001 / 97 + 1];
    (void)state;
    for (size_t i = 0; i < sizeof byte; i++)
        byte[i] = (uint8_t)(i % 97 == 4 ? 2 : i % 2);
    assert_int_equal(rmap_bytes_list(byte, sizeof byte, 2, at), 93);
    for (size_t k = 0; k < 93; k++)
        assert_int_equal(at[k], 97 * k + 4);
    assert_int_equal(rmap_bytes_list(byte, 4, 2, at), 0);
}

/* Groups of no bits, of some, and of more than are read at once. */
static void test_groups(void **state)
{
    (void)state;
    uint32_t random = 11;
    for (int round = 0; round < 200; round++) {
        uint64_t bits[N / 64 + 2] = {0};
        uint32_t size[N], count[N];
        size_t n_group = 0, first = 0;
        for (size_t w = 0; w < N / 64 + 1; w++)
            bits[w] = (uint64_t)next(&random) << 40 ^ (uint64_t)next(&random) << 20 ^ next(&random);
        for (size_t at = 0; at < N && n_group < N; at += size[n_group++]) {
            uint32_t own = next(&random) % 8 == 0 ? next(&random) % 200 : next(&random) % 20;
            size[n_group] = own < N - at ? own : (uint32_t)(N - at);
        }
        rmap_bits_count_groups(bits, size, n_group, count);
        for (size_t g = 0; g < n_group; first += size[g++]) {
            uint32_t sum = 0;
            for (size_t i = first; i < first + size[g]; i++)
                sum += (uint32_t)(bits[i / 64] >> i % 64 & 1);
            assert_int_equal(count[g], sum);
            assert_int_equal(rmap_bits_count(bits, first, size[g]), sum);
        }
    }
}

static void test_numbers(void **state)
{
    (void)state;
    uint32_t random = 13;
    for (int round = 0; round < 300; round++) {
        int32_t number[N];
        uint32_t word[N], low = next(&random) % 9 - 2, span = next(&random) % 8;
        uint32_t any = next(&random) % 64 | (round % 9 == 0 ? UINT32_C(1) << 31 : 0);
        uint64_t bits[N / 64 + 1];
        size_t n = next(&random) % (N + 1);
        for (size_t i = 0; i < n; i++) {
            number[i] = (int32_t)(next(&random) % 12) - 3;
            word[i] = next(&random) << 8 & next(&random) << 8 & next(&random) << 4;
        }
        rmap_range_bits(number, n, low, span, bits);
        for (size_t i = 0; i < n; i++)
            assert_int_equal(bits[i / 64] >> i % 64 & 1, (uint32_t)number[i] - low < span);
        rmap_keep_any_bits(word, n, any, bits);
        for (size_t i = 0; i < n; i++)
            assert_int_equal(bits[i / 64] >> i % 64 & 1,
                             (uint32_t)number[i] - low < span && (word[i] & any) != 0);
        rmap_keep_none_bits(word, n, any >> 1, bits);
        for (size_t i = 0; i < n; i++)
            assert_int_equal(bits[i / 64] >> i % 64 & 1, (uint32_t)number[i] - low < span &&
                                                             (word[i] & any) != 0 &&
                                                             (word[i] & any >> 1) == 0);
    }
}

static bool has(const uint64_t *bits, size_t i)
{
    return bits[i / 64] >> i % 64 & 1;
}

/* Which groups have a bit, or end with one: groups of all sizes, few or many bits. */
static void test_any_and_last(void **state)
{
    enum { WORDS = N / 64 + 2 };
    (void)state;
    uint32_t random = 5;
    for (int round = 0; round < 400; round++) {
        uint64_t bits[WORDS] = {0}, any[WORDS], last[WORDS];
        uint32_t size[N], count[N];
        size_t n_group = 0, n_bit = 0, rarity = 1 + next(&random) % 12;
        const uint32_t longest = round % 3 == 0 ? 3 : round % 3 == 1 ? 20 : 300;
        for (; n_group < N && n_bit < N; n_bit += size[n_group++]) {
            uint32_t own = next(&random) % longest + (uint32_t)(round % 2);
            size[n_group] = own < N - n_bit ? own : (uint32_t)(N - n_bit);
        }
        for (size_t i = 0; i < n_bit; i++)
            bits[i / 64] |= (uint64_t)(next(&random) % rarity == 0) << i % 64;
        rmap_bits_count_groups(bits, size, n_group, count);
        rmap_bits_any_groups(bits, size, n_group, any);
        rmap_bits_last_groups(bits, size, n_group, last);
        for (size_t g = 0, at = 0; g < n_group; at += size[g++]) {
            assert_int_equal(has(any, g), count[g] > 0);
            assert_int_equal(has(last, g), size[g] > 0 && has(bits, at + size[g] - 1));
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_members),      cmocka_unit_test(test_list),
        cmocka_unit_test(test_numbers),      cmocka_unit_test(test_groups),
        cmocka_unit_test(test_any_and_last),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

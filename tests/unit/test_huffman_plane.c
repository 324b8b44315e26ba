/* SPDX-License-Identifier: MIT
 *
 * Blocks of literals alone come back by zlib, whatever their bytes: codes of every shape, among
 * them trees deeper than codes may be long, and codes near the entropy. So do blocks of one byte
 * over and over.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>
#include <zlib.h>

#include "base/alloc.h"
#include "io/codec/huffman_plane.h"
#include "io/codec/huffman_wide.h"
#include "io/codec/uniform_plane.h"

enum { N_MAX = 300000 };

static uint8_t data[N_MAX], back[N_MAX], block[2 * N_MAX];

/* The blocks of that length come back as n bytes of data. */
static void check_blocks(size_t nbytes, size_t n)
{
    static const uint8_t final_block[2] = {0x03, 0x00};
    z_stream stream = {0};
    assert_true(nbytes > 0);
    memcpy(block + nbytes, final_block, sizeof final_block);
    memset(back, 0xA5, n);
    assert_int_equal(inflateInit2(&stream, -15), Z_OK);
    stream.next_in = block;
    stream.avail_in = (uInt)(nbytes + sizeof final_block);
    stream.next_out = back;
    stream.avail_out = (uInt)n;
    assert_int_equal(inflate(&stream, Z_FINISH), Z_STREAM_END);
    assert_int_equal(stream.avail_out, 0);
    assert_int_equal(stream.avail_in, 0);
    (void)inflateEnd(&stream);
    assert_memory_equal(data, back, n);
}

/* Length of the blocks; their bytes are checked. */
static size_t check(size_t n)
{
    size_t nbytes = rmap_huffman_plane(data, n, block, N_MAX);
    check_blocks(nbytes, n);
    return nbytes;
}

static void test_any_length(void **state)
{
    (void)state;
    for (size_t n = 1; n < 70; n++) {
        for (size_t i = 0; i < n; i++)
            data[i] = (uint8_t)(i * i % 7 * 40);
        (void)check(n);
    }
}

static void test_one_symbol(void **state)
{
    (void)state;
    memset(data, 0, N_MAX);
    assert_true(check(N_MAX) < N_MAX / 8 + 200);
    memset(data, 255, 3);
    (void)check(3);
}

/* Symbol k occurs as often as the k-th Fibonacci number: the tree is a chain of 24 levels. */
static void test_deep_tree(void **state)
{
    size_t n = 0, a = 1, b = 1;
    (void)state;
    for (int k = 0; k < 24; k++) {
        memset(data + n, k * 9, a);
        n += a;
        size_t next = a + b;
        a = b;
        b = next;
    }
    assert_true(n <= N_MAX);
    (void)check(n);
}

static void test_near_entropy(void **state)
{
    uint64_t random = 1;
    size_t count[256] = {0};
    double bits = 0.0;
    (void)state;
    for (size_t i = 0; i < N_MAX; i++) {
        random = random * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
        uint32_t u = (uint32_t)(random >> 40), v = (uint32_t)(random >> 16) & 0xffffff;
        data[i] = (uint8_t)((uint64_t)u * v >> 40); /* small values are likelier */
        count[data[i]]++;
    }
    for (int s = 0; s < 256; s++)
        if (count[s])
            bits -= (double)count[s] * log2((double)count[s] / N_MAX);
    double nbytes = (double)check(N_MAX);
    assert_true(nbytes > bits / 8.0);
    assert_true(nbytes < 1.01 * bits / 8.0);
}

/* Codes of 64 bytes at once, where the machine has them, are those of one byte after another. */
static void test_wide(void **state)
{
    uint32_t value[256], length[256];
    static uint8_t other[2 * 1000 + 8];
    (void)state;
    for (uint32_t s = 0; s < 256; s++) {
        length[s] = 1 + s * s % 14;
        value[s] = s * 2654435761u >> 8 & ((1u << length[s]) - 1);
    }
    for (size_t i = 0; i < 1000; i++)
        data[i] = (uint8_t)(i * i * 37 >> 3 & 255);
    for (size_t n = 0; n < 1000; n += 61) {
        struct rmap_bits wide = {.out = block}, narrow = {.out = other};
        size_t done = rmap_huffman_wide(value, length, data, n, &wide);
        assert_true(done == 0 || done == n / 64 * 64);
        for (size_t i = 0; i < done; i++)
            rmap_bits_put(&narrow, value[data[i]], length[data[i]]);
        assert_int_equal(wide.n, narrow.n);
        assert_int_equal(wide.waiting, narrow.waiting);
        assert_int_equal(wide.out - block, narrow.out - other);
        assert_memory_equal(block, other, (size_t)(narrow.out - other));
    }
}

static void test_uniform(void **state)
{
    static const uint8_t byte[] = {0, 1, 2, 3, 10, 11, 12, 137, 138, 139, 150, 244, 245, 254, 255};
    (void)state;
    for (size_t k = 0; k < sizeof byte; k++) {
        memset(data, byte[k], N_MAX);
        for (size_t n = 1; n < 4 * 258; n++) {
            size_t room = RMAP_UNIFORM_BOUND + n / 8;
            memset(block, 77, room + 1);
            check_blocks(rmap_uniform_plane(byte[k], n, block), n);
            assert_int_equal(block[room], 77);
        }
    }
    memset(data, 0, N_MAX);
    size_t nbytes = rmap_uniform_plane(0, 65536, block);
    assert_true(nbytes < 100);
    check_blocks(nbytes, 65536);
    check_blocks(rmap_uniform_plane(0, N_MAX, block), N_MAX);
}

static void test_no_room(void **state)
{
    (void)state;
    memset(data, 1, 1000);
    data[500] = 2;
    block[260] = 77;
    assert_int_equal(rmap_huffman_plane(data, 1000, block, 260), 0);
    assert_int_equal(block[260], 77);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_any_length), cmocka_unit_test(test_one_symbol),
        cmocka_unit_test(test_deep_tree),  cmocka_unit_test(test_near_entropy),
        cmocka_unit_test(test_wide),       cmocka_unit_test(test_uniform),
        cmocka_unit_test(test_no_room),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

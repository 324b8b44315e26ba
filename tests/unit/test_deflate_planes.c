/* SPDX-License-Identifier: MIT
 *
 * A plane becomes the same bytes whichever deflater takes it, wherever that lies in memory and
 * whatever it did before; and by zlib these are the plane again.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>
#include <zlib.h>

#include "base/alloc.h"
#include "io/codec/deflate_planes.h"

enum { N_DEFLATER = 64, N_PLANE = 40, N_MAX = 70000 };

static uint8_t data[N_MAX], back[N_MAX];

static uint8_t next_letter(uint32_t *state)
{
    *state = *state * UINT32_C(1664525) + UINT32_C(1013904223);
    return (uint8_t)(*state >> 26);
}

/* Two letters, then words of a few, with a letter between: what is found again begins where a word
 * does, the first of them at position 2. */
static void write_words(size_t n, uint32_t seed)
{
    enum { N_WORD = 6, LENGTH = 8 };
    uint8_t word[N_WORD][LENGTH];
    uint32_t state = seed * UINT32_C(2654435761) + 1;
    for (int k = 0; k < N_WORD * LENGTH; k++)
        word[k / LENGTH][k % LENGTH] = next_letter(&state);
    data[0] = next_letter(&state);
    for (size_t i = 1; i < n; i += LENGTH + 1) {
        data[i] = next_letter(&state);
        const uint8_t *next = word[next_letter(&state) % N_WORD];
        memcpy(data + i + 1, next, n - i - 1 < LENGTH ? n - i - 1 : LENGTH);
    }
}

static size_t n_of(uint32_t plane)
{
    return plane < N_PLANE - 2 ? 100 + 11 * (size_t)plane : N_MAX - 100 * (size_t)plane;
}

static void check_back(const uint8_t *stream, size_t nbytes, size_t n)
{
    uLongf n_back = sizeof back;
    assert_int_equal(uncompress(back, &n_back, stream, (uLong)nbytes), Z_OK);
    assert_int_equal(n_back, n);
    assert_memory_equal(back, data, n);
}

/* All are alive at once, so no two lie at one place. */
static void test_equal_bytes(void **state)
{
    (void)state;
    struct rmap_deflater *deflater[N_DEFLATER];
    struct rmap_plane_habit habit = {0};
    const size_t bound = rmap_deflate_bound(1, N_MAX);
    uint8_t *first = rmap_alloc(bound, 1), *other = rmap_alloc(bound, 1);
    assert_non_null(first);
    assert_non_null(other);
    for (int k = 0; k < N_DEFLATER; k++)
        assert_int_equal(rmap_deflater_create(&deflater[k], NULL), RMAP_OK);
    for (uint32_t plane = 0; plane < N_PLANE; plane++) {
        const size_t n = n_of(plane);
        write_words(n, plane);
        size_t nbytes = rmap_deflate_planes(deflater[0], NULL, data, n, 1, n, 0, first).nbytes;
        check_back(first, nbytes, n);
        for (int k = 1; k < N_DEFLATER; k++) {
            size_t again = rmap_deflate_planes(deflater[k], NULL, data, n, 1, n, 0, other).nbytes;
            assert_int_equal(again, nbytes);
            assert_memory_equal(other, first, nbytes);
        }
        /* Whatever the planes before were. */
        check_back(other, rmap_deflate_planes(deflater[0], &habit, data, n, 1, n, 0, other).nbytes,
                   n);
    }
    for (int k = 0; k < N_DEFLATER; k++)
        rmap_deflater_destroy(deflater[k]);
    rmap_free(first);
    rmap_free(other);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_equal_bytes)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

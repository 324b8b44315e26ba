/* SPDX-License-Identifier: MIT
 *
 * Elements to byte planes and back, at every alignment.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/rng.h"
#include "io/codec/shuffle.h"

enum { MOST = 3000, STRIDE = 4096 };

static void fill(uint8_t *byte, size_t n)
{
    for (size_t i = 0; i < n; i++) {
        double u[4];
        rmap_rng(7, i, 0, RMAP_RNG_EMIT_POINT, u);
        byte[i] = (uint8_t)(256 * u[0]);
    }
}

static void check(const uint64_t *element, size_t n, size_t nbytes, size_t at)
{
    static uint8_t plane[8 * STRIDE], back[8 * MOST];
    const uint8_t *byte = (const uint8_t *)element;
    memset(plane, 0xa5, sizeof plane);
    rmap_shuffle(element, n, nbytes, plane + at, STRIDE);
    for (size_t i = 0; i < n; i++)
        for (size_t k = 0; k < nbytes; k++)
            assert_int_equal(plane[k * STRIDE + at + i], byte[i * nbytes + k]);
    rmap_unshuffle(plane + at, STRIDE, 0, n, nbytes, back);
    assert_memory_equal(back, element, n * nbytes);
}

static void test_planes_hold_what_elements_do(void **state)
{
    static uint64_t element[MOST];
    (void)state;
    fill((uint8_t *)element, sizeof element);
    for (size_t nbytes = 1; nbytes <= 8; nbytes *= 2)
        for (size_t at = 0; at < 70; at++)
            for (size_t n = at % 3; n < MOST; n = 3 * n + 1 + at)
                check(element, n, nbytes, at);
    check(element, MOST, 4, 1);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_planes_hold_what_elements_do),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

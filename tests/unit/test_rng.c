/* SPDX-License-Identifier: MIT
 *
 * Random streams: known answers of Philox4x32-10 (kat_vectors of Salmon et al. 2011), range,
 * independence of streams.
 */
#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

#include "base/rng.h"

static void assert_bits(const double u[4], const uint32_t bits[4])
{
    for (int i = 0; i < 4; i++)
        assert_true(u[i] == ((double)bits[i] + 0.5) / 4294967296.0);
}

static void known_answers(void **state)
{
    (void)state;
    double u[4];
    rmap_rng(0, 0, 0, RMAP_RNG_EMIT_POINT, u);
    assert_bits(u, (const uint32_t[4]){0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8});
    rmap_rng(UINT64_MAX, UINT64_MAX, UINT32_MAX, (enum rmap_rng_slot)UINT32_MAX, u);
    assert_bits(u, (const uint32_t[4]){0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd});
    rmap_rng(0x299f31d0a4093822, 0x85a308d3243f6a88, 0x13198a2e, (enum rmap_rng_slot)0x03707344, u);
    assert_bits(u, (const uint32_t[4]){0xd16cfe09, 0x94fdcceb, 0x5001e420, 0x24126ea1});
}

/* The mean of n uniform numbers lies within 5 standard errors of 1/2, and so for squares. */
static void uniform_moments(void **state)
{
    (void)state;
    enum { N = 100000 };
    double sum = 0.0, square = 0.0;
    for (uint64_t ray = 0; ray < N; ray++) {
        double u[4];
        rmap_rng(7, ray, 3, RMAP_RNG_SURFACE, u);
        for (int i = 0; i < 4; i++) {
            assert_true(u[i] > 0.0 && u[i] < 1.0);
            sum += u[i];
            square += u[i] * u[i];
        }
    }
    double n = 4.0 * N;
    assert_true(fabs(sum / n - 0.5) < 5.0 * sqrt(1.0 / 12.0 / n));
    assert_true(fabs(square / n - 1.0 / 3.0) < 5.0 * sqrt(4.0 / 45.0 / n));
}

static void every_argument_counts(void **state)
{
    (void)state;
    double base[4], other[4];
    rmap_rng(1, 2, 3, RMAP_RNG_EMIT_POINT, base);
    rmap_rng(1ull << 32 | 1, 2, 3, RMAP_RNG_EMIT_POINT, other);
    assert_true(base[0] != other[0]);
    rmap_rng(1, 1ull << 32 | 2, 3, RMAP_RNG_EMIT_POINT, other);
    assert_true(base[0] != other[0]);
    rmap_rng(1, 2, 4, RMAP_RNG_EMIT_POINT, other);
    assert_true(base[0] != other[0]);
    rmap_rng(1, 2, 3, RMAP_RNG_MEDIUM, other);
    assert_true(base[0] != other[0]);
    rmap_rng(1, 2, 3, RMAP_RNG_EMIT_POINT, other);
    for (int i = 0; i < 4; i++)
        assert_true(base[i] == other[i]);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(known_answers),
        cmocka_unit_test(uniform_moments),
        cmocka_unit_test(every_argument_counts),
    };
    return cmocka_run_group_tests_name("rng", test, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Chunks that are elements in a cycle.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "io/codec/shuffle.h"
#include "io/map/chunk_cycle.h"

enum { ROWS = 1000, CYCLE = 7 };
static const int32_t element[CYCLE] = {3, 0, 1, 300, 2, 0, 5};

/* Planes of rows that follow the cycle from a phase on. */
static void lay(size_t phase, int32_t *row, uint8_t *plane)
{
    for (size_t i = 0; i < ROWS; i++)
        row[i] = element[(phase + i) % CYCLE];
    rmap_shuffle(row, ROWS, sizeof *row, plane, ROWS);
}

static bool follows(size_t n, size_t phase, const uint8_t *plane, size_t n_lead, size_t n_row)
{
    const struct rmap_cycle cycle = {element, n, phase};
    struct rmap_error err = {0};
    bool yes = false;
    assert_int_equal(
        rmap_cycle_compare(&cycle, sizeof *element, plane, ROWS, n_lead, n_row, &yes, &err),
        RMAP_OK);
    return yes;
}

static void test_compare(void **state)
{
    int32_t row[ROWS];
    uint8_t plane[sizeof row];
    (void)state;
    for (size_t phase = 0; phase < CYCLE; phase++) {
        lay(phase, row, plane);
        assert_true(follows(CYCLE, phase, plane, 4, ROWS));
        assert_true(follows(CYCLE, phase, plane, 2, ROWS));  /* the others are 0 */
        assert_false(follows(CYCLE, phase, plane, 1, ROWS)); /* 300 has a second byte */
        assert_false(follows(CYCLE, (phase + 1) % CYCLE, plane, 4, ROWS));
        assert_false(follows(CYCLE - 1, 0, plane, 4, ROWS));
        assert_true(follows(CYCLE, phase, plane, 4, 3)); /* less than a cycle */
        plane[ROWS - 1] ^= 1;
        assert_false(follows(CYCLE, phase, plane, 4, ROWS));
        assert_true(follows(CYCLE, phase, plane, 4, ROWS - 1));
    }
}

static void test_remembers(void **state)
{
    struct rmap_cycle_chunks chunks = {.n = 0};
    const struct rmap_cycle cycle = {element, CYCLE, 2}, other = {element, CYCLE, 3};
    uint8_t stored[RMAP_CYCLE_STORED_MOST] = {0};
    (void)state;
    assert_null(rmap_cycle_chunks_find(&chunks, stored, 0, ROWS, &cycle));
    for (uint8_t k = 0; k < 2 * RMAP_CYCLES_KNOWN; k++) {
        stored[9] = k;
        struct rmap_cycle_chunk *chunk =
            rmap_cycle_chunks_add(&chunks, stored, sizeof stored, ROWS, &cycle);
        assert_false(chunk->follows);
        chunk->follows = true;
        assert_ptr_equal(rmap_cycle_chunks_find(&chunks, stored, sizeof stored, ROWS, &cycle),
                         chunk);
        assert_null(rmap_cycle_chunks_find(&chunks, stored, sizeof stored - 1, ROWS, &cycle));
        assert_null(rmap_cycle_chunks_find(&chunks, stored, sizeof stored, ROWS - 1, &cycle));
        assert_null(rmap_cycle_chunks_find(&chunks, stored, sizeof stored, ROWS, &other));
    }
    stored[9] = RMAP_CYCLES_KNOWN - 1; /* the oldest ones made room */
    assert_null(rmap_cycle_chunks_find(&chunks, stored, sizeof stored, ROWS, &cycle));
    stored[9] = RMAP_CYCLES_KNOWN;
    assert_non_null(rmap_cycle_chunks_find(&chunks, stored, sizeof stored, ROWS, &cycle));
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_compare),
                                       cmocka_unit_test(test_remembers)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

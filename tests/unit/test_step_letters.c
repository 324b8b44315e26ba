/* SPDX-License-Identifier: MIT
 *
 * Steps of many legs at once: what the tables of letters say, one by one.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/paths/step_letters.h"
#include "portion/event.h"

enum { CODES = 1 << 13, ANY = 13, INSIDE = 1 << 4 | 1 << 10, N = 100 };
static const char *const letters_in_order = "EKOFSIRTDdAXV";

static void fill_table(uint8_t table[CODES])
{
    for (uint32_t events = 0; events < CODES; events++) {
        const char c = rmap_event_letter(events);
        table[events] = c ? (uint8_t)(strchr(letters_in_order, c) - letters_in_order) : ANY;
    }
}

/* Every set of events, at objects from none to the last, from every place of a block on. */
static void test_steps(void **state)
{
    (void)state;
    static uint8_t table[CODES];
    static int32_t object[CODES + 16];
    static uint32_t event[CODES + 16];
    static uint16_t step[CODES + 16];
    struct rmap_step_letters letters;
    fill_table(table);
    rmap_step_letters_init(&letters, table, INSIDE);
    for (size_t i = 0; i < CODES + 16; i++) {
        event[i] = (uint32_t)(i * 4099 % CODES);
        object[i] = (int32_t)(i * 911 % 4096) - 1;
    }
    for (size_t first = 0; first < 16; first++) {
        bool inside;
        memset(step, 0, sizeof step);
        const size_t n = rmap_step_letters_steps(&letters, object + first, event + first, CODES,
                                                 step + first, &inside);
        assert_true(n == (letters.is_usable ? CODES : 0));
        for (size_t i = first; i < first + n; i++)
            assert_int_equal(step[i], (uint16_t)((object[i] + 1) << 4 | table[event[i] % CODES]));
    }
}

/* Absorption and scattering without an object are told of, wherever they stand; at an object, or
 * another event without one, are not. */
static void test_inside(void **state)
{
    (void)state;
    static const uint32_t telling[] = {RMAP_EVENT_ABSORB, RMAP_EVENT_SCATTER_VOLUME};
    static uint8_t table[CODES];
    struct rmap_step_letters letters;
    fill_table(table);
    rmap_step_letters_init(&letters, table, INSIDE);
    for (size_t n = 0; n <= N; n++)
        for (size_t at = 0; at < n; at++)
            for (int k = 0; k < 2; k++) {
                int32_t object[N];
                uint32_t event[N];
                uint16_t step[N];
                bool inside;
                for (size_t i = 0; i < n; i++) {
                    object[i] = i % 3 == 0 ? -1 : 5;
                    event[i] = object[i] < 0 ? RMAP_EVENT_LEFT : telling[i % 2];
                }
                const size_t before =
                    rmap_step_letters_steps(&letters, object, event, n, step, &inside);
                assert_false(inside);
                object[at] = -1;
                event[at] = telling[k];
                assert_int_equal(rmap_step_letters_steps(&letters, object, event, n, step, &inside),
                                 before);
                assert_int_equal(inside, at < before);
            }
}

/* Letters that are not the least of their bits' are left to others. */
static void test_unusable(void **state)
{
    (void)state;
    static uint8_t table[CODES];
    struct rmap_step_letters letters;
    bool inside = true;
    int32_t object[N] = {0};
    uint32_t event[N] = {0};
    uint16_t step[N];
    fill_table(table);
    table[RMAP_EVENT_ABSORB | RMAP_EVENT_ERROR] = 3;
    rmap_step_letters_init(&letters, table, INSIDE);
    assert_false(letters.is_usable);
    assert_int_equal(rmap_step_letters_steps(&letters, object, event, N, step, &inside), 0);
    assert_false(inside);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_steps), cmocka_unit_test(test_inside),
                                       cmocka_unit_test(test_unusable)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

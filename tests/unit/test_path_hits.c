/* SPDX-License-Identifier: MIT
 *
 * Registrations mixed into hashes: the same whether eight rays are taken abreast, or one by one as
 * where a row of the portion is not registered.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "analysis/paths/path_hash.h"
#include "analysis/paths/path_key_internal.h"
#include "base/alloc.h"

enum { N_RAY = 203, HITS_MOST = 40, N_ROW = N_RAY * HITS_MOST + 1 };

static uint32_t draw(uint64_t *state, uint32_t n)
{
    *state = *state * UINT64_C(6364136223846793005) + 1442695040888963407u;
    return (uint32_t)((*state >> 33) % n);
}

struct rays {
    uint64_t low[N_RAY], high[N_RAY];
    uint32_t registration[N_RAY], n_leg[N_RAY], n_hit[N_RAY];
};

/* Mostly few registrations, in any order, some behind the last leg. Returns their number. */
static size_t make(struct rays *rays, uint32_t hits_most, uint32_t n_detector, uint32_t *segment,
                   int32_t *detector, uint64_t *state)
{
    uint32_t n = 0;
    for (size_t k = 0; k < N_RAY; k++) {
        rays->low[k] = (uint64_t)draw(state, UINT32_MAX) << 32 | draw(state, UINT32_MAX);
        rays->high[k] = ~rays->low[k] * 3;
        rays->n_leg[k] = draw(state, 30);
        rays->registration[k] = n;
        rays->n_hit[k] = draw(state, 8) ? draw(state, 3) : draw(state, hits_most + 1);
        for (uint32_t i = 0; i < rays->n_hit[k]; i++, n++) {
            segment[n] = draw(state, 50) ? draw(state, 31) : UINT32_MAX - draw(state, 2);
            detector[n] = (int32_t)draw(state, n_detector);
        }
    }
    return n;
}

static void mix(const struct rmap_path_keys *keys, struct rmap_portion *portion, struct rays *rays)
{
    struct rmap_path_hits hits = {0};
    struct rmap_error err;
    const struct rmap_path_keyed keyed = {.n = N_RAY,
                                          .low = rays->low,
                                          .high = rays->high,
                                          .registration = rays->registration,
                                          .n_leg = rays->n_leg,
                                          .n_hit = rays->n_hit};
    assert_int_equal(rmap_path_hits_enter(&hits, keys, portion, &err), RMAP_OK);
    rmap_path_hits_mix(&hits, keys, portion, &keyed);
    rmap_path_hits_fini(&hits);
}

static void check(uint32_t hits_most, uint32_t n_detector)
{
    static uint32_t segment[N_ROW];
    static int32_t detector[N_ROW];
    static uint8_t registered[N_ROW];
    static struct rays wide, plain;
    struct rmap_path_hit hit[] = {{0x1234, 1}, {0x55, 0}, {0x9876, 1}};
    const struct rmap_scene scene = {.n_detector = n_detector};
    const struct rmap_path_keys keys = {.scene = &scene, .hit = hit};
    uint64_t state = hits_most + 100 * n_detector;
    const size_t n = make(&wide, hits_most, n_detector, segment, detector, &state);
    struct rmap_portion portion = {
        .registration = {.segment = segment, .detector = detector, .registered = registered}};
    plain = wide;
    memset(registered, 1, n);
    portion.n_row[RMAP_TABLE_REGISTRATION] = n;
    mix(&keys, &portion, &wide);
    registered[n] = 0; /* of no ray here */
    segment[n] = 0;
    detector[n] = 0;
    portion.n_row[RMAP_TABLE_REGISTRATION] = n + 1;
    mix(&keys, &portion, &plain);
    assert_memory_equal(&wide, &plain, sizeof wide);
}

static void test_alike(void **state)
{
    (void)state;
    static const uint32_t most[] = {0, 1, 2, 5, HITS_MOST};
    for (size_t m = 0; m < sizeof most / sizeof *most; m++)
        for (uint32_t n_detector = 1; n_detector <= 3; n_detector++)
            check(most[m], n_detector);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_alike)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * The promise: a portion that says which of its rays arrive at detectors gives these rays, and all
 * registrations, without the references of the others; where it cannot say so, it is left as it is;
 * and rows that do not fit together are refused.
 */
#include "compact_rig.h"

#include "base/rng.h"
#include "compact/arrivals.h"
#include "compact/own_lengths.h"

enum { RAYS = 4096, FLIPS = 4000 };

/* What the reader of these alone has: not the references, nor channels. */
static struct rmap_rows without_others(const struct rmap_rows *own)
{
    struct rmap_rows rows = *own;
    rows.data[RMAP_STREAM_ray_path] = rows.data[RMAP_STREAM_ray_channel] = NULL;
    rows.data[RMAP_STREAM_patch_skip] = rows.data[RMAP_STREAM_patch_value] = NULL;
    rows.data[RMAP_STREAM_triangle] = rows.data[RMAP_STREAM_pool32] = NULL;
    return rows;
}

/* Narrowed where *told_ret says so, and decoded. */
static enum rmap_status read_arrivals(struct rig *rig, const struct rmap_path_table *table,
                                      struct rmap_rows *rows, const struct rmap_portion *like,
                                      bool *told_ret)
{
    struct rmap_arrivals arrivals = {.cap = 0};
    struct rmap_compact_summary summary;
    struct rmap_error err = {0};
    size_t n_row[RMAP_TABLE_COUNT];
    memcpy(n_row, like->n_row, sizeof n_row);
    enum rmap_status st = rmap_compact_summarise_header(rows, &summary, &err);
    if (st == RMAP_OK)
        st = rmap_arrivals_find(&arrivals, table, like->timed, rows, &summary, n_row, told_ret,
                                &err);
    if (st == RMAP_OK && *told_ret)
        rmap_arrivals_narrow(&arrivals, rows, n_row);
    if (st == RMAP_OK && *told_ret)
        st = rmap_compact_decode(rig->decoder, table, rows, n_row, RMAP_COLUMNS_ARRIVAL, 0,
                                 rig->decoded, &err);
    rmap_arrivals_fini(&arrivals);
    return st;
}

/* The portion's rays that arrive. */
static struct rmap_portion *gather(const struct rmap_portion *all, const uint32_t *path)
{
    struct rmap_portion *some = NULL;
    struct rmap_error err = {0};
    size_t segment = 0, registration = 0;
    rig_ok(rmap_portion_create(1, all->n_channel, &some, &err), &err);
    for (size_t i = 0; i < all->n_row[RMAP_TABLE_RAY]; i++) {
        if (rmap_arrives(path[i], all->ray.registration_count[i]))
            rig_ok(rmap_portion_append_ray(some, all, i, segment, registration, &err), &err);
        segment += all->ray.segment_count[i];
        registration += all->ray.registration_count[i];
    }
    return some;
}

static void check_arrivals(const char *scene, bool expected)
{
    struct rig rig;
    struct rmap_error err = {0};
    bool is_told = false;
    rig_open(&rig, scene);
    for (uint64_t first = 0; first < 3 * (uint64_t)RAYS; first += RAYS) {
        struct rmap_rows own;
        struct rmap_path_table *table = NULL;
        struct rmap_portion *portion = rig_trace(&rig, first, RAYS);
        rig_encode(&rig, RIG_SEED, portion, &own);
        rig_ok(rmap_path_table_create(rig.model, &rig.whole, &table, &err), &err);
        struct rmap_rows rows = without_others(&own), before = rows;
        struct rmap_portion *some = gather(portion, own.data[RMAP_STREAM_ray_path]);
        assert_int_equal(read_arrivals(&rig, table, &rows, portion, &is_told), RMAP_OK);
        if (is_told) {
            assert_true(RMAP_ARRIVALS_SHARE * some->n_row[RMAP_TABLE_RAY] <= RAYS);
            assert_memory_equal(rig.decoded->n_row, some->n_row, sizeof some->n_row);
            assert_columns_equal(some, rig.decoded, RMAP_COLUMNS_ARRIVAL);
        } else {
            assert_memory_equal(&rows, &before, sizeof rows);
        }
        rmap_portion_destroy(some);
        rmap_path_table_destroy(table);
        rows_free(&own);
        rmap_portion_destroy(portion);
    }
    assert_int_equal(is_told, expected); /* of the last, whose paths are known */
    rig_close(&rig);
}

static void test_arrivals(void **state)
{
    (void)state;
    check_arrivals(RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml", true);
    check_arrivals(RAYMAP_SOURCE_DIR "/examples/room/scene.yaml", false);
}

/* Bits that turned lead to a refusal or to other rays, never astray. */
static void test_damage(void **state)
{
    struct rig rig;
    struct rmap_error err = {0};
    struct rmap_rows own;
    struct rmap_path_table *table = NULL;
    size_t n_refused = 0;
    bool is_told;
    (void)state;
    rig_open(&rig, RAYMAP_SOURCE_DIR "/examples/double-gauss/scene.yaml");
    struct rmap_portion *portion = rig_trace(&rig, 0, RAYS);
    rig_encode(&rig, RIG_SEED, portion, &own);
    rows_free(&own);
    rig_encode(&rig, RIG_SEED, portion, &own); /* now its paths are known */
    rig_ok(rmap_path_table_create(rig.model, &rig.whole, &table, &err), &err);
    const int stream[] = {RMAP_STREAM_pool16, RMAP_STREAM_pool64, RMAP_STREAM_OWN_segment_count};
    for (uint64_t i = 0; i < FLIPS; i++) {
        double u[4];
        rmap_rng(5, i, 0, 0, u);
        const int s = stream[i % 3];
        const size_t nbytes = stream_nbytes(&own, s);
        if (nbytes == 0)
            continue;
        uint8_t *byte = (uint8_t *)own.data[s] + (size_t)(u[0] * (double)nbytes);
        const uint8_t bit = (uint8_t)(1U << (unsigned)(u[1] * 8.0));
        struct rmap_rows rows = without_others(&own);
        *byte ^= bit;
        const enum rmap_status st = read_arrivals(&rig, table, &rows, portion, &is_told);
        *byte ^= bit;
        assert_true(st == RMAP_OK || st == RMAP_FORMAT);
        n_refused += st == RMAP_FORMAT;
    }
    assert_true(n_refused > FLIPS / 20);

    /* More than there are rays. */
    struct rmap_rows rows = without_others(&own);
    portion->n_row[RMAP_TABLE_RAY] = 10;
    assert_int_equal(read_arrivals(&rig, table, &rows, portion, &is_told), RMAP_FORMAT);
    portion->n_row[RMAP_TABLE_RAY] = RAYS;

    /* None, though there are registrations. */
    uint64_t *flags = own.data[RMAP_STREAM_pool64];
    uint16_t *end = (uint16_t *)own.data[RMAP_STREAM_pool16] + own.n_row[RMAP_COMPACT_POOL16];
    const size_t n = *flags >> 32 & 0xffff;
    const size_t behind = rmap_own_length_rows(own.n_row[RMAP_COMPACT_OWN]);
    assert_true(n > 0 && own.n_row[RMAP_COMPACT_OWN] > 0);
    memmove(end - behind - n, end - behind, behind * sizeof *end);
    rows = without_others(&own);
    rows.n_row[RMAP_COMPACT_POOL16] -= n;
    *flags &= ~(UINT64_C(0xffff) << 32);
    assert_int_equal(read_arrivals(&rig, table, &rows, portion, &is_told), RMAP_FORMAT);
    rmap_path_table_destroy(table);
    rows_free(&own);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_arrivals),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

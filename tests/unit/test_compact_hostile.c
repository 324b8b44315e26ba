/* SPDX-License-Identifier: MIT
 *
 * The compact encoding on portions that no tracer makes, and on damaged rows: every bit of the
 * former comes back, the latter are refused or give some numbers, and never read out of bounds.
 */
#include "compact/paths.h"
#include "compact_rig.h"

static const char small_scene[] =
    "raymap: 1\n"
    "spectrum: {mode: spectral, wavelengths: [450, 500, 550]}\n"
    "media: {air: {index: 1}, glass: {index: 1.5}}\n"
    "surfaces: {clear: {type: fresnel}, white: {type: lambert, reflectance: 0.5}}\n"
    "geometries:\n"
    "  ball: {type: sphere, radius: 3}\n"
    "  plate: {type: rectangle, size: [40, 40]}\n"
    "  board: {type: mesh, file: " RAYMAP_SOURCE_DIR "/examples/room/meshes/board.ply}\n"
    "objects:\n"
    "  - {name: ball, geometry: ball, surface: clear, inside: glass, outside: air}\n"
    "  - {name: floor, geometry: plate, at: [0, 0, 5], surface: white, front: air, back: air}\n"
    "  - {name: board, geometry: board, scale: 20, at: [0, 0, -9], surface: clear, inside: glass, "
    "outside: air}\n"
    "sources: [{name: bulb, type: point, at: [0, 0, -5], flux: 1 W, medium: air}]\n"
    "detectors: [{name: eye, type: plane, size: [9, 9], cells: [9, 9], at: [0, 0, 4], "
    "direction: [0, 0, 1]}]\n";

static uint64_t next_bits(uint64_t *state)
{
    *state ^= *state << 13;
    *state ^= *state >> 7;
    *state ^= *state << 17;
    return *state * UINT64_C(0x2545F4914F6CDD1D);
}

/* Every column but the counts full of random bytes. */
static struct rmap_portion *garbage(const struct rig *rig, size_t n_ray, uint32_t segments_max,
                                    uint64_t seed)
{
    struct rmap_error err = {0};
    struct rmap_portion *portion = NULL;
    size_t n_row[RMAP_TABLE_COUNT] = {n_ray, 0, 0};
    rig_ok(rmap_portion_create(n_ray, rig->scene->channels.n, &portion, &err), &err);
    for (size_t i = 0; i < n_ray; i++) {
        portion->ray.segment_count[i] = (uint32_t)(next_bits(&seed) >> 32) % (segments_max + 1);
        portion->ray.registration_count[i] = (uint32_t)(next_bits(&seed) >> 32) % 3;
        n_row[RMAP_TABLE_SEGMENT] += portion->ray.segment_count[i];
        n_row[RMAP_TABLE_REGISTRATION] += portion->ray.registration_count[i];
    }
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        rig_ok(rmap_portion_reserve(portion, (enum rmap_table)t, n_row[t], RMAP_COLUMNS_ALL, &err),
               &err);
    memcpy(portion->n_row, n_row, sizeof n_row);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        if (!(rmap_columns_of_run(portion->timed) >> c & 1))
            continue;
        enum rmap_column column = (enum rmap_column)c;
        size_t nbytes =
            rmap_portion_row_nbytes(portion, column) * n_row[rmap_column_info(column)->table];
        uint8_t *data = rmap_portion_column(portion, column);
        if (column == RMAP_RAY_segment_count || column == RMAP_RAY_registration_count)
            continue;
        for (size_t i = 0; i < nbytes; i++)
            data[i] = (uint8_t)(next_bits(&seed) >> 56);
    }
    portion->first_ray = next_bits(&seed);
    return portion;
}

/* Paths as if traced, all the rest garbage, with unknown objects and triangles here and there. */
static void make_likely(const struct rig *rig, struct rmap_portion *portion, uint64_t seed)
{
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        portion->ray.source[i] = (int32_t)(next_bits(&seed) % 2) - 1 + (i % 9 != 0);
        portion->ray.stop[i] = (uint8_t)(next_bits(&seed) % 5);
        portion->ray.start_object[i] = -1;
    }
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_SEGMENT]; i++) {
        int32_t object = (int32_t)(next_bits(&seed) % 5) - 1;
        portion->segment.object[i] = i % 100 == 0 ? 100000 + object : object;
        portion->segment.primitive[i] =
            i % 90 == 0 ? INT32_MIN : (int32_t)(next_bits(&seed) % 3000);
        portion->segment.event[i] = UINT32_C(1) << (next_bits(&seed) % 14);
        portion->segment.medium[i] = (int16_t)(next_bits(&seed) % 3);
    }
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_REGISTRATION]; i++) {
        portion->registration.segment[i] = (uint32_t)(next_bits(&seed) % 6);
        portion->registration.detector[i] = (int32_t)(next_bits(&seed) % 3) - 1;
    }
    (void)rig;
}

static void test_garbage(void **state)
{
    (void)state;
    struct rig rig;
    rig_open_text(&rig, small_scene);
    for (uint64_t k = 1; k <= 12; k++) {
        struct rmap_portion *portion = garbage(&rig, k * 20, (uint32_t)k * 2, k);
        rig_roundtrip(&rig, k, portion);
        make_likely(&rig, portion, k);
        rig_roundtrip(&rig, k, portion);
        rmap_portion_destroy(portion);
    }
    rig_close(&rig);
}

/* Objects and triangles beyond 16 bits, no numbers, infinite numbers, absorption in a medium. */
static void test_odd_numbers(void **state)
{
    (void)state;
    struct rig rig;
    rig_open_text(&rig, small_scene);
    struct rmap_portion *portion = rig_trace(&rig, 0, 300);
    size_t n = portion->n_row[RMAP_TABLE_SEGMENT];
    for (size_t i = 0; i < n; i += 11) {
        portion->segment.position[3 * i] = NAN;
        portion->segment.position[3 * i + 1] = i % 2 ? INFINITY : -INFINITY;
    }
    for (size_t i = 5; i < n; i += 13) {
        portion->segment.object[i] = (int32_t)(70000 + i);
        portion->segment.primitive[i] = 100000;
    }
    for (size_t i = 3; i < n; i += 17) {
        portion->segment.object[i] = -1;
        portion->segment.primitive[i] = -1;
        portion->segment.event[i] = RMAP_EVENT_SCATTER_VOLUME;
    }
    portion->ray.start[0] = NAN;
    portion->ray.path_length[1] = INFINITY;
    portion->ray.id[200] = UINT64_MAX;
    rig_roundtrip(&rig, RIG_SEED, portion);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* One ray of 60,000 segments, its like again, and a portion of such rays that overflows the
 * dictionary's rows. */
static void test_long_rays(void **state)
{
    (void)state;
    struct rig rig;
    rig_open_text(&rig, small_scene);
    struct rmap_portion *portion = garbage(&rig, 1, 0, 3);
    struct rmap_error err = {0};
    portion->n_row[RMAP_TABLE_SEGMENT] = 0;
    rig_ok(rmap_portion_reserve(portion, RMAP_TABLE_SEGMENT, 60000, RMAP_COLUMNS_ALL, &err), &err);
    portion->n_row[RMAP_TABLE_SEGMENT] = portion->ray.segment_count[0] = 60000;
    portion->n_row[RMAP_TABLE_REGISTRATION] = portion->ray.registration_count[0] = 0;
    memset(portion->segment.normal, 0, 60000 * 6);
    memset(portion->colour, 0, 60000 * 6);
    memset(portion->segment.position, 0, 60000 * 12);
    make_likely(&rig, portion, 8);
    for (int k = 0; k < 3; k++)
        rig_roundtrip(&rig, RIG_SEED, portion);
    assert_int_equal(rig.whole.n_row[RMAP_COMPACT_PATH], 1);
    assert_int_equal(rig.whole.n_row[RMAP_COMPACT_PATH_SEGMENT], 60000);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

/* What follows no rule at all costs no more than plain by more than 1 %. */
static void test_cost(void **state)
{
    (void)state;
    struct rig rig;
    struct rmap_error err = {0};
    struct rmap_encoder *codec = NULL;
    rig_open_text(&rig, small_scene);
    rig_ok(rmap_encoder_create(&codec, &err), &err);
    for (int likely = 0; likely < 2; likely++) {
        struct rmap_rows own;
        struct rmap_portion *portion = garbage(&rig, 4096, 16, 99);
        if (likely)
            make_likely(&rig, portion, 7);
        rig_encode(&rig, RIG_SEED, portion, &own);
        double plain = plain_nbytes(codec, portion), compact = compact_nbytes(codec, &own);
        print_message("plain %.0f, compact %.0f bytes\n", plain, compact);
        assert_true(compact <= 1.01 * plain);
        rows_free(&own);
        rmap_portion_destroy(portion);
    }
    rmap_encoder_destroy(codec);
    rig_close(&rig);
}

/* One ray in three of rows that may be damaged, alone: refused, or decoded to something. */
static bool select_some(struct rig *rig, const struct rmap_path_table *table,
                        const struct rmap_rows *own, const size_t *n_row, size_t first)
{
    struct rmap_error err = {0};
    struct rmap_compact_selection *selection = NULL;
    const struct rmap_rows *rows = NULL;
    uint32_t ray[100];
    size_t n = 0, some_row[RMAP_TABLE_COUNT];
    const rmap_column_set columns = RMAP_COLUMNS_ALL & ~RMAP_COLUMNS_CURVE;
    for (size_t i = first; i < n_row[RMAP_TABLE_RAY]; i += 3)
        ray[n++] = (uint32_t)i;
    rig_ok(rmap_compact_selection_create(rig->model, &selection, &err), &err);
    enum rmap_status st =
        rmap_compact_select(selection, table, own, n_row, columns, ray, n, &rows, some_row, &err);
    if (st == RMAP_OK)
        st = rmap_compact_decode(rig->decoder, table, rows, some_row, columns, 0, rig->decoded,
                                 &err);
    assert_true(st == RMAP_OK || st == RMAP_FORMAT);
    rmap_compact_selection_destroy(selection);
    return st == RMAP_OK;
}

/* Rays that are passed over have more triangles than there are. */
static void lack_triangles(struct rig *rig, const struct rmap_rows *own, const size_t *n_row)
{
    struct rmap_error err = {0};
    struct rmap_path_table *table = NULL;
    struct rmap_rows less = *own;
    assert_true(less.n_row[RMAP_COMPACT_TRIANGLE] > 20);
    less.n_row[RMAP_COMPACT_TRIANGLE] = 1;
    rig_ok(rmap_path_table_create(rig->model, &rig->whole, &table, &err), &err);
    for (size_t back = 1; back < 10; back++)
        assert_false(select_some(rig, table, &less, n_row, n_row[RMAP_TABLE_RAY] - back));
    rmap_path_table_destroy(table);
}

/* Decodes rows that may be damaged: refused as such, or decoded to something. */
static bool survives(struct rig *rig, const struct rmap_rows *own, const size_t *n_row)
{
    struct rmap_error err = {0};
    struct rmap_path_table *table = NULL;
    enum rmap_status st = rmap_path_table_create(rig->model, &rig->whole, &table, &err);
    if (st == RMAP_OK)
        (void)select_some(rig, table, own, n_row, 0);
    if (st == RMAP_OK)
        st = rmap_compact_decode(rig->decoder, table, own, n_row, RMAP_COLUMNS_ALL, 0, rig->decoded,
                                 &err);
    rmap_path_table_destroy(table);
    if (st != RMAP_OK)
        assert_int_equal(st, RMAP_FORMAT);
    return st == RMAP_OK;
}

static void test_damage(void **state)
{
    (void)state;
    struct rig rig;
    uint64_t seed = 4242;
    size_t refused = 0;
    rig_open_text(&rig, small_scene);
    struct rmap_portion *portion = rig_trace(&rig, 0, 200);
    struct rmap_rows own;
    portion->segment.position[40] = 1.0f;
    portion->ray.weight[3] = 0.5;
    rig_encode(&rig, RIG_SEED, portion, &own);
    rows_free(&own);
    rig_encode(&rig, RIG_SEED, portion, &own);
    for (int k = 0; k < 4000; k++) {
        int s = (int)(next_bits(&seed) % (uint64_t)rmap_compact_layout.n_stream);
        struct rmap_rows *rows = is_whole(s) ? &rig.whole : &own;
        size_t nbytes = stream_nbytes(rows, s);
        if (nbytes == 0)
            continue;
        uint8_t *data = (uint8_t *)rows->data[s] + next_bits(&seed) % nbytes, was = *data;
        *data ^= (uint8_t)(1u << next_bits(&seed) % 8);
        refused += !survives(&rig, &own, portion->n_row);
        *data = was;
    }
    assert_true(refused > 100);
    for (int t = 0; t < rmap_compact_layout.n_table; t++) { /* a row too few, in a block as long */
        struct rmap_rows less = own;
        bool whole = rmap_compact_layout.whole_tables >> t & 1;
        if (whole || less.n_row[t] == 0)
            continue;
        less.n_row[t]--;
        assert_false(survives(&rig, &less, portion->n_row));
    }
    lack_triangles(&rig, &own, portion->n_row);
    size_t n_row[RMAP_TABLE_COUNT];
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) { /* the index promises others */
        memcpy(n_row, portion->n_row, sizeof n_row);
        n_row[t]++;
        assert_false(survives(&rig, &own, n_row));
    }
    assert_true(survives(&rig, &own, portion->n_row));
    rows_free(&own);
    rmap_portion_destroy(portion);
    rig_close(&rig);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_garbage),   cmocka_unit_test(test_odd_numbers),
        cmocka_unit_test(test_long_rays), cmocka_unit_test(test_cost),
        cmocka_unit_test(test_damage),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

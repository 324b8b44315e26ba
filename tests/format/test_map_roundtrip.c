/* SPDX-License-Identifier: MIT
 *
 * What is written is read: every column of every portion, whatever pieces, shards and threads.
 */
#include "map_fixture.h"

#include <stdatomic.h>
#include <time.h>

#include "base/workers.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"

enum { BLOCK = 500, N_BLOCK = 120 };

static struct rmap_map *index_and_open(struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    return map;
}

static void check_portion(struct fixture *f, struct rmap_cursor *cursor, size_t portion,
                          uint64_t rays)
{
    struct rmap_error err = {0};
    const struct rmap_portion *read = NULL;
    fixture_must(rmap_cursor_read(cursor, portion, &read, &err), &err);
    struct rmap_portion *want = fixture_portion(f, read->first_ray, rays, NULL);
    fixture_compare(read, want);
    rmap_portion_destroy(want);
}

/* reread: how often bytes may be read again, where threads put blocks out of order. */
static void check_map(struct fixture *f, const struct rmap_map *map, double reread)
{
    struct rmap_error err = {0};
    struct rmap_cursor *cursor = NULL;
    struct rmap_map_summary summary;
    struct rmap_digest digest = {0, 0};
    uint64_t n_row[RMAP_TABLE_COUNT] = {0};
    size_t n = rmap_map_n_portion(map);
    assert_int_equal(n, N_BLOCK);
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t i = 0; i < n; i++) {
        check_portion(f, cursor, i, BLOCK);
        assert_int_equal(rmap_map_portion(map, i)->first_ray, i * BLOCK);
        struct rmap_portion *want = fixture_portion(f, i * BLOCK, BLOCK, NULL);
        rmap_digest_add(&digest, rmap_portion_digest(want));
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            n_row[t] += want->n_row[t];
        rmap_portion_destroy(want);
    }
    rmap_map_summarise(map, &summary);
    assert_memory_equal(&summary.digest, &digest, sizeof digest);
    assert_memory_equal(summary.n_row, n_row, sizeof n_row);
    assert_true(summary.complete && summary.seed == 42 && summary.n_rank == 1);
    double bytes_read = (double)rmap_cursor_nbytes(cursor);
    assert_true(bytes_read < (1.0 + reread) * (double)summary.nbytes);
    rmap_cursor_destroy(cursor);
}

static void test_one_shard_many_pieces(void **state)
{
    (void)state;
    static const size_t piece_nbytes[] = {0, 1 << 20, 8 << 20};
    for (size_t k = 0; k < 3; k++) {
        struct fixture f;
        struct rmap_error err = {0};
        fixture_init(&f);
        fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
        fixture_must(fixture_write_shard(&f, 0, 0, N_BLOCK, BLOCK, piece_nbytes[k], &err), &err);
        struct rmap_map *map = index_and_open(&f);
        assert_true(k == 0 ? rmap_map_n_piece(map) == 1 : rmap_map_n_piece(map) > 2);
        check_map(&f, map, 0.0);
        rmap_map_close(map);
        fixture_fini(&f);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

/* Shards whose blocks alternate, columns by halves, portions in a jumbled order. */
static void test_shards_and_columns(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
    for (uint64_t block = 0; block < N_BLOCK; block += 10)
        fixture_must(
            fixture_write_shard(&f, (int)(block / 10 % 3), block, block + 10, BLOCK, 0, &err),
            &err);
    struct rmap_map *map = index_and_open(&f);
    check_map(&f, map, 0.0);
    struct rmap_cursor *cursor = NULL;
    rmap_column_set some = RMAP_COLUMN_BIT(RMAP_SEGMENT_object) |
                           RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
                           RMAP_COLUMN_BIT(RMAP_REGISTRATION_cell);
    fixture_must(rmap_cursor_create(map, some, &cursor, &err), &err);
    for (size_t i = 0; i < N_BLOCK; i++)
        check_portion(&f, cursor, i * 37 % N_BLOCK, BLOCK);
    const struct rmap_portion *read = NULL;
    fixture_must(rmap_cursor_read(cursor, 0, &read, &err), &err);
    assert_null(read->ray.id);
    assert_non_null(read->segment.object);
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

struct crowd {
    struct fixture *f;
    struct rmap_shard_writer *writer;
    _Atomic uint64_t next;
    _Atomic int failures;
};

static void crowd_work(void *context, int thread)
{
    struct crowd *crowd = context;
    struct rmap_error err = {0};
    bool did = true;
    (void)thread;
    for (uint64_t block; (block = atomic_fetch_add(&crowd->next, 1)) < N_BLOCK;) {
        struct rmap_portion *portion = fixture_portion(crowd->f, block * BLOCK, BLOCK, NULL);
        if (rmap_shard_writer_append(crowd->writer, portion, &err) != RMAP_OK)
            atomic_fetch_add(&crowd->failures, 1);
        rmap_portion_destroy(portion);
        if (rmap_shard_writer_encode(crowd->writer, &did, &err) != RMAP_OK)
            atomic_fetch_add(&crowd->failures, 1);
    }
}

static void test_many_threads(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_workers *workers = NULL;
    fixture_init(&f);
    fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
    struct crowd crowd = {.f = &f};
    fixture_must(rmap_shard_writer_create(f.map, 0, &f.run,
                                          &(struct rmap_shard_options){.piece_nbytes = 4 << 20},
                                          &crowd.writer, &err),
                 &err);
    fixture_must(rmap_workers_start(4, crowd_work, &crowd, &workers, &err), &err);
    while (!rmap_workers_done(workers)) {
        fixture_must(rmap_shard_writer_store(crowd.writer, &err), &err);
        (void)nanosleep(&(struct timespec){.tv_nsec = 1000000}, NULL);
    }
    rmap_workers_join(workers);
    fixture_must(rmap_shard_writer_finish(crowd.writer, &err), &err);
    assert_int_equal(rmap_shard_writer_backlog(crowd.writer), 0);
    rmap_shard_writer_destroy(crowd.writer);
    assert_int_equal(atomic_load(&crowd.failures), 0);
    struct rmap_map *map = index_and_open(&f);
    check_map(&f, map, 0.5);
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_same_work_same_bytes(void **state)
{
    (void)state;
    struct fixture f[2];
    struct rmap_error err = {0};
    char command[256];
    for (int k = 0; k < 2; k++) {
        fixture_init(&f[k]);
        fixture_must(rmap_map_create(f[k].map, false, NULL, NULL, &err), &err);
        fixture_must(fixture_write_shard(&f[k], 0, 0, 30, BLOCK, 4 << 20, &err), &err);
        fixture_must(rmap_index_write(f[k].map, &f[k].run, f[k].tally, true, &err), &err);
    }
    (void)snprintf(command, sizeof command, "diff -r %s %s", f[0].map, f[1].map);
    assert_int_equal(system(command), 0);
    for (int k = 0; k < 2; k++)
        fixture_fini(&f[k]);
}

static void test_tally_and_tables(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(&f, 7, 0, N_BLOCK, BLOCK, 0, &err), &err);
    struct rmap_map *map = index_and_open(&f);
    const struct rmap_tally *tally = rmap_map_tally(map);
    assert_int_equal(tally->n_value, f.tally->n_value);
    size_t n_kept = (size_t)(tally->left_elsewhere - tally->value); /* the last: not in maps */
    assert_memory_equal(tally->value, f.tally->value, n_kept * sizeof(double));
    const double *flux = rmap_map_flux_per_weight(map);
    assert_true(flux[1] == 3.0 / (N_BLOCK * BLOCK / 2));
    assert_string_equal(rmap_map_piece(map, 0)->name, "shard-00007/piece-00000.h5");
    assert_string_equal(rmap_map_bundle(map)->text, f.bundle->text);
    /* Parts cover all portions once, in order, about evenly. */
    for (size_t n = 1; n <= 7; n++) {
        assert_int_equal(rmap_map_split(map, n, 0), 0);
        assert_int_equal(rmap_map_split(map, n, n), N_BLOCK);
        for (size_t k = 0; k < n; k++) {
            size_t part = rmap_map_split(map, n, k + 1) - rmap_map_split(map, n, k);
            assert_in_range(part, N_BLOCK / n - 4, N_BLOCK / n + 4);
        }
    }
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_empty_map(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(&f, 0, 0, 0, BLOCK, 0, &err), &err);
    struct rmap_map *map = index_and_open(&f);
    assert_int_equal(rmap_map_n_portion(map), 0);
    assert_int_equal(rmap_map_split(map, 3, 1), 0);
    struct rmap_cursor *cursor = NULL;
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    fixture_fini(&f);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_one_shard_many_pieces), cmocka_unit_test(test_shards_and_columns),
        cmocka_unit_test(test_many_threads),          cmocka_unit_test(test_same_work_same_bytes),
        cmocka_unit_test(test_tally_and_tables),      cmocka_unit_test(test_empty_map),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

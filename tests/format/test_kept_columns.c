/* SPDX-License-Identifier: MIT
 *
 * Columns that a map keeps in memory are those that its pieces hold, in both encodings, whatever
 * the budget and the order of questions.
 */
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_keep.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "map_fixture.h"

enum { BLOCK = 500, N_BLOCK = 20 };

struct kept {
    struct fixture f;
    struct rmap_map *map;
};

static void make(struct kept *k, enum rmap_encoding encoding, size_t budget)
{
    struct rmap_error err = {0};
    fixture_init(&k->f);
    k->f.run.encoding = encoding;
    fixture_must(rmap_map_create(k->f.map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(&k->f, 0, 0, N_BLOCK, BLOCK, 0, &err), &err);
    fixture_must(rmap_index_write(k->f.map, &k->f.run, k->f.tally, true, &err), &err);
    fixture_must(rmap_map_open(k->f.map, &k->map, &err), &err);
    fixture_must(rmap_map_keep(k->map, budget, &err), &err);
    assert_int_equal(rmap_map_keep(k->map, budget, &err), RMAP_USAGE);
}

static size_t kept_nbytes(const struct rmap_map *map)
{
    struct rmap_map_kept kept;
    rmap_map_kept(map, &kept);
    assert_true(kept.columns <= kept.taken && kept.taken <= kept.budget);
    return kept.columns;
}

static void finish(struct kept *k)
{
    rmap_map_close(k->map);
    fixture_fini(&k->f);
}

/* Reads the columns in two steps; returns the bytes that came from files. */
static uint64_t read_and_compare(const struct kept *k, rmap_column_set first, rmap_column_set more)
{
    struct rmap_error err = {0};
    struct rmap_cursor *cursor = NULL;
    fixture_must(rmap_cursor_create(k->map, first | more, &cursor, &err), &err);
    for (size_t i = 0; i < rmap_map_n_portion(k->map); i++) {
        const struct rmap_portion *read = NULL;
        fixture_must(rmap_cursor_enter(cursor, i, &read, &err), &err);
        fixture_must(rmap_cursor_fetch(cursor, first, &err), &err);
        fixture_must(rmap_cursor_fetch(cursor, more, &err), &err);
        struct rmap_portion *want = fixture_portion(&k->f, read->first_ray, BLOCK, NULL);
        for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
            if ((first | more) & rmap_columns_of_run(read->timed) & RMAP_COLUMN_BIT(c))
                assert_non_null(rmap_portion_column(read, (enum rmap_column)c));
        fixture_compare(read, want);
        rmap_portion_destroy(want);
    }
    uint64_t nbytes = rmap_cursor_nbytes(cursor);
    rmap_cursor_destroy(cursor);
    return nbytes;
}

static void test_second_reading_reads_nothing(void **state)
{
    (void)state;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        struct kept k;
        make(&k, (enum rmap_encoding)e, SIZE_MAX / 2);
        assert_true(read_and_compare(&k, RMAP_COLUMNS_ALL, 0) > 0);
        size_t kept = kept_nbytes(k.map);
        assert_true(kept > 0);
        assert_int_equal(read_and_compare(&k, RMAP_COLUMNS_ALL, 0), 0);
        assert_int_equal(read_and_compare(&k, RMAP_COLUMNS_DISCRETE, RMAP_COLUMNS_ALL), 0);
        assert_int_equal(kept_nbytes(k.map), kept);
        finish(&k);
    }
}

/* Each column alone and with its right neighbour, so that what is kept and what is read mix. */
static void test_kept_and_read_mix(void **state)
{
    (void)state;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        struct kept k;
        make(&k, (enum rmap_encoding)e, SIZE_MAX / 2);
        for (int c = 0; c + 1 < RMAP_COLUMN_COUNT; c += 2) {
            (void)read_and_compare(&k, RMAP_COLUMN_BIT(c), 0);
            (void)read_and_compare(&k, RMAP_COLUMN_BIT(c), RMAP_COLUMN_BIT(c + 1));
        }
        (void)read_and_compare(&k, RMAP_COLUMNS_DISCRETE, RMAP_COLUMNS_ALL);
        finish(&k);
    }
}

static void test_budget_holds(void **state)
{
    (void)state;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        for (size_t budget = 0; budget < 300000; budget += 99999) {
            struct kept k;
            make(&k, (enum rmap_encoding)e, budget);
            for (int round = 0; round < 2; round++)
                assert_true(read_and_compare(&k, RMAP_COLUMNS_DISCRETE, RMAP_COLUMNS_ALL) > 0);
            assert_true(kept_nbytes(k.map) <= budget);
            finish(&k);
        }
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_second_reading_reads_nothing),
        cmocka_unit_test(test_kept_and_read_mix),
        cmocka_unit_test(test_budget_holds),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Both encodings hold the same rays: columns and digest are equal bit for bit, asked for together
 * or one by one, and a map may mix them.
 */
#include "map_fixture.h"

#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_internal.h"
#include "io/map/map_paths.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"

enum { BLOCK = 500, N_BLOCK = 30 };

static struct rmap_map *index_and_open(struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    return map;
}

static void compare_columns(struct fixture *f, const struct rmap_map *map, rmap_column_set columns)
{
    struct rmap_error err = {0};
    struct rmap_cursor *cursor = NULL;
    fixture_must(rmap_cursor_create(map, columns, &cursor, &err), &err);
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        const struct rmap_portion *read = NULL;
        fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
        struct rmap_portion *want =
            fixture_portion(f, read->first_ray, rmap_map_portion(map, i)->n_row[0], NULL);
        for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
            enum rmap_column column = (enum rmap_column)c;
            if (columns & rmap_columns_of_run(read->timed) & RMAP_COLUMN_BIT(c))
                assert_non_null(rmap_portion_column(read, column));
            else
                assert_null(rmap_portion_column(read, column));
        }
        fixture_compare(read, want);
        rmap_portion_destroy(want);
    }
    rmap_cursor_destroy(cursor);
}

/* Paths that nobody has are let go when they take more than they may, and come back. */
static void compare_with_few_paths(struct fixture *f, struct rmap_map *map)
{
    size_t kept = map->paths_nbytes;
    map->paths_budget = 1;
    compare_columns(f, map, RMAP_COLUMNS_ALL);
    assert_int_equal(map->paths_nbytes, 0);
    map->paths_budget = RMAP_PATHS_NBYTES;
    compare_columns(f, map, RMAP_COLUMNS_ALL);
    assert_int_equal(map->paths_nbytes, kept);
}

static struct rmap_digest digest_of(const struct rmap_map *map)
{
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    return summary.digest;
}

static void test_same_digest(void **state)
{
    (void)state;
    struct rmap_digest digest[RMAP_ENCODING_COUNT];
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        struct fixture f;
        struct rmap_error err = {0};
        fixture_init(&f);
        f.run.encoding = (enum rmap_encoding)e;
        fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
        fixture_must(fixture_write_shard(&f, 0, 0, N_BLOCK / 2, BLOCK, 1 << 20, &err), &err);
        fixture_must(fixture_write_shard(&f, 1, N_BLOCK / 2, N_BLOCK, BLOCK, 0, &err), &err);
        struct rmap_map *map = index_and_open(&f);
        assert_true(rmap_map_n_piece(map) > 2);
        for (size_t k = 0; k < rmap_map_n_piece(map); k++)
            assert_int_equal(rmap_map_piece(map, k)->encoding, e);
        compare_columns(&f, map, RMAP_COLUMNS_ALL);
        compare_with_few_paths(&f, map);
        digest[e] = digest_of(map);
        rmap_map_close(map);
        fixture_fini(&f);
        assert_int_equal(rmap_alloc_live(), 0);
    }
    assert_memory_equal(&digest[0], &digest[1], sizeof digest[0]);
}

/* Shards of one encoding each, blocks alternating; every column alone, and pairs of them. */
static void test_mixed_and_single_columns(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    fixture_must(rmap_map_create(f.map, false, NULL, NULL, &err), &err);
    for (uint64_t block = 0; block < N_BLOCK; block += 5) {
        f.run.encoding = block % 2 ? RMAP_ENCODING_COMPACT : RMAP_ENCODING_PLAIN;
        fixture_must(
            fixture_write_shard(&f, (int)(block / 5 % 3), block, block + 5, BLOCK, 0, &err), &err);
    }
    struct rmap_map *map = index_and_open(&f);
    compare_columns(&f, map, RMAP_COLUMNS_ALL);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        compare_columns(&f, map, RMAP_COLUMN_BIT(c));
        compare_columns(&f, map, RMAP_COLUMN_BIT(c) | RMAP_COLUMN_BIT(c * 7 % RMAP_COLUMN_COUNT));
    }
    compare_columns(&f, map, RMAP_COLUMN_BIT(RMAP_SEGMENT_object));
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_same_digest),
        cmocka_unit_test(test_mixed_and_single_columns),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

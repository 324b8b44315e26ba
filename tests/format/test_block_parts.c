/* SPDX-License-Identifier: MIT
 *
 * The promise: blocks that are appended in parts become the file that they become in one, byte by
 * byte; when memory runs short in between, it is said and nothing is kept of the block.
 */
#include "io/map/map_content.h"
#include "io/map/map_directory.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"
#include "map_fixture.h"

enum { BLOCKS = 3, RAYS = 900 };

/* Parts of n, n + 1, ... rays, at most n_most. */
static enum rmap_status append_parts(const struct fixture *f, struct rmap_shard_block *block,
                                     uint64_t first, uint64_t n, uint64_t n_most,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    bool whole = false;
    for (uint64_t at = 0, count; st == RMAP_OK && at < RAYS; at += count) {
        count = n < RAYS - at ? n : RAYS - at;
        n = n < n_most ? n + 1 : n;
        struct rmap_portion *part = fixture_portion(f, first + at, count, NULL);
        st = rmap_shard_block_add(block, part, &whole, err);
        rmap_portion_destroy(part);
        assert_false(whole);
    }
    if (st == RMAP_OK)
        st = rmap_shard_block_append(block, &whole, err);
    assert_false(whole);
    return st;
}

/* n_most = 0: in one. */
static void write_piece(struct fixture *f, uint64_t n, uint64_t n_most, const char *name)
{
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    struct rmap_shard_block *block = NULL;
    char command[256];
    fixture_must(rmap_map_create(f->map, true, NULL, NULL, &err), &err);
    fixture_must(rmap_shard_writer_create(f->map, 0, &f->run, NULL, &writer, &err), &err);
    fixture_must(rmap_shard_block_create(writer, &block, &err), &err);
    assert_non_null(block);
    for (uint64_t i = 0; i < BLOCKS; i++) {
        if (n_most > 0) {
            fixture_must(append_parts(f, block, i * RAYS, n, n_most, &err), &err);
            continue;
        }
        struct rmap_portion *portion = fixture_portion(f, i * RAYS, RAYS, NULL);
        fixture_must(rmap_shard_writer_append(writer, portion, &err), &err);
        rmap_portion_destroy(portion);
    }
    rmap_shard_block_destroy(block);
    fixture_must(rmap_shard_writer_finish(writer, &err), &err);
    rmap_shard_writer_destroy(writer);
    (void)snprintf(command, sizeof command, "cp %s/shard-00000/piece-00000.h5 %s/%s", f->map,
                   f->directory, name);
    assert_int_equal(system(command), 0);
}

static bool same_files(const struct fixture *f, const char *a, const char *b)
{
    char command[256];
    (void)snprintf(command, sizeof command, "cmp -s %s/%s %s/%s", f->directory, a, f->directory, b);
    return system(command) == 0;
}

static void test_same_bytes(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    write_piece(&f, 0, 0, "whole");
    write_piece(&f, 1, 200, "rising");
    write_piece(&f, 1, 1, "single");
    write_piece(&f, RAYS, RAYS, "one");
    assert_true(same_files(&f, "whole", "rising"));
    assert_true(same_files(&f, "whole", "single"));
    assert_true(same_files(&f, "whole", "one"));
    f.run.seed++;
    write_piece(&f, 1, 200, "other");
    assert_false(same_files(&f, "whole", "other"));
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Whichever allocation of adding and appending fails. */
static void test_short_of_memory(void **state)
{
    (void)state;
    struct fixture f;
    enum rmap_status st = RMAP_SYSTEM;
    int64_t fail_at = 0;
    fixture_init(&f);
    while (st != RMAP_OK) {
        struct rmap_error err = {0};
        struct rmap_shard_writer *writer = NULL;
        struct rmap_shard_block *block = NULL;
        struct rmap_portion *part[2];
        bool whole = false;
        for (uint64_t i = 0; i < 2; i++)
            part[i] = fixture_portion(&f, 100 * i, 100, NULL);
        fixture_must(rmap_map_create(f.map, true, NULL, NULL, &err), &err);
        fixture_must(rmap_shard_writer_create(f.map, 0, &f.run, NULL, &writer, &err), &err);
        fixture_must(rmap_shard_block_create(writer, &block, &err), &err);
        rmap_alloc_fail_at(++fail_at);
        st = rmap_shard_block_add(block, part[0], &whole, &err);
        if (st == RMAP_OK)
            st = rmap_shard_block_add(block, part[1], &whole, &err);
        if (st == RMAP_OK)
            st = rmap_shard_block_append(block, &whole, &err);
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        /* A shard that failed says so for ever; one whose block never came to it has no rows. */
        if (rmap_shard_writer_finish(writer, &err) != RMAP_OK)
            assert_int_equal(st, RMAP_SYSTEM);
        assert_int_equal(rmap_shard_writer_content(writer)->n_portion, st == RMAP_OK);
        rmap_shard_block_destroy(block);
        rmap_shard_writer_destroy(writer);
        for (int i = 0; i < 2; i++)
            rmap_portion_destroy(part[i]);
    }
    assert_true(fail_at > 5);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {cmocka_unit_test(test_same_bytes),
                                       cmocka_unit_test(test_short_of_memory)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}

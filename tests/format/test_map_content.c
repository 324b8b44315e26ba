/* SPDX-License-Identifier: MIT
 *
 * What a map holds, gathered from wherever it is known: pieces beside an incomplete index, content
 * sent by ranks, colour spaces, and numbers beyond 32 bits.
 */
#include "map_fixture.h"

#include <time.h>

#include "io/map/map_content.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_format.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"

enum { BLOCK = 200, N_BLOCK = 24 };

static struct rmap_map *open_map(const struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    return map;
}

/* The index that a trace writes before it has anything. */
static void begin_map(struct fixture *f)
{
    struct rmap_error err = {0};
    const struct rmap_run_row row = {.n_ray = N_BLOCK * BLOCK, .seed = 42, .n_rank = 1};
    const struct rmap_index index = {.run = &f->run, .row = &row};
    fixture_must(rmap_map_create(f->map, true, NULL, NULL, &err), &err);
    fixture_must(rmap_index_write_content(f->map, &index, &err), &err);
}

static struct rmap_digest digest_of_blocks(const struct fixture *f, uint64_t first, uint64_t last)
{
    struct rmap_digest digest = {0, 0};
    for (uint64_t k = first; k < last; k++) {
        struct rmap_portion *portion = fixture_portion(f, k * BLOCK, BLOCK, NULL);
        rmap_digest_add(&digest, rmap_portion_digest(portion));
        rmap_portion_destroy(portion);
    }
    return digest;
}

static void expect_blocks(const struct fixture *f, const struct rmap_map *map, uint64_t n)
{
    struct rmap_map_summary summary;
    struct rmap_digest digest = digest_of_blocks(f, 0, n);
    rmap_map_summarise(map, &summary);
    assert_int_equal(summary.n_row[RMAP_TABLE_RAY], n * BLOCK);
    assert_memory_equal(&summary.digest, &digest, sizeof digest);
}

/* Blocks traced by a run that nobody counted: no tally is kept of them but the map's. */
static void write_blocks(struct fixture *f, int shard, uint64_t first, uint64_t last)
{
    struct rmap_error err = {0};
    fixture_must(fixture_write_shard(f, shard, first, last, BLOCK, 0, &err), &err);
}

static void test_killed_before_its_index(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_map_summary summary;
    fixture_init(&f);
    begin_map(&f);
    struct rmap_map *map = open_map(&f);
    assert_int_equal(rmap_map_n_portion(map), 0);
    assert_int_equal(rmap_map_n_run(map), 1);
    assert_int_equal(rmap_map_run(map, 0)->n_ray, N_BLOCK * BLOCK);
    rmap_map_close(map);
    write_blocks(&f, 0, 0, 8); /* f.tally counts them */
    write_blocks(&f, 3, 8, N_BLOCK);
    map = open_map(&f);
    rmap_map_summarise(map, &summary);
    assert_true(!summary.complete && summary.n_shard == 2 && rmap_map_n_trouble(map) == 0);
    expect_blocks(&f, map, N_BLOCK);
    assert_int_equal(rmap_map_tally(map)->n_value, f.tally->n_value);
    assert_memory_equal(rmap_map_tally(map)->value, f.tally->value,
                        f.tally->n_value * sizeof *f.tally->value);
    for (size_t s = 0; s < f.scene->n_source; s++)
        assert_true(rmap_map_flux_per_weight(map)[s] ==
                    f.scene->source[s].flux / f.tally->emitted[s]);
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void shell(const char *format, const char *directory)
{
    char command[300];
    (void)snprintf(command, sizeof command, "cd %s && %s", directory, format);
    assert_int_equal(system(command), 0);
}

/* Ghosts count once, damaged and foreign pieces are named and passed over, and of two blocks that
 * share some of their rays one is left out, and told. */
static void test_what_stands_beside(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    fixture_init(&f);
    begin_map(&f);
    write_blocks(&f, 0, 0, 8);
    write_blocks(&f, 1, 2, 5); /* a ghost */
    map = open_map(&f);
    expect_blocks(&f, map, 8);
    assert_int_equal(rmap_map_n_trouble(map), 0);
    rmap_map_close(map);
    write_blocks(&f, 2, 8, 12);
    shell("truncate -s 5000 shard-00002/piece-00000.h5", f.map);
    f.run.seed = 43;
    write_blocks(&f, 4, 12, 14);
    f.run.seed = 42;
    map = open_map(&f);
    expect_blocks(&f, map, 8);
    assert_int_equal(rmap_map_n_trouble(map), 2);
    assert_non_null(strstr(rmap_map_trouble(map, 0), "shard-00002/piece-00000.h5"));
    assert_non_null(strstr(rmap_map_trouble(map, 1), "shard-00004/piece-00000.h5"));
    rmap_map_close(map);
    fixture_must(fixture_write_shard(&f, 5, 5, 6, BLOCK + BLOCK / 2, 0, &err), &err);
    map = open_map(&f);
    expect_blocks(&f, map, 8);
    assert_int_equal(rmap_map_n_trouble(map), 3);
    assert_non_null(strstr(rmap_map_trouble(map, 2), "shard-00000/piece-00000.h5"));
    assert_non_null(strstr(rmap_map_trouble(map, 2), "shard-00005/piece-00000.h5"));
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* A complete index is believed: what is missing or extra is told, by name. */
static void test_compare_directory(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    begin_map(&f);
    write_blocks(&f, 0, 0, 8);
    write_blocks(&f, 1, 8, 12);
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    write_blocks(&f, 7, 12, 14);
    shell("rm shard-00001/piece-00000.h5", f.map);
    struct rmap_map *map = open_map(&f);
    expect_blocks(&f, map, 12);
    assert_int_equal(rmap_map_n_trouble(map), 0);
    fixture_must(rmap_map_compare_directory(map, &err), &err);
    assert_int_equal(rmap_map_n_trouble(map), 2);
    assert_non_null(strstr(rmap_map_trouble(map, 0), "shard-00001/piece-00000.h5 is missing"));
    assert_non_null(strstr(rmap_map_trouble(map, 1), "shard-00007/piece-00000.h5 is not in"));
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

static struct rmap_shard_writer *write_for_content(struct fixture *f, int shard, uint64_t first,
                                                   uint64_t last)
{
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    fixture_must(rmap_shard_writer_create(f->map, shard, &f->run, NULL, &writer, &err), &err);
    for (uint64_t k = first; k < last; k++) {
        struct rmap_portion *portion = fixture_portion(f, k * BLOCK, BLOCK, f->tally);
        fixture_must(rmap_shard_writer_append(writer, portion, &err), &err);
        rmap_portion_destroy(portion);
    }
    fixture_must(rmap_shard_writer_finish(writer, &err), &err);
    return writer;
}

/* Ranks hand over what they wrote; the index is made of that, without a look at the disk. */
static void test_gathered(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map_content all = {0};
    fixture_init(&f);
    begin_map(&f);
    for (int shard = 2; shard >= 0; shard--) {
        struct rmap_shard_writer *writer =
            write_for_content(&f, shard, (uint64_t)shard * 8, (uint64_t)shard * 8 + 8);
        size_t nbytes = rmap_map_content_packed_nbytes(rmap_shard_writer_content(writer));
        uint8_t *blob = rmap_alloc(nbytes, 1);
        rmap_map_content_pack(rmap_shard_writer_content(writer),
                              &(struct rmap_packing){.to = blob});
        rmap_shard_writer_destroy(writer);
        for (size_t cut = 0; cut < nbytes; cut += 97)
            assert_int_equal(rmap_map_content_unpack(blob, cut, &all, &err), RMAP_FORMAT);
        assert_int_equal(all.n_piece, 2 - shard);
        fixture_must(rmap_map_content_unpack(blob, nbytes, &all, &err), &err);
        rmap_free(blob);
    }
    const struct rmap_index index = {
        .run = &f.run, .content = &all, .tally = f.tally, .complete = true};
    fixture_must(rmap_index_write_content(f.map, &index, &err), &err);
    rmap_map_content_fini(&all);
    struct rmap_map *map = open_map(&f);
    expect_blocks(&f, map, N_BLOCK);
    struct rmap_cursor *cursor = NULL;
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        const struct rmap_portion *read = NULL;
        fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
    }
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* The fixture's scene in spectral light, as `--color spectral` makes it. */
static void spectral_fixture(const struct fixture *f, struct fixture *other)
{
    char path[128];
    struct rmap_error err = {0};
    struct rmap_scene_options options = {.color = rmap_strdup("spectral")};
    struct rmap_diagnostics diagnostics;
    *other = *f;
    (void)snprintf(path, sizeof path, "%s/scene.yaml", f->directory);
    rmap_diagnostics_init(&diagnostics, path);
    fixture_must(rmap_bundle_open(path, &options, &other->bundle, &err), &err);
    fixture_must(rmap_scene_read(other->bundle, &other->scene, &diagnostics, &err), &err);
    rmap_diagnostics_fini(&diagnostics);
    other->run.bundle = other->bundle;
    other->run.scene = other->scene;
}

/* RGB first, then spectral rays appended, in both encodings: one map, one tally, two spaces. */
static void test_two_spaces(void **state)
{
    (void)state;
    struct fixture f, other;
    struct rmap_error err = {0};
    fixture_init(&f);
    spectral_fixture(&f, &other);
    assert_true(other.scene->channels.n > f.scene->channels.n);
    fixture_must(rmap_map_create(f.map, true, NULL, NULL, &err), &err);
    write_blocks(&f, 0, 0, 8);
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    struct rmap_map *before = open_map(&f);
    fixture_must(rmap_map_admit(before, &other.run, &other.run.space, &err), &err);
    assert_int_equal(other.run.space, 1);
    struct rmap_map_content all = {0};
    fixture_must(rmap_map_content_add(&all, rmap_map_contents(before), &err), &err);
    for (int shard = 1; shard < 3; shard++) {
        other.run.encoding = shard == 1 ? RMAP_ENCODING_PLAIN : RMAP_ENCODING_COMPACT;
        struct rmap_shard_writer *writer =
            write_for_content(&other, shard, (uint64_t)shard * 8, (uint64_t)shard * 8 + 8);
        fixture_must(rmap_map_content_add(&all, rmap_shard_writer_content(writer), &err), &err);
        rmap_shard_writer_destroy(writer);
    }
    const struct rmap_run_row row = {8 * BLOCK, 16 * BLOCK, 42, 1, 1};
    const struct rmap_index index = {.run = &other.run,
                                     .before = before,
                                     .row = &row,
                                     .content = &all,
                                     .tally = f.tally,
                                     .complete = true};
    fixture_must(rmap_index_write_content(f.map, &index, &err), &err);
    rmap_map_content_fini(&all);
    rmap_map_close(before);

    struct rmap_map *map = open_map(&f);
    struct rmap_cursor *cursor = NULL;
    assert_int_equal(rmap_map_n_space(map), 2);
    assert_int_equal(rmap_map_n_run(map), 2);
    assert_int_equal(rmap_map_scene(map)->channels.n, 3);
    assert_int_equal(rmap_map_scene_of(map, 1)->channels.n, other.scene->channels.n);
    assert_int_equal(rmap_map_n_channel(map), other.scene->channels.n);
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t k = 0; k < 2 * (size_t)N_BLOCK; k++) { /* to and fro */
        size_t i = k * 7 % N_BLOCK;
        const struct rmap_portion *read = NULL;
        const struct fixture *from = i < 8 ? &f : &other;
        assert_int_equal(rmap_map_portion(map, i)->space, i < 8 ? 0 : 1);
        assert_int_equal(rmap_map_space_of_ray(map, i * BLOCK + 3), i < 8 ? 0 : 1);
        fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
        struct rmap_portion *want = fixture_portion(from, i * BLOCK, BLOCK, NULL);
        assert_int_equal(read->n_channel, want->n_channel);
        fixture_compare(read, want);
        rmap_portion_destroy(want);
    }
    rmap_cursor_destroy(cursor);
    other.run.seed = 1;
    assert_int_equal(rmap_map_admit(map, &other.run, &other.run.space, &err), RMAP_INPUT);
    assert_non_null(strstr(err.text, "seed"));
    rmap_map_close(map);
    rmap_scene_destroy(other.scene);
    rmap_bundle_destroy(other.bundle);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

static double seconds(void)
{
    struct timespec now;
    assert_int_equal(clock_gettime(CLOCK_MONOTONIC, &now), 0);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Many shards, as many ranks leave them: opening takes the index alone. */
static void test_many_shards(void **state)
{
    (void)state;
    enum { N = RMAP_VIEW_PIECES_MAX + 4, RAYS = 20 };
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map_content all = {0};
    char command[400];
    fixture_init(&f);
    begin_map(&f);
    for (int shard = 0; shard < N; shard++) {
        struct rmap_shard_writer *writer = NULL;
        f.run.encoding = shard % 16 ? RMAP_ENCODING_COMPACT : RMAP_ENCODING_PLAIN;
        fixture_must(rmap_shard_writer_create(f.map, shard, &f.run, NULL, &writer, &err), &err);
        struct rmap_portion *portion = fixture_portion(&f, (uint64_t)shard * RAYS, RAYS, f.tally);
        fixture_must(rmap_shard_writer_append(writer, portion, &err), &err);
        rmap_portion_destroy(portion);
        fixture_must(rmap_shard_writer_finish(writer, &err), &err);
        fixture_must(rmap_map_content_add(&all, rmap_shard_writer_content(writer), &err), &err);
        rmap_shard_writer_destroy(writer);
    }
    const struct rmap_index index = {
        .run = &f.run, .content = &all, .tally = f.tally, .complete = true};
    double begun = seconds();
    fixture_must(rmap_index_write_content(f.map, &index, &err), &err);
    double written = seconds();
    rmap_map_content_fini(&all);
    struct rmap_map *map = open_map(&f);
    double opened = seconds();
    struct rmap_cursor *cursor = NULL;
    fixture_must(rmap_cursor_create(map, RMAP_COLUMN_BIT(RMAP_SEGMENT_event), &cursor, &err), &err);
    for (size_t i = 0; i < rmap_map_n_portion(map); i++) {
        const struct rmap_portion *read = NULL;
        fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
        assert_true(read->n_row[RMAP_TABLE_RAY] == RAYS);
    }
    double scanned = seconds();
    print_message("index %.0f ms, open %.0f ms, events of all shards %.0f ms\n",
                  1e3 * (written - begun), 1e3 * (opened - written), 1e3 * (scanned - opened));
    assert_true(opened - written < 1.0 && scanned - opened < 10.0);
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    (void)snprintf(command, sizeof command,
                   "h5dump -a /view %s/map.h5 2>/dev/null | grep -q 'too many pieces'", f.map);
    if (system("command -v h5dump >/dev/null") == 0)
        assert_int_equal(system(command), 0);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Rows and ids that 32 bits do not count: the index alone, for nobody has the disk. */
static void test_beyond_32_bits(void **state)
{
    (void)state;
    enum { N = 1000 };
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map_content all = {0};
    struct rmap_map_summary summary;
    const uint64_t first = UINT64_C(1) << 40, rays = UINT64_C(1) << 24;
    fixture_init(&f);
    begin_map(&f);
    for (int k = 0; k < N; k++) {
        struct rmap_portion_info portion = {.first_ray = first + (uint64_t)k * rays,
                                            .n_row = {rays, 9 * rays, 2 * rays},
                                            .stored_rows = {rays, 9 * rays, 2 * rays}};
        struct rmap_piece_info piece = {.shard = k, .nbytes = UINT64_C(5) << 30};
        memcpy(piece.stored_rows, portion.stored_rows, sizeof piece.stored_rows);
        rmap_piece_name_set(&piece);
        fixture_must(rmap_map_content_add_piece(&all, &piece, &portion, 1, NULL, &err), &err);
    }
    const struct rmap_index index = {.run = &f.run, .content = &all, .complete = true};
    fixture_must(rmap_index_write_content(f.map, &index, &err), &err);
    rmap_map_content_fini(&all);
    struct rmap_map *map = open_map(&f);
    rmap_map_summarise(map, &summary);
    assert_true(summary.n_row[RMAP_TABLE_RAY] == N * rays);
    assert_true(summary.n_row[RMAP_TABLE_SEGMENT] == N * 9 * rays);
    assert_true(summary.nbytes > N * (UINT64_C(5) << 30));
    assert_true(rmap_map_portion(map, N - 1)->first_ray == first + (N - 1) * rays);
    assert_int_equal(rmap_map_split(map, 10, 5), N / 2);
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Real rays with ids from 2^40 on, in both encodings. */
static void test_large_ids(void **state)
{
    (void)state;
    const uint64_t block = (UINT64_C(1) << 40) / BLOCK + 1;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        struct fixture f;
        struct rmap_error err = {0};
        struct rmap_cursor *cursor = NULL;
        fixture_init(&f);
        f.run.encoding = (enum rmap_encoding)e;
        begin_map(&f);
        write_blocks(&f, 0, block, block + 5);
        struct rmap_map *map = open_map(&f);
        fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
        assert_int_equal(rmap_map_n_portion(map), 5);
        for (size_t i = 0; i < 5; i++) {
            const struct rmap_portion *read = NULL;
            fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
            struct rmap_portion *want = fixture_portion(&f, (block + i) * BLOCK, BLOCK, NULL);
            assert_true(want->first_ray >> 40 == 1 && read->first_ray == want->first_ray);
            fixture_compare(read, want);
            rmap_portion_destroy(want);
        }
        rmap_cursor_destroy(cursor);
        rmap_map_close(map);
        fixture_fini(&f);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_killed_before_its_index),
        cmocka_unit_test(test_what_stands_beside),
        cmocka_unit_test(test_compare_directory),
        cmocka_unit_test(test_gathered),
        cmocka_unit_test(test_two_spaces),
        cmocka_unit_test(test_beyond_32_bits),
        cmocka_unit_test(test_large_ids),
        cmocka_unit_test(test_many_shards),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Numbers beyond 2^32: offsets and sizes in files, ray ids, rows and sums of a map. The files are
 * sparse and the headers synthetic; what is read is real.
 */
#include "map_fixture.h"

#include <fcntl.h>
#include <sys/stat.h>

#include "io/map/map_chunks.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_internal.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"

enum { BLOCK = 300, N_BLOCK = 4 };

#define FOUR_GIB (UINT64_C(1) << 32)

/* A map of one piece with an index that `change` has been at. */
static void write_map(struct fixture *f, enum rmap_encoding encoding, uint64_t first_ray)
{
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    fixture_init(f);
    f->run.encoding = encoding;
    fixture_must(rmap_map_create(f->map, false, NULL, NULL, &err), &err);
    fixture_must(rmap_shard_writer_create(f->map, 0, &f->run, 0, &writer, &err), &err);
    for (uint64_t block = 0; block < N_BLOCK; block++) {
        struct rmap_portion *portion =
            fixture_portion(f, first_ray + block * BLOCK, BLOCK, f->tally);
        portion->first_ray = first_ray + block * BLOCK;
        fixture_must(rmap_shard_writer_append(writer, portion, &err), &err);
        rmap_portion_destroy(portion);
    }
    fixture_must(rmap_shard_writer_finish(writer, &err), &err);
    rmap_shard_writer_destroy(writer);
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
}

static void rewrite_index(struct fixture *f, void (*change)(struct rmap_map_content *content))
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    struct rmap_map_content content = {0};
    struct rmap_run_row row = {.seed = f->run.seed, .n_rank = 1};
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    fixture_must(rmap_map_content_add(&content, &map->content, &err), &err);
    rmap_map_close(map);
    change(&content);
    const struct rmap_index index = {
        .run = &f->run, .row = &row, .content = &content, .tally = f->tally, .complete = true};
    fixture_must(rmap_index_write_content(f->map, &index, &err), &err);
    rmap_map_content_fini(&content);
}

static void read_all(const struct fixture *f, uint64_t first_ray)
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    struct rmap_cursor *cursor = NULL;
    const struct rmap_portion *read = NULL;
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    fixture_must(rmap_map_check_pieces(map, &err), &err);
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    assert_int_equal(rmap_map_n_portion(map), N_BLOCK);
    for (size_t i = 0; i < N_BLOCK; i++) {
        fixture_must(rmap_cursor_read(cursor, i, &read, &err), &err);
        struct rmap_portion *want = fixture_portion(f, first_ray + i * BLOCK, BLOCK, NULL);
        fixture_compare(read, want);
        assert_int_equal(read->first_ray, first_ray + i * BLOCK);
        rmap_portion_destroy(want);
    }
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
}

/* ---- chunks before, across and behind 4 GiB ---- */

#define STEP (FOUR_GIB / 4 + 12345)
#define AT(k)                                                                                      \
    ((k) == 2  ? FOUR_GIB - 3 /* across */                                                         \
     : (k) < 2 ? (k)*STEP + 7                                                                      \
               : FOUR_GIB + ((uint64_t)(k) << 21))

static void spread_chunks(struct rmap_map_content *content)
{
    for (size_t k = 0; k < content->n_chunk; k++)
        content->chunk[k].offset = AT(k);
    content->piece[0].nbytes = AT(content->n_chunk) + 1;
}

/* The chunks of the piece at their new places in a file that is otherwise a hole. */
static void spread_file(const struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    char path[400], wide[420];
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    (void)snprintf(path, sizeof path, "%s/%s", f->map, map->content.piece[0].name);
    (void)snprintf(wide, sizeof wide, "%s.wide", path);
    int from = open(path, O_RDONLY), to = open(wide, O_WRONLY | O_CREAT, 0666);
    assert_true(from >= 0 && to >= 0);
    assert_int_equal(ftruncate(to, (off_t)AT(map->content.n_chunk) + 1), 0);
    for (size_t k = 0; k < map->content.n_chunk; k++) {
        const struct rmap_chunk_entry *chunk = &map->content.chunk[k];
        uint8_t *data = rmap_alloc(chunk->nbytes, 1);
        assert_non_null(data);
        assert_int_equal(pread(from, data, chunk->nbytes, (off_t)chunk->offset), chunk->nbytes);
        assert_int_equal(pwrite(to, data, chunk->nbytes, (off_t)AT(k)), chunk->nbytes);
        rmap_free(data);
    }
    assert_int_equal(close(from), 0);
    assert_int_equal(close(to), 0);
    assert_int_equal(rename(wide, path), 0);
    rmap_map_close(map);
}

static void test_four_gib(void **state)
{
    (void)state;
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        struct fixture f;
        write_map(&f, (enum rmap_encoding)e, 0);
        read_all(&f, 0);
        spread_file(&f);
        rewrite_index(&f, spread_chunks);
        read_all(&f, 0);
        fixture_fini(&f);
        assert_int_equal(rmap_alloc_live(), 0);
    }
}

/* ---- ids ---- */

static void test_ray_ids(void **state)
{
    (void)state;
    static const uint64_t first[] = {FOUR_GIB - 2 * BLOCK, UINT64_C(1) << 40,
                                     (UINT64_C(1) << 63) - BLOCK};
    for (size_t i = 0; i < 3; i++)
        for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
            struct fixture f;
            write_map(&f, (enum rmap_encoding)e, first[i]);
            read_all(&f, first[i]);
            fixture_fini(&f);
        }
    assert_int_equal(rmap_alloc_live(), 0);
}

/* ---- rows ---- */

#define MANY (UINT64_C(3) << 31) /* rows of a portion: more than 32 bits */

static void claim_rows(struct rmap_map_content *content)
{
    for (size_t i = 0; i < content->n_portion; i++) {
        struct rmap_portion_info *portion = &content->portion[i];
        portion->first_ray = i * MANY;
        for (int t = 0; t < RMAP_TABLE_CURVE; t++) {
            portion->n_row[t] = portion->stored_rows[t] = MANY;
            portion->stored_first[t] = i * MANY;
        }
    }
    for (int t = 0; t < RMAP_TABLE_CURVE; t++)
        content->piece[0].n_row[t] = content->piece[0].stored_rows[t] = N_BLOCK * MANY;
}

/* An index may speak of more rows than 32 bits count, and of more than there are chunks for: that
 * is found when they are read, without taking memory for them. */
static void test_rows(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    struct rmap_cursor *cursor = NULL;
    struct rmap_map_summary summary;
    const struct rmap_portion *read = NULL;
    write_map(&f, RMAP_ENCODING_PLAIN, 0);
    rewrite_index(&f, claim_rows);
    fixture_must(rmap_map_open(f.map, &map, &err), &err);
    rmap_map_summarise(map, &summary);
    for (int t = 0; t < RMAP_TABLE_CURVE; t++)
        assert_true(summary.n_row[t] == N_BLOCK * MANY);
    for (size_t part = 0; part <= N_BLOCK; part++)
        assert_int_equal(rmap_map_split(map, N_BLOCK, part), part);
    fixture_must(rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t i = 0; i < N_BLOCK; i++) {
        assert_int_equal(rmap_cursor_read(cursor, i, &read, &err), RMAP_FORMAT);
        assert_non_null(strstr(err.text, "table of chunks does not fit its rows"));
    }
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Sums that would run over 64 bits are refused. */
static void test_sums(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rmap_piece_info piece = {.n_chunk = 0};
    struct rmap_portion_info portion[2] = {{.first_ray = 0}, {.first_ray = UINT64_C(3) << 61}};
    struct rmap_map_content content = {
        .piece = &piece, .n_piece = 1, .portion = portion, .n_portion = 2};
    for (int i = 0; i < 2; i++)
        for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
            portion[i].n_row[t] = portion[i].stored_rows[t] = UINT64_C(3) << 60;
            portion[i].stored_first[t] = (uint64_t)i * (UINT64_C(3) << 60);
            piece.stored_rows[t] = UINT64_MAX;
        }
    assert_int_equal(rmap_map_content_check(&content, "here", &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "too many rows"));
    for (int i = 0; i < 2; i++)
        for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
            portion[i].n_row[t] = portion[i].stored_rows[t] = UINT64_C(1) << 60;
            portion[i].stored_first[t] = (uint64_t)i << 60;
        }
    fixture_must(rmap_map_content_check(&content, "here", &err), &err);
    assert_true(content.n_row[RMAP_TABLE_SEGMENT] == UINT64_C(1) << 61);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_four_gib),
        cmocka_unit_test(test_ray_ids),
        cmocka_unit_test(test_rows),
        cmocka_unit_test(test_sums),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * A journal gives back what was committed, and of a cut or damaged one a prefix of it or an error.
 */
#include <errno.h>
#include <fcntl.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "io/write/journal_writer.h"

enum { N_COMMIT = 6, N_CHANNEL = 3 };

/* Rows of /ray, /segment, /registration at each commit: few are journalled, for chunks are stored
 * in between. The last but one has no rows behind the chunks of /ray. */
static const uint64_t table_rows[N_COMMIT + 1][RMAP_TABLE_COUNT] = {{0, 0, 0},
                                                                    {20, 60, 0},
                                                                    {27, 65536 + 9, 3},
                                                                    {40, 65536 + 9, 9},
                                                                    {65536 + 5, 131100, 9},
                                                                    {131072, 131111, 9},
                                                                    {131080, 393225, 12}};

struct scratch {
    char directory[64];
    char path[96];
    const struct rmap_layout *layout;
    uint64_t end[N_COMMIT + 1]; /* bytes of the file at each commit */
};

static uint8_t value(int stream, uint64_t byte)
{
    uint64_t x = (byte + 1) * UINT64_C(0x9E3779B97F4A7C15) + (uint64_t)stream * 77;
    return (uint8_t)(x >> 37);
}

static void must(enum rmap_status st, const struct rmap_error *err)
{
    if (st != RMAP_OK)
        fail_msg("status %d: %s", (int)st, err->text);
}

static struct rmap_portion_info portion_of(int commit)
{
    struct rmap_portion_info info = {.first_ray = (uint64_t)commit << 40,
                                     .digest = {(uint64_t)commit * 3, 5},
                                     .summary = {.events = (uint32_t)commit, .box_min = {1, 2, 3}}};
    for (int t = 0; t < RMAP_TABLE_COUNT; t++) {
        info.stored_first[t] = table_rows[commit - 1][t];
        info.stored_rows[t] = table_rows[commit][t] - table_rows[commit - 1][t];
        info.n_row[t] = info.stored_rows[t];
    }
    return info;
}

static struct rmap_chunk_entry chunk_of(int stream, uint64_t index)
{
    return (struct rmap_chunk_entry){.offset = (uint64_t)stream << 33 | index << 10,
                                     .checksum = ~index,
                                     .nbytes = 1000 + (uint32_t)stream,
                                     .index = (uint32_t)index,
                                     .lead_nbytes = 17,
                                     .lead_planes = 2,
                                     .stream = (uint16_t)stream};
}

/* What happens to one stream between two commits: chunks that filled up, rows behind them. */
static void add_stream(struct rmap_journal_batch *batch, const struct rmap_layout *layout, int s,
                       int commit)
{
    struct rmap_error err = {0};
    int table = layout->stream[s].table;
    size_t row = rmap_stream_row_nbytes(&layout->stream[s], N_CHANNEL);
    uint64_t from = table_rows[commit - 1][table], to = table_rows[commit][table];
    for (uint64_t k = from / RMAP_CHUNK_ROWS; k < to / RMAP_CHUNK_ROWS; k++) {
        struct rmap_chunk_entry entry = chunk_of(s, k);
        must(rmap_journal_add_chunks(batch, &entry, 1, &err), &err);
    }
    if (from < to - to % RMAP_CHUNK_ROWS)
        from = to - to % RMAP_CHUNK_ROWS;
    if (from == to)
        return;
    uint8_t *rows = rmap_alloc((size_t)(to - from) * row, 1);
    for (uint64_t i = 0; i < (to - from) * row; i++)
        rows[i] = value(s, from * row + i);
    must(rmap_journal_add_tail(batch, s, from, (size_t)(to - from), row, rows, &err), &err);
    rmap_free(rows);
}

static struct rmap_journal_header some_header(void)
{
    return (struct rmap_journal_header){.encoding = RMAP_ENCODING_PLAIN,
                                        .mode = RMAP_COLOUR_RGB,
                                        .n_channel = N_CHANNEL,
                                        .shard = 3,
                                        .number = 14,
                                        .seed = 42,
                                        .scene_digest = "0123456789abcdef0123456789abcdef",
                                        .space_digest = "fedcba9876543210fedcba9876543210",
                                        .isa = "test"};
}

static void begin(struct scratch *s)
{
    *s = (struct scratch){.directory = "journal-test-XXXXXX",
                          .layout = rmap_layout_of(RMAP_ENCODING_PLAIN, RMAP_COLOUR_RGB)};
    assert_non_null(mkdtemp(s->directory));
    (void)snprintf(s->path, sizeof s->path, "%s/t.journal", s->directory);
}

static void end(struct scratch *s)
{
    (void)unlink(s->path);
    assert_int_equal(rmdir(s->directory), 0);
    assert_int_equal(rmap_alloc_live(), 0);
}

static uint64_t file_nbytes(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    return (uint64_t)info.st_size;
}

static void write_journal(struct scratch *s)
{
    struct rmap_error err = {0};
    struct rmap_journal_writer *writer = NULL;
    struct rmap_journal_batch batch = {0};
    const struct rmap_journal_header header = some_header();
    must(rmap_journal_create(s->path, &header, &writer, &err), &err);
    for (int k = 1; k <= N_COMMIT; k++) {
        uint64_t n_row[RMAP_STORED_TABLE_MAX] = {0};
        struct rmap_portion_info info = portion_of(k);
        memcpy(n_row, table_rows[k], sizeof table_rows[k]);
        for (int stream = 0; stream < s->layout->time_stream; stream++)
            add_stream(&batch, s->layout, stream, k);
        must(rmap_journal_add_portions(&batch, false, &info, 1, &err), &err);
        must(rmap_journal_commit(writer, &batch, n_row, (uint64_t)k, &err), &err);
        s->end[k] = file_nbytes(s->path);
    }
    rmap_journal_writer_destroy(writer);
    rmap_journal_batch_fini(&batch);
}

static void compare_tails(const struct rmap_map_content *content, const struct scratch *s, int k)
{
    size_t at = 0;
    for (int stream = 0; stream < s->layout->time_stream; stream++) {
        size_t row = rmap_stream_row_nbytes(&s->layout->stream[stream], N_CHANNEL);
        uint64_t n = table_rows[k][s->layout->stream[stream].table] % RMAP_CHUNK_ROWS;
        if (n == 0)
            continue;
        const struct rmap_stream_tail *tail = &content->tail[at++];
        uint64_t first = table_rows[k][s->layout->stream[stream].table] - n;
        assert_int_equal(tail->stream, stream);
        assert_int_equal(tail->first_row, first);
        assert_int_equal(tail->n_row, n);
        assert_int_equal(tail->nbytes, n * row);
        for (size_t i = 0; i < tail->nbytes; i++)
            assert_int_equal(tail->data[i], value(stream, first * row + i));
    }
    assert_int_equal(content->n_tail, at);
}

/* The journal holds just the first k commits. */
static void compare(const struct rmap_journal *journal, const struct scratch *s, int k)
{
    size_t n_entry = 0;
    assert_int_equal(journal->n_portion, k);
    assert_int_equal(journal->nbytes, s->end[k]);
    if (k == 0)
        return;
    assert_memory_equal(journal->n_row, table_rows[k], sizeof table_rows[k]);
    for (int i = 0; i < k; i++) {
        struct rmap_portion_info want = portion_of(i + 1);
        const struct rmap_portion_info *got = &journal->portion[i];
        assert_int_equal(got->first_ray, want.first_ray);
        assert_memory_equal(got->stored_rows, want.stored_rows, sizeof want.stored_rows);
        assert_memory_equal(&got->digest, &want.digest, sizeof want.digest);
        assert_memory_equal(&got->summary, &want.summary, sizeof want.summary);
    }
    for (int stream = 0; stream < s->layout->time_stream; stream++)
        for (uint64_t i = 0; i < table_rows[k][s->layout->stream[stream].table] / RMAP_CHUNK_ROWS;
             i++) {
            struct rmap_chunk_entry want = chunk_of(stream, i);
            assert_memory_equal(&journal->entry[n_entry++], &want, sizeof want);
        }
    assert_int_equal(journal->n_entry, n_entry);
}

static void test_roundtrip(void **state)
{
    (void)state;
    struct scratch s;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    struct rmap_map_content content = {0};
    struct rmap_piece_origin origin;
    begin(&s);
    write_journal(&s);
    for (int k = N_COMMIT; k > 0; k--) {
        assert_int_equal(truncate(s.path, (off_t)s.end[k]), 0);
        must(rmap_journal_read(s.path, &journal, &err), &err);
        compare(&journal, &s, k);
        must(rmap_journal_content(&journal, s.path, "shard-00003/x.part", 5, &content, &err), &err);
        assert_int_equal(content.n_piece, 1);
        assert_int_equal(content.piece[0].number, 14);
        assert_int_equal(content.piece[0].is_open, 1);
        assert_string_equal(content.piece[0].name, "shard-00003/x.part");
        assert_int_equal(content.n_portion, k);
        compare_tails(&content, &s, k);
        rmap_journal_origin(&journal, &origin);
        assert_int_equal(origin.seed, 42);
        assert_string_equal(origin.space_digest, "fedcba9876543210fedcba9876543210");
        rmap_map_content_fini(&content);
        rmap_journal_fini(&journal);
    }
    end(&s);
}

/* Cut off at any byte: what was committed before stands. */
static void test_truncation(void **state)
{
    (void)state;
    struct scratch s;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    begin(&s);
    write_journal(&s);
    int k = N_COMMIT;
    for (uint64_t n = s.end[N_COMMIT] + 1; n-- > 0;) {
        while (k > 0 && n < s.end[k])
            k--;
        assert_int_equal(truncate(s.path, (off_t)n), 0);
        must(rmap_journal_read(s.path, &journal, &err), &err);
        compare(&journal, &s, k);
        assert_int_equal(journal.nbytes_dropped, n - s.end[k]);
        rmap_journal_fini(&journal);
    }
    end(&s);
}

static uint8_t *slurp(const char *path, size_t *nbytes)
{
    *nbytes = (size_t)file_nbytes(path);
    uint8_t *data = rmap_alloc(*nbytes, 1);
    int fd = open(path, O_RDONLY);
    assert_int_equal(read(fd, data, *nbytes), (ssize_t)*nbytes);
    (void)close(fd);
    return data;
}

static void spill(const char *path, const void *data, size_t nbytes)
{
    int fd = open(path, O_WRONLY | O_CREAT | O_TRUNC, 0666);
    assert_int_equal(write(fd, data, nbytes), (ssize_t)nbytes);
    (void)close(fd);
}

/* A changed byte: the commits before it, or a word. */
static void test_damage(void **state)
{
    (void)state;
    struct scratch s;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    size_t nbytes = 0;
    begin(&s);
    write_journal(&s);
    uint8_t *data = slurp(s.path, &nbytes);
    int fd = open(s.path, O_WRONLY), k = 0, told = 0;
    for (size_t at = 0; at < nbytes; at++) {
        uint8_t wrong = (uint8_t)(data[at] ^ 1 << at % 8);
        if (at >= s.end[k + 1])
            k++;
        assert_int_equal(pwrite(fd, &wrong, 1, (off_t)at), 1);
        enum rmap_status st = rmap_journal_read(s.path, &journal, &err);
        if (st == RMAP_OK)
            compare(&journal, &s, k);
        else
            assert_int_equal(st, RMAP_FORMAT);
        told += st != RMAP_OK;
        rmap_journal_fini(&journal);
        assert_int_equal(pwrite(fd, data + at, 1, (off_t)at), 1);
    }
    assert_true(told > 20 && told < 300); /* the header alone */
    (void)close(fd);
    rmap_free(data);
    end(&s);
}

/* Commits of another order, or left out, do not count: each builds on the one before. */
static void test_left_out(void **state)
{
    (void)state;
    struct scratch s;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    size_t nbytes = 0;
    begin(&s);
    write_journal(&s);
    uint8_t *data = slurp(s.path, &nbytes);
    memmove(data + s.end[2], data + s.end[3], nbytes - s.end[3]);
    spill(s.path, data, nbytes - (s.end[3] - s.end[2]));
    must(rmap_journal_read(s.path, &journal, &err), &err);
    compare(&journal, &s, 2);
    rmap_journal_fini(&journal);
    rmap_free(data);
    end(&s);
}

static void expect_nothing(struct scratch *s, const void *data, size_t nbytes)
{
    struct rmap_error err = {0};
    struct rmap_journal journal;
    struct rmap_map_content content = {0};
    spill(s->path, data, nbytes);
    must(rmap_journal_read(s->path, &journal, &err), &err);
    assert_true(journal.n_portion == 0 && !journal.layout);
    must(rmap_journal_content(&journal, s->path, "x", 0, &content, &err), &err);
    assert_int_equal(content.n_piece, 0);
    rmap_journal_fini(&journal);
}

static void test_no_commit(void **state)
{
    (void)state;
    static const uint8_t zero[5000];
    struct scratch s;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    begin(&s);
    expect_nothing(&s, "", 0);
    expect_nothing(&s, "abc", 3);
    expect_nothing(&s, zero, sizeof zero);
    char text[400];
    memset(text, 'x', sizeof text);
    spill(s.path, text, sizeof text);
    assert_int_equal(rmap_journal_read(s.path, &journal, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "no journal"));
    rmap_journal_fini(&journal);
    (void)unlink(s.path);
    assert_int_equal(rmap_journal_read(s.path, &journal, &err), RMAP_SYSTEM);
    rmap_journal_fini(&journal);
    end(&s);
}

/* One commit whose hash holds and whose numbers do not. */
struct lie {
    const char *name;
    uint64_t ray_rows; /* committed; the portion has 10 */
    uint64_t tail_first;
    size_t tail_rows;
    int chunk; /* stream of a chunk that is too many, or -1 */
    uint64_t first_row;
};

static enum rmap_status tell(const struct scratch *s, const struct lie *lie, struct rmap_error *err)
{
    struct rmap_journal_writer *writer = NULL;
    struct rmap_journal_batch batch = {0};
    struct rmap_journal journal;
    const struct rmap_journal_header header = some_header();
    struct rmap_portion_info info = {.n_row = {10}, .stored_rows = {10}};
    uint64_t n_row[RMAP_STORED_TABLE_MAX] = {lie->ray_rows};
    static const uint8_t rows[100 * 64];
    info.stored_first[0] = lie->first_row;
    must(rmap_journal_create(s->path, &header, &writer, err), err);
    for (int stream = 0; stream < s->layout->time_stream; stream++)
        if (s->layout->stream[stream].table == RMAP_TABLE_RAY)
            must(rmap_journal_add_tail(
                     &batch, stream, lie->tail_first, lie->tail_rows,
                     rmap_stream_row_nbytes(&s->layout->stream[stream], N_CHANNEL), rows, err),
                 err);
    if (lie->chunk >= 0) {
        struct rmap_chunk_entry entry = chunk_of(lie->chunk, 0);
        must(rmap_journal_add_chunks(&batch, &entry, 1, err), err);
    }
    must(rmap_journal_add_portions(&batch, false, &info, 1, err), err);
    must(rmap_journal_commit(writer, &batch, n_row, 1, err), err);
    rmap_journal_writer_destroy(writer);
    rmap_journal_batch_fini(&batch);
    enum rmap_status st = rmap_journal_read(s->path, &journal, err);
    rmap_journal_fini(&journal);
    (void)unlink(s->path);
    return st;
}

static void test_contradictions(void **state)
{
    (void)state;
    static const struct lie truth = {"truth", 10, 0, 10, -1, 0};
    static const struct lie lie[] = {
        {"more rows than portions", 11, 0, 11, -1, 0},
        {"fewer rows than portions", 9, 0, 9, -1, 0},
        {"tail too short", 10, 0, 9, -1, 0},
        {"tail too long", 10, 0, 11, -1, 0},
        {"tail elsewhere", 10, 1, 10, -1, 0},
        {"tail far away", 10, UINT64_MAX, 10, -1, 0},
        {"chunk without rows", 10, 0, 10, 2, 0},
        {"chunk of an unknown stream", 10, 0, 10, 59, 0},
        {"portion elsewhere", 10, 0, 10, -1, 3},
        {"rows without end", UINT64_MAX, 0, 10, -1, 0},
    };
    struct scratch s;
    struct rmap_error err = {0};
    begin(&s);
    must(tell(&s, &truth, &err), &err);
    for (size_t i = 0; i < sizeof lie / sizeof *lie; i++)
        if (tell(&s, &lie[i], &err) != RMAP_FORMAT)
            fail_msg("believed: %s", lie[i].name);
    end(&s);
}

static void test_memory(void **state)
{
    (void)state;
    struct scratch s;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    struct rmap_map_content content = {0};
    enum rmap_status st = RMAP_SYSTEM;
    begin(&s);
    write_journal(&s);
    int64_t at = 1;
    for (; st != RMAP_OK; at++) {
        assert_true(at < 1000);
        rmap_alloc_fail_at(at);
        st = rmap_journal_read(s.path, &journal, &err);
        if (st == RMAP_OK)
            st = rmap_journal_content(&journal, s.path, "x", 5, &content, &err);
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        rmap_journal_fini(&journal);
    }
    assert_true(at > 10);
    rmap_map_content_fini(&content);
    end(&s);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_roundtrip), cmocka_unit_test(test_truncation),
        cmocka_unit_test(test_damage),    cmocka_unit_test(test_left_out),
        cmocka_unit_test(test_no_commit), cmocka_unit_test(test_contradictions),
        cmocka_unit_test(test_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

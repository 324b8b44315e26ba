/* SPDX-License-Identifier: MIT
 *
 * A broken map is told from a whole one: what is not read right is refused, by name.
 */
#include "map_fixture.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include "io/file/seal.h"
#include "io/map/journal.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/map/map_scan.h"
#include "io/write/index_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"

enum { BLOCK = 400, N_BLOCK = 24 };

/* A file that failed to write is left to HDF5 as it is (closing it may crash), and with it some of
 * HDF5's own memory: the leak checker, where there is one, asks this function. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libhdf5_serial";
}

static void write_map(struct fixture *f, size_t piece_nbytes)
{
    struct rmap_error err = {0};
    fixture_init(f);
    fixture_must(rmap_map_create(f->map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(f, 0, 0, N_BLOCK, BLOCK, piece_nbytes, &err), &err);
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
}

static const char *map_file(const struct fixture *f, const char *name)
{
    static char path[160];
    (void)snprintf(path, sizeof path, "%s/%s", f->map, name);
    return path;
}

#define PIECE "shard-00000/piece-00000.h5"

static size_t file_nbytes(const char *path)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    return (size_t)info.st_size;
}

static uint8_t *slurp(const char *path, size_t *nbytes)
{
    *nbytes = file_nbytes(path);
    uint8_t *data = rmap_alloc(*nbytes, 1);
    int fd = open(path, O_RDONLY);
    assert_int_equal(read(fd, data, *nbytes), (ssize_t)*nbytes);
    (void)close(fd);
    return data;
}

static void poke(const char *path, size_t at, const void *data, size_t nbytes)
{
    int fd = open(path, O_WRONLY);
    assert_int_equal(pwrite(fd, data, nbytes, (off_t)at), (ssize_t)nbytes);
    (void)close(fd);
}

/* Opens the map and reads every column of every portion; checks what it gets. */
static enum rmap_status read_all(const struct fixture *f, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    struct rmap_cursor *cursor = NULL;
    enum rmap_status st = rmap_map_open(f->map, &map, err);
    if (st == RMAP_OK)
        st = rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, err);
    for (size_t i = 0; st == RMAP_OK && i < rmap_map_n_portion(map); i++) {
        const struct rmap_portion *read = NULL;
        st = rmap_cursor_read(cursor, i, &read, err);
        if (st != RMAP_OK)
            break;
        struct rmap_portion *want = fixture_portion(f, i * BLOCK, BLOCK, NULL);
        fixture_compare(read, want);
        rmap_portion_destroy(want);
    }
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    return st;
}

static void expect(const struct fixture *f, enum rmap_status want, const char *text)
{
    struct rmap_error err = {0};
    enum rmap_status st = read_all(f, &err);
    if (st != want || (text && !strstr(err.text, text)))
        fail_msg("status %d (wanted %d): '%s' lacks '%s'", (int)st, (int)want, err.text,
                 text ? text : "");
}

static void test_no_map(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    write_map(&f, 0);
    expect(&f, RMAP_OK, NULL);
    struct rmap_map *map = NULL;
    assert_int_equal(rmap_map_open("no-such-map.raymap", &map, &err), RMAP_INPUT);
    assert_int_equal(rmap_map_open(map_file(&f, PIECE), &map, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "directory"));
    assert_int_equal(rmap_map_open(map_file(&f, "shard-00000"), &map, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "no map.h5"));
    assert_null(map);
    fixture_fini(&f);
}

static void test_foreign_index(void **state)
{
    (void)state;
    struct fixture f;
    char command[300];
    write_map(&f, 0);
    (void)snprintf(command, sizeof command, "cp %s/map.h5 %s/kept && echo hello > %s/map.h5", f.map,
                   f.directory, f.map);
    assert_int_equal(system(command), 0);
    expect(&f, RMAP_FORMAT, "map.h5");
    (void)snprintf(command, sizeof command, "cp %s/%s %s/map.h5", f.map, PIECE, f.map);
    assert_int_equal(system(command), 0);
    expect(&f, RMAP_FORMAT, "not a 'raymap map'");
    (void)snprintf(command, sizeof command, "rm %s/map.h5 && mkdir %s/map.h5", f.map, f.map);
    assert_int_equal(system(command), 0);
    expect(&f, RMAP_FORMAT, "regular");
    (void)snprintf(command, sizeof command, "rmdir %s/map.h5 && : > %s/map.h5", f.map, f.map);
    assert_int_equal(system(command), 0);
    expect(&f, RMAP_FORMAT, "map.h5");
    (void)snprintf(command, sizeof command, "cp %s/kept %s/map.h5", f.directory, f.map);
    assert_int_equal(system(command), 0);
    expect(&f, RMAP_OK, NULL);
    size_t nbytes = file_nbytes(map_file(&f, "map.h5"));
    assert_int_equal(truncate(map_file(&f, "map.h5"), (off_t)(nbytes - 10)), 0);
    expect(&f, RMAP_FORMAT, "map.h5");
    fixture_fini(&f);
}

/* The value of the attribute `version` of a file, {5, 0}, is changed and the file sealed
 * anew: what a later program would write. Bytes that look like it are tried until one is it. */
static void test_other_version(void **state)
{
    (void)state;
    struct fixture f;
    size_t nbytes = 0;
    bool refused = false;
    static const uint8_t name[] = "\0version", nine = 9, was = 5, version[8] = {5};
    write_map(&f, 0);
    const char *path = map_file(&f, "map.h5");
    uint8_t *data = slurp(path, &nbytes);
    size_t at = 0;
    while (at + 100 < nbytes && memcmp(data + at, name, sizeof name) != 0)
        at++;
    for (size_t k = at; k < at + 80 && !refused; k++) {
        struct rmap_error err = {0};
        if (memcmp(data + k, version, sizeof version) != 0)
            continue;
        assert_int_equal(truncate(path, (off_t)(nbytes - 32)), 0);
        poke(path, k, &nine, 1);
        fixture_must(rmap_seal_write(path, NULL, 0, &err), &err);
        refused = read_all(&f, &err) == RMAP_FORMAT && strstr(err.text, "version 9.0");
        poke(path, k, &was, 1);
    }
    assert_true(refused);
    rmap_free(data);
    fixture_fini(&f);
}

static void test_missing_and_cut_pieces(void **state)
{
    (void)state;
    struct fixture f;
    write_map(&f, 256 << 10);
    size_t nbytes = file_nbytes(map_file(&f, PIECE));
    assert_int_equal(truncate(map_file(&f, PIECE), (off_t)(nbytes / 2)), 0);
    expect(&f, RMAP_FORMAT, PIECE);
    assert_int_equal(truncate(map_file(&f, PIECE), (off_t)nbytes), 0); /* right size, wrong bytes */
    expect(&f, RMAP_FORMAT, PIECE);
    assert_int_equal(unlink(map_file(&f, PIECE)), 0);
    expect(&f, RMAP_FORMAT, PIECE);
    struct rmap_error err = {0};
    assert_int_equal(rmap_index_write(f.map, &f.run, f.tally, false, &err), RMAP_OK);
    struct rmap_map *map = NULL;
    struct rmap_map_summary summary;
    assert_int_equal(rmap_map_open(f.map, &map, &err), RMAP_OK); /* the rest is a map again */
    rmap_map_summarise(map, &summary);
    assert_true(!summary.complete && summary.n_row[RMAP_TABLE_RAY] < BLOCK * N_BLOCK);
    rmap_map_close(map);
    fixture_fini(&f);
}

/* That HDF5 may open the piece: its seal holds. */
static enum rmap_status open_piece(const struct fixture *f, struct rmap_error *err)
{
    struct rmap_map_content content = {0};
    struct rmap_piece_origin origin;
    enum rmap_status st = rmap_piece_read(f->map, 0, 0, &content, &origin, err);
    rmap_map_content_fini(&content);
    return st;
}

/* A bit anywhere in a piece or the index is found: by whoever reads the rows, or, where HDF5's
 * own data are hit, which reading rows does without, before HDF5 could stumble over it. */
static void flip_bits(const char *name, int n_flip)
{
    struct fixture f;
    size_t nbytes = 0;
    int named = 0;
    write_map(&f, 0);
    uint8_t *data = slurp(map_file(&f, name), &nbytes);
    for (int k = 0; k < n_flip; k++) {
        struct rmap_error err = {0};
        size_t at = fixture_hash((uint64_t)k, 1) % nbytes;
        uint8_t flipped = data[at] ^ (uint8_t)(1u << (k % 8));
        poke(map_file(&f, name), at, &flipped, 1);
        enum rmap_status st = read_all(&f, &err);
        if (st == RMAP_OK && strcmp(name, PIECE) == 0)
            st = open_piece(&f, &err);
        assert_int_equal(st, RMAP_FORMAT);
        named += strstr(err.text, "chunk") && strstr(err.text, "piece-00000.h5");
        poke(map_file(&f, name), at, &data[at], 1);
    }
    expect(&f, RMAP_OK, NULL);
    if (strcmp(name, PIECE) == 0) /* nearly all of a piece is payload */
        assert_true(named > n_flip * 8 / 10);
    rmap_free(data);
    fixture_fini(&f);
}

static void test_flipped_bits(void **state)
{
    (void)state;
    flip_bits(PIECE, fixture_steps(40, 100));
    flip_bits("map.h5", fixture_steps(60, 400));
}

static void test_same_rays_twice(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    write_map(&f, 0);
    fixture_must(fixture_write_shard(&f, 1, 3, 5, BLOCK, 0, &err), &err);
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    expect(&f, RMAP_OK, NULL); /* a ghost's: each ray counts once */
    fixture_must(fixture_write_shard(&f, 2, 1, 2, BLOCK + BLOCK / 2, 0, &err), &err);
    assert_int_equal(rmap_index_write(f.map, &f.run, f.tally, true, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "both hold"));
    assert_non_null(strstr(err.text, "shard-00000/piece-00000.h5"));
    assert_non_null(strstr(err.text, "shard-00002/piece-00000.h5"));
    struct rmap_run other = f.run;
    other.seed = 43;
    assert_int_equal(rmap_index_write(f.map, &other, f.tally, true, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "seed"));
    expect(&f, RMAP_OK, NULL); /* the index that stood still stands */
    fixture_fini(&f);
}

static void test_create_over(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    char command[200];
    write_map(&f, 0);
    assert_int_equal(rmap_map_create(f.map, false, NULL, NULL, &err), RMAP_USAGE);
    expect(&f, RMAP_OK, NULL);
    (void)snprintf(command, sizeof command, "echo mine > %s/shard-00000/notes.txt", f.map);
    assert_int_equal(system(command), 0);
    assert_int_equal(rmap_map_create(f.map, true, NULL, NULL, &err), RMAP_USAGE);
    assert_non_null(strstr(err.text, "notes.txt"));
    expect(&f, RMAP_OK, NULL); /* nothing was removed */
    assert_int_equal(unlink(map_file(&f, "shard-00000/notes.txt")), 0);
    fixture_must(rmap_map_create(f.map, true, NULL, NULL, &err), &err);
    expect(&f, RMAP_FORMAT, "no map.h5");
    assert_int_equal(rmap_map_create("no-such-folder/x.raymap", false, NULL, NULL, &err),
                     RMAP_INPUT);
    assert_non_null(strstr(err.text, "no-such-folder"));
    fixture_fini(&f);
}

/* Writes stop at a size limit, as they stop on a full disk: an error that says so, no crash in
 * HDF5, no file left under any name. */
static void test_no_room(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    char command[200];
    struct rlimit limit, before;
    write_map(&f, 0);
    size_t nbytes = file_nbytes(map_file(&f, PIECE));
    (void)signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    int n_limit = fixture_steps(10, 40);
    for (int k = 0; k < n_limit; k++) {
        limit = before;
        limit.rlim_cur = (rlim_t)(nbytes * (size_t)k / (size_t)n_limit);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
        int64_t live = rmap_alloc_live();
        enum rmap_status st = fixture_write_shard(&f, 1, 0, N_BLOCK, BLOCK, 0, &err);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        assert_int_equal(st, RMAP_SYSTEM);
        assert_non_null(strstr(err.text, "File too large"));
        assert_int_equal(rmap_alloc_live(), live);
    }
    (void)snprintf(command, sizeof command, "test -z \"$(ls -A %s/shard-00001)\"", f.map);
    assert_int_equal(system(command), 0);
    expect(&f, RMAP_OK, NULL);
    fixture_fini(&f);
}

/* Some allocations may fail without harm (the text of a warning): the end is reached only when
 * that many in a row made no difference. */
enum { HARMLESS_MAX = 8 };

/* One allocation after another fails: an error, no leak, nothing half-published. */
static void test_out_of_memory(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    struct rmap_portion *portion = fixture_portion(&f, 0, BLOCK, f.tally);
    int64_t live = rmap_alloc_live();
    int harmless = 0;
    for (int64_t k = 1; harmless < HARMLESS_MAX; k += fixture_steps(5, 1)) {
        struct rmap_shard_writer *writer = NULL;
        fixture_must(rmap_map_create(f.map, true, NULL, NULL, &err), &err);
        rmap_alloc_fail_at(k);
        enum rmap_status st = rmap_shard_writer_create(f.map, 0, &f.run, 0, &writer, &err);
        if (st == RMAP_OK)
            st = rmap_shard_writer_append(writer, portion, &err);
        if (st == RMAP_OK)
            st = rmap_shard_writer_finish(writer, &err);
        rmap_shard_writer_destroy(writer);
        if (st == RMAP_OK)
            st = rmap_index_write(f.map, &f.run, f.tally, true, &err);
        harmless = st == RMAP_OK ? harmless + 1 : 0;
        rmap_alloc_fail_at(0);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        assert_int_equal(rmap_alloc_live(), live);
    }
    harmless = 0;
    for (int64_t k = 1; harmless < HARMLESS_MAX; k += fixture_steps(5, 1)) {
        struct rmap_map *map = NULL;
        struct rmap_cursor *cursor = NULL;
        const struct rmap_portion *read = NULL;
        rmap_alloc_fail_at(k);
        enum rmap_status st = rmap_map_open(f.map, &map, &err);
        if (st == RMAP_OK)
            st = rmap_cursor_create(map, RMAP_COLUMNS_ALL, &cursor, &err);
        if (st == RMAP_OK)
            st = rmap_cursor_read(cursor, 0, &read, &err);
        harmless = st == RMAP_OK ? harmless + 1 : 0;
        rmap_alloc_fail_at(0);
        rmap_cursor_destroy(cursor);
        rmap_map_close(map);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        assert_int_equal(rmap_alloc_live(), live);
    }
    rmap_portion_destroy(portion);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Who waits at a pipe's end waits for ever. */
static void test_pipe(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rmap_journal journal;
    char path[64];
    (void)snprintf(path, sizeof path, "pipe-%ld", (long)getpid());
    assert_int_equal(mkfifo(path, 0600), 0);
    assert_int_equal(rmap_seal_check(path, &err), RMAP_FORMAT);
    assert_int_equal(rmap_journal_read(path, &journal, &err), RMAP_FORMAT);
    rmap_journal_fini(&journal);
    assert_int_equal(unlink(path), 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_pipe),
        cmocka_unit_test(test_no_map),
        cmocka_unit_test(test_foreign_index),
        cmocka_unit_test(test_other_version),
        cmocka_unit_test(test_missing_and_cut_pieces),
        cmocka_unit_test(test_flipped_bits),
        cmocka_unit_test(test_same_rays_twice),
        cmocka_unit_test(test_create_over),
        cmocka_unit_test(test_no_room),
        cmocka_unit_test(test_out_of_memory),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * What a shard flushed outlives its writer, whenever that one is killed.
 */
#include "map_leftover.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "io/file/shared_memory.h"
#include "io/map/map_content.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/map/map_state.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_piece.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"

/* A file that failed to write is left to HDF5 as it is (closing it may crash), and with it some of
 * HDF5's own memory: the leak checker, where there is one, asks this function. */
const char *__lsan_default_suppressions(void);
const char *__lsan_default_suppressions(void)
{
    return "leak:libhdf5_serial";
}

/* Flushed by hand: all of it is there, in buffers, in stored chunks and in published pieces. */
static void flush_in(enum rmap_encoding encoding)
{
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    const struct rmap_shard_options options = {.piece_nbytes = 24 << 20};
    begin_map(&f, encoding);
    fixture_must(rmap_shard_writer_create(f.map, 0, &f.run, &options, &writer, &err), &err);
    fixture_must(rmap_shard_writer_flush(writer, &err), &err); /* of nothing */
    assert_int_equal(n_leftover(&f), 0);
    uint64_t last = 0;
    static const uint64_t stop[] = {1, 7, 30, 121};
    for (size_t k = 0; k < sizeof stop / sizeof *stop; k++) {
        for (; last < stop[k]; last++)
            append(&f, writer, last);
        fixture_must(rmap_shard_writer_flush(writer, &err), &err);
        assert_int_equal(read_back(&f), last * BLOCK);
    }
    assert_true(n_leftover(&f) == 1);
    append(&f, writer, last);
    assert_int_equal(read_back(&f), last * BLOCK); /* not flushed, not there */
    fixture_must(rmap_shard_writer_finish(writer, &err), &err);
    assert_int_equal(n_leftover(&f), 0);
    assert_int_equal(read_back(&f), (last + 1) * BLOCK);
    rmap_shard_writer_destroy(writer);
    fixture_fini(&f);
}

static void test_flush(void **state)
{
    (void)state;
    flush_in(RMAP_ENCODING_PLAIN);
    flush_in(RMAP_ENCODING_COMPACT);
}

/* By number of portions, and what was flushed stays when the writer goes without finishing. */
static void test_portions(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    const struct rmap_shard_options options = {.flush_portions = 4};
    begin_map(&f, RMAP_ENCODING_PLAIN);
    fixture_must(rmap_shard_writer_create(f.map, 0, &f.run, &options, &writer, &err), &err);
    for (uint64_t block = 0; block < 11; block++) {
        append(&f, writer, block);
        fixture_must(rmap_shard_writer_store(writer, &err), &err);
        assert_int_equal(read_back(&f), (block + 1) / 4 * 4 * BLOCK);
    }
    rmap_shard_writer_destroy(writer);
    assert_int_equal(n_leftover(&f), 1);
    assert_int_equal(read_back(&f), 8 * BLOCK);
    fixture_must(rmap_map_create(f.map, true, NULL, NULL, &err), &err); /* as --force does */
    assert_int_equal(n_leftover(&f), 0);
    fixture_fini(&f);
}

/* Two processes have a map's rows in the same memory, as another process finds it; what one of them
 * writes there is its own. */
static void share_memory(const struct fixture *f, const struct rmap_map *map, uint64_t n_ray)
{
    struct rmap_error err = {0};
    struct rmap_map *sharing[2];
    struct rmap_shared_place place;
    const int fd = rmap_shared_memory_create(&place);
    const int again = rmap_shared_memory_open(&place);
    assert_true(fd >= 0 && again >= 0);
    place.inode++;
    assert_int_equal(rmap_shared_memory_open(&place), -1);
    fixture_must(rmap_map_state_share(map, fd, &err), &err);
    for (int i = 0; i < 2; i++) {
        fixture_must(rmap_map_open_bare(f->map, "map.h5", &sharing[i], &err), &err);
        fixture_must(rmap_map_state_join(sharing[i], i ? fd : again, &err), &err);
    }
    (void)close(fd);
    (void)close(again);
    memset(rmap_map_contents(sharing[0])->portion, 0, sizeof(struct rmap_portion_info));
    rmap_map_close(sharing[0]);
    assert_int_equal(read_map(f, sharing[1]), n_ray);
    struct rmap_map_summary here, there;
    rmap_map_summarise(map, &here);
    rmap_map_summarise(sharing[1], &there);
    assert_memory_equal(&here.digest, &there.digest, sizeof here.digest);
    assert_memory_equal(here.n_row, there.n_row, sizeof here.n_row);
    rmap_map_close(sharing[1]);
}

/* A map that was opened while a piece was written is read on when the piece got its final name and
 * others came: nothing is missing, and nothing that came since is a trouble. Another process that
 * is given the state opens the same. */
static void publish_in(enum rmap_encoding encoding)
{
    enum { N_FLUSHED = 65, N_BLOCK = 100 };
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    struct rmap_map *map = NULL, *other = NULL;
    uint8_t *state = NULL;
    size_t n_state = 0;
    struct rmap_verification *what = NULL;
    struct rmap_chunk_verifier *chunks = NULL;
    struct rmap_findings findings = {0};
    const struct rmap_shard_options options = {.piece_nbytes = 12 << 20};
    begin_map(&f, encoding);
    fixture_must(rmap_shard_writer_create(f.map, 0, &f.run, &options, &writer, &err), &err);
    for (uint64_t block = 0; block < N_FLUSHED; block++)
        append(&f, writer, block);
    fixture_must(rmap_shard_writer_flush(writer, &err), &err);
    fixture_must(rmap_map_open(f.map, &map, &err), &err);
    fixture_must(rmap_verification_open(f.map, &what, &findings, &err), &err);
    fixture_must(rmap_map_state_pack(map, &state, &n_state, &err), &err);
    for (uint64_t block = N_FLUSHED; block < N_BLOCK; block++) {
        append(&f, writer, block);
        fixture_must(rmap_shard_writer_flush(writer, &err), &err);
    }
    fixture_must(rmap_shard_writer_finish(writer, &err), &err);
    rmap_shard_writer_destroy(writer);
    assert_int_equal(n_leftover(&f), 0);
    assert_int_equal(read_map(&f, map), N_FLUSHED * BLOCK);
    fixture_must(rmap_map_open_listed(f.map, &other, &err), &err);
    assert_int_equal(rmap_map_n_portion(other), 0);
    fixture_must(rmap_map_state_take(other, state, n_state, &err), &err);
    assert_int_equal(read_map(&f, other), N_FLUSHED * BLOCK);
    struct rmap_map_summary here, there;
    rmap_map_summarise(map, &here);
    rmap_map_summarise(other, &there);
    assert_memory_equal(&here.digest, &there.digest, sizeof here.digest);
    assert_int_equal(here.nbytes, there.nbytes);
    assert_memory_equal(rmap_map_tally(map)->value, rmap_map_tally(other)->value,
                        rmap_map_tally(map)->n_value * sizeof(double));
    assert_int_equal(rmap_map_state_take(other, state, n_state - 1, &err), RMAP_FORMAT);
    rmap_map_close(other);
    rmap_free(state);
    share_memory(&f, map, N_FLUSHED * BLOCK);
    fixture_must(rmap_map_compare_directory(map, &err), &err);
    if (rmap_map_n_trouble(map) > 0)
        fail_msg("%s", rmap_map_trouble(map, 0));
    fixture_must(rmap_chunk_verifier_create(what, &chunks, &err), &err);
    for (size_t i = 0; i < what->content->n_chunk; i++)
        fixture_must(rmap_verify_chunk(chunks, i, &findings, &err), &err);
    if (findings.n > 0)
        fail_msg("%s %s", findings.row[0].file, findings.row[0].text);
    rmap_chunk_verifier_destroy(chunks);
    rmap_verification_close(what);
    rmap_map_close(map);
    fixture_fini(&f);
}

static void test_published_meanwhile(void **state)
{
    (void)state;
    publish_in(RMAP_ENCODING_PLAIN);
    publish_in(RMAP_ENCODING_COMPACT);
}

/* Without a flush nothing stays. */
static void test_no_flush(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    const struct rmap_shard_options options = {0};
    begin_map(&f, RMAP_ENCODING_PLAIN);
    fixture_must(rmap_shard_writer_create(f.map, 0, &f.run, &options, &writer, &err), &err);
    for (uint64_t block = 0; block < 30; block++)
        append(&f, writer, block);
    for (bool did = true; did;)
        fixture_must(rmap_shard_writer_encode(writer, &did, &err), &err);
    fixture_must(rmap_shard_writer_store(writer, &err), &err);
    rmap_shard_writer_destroy(writer);
    assert_int_equal(n_leftover(&f), 0);
    assert_int_equal(read_back(&f), 0);
    fixture_fini(&f);
}

/* The names that two writers choose do not meet: neither those of finished pieces nor, with the
 * same process number, those of unfinished ones. */
static void test_names(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer[2] = {NULL, NULL};
    const struct rmap_shard_options options = {.flush_portions = 1};
    begin_map(&f, RMAP_ENCODING_PLAIN);
    for (int k = 0; k < 2; k++)
        fixture_must(rmap_shard_writer_create(f.map, 0, &f.run, &options, &writer[k], &err), &err);
    for (uint64_t k = 0; k < 2; k++) {
        append(&f, writer[k], k);
        fixture_must(rmap_shard_writer_flush(writer[k], &err), &err);
    }
    assert_int_equal(n_leftover(&f), 2);
    assert_int_equal(read_back(&f), 2 * BLOCK);
    for (int k = 0; k < 2; k++) {
        fixture_must(rmap_shard_writer_finish(writer[k], &err), &err);
        rmap_shard_writer_destroy(writer[k]);
    }
    struct rmap_piece_name *name = NULL;
    size_t n = 0;
    fixture_must(rmap_map_list_pieces(f.map, &name, &n, &err), &err);
    assert_int_equal(n, 2);
    assert_int_equal(name[1].number, 1);
    rmap_free(name);
    assert_int_equal(n_leftover(&f), 0);
    assert_int_equal(read_back(&f), 2 * BLOCK);
    fixture_fini(&f);
}

/* No file may grow beyond a limit, as on a full disk: an error, and what was safe stays so. */
static void test_no_room(void **state)
{
    (void)state;
    enum { N_BLOCK = 40 };
    int n_limit = fixture_steps(8, 20);
    struct rlimit before;
    uint64_t most = 0;
    (void)signal(SIGXFSZ, SIG_IGN);
    assert_int_equal(getrlimit(RLIMIT_FSIZE, &before), 0);
    for (int k = 0; k < n_limit; k++) {
        struct fixture f;
        struct rmap_error err = {0};
        struct rmap_shard_writer *writer = NULL;
        const struct rmap_shard_options options = {0};
        struct rlimit limit = before;
        uint64_t told = 0;
        begin_map(&f, k % 2 ? RMAP_ENCODING_COMPACT : RMAP_ENCODING_PLAIN);
        limit.rlim_cur = 10000 + 3000000 / (rlim_t)n_limit * (rlim_t)k;
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
        enum rmap_status st = rmap_shard_writer_create(f.map, 0, &f.run, &options, &writer, &err);
        for (uint64_t block = 0; st == RMAP_OK && block < N_BLOCK; block++) {
            append(&f, writer, block);
            st = rmap_shard_writer_flush(writer, &err);
            if (st == RMAP_OK)
                told = (block + 1) * BLOCK;
        }
        assert_int_equal(st, RMAP_SYSTEM);
        assert_non_null(strstr(err.text, "File too large"));
        rmap_shard_writer_destroy(writer);
        assert_int_equal(setrlimit(RLIMIT_FSIZE, &before), 0);
        assert_true(read_back(&f) >= told);
        most = told > most ? told : most;
        fixture_fini(&f);
    }
    assert_true(most > 5 * BLOCK);
}

/* The child writes, and tells after every flush how many rays are safe. */
static void write_until_killed(struct fixture *f, int fd)
{
    struct rmap_shard_writer *writer = NULL;
    const struct rmap_shard_options options = {.piece_nbytes = 6 << 20};
    bool did = true;
    enum rmap_status st = rmap_shard_writer_create(f->map, 0, &f->run, &options, &writer, NULL);
    for (uint64_t block = 0; st == RMAP_OK; block++) {
        struct rmap_portion *portion = fixture_portion(f, block * BLOCK, BLOCK, NULL);
        st = rmap_shard_writer_append(writer, portion, NULL);
        rmap_portion_destroy(portion);
        for (did = true; did && st == RMAP_OK;)
            st = rmap_shard_writer_encode(writer, &did, NULL);
        if (st == RMAP_OK)
            st = rmap_shard_writer_store(writer, NULL);
        if (st == RMAP_OK && block % 3 == 0) {
            uint64_t n_ray = (block + 1) * BLOCK;
            st = rmap_shard_writer_flush(writer, NULL);
            if (write(fd, &n_ray, sizeof n_ray) != (ssize_t)sizeof n_ray)
                break;
        }
    }
    _exit(1);
}

static uint64_t last_told(int fd)
{
    uint64_t n_ray = 0, told = 0;
    while (read(fd, &n_ray, sizeof n_ray) == (ssize_t)sizeof n_ray)
        told = n_ray;
    return told;
}

static void test_kill(void **state)
{
    (void)state;
    int n_kill = fixture_steps(10, 40);
    uint64_t most = 0;
    for (int k = 0; k < n_kill; k++) {
        struct fixture f;
        int pipe_fd[2], status = 0;
        begin_map(&f, k % 2 ? RMAP_ENCODING_COMPACT : RMAP_ENCODING_PLAIN);
        assert_int_equal(pipe(pipe_fd), 0);
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0)
            write_until_killed(&f, pipe_fd[1]);
        (void)close(pipe_fd[1]);
        /* After some flushes, so that a busy machine is waited for, and then at any moment. */
        uint64_t early = 0;
        for (uint64_t i = fixture_hash((uint64_t)k, 8) % 14; i > 0; i--)
            assert_int_equal(read(pipe_fd[0], &early, sizeof early), (ssize_t)sizeof early);
        const struct timespec wait = {.tv_nsec = (long)(fixture_hash((uint64_t)k, 9) % 30000000)};
        (void)nanosleep(&wait, NULL);
        assert_int_equal(kill(child, SIGKILL), 0);
        assert_int_equal(waitpid(child, &status, 0), child);
        assert_true(WIFSIGNALED(status));
        uint64_t late = last_told(pipe_fd[0]), told = late > early ? late : early;
        uint64_t n_ray = read_back(&f);
        (void)close(pipe_fd[0]);
        if (n_ray < told)
            fail_msg("kill %d: %llu rays were safe, %llu are there", k, (unsigned long long)told,
                     (unsigned long long)n_ray);
        most = n_ray > most ? n_ray : most;
        fixture_fini(&f);
    }
    assert_true(most > 3 * BLOCK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_flush),
        cmocka_unit_test(test_portions),
        cmocka_unit_test(test_no_flush),
        cmocka_unit_test(test_names),
        cmocka_unit_test(test_no_room),
        cmocka_unit_test(test_kill),
        cmocka_unit_test(test_published_meanwhile),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * What a killed writer left becomes finished pieces: every ray once, none that was safe lost.
 */
#include "map_leftover.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <time.h>

#include "io/map/map_content.h"
#include "io/map/map_reader.h"
#include "io/recovery/salvage.h"
#include "io/write/index_writer.h"
#include "io/write/shard_writer.h"

/* Blocks [first, last) flushed by a writer that goes without finishing. */
static void leave(struct fixture *f, int shard, uint64_t first, uint64_t last)
{
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    const struct rmap_shard_options options = {0};
    fixture_must(rmap_shard_writer_create(f->map, shard, &f->run, &options, &writer, &err), &err);
    for (uint64_t block = first; block < last; block++)
        append(f, writer, block);
    fixture_must(rmap_shard_writer_flush(writer, &err), &err);
    rmap_shard_writer_destroy(writer);
}

/* Salvages all that is there; sums up. */
static enum rmap_status salvage_all(const struct fixture *f, struct rmap_salvaged *sum,
                                    struct rmap_map_content *content, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_map *map = NULL;
    struct rmap_leftover *leftover = NULL;
    size_t n = 0;
    *sum = (struct rmap_salvaged){0};
    RMAP_TRY(rmap_map_open_untallied(f->map, &map, err));
    RMAP_TRY(rmap_map_list_leftovers(f->map, &leftover, &n, err));
    for (size_t i = 0; i < n; i++) {
        struct rmap_salvaged one;
        RMAP_TRY(rmap_salvage(map, &leftover[i], content, &one, err));
        sum->n_piece += one.n_piece;
        sum->n_ray += one.n_ray;
        sum->n_portion_lost += one.n_portion_lost;
        sum->n_ray_lost += one.n_ray_lost;
        if (one.first_lost[0])
            memcpy(sum->first_lost, one.first_lost, sizeof one.first_lost);
    }
out:
    rmap_free(leftover);
    rmap_map_close(map);
    return st;
}

static struct rmap_salvaged salvage(const struct fixture *f)
{
    struct rmap_error err = {0};
    struct rmap_salvaged sum;
    struct rmap_map_content content = {0};
    fixture_must(salvage_all(f, &sum, &content, &err), &err);
    assert_int_equal(content.n_piece, sum.n_piece);
    rmap_map_content_fini(&content);
    assert_int_equal(n_leftover(f), 0);
    return sum;
}

/* Chunks, tails and an exact end of a chunk of /ray; the result is a map like any other. */
static void whole_in(enum rmap_encoding encoding)
{
    static const uint64_t n_block[] = {1, 170};
    for (size_t k = 0; k < sizeof n_block / sizeof *n_block; k++) {
        struct fixture f;
        struct rmap_error err = {0};
        begin_map(&f, encoding);
        leave(&f, 0, 0, n_block[k]);
        leave(&f, 1, n_block[k], n_block[k] + 2);
        struct rmap_salvaged sum = salvage(&f);
        assert_int_equal(sum.n_ray, (n_block[k] + 2) * BLOCK);
        assert_int_equal(sum.n_piece, 2);
        assert_int_equal(sum.n_portion_lost, 0);
        assert_int_equal(read_back(&f), (n_block[k] + 2) * BLOCK);
        fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
        assert_int_equal(read_back(&f), (n_block[k] + 2) * BLOCK);
        fixture_fini(&f);
    }
}

static void test_whole(void **state)
{
    (void)state;
    whole_in(RMAP_ENCODING_PLAIN);
    whole_in(RMAP_ENCODING_COMPACT);
}

/* Salvaged is what would have been written: the same bytes per dataset, whatever their order. */
static void test_same_chunks(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    begin_map(&f, RMAP_ENCODING_PLAIN);
    leave(&f, 0, 0, 40);
    (void)salvage(&f);
    fixture_must(fixture_write_shard(&f, 1, 40, 80, BLOCK, 0, &err), &err);
    fixture_must(rmap_map_open(f.map, &map, &err), &err);
    const struct rmap_map_content *content = rmap_map_contents(map);
    assert_int_equal(content->n_piece, 2);
    assert_int_equal(content->piece[0].n_chunk, content->piece[1].n_chunk);
    rmap_map_close(map);
    fixture_fini(&f);
}

static void flip_part(const struct fixture *f, uint64_t offset)
{
    char path[600];
    struct rmap_error err = {0};
    struct rmap_leftover *leftover = NULL;
    size_t n = 0;
    uint8_t byte = 0;
    fixture_must(rmap_map_list_leftovers(f->map, &leftover, &n, &err), &err);
    assert_int_equal(n, 1);
    (void)snprintf(path, sizeof path, "%s/%s", f->map, leftover[0].name);
    rmap_free(leftover);
    int fd = open(path, O_RDWR);
    assert_int_equal(pread(fd, &byte, 1, (off_t)offset), 1);
    byte ^= 4;
    assert_int_equal(pwrite(fd, &byte, 1, (off_t)offset), 1);
    (void)close(fd);
}

/* The first large one from the fourth on of rows that belong to portions: all need the whole
 * tables, and what is small may be 0 throughout and asked for by nobody. */
static struct rmap_chunk_entry some_chunk(const struct rmap_map *map)
{
    const struct rmap_map_content *content = rmap_map_contents(map);
    const struct rmap_layout *layout =
        rmap_piece_layout(&content->piece[0], rmap_map_scene(map)->channels.mode);
    size_t k = 3;
    while ((layout->whole_tables >> layout->stream[content->chunk[k].stream].table & 1) ||
           content->chunk[k].nbytes < 4096) {
        k++;
        assert_true(k < content->n_chunk);
    }
    return content->chunk[k];
}

static void damaged_in(enum rmap_encoding encoding)
{
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_map *map = NULL;
    begin_map(&f, encoding);
    leave(&f, 0, 0, 60);
    fixture_must(rmap_map_open_untallied(f.map, &map, &err), &err);
    const struct rmap_map_content *content = rmap_map_contents(map);
    assert_true(content->n_chunk > 5 && content->n_tail > 0);
    struct rmap_chunk_entry entry = some_chunk(map);
    rmap_map_close(map);
    flip_part(&f, entry.offset + entry.nbytes / 2);
    struct rmap_salvaged sum = salvage(&f);
    assert_true(sum.n_portion_lost > 0 && sum.n_portion_lost < 60);
    assert_int_equal(sum.n_ray + sum.n_ray_lost, 60 * BLOCK);
    assert_non_null(strstr(sum.first_lost, "rays "));
    assert_non_null(strstr(sum.first_lost, "chunk"));
    assert_int_equal(read_back(&f), sum.n_ray);
    fixture_fini(&f);
}

static void test_damaged(void **state)
{
    (void)state;
    damaged_in(RMAP_ENCODING_PLAIN);
    damaged_in(RMAP_ENCODING_COMPACT);
}

#define SHELL(...)                                                                                 \
    do {                                                                                           \
        char command[400];                                                                         \
        (void)snprintf(command, sizeof command, __VA_ARGS__);                                      \
        assert_int_equal(system(command), 0);                                                      \
    } while (0)

/* A salvage that was killed after it published and before it removed: nothing is there twice. */
static void test_twice(void **state)
{
    (void)state;
    struct fixture f;
    begin_map(&f, RMAP_ENCODING_PLAIN);
    leave(&f, 0, 0, 30);
    SHELL("cp -a %s/shard-00000 %s/kept", f.map, f.directory);
    assert_int_equal(salvage(&f).n_ray, 30 * BLOCK);
    SHELL("cp -a %s/kept/.piece* %s/shard-00000/", f.directory, f.map);
    assert_int_equal(n_leftover(&f), 1);
    assert_int_equal(read_back(&f), 30 * BLOCK);
    assert_int_equal(salvage(&f).n_piece, 0);
    assert_int_equal(read_back(&f), 30 * BLOCK);
    fixture_fini(&f);
}

/* Two lives of a run traced some of the same rays. */
static void overlap_in(enum rmap_encoding encoding)
{
    struct fixture f;
    struct rmap_error err = {0};
    begin_map(&f, encoding);
    leave(&f, 0, 0, 30);
    leave(&f, 0, 20, 50);
    assert_int_equal(n_leftover(&f), 2);
    assert_int_equal(read_back(&f), 50 * BLOCK);
    assert_int_equal(salvage(&f).n_ray, 50 * BLOCK);
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    assert_int_equal(read_back(&f), 50 * BLOCK);
    fixture_fini(&f);
}

static void test_overlap(void **state)
{
    (void)state;
    overlap_in(RMAP_ENCODING_PLAIN);
    overlap_in(RMAP_ENCODING_COMPACT);
}

static void test_worthless(void **state)
{
    (void)state;
    struct fixture f;
    begin_map(&f, RMAP_ENCODING_PLAIN);
    leave(&f, 0, 0, 3);
    SHELL("for f in %s/shard-00000/.*.journal; do : > $f; done", f.map);
    assert_int_equal(salvage(&f).n_piece, 0);
    leave(&f, 0, 0, 3);
    SHELL("rm %s/shard-00000/.*.journal", f.map);
    assert_int_equal(salvage(&f).n_piece, 0);
    leave(&f, 0, 0, 3);
    SHELL("rm %s/shard-00000/.*.part", f.map);
    assert_int_equal(salvage(&f).n_piece, 0);
    assert_int_equal(read_back(&f), 0);
    fixture_fini(&f);
}

/* Of another seed: told, and left alone. */
static void test_foreign(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    struct rmap_salvaged sum;
    struct rmap_map_content content = {0};
    begin_map(&f, RMAP_ENCODING_PLAIN);
    f.run.seed = 43;
    leave(&f, 0, 0, 3);
    f.run.seed = 42;
    assert_int_equal(read_back(&f), 0);
    assert_int_equal(salvage_all(&f, &sum, &content, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "another"));
    assert_int_equal(n_leftover(&f), 1);
    rmap_map_content_fini(&content);
    fixture_fini(&f);
}

static void test_memory(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    enum rmap_status st = RMAP_SYSTEM;
    begin_map(&f, RMAP_ENCODING_PLAIN);
    leave(&f, 0, 0, 1);
    int64_t live = rmap_alloc_live();
    /* Near the end, published and not removed, the next salvage has nothing left to do. */
    for (int64_t at = 1; st != RMAP_OK; at += fixture_steps(149, 37)) {
        struct rmap_map_content content = {0};
        struct rmap_salvaged sum;
        assert_true(at < 100000);
        rmap_alloc_fail_at(at);
        st = salvage_all(&f, &sum, &content, &err);
        rmap_alloc_fail_at(0);
        rmap_map_content_fini(&content);
        assert_true(st == RMAP_OK || st == RMAP_SYSTEM);
        assert_int_equal(rmap_alloc_live(), live);
        assert_int_equal(read_back(&f), BLOCK);
    }
    assert_int_equal(n_leftover(&f), 0);
    fixture_fini(&f);
}

/* Killed while salvaging, again and again until one comes through. */
static void kill_in(enum rmap_encoding encoding)
{
    struct fixture f;
    int n_kill = 0;
    begin_map(&f, encoding);
    leave(&f, 0, 0, 20);
    for (bool done = false; !done; n_kill++) {
        int status = 0;
        pid_t child = fork();
        assert_true(child >= 0);
        if (child == 0) {
            struct rmap_map_content content = {0};
            struct rmap_salvaged sum;
            _exit(salvage_all(&f, &sum, &content, NULL) == RMAP_OK ? 0 : 1);
        }
        const long ms = 1L << n_kill; /* a busy machine gets there, too */
        const struct timespec wait = {ms / 1000, ms % 1000 * 1000000};
        (void)nanosleep(&wait, NULL);
        (void)kill(child, SIGKILL);
        assert_int_equal(waitpid(child, &status, 0), child);
        done = WIFEXITED(status);
        if (done)
            assert_int_equal(WEXITSTATUS(status), 0);
        assert_int_equal(read_back(&f), 20 * BLOCK);
    }
    assert_true(n_kill > 2);
    (void)salvage(&f);
    assert_int_equal(read_back(&f), 20 * BLOCK);
    fixture_fini(&f);
}

static void test_kill(void **state)
{
    (void)state;
    kill_in(RMAP_ENCODING_PLAIN);
    kill_in(RMAP_ENCODING_COMPACT);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_whole),   cmocka_unit_test(test_same_chunks),
        cmocka_unit_test(test_damaged), cmocka_unit_test(test_twice),
        cmocka_unit_test(test_overlap), cmocka_unit_test(test_worthless),
        cmocka_unit_test(test_foreign), cmocka_unit_test(test_memory),
        cmocka_unit_test(test_kill),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

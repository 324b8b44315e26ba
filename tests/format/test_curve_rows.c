/* SPDX-License-Identifier: MIT
 *
 * /curve: maps whose scene has gradient media have it and a format of their own, other maps do not;
 * points that lie on no segment are refused, in either encoding.
 */
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"
#include "io/write/shard_append.h"
#include "io/write/shard_writer.h"
#include "map_fixture.h"

#include <fcntl.h>
#include <sys/stat.h>

enum { BLOCK = 300 };

static void write_portion(struct fixture *f, enum rmap_encoding encoding,
                          const struct rmap_portion *portion)
{
    struct rmap_error err = {0};
    struct rmap_shard_writer *writer = NULL;
    f->run.encoding = encoding;
    fixture_must(rmap_map_create(f->map, true, NULL, NULL, &err), &err);
    fixture_must(rmap_shard_writer_create(f->map, 0, &f->run, 0, &writer, &err), &err);
    fixture_must(rmap_shard_writer_append(writer, portion, &err), &err);
    fixture_must(rmap_shard_writer_finish(writer, &err), &err);
    rmap_shard_writer_destroy(writer);
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
}

static enum rmap_status read_portion(const struct fixture *f, rmap_column_set columns,
                                     const struct rmap_portion *want, struct rmap_error *err)
{
    struct rmap_map *map = NULL;
    struct rmap_cursor *cursor = NULL;
    const struct rmap_portion *read = NULL;
    fixture_must(rmap_map_open(f->map, &map, err), err);
    fixture_must(rmap_cursor_create(map, columns, &cursor, err), err);
    enum rmap_status st = rmap_cursor_read(cursor, 0, &read, err);
    if (st == RMAP_OK && want)
        fixture_compare(read, want);
    rmap_cursor_destroy(cursor);
    rmap_map_close(map);
    return st;
}

/* Every column set gives the same rows; the points alone need nothing else. */
static void test_columns(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    const rmap_column_set some[] = {RMAP_COLUMNS_ALL, RMAP_COLUMNS_CURVE,
                                    RMAP_COLUMN_BIT(RMAP_CURVE_position),
                                    RMAP_COLUMNS_CURVE | RMAP_COLUMN_BIT(RMAP_SEGMENT_position)};
    fixture_init(&f);
    struct rmap_portion *portion = fixture_portion(&f, 0, BLOCK, f.tally);
    assert_true(portion->n_row[RMAP_TABLE_CURVE] > BLOCK);
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        write_portion(&f, (enum rmap_encoding)e, portion);
        for (size_t i = 0; i < sizeof some / sizeof *some; i++)
            fixture_must(read_portion(&f, some[i], portion, &err), &err);
    }
    rmap_portion_destroy(portion);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

static void test_points_of_no_segment(void **state)
{
    (void)state;
    struct fixture f;
    fixture_init(&f);
    struct rmap_portion *portion = fixture_portion(&f, 0, BLOCK, f.tally);
    const struct rmap_curve_columns *curve = &portion->curve;
    size_t n = portion->n_row[RMAP_TABLE_CURVE], at = n / 2;
    while (curve->ray[at] != curve->ray[at - 1] || curve->segment[at] == 0)
        at++;
    const struct {
        size_t row;
        uint64_t ray;
        uint32_t segment;
        const char *says;
    } lie[] = {
        {at, curve->ray[at], 99, "no segment"},          /* more than it has */
        {at - 1, curve->ray[at], 20, "no segment"},      /* and not in order */
        {at, curve->ray[at] - 1, 0, "no ray"},           /* a ray that is over */
        {n - 1, BLOCK, curve->segment[n - 1], "no ray"}, /* one of another block */
    };
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++)
        for (size_t i = 0; i < sizeof lie / sizeof *lie; i++) {
            struct rmap_error err = {0};
            uint64_t ray = curve->ray[lie[i].row];
            uint32_t segment = curve->segment[lie[i].row];
            curve->ray[lie[i].row] = lie[i].ray;
            curve->segment[lie[i].row] = lie[i].segment;
            write_portion(&f, (enum rmap_encoding)e, portion);
            assert_int_equal(read_portion(&f, RMAP_COLUMNS_ALL, NULL, &err), RMAP_FORMAT);
            if (!strstr(err.text, lie[i].says))
                fail_msg("%zu: %s", i, err.text);
            curve->ray[lie[i].row] = ray;
            curve->segment[lie[i].row] = segment;
        }
    rmap_portion_destroy(portion);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

/* Whether a file of the map speaks of /curve. */
static bool has_curve(const struct fixture *f, const char *name)
{
    static const char word[] = "/curve/ray";
    char path[160];
    struct stat info;
    bool has = false;
    (void)snprintf(path, sizeof path, "%s/%s", f->map, name);
    int fd = open(path, O_RDONLY);
    assert_true(fd >= 0 && fstat(fd, &info) == 0);
    char *data = rmap_alloc((size_t)info.st_size, 1);
    assert_int_equal(read(fd, data, (size_t)info.st_size), info.st_size);
    for (size_t i = 0; !has && i + sizeof word <= (size_t)info.st_size; i++)
        has = memcmp(data + i, word, sizeof word - 1) == 0;
    rmap_free(data);
    assert_int_equal(close(fd), 0);
    return has;
}

#define PIECE "shard-00000/piece-00000.h5"

/* Without gradient media nothing of it is in the files; without curved rays the table is empty. */
static void test_formats(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    fixture_init(&f);
    struct rmap_portion *curved = fixture_portion(&f, 0, BLOCK, NULL);
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        write_portion(&f, (enum rmap_encoding)e, curved);
        assert_true(has_curve(&f, PIECE) && has_curve(&f, "map.h5"));
    }
    fixture_fini(&f);

    assert_int_equal(setenv("FIXTURE", "uniform", 1), 0);
    fixture_init(&f);
    struct rmap_portion *straight = fixture_portion(&f, 0, BLOCK, NULL);
    assert_int_equal(straight->n_row[RMAP_TABLE_CURVE], 0);
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) {
        struct rmap_shard_writer *writer = NULL;
        write_portion(&f, (enum rmap_encoding)e, straight);
        assert_false(has_curve(&f, PIECE) || has_curve(&f, "map.h5"));
        fixture_must(rmap_shard_writer_create(f.map, 1, &f.run, 0, &writer, &err), &err);
        assert_int_equal(rmap_shard_writer_append(writer, curved, &err), RMAP_INTERNAL);
        rmap_shard_writer_destroy(writer);
    }
    assert_int_equal(setenv("FIXTURE", "curved", 1), 0);
    fixture_fini(&f);
    fixture_init(&f);
    for (int e = 0; e < RMAP_ENCODING_COUNT; e++) { /* rays that met no gradient medium */
        write_portion(&f, (enum rmap_encoding)e, straight);
        assert_true(has_curve(&f, PIECE));
        fixture_must(read_portion(&f, RMAP_COLUMNS_ALL, straight, &err), &err);
    }
    rmap_portion_destroy(curved);
    rmap_portion_destroy(straight);
    fixture_fini(&f);
    assert_int_equal(rmap_alloc_live(), 0);
}

int main(void)
{
    if (setenv("FIXTURE", "curved", 1) != 0)
        return 1;
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_columns),
        cmocka_unit_test(test_points_of_no_segment),
        cmocka_unit_test(test_formats),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * An index that states something wrong, in good form: dataset, checksum and seal changed together,
 * as no accident does. What it says is told from what the pieces and the rays say.
 */
#include "map_fixture.h"

#include <fcntl.h>
#include <sys/stat.h>

#include "io/codec/codec.h"
#include "io/file/seal.h"
#include "io/map/map_cursor.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/recovery/verify.h"
#include "io/recovery/verify_piece.h"
#include "io/recovery/verify_rays.h"
#include "io/write/index_writer.h"

enum { BLOCK = 300, N_BLOCK = 20, FOOTER = 32, DATA_MAX = 1 << 16 };

static void write_map(struct fixture *f)
{
    struct rmap_error err = {0};
    fixture_init(f);
    fixture_must(rmap_map_create(f->map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(f, 0, 0, N_BLOCK / 2, BLOCK, 0, &err), &err);
    fixture_must(fixture_write_shard(f, 1, N_BLOCK / 2, N_BLOCK, BLOCK, 0, &err), &err);
    fixture_must(rmap_index_write(f->map, &f->run, f->tally, true, &err), &err);
}

/* All steps of a verification, one after the other. */
static void verify(const struct fixture *f, struct rmap_findings *findings)
{
    struct rmap_error err = {0};
    struct rmap_verification *what = NULL;
    struct rmap_chunk_verifier *chunks = NULL;
    struct rmap_cursor *cursor = NULL;
    struct rmap_tally *tally = NULL;
    bool whole = true;
    *findings = (struct rmap_findings){0};
    fixture_must(rmap_verification_open(f->map, &what, findings, &err), &err);
    for (size_t i = 0; i < what->claimed->n_piece; i++)
        fixture_must(rmap_verify_piece(what, i, findings, &err), &err);
    fixture_must(rmap_chunk_verifier_create(what, &chunks, &err), &err);
    for (size_t i = 0; i < what->content->n_chunk; i++)
        fixture_must(rmap_verify_chunk(chunks, i, findings, &err), &err);
    fixture_must(rmap_tally_create(f->scene, &tally, &err), &err);
    if (what->map)
        fixture_must(rmap_cursor_create(what->map, RMAP_COLUMNS_ALL, &cursor, &err), &err);
    for (size_t i = 0; what->map && i < what->content->n_portion; i++) {
        fixture_must(rmap_verify_portion(what, cursor, i, tally, findings, &err), &err);
        whole = whole && !(what->portion_flag[i] & RMAP_PORTION_LOST);
    }
    if (what->map)
        fixture_must(rmap_verify_sums(what, whole ? tally : NULL, findings, &err), &err);
    rmap_findings_sort(findings);
    rmap_tally_destroy(tally);
    rmap_cursor_destroy(cursor);
    rmap_chunk_verifier_destroy(chunks);
    rmap_verification_close(what);
}

static uint8_t *slurp(const char *path, size_t *nbytes)
{
    struct stat info;
    assert_int_equal(stat(path, &info), 0);
    *nbytes = (size_t)info.st_size;
    uint8_t *data = rmap_alloc(*nbytes, 1);
    int fd = open(path, O_RDONLY);
    assert_int_equal(read(fd, data, *nbytes), (ssize_t)*nbytes);
    (void)close(fd);
    return data;
}

static size_t find(const uint8_t *data, size_t nbytes, const void *what, size_t n)
{
    for (size_t i = 0; i + n <= nbytes; i++)
        if (memcmp(data + i, what, n) == 0)
            return i;
    fail_msg("the bytes are not in the file");
    return 0;
}

/* Writes `now` in place of a dataset's bytes `was` in map.h5, its checksum and the seal to fit. */
static void forge(const struct fixture *f, const void *was, const void *now, size_t nbytes)
{
    struct rmap_error err = {0};
    char path[160];
    size_t n_file;
    (void)snprintf(path, sizeof path, "%s/map.h5", f->map);
    uint8_t *data = slurp(path, &n_file);
    uint64_t before = rmap_checksum(was, nbytes), after = rmap_checksum(now, nbytes);
    memcpy(data + find(data, n_file, was, nbytes), now, nbytes);
    memcpy(data + find(data, n_file, &before, sizeof before), &after, sizeof after);
    int fd = open(path, O_WRONLY | O_TRUNC);
    assert_int_equal(write(fd, data, n_file - FOOTER), (ssize_t)(n_file - FOOTER));
    (void)close(fd);
    fixture_must(rmap_seal_write(path, NULL, 0, &err), &err);
    rmap_free(data);
}

/* A field of /portion of the index as it lies in the file: [n_portion][width]. */
static size_t portion_field(const struct fixture *f, size_t offset, size_t nbytes, uint8_t *out)
{
    struct rmap_map *map = NULL;
    struct rmap_error err = {0};
    fixture_must(rmap_map_open(f->map, &map, &err), &err);
    size_t n = rmap_map_n_portion(map);
    assert_true(n * nbytes <= DATA_MAX);
    for (size_t i = 0; i < n; i++)
        memcpy(out + i * nbytes, (const uint8_t *)rmap_map_portion(map, i) + offset, nbytes);
    rmap_map_close(map);
    return n;
}

static void expect(const struct fixture *f, const char *dataset, uint64_t first, uint64_t last)
{
    struct rmap_findings findings;
    bool found = false;
    verify(f, &findings);
    assert_true(findings.n > 0);
    for (size_t i = 0; i < findings.n; i++) {
        const struct rmap_finding *row = &findings.row[i];
        bool here = strcmp(row->file, "map.h5") == 0 && strcmp(row->dataset, dataset) == 0;
        if (strcmp(row->file, "map.h5") != 0)
            fail_msg("%s is blamed (%s: %s)", row->file, row->dataset, row->text);
        if (here && last > 0)
            assert_true(row->n_range == 1 && row->range[0][0] == first && row->range[0][1] == last);
        found = found || here;
    }
    if (!found)
        fail_msg("%s is not named; %s: %s is", dataset, findings.row[0].dataset,
                 findings.row[0].text);
    rmap_findings_fini(&findings);
}

static void test_whole(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_findings findings;
    write_map(&f);
    verify(&f, &findings);
    if (findings.n > 0)
        fail_msg("%s: %s: %s", findings.row[0].file, findings.row[0].dataset, findings.row[0].text);
    rmap_findings_fini(&findings);
    fixture_fini(&f);
}

/* One number of one row of /portion, +1. */
static void forge_portion(size_t offset, size_t nbytes, const char *dataset)
{
    static uint8_t was[DATA_MAX], now[DATA_MAX];
    const size_t row = 13;
    struct fixture f;
    write_map(&f);
    size_t n = portion_field(&f, offset, nbytes, was);
    memcpy(now, was, n * nbytes);
    now[row * nbytes]++;
    forge(&f, was, now, n * nbytes);
    expect(&f, dataset, row * BLOCK, row * BLOCK + BLOCK - 1);
    fixture_fini(&f);
}

static void test_count(void **state)
{
    (void)state;
    forge_portion(offsetof(struct rmap_portion_info, n_row),
                  (fixture_is_curved() ? 4 : 3) * sizeof(uint64_t), "/portion/n_row");
}

static void test_digest(void **state)
{
    (void)state;
    forge_portion(offsetof(struct rmap_portion_info, digest), sizeof(struct rmap_digest),
                  "/portion/digest");
}

static void test_summary(void **state)
{
    (void)state;
    forge_portion(offsetof(struct rmap_portion_info, summary.box_min), 3 * sizeof(float),
                  "/portion/box_min");
}

/* The energy balance is of the rays. */
static void test_tally(void **state)
{
    (void)state;
    struct fixture f;
    struct rmap_error err = {0};
    write_map(&f);
    f.tally->left[0] += 1.0;
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    expect(&f, "/tally/left", 0, 0);
    f.tally->left[0] -= 1.0;
    f.tally->image[3] += 1.0;
    fixture_must(rmap_index_write(f.map, &f.run, f.tally, true, &err), &err);
    char image[128];
    (void)snprintf(image, sizeof image, "/detector/%s/image", f.scene->detector[0].name);
    expect(&f, image, 0, 0);
    fixture_fini(&f);
}

/* Many ranges of rays stay ranges; the last one takes the rest. */
static void test_ranges(void **state)
{
    (void)state;
    struct rmap_finding finding;
    struct rmap_findings list = {0};
    struct rmap_error err = {0};
    rmap_finding_set(&finding, "map.h5", "/x", "a/map.h5: %s", "wrong");
    assert_string_equal(finding.text, "wrong");
    for (uint64_t i = 0; i < 2 * RMAP_FINDING_RANGES; i++)
        rmap_finding_add_rays(&finding, 10 * i, 5);
    rmap_finding_add_rays(&finding, 20 * RMAP_FINDING_RANGES - 5, 5);
    assert_int_equal(finding.n_range, RMAP_FINDING_RANGES);
    assert_int_equal(finding.n_ray, 5 * (2 * RMAP_FINDING_RANGES + 1));
    assert_int_equal(finding.range[0][1], 4);
    assert_int_equal(finding.range[RMAP_FINDING_RANGES - 1][1], 20 * RMAP_FINDING_RANGES - 1);
    for (int i = 0; i < 3; i++)
        fixture_must(rmap_findings_add(&list, &finding, &err), &err);
    rmap_finding_set(&finding, "shard-00000/piece-00000.h5", "", "first of all");
    fixture_must(rmap_findings_add(&list, &finding, &err), &err);
    rmap_findings_sort(&list);
    assert_int_equal(list.n, 2);
    assert_string_equal(list.row[0].file, "map.h5");
    rmap_findings_fini(&list);
}

int main(void)
{
    const struct CMUnitTest test[] = {
        cmocka_unit_test(test_whole),   cmocka_unit_test(test_count), cmocka_unit_test(test_digest),
        cmocka_unit_test(test_summary), cmocka_unit_test(test_tally), cmocka_unit_test(test_ranges),
    };
    return cmocka_run_group_tests(test, NULL, NULL);
}

/* SPDX-License-Identifier: MIT
 *
 * Scans of a map: counts against a ray-by-ray count of the same histories, whole rays collected
 * in order of their ids, portions skipped, ranges and threads that add up.
 */
#include "tests/format/map_fixture.h"

#include "analysis/query/query.h"
#include "base/workers.h"
#include "io/map/map_directory.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"

enum { BLOCK = 300, N_BLOCK = 40, N_RAY = BLOCK * N_BLOCK };

static struct fixture fixture;
static struct rmap_map *map;

static int make_map(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    fixture_init(&fixture);
    fixture_must(rmap_map_create(fixture.map, false, NULL, NULL, &err), &err);
    fixture_must(fixture_write_shard(&fixture, 0, 0, 25, BLOCK, 1 << 20, &err), &err);
    fixture_must(fixture_write_shard(&fixture, 1, 25, N_BLOCK, BLOCK, 1 << 20, &err), &err);
    fixture_must(rmap_index_write(fixture.map, &fixture.run, fixture.tally, true, &err), &err);
    fixture_must(rmap_map_open(fixture.map, &map, &err), &err);
    assert_int_equal(rmap_map_n_portion(map), N_BLOCK);
    return 0;
}

static int drop_map(void **state)
{
    (void)state;
    rmap_map_close(map);
    fixture_fini(&fixture);
    return (int)rmap_alloc_live();
}

static struct rmap_criterion *compile(const char *text)
{
    struct rmap_error err = {0};
    struct rmap_criterion *criterion = NULL;
    fixture_must(rmap_criterion_compile(text, rmap_map_scene(map), &criterion, &err), &err);
    return criterion;
}

/* One criterion over portions [first, last). */
static void scan(const char *text, size_t first, size_t last, struct rmap_count *count,
                 struct rmap_portion *collect, uint64_t limit)
{
    struct rmap_error err = {0};
    struct rmap_criterion *criterion = compile(text);
    fixture_must(rmap_count_init(count, 2, &err), &err);
    fixture_must(rmap_query_scan(map, &criterion, 1, first, last, count, collect, limit, &err),
                 &err);
    rmap_criterion_destroy(criterion);
}

/* How often a ray met the object with that event; -1 and 0: any. */
static int steps_of(const struct rmap_portion *p, size_t ray, size_t first, int object,
                    uint32_t events)
{
    int n = 0;
    for (size_t s = first; s < first + p->ray.segment_count[ray]; s++)
        n += (object < 0 || p->segment.object[s] == object) &&
             (!events || (p->segment.event[s] & events));
    return n;
}

static bool is_twice_barrel(const struct rmap_portion *p, size_t ray, size_t first)
{
    return steps_of(p, ray, first, 1, RMAP_EVENT_REFLECT_SPECULAR) >= 2;
}

static bool is_short_from_lamp(const struct rmap_portion *p, size_t ray, size_t first)
{
    (void)first;
    return p->ray.source[ray] == 1 && p->ray.segment_count[ray] <= 3;
}

static bool is_never_lens(const struct rmap_portion *p, size_t ray, size_t first)
{
    return steps_of(p, ray, first, 0, 0) == 0;
}

static const struct {
    const char *text;
    bool (*holds)(const struct rmap_portion *, size_t ray, size_t first_step);
} case_table[] = {
    {"hit(barrel, reflect_specular) >= 2", is_twice_barrel},
    {"source(lamp) and segments <= 3", is_short_from_lamp},
    {"not hit(lens)", is_never_lens},
};
enum { N_CASE = sizeof case_table / sizeof *case_table };

/* Counts, and the matching rays, made again from the histories. */
static struct rmap_portion *expect(int c, struct rmap_count *count)
{
    struct rmap_portion *rays = NULL;
    assert_int_equal(rmap_count_init(count, 2, NULL), RMAP_OK);
    assert_int_equal(rmap_portion_create(1, 3, &rays, NULL), RMAP_OK);
    for (uint64_t b = 0; b < N_BLOCK; b++) {
        struct rmap_portion *p = fixture_portion(&fixture, b * BLOCK, BLOCK, NULL);
        size_t step = 0, seen = 0;
        for (size_t i = 0; i < BLOCK; i++) {
            if (case_table[c].holds(p, i, step)) {
                assert_int_equal(rmap_portion_append_ray(rays, p, i, step, seen, NULL), RMAP_OK);
                count->rays++;
                count->segments += p->ray.segment_count[i];
                count->source_weight[p->ray.source[i]] += p->ray.weight[i];
                count->source_weight_squared[p->ray.source[i]] +=
                    p->ray.weight[i] * p->ray.weight[i];
            }
            step += p->ray.segment_count[i];
            seen += p->ray.registration_count[i];
        }
        rmap_portion_destroy(p);
    }
    return rays;
}

static void assert_same_count(const struct rmap_count *a, const struct rmap_count *b)
{
    assert_int_equal(a->rays, b->rays);
    assert_int_equal(a->segments, b->segments);
    for (int s = 0; s < 2; s++) {
        assert_true(a->source_weight[s] == b->source_weight[s]);
        assert_true(a->source_weight_squared[s] == b->source_weight_squared[s]);
    }
}

static void test_counts(void **state)
{
    (void)state;
    struct rmap_map_summary summary;
    rmap_map_summarise(map, &summary);
    for (int c = 0; c < N_CASE; c++) {
        struct rmap_count count, want;
        rmap_portion_destroy(expect(c, &want));
        scan(case_table[c].text, 0, N_BLOCK, &count, NULL, 0);
        assert_same_count(&count, &want);
        assert_in_range(want.rays, N_RAY / 100, N_RAY / 2);
        assert_int_equal(count.portions_read, N_BLOCK);
        assert_in_range(count.nbytes_read, 1, summary.nbytes / 4);
        rmap_count_fini(&count);
        rmap_count_fini(&want);
    }
}

static void test_collect_all(void **state)
{
    (void)state;
    for (int c = 0; c < N_CASE; c++) {
        struct rmap_count count, want;
        struct rmap_portion *rays = NULL, *expected = expect(c, &want);
        assert_int_equal(rmap_portion_create(1, 3, &rays, NULL), RMAP_OK);
        scan(case_table[c].text, 0, N_BLOCK, &count, rays, UINT64_MAX);
        assert_same_count(&count, &want);
        fixture_compare(rays, expected);
        for (size_t i = 1; i < rays->n_row[RMAP_TABLE_RAY]; i++)
            assert_true(rays->ray.id[i - 1] < rays->ray.id[i]);
        rmap_portion_destroy(rays);
        rmap_portion_destroy(expected);
        rmap_count_fini(&count);
        rmap_count_fini(&want);
    }
}

static void test_collect_limit(void **state)
{
    (void)state;
    struct rmap_count want;
    struct rmap_portion *expected = expect(0, &want);
    static const uint64_t limit[] = {0, 1, 7, 100};
    for (size_t k = 0; k < 4; k++) {
        struct rmap_count count;
        struct rmap_portion *rays = NULL;
        assert_int_equal(rmap_portion_create(1, 3, &rays, NULL), RMAP_OK);
        scan(case_table[0].text, 0, N_BLOCK, &count, rays, limit[k]);
        assert_int_equal(rays->n_row[RMAP_TABLE_RAY], limit[k]);
        for (size_t i = 0; i < limit[k]; i++)
            assert_int_equal(rays->ray.id[i], expected->ray.id[i]);
        /* Reading stopped with the portion of the last ray. */
        uint64_t last = limit[k] ? expected->ray.id[limit[k] - 1] / BLOCK + 1 : 0;
        assert_int_equal(count.portions_read, last);
        rmap_portion_destroy(rays);
        rmap_count_fini(&count);
    }
    rmap_portion_destroy(expected);
    rmap_count_fini(&want);
}

static void test_skips(void **state)
{
    (void)state;
    static const struct {
        const char *text;
        uint64_t portions, rays;
    } row[] = {
        {"event(limit)", 0, 0}, {"ended(absorbed)", 0, 0}, {"ended(left)", N_BLOCK, N_RAY},
        {"ray in 0..9", 1, 10}, {"ray <= 300", 2, 301},    {"all", N_BLOCK, N_RAY},
    };
    for (size_t i = 0; i < sizeof row / sizeof *row; i++) {
        struct rmap_count count;
        scan(row[i].text, 0, N_BLOCK, &count, NULL, 0);
        assert_int_equal(count.portions_read, row[i].portions);
        assert_int_equal(count.rays, row[i].rays);
        assert_true((count.nbytes_read > 0) == (row[i].portions > 0));
        rmap_count_fini(&count);
    }
}

/* Several criteria in one scan give what each gives alone; only the first is collected. */
static void test_several(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    struct rmap_criterion *criterion[N_CASE];
    struct rmap_count count[N_CASE];
    struct rmap_portion *rays = NULL;
    assert_int_equal(rmap_portion_create(1, 3, &rays, NULL), RMAP_OK);
    for (int c = 0; c < N_CASE; c++) {
        criterion[c] = compile(case_table[c].text);
        fixture_must(rmap_count_init(&count[c], 2, &err), &err);
    }
    fixture_must(rmap_query_scan(map, criterion, N_CASE, 0, N_BLOCK, count, rays, 5, &err), &err);
    assert_int_equal(rays->n_row[RMAP_TABLE_RAY], 5);
    for (int c = 0; c < N_CASE; c++) {
        struct rmap_count want;
        rmap_portion_destroy(expect(c, &want));
        if (c > 0)
            assert_same_count(&count[c], &want);
        rmap_count_fini(&want);
        rmap_count_fini(&count[c]);
        rmap_criterion_destroy(criterion[c]);
    }
    rmap_portion_destroy(rays);
}

/* Threads with ranges of their own, as ranks and threads share the work. */
enum { N_THREAD = 3 };
struct share {
    struct rmap_criterion *criterion;
    struct rmap_count count[N_THREAD];
    struct rmap_portion *rays[N_THREAD];
    enum rmap_status status[N_THREAD];
};

static void scan_share(void *context, int thread)
{
    struct share *share = context;
    size_t first = (size_t)thread * N_BLOCK / N_THREAD;
    size_t last = (size_t)(thread + 1) * N_BLOCK / N_THREAD;
    share->status[thread] =
        rmap_query_scan(map, &share->criterion, 1, first, last, &share->count[thread],
                        share->rays[thread], UINT64_MAX, NULL);
}

static void test_threads(void **state)
{
    (void)state;
    struct rmap_workers *workers = NULL;
    struct share share = {.criterion = compile(case_table[0].text)};
    struct rmap_count want, sum;
    struct rmap_portion *expected = expect(0, &want);
    assert_int_equal(rmap_count_init(&sum, 2, NULL), RMAP_OK);
    for (int i = 0; i < N_THREAD; i++) {
        assert_int_equal(rmap_count_init(&share.count[i], 2, NULL), RMAP_OK);
        assert_int_equal(rmap_portion_create(1, 3, &share.rays[i], NULL), RMAP_OK);
    }
    assert_int_equal(rmap_workers_start(N_THREAD, scan_share, &share, &workers, NULL), RMAP_OK);
    rmap_workers_join(workers);
    size_t row = 0;
    for (int i = 0; i < N_THREAD; i++) {
        assert_int_equal(share.status[i], RMAP_OK);
        rmap_count_add(&sum, &share.count[i], 2);
        for (size_t k = 0; k < share.rays[i]->n_row[RMAP_TABLE_RAY]; k++)
            assert_int_equal(share.rays[i]->ray.id[k], expected->ray.id[row++]);
        rmap_count_fini(&share.count[i]);
        rmap_portion_destroy(share.rays[i]);
    }
    assert_int_equal(row, expected->n_row[RMAP_TABLE_RAY]);
    assert_same_count(&sum, &want);
    rmap_portion_destroy(expected);
    rmap_count_fini(&want);
    rmap_count_fini(&sum);
    rmap_criterion_destroy(share.criterion);
}

/* Flux of everything is that of the sources, without error; half of a source's rays carry half. */
static void test_flux(void **state)
{
    (void)state;
    struct rmap_count count;
    double flux, error;
    scan("all", 0, N_BLOCK, &count, NULL, 0);
    rmap_count_flux(&count, map, &flux, &error);
    assert_true(fabs(flux - 5.0) < 1e-12);
    assert_true(error < 1e-7);
    rmap_count_fini(&count);
    scan("source(lamp) and ray < 6000", 0, N_BLOCK, &count, NULL, 0);
    rmap_count_flux(&count, map, &flux, &error);
    assert_true(fabs(flux - 1.5) < 1e-12);
    /* Binomial: Phi sqrt(p (1 - p) / (N - 1)) with p = 1/2, N = 6000, Phi = 3. */
    assert_true(fabs(error - 3.0 * sqrt(0.25 / 5999.0)) < 1e-12);
    rmap_count_fini(&count);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_counts),        cmocka_unit_test(test_collect_all),
        cmocka_unit_test(test_collect_limit), cmocka_unit_test(test_skips),
        cmocka_unit_test(test_several),       cmocka_unit_test(test_threads),
        cmocka_unit_test(test_flux),
    };
    return cmocka_run_group_tests(tests, make_map, drop_map);
}

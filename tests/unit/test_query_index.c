/* SPDX-License-Identifier: MIT
 *
 * Questions put to a map with a history index are answered as those put to the same map without:
 * counts, sums of weights and marks, for criteria made by dice, one by one and many at once. The
 * map has portions that the index keeps as paths, others that it keeps as rows, weights that are
 * not 1, and a piece without an index.
 */
#include "tests/format/map_fixture.h"

#include "analysis/query/query.h"
#include "analysis/query/query_mark.h"
#include "analysis/query/query_marker.h"
#include "history/history_index.h"
#include "history/history_view.h"
#include "io/map/map_directory.h"
#include "io/map/map_history.h"
#include "io/map/map_reader.h"
#include "io/write/index_writer.h"

enum { BLOCK = 500, N_BLOCK = 16, N_RANDOM = 200, TEXT = 2000, N_TOGETHER = 20 };

static struct fixture fixture;
static struct rmap_map *plain, *indexed;

/* Rays of this block did one of a few things: a path each; but where they did it differs. */
static bool is_repeated(uint64_t block)
{
    return block / 2 % 2 == 0;
}

static struct rmap_portion *repeat(uint64_t block, uint64_t rays)
{
    struct rmap_portion *from = fixture_portion(&fixture, block * rays, rays, fixture.tally);
    struct rmap_portion *to = NULL;
    size_t segment[8], registration[8], at = 0, seen = 0;
    assert_int_equal(rmap_portion_create(rays, 3, &to, NULL), RMAP_OK);
    for (size_t i = 0; i < 8;
         at += from->ray.segment_count[i], seen += from->ray.registration_count[i], i++) {
        segment[i] = at;
        registration[i] = seen;
    }
    for (size_t i = 0; i < rays; i++) {
        size_t k = fixture_hash(i, block) % 8, row = to->n_row[RMAP_TABLE_REGISTRATION];
        assert_int_equal(rmap_portion_append_ray(to, from, k, segment[k], registration[k], NULL),
                         RMAP_OK);
        to->ray.id[i] = block * rays + i;
        to->ray.path_length[i] = fixture_unit(i, block);
        to->ray.wavelength[i] = 400 + (double)(i % 7);
        for (; row < to->n_row[RMAP_TABLE_REGISTRATION]; row++)
            to->registration.relative[2 * row] = (uint16_t)fixture_hash(row, 7);
    }
    to->first_ray = block * rays;
    rmap_portion_destroy(from);
    return to;
}

static struct rmap_portion *make_block(struct fixture *f, uint64_t block, uint64_t rays)
{
    struct rmap_portion *portion =
        is_repeated(block) ? repeat(block, rays) : fixture_portion(f, block * rays, rays, f->tally);
    for (uint64_t i = 0; (block % 8 == 5 || block % 8 == 3) && i < rays; i++)
        portion->ray.weight[i] = (double)(i % 4);
    return portion;
}

static int make_map(void **state)
{
    (void)state;
    struct rmap_error err = {0};
    fixture_init(&fixture);
    fixture_must(rmap_map_create(fixture.map, false, NULL, NULL, &err), &err);
    for (int shard = 0; shard < 2; shard++)
        fixture_must(fixture_write_blocks(&fixture, shard, (uint64_t)shard * N_BLOCK / 2,
                                          (uint64_t)(shard + 1) * N_BLOCK / 2, 1 << 20, make_block,
                                          BLOCK, &err),
                     &err);
    fixture_must(rmap_index_write(fixture.map, &fixture.run, fixture.tally, true, &err), &err);
    fixture_must(rmap_map_open(fixture.map, &plain, &err), &err);
    fixture_must(rmap_map_open(fixture.map, &indexed, &err), &err);
    assert_true(rmap_map_n_piece(indexed) > 3);
    for (size_t p = 0; p + 1 < rmap_map_n_piece(indexed); p++) {
        struct rmap_history_bytes bytes = {0};
        fixture_must(rmap_map_history_make(indexed, p, SIZE_MAX, NULL, NULL, &bytes, &err), &err);
        fixture_must(rmap_map_history_keep(indexed, p, &bytes, &err), &err);
    }
    return 0;
}

static int drop_map(void **state)
{
    (void)state;
    rmap_map_close(plain);
    rmap_map_close(indexed);
    fixture_fini(&fixture);
    return (int)rmap_alloc_live();
}

/* Portions that the index keeps in this form. */
static size_t count_form(enum rmap_history_form form)
{
    size_t n = 0;
    struct rmap_history_view view = {0};
    for (size_t p = 0; p < rmap_map_n_portion(indexed); p++) {
        const struct rmap_portion_info *info = rmap_map_portion(indexed, p);
        const struct rmap_history_index *index = NULL;
        assert_int_equal(rmap_map_history(indexed, (size_t)info->piece, &index, NULL), RMAP_OK);
        if (!index)
            continue;
        size_t at = rmap_history_find(index, info->first_ray, info->n_row, info->digest);
        assert_true(at != SIZE_MAX);
        assert_int_equal(rmap_history_view_open(index, at, &view, NULL), RMAP_OK);
        n += view.form == form;
        rmap_map_history_release(indexed, (size_t)info->piece);
    }
    rmap_history_view_fini(&view);
    return n;
}

static void test_forms(void **state)
{
    (void)state;
    assert_in_range(count_form(RMAP_HISTORY_PATHS), 3, N_BLOCK);
    assert_in_range(count_form(RMAP_HISTORY_ROWS), 3, N_BLOCK);
}

static const char *const test_table[] = {
    "all",
    "source(beam)",
    "source(lamp) == 0",
    "hit(lens)",
    "hit(barrel) >= 2",
    "hit(housing, reflect_specular) in 1..3",
    "hit(*) != 4",
    "hit(film_holder, transmit) < 2",
    "hit(lens, face 0)",
    "hit(barrel, triangle 0)",
    "surface(black) > 5",
    "event(reflect)",
    "event(reflect) == 0",
    "medium(glass) >= 3",
    "registered(film)",
    "registered(film) >= 2",
    "crossed(film) == 1",
    "registered(film, rect(-2, -2, 2, 3))",
    "registered(film, rect(-4, -3, 0, 3)) == 0",
    "crossed(film, ellipse(0, 0, 3, 2)) >= 2",
    "registered(film, cells(0..7, 2..5))",
    "registered(film where x > 0 and angle < 10 deg)",
    "registered(film where ghost_order >= 1)",
    "registered(film where hit(*) >= 2 and not after(film_holder))",
    "registered(film where bounces == 1 and x > 0)",
    "registered(film where path(\".* R@lens .* V\"))",
    "registered(film where path(\".* T V@film\") and y < 0) >= 2",
    "ghost_order == 1 or scatter_order >= 1",
    "angle(film) > 100 deg",
    "y(film) in -1..2",
    "ended(left)",
    "ended(absorbed)",
    "ended(left, air)",
    "ended(left, glass) == 0",
    "segments > 7",
    "bounces in 3..9",
    "ray in 700..6100",
    "flux > 0.0004",
    "wavelength > 500 nm",
    "path_length < 0.4",
    "optical_path != 2",
    "path(\".* R@lens .* V@film .*\")",
    "path(\"(T|R)* X\")",
    "path(\"[TR]@barrel .* [TR]@lens .*\") == 0",
};
enum { N_TEST = sizeof test_table / sizeof *test_table };

struct dice {
    uint64_t seed, draw;
};

static size_t roll(struct dice *dice, size_t n)
{
    return fixture_hash(dice->seed, dice->draw++) % n;
}

static void append(char *text, const char *more)
{
    assert_true(strlen(text) + strlen(more) < TEXT);
    strcat(text, more);
}

static void make_text(struct dice *dice, int depth, char *text)
{
    if (depth == 0 || roll(dice, 5) == 0) {
        append(text, test_table[roll(dice, N_TEST)]);
        return;
    }
    const char *word = roll(dice, 2) ? " and " : " or ";
    append(text, roll(dice, 4) ? "(" : "not (");
    for (size_t n = 2 + roll(dice, 2); n > 0; n--) {
        make_text(dice, depth - 1, text);
        if (n > 1)
            append(text, word);
    }
    append(text, ")");
}

static struct rmap_criterion *compile(const char *text)
{
    struct rmap_error err = {0};
    struct rmap_criterion *criterion = NULL;
    if (rmap_criterion_compile(text, rmap_map_scene(plain), &criterion, &err) != RMAP_OK)
        fail_msg("%s", err.text);
    return criterion;
}

static void scan(const struct rmap_map *map, struct rmap_criterion **criterion, size_t n,
                 struct rmap_count *count)
{
    struct rmap_error err = {0};
    for (size_t c = 0; c < n; c++)
        fixture_must(rmap_count_init(&count[c], 2, &err), &err);
    fixture_must(rmap_query_scan(map, criterion, n, 0, N_BLOCK, count, NULL, 0, &err), &err);
}

static void assert_same(const char *text, const struct rmap_count *a, const struct rmap_count *b)
{
    bool same = a->rays == b->rays && a->segments == b->segments;
    for (int s = 0; s < 2; s++)
        same = same && a->source_weight[s] == b->source_weight[s] &&
               a->source_weight_squared[s] == b->source_weight_squared[s];
    if (!same)
        fail_msg("%s\nwith the index %llu rays, without %llu", text, (unsigned long long)a->rays,
                 (unsigned long long)b->rays);
}

/* Each ray, by both. */
static void compare_marks(struct rmap_criterion *criterion)
{
    struct rmap_query_marker *marker[2] = {NULL};
    uint8_t *match[2];
    size_t n[2];
    const struct rmap_map *map[] = {plain, indexed};
    for (int m = 0; m < 2; m++)
        assert_int_equal(rmap_query_marker_create(map[m], criterion, 0, &marker[m], NULL), RMAP_OK);
    for (size_t p = 0; p < N_BLOCK; p++) {
        for (int m = 0; m < 2; m++) {
            assert_int_equal(rmap_query_marker_enter(marker[m], p, &n[m], NULL), RMAP_OK);
            assert_int_equal(rmap_query_marker_mark(marker[m], &match[m], &n[m], NULL), RMAP_OK);
        }
        if (n[0] != n[1] || !match[0] != !match[1] ||
            (match[0] && memcmp(match[0], match[1], BLOCK) != 0))
            fail_msg("%s\ndiffers in portion %zu", rmap_criterion_text(criterion), p);
    }
    for (int m = 0; m < 2; m++)
        rmap_query_marker_destroy(marker[m]);
}

/* One test alone, then joined by dice. Several at once must give what each gives alone. */
static void test_same(void **state)
{
    (void)state;
    struct rmap_criterion *criterion[N_TOGETHER];
    struct rmap_count count[N_TOGETHER], together[N_TOGETHER], without[N_TOGETHER];
    size_t n_some = 0;
    for (size_t i = 0; i < N_TEST + N_RANDOM; i += N_TOGETHER) {
        for (size_t c = 0; c < N_TOGETHER; c++) {
            struct dice dice = {i + c, 0};
            char text[TEXT] = "";
            if (i + c < N_TEST)
                append(text, test_table[i + c]);
            else
                make_text(&dice, 1 + (int)(c % 3), text);
            criterion[c] = compile(text);
            scan(indexed, &criterion[c], 1, &count[c]);
            compare_marks(criterion[c]);
        }
        scan(indexed, criterion, N_TOGETHER, together);
        scan(plain, criterion, N_TOGETHER, without);
        for (size_t c = 0; c < N_TOGETHER; c++) {
            const char *text = rmap_criterion_text(criterion[c]);
            assert_same(text, &count[c], &without[c]);
            assert_same(text, &together[c], &without[c]);
            n_some += without[c].rays > 0 && without[c].rays < BLOCK * N_BLOCK;
            rmap_count_fini(&count[c]);
            rmap_count_fini(&together[c]);
            rmap_count_fini(&without[c]);
            rmap_criterion_destroy(criterion[c]);
        }
    }
    assert_true(n_some > N_RANDOM / 2); /* they are not all trivial */
}

/* Steps one after the other with anything between them, from the start or not, with a registration
 * behind them, before them or none; some with a neighbour in place of a gap. */
static void make_chain(struct dice *dice, char *text)
{
    static const char *const step[] = {"T",         "R",      ".",          "[TR]@lens",
                                       "T@barrel",  "R@lens", "[^A]",       "D@'*'",
                                       "T@housing", "X",      "[TRD]@lens", "A"};
    size_t n = 1 + roll(dice, 4);
    append(text, roll(dice, 3) ? "path(\"" : "path(\".* ");
    if (roll(dice, 8) == 0)
        append(text, "V@film .* ");
    for (size_t k = 0; k < n; k++) {
        append(text, step[roll(dice, roll(dice, 3) ? 4 : sizeof step / sizeof *step)]);
        append(text, k + 1 < n && roll(dice, 9) == 0 ? " " : " .* ");
    }
    append(text, roll(dice, 2) ? "V@film .*\")" : "\")");
}

static void test_chains(void **state)
{
    (void)state;
    size_t n_some = 0;
    for (size_t i = 0; i < 300; i++) {
        struct dice dice = {1000 + i, 0};
        struct rmap_count with[1], without[1];
        char text[TEXT] = "";
        make_chain(&dice, text);
        struct rmap_criterion *criterion = compile(text);
        scan(indexed, &criterion, 1, with);
        scan(plain, &criterion, 1, without);
        assert_same(text, with, without);
        compare_marks(criterion);
        n_some += without->rays > 0 && without->rays < BLOCK * N_BLOCK;
        rmap_count_fini(with);
        rmap_count_fini(without);
        rmap_criterion_destroy(criterion);
    }
    assert_true(n_some > 100);
}

/* What map.h5 says of rows is no reason to ask for memory. */
static void test_rows_that_no_chunk_vouches_for(void **state)
{
    (void)state;
    const uint64_t many = UINT64_C(1) << 50, id = 1;
    struct rmap_criterion *criterion = compile("path_length > 0");
    const struct rmap_pick pick[] = {{.criterion = criterion}, {.id = &id, .n_id = 1}, {0}};
    for (size_t k = 0; k < 3; k++) {
        struct rmap_map *map;
        struct rmap_picker *picker;
        struct rmap_error err = {0};
        const uint8_t *match;
        const uint64_t *ids;
        size_t n;
        fixture_must(rmap_map_open(fixture.map, &map, &err), &err);
        /* The map that is read stands in memory that can be written. */
        struct rmap_portion_info *info = (void *)(uintptr_t)rmap_map_portion(map, 0);
        struct rmap_piece_info *piece = (void *)(uintptr_t)rmap_map_piece(map, 0);
        info->n_row[RMAP_TABLE_RAY] = info->stored_rows[RMAP_TABLE_RAY] = many;
        piece->n_row[RMAP_TABLE_RAY] = piece->stored_rows[RMAP_TABLE_RAY] = many;
        fixture_must(rmap_picker_create(map, &pick[k], &picker, &err), &err);
        assert_int_equal(rmap_picker_mark(picker, 0, &match, &n, &err), RMAP_FORMAT);
        assert_int_equal(rmap_picker_ids(picker, 0, &ids, &err), RMAP_FORMAT);
        rmap_picker_destroy(picker);
        rmap_map_close(map);
    }
    rmap_criterion_destroy(criterion);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_forms),
        cmocka_unit_test(test_same),
        cmocka_unit_test(test_chains),
        cmocka_unit_test(test_rows_that_no_chunk_vouches_for),
    };
    return cmocka_run_group_tests(tests, make_map, drop_map);
}

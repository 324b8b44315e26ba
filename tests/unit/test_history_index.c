/* SPDX-License-Identifier: MIT
 *
 * The history index: what it gives back is what it was given, in both forms, and its counts are
 * those of the rows; damaged bytes and short memory are told.
 */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <string.h>

#include <cmocka.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "history/history_builder.h"
#include "history/history_gather.h"
#include "history/history_index.h"
#include "history/history_view.h"

enum { N_OBJECT = 400, N_MEDIUM = 3, N_DETECTOR = 5, N_SOURCE = 3 };
static const struct rmap_history_limits limits = {N_SOURCE, N_OBJECT, N_MEDIUM, N_DETECTOR};

static uint32_t draw(uint64_t *state, uint32_t n)
{
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (uint32_t)((*state >> 33) % n);
}

/* What makes portions of different kinds. */
struct recipe {
    size_t n_ray;
    uint32_t n_path;        /* rays repeat one of so many histories; 0: each has its own */
    uint32_t n_object;      /* met */
    uint32_t segments_max;  /* per ray */
    uint32_t registrations; /* at most, per ray */
    uint32_t kinds;         /* of (source, stop) */
    uint32_t longest;       /* segments of one ray; 0: as the others */
    bool empty_rays, weighted;
};

static void add_ray(struct rmap_portion *p, const struct recipe *recipe, size_t i, uint64_t seed)
{
    uint64_t state = seed;
    uint32_t n = 1 + draw(&state, recipe->segments_max),
             m = draw(&state, recipe->registrations + 1);
    if (recipe->longest > 0 && i == 5)
        n = recipe->longest;
    if (recipe->empty_rays && draw(&state, 7) == 0)
        n = m = 0;
    struct rmap_error err = {0};
    assert_int_equal(rmap_portion_reserve(p, RMAP_TABLE_SEGMENT, n, RMAP_COLUMNS_ALL, &err), 0);
    assert_int_equal(rmap_portion_reserve(p, RMAP_TABLE_REGISTRATION, m, RMAP_COLUMNS_ALL, &err),
                     0);
    uint32_t kind = draw(&state, recipe->kinds);
    p->ray.id[i] = p->first_ray + i;
    p->ray.source[i] = (int32_t)(kind % N_SOURCE);
    p->ray.stop[i] = (uint8_t)(kind / N_SOURCE % 4);
    p->ray.weight[i] = recipe->weighted ? 0.25 : 1.0;
    p->ray.segment_count[i] = n;
    p->ray.registration_count[i] = m;
    for (uint32_t k = 0; k < n; k++) {
        size_t row = p->n_row[RMAP_TABLE_SEGMENT]++;
        uint32_t a = draw(&state, recipe->n_object), b = draw(&state, recipe->n_object);
        p->segment.object[row] = (int32_t)(a * b / recipe->n_object) - 1; /* some are rare */
        p->segment.event[row] = UINT32_C(1) << draw(&state, 3);
        p->segment.medium[row] = (int16_t)((int)draw(&state, N_MEDIUM + 1) - 1);
    }
    for (uint32_t k = 0; k < m; k++) {
        size_t row = p->n_row[RMAP_TABLE_REGISTRATION]++;
        p->registration.segment[row] = draw(&state, n);
        p->registration.detector[row] = (int32_t)draw(&state, N_DETECTOR);
        p->registration.registered[row] = (uint8_t)draw(&state, 2);
        p->registration.relative[2 * row] = (uint16_t)draw(&state, 65536);
        p->registration.relative[2 * row + 1] = (uint16_t)i;
    }
}

static struct rmap_portion *make_portion(const struct recipe *recipe, uint64_t first_ray)
{
    struct rmap_portion *p = NULL;
    struct rmap_error err = {0};
    assert_int_equal(rmap_portion_create(recipe->n_ray, 1, &p, &err), RMAP_OK);
    p->first_ray = first_ray;
    p->n_row[RMAP_TABLE_RAY] = recipe->n_ray;
    for (size_t i = 0; i < recipe->n_ray; i++) {
        uint64_t seed = first_ray + i + 1000;
        uint64_t choice = first_ray * 31 + i;
        add_ray(p, recipe, i, recipe->n_path > 0 ? 1 + draw(&choice, recipe->n_path) : seed);
    }
    return p;
}

static const struct recipe recipes[] = {
    {.n_ray = 4096,
     .n_path = 200,
     .n_object = 30,
     .segments_max = 15,
     .registrations = 1,
     .kinds = 4},
    {.n_ray = 4096, .n_object = 120, .segments_max = 18, .registrations = 2, .kinds = 1},
    {.n_ray = 700,
     .n_object = 400,
     .segments_max = 40,
     .registrations = 5,
     .kinds = 12,
     .weighted = true},
    {.n_ray = 300,
     .n_object = 9,
     .segments_max = 9,
     .registrations = 3,
     .kinds = 2,
     .longest = 70000},
    {.n_ray = 1000,
     .n_object = 20,
     .segments_max = 6,
     .registrations = 300,
     .kinds = 3,
     .empty_rays = true},
    {.n_ray = 1, .n_object = 3, .segments_max = 2, .registrations = 1, .kinds = 1},
    {.n_ray = 4096,
     .n_path = 150,
     .n_object = 30,
     .segments_max = 15,
     .registrations = 9,
     .kinds = 4,
     .empty_rays = true},
};
enum { N_PORTION = sizeof recipes / sizeof *recipes };

struct rig {
    struct rmap_portion *portion[N_PORTION];
    struct rmap_history_bytes bytes;
    struct rmap_history_index *index;
};

static struct rmap_digest digest_of(size_t i)
{
    return (struct rmap_digest){i * 77 + 1, i + 5};
}

static enum rmap_status build(struct rig *rig, struct rmap_error *err)
{
    struct rmap_history_builder *builder = NULL;
    enum rmap_status st = rmap_history_builder_create(&builder, err);
    for (size_t i = 0; i < N_PORTION && st == RMAP_OK; i++)
        st = rmap_history_builder_add(builder, rig->portion[i], digest_of(i), err);
    if (st == RMAP_OK)
        st = rmap_history_builder_finish(builder, &rig->bytes, err);
    rmap_history_builder_destroy(builder);
    return st;
}

static enum rmap_status read_body(void *context, uint64_t offset, size_t nbytes, void *to,
                                  struct rmap_error *err)
{
    (void)err;
    memcpy(to, (const uint8_t *)context + offset, nbytes);
    return RMAP_OK;
}

static enum rmap_status open_index(struct rig *rig, bool in_memory, struct rmap_error *err)
{
    struct rmap_history_body body = {.nbytes = rig->bytes.body_nbytes};
    if (in_memory) {
        body.bytes = rig->bytes.body;
    } else {
        body.context = rig->bytes.body;
        body.read = read_body;
    }
    return rmap_history_open(rig->bytes.head, rig->bytes.head_nbytes, &body, &limits, &rig->index,
                             err);
}

static void free_bytes(struct rmap_history_bytes *bytes)
{
    rmap_free(bytes->head);
    rmap_free(bytes->body);
    *bytes = (struct rmap_history_bytes){0};
}

static int setup(void **state)
{
    static struct rig rig;
    struct rmap_error err = {0};
    rig = (struct rig){0};
    for (size_t i = 0; i < N_PORTION; i++)
        rig.portion[i] = make_portion(&recipes[i], 5000 * i);
    assert_int_equal(build(&rig, &err), RMAP_OK);
    *state = &rig;
    return 0;
}

static int teardown(void **state)
{
    struct rig *rig = *state;
    for (size_t i = 0; i < N_PORTION; i++)
        rmap_portion_destroy(rig->portion[i]);
    free_bytes(&rig->bytes);
    assert_int_equal(rmap_alloc_live(), 0);
    return 0;
}

static void find(const struct rig *rig, size_t i, size_t *found)
{
    uint64_t n_row[RMAP_TABLE_COUNT];
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        n_row[t] = rig->portion[i]->n_row[t];
    *found = rmap_history_find(rig->index, rig->portion[i]->first_ray, n_row, digest_of(i));
    assert_int_equal(*found, i);
    n_row[1]++;
    assert_true(rmap_history_find(rig->index, rig->portion[i]->first_ray, n_row, digest_of(i)) ==
                SIZE_MAX);
    n_row[1]--;
    assert_true(rmap_history_find(rig->index, rig->portion[i]->first_ray, n_row,
                                  digest_of(i + 1)) == SIZE_MAX);
    assert_true(rmap_history_find(rig->index, rig->portion[i]->first_ray + 1, n_row,
                                  digest_of(i)) == SIZE_MAX);
}

static void same_columns(const struct rmap_portion *a, const struct rmap_portion *b)
{
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        enum rmap_column column = (enum rmap_column)c;
        enum rmap_table table = rmap_column_info(column)->table;
        assert_int_equal(a->n_row[table], b->n_row[table]);
        if (RMAP_COLUMNS_DISCRETE & RMAP_COLUMN_BIT(c) && a->n_row[table] > 0)
            assert_memory_equal(rmap_portion_column(a, column), rmap_portion_column(b, column),
                                a->n_row[table] * rmap_portion_row_nbytes(a, column));
    }
}

static void test_gives_back_what_it_was_given(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    struct rmap_history_view view = {0};
    const enum rmap_history_form form[N_PORTION] = {
        RMAP_HISTORY_PATHS, RMAP_HISTORY_ROWS, RMAP_HISTORY_ROWS, RMAP_HISTORY_ROWS,
        RMAP_HISTORY_ROWS,  RMAP_HISTORY_ROWS, RMAP_HISTORY_PATHS};
    for (int in_memory = 0; in_memory < 2; in_memory++) {
        struct rmap_portion out = {0};
        assert_int_equal(open_index(rig, in_memory == 1, &err), RMAP_OK);
        assert_int_equal(rmap_history_n_portion(rig->index), N_PORTION);
        for (size_t i = 0; i < N_PORTION; i++) {
            size_t at;
            const struct rmap_portion *p = rig->portion[i];
            find(rig, i, &at);
            assert_int_equal(rmap_history_view_open(rig->index, at, &view, &err), RMAP_OK);
            assert_int_equal(view.form, form[i]);
            assert_int_equal(view.unit_weight, !recipes[i].weighted);
            assert_int_equal(rmap_history_unfold(&view, RMAP_COLUMNS_ALL, &out, &err), RMAP_OK);
            assert_int_equal(out.first_ray, p->first_ray);
            same_columns(p, &out);
            assert_null(out.ray.weight);
            if (view.relative)
                assert_memory_equal(view.relative, p->registration.relative,
                                    4 * p->n_row[RMAP_TABLE_REGISTRATION]);
        }
        for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
            rmap_free(rmap_portion_column(&out, (enum rmap_column)c));
        rmap_history_destroy(rig->index);
    }
    rmap_history_view_fini(&view);
}

static void test_dictionary_holds_the_paths(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    struct rmap_history_view view = {0};
    assert_int_equal(open_index(rig, true, &err), RMAP_OK);
    const struct rmap_portion *paths = rmap_history_paths(rig->index), *p = rig->portion[0];
    assert_int_equal(rmap_history_view_open(rig->index, 0, &view, &err), RMAP_OK);
    assert_true(view.n_path <= 200 && view.n_path > 100);
    assert_true(paths->n_row[RMAP_TABLE_RAY] <= 350);
    size_t *rays = rmap_alloc(view.n_path, sizeof *rays);
    assert_non_null(rays);
    for (size_t i = 0; i < 4096; i++) {
        size_t k = view.path_row[view.path[i]];
        rays[view.path[i]]++;
        assert_int_equal(paths->ray.source[k], p->ray.source[i]);
        assert_int_equal(paths->ray.segment_count[k], p->ray.segment_count[i]);
    }
    for (size_t k = 0; k < view.n_path; k++)
        assert_int_equal(rays[k], view.path_rays[k]);
    rmap_free(rays);
    rmap_history_view_fini(&view);
    rmap_history_destroy(rig->index);
}

/* Rows of a ray that are wanted, counted one by one. */
static void check_counts(const struct rmap_history_view *view, const struct rmap_portion *p,
                         const uint8_t *wanted, const uint32_t *count)
{
    const struct rmap_step_class *what = rmap_history_classes(view->index);
    size_t n_class = rmap_history_n_class(view->index), row = 0;
    for (size_t i = 0; i < p->n_row[RMAP_TABLE_RAY]; i++) {
        uint32_t n = 0;
        for (uint32_t s = 0; s < p->ray.segment_count[i]; s++, row++)
            for (size_t c = 0; c < n_class; c++)
                n += wanted[c] && what[c].object == p->segment.object[row] &&
                     what[c].event == p->segment.event[row] &&
                     what[c].medium == p->segment.medium[row];
        assert_int_equal(count[i], n);
    }
}

static void check_hits(const struct rmap_history_view *view, const struct rmap_portion *p,
                       const uint8_t *wanted, const uint32_t *count)
{
    const struct rmap_history_hit *what = rmap_history_hits(view->index);
    size_t row = 0;
    for (size_t i = 0; i < p->n_row[RMAP_TABLE_RAY]; i++) {
        uint32_t n = 0;
        for (uint32_t s = 0; s < p->ray.registration_count[i]; s++, row++)
            for (size_t c = 0; c < rmap_history_n_hit(view->index); c++)
                n += wanted[c] && what[c].detector == p->registration.detector[row] &&
                     what[c].registered == p->registration.registered[row];
        assert_int_equal(count[i], n);
    }
}

/* Of each ray; bits NULL: there are none. */
static void count_marks(const struct rmap_history_view *view, const uint64_t *bits,
                        const uint32_t *n_rows, uint32_t *count)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    memset(count, 0, n_ray * sizeof *count);
    if (bits)
        rmap_bits_count_groups(bits, n_rows, n_ray, count);
}

/* Room for what tests want and count. */
struct wants {
    uint8_t *class, *hit;
    uint32_t *count;
};

/* Classes and registrations by chance, so many of a thousand. */
static void check_marks(const struct rmap_history_view *view, const struct rmap_portion *p,
                        uint64_t random, uint32_t share, const struct wants *want)
{
    size_t n_class = rmap_history_n_class(view->index), n_hit = rmap_history_n_hit(view->index);
    for (size_t c = 0; c < n_class; c++)
        want->class[c] = draw(&random, 1000) < share;
    for (size_t c = 0; c < n_hit; c++)
        want->hit[c] = draw(&random, 1000) < share;
    count_marks(view, rmap_history_mark(view, want->class), view->segment_count, want->count);
    check_counts(view, p, want->class, want->count);
    count_marks(view, rmap_history_mark_hits(view, want->hit), view->registration_count,
                want->count);
    check_hits(view, p, want->hit, want->count);
}

/* Sets that were asked for in the portion before, more of them than are marked at once. */
static void check_old_sets(const struct rmap_history_view *view, const struct rmap_portion *p,
                           const struct wants *want)
{
    size_t n_class = rmap_history_n_class(view->index);
    for (size_t s = 0; s < 20; s++) {
        for (size_t c = 0; c < n_class; c++)
            want->class[c] = c % (s % 10 + 2) == 1;
        count_marks(view, rmap_history_mark(view, want->class), view->segment_count, want->count);
        check_counts(view, p, want->class, want->count);
    }
}

/* Opens the portion again from a copy of what the view made. */
static void reopen(struct rmap_history_view *view, size_t portion, struct rmap_history_made **made)
{
    struct rmap_error err = {0};
    const size_t nbytes = rmap_history_made_nbytes(view);
    struct rmap_history_made *copy = rmap_alloc_unset(nbytes, 1);
    assert_non_null(copy);
    memset(copy, 0xA5, nbytes);
    rmap_history_made_copy(view, copy);
    rmap_free(*made);
    *made = copy;
    assert_int_equal(rmap_history_view_reopen(view->index, portion, copy, view, &err), RMAP_OK);
}

static void test_counts_are_those_of_the_rows(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    struct rmap_history_view view = {0};
    const uint32_t shares[] = {0, 1, 10, 100, 500, 900, 1000};
    for (int in_memory = 0; in_memory < 2; in_memory++) {
        assert_int_equal(open_index(rig, in_memory == 1, &err), RMAP_OK);
        struct rmap_history_made *made = NULL;
        struct wants want = {rmap_alloc(rmap_history_n_class(rig->index), 1),
                             rmap_alloc(rmap_history_n_hit(rig->index), 1),
                             rmap_alloc(4096, sizeof(uint32_t))};
        assert_true(want.class && want.hit && want.count);
        for (size_t i = 0; i < N_PORTION; i++) {
            assert_int_equal(rmap_history_view_open(rig->index, i, &view, &err), RMAP_OK);
            for (size_t s = 0; s < sizeof shares / sizeof *shares; s++) {
                if (view.form == RMAP_HISTORY_ROWS)
                    check_marks(&view, rig->portion[i], 99 * i + s, shares[s], &want);
                reopen(&view, i, &made); /* before and after all of it is there */
            }
            if (view.form == RMAP_HISTORY_ROWS)
                check_old_sets(&view, rig->portion[i], &want);
        }
        rmap_free(want.class);
        rmap_free(want.hit);
        rmap_free(want.count);
        rmap_free(made);
        rmap_history_destroy(rig->index);
    }
    rmap_history_view_fini(&view);
}

static void test_gives_back_what_was_reopened(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    struct rmap_history_view view = {0};
    struct rmap_portion out = {0};
    struct rmap_history_made *made = NULL;
    assert_int_equal(open_index(rig, false, &err), RMAP_OK);
    for (size_t i = 0; i < N_PORTION; i++) {
        assert_int_equal(rmap_history_view_open(rig->index, i, &view, &err), RMAP_OK);
        for (int round = 0; round < 2; round++) {
            reopen(&view, i, &made);
            assert_int_equal(view.unit_weight, !recipes[i].weighted);
            assert_int_equal(rmap_history_unfold(&view, RMAP_COLUMNS_ALL, &out, &err), RMAP_OK);
            assert_int_equal(out.first_ray, rig->portion[i]->first_ray);
            same_columns(rig->portion[i], &out);
            if (view.relative)
                assert_memory_equal(view.relative, rig->portion[i]->registration.relative,
                                    4 * out.n_row[RMAP_TABLE_REGISTRATION]);
        }
    }
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        rmap_free(rmap_portion_column(&out, (enum rmap_column)c));
    rmap_free(made);
    rmap_history_destroy(rig->index);
    rmap_history_view_fini(&view);
}

/* Every damage is found: a portion's by its own checksum, the head's by that of the head. */
static void test_damage_is_told(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    struct rmap_history_view view = {0};
    uint64_t random = 3;
    for (int k = 0; k < 300; k++) {
        uint8_t *byte = &rig->bytes.head[draw(&random, (uint32_t)rig->bytes.head_nbytes)];
        *byte ^= (uint8_t)(1u << draw(&random, 8));
        assert_int_equal(open_index(rig, true, &err), RMAP_FORMAT);
    }
    free_bytes(&rig->bytes);
    assert_int_equal(build(rig, &err), RMAP_OK);
    assert_int_equal(open_index(rig, true, &err), RMAP_OK);
    for (size_t i = 0; i < N_PORTION; i++)
        assert_int_equal(rmap_history_view_open(rig->index, i, &view, &err), RMAP_OK);
    size_t n = rig->bytes.body_nbytes;
    for (int k = 0; k < 300; k++) {
        size_t n_bad = 0;
        uint8_t *byte = &rig->bytes.body[draw(&random, (uint32_t)n)], good = *byte;
        *byte ^= (uint8_t)(1u << draw(&random, 8));
        for (size_t i = 0; i < N_PORTION; i++)
            n_bad += rmap_history_view_open(rig->index, i, &view, &err) == RMAP_FORMAT;
        assert_int_equal(n_bad, 1);
        *byte = good;
    }
    rmap_history_view_fini(&view);
    rmap_history_destroy(rig->index);
    for (size_t cut = 0; cut < rig->bytes.head_nbytes; cut += 1 + cut / 7) {
        struct rmap_history_body body = {.bytes = rig->bytes.body, .nbytes = n};
        assert_int_equal(rmap_history_open(rig->bytes.head, cut, &body, &limits, &rig->index, &err),
                         RMAP_FORMAT);
    }
    rig->bytes.head[7]++;
    assert_int_equal(open_index(rig, true, &err), RMAP_FORMAT);
    assert_non_null(strstr(err.text, "of another format"));
}

static void test_values_lie_in_the_scene(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    const struct rmap_history_limits small[] = {{1, N_OBJECT, N_MEDIUM, N_DETECTOR},
                                                {N_SOURCE, 7, N_MEDIUM, N_DETECTOR},
                                                {N_SOURCE, N_OBJECT, 1, N_DETECTOR},
                                                {N_SOURCE, N_OBJECT, N_MEDIUM, 2}};
    struct rmap_history_body body = {.bytes = rig->bytes.body, .nbytes = rig->bytes.body_nbytes};
    for (size_t i = 0; i < 4; i++)
        assert_int_equal(rmap_history_open(rig->bytes.head, rig->bytes.head_nbytes, &body,
                                           &small[i], &rig->index, &err),
                         RMAP_FORMAT);
}

static void test_short_memory_is_told(void **state)
{
    struct rig *rig = *state;
    struct rmap_error err = {0};
    int64_t live = rmap_alloc_live();
    for (int64_t at = 1;; at++) {
        struct rig again = *rig;
        struct rmap_history_view view = {0};
        again.bytes = (struct rmap_history_bytes){0};
        again.index = NULL;
        rmap_alloc_fail_at(at);
        enum rmap_status st = build(&again, &err);
        if (st == RMAP_OK)
            st = open_index(&again, false, &err);
        for (size_t i = 0; i < N_PORTION && st == RMAP_OK; i++)
            st = rmap_history_view_open(again.index, i, &view, &err);
        rmap_alloc_fail_at(0);
        rmap_history_view_fini(&view);
        rmap_history_destroy(again.index);
        free_bytes(&again.bytes);
        assert_int_equal(rmap_alloc_live(), live);
        if (st == RMAP_OK)
            break;
        assert_int_equal(st, RMAP_SYSTEM);
        assert_true(at < 500);
    }
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_gives_back_what_it_was_given, setup, teardown),
        cmocka_unit_test_setup_teardown(test_dictionary_holds_the_paths, setup, teardown),
        cmocka_unit_test_setup_teardown(test_counts_are_those_of_the_rows, setup, teardown),
        cmocka_unit_test_setup_teardown(test_gives_back_what_was_reopened, setup, teardown),
        cmocka_unit_test_setup_teardown(test_damage_is_told, setup, teardown),
        cmocka_unit_test_setup_teardown(test_values_lie_in_the_scene, setup, teardown),
        cmocka_unit_test_setup_teardown(test_short_memory_is_told, setup, teardown),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}

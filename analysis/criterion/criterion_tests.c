/* SPDX-License-Identifier: MIT
 *
 * Rows are marked strip by strip, rays all at once, without a branch per ray.
 */
#include "analysis/criterion/criterion_tests.h"

#include <string.h>

#include "analysis/criterion/criterion_mark.h"
#include "analysis/criterion/path_mark.h"
#include "analysis/criterion/registration_response.h"
#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/count.h"
#include "base/wide.h"

/* Rows marked at a time, whole words of bits: they stay in the first-level cache. */
enum { STRIP_ROWS = 4096 };

enum rmap_status rmap_evaluation_fetch(const struct rmap_evaluation *ev, rmap_column_set columns,
                                       struct rmap_error *err)
{
    return ev->input->fetch ? ev->input->fetch(ev->input->context, columns, err) : RMAP_OK;
}

/* Room for a bit per row, or per ray; one word more is read. */
static enum rmap_status reserve(const struct rmap_evaluation *ev, size_t n_bit,
                                struct rmap_error *err)
{
    enum rmap_status st =
        RMAP_RESERVE(ev->evaluator->mark, ev->evaluator->mark_cap, rmap_bit_words(n_bit) + 2, err);
    return st;
}

/* Bytes that are 0 or 1 as bits. */
static void keep_bits(const uint8_t *flag, size_t n, uint64_t *bits)
{
    static const uint8_t marked = 1;
    rmap_bytes_among(flag, n, &marked, 1, bits);
}

/* A bit for each segment. size: [n_ray] segments of each ray. */
static void mark_segments(const struct rmap_evaluation *ev, const struct rmap_step_test *test,
                          const uint32_t *size, size_t n_row)
{
    uint8_t flag[STRIP_ROWS];
    struct rmap_strip strip = {0};
    for (; strip.first < n_row; strip.first += strip.n) {
        strip.n = n_row - strip.first < STRIP_ROWS ? n_row - strip.first : STRIP_ROWS;
        while ((test->side || test->n_limit) && strip.ray_row + size[strip.ray] <= strip.first)
            strip.ray_row += size[strip.ray++];
        rmap_steps_mark(ev->criterion, test, ev->portion, &strip, flag);
        keep_bits(flag, strip.n, ev->evaluator->mark + strip.first / 64);
    }
}

/* A bit for each registration that may count; sure: for those that do, or NULL. */
static void mark_registrations(const struct rmap_evaluation *ev,
                               const struct rmap_registration_test *test, size_t n_row,
                               uint64_t *sure)
{
    uint8_t flag[STRIP_ROWS];
    for (struct rmap_strip strip = {0}; strip.first < n_row; strip.first += strip.n) {
        strip.n = n_row - strip.first < STRIP_ROWS ? n_row - strip.first : STRIP_ROWS;
        rmap_registrations_mark(ev->criterion, test, ev->portion, &strip, flag);
        keep_bits(flag, strip.n, ev->evaluator->mark + strip.first / 64);
    }
    if (test->where >= 0 && n_row > 0)
        rmap_where_keep(ev->criterion, test->where, ev->input->columns, ev->portion, n_row,
                        ev->evaluator->mark, sure);
}

enum rmap_status rmap_test_count_rows(const struct rmap_evaluation *ev, enum rmap_table table,
                                      const uint32_t **n_rows_ret, struct rmap_error *err)
{
    const struct rmap_ray_columns *ray = &ev->portion->ray;
    const size_t n_row = ev->portion->n_row[table];
    const uint32_t *n_rows =
        table == RMAP_TABLE_SEGMENT ? ray->segment_count : ray->registration_count;
    *n_rows_ret = n_rows;
    return rmap_sums_to(n_rows, ev->n_ray, n_row)
               ? RMAP_OK
               : rmap_error_set(err, RMAP_FORMAT, "the rows of %zu rays do not add up to %zu",
                                ev->n_ray, n_row);
}

/* By objects that follow each other, or all, and by events. */
static bool is_plain(const struct rmap_step_test *test)
{
    return !(test->of_object && test->object.member) && !test->of_medium &&
           test->part == RMAP_PART_ALL && !test->side && test->n_limit == 0;
}

/* A bit for each segment, of such a test. */
static void mark_steps(const struct rmap_evaluation *ev, const struct rmap_step_test *test,
                       size_t n_row)
{
    const struct rmap_segment_columns *segment = &ev->portion->segment;
    uint64_t *mark = ev->evaluator->mark;
    if (test->of_object)
        rmap_range_bits(segment->object, n_row, (uint32_t)test->object.low, test->object.span,
                        mark);
    else
        memset(mark, UINT8_MAX, rmap_bit_words(n_row) * sizeof *mark);
    if (test->events)
        rmap_keep_any_bits(segment->event, n_row, test->events, mark);
    if (test->events_not)
        rmap_keep_none_bits(segment->event, n_row, test->events_not, mark);
}

static enum rmap_status mark_table(const struct rmap_evaluation *ev,
                                   const struct rmap_criterion_node *node, bool surely,
                                   struct rmap_marks *marks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_evaluator *memory = ev->evaluator;
    enum rmap_table table =
        node->kind == RMAP_CRITERION_STEPS ? RMAP_TABLE_SEGMENT : RMAP_TABLE_REGISTRATION;
    const uint32_t *n_rows;
    RMAP_TRY(reserve(ev, ev->portion->n_row[table], err));
    RMAP_TRY(rmap_test_count_rows(ev, table, &n_rows, err));
    if (surely)
        RMAP_TRY(RMAP_RESERVE(memory->sure, memory->sure_cap,
                              rmap_bit_words(ev->portion->n_row[table]) + 2, err));
    if (table == RMAP_TABLE_REGISTRATION)
        mark_registrations(ev, &node->registrations, ev->portion->n_row[table],
                           surely ? memory->sure : NULL);
    else if (is_plain(&node->steps))
        mark_steps(ev, &node->steps, ev->portion->n_row[table]);
    else
        mark_segments(ev, &node->steps, n_rows, ev->portion->n_row[table]);
    *marks = (struct rmap_marks){memory->mark, n_rows, surely ? memory->sure : NULL};
out:
    return st;
}

/* 1 where the ray ended so, and there. */
static void mark_endings(const struct rmap_evaluation *ev, const struct rmap_ending_test *test,
                         uint8_t *flag)
{
    const struct rmap_portion *portion = ev->portion;
    const bool of_medium = test->medium.span > 0;
    size_t row = 0;
    for (size_t i = 0; i < ev->n_ray; i++)
        flag[i] = portion->ray.stop[i] == test->stop;
    for (size_t i = 0; test->somewhere && i < ev->n_ray; i++) {
        uint32_t n = portion->ray.segment_count[i];
        row += n;
        if (n == 0) {
            flag[i] = 0;
            continue;
        }
        int32_t object = portion->segment.object[row - 1];
        flag[i] &= test->object.member ? rmap_index_set_member(&test->object, object)
                                       : rmap_index_set_has(&test->object, object);
        if (of_medium && object < 0)
            flag[i] = portion->ray.stop[i] == test->stop &&
                      rmap_index_set_has(&test->medium, portion->segment.medium[row - 1]);
    }
}

/* A bit for each ray that ended so. */
static void keep_stops(const struct rmap_evaluation *ev, uint32_t stop)
{
    const uint8_t it = (uint8_t)stop;
    rmap_bytes_among(ev->portion->ray.stop, ev->n_ray, &it, stop == it, ev->evaluator->mark);
}

/* Of rays that ended so, 1 for those whose last segment ended at one of the objects, which follow
 * each other. */
static enum rmap_status mark_ends(const struct rmap_evaluation *ev,
                                  const struct rmap_ending_test *test, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = ev->portion;
    size_t n_row = portion->n_row[RMAP_TABLE_SEGMENT];
    const size_t n_word = rmap_bit_words(ev->n_ray);
    uint64_t *mark = ev->evaluator->mark;
    const uint32_t *n_rows;
    RMAP_TRY(RMAP_RESERVE(ev->evaluator->last, ev->evaluator->last_cap, n_word, err));
    RMAP_TRY(rmap_test_count_rows(ev, RMAP_TABLE_SEGMENT, &n_rows, err));
    rmap_range_bits(portion->segment.object, n_row, (uint32_t)test->object.low, test->object.span,
                    mark);
    rmap_bits_last_groups(mark, n_rows, ev->n_ray, ev->evaluator->last);
    keep_stops(ev, test->stop);
    for (size_t w = 0; w < n_word; w++)
        mark[w] &= ev->evaluator->last[w];
out:
    return st;
}

static enum rmap_status mark_rays(const struct rmap_evaluation *ev,
                                  const struct rmap_criterion_node *node, struct rmap_marks *marks,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    uint8_t *flag = (uint8_t *)ev->count; /* has room for them */
    const size_t n_segment = ev->portion->n_row[RMAP_TABLE_SEGMENT];
    RMAP_TRY(reserve(ev, ev->n_ray > n_segment ? ev->n_ray : n_segment, err));
    *marks = (struct rmap_marks){.bits = ev->evaluator->mark};
    if (node->kind == RMAP_CRITERION_ENDED && node->ending.somewhere &&
        !node->ending.object.member && node->ending.medium.span == 0)
        return mark_ends(ev, &node->ending, err);
    if (node->kind == RMAP_CRITERION_PATH)
        RMAP_TRY(rmap_path_mark(node, ev->portion, NULL, flag, err));
    else if (node->kind == RMAP_CRITERION_ENDED)
        mark_endings(ev, &node->ending, flag);
    else
        rmap_index_set_mark(&node->source, ev->portion->ray.source, ev->n_ray, flag);
    keep_bits(flag, ev->n_ray, ev->evaluator->mark);
out:
    return st;
}

enum rmap_status rmap_test_mark(const struct rmap_evaluation *ev, int32_t index,
                                const struct rmap_criterion_node *node, bool surely,
                                struct rmap_marks *marks, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *marks = (struct rmap_marks){.bits = NULL};
    if (ev->input->mark && !(node->columns & ~RMAP_COLUMNS_DISCRETE))
        RMAP_TRY(ev->input->mark(ev->input->context, index, node, marks, err));
    if (marks->bits)
        return RMAP_OK;
    RMAP_TRY(rmap_evaluation_fetch(ev, node->columns, err));
    if (node->kind == RMAP_CRITERION_STEPS || node->kind == RMAP_CRITERION_REGISTRATIONS)
        st = mark_table(ev, node, surely, marks, err);
    else
        st = mark_rays(ev, node, marks, err);
out:
    return st;
}

RMAP_WIDE static void count_bits(const uint64_t *bits, size_t n, uint32_t *count)
{
    for (size_t i = 0; i < n; i += 64) {
        const uint64_t word = bits[i / 64];
        const size_t few = n - i < 64 ? n - i : 64;
        for (size_t k = 0; k < few; k++)
            count[i + k] = word >> k & 1;
    }
}

void rmap_test_count(const uint64_t *bits, const uint32_t *n_rows, size_t n_ray, uint32_t *count)
{
    if (n_rows)
        rmap_bits_count_groups(bits, n_rows, n_ray, count);
    else
        count_bits(bits, n_ray, count);
}

/* SPDX-License-Identifier: MIT
 *
 * Evaluation: every test becomes a byte per ray; and, or, not combine bytes. Tests that count
 * rows mark them strip by strip and take each ray's share from a running sum, so that the inner
 * loops have no branch per ray's end.
 */
#include <math.h>
#include <string.h>

#include "analysis/criterion_tree.h"
#include "base/alloc.h"

/* Rows marked at a time: marks and sums stay in the first-level cache. */
enum { STRIP_ROWS = 4096 };

struct evaluation {
    const struct rmap_criterion *criterion;
    const struct rmap_portion *portion;
    const double *flux_per_weight;
    size_t n_ray;
    uint32_t *count; /* [n_ray] */
    uint8_t *mask;   /* [criterion->n_mask][n_ray] */
};

static void mark(const struct evaluation *ev, const struct rmap_criterion_node *node,
                 const struct rmap_strip *strip, uint8_t *flag)
{
    if (node->kind == RMAP_CRITERION_STEPS)
        rmap_steps_mark(ev->criterion, &node->steps, ev->portion, strip, flag);
    else
        rmap_registrations_mark(ev->criterion, &node->registrations, ev->portion, strip, flag);
}

/* Counts marked rows of each ray; rows [n_ray]: rows per ray, which sum to n_row. */
static void count_rows(const struct evaluation *ev, const struct rmap_criterion_node *node,
                       const uint32_t *rows, size_t n_row)
{
    uint8_t flag[STRIP_ROWS];
    uint32_t sum[STRIP_ROWS + 1];
    size_t ray = 0, ray_row = 0;
    uint32_t carry = 0; /* of the ray that began in an earlier strip */
    sum[0] = 0;
    for (size_t first = 0; ray < ev->n_ray; first += STRIP_ROWS) {
        size_t n = n_row - first < STRIP_ROWS ? n_row - first : STRIP_ROWS;
        struct rmap_strip strip = {first, n, ray, ray_row};
        if (n > 0)
            mark(ev, node, &strip, flag);
        for (size_t i = 0; i < n; i++)
            sum[i + 1] = sum[i] + flag[i];
        size_t at = ray_row > first ? ray_row - first : 0;
        for (; ray < ev->n_ray && ray_row + rows[ray] <= first + n; ray++) {
            ray_row += rows[ray];
            ev->count[ray] = carry + sum[ray_row - first] - sum[at];
            at = ray_row - first;
            carry = 0;
        }
        carry += sum[n] - sum[at];
    }
}

static void compare_counts(const struct evaluation *ev, const struct rmap_interval *interval,
                           uint8_t *match)
{
    double low = ceil(fmax(interval->low, 0.0)), high = floor(fmin(interval->high, UINT32_MAX));
    bool empty = low > high;
    uint32_t least = empty ? 1 : (uint32_t)low, span = empty ? 0 : (uint32_t)(high - low);
    uint8_t flip = interval->outside;
    if (empty)
        memset(match, flip, ev->n_ray);
    else
        for (size_t i = 0; i < ev->n_ray; i++)
            match[i] = (ev->count[i] - least <= span) ^ flip;
}

static double ray_number(const struct evaluation *ev, enum rmap_ray_number number, size_t i)
{
    const struct rmap_ray_columns *ray = &ev->portion->ray;
    switch (number) {
    case RMAP_RAY_NUMBER_ID:
        return (double)ray->id[i];
    case RMAP_RAY_NUMBER_SEGMENTS:
        return ray->segment_count[i];
    case RMAP_RAY_NUMBER_WAVELENGTH:
        return ray->wavelength[i];
    case RMAP_RAY_NUMBER_FLUX:
        return (size_t)ray->source[i] < ev->criterion->scene->n_source
                   ? ray->weight[i] * ev->flux_per_weight[ray->source[i]]
                   : (double)NAN;
    case RMAP_RAY_NUMBER_PATH_LENGTH:
        return ray->path_length[i];
    case RMAP_RAY_NUMBER_OPTICAL_PATH:
        return ray->optical_path[i];
    }
    return (double)NAN;
}

/* 1 where the ray ended so, and there. */
static void count_endings(const struct evaluation *ev, const struct rmap_ending_test *test)
{
    const struct rmap_portion *portion = ev->portion;
    size_t row = 0;
    for (size_t i = 0; i < ev->n_ray; i++) {
        ev->count[i] = portion->ray.stop[i] == test->stop;
        if (!test->somewhere)
            continue;
        row += portion->ray.segment_count[i];
        if (!ev->count[i])
            continue;
        if (portion->ray.segment_count[i] == 0) {
            ev->count[i] = 0;
            continue;
        }
        int32_t object = portion->segment.object[row - 1];
        ev->count[i] = object >= 0
                           ? rmap_index_set_has(&test->object, object)
                           : rmap_index_set_has(&test->medium, portion->segment.medium[row - 1]);
    }
}

static void evaluate_test(const struct evaluation *ev, const struct rmap_criterion_node *node,
                          uint8_t *match)
{
    const struct rmap_portion *portion = ev->portion;
    switch (node->kind) {
    case RMAP_CRITERION_ALL:
        memset(match, rmap_interval_holds(&node->interval, 1.0), ev->n_ray);
        return;
    case RMAP_CRITERION_NUMBER:
        for (size_t i = 0; i < ev->n_ray; i++)
            match[i] = rmap_interval_holds(&node->interval, ray_number(ev, node->ray_number, i));
        return;
    case RMAP_CRITERION_SOURCE:
        for (size_t i = 0; i < ev->n_ray; i++)
            ev->count[i] = rmap_index_set_has(&node->source, portion->ray.source[i]);
        break;
    case RMAP_CRITERION_ENDED:
        count_endings(ev, &node->ending);
        break;
    case RMAP_CRITERION_STEPS:
        count_rows(ev, node, portion->ray.segment_count, portion->n_row[RMAP_TABLE_SEGMENT]);
        break;
    default:
        count_rows(ev, node, portion->ray.registration_count,
                   portion->n_row[RMAP_TABLE_REGISTRATION]);
        break;
    }
    compare_counts(ev, &node->interval, match);
}

/* level: masks that are in use above. */
static void evaluate_node(const struct evaluation *ev, int32_t index, int level, uint8_t *match)
{
    const struct rmap_criterion_node *node = &ev->criterion->node[index];
    size_t n = ev->n_ray;
    bool is_and = node->kind == RMAP_CRITERION_AND;
    if (node->kind == RMAP_CRITERION_NOT) {
        evaluate_node(ev, node->first, level, match);
        for (size_t i = 0; i < n; i++)
            match[i] ^= 1;
    } else if (is_and || node->kind == RMAP_CRITERION_OR) {
        uint8_t *own = ev->mask + (size_t)level * n;
        memset(match, is_and, n);
        for (int32_t child = node->first; child >= 0; child = ev->criterion->node[child].next) {
            if (!memchr(match, is_and, n))
                return; /* every ray is decided */
            evaluate_node(ev, child, level + 1, own);
            if (is_and)
                for (size_t i = 0; i < n; i++)
                    match[i] &= own[i];
            else
                for (size_t i = 0; i < n; i++)
                    match[i] |= own[i];
        }
    } else {
        evaluate_test(ev, node, match);
    }
}

static bool sums_to(const uint32_t *rows, size_t n_ray, size_t n_row)
{
    uint64_t sum = 0;
    for (size_t i = 0; i < n_ray; i++)
        sum += rows[i];
    return sum == n_row;
}

static enum rmap_status check_portion(const struct rmap_criterion *criterion,
                                      const struct rmap_portion *portion, struct rmap_error *err)
{
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++) {
        const struct rmap_column_info *info = rmap_column_info((enum rmap_column)c);
        if (criterion->columns & RMAP_COLUMN_BIT(c) && portion->n_row[info->table] > 0 &&
            !rmap_portion_column(portion, (enum rmap_column)c))
            return rmap_error_set(err, RMAP_INTERNAL, "column %s was not read", info->path);
    }
    if ((portion->ray.segment_count &&
         !sums_to(portion->ray.segment_count, n_ray, portion->n_row[RMAP_TABLE_SEGMENT])) ||
        (portion->ray.registration_count &&
         !sums_to(portion->ray.registration_count, n_ray, portion->n_row[RMAP_TABLE_REGISTRATION])))
        return rmap_error_set(err, RMAP_FORMAT,
                              "the rays from id %llu on do not add up to the rows of their tables",
                              (unsigned long long)portion->first_ray);
    return RMAP_OK;
}

enum rmap_status rmap_criterion_evaluate(const struct rmap_criterion *criterion,
                                         const struct rmap_portion *portion,
                                         const double *flux_per_weight, uint8_t *match,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct evaluation ev = {.criterion = criterion,
                            .portion = portion,
                            .flux_per_weight = flux_per_weight,
                            .n_ray = portion->n_row[RMAP_TABLE_RAY]};
    RMAP_TRY(check_portion(criterion, portion, err));
    ev.count = rmap_alloc(ev.n_ray, sizeof *ev.count);
    ev.mask = rmap_alloc(ev.n_ray, (size_t)criterion->n_mask);
    if (!ev.count || !ev.mask) {
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rays", ev.n_ray);
        goto out;
    }
    evaluate_node(&ev, criterion->root, 0, match);
out:
    rmap_free(ev.mask);
    rmap_free(ev.count);
    return st;
}

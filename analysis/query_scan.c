/* SPDX-License-Identifier: MIT
 *
 * Reads the portions that may hold matches, and of those only the columns that the criteria and
 * the sums need. Rays that are wanted whole are read by a second cursor, and only from portions
 * in which some matched.
 */
#include <string.h>

#include "analysis/criterion_tree.h"
#include "analysis/query.h"
#include "base/alloc.h"

struct scan {
    const struct rmap_map *map;
    struct rmap_criterion *const *criterion;
    size_t n_criterion;
    struct rmap_count *count;
    bool *wanted; /* [n_criterion] that the portion in hand may answer */
    uint8_t *match;
    size_t match_cap;
    struct rmap_cursor *cursor; /* columns of the criteria and the sums */
    struct rmap_cursor *whole;  /* all columns; made when first needed */
    struct rmap_portion *collect;
    uint16_t *wide; /* colours of a portion with fewer channels than `collect` has */
    size_t wide_cap;
    uint64_t n_left; /* rays still to collect */
    bool collected;  /* criterion 0 has all it was asked for */
};

static bool skips(const struct rmap_criterion *criterion, const struct rmap_portion_info *info)
{
    return (double)info->first_ray > rmap_criterion_last_ray(criterion) ||
           !rmap_criterion_may_match(criterion, &info->summary);
}

/* Without a branch per ray: which rays match is random. */
static enum rmap_status add_sums(const struct scan *scan, const struct rmap_portion *portion,
                                 struct rmap_count *count, struct rmap_error *err)
{
    const struct rmap_ray_columns *ray = &portion->ray;
    size_t n_source = rmap_map_scene(scan->map)->n_source, n_ray = portion->n_row[RMAP_TABLE_RAY];
    const uint8_t *match = scan->match;
    for (size_t i = 0; i < n_ray; i++) {
        count->rays += match[i];
        count->segments += ray->segment_count[i] & (0u - match[i]);
    }
    for (size_t i = 0; i < n_ray; i++) {
        size_t source = (size_t)ray->source[i];
        double weight = match[i] ? ray->weight[i] : 0.0;
        if (source >= n_source)
            return rmap_error_set(
                err, RMAP_FORMAT, "a ray of the portion from id %llu on has source %d of %zu",
                (unsigned long long)portion->first_ray, (int)ray->source[i], n_source);
        count->source_weight[source] += weight;
        count->source_weight_squared[source] += weight * weight;
    }
    return RMAP_OK;
}

/* The portion with as many channels as the collected rays have, those it lacks being 0. */
static enum rmap_status widen(struct scan *scan, struct rmap_portion *portion,
                              struct rmap_error *err)
{
    size_t n = portion->n_row[RMAP_TABLE_SEGMENT], few = (size_t)portion->n_channel;
    size_t many = (size_t)scan->collect->n_channel;
    void *block = scan->wide;
    if (few == many)
        return RMAP_OK;
    enum rmap_status st =
        rmap_reserve(&block, &scan->wide_cap, n * many + 1, sizeof *scan->wide, err);
    scan->wide = block;
    if (st != RMAP_OK)
        return st;
    for (size_t i = 0; i < n; i++)
        for (size_t c = 0; c < many; c++)
            scan->wide[i * many + c] = c < few ? portion->colour[i * few + c] : 0;
    portion->colour = scan->wide;
    portion->n_channel = scan->collect->n_channel;
    return RMAP_OK;
}

/* Appends the marked rays of a portion, whole, until enough are there. */
static enum rmap_status collect_rays(struct scan *scan, size_t index, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *read = NULL;
    size_t segment = 0, registration = 0;
    if (!scan->whole)
        RMAP_TRY(rmap_cursor_create(scan->map, RMAP_COLUMNS_ALL, &scan->whole, err));
    RMAP_TRY(rmap_cursor_read(scan->whole, index, &read, err));
    struct rmap_portion portion = *read; /* its columns stay the cursor's */
    RMAP_TRY(widen(scan, &portion, err));
    for (size_t i = 0; i < portion.n_row[RMAP_TABLE_RAY] && scan->n_left > 0; i++) {
        if (scan->match[i]) {
            RMAP_TRY(
                rmap_portion_append_ray(scan->collect, &portion, i, segment, registration, err));
            scan->n_left--;
        }
        segment += portion.ray.segment_count[i];
        registration += portion.ray.registration_count[i];
    }
    scan->collected = scan->n_left == 0;
out:
    return st;
}

static enum rmap_status scan_portion(struct scan *scan, size_t index, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_portion *portion = NULL;
    RMAP_TRY(rmap_cursor_read(scan->cursor, index, &portion, err));
    size_t n_ray = portion->n_row[RMAP_TABLE_RAY];
    void *block = scan->match;
    RMAP_TRY(rmap_reserve(&block, &scan->match_cap, n_ray, 1, err));
    scan->match = block;
    for (size_t c = 0; c < scan->n_criterion; c++) {
        if (!scan->wanted[c])
            continue;
        scan->count[c].portions_read++;
        RMAP_TRY(rmap_criterion_evaluate(scan->criterion[c], portion,
                                         rmap_map_flux_per_weight(scan->map), scan->match, err));
        RMAP_TRY(add_sums(scan, portion, &scan->count[c], err));
        if (c == 0 && scan->collect && memchr(scan->match, 1, n_ray))
            RMAP_TRY(collect_rays(scan, index, err));
    }
out:
    return st;
}

/* Which criteria the portion may answer; true when any of them. */
static bool choose(struct scan *scan, size_t index)
{
    const struct rmap_portion_info *info = rmap_map_portion(scan->map, index);
    bool any = false;
    for (size_t c = 0; c < scan->n_criterion; c++) {
        scan->wanted[c] = !(c == 0 && scan->collected) && !skips(scan->criterion[c], info);
        any |= scan->wanted[c];
    }
    return any;
}

static rmap_column_set columns_of(struct rmap_criterion *const *criterion, size_t n_criterion)
{
    rmap_column_set columns = RMAP_COLUMN_BIT(RMAP_RAY_source) | RMAP_COLUMN_BIT(RMAP_RAY_weight) |
                              RMAP_COLUMN_BIT(RMAP_RAY_segment_count);
    for (size_t c = 0; c < n_criterion; c++)
        columns |= rmap_criterion_columns(criterion[c]);
    return columns;
}

enum rmap_status rmap_query_scan(const struct rmap_map *map,
                                 struct rmap_criterion *const *criterion, size_t n_criterion,
                                 size_t first, size_t last, struct rmap_count *count,
                                 struct rmap_portion *collect, uint64_t limit,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct scan scan = {.map = map,
                        .criterion = criterion,
                        .n_criterion = n_criterion,
                        .count = count,
                        .collect = collect,
                        .n_left = limit,
                        .collected = collect && limit == 0};
    scan.wanted = rmap_alloc(n_criterion, sizeof *scan.wanted);
    if (!scan.wanted)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu criteria", n_criterion);
    RMAP_TRY(rmap_cursor_create(map, columns_of(criterion, n_criterion), &scan.cursor, err));
    for (size_t p = first; p < last && !(n_criterion == 1 && scan.collected); p++)
        if (choose(&scan, p))
            RMAP_TRY(scan_portion(&scan, p, err));
    for (size_t c = 0; c < n_criterion; c++)
        count[c].nbytes_read += rmap_cursor_nbytes_of_rows(scan.cursor) +
                                (c == 0 && scan.whole ? rmap_cursor_nbytes_of_rows(scan.whole) : 0);
out:
    rmap_cursor_destroy(scan.whole);
    rmap_cursor_destroy(scan.cursor);
    rmap_free(scan.match);
    rmap_free(scan.wide);
    rmap_free(scan.wanted);
    return st;
}

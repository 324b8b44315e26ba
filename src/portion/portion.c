/* SPDX-License-Identifier: MIT
 *
 * The histories of a block of consecutive ray ids as columns in memory: what a traced block fills,
 * what a shard stores and what a query decodes.
 */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#define XXH_INLINE_ALL
#include <xxhash.h>

#include "base/alloc.h"
#include "base/wide.h"
#include "portion/portion.h"

/* Where each column's pointer stands in struct rmap_portion. */
/* clang-format off */
static const size_t pointer_offset[RMAP_COLUMN_COUNT] = {
#define RAY(field, path, type, element, width, unit, text)                                         \
    [RMAP_RAY_##field] = offsetof(struct rmap_portion, ray.field),
    RMAP_RAY_COLUMNS(RAY)
#define SEGMENT(field, path, type, element, width, unit, text)                                     \
    [RMAP_SEGMENT_##field] = offsetof(struct rmap_portion, segment.field),
    RMAP_SEGMENT_COLUMNS(SEGMENT)
#define REGISTRATION(field, path, type, element, width, unit, text)                                \
    [RMAP_REGISTRATION_##field] = offsetof(struct rmap_portion, registration.field),
    RMAP_REGISTRATION_COLUMNS(REGISTRATION)
    [RMAP_SEGMENT_colour] = offsetof(struct rmap_portion, colour),
#define CURVE(field, path, type, element, width, unit, text)                                       \
    [RMAP_CURVE_##field] = offsetof(struct rmap_portion, curve.field),
    RMAP_CURVE_COLUMNS(CURVE)
    RMAP_RAY_TIME_COLUMNS(RAY)
    RMAP_REGISTRATION_TIME_COLUMNS(REGISTRATION)
};
/* clang-format on */

/* Segments and registrations per ray to begin with; they grow as needed. */
#define FIRST_SEGMENTS_PER_RAY 8
#define FIRST_ROWS_MIN         64

/* The pointers have different types, so they are moved as bytes. */
void *rmap_portion_column(const struct rmap_portion *portion, enum rmap_column column)
{
    void *start;
    memcpy(&start, (const char *)portion + pointer_offset[column], sizeof start);
    return start;
}

void **rmap_portion_column_address(struct rmap_portion *portion, enum rmap_column column)
{
    return (void **)(void *)((char *)portion + pointer_offset[column]);
}

static void column_set(struct rmap_portion *portion, enum rmap_column column, void *start)
{
    memcpy((char *)portion + pointer_offset[column], &start, sizeof start);
}

size_t rmap_portion_row_nbytes(const struct rmap_portion *portion, enum rmap_column column)
{
    const struct rmap_column_info *info = rmap_column_info(column);
    size_t width = column == RMAP_SEGMENT_colour ? (size_t)portion->n_channel : (size_t)info->width;
    return width * rmap_element_nbytes(info->element);
}

enum rmap_status rmap_portion_create(size_t n_ray, int n_channel, struct rmap_portion **portion_ret,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *portion = NULL;
    if (n_channel < 1)
        return rmap_error_set(err, RMAP_INTERNAL, "a portion needs a colour channel");
    portion = rmap_alloc(1, sizeof *portion);
    if (!portion)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a block of rays");
    portion->n_channel = n_channel;
    if (n_ray < FIRST_ROWS_MIN)
        n_ray = FIRST_ROWS_MIN;
    RMAP_TRY(rmap_portion_reserve(portion, RMAP_TABLE_RAY, n_ray, RMAP_COLUMNS_ALL, err));
    RMAP_TRY(rmap_portion_reserve(portion, RMAP_TABLE_SEGMENT, n_ray * FIRST_SEGMENTS_PER_RAY,
                                  RMAP_COLUMNS_ALL, err));
    RMAP_TRY(rmap_portion_reserve(portion, RMAP_TABLE_REGISTRATION, n_ray, RMAP_COLUMNS_ALL, err));
    RMAP_TRY(rmap_portion_reserve(portion, RMAP_TABLE_CURVE, 1, RMAP_COLUMNS_ALL, err));
    *portion_ret = portion;
    portion = NULL;
out:
    rmap_portion_destroy(portion);
    return st;
}

void rmap_portion_destroy(struct rmap_portion *portion)
{
    if (!portion)
        return;
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        rmap_free(rmap_portion_column(portion, (enum rmap_column)c));
    rmap_free(portion->angle);
    rmap_free(portion);
}

enum rmap_status rmap_portion_set_timed(struct rmap_portion *portion, bool timed,
                                        struct rmap_error *err)
{
    portion->timed = timed;
    for (int t = 0; t < RMAP_TABLE_COUNT && timed; t++) {
        enum rmap_status st =
            rmap_portion_reserve(portion, (enum rmap_table)t, 0, RMAP_COLUMNS_TIME, err);
        if (st != RMAP_OK)
            return st;
    }
    return RMAP_OK;
}

void rmap_portion_clear(struct rmap_portion *portion)
{
    portion->first_ray = 0;
    portion->unpredicted = NULL;
    portion->knows_angles = false;
    memset(portion->n_row, 0, sizeof portion->n_row);
}

enum rmap_status rmap_portion_reserve(struct rmap_portion *portion, enum rmap_table table,
                                      size_t n_more, rmap_column_set columns,
                                      struct rmap_error *err)
{
    size_t used = portion->n_row[table], cap = portion->cap[table];
    if (n_more > SIZE_MAX / 4 - used)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory: %zu more rows wanted", n_more);
    bool grow = used + n_more > cap;
    columns &= rmap_columns_of_run(portion->timed);
    while (cap < used + n_more)
        cap = cap < FIRST_ROWS_MIN ? FIRST_ROWS_MIN : 2 * cap;

    for (rmap_column_set left = grow ? RMAP_COLUMNS_ALL : columns; left; left &= left - 1) {
        const enum rmap_column c = (enum rmap_column)__builtin_ctzll(left);
        void *start = rmap_portion_column(portion, c);
        bool wanted = start ? grow : (columns & RMAP_COLUMN_BIT(c)) != 0;
        if (rmap_column_info(c)->table != table || !wanted)
            continue;
        const size_t nbytes = rmap_portion_row_nbytes(portion, c);
        void *grown = start ? rmap_realloc(start, cap, nbytes) : rmap_alloc_unset(cap, nbytes);
        if (!grown)
            return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu rows of %s", cap,
                                  rmap_column_info(c)->path);
        column_set(portion, c, grown);
    }
    portion->cap[table] = cap;
    return RMAP_OK;
}

int rmap_portion_channel(const struct rmap_portion *portion, size_t segment)
{
    int most = 0;
    if (!portion->colour)
        return 0;
    const uint16_t *share = portion->colour + segment * (size_t)portion->n_channel;
    for (int c = 1; c < portion->n_channel; c++)
        if (share[c] > share[most])
            most = c;
    return most;
}

/* First row of /curve of a ray whose id is not below this one. */
static size_t curve_bound(const struct rmap_portion *portion, uint64_t ray)
{
    size_t low = 0, high = portion->n_row[RMAP_TABLE_CURVE];
    while (low < high) {
        size_t middle = low + (high - low) / 2;
        if (portion->curve.ray[middle] < ray)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

size_t rmap_portion_curve_of(const struct rmap_portion *portion, uint64_t ray, size_t *first_ret)
{
    size_t first = curve_bound(portion, ray), n = 0;
    while (n < portion->n_row[RMAP_TABLE_CURVE] - first && portion->curve.ray[first + n] == ray)
        n++;
    *first_ret = first;
    return n;
}

void rmap_unpredicted_take(struct rmap_unpredicted *list, const struct rmap_unpredicted *known,
                           size_t first, size_t end, size_t to)
{
    if (!known || known->n > RMAP_UNPREDICTED_MAX || known->seed != list->seed) {
        list->n = RMAP_UNPREDICTED_MAX + 1; /* all of them */
        return;
    }
    for (size_t k = 0; k < known->n; k++) {
        if (known->ray[k] < first || known->ray[k] >= end)
            continue;
        if (list->n < RMAP_UNPREDICTED_MAX)
            list->ray[list->n] = (uint32_t)(known->ray[k] - first + to);
        list->n++;
    }
}

enum rmap_status rmap_portion_append_rows(struct rmap_portion *dst, const struct rmap_portion *src,
                                          const size_t first[RMAP_TABLE_COUNT],
                                          const size_t n[RMAP_TABLE_COUNT], struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    if (dst->n_channel != src->n_channel)
        return rmap_error_set(err, RMAP_INTERNAL, "rays of %d colour channels appended to %d",
                              src->n_channel, dst->n_channel);
    if (dst->n_row[RMAP_TABLE_RAY] == 0)
        dst->timed = src->timed;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        if (dst->n_row[RMAP_TABLE_RAY] == 0 || n[t] > dst->cap[t] - dst->n_row[t])
            RMAP_TRY(rmap_portion_reserve(dst, (enum rmap_table)t, n[t], RMAP_COLUMNS_ALL, err));
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
        enum rmap_column c = (enum rmap_column)i;
        enum rmap_table t = rmap_column_info(c)->table;
        if (n[t] == 0 || !rmap_portion_column(src, c) ||
            !(rmap_columns_of_run(dst->timed) & RMAP_COLUMN_BIT(c)))
            continue;
        const size_t row = rmap_portion_row_nbytes(src, c);
        memcpy((char *)rmap_portion_column(dst, c) + dst->n_row[t] * row,
               (const char *)rmap_portion_column(src, c) + first[t] * row, n[t] * row);
    }
    uint64_t id = src->ray.id[first[RMAP_TABLE_RAY]];
    if (dst->n_row[RMAP_TABLE_RAY] == 0 || id < dst->first_ray)
        dst->first_ray = id;
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        dst->n_row[t] += n[t];
out:
    return st;
}

enum rmap_status rmap_portion_append_rays(struct rmap_portion *dst, const struct rmap_portion *src,
                                          size_t ray, size_t n_ray, size_t first_segment,
                                          size_t first_registration, struct rmap_error *err)
{
    size_t first[RMAP_TABLE_COUNT] = {ray, first_segment, first_registration}, last;
    size_t n[RMAP_TABLE_COUNT] = {n_ray};
    if (n_ray == 0)
        return RMAP_OK;
    for (size_t i = ray; i < ray + n_ray; i++) {
        n[RMAP_TABLE_SEGMENT] += src->ray.segment_count[i];
        n[RMAP_TABLE_REGISTRATION] += src->ray.registration_count[i];
    }
    if (src->curve.ray) {
        first[RMAP_TABLE_CURVE] = curve_bound(src, src->ray.id[ray]);
        n[RMAP_TABLE_CURVE] = rmap_portion_curve_of(src, src->ray.id[ray + n_ray - 1], &last);
        n[RMAP_TABLE_CURVE] += last - first[RMAP_TABLE_CURVE];
    }
    return rmap_portion_append_rows(dst, src, first, n, err);
}

enum rmap_status rmap_portion_append_ray(struct rmap_portion *dst, const struct rmap_portion *src,
                                         size_t ray, size_t first_segment,
                                         size_t first_registration, struct rmap_error *err)
{
    return rmap_portion_append_rays(dst, src, ray, 1, first_segment, first_registration, err);
}

/* Four points at a time are three vectors of four. */
#define BOX_WIDE 12

static void box_add(struct rmap_portion_summary *summary, const float *point, size_t n)
{
    float low[BOX_WIDE], high[BOX_WIDE];
    for (size_t k = 0; k < BOX_WIDE; k++) {
        low[k] = summary->box_min[k % 3];
        high[k] = summary->box_max[k % 3];
    }
    size_t whole = 3 * n / BOX_WIDE * BOX_WIDE;
    for (size_t i = 0; i < whole; i += BOX_WIDE)
#pragma GCC unroll 1 /* or it becomes 12 scalars before it can become vectors */
        for (size_t k = 0; k < BOX_WIDE; k++) {
            float x = point[i + k];
            low[k] = x < low[k] ? x : low[k];
            high[k] = x > high[k] ? x : high[k];
        }
    for (size_t i = whole; i < 3 * n; i++) {
        low[i % 3] = point[i] < low[i % 3] ? point[i] : low[i % 3];
        high[i % 3] = point[i] > high[i % 3] ? point[i] : high[i % 3];
    }
    for (size_t k = 0; k < BOX_WIDE; k++) {
        summary->box_min[k % 3] =
            low[k] < summary->box_min[k % 3] ? low[k] : summary->box_min[k % 3];
        summary->box_max[k % 3] =
            high[k] > summary->box_max[k % 3] ? high[k] : summary->box_max[k % 3];
    }
}

void rmap_portion_summarise(const struct rmap_portion *portion,
                            struct rmap_portion_summary *summary)
{
    const size_t *n = portion->n_row;
    *summary = (struct rmap_portion_summary){.box_min = {INFINITY, INFINITY, INFINITY},
                                             .box_max = {-INFINITY, -INFINITY, -INFINITY}};
    for (size_t i = 0; i < n[RMAP_TABLE_RAY]; i++) {
        summary->stops |= UINT32_C(1) << (portion->ray.stop[i] & 31);
        summary->sources |= UINT64_C(1) << ((uint32_t)portion->ray.source[i] & 63);
    }
    uint32_t events = 0;
    for (size_t i = 0; i < n[RMAP_TABLE_SEGMENT]; i++)
        events |= portion->segment.event[i];
    summary->events = events;
    for (size_t i = 0; i < n[RMAP_TABLE_SEGMENT]; i++) {
        uint32_t object = (uint32_t)portion->segment.object[i];
        uint64_t bit = UINT64_C(1) << (object & 63), *bits = &summary->objects[object >> 6 & 3];
        if (portion->segment.object[i] >= 0 && !(*bits & bit)) /* a store waits for the last one */
            *bits |= bit;
    }
    for (size_t i = 0; i < n[RMAP_TABLE_REGISTRATION]; i++)
        summary->detectors |= UINT64_C(1) << ((uint32_t)portion->registration.detector[i] & 63);
    box_add(summary, portion->ray.start, n[RMAP_TABLE_RAY]);
    box_add(summary, portion->segment.position, n[RMAP_TABLE_SEGMENT]);
    box_add(summary, portion->curve.position, n[RMAP_TABLE_CURVE]);
}

void rmap_portion_summary_add(struct rmap_portion_summary *sum,
                              const struct rmap_portion_summary *more)
{
    sum->events |= more->events;
    sum->stops |= more->stops;
    sum->sources |= more->sources;
    sum->detectors |= more->detectors;
    for (size_t i = 0; i < 4; i++)
        sum->objects[i] |= more->objects[i];
    for (size_t i = 0; i < 3; i++) {
        sum->box_min[i] = more->box_min[i] < sum->box_min[i] ? more->box_min[i] : sum->box_min[i];
        sum->box_max[i] = more->box_max[i] > sum->box_max[i] ? more->box_max[i] : sum->box_max[i];
    }
}

/* The logical digest of rays: independent of blocks, order, shards and encoding. A ray's rows are
 * gathered side by side and hashed in one go, which costs less than an update per column; very long
 * rays are hashed column by column, for which XXH3 promises the same value. */

enum { GATHER_NBYTES = 16384 };

/* A column as bytes, with its row size, looked up once per portion. */
struct strip {
    const uint8_t *start;
    size_t row_nbytes;
    enum rmap_table table;
};

static struct rmap_digest from_hash(XXH128_hash_t hash)
{
    return (struct rmap_digest){hash.low64, hash.high64};
}

void rmap_digest_add(struct rmap_digest *sum, struct rmap_digest term)
{
    sum->low += term.low;
    sum->high += term.high + (sum->low < term.low);
}

static struct rmap_digest hash_long(const struct strip *strip, int n_strip, const size_t *first,
                                    const size_t *n)
{
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_128bits_reset(&state);
    for (int c = 0; c < n_strip; c++)
        XXH3_128bits_update(&state, strip[c].start + first[strip[c].table] * strip[c].row_nbytes,
                            n[strip[c].table] * strip[c].row_nbytes);
    return from_hash(XXH3_128bits_digest(&state));
}

static struct rmap_digest hash_ray(const struct strip *strip, int n_strip, const size_t *first,
                                   const size_t *n)
{
    uint8_t bytes[GATHER_NBYTES], *to = bytes;
    for (int c = 0; c < n_strip; c++) {
        size_t row = strip[c].row_nbytes, nbytes = n[strip[c].table] * row;
        if (nbytes == 0)
            continue;
        memcpy(to, strip[c].start + first[strip[c].table] * row, nbytes);
        to += nbytes;
    }
    return from_hash(XXH3_128bits(bytes, (size_t)(to - bytes)));
}

/* Rows of /curve from `first` on that are the ray's: they stand in the order of the rays. */
static size_t curve_rows(const struct rmap_portion *portion, size_t first, uint64_t ray)
{
    size_t n = 0;
    while (first + n < portion->n_row[RMAP_TABLE_CURVE] && portion->curve.ray[first + n] == ray)
        n++;
    return n;
}

struct rmap_digest rmap_portion_digest(const struct rmap_portion *portion)
{
    struct rmap_digest sum = {0, 0};
    struct strip strip[RMAP_COLUMN_COUNT];
    size_t first[RMAP_TABLE_COUNT] = {0}, row_nbytes[RMAP_TABLE_COUNT] = {0};
    /* those of time stand last */
    const int n_strip = portion->timed ? RMAP_COLUMN_COUNT : RMAP_RAY_group_path;
    for (int i = 0; i < n_strip; i++) {
        enum rmap_column c = (enum rmap_column)i;
        strip[i] = (struct strip){rmap_portion_column(portion, c),
                                  rmap_portion_row_nbytes(portion, c), rmap_column_info(c)->table};
        row_nbytes[strip[i].table] += strip[i].row_nbytes;
    }
    for (size_t i = 0; i < portion->n_row[RMAP_TABLE_RAY]; i++) {
        const size_t n[RMAP_TABLE_COUNT] = {
            1, portion->ray.segment_count[i], portion->ray.registration_count[i],
            curve_rows(portion, first[RMAP_TABLE_CURVE], portion->ray.id[i])};
        size_t nbytes = 0;
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            nbytes += n[t] * row_nbytes[t];
        rmap_digest_add(&sum, nbytes <= GATHER_NBYTES ? hash_ray(strip, n_strip, first, n)
                                                      : hash_long(strip, n_strip, first, n));
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            first[t] += n[t];
    }
    return sum;
}

void rmap_digest_text(struct rmap_digest digest, char text[33])
{
    (void)snprintf(text, 33, "%016llx%016llx", (unsigned long long)digest.high,
                   (unsigned long long)digest.low);
}

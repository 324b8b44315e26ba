/* SPDX-License-Identifier: MIT
 *
 * The logical digest of rays: independent of blocks, order, shards and encoding. A ray's rows are
 * gathered side by side and hashed in one go; only very long rays are hashed in pieces, which
 * XXH3 promises to give the same value. Some rays are gathered before the first of them is hashed:
 * bytes that were stored a moment ago cannot be loaded at once.
 */
#include "portion/portion_hash.h"

#include <stdbool.h>
#include <stdio.h>
#include <string.h>

#include "base/wide.h"

#define XXH_INLINE_ALL
#include <xxhash.h>

enum { GATHER_NBYTES = 16384, GATHER_RAYS = 8, LINE = 64 };

/* Rows are copied by so many bytes, over those that follow: most rays have few, and a call per
 * column costs more than they do. */
#define STRIDE 64
typedef uint8_t half __attribute__((vector_size(STRIDE / 2)));

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

static struct rmap_digest hash_long(const struct strip *strip, const size_t *first, const size_t *n)
{
    XXH3_state_t state;
    XXH3_INITSTATE(&state);
    XXH3_128bits_reset(&state);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        XXH3_128bits_update(&state, strip[c].start + first[strip[c].table] * strip[c].row_nbytes,
                            n[strip[c].table] * strip[c].row_nbytes);
    return from_hash(XXH3_128bits_digest(&state));
}

/* Rays side by side, each from the start of a cache line on. */
struct gathered {
    _Alignas(LINE) uint8_t bytes[GATHER_NBYTES + GATHER_RAYS * LINE + STRIDE];
    size_t used;
    int n_ray;
    struct {
        const uint8_t *start;
        size_t nbytes;
    } ray[GATHER_RAYS];
};

static uint8_t *gather_rows(const struct strip *strip, int first_column, int end_column,
                            const size_t *first, const size_t *n, uint8_t *to)
{
    for (int c = first_column; c < end_column; c++) {
        size_t row = strip[c].row_nbytes, nbytes = n[strip[c].table] * row;
        memcpy(to, strip[c].start + first[strip[c].table] * row, nbytes);
        to += nbytes;
    }
    return to;
}

/* Rows that STRIDE more follow; and up to STRIDE bytes behind `to`. */
static inline uint8_t *copy_over(const void *from, size_t nbytes, uint8_t *to)
{
    const uint8_t *p = from;
    for (size_t k = 0; k < nbytes; k += STRIDE) {
        half low, high;
        memcpy(&low, p + k, sizeof low);
        memcpy(&high, p + k + sizeof low, sizeof high);
        memcpy(to + k, &low, sizeof low);
        memcpy(to + k + sizeof low, &high, sizeof high);
    }
    return to + nbytes;
}

/* n rows from `first` on, which STRIDE more follow: sizes are constant. */
static inline uint8_t *gather_legs(const struct rmap_portion *portion, size_t first, size_t n,
                                   uint8_t *to)
{
#define COPY(field, path, type, element, width, unit, text)                                        \
    to = copy_over(portion->segment.field + first * (width), n * (width) * sizeof(type), to);
    RMAP_SEGMENT_COLUMNS(COPY)
#undef COPY
    return to;
}

static inline uint8_t *gather_registrations(const struct rmap_portion *portion, size_t first,
                                            size_t n, uint8_t *to)
{
#define COPY(field, path, type, element, width, unit, text)                                        \
    to = copy_over(portion->registration.field + first * (width), n * (width) * sizeof(type), to);
    RMAP_REGISTRATION_COLUMNS(COPY)
#undef COPY
    return to;
}

static inline uint8_t *gather_colours(const struct rmap_portion *portion, size_t first, size_t n,
                                      uint8_t *to)
{
    size_t row = (size_t)portion->n_channel * sizeof *portion->colour;
    return copy_over((const uint8_t *)portion->colour + first * row, n * row, to);
}

/* Whether so many rows and STRIDE more are there. */
static inline bool has_room(const struct rmap_portion *portion, enum rmap_table table,
                            const size_t *first, const size_t *n)
{
    return portion->n_row[table] - first[table] >= n[table] + STRIDE;
}

/* The one row of /ray is copied by constant sizes, which costs a few moves in place of a call
 * per column. */
RMAP_WIDE
static void gather_ray(const struct rmap_portion *portion, size_t ray, const struct strip *strip,
                       const size_t *first, const size_t *n, struct gathered *all)
{
    uint8_t *start = all->bytes + all->used, *to = start;
#define PUT(field, path, type, element, width, unit, text)                                         \
    memcpy(to, portion->ray.field + ray * (width), (width) * sizeof(type));                        \
    to += (width) * sizeof(type);
    RMAP_RAY_COLUMNS(PUT)
#undef PUT
    size_t leg = first[RMAP_TABLE_SEGMENT], n_leg = n[RMAP_TABLE_SEGMENT];
    bool room = has_room(portion, RMAP_TABLE_SEGMENT, first, n);
    to = room ? gather_legs(portion, leg, n_leg, to)
              : gather_rows(strip, RMAP_SEGMENT_object, RMAP_REGISTRATION_segment, first, n, to);
    if (n[RMAP_TABLE_REGISTRATION] == 0)
        ; /* most rays, in most scenes */
    else if (has_room(portion, RMAP_TABLE_REGISTRATION, first, n))
        to = gather_registrations(portion, first[RMAP_TABLE_REGISTRATION],
                                  n[RMAP_TABLE_REGISTRATION], to);
    else
        to = gather_rows(strip, RMAP_REGISTRATION_segment, RMAP_SEGMENT_colour, first, n, to);
    to = room ? gather_colours(portion, leg, n_leg, to)
              : gather_rows(strip, RMAP_SEGMENT_colour, RMAP_CURVE_ray, first, n, to);
    if (n[RMAP_TABLE_CURVE] > 0)
        to = gather_rows(strip, RMAP_CURVE_ray, RMAP_COLUMN_COUNT, first, n, to);
    all->ray[all->n_ray].start = start;
    all->ray[all->n_ray++].nbytes = (size_t)(to - start);
    all->used += ((size_t)(to - start) + LINE - 1) / LINE * LINE;
}

static void hash_gathered(struct gathered *all, rmap_hash_function *hash, struct rmap_digest *sum)
{
    for (int i = 0; i < all->n_ray; i++)
        rmap_digest_add(sum, hash(all->ray[i].start, all->ray[i].nbytes));
    all->used = 0;
    all->n_ray = 0;
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
    rmap_hash_function *hash = rmap_hash_fastest();
    struct rmap_digest sum = {0, 0};
    struct gathered all;
    all.used = 0;
    all.n_ray = 0;
    struct strip strip[RMAP_COLUMN_COUNT];
    size_t first[RMAP_TABLE_COUNT] = {0}, row_nbytes[RMAP_TABLE_COUNT] = {0};
    for (int i = 0; i < RMAP_COLUMN_COUNT; i++) {
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
        if (all.n_ray == GATHER_RAYS || all.used + nbytes > GATHER_NBYTES)
            hash_gathered(&all, hash, &sum);
        if (nbytes <= GATHER_NBYTES)
            gather_ray(portion, i, strip, first, n, &all);
        else
            rmap_digest_add(&sum, hash_long(strip, first, n));
        for (int t = 0; t < RMAP_TABLE_COUNT; t++)
            first[t] += n[t];
    }
    hash_gathered(&all, hash, &sum);
    return sum;
}

void rmap_digest_text(struct rmap_digest digest, char text[33])
{
    (void)snprintf(text, 33, "%016llx%016llx", (unsigned long long)digest.high,
                   (unsigned long long)digest.low);
}

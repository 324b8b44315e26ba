/* SPDX-License-Identifier: MIT
 *
 * Classes of segments, of all rays of a portion or of some.
 */
#include <string.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/wide.h"
#include "history/history_gather.h"
#include "history/history_parts.h"

/* Classes by code, and what tells those of the codes that rare ones share. */
struct class_codes {
    uint16_t class_of[256];
    uint32_t n_common;
    const uint64_t *rare;
};

static struct class_codes class_codes(const struct rmap_history_view *view)
{
    struct class_codes codes = {.n_common = view->rows->shape.n_common,
                                .rare = rmap_history_rare_segments(view)};
    for (uint32_t k = 0; k < codes.n_common; k++)
        codes.class_of[k] = view->local_class[k];
    return codes;
}

static inline uint16_t class_at(const struct rmap_history_view *view,
                                const struct class_codes *codes, size_t segment)
{
    uint8_t code = view->rows->code[segment];
    return code < codes->n_common || !codes->rare
               ? codes->class_of[code]
               : view->local_class[rmap_history_rare_at(view, codes->rare, segment)];
}

void rmap_history_row_classes(const struct rmap_history_view *view, uint16_t *row_class)
{
    const struct class_codes codes = class_codes(view);
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_SEGMENT]; i++)
        row_class[i] = class_at(view, &codes, i);
}

/* Where segments and registrations of each of n rays begin, registrations in the upper half;
 * returns where the next ones do. */
static inline uint64_t place_block(const uint32_t *segments, const uint32_t *hits, size_t n,
                                   uint64_t at, uint64_t *begin)
{
    RMAP_UNROLL
    for (size_t i = 0; i < n; i++) {
        begin[i] = at;
        at += segments[i] | (uint64_t)hits[i] << 32;
    }
    return at;
}

size_t rmap_history_place_rays(const struct rmap_history_view *view, const uint64_t *bits,
                               struct rmap_history_place_of_ray *ray)
{
    enum { BLOCK = 64 };
    const size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    const bool has_hits = view->registration_count != NULL;
    const uint32_t *segments = view->segment_count,
                   *hits = has_hits ? view->registration_count : segments;
    uint64_t at = 0, begin[BLOCK];
    size_t n = 0;
    for (size_t first = 0; first < n_ray; first += BLOCK) {
        size_t few = n_ray - first < BLOCK ? n_ray - first : BLOCK;
        at = place_block(segments + first, hits + first, few, at, begin);
        for (uint64_t left = bits[first / BLOCK]; left != 0; left &= left - 1) {
            size_t i = (size_t)__builtin_ctzll(left);
            ray[n++] =
                (struct rmap_history_place_of_ray){(uint32_t)(first + i), (uint32_t)begin[i],
                                                   has_hits ? (uint32_t)(begin[i] >> 32) : 0};
        }
    }
    return n;
}

/* Far segments of registrations before one of them, counted on from an earlier one. */
struct far_walk {
    size_t at;
    uint32_t n;
};

static uint32_t far_before(const struct rmap_history_rows *rows, struct far_walk *walk, size_t hit)
{
    for (; rows->shape.n_far > 0 && walk->at < hit; walk->at++)
        walk->n += rows->segment[walk->at] == UINT8_MAX;
    return walk->n;
}

/* The segment on which a registration happened; later ones must be asked for after earlier ones. */
static uint32_t segment_of_hit(const struct rmap_history_rows *rows, struct far_walk *walk,
                               size_t hit)
{
    uint32_t segment = rows->segment[hit];
    return segment == UINT8_MAX && far_before(rows, walk, hit) < rows->shape.n_far
               ? rows->far[walk->n]
               : segment;
}

static void copy_hits(const struct rmap_history_view *view, struct far_walk *walk, size_t first,
                      uint32_t n, struct rmap_portion *out)
{
    const struct rmap_history_rows *rows = view->rows;
    for (size_t i = first; i < first + n; i++) {
        size_t to = out->n_row[RMAP_TABLE_REGISTRATION]++;
        const struct rmap_history_hit *hit =
            &view->index->hit[rmap_history_number(rows->hit, rows->shape.hit_nbytes, i)];
        out->registration.detector[to] = hit->detector;
        out->registration.registered[to] = (uint8_t)hit->registered;
        out->registration.segment[to] = segment_of_hit(rows, walk, i);
    }
}

void rmap_history_gather(const struct rmap_history_view *view,
                         const struct rmap_history_place_of_ray *ray, size_t n,
                         struct rmap_portion *out, uint16_t *row_class)
{
    const struct class_codes codes = class_codes(view);
    struct far_walk walk = {0};
    out->n_row[RMAP_TABLE_REGISTRATION] = 0;
    for (size_t k = 0; k < n; k++) {
        uint32_t n_segment = view->segment_count[ray[k].ray];
        uint32_t n_hit = view->registration_count ? view->registration_count[ray[k].ray] : 0;
        for (size_t segment = ray[k].segment; segment < (size_t)ray[k].segment + n_segment;
             segment++)
            *row_class++ = class_at(view, &codes, segment);
        copy_hits(view, &walk, ray[k].registration, n_hit, out);
        out->ray.segment_count[k] = n_segment;
        out->ray.registration_count[k] = n_hit;
    }
    out->n_row[RMAP_TABLE_RAY] = n;
}

/* The discrete columns of a portion from its index. */

static bool asked(rmap_column_set columns, enum rmap_column column)
{
    return (columns & RMAP_COLUMN_BIT(column)) != 0;
}

static enum rmap_status reserve(const struct rmap_history_view *view, rmap_column_set columns,
                                struct rmap_portion *out, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    rmap_portion_clear(out);
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        RMAP_TRY(rmap_portion_reserve(out, (enum rmap_table)t, view->n_row[t], columns, err));
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        out->n_row[t] = view->n_row[t];
    out->first_ray = view->first_ray;
out:
    return st;
}

static enum rmap_status does_not_add_up(const struct rmap_history_view *view,
                                        struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT,
                          "the history index is damaged: the rays from id %llu on do not add up",
                          (unsigned long long)view->first_ray);
}

/* ---- ROWS ---- */

static void unfold_rays(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    memcpy(out->ray.segment_count, view->segment_count, n_ray * sizeof(uint32_t));
    if (view->registration_count)
        memcpy(out->ray.registration_count, view->registration_count, n_ray * sizeof(uint32_t));
    else
        memset(out->ray.registration_count, 0, n_ray * sizeof(uint32_t));
    for (size_t i = 0; asked(columns, RMAP_RAY_source) && i < n_ray; i++)
        out->ray.source[i] = view->kind_source[view->kind ? view->kind[i] : 0];
    for (size_t i = 0; asked(columns, RMAP_RAY_stop) && i < n_ray; i++)
        out->ray.stop[i] = view->kind_stop[view->kind ? view->kind[i] : 0];
}

static void unfold_rare_segments(const struct rmap_history_view *view, rmap_column_set columns,
                                 struct rmap_portion *out)
{
    const uint64_t *rare = rmap_history_rare_segments(view);
    const struct rmap_step_class *what = view->index->class_of;
    for (size_t w = 0; rare && w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rare[w]; left != 0; left &= left - 1) {
            size_t segment = w * 64 + (size_t)__builtin_ctzll(left);
            const struct rmap_step_class *is =
                &what[view->local_class[rmap_history_rare_at(view, rare, segment)]];
            if (asked(columns, RMAP_SEGMENT_object))
                out->segment.object[segment] = is->object;
            if (asked(columns, RMAP_SEGMENT_event))
                out->segment.event[segment] = is->event;
            if (asked(columns, RMAP_SEGMENT_medium))
                out->segment.medium[segment] = (int16_t)is->medium;
        }
}

/* What the classes with codes are, then each segment's, then the rare ones. */
static void unfold_segments(const struct rmap_history_view *view, rmap_column_set columns,
                            struct rmap_portion *out)
{
    const uint8_t *code = view->rows->code;
    const struct rmap_step_class *what = view->index->class_of;
    bool object = asked(columns, RMAP_SEGMENT_object), event = asked(columns, RMAP_SEGMENT_event);
    bool medium = asked(columns, RMAP_SEGMENT_medium);
    struct {
        int32_t object[256];
        uint32_t event[256];
        int16_t medium[256];
    } of = {{0}, {0}, {0}};
    size_t n = view->n_row[RMAP_TABLE_SEGMENT];
    if (!object && !event && !medium)
        return;
    for (uint32_t k = 0; k < view->rows->shape.n_common; k++) {
        of.object[k] = what[view->local_class[k]].object;
        of.event[k] = what[view->local_class[k]].event;
        of.medium[k] = (int16_t)what[view->local_class[k]].medium;
    }
    for (size_t i = 0; object && i < n; i++)
        out->segment.object[i] = of.object[code[i]];
    for (size_t i = 0; event && i < n; i++)
        out->segment.event[i] = of.event[code[i]];
    for (size_t i = 0; medium && i < n; i++)
        out->segment.medium[i] = of.medium[code[i]];
    unfold_rare_segments(view, columns, out);
}

static bool unfold_hits(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_hit *what = view->index->hit;
    unsigned nbytes = rows->shape.hit_nbytes;
    size_t n = view->n_row[RMAP_TABLE_REGISTRATION];
    for (size_t i = 0; asked(columns, RMAP_REGISTRATION_detector) && i < n; i++)
        out->registration.detector[i] = what[rmap_history_number(rows->hit, nbytes, i)].detector;
    for (size_t i = 0; asked(columns, RMAP_REGISTRATION_registered) && i < n; i++)
        out->registration.registered[i] =
            (uint8_t)what[rmap_history_number(rows->hit, nbytes, i)].registered;
    return !asked(columns, RMAP_REGISTRATION_segment) ||
           rmap_history_widen(rows->segment, n, rows->far, rows->shape.n_far,
                              out->registration.segment);
}

/* ---- PATHS ---- */

static bool paths_add_up(const struct rmap_history_view *view)
{
    const struct rmap_portion *paths = view->index->paths;
    uint64_t n_segment = 0, n_registration = 0;
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_RAY]; i++) {
        size_t path = view->path_row[view->path[i]];
        n_segment += paths->ray.segment_count[path];
        n_registration += paths->ray.registration_count[path];
    }
    return n_segment == view->n_row[RMAP_TABLE_SEGMENT] &&
           n_registration == view->n_row[RMAP_TABLE_REGISTRATION];
}

/* A column of the rows of a ray after those of the other, from the dictionary. */
static void unfold_column(const struct rmap_history_view *view, enum rmap_column column,
                          struct rmap_portion *out)
{
    const struct rmap_history_index *index = view->index;
    const struct rmap_portion *paths = index->paths;
    enum rmap_table table = rmap_column_info(column)->table;
    size_t row = rmap_portion_row_nbytes(paths, column);
    const char *from = rmap_portion_column(paths, column);
    char *to = rmap_portion_column(out, column);
    const uint32_t *first =
        table == RMAP_TABLE_SEGMENT ? index->path_segment : index->path_registration;
    const uint32_t *count =
        table == RMAP_TABLE_SEGMENT ? paths->ray.segment_count : paths->ray.registration_count;
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_RAY]; i++) {
        size_t path = view->path_row[view->path[i]];
        size_t nbytes = row * (table == RMAP_TABLE_RAY ? 1 : count[path]);
        memcpy(to, from + row * (table == RMAP_TABLE_RAY ? path : first[path]), nbytes);
        to += nbytes;
    }
}

static enum rmap_status unfold_paths(const struct rmap_history_view *view, rmap_column_set columns,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    if (!paths_add_up(view))
        return does_not_add_up(view, err);
    for (int c = 0; c < RMAP_COLUMN_COUNT; c++)
        if (asked(columns, (enum rmap_column)c))
            unfold_column(view, (enum rmap_column)c, out);
    return RMAP_OK;
}

enum rmap_status rmap_history_unfold(const struct rmap_history_view *view, rmap_column_set columns,
                                     struct rmap_portion *out, struct rmap_error *err)
{
    columns = (columns & RMAP_COLUMNS_DISCRETE) | RMAP_COLUMN_BIT(RMAP_RAY_segment_count) |
              RMAP_COLUMN_BIT(RMAP_RAY_registration_count);
    enum rmap_status st = reserve(view, columns, out, err);
    if (st != RMAP_OK)
        return st;
    if (view->form == RMAP_HISTORY_PATHS)
        return unfold_paths(view, columns, out, err);
    unfold_rays(view, columns, out);
    unfold_segments(view, columns, out);
    return unfold_hits(view, columns, out) ? RMAP_OK : does_not_add_up(view, err);
}

/* Segments whose class is wanted, as a bit each. A set that was marked in this portion is not
 * marked again. */

/* Rare segments of the set: a bit for each more. What is stored may be shorter than it should, or
 * name classes that are not there: damage that a checksum hides. */
static void mark_rare(const struct rmap_history_view *view, const uint8_t *wanted, uint64_t *mark)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    const uint64_t *rare = rmap_history_rare_segments(view);
    size_t n = 0, n_word = rmap_bit_words(view->n_row[RMAP_TABLE_SEGMENT]);
    for (size_t w = 0; rare && w < n_word; w++)
        for (uint64_t left = rare[w]; left != 0 && n < shape->n_rare; left &= left - 1, n++) {
            size_t segment = w * 64 + (size_t)__builtin_ctzll(left);
            uint32_t k = rmap_history_rare_class(shape, rows->code[segment], rows->rare[n]);
            if (k < shape->n_local && wanted[view->local_class[k]])
                mark[w] |= left & (0 - left);
        }
}

/* False: there is no such segment. */
static bool mark_segments(const struct rmap_history_view *view, const uint8_t *wanted,
                          uint64_t *mark)
{
    const struct rmap_history_shape *shape = &view->rows->shape;
    uint8_t member[256] = {0};
    bool common = false, rare = false;
    for (uint32_t k = 0; k < shape->n_common; k++)
        common |= (member[k] = wanted[view->local_class[k]]) != 0;
    for (uint32_t k = shape->n_common; k < shape->n_local; k++)
        rare |= wanted[view->local_class[k]] != 0;
    if (common || rare)
        rmap_byte_set_bits(view->rows->code, view->n_row[RMAP_TABLE_SEGMENT], member, mark);
    if (rare)
        mark_rare(view, wanted, mark);
    return common || rare;
}

const uint64_t *rmap_history_mark(const struct rmap_history_view *view, const uint8_t *wanted)
{
    struct rmap_history_sets *sets = &view->rows->sets;
    const size_t n_class = sets->n_class;
    size_t s = 0, n = sets->n < RMAP_HISTORY_SET_MAX ? sets->n : RMAP_HISTORY_SET_MAX;
    while (s < n && memcmp(sets->wanted + s * n_class, wanted, n_class) != 0)
        s++;
    if (s == n) { /* in the place of the oldest */
        s = sets->n++ % RMAP_HISTORY_SET_MAX;
        memcpy(sets->wanted + s * n_class, wanted, n_class);
        sets->any[s] = mark_segments(view, wanted, sets->mark + s * rmap_history_mark_words(view));
    }
    return sets->any[s] ? sets->mark + s * rmap_history_mark_words(view) : NULL;
}

enum rmap_status rmap_history_sets_enter(struct rmap_history_view *view, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_sets *sets = &view->rows->sets;
    sets->n = 0;
    sets->n_class = view->index->n_class;
    RMAP_TRY(RMAP_RESERVE(sets->wanted, sets->cap_wanted, RMAP_HISTORY_SET_MAX * sets->n_class + 1,
                          err));
    RMAP_TRY(RMAP_RESERVE(sets->mark, sets->cap_mark,
                          RMAP_HISTORY_SET_MAX * rmap_history_mark_words(view), err));
out:
    return st;
}

void rmap_history_sets_fini(struct rmap_history_sets *sets)
{
    rmap_free(sets->wanted);
    rmap_free(sets->mark);
    *sets = (struct rmap_history_sets){0};
}

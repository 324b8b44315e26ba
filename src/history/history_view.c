/* SPDX-License-Identifier: MIT
 *
 * Opens a portion of an index: its bytes are taken as they are where that is possible, and checked
 * as far as memory safety takes.
 */
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "history/history_parts.h"
#include "trace/event.h"

#if defined(__GNUC__) && !defined(__clang__) && defined(__x86_64__) && defined(__OPTIMIZE__)
#define WIDE __attribute__((target_clones("avx2", "popcnt", "default")))
#else
#define WIDE
#endif

static enum rmap_status bad(const struct rmap_history_view *view, struct rmap_error *err)
{
    return rmap_error_set(err, RMAP_FORMAT,
                          "the history index is damaged where it holds the %zu rays from ray %llu "
                          "on",
                          view->n_row[RMAP_TABLE_RAY], (unsigned long long)view->first_ray);
}

/* *bytes_ret: of the portion, in memory. */
static enum rmap_status fetch(const struct rmap_history_index *index,
                              const struct rmap_history_place *place,
                              struct rmap_history_view *view, const uint8_t **bytes_ret,
                              struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    *bytes_ret = index->body.bytes ? index->body.bytes + place->offset : NULL;
    if (!*bytes_ret) {
        void *block = rows->bytes;
        enum rmap_status st = rmap_reserve(&block, &rows->cap_bytes, place->nbytes, 1, err);
        rows->bytes = block;
        if (st == RMAP_OK)
            st = index->body.read(index->body.context, place->offset, place->nbytes, rows->bytes,
                                  err);
        if (st != RMAP_OK)
            return st;
        *bytes_ret = rows->bytes;
    }
    return XXH3_64bits(*bytes_ret, place->nbytes) == place->checksum ? RMAP_OK : bad(view, err);
}

WIDE static bool all_below_u16(const uint16_t *number, size_t n, uint32_t limit)
{
    uint16_t most = 0;
    for (size_t i = 0; i < n; i++)
        most = number[i] > most ? number[i] : most;
    return n == 0 || most < limit;
}

WIDE static bool all_below_u32(const uint32_t *number, size_t n, size_t limit)
{
    uint32_t most = 0;
    for (size_t i = 0; i < n; i++)
        most = number[i] > most ? number[i] : most;
    return n == 0 || most < limit;
}

/* One bit for each ray, the last on the last leg: then no leg belongs to a ray that is not there.
 */
WIDE static bool ends_hold(const uint64_t *end, size_t n_segment, size_t n_ray)
{
    uint64_t n = 0, last = n_segment - 1;
    for (size_t w = 0; w < n_segment / 64 + 1; w++)
        n += (uint64_t)__builtin_popcountll(end[w]);
    return n == n_ray && end[last / 64] >> last % 64 == 1 &&
           (last / 64 == n_segment / 64 || end[n_segment / 64] == 0);
}

/* Counts of a byte as 32 bits; 255 stands for the next of the long ones. */
WIDE static bool widen_counts(const uint8_t *byte, size_t n, const uint32_t *longer,
                              uint32_t n_longer, uint32_t *count, uint64_t *sum_ret)
{
    uint64_t sum = 0;
    uint32_t used = 0;
    for (size_t i = 0; i < n; i++)
        count[i] = byte[i];
    for (size_t i = 0; n_longer > 0 && i < n; i++)
        if (byte[i] == UINT8_MAX) {
            if (used == n_longer)
                return false;
            count[i] = longer[used++];
        }
    for (size_t i = 0; i < n; i++)
        sum += count[i];
    *sum_ret = sum;
    return used == n_longer;
}

static enum rmap_status reserve(struct rmap_history_view *view, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_rows *rows = view->rows;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    void *segments = rows->segment_count, *registrations = rows->registration_count;
    void *kind = rows->kind, *mark = rows->mark;
    RMAP_TRY(rmap_reserve(&segments, &rows->cap_segment_count, n_ray, sizeof(uint32_t), err));
    RMAP_TRY(
        rmap_reserve(&registrations, &rows->cap_registration_count, n_ray, sizeof(uint32_t), err));
    RMAP_TRY(rmap_reserve(&kind, &rows->cap_kind, n_ray, sizeof(uint16_t), err));
    RMAP_TRY(rmap_reserve(&mark, &rows->cap_mark, 2 * rmap_history_mark_words(view),
                          sizeof(uint64_t), err));
out:
    rows->segment_count = segments;
    rows->registration_count = registrations;
    rows->kind = kind;
    rows->mark = mark;
    return st;
}

static enum rmap_status open_paths(struct rmap_history_view *view,
                                   const struct rmap_history_shape *shape, const uint8_t *bytes,
                                   const uint64_t *at, struct rmap_error *err)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    view->n_path = shape->n_path;
    view->path_row = (const void *)(bytes + at[RMAP_PART_PATH_ROW]);
    view->path_rays = (const void *)(bytes + at[RMAP_PART_PATH_RAYS]);
    view->path = (const void *)(bytes + at[RMAP_PART_PATH]);
    uint64_t n = 0, n_segment = 0, n_registration = 0;
    const struct rmap_portion *paths = view->index->paths;
    if (!all_below_u16(view->path, n_ray, shape->n_path) ||
        !all_below_u32(view->path_row, view->n_path, paths->n_row[RMAP_TABLE_RAY]))
        return bad(view, err);
    for (size_t k = 0; k < view->n_path; k++) {
        n += view->path_rays[k];
        n_segment += (uint64_t)view->path_rays[k] * paths->ray.segment_count[view->path_row[k]];
        n_registration +=
            (uint64_t)view->path_rays[k] * paths->ray.registration_count[view->path_row[k]];
    }
    return n == n_ray && n_segment == view->n_row[RMAP_TABLE_SEGMENT] &&
                   n_registration == view->n_row[RMAP_TABLE_REGISTRATION]
               ? RMAP_OK
               : bad(view, err);
}

/* Rays: their kinds, legs and registrations. */
static bool open_rays(struct rmap_history_view *view, const uint8_t *bytes, const uint64_t *at)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    uint64_t n_segment = 0, n_registration = 0;
    view->n_kind = shape->n_kind;
    view->kind_source = (const void *)(bytes + at[RMAP_PART_KIND_SOURCE]);
    view->kind_stop = bytes + at[RMAP_PART_KIND_STOP];
    view->kind = shape->kind_nbytes > 0 ? rows->kind : NULL;
    bool good = shape->n_kind > 0;
    for (size_t i = 0; view->kind && i < n_ray; i++)
        rows->kind[i] =
            (uint16_t)rmap_history_number(bytes + at[RMAP_PART_KIND], shape->kind_nbytes, i);
    good = good && (!view->kind || all_below_u16(view->kind, n_ray, shape->n_kind));
    for (size_t k = 0; k < view->n_kind; k++)
        good &= view->kind_source[k] >= 0 && (size_t)view->kind_source[k] < view->index->n_source &&
                view->kind_stop[k] < RMAP_STOP_COUNT;
    view->segment_count = rows->segment_count;
    good = good && widen_counts(bytes + at[RMAP_PART_COUNT], n_ray,
                                (const void *)(bytes + at[RMAP_PART_LONG]), shape->n_long,
                                rows->segment_count, &n_segment);
    if (view->n_row[RMAP_TABLE_REGISTRATION] > 0) {
        view->registration_count = rows->registration_count;
        good = good && widen_counts(bytes + at[RMAP_PART_HITS], n_ray,
                                    (const void *)(bytes + at[RMAP_PART_MANY]), shape->n_many,
                                    rows->registration_count, &n_registration);
    }
    return good && n_segment == view->n_row[RMAP_TABLE_SEGMENT] &&
           n_registration == view->n_row[RMAP_TABLE_REGISTRATION];
}

/* Legs and registrations: their classes. */
static bool open_legs(struct rmap_history_view *view, const uint8_t *bytes, const uint64_t *at)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    size_t n_segment = view->n_row[RMAP_TABLE_SEGMENT];
    view->n_local = shape->n_local;
    view->local_class = (const void *)(bytes + at[RMAP_PART_LOCAL_CLASS]);
    view->local_rows = (const void *)(bytes + at[RMAP_PART_LOCAL_ROWS]);
    rows->code = bytes + at[RMAP_PART_CODE];
    rows->rare = (const void *)(bytes + at[RMAP_PART_RARE]);
    rows->end = (const void *)(bytes + at[RMAP_PART_END]);
    rows->hit = bytes + at[RMAP_PART_HIT];
    rows->leg = bytes + at[RMAP_PART_LEG];
    bool good = all_below_u16(view->local_class, view->n_local, (uint32_t)view->index->n_class) &&
                all_below_u16(rows->rare, shape->n_rare, shape->n_local);
    uint64_t n_listed = 0;
    for (size_t k = 0; k < view->n_local; k++)
        n_listed += view->local_rows[k];
    good = good && n_listed == n_segment;
    size_t n_hit = view->n_row[RMAP_TABLE_REGISTRATION];
    if (shape->hit_nbytes == 0 && n_hit > 0)
        n_hit = 1;
    for (size_t i = 0; good && i < n_hit; i++)
        good = rmap_history_number(rows->hit, shape->hit_nbytes, i) < view->index->n_hit;
    return good;
}

static bool shape_holds(const struct rmap_history_shape *shape)
{
    bool widths = shape->kind_nbytes <= 2 && shape->hit_nbytes <= 2 &&
                  (shape->leg_nbytes == 1 || shape->leg_nbytes == 2 || shape->leg_nbytes == 4);
    return widths && shape->n_common <= shape->n_local && shape->n_common <= RMAP_HISTORY_RARE &&
           shape->n_kind <= RMAP_HISTORY_CLASS_MAX && shape->n_local <= RMAP_HISTORY_CLASS_MAX &&
           shape->n_path <= RMAP_HISTORY_RAY_MAX;
}

static enum rmap_status open_form(struct rmap_history_view *view,
                                  const struct rmap_history_place *place, const uint8_t *bytes,
                                  struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    struct rmap_history_shape *shape = &rows->shape;
    struct rmap_history_layout layout;
    memcpy(shape, bytes, sizeof *shape);
    rmap_history_arrange(place, shape, &layout);
    if (layout.at[RMAP_PART_COUNT_OF] != place->nbytes)
        return bad(view, err);
    if (place->has_relative)
        view->relative = (const void *)(bytes + layout.at[RMAP_PART_RELATIVE]);
    if (place->form == RMAP_HISTORY_PATHS)
        return open_paths(view, shape, bytes, layout.at, err);
    enum rmap_status st = shape_holds(shape) ? reserve(view, err) : bad(view, err);
    if (st != RMAP_OK)
        return st;
    if (!open_rays(view, bytes, layout.at) || !open_legs(view, bytes, layout.at))
        return bad(view, err);
    /* Rays without a leg have no end: their legs are found by counting. */
    size_t n_segment = view->n_row[RMAP_TABLE_SEGMENT];
    if (n_segment == 0 || !ends_hold(rows->end, n_segment, view->n_row[RMAP_TABLE_RAY]))
        rows->end = NULL;
    return RMAP_OK;
}

enum rmap_status rmap_history_view_open(const struct rmap_history_index *index, size_t portion,
                                        struct rmap_history_view *view, struct rmap_error *err)
{
    const struct rmap_history_place *place = &index->place[portion];
    const uint8_t *bytes = NULL;
    struct rmap_history_rows *rows = view->rows ? view->rows : rmap_alloc(1, sizeof *rows);
    *view = (struct rmap_history_view){.index = index,
                                       .form = (enum rmap_history_form)place->form,
                                       .first_ray = place->first_ray,
                                       .unit_weight = place->unit_weight == 1,
                                       .nbytes = place->nbytes,
                                       .rows = rows};
    if (!rows)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    for (int t = 0; t < RMAP_TABLE_COUNT; t++)
        view->n_row[t] = place->n_row[t];
    enum rmap_status st = fetch(index, place, view, &bytes, err);
    return st == RMAP_OK ? open_form(view, place, bytes, err) : st;
}

void rmap_history_view_fini(struct rmap_history_view *view)
{
    if (view->rows) {
        rmap_free(view->rows->bytes);
        rmap_free(view->rows->segment_count);
        rmap_free(view->rows->registration_count);
        rmap_free(view->rows->kind);
        rmap_free(view->rows->mark);
        rmap_free(view->rows);
    }
    *view = (struct rmap_history_view){0};
}

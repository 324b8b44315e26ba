/* SPDX-License-Identifier: MIT
 *
 * Opens a portion of an index: its bytes are taken as they are where that is possible, and checked
 * as far as memory safety takes.
 */
#include <string.h>
#include <xxhash.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/count.h"
#include "history/history_parts.h"
#include "history/history_view.h"
#include "portion/event.h"

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

static enum rmap_status reserve_made(struct rmap_history_rows *rows, uint64_t nbytes,
                                     struct rmap_error *err)
{
    void *block = rows->own;
    enum rmap_status st = rmap_reserve(&block, &rows->cap_own, nbytes, 1, err);
    rows->made = rows->own = block;
    return st;
}

/* *bytes_ret: of the portion, in memory; read ones are the first of what is made. */
static enum rmap_status fetch(const struct rmap_history_index *index,
                              const struct rmap_history_place *place,
                              struct rmap_history_view *view, const uint8_t **bytes_ret,
                              struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_body *body = &index->body;
    const uint64_t nbytes = body->bytes ? 0 : place->nbytes;
    enum rmap_status st = reserve_made(rows, sizeof *rows->made + nbytes, err);
    if (st == RMAP_OK && nbytes > 0)
        st = body->read(body->context, place->offset, nbytes, rows->made + 1, err);
    if (st != RMAP_OK)
        return st;
    *bytes_ret = nbytes > 0 ? (const uint8_t *)(rows->made + 1) : body->bytes + place->offset;
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

/* Numbers of 8 and of 4 bits; how many of them are the largest, which stands for a longer one. */
WIDE static uint32_t widen_bytes(const uint8_t *byte, size_t n, uint32_t *count)
{
    uint32_t n_largest = 0;
    for (size_t i = 0; i < n; i++) {
        count[i] = byte[i];
        n_largest += byte[i] == UINT8_MAX;
    }
    return n_largest;
}

WIDE static uint32_t widen_halves(const uint8_t *byte, size_t n, uint32_t *count)
{
    uint32_t n_largest = 0;
    for (size_t i = 0; i < n / 2; i++) {
        count[2 * i] = byte[i] & 15;
        count[2 * i + 1] = byte[i] >> 4;
    }
    if (n % 2)
        count[n - 1] = byte[n / 2] & 15;
    for (size_t i = 0; i < n; i++)
        n_largest += count[i] == 15;
    return n_largest;
}

static void put_longer(const uint32_t *longer, uint32_t largest, size_t n, uint32_t *count)
{
    for (size_t i = 0; i < n; i++)
        if (count[i] == largest)
            count[i] = *longer++;
}

bool rmap_history_widen(const uint8_t *byte, size_t n, const uint32_t *longer, uint32_t n_longer,
                        uint32_t *count)
{
    if (widen_bytes(byte, n, count) != n_longer)
        return false;
    if (n_longer > 0)
        put_longer(longer, UINT8_MAX, n, count);
    return true;
}

static enum rmap_status reserve_marks(struct rmap_history_view *view, struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    enum rmap_status st =
        RMAP_RESERVE(rows->mark_hit, rows->cap_mark_hit, rmap_history_hit_words(view), err);
    if (st == RMAP_OK && view->form == RMAP_HISTORY_ROWS)
        st = rmap_history_sets_enter(view, err);
    return st;
}

/* Where arrays stand in what was made. */
static void point_made(struct rmap_history_rows *rows, const uint64_t *at)
{
    uint8_t *block = (uint8_t *)rows->made;
    rows->segment_count = (void *)(block + at[RMAP_MADE_SEGMENT_COUNT]);
    rows->registration_count = (void *)(block + at[RMAP_MADE_REGISTRATION_COUNT]);
    rows->kind = (void *)(block + at[RMAP_MADE_KIND]);
    rows->local_rows = (void *)(block + at[RMAP_MADE_LOCAL_ROWS]);
    rows->rare_mark = (void *)(block + at[RMAP_MADE_RARE_MARK]);
    rows->rank = (void *)(block + at[RMAP_MADE_RANK]);
}

/* Where arrays stand in the bytes. */
static void point_bytes(struct rmap_history_view *view, const struct rmap_history_place *place,
                        const uint8_t *bytes, const uint64_t *at)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    view->relative = place->has_relative ? (const void *)(bytes + at[RMAP_PART_RELATIVE]) : NULL;
    if (place->form == RMAP_HISTORY_PATHS) {
        view->n_path = shape->n_path;
        view->path_row = (const void *)(bytes + at[RMAP_PART_PATH_ROW]);
        view->path_rays = (const void *)(bytes + at[RMAP_PART_PATH_RAYS]);
        view->path = (const void *)(bytes + at[RMAP_PART_PATH]);
        return;
    }
    view->n_kind = shape->n_kind;
    view->kind_source = (const void *)(bytes + at[RMAP_PART_KIND_SOURCE]);
    view->kind_stop = bytes + at[RMAP_PART_KIND_STOP];
    view->kind = shape->kind_nbytes > 0 ? rows->kind : NULL;
    view->segment_count = rows->segment_count;
    view->registration_count =
        view->n_row[RMAP_TABLE_REGISTRATION] > 0 ? rows->registration_count : NULL;
    view->n_local = shape->n_local;
    view->local_class = (const void *)(bytes + at[RMAP_PART_LOCAL_CLASS]);
    view->local_rows = rows->local_rows;
    rows->code = bytes + at[RMAP_PART_CODE];
    rows->rare = bytes + at[RMAP_PART_RARE];
    rows->hit = bytes + at[RMAP_PART_HIT];
    rows->segment = bytes + at[RMAP_PART_SEGMENT];
    rows->far = (const void *)(bytes + at[RMAP_PART_FAR]);
}

static enum rmap_status open_paths(const struct rmap_history_view *view, struct rmap_error *err)
{
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    uint64_t n = 0, n_segment = 0, n_registration = 0;
    const struct rmap_portion *paths = view->index->paths;
    if (!all_below_u16(view->path, n_ray, (uint32_t)view->n_path) ||
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

static bool open_kinds(const struct rmap_history_view *view, const uint8_t *bytes,
                       const uint64_t *at)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    for (size_t i = 0; view->kind && i < n_ray; i++)
        rows->kind[i] =
            (uint16_t)rmap_history_number(bytes + at[RMAP_PART_KIND], shape->kind_nbytes, i);
    bool good =
        shape->n_kind > 0 && (!view->kind || all_below_u16(view->kind, n_ray, shape->n_kind));
    for (size_t k = 0; k < view->n_kind; k++)
        good &= view->kind_source[k] >= 0 && (size_t)view->kind_source[k] < view->index->n_source &&
                view->kind_stop[k] < RMAP_STOP_COUNT;
    return good;
}

/* How many segments and registrations each ray has. */
static bool open_counts(const struct rmap_history_view *view, const uint8_t *bytes,
                        const uint64_t *at)
{
    struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    size_t n_ray = view->n_row[RMAP_TABLE_RAY], n_segment = view->n_row[RMAP_TABLE_SEGMENT];
    size_t n_registration = view->n_row[RMAP_TABLE_REGISTRATION];
    if (!rmap_history_widen(bytes + at[RMAP_PART_COUNT], n_ray,
                            (const void *)(bytes + at[RMAP_PART_LONG]), shape->n_long,
                            rows->segment_count) ||
        !rmap_sums_to(rows->segment_count, n_ray, n_segment))
        return false;
    if (n_registration == 0)
        return true;
    if (widen_halves(bytes + at[RMAP_PART_HITS], n_ray, rows->registration_count) != shape->n_many)
        return false;
    if (shape->n_many > 0)
        put_longer((const void *)(bytes + at[RMAP_PART_MANY]), 15, n_ray, rows->registration_count);
    return rmap_sums_to(rows->registration_count, n_ray, n_registration);
}

/* Segments and registrations: their classes. Codes may say anything. */
static bool open_segments(const struct rmap_history_view *view, const uint8_t *bytes,
                          const uint64_t *at)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_shape *shape = &rows->shape;
    bool good = rmap_history_widen(bytes + at[RMAP_PART_LOCAL_ROWS], view->n_local,
                                   (const void *)(bytes + at[RMAP_PART_FREQUENT]),
                                   shape->n_frequent, rows->local_rows) &&
                rmap_sums_to(rows->local_rows, view->n_local, view->n_row[RMAP_TABLE_SEGMENT]) &&
                all_below_u16(view->local_class, view->n_local, (uint32_t)view->index->n_class);
    size_t n_hit = view->n_row[RMAP_TABLE_REGISTRATION];
    if (shape->hit_nbytes == 0 && n_hit > 0)
        n_hit = 1;
    for (size_t i = 0; good && i < n_hit; i++)
        good = rmap_history_number(rows->hit, shape->hit_nbytes, i) < view->index->n_hit;
    return good;
}

static bool shape_holds(const struct rmap_history_shape *shape)
{
    return shape->kind_nbytes <= 2 && shape->hit_nbytes <= 2 &&
           shape->n_kind <= RMAP_HISTORY_CLASS_MAX && shape->n_local <= RMAP_HISTORY_CLASS_MAX &&
           shape->n_path <= RMAP_HISTORY_RAY_MAX && shape->n_common <= shape->n_local &&
           shape->n_common + rmap_history_n_page(shape->n_local) <= 256;
}

/* Takes memory for what is to be made; the bytes may move with it. */
static enum rmap_status make_room(struct rmap_history_view *view,
                                  const struct rmap_history_place *place, const uint8_t **bytes,
                                  struct rmap_error *err)
{
    struct rmap_history_rows *rows = view->rows;
    const bool is_read = !view->index->body.bytes;
    struct rmap_history_layout layout;
    rmap_history_arrange_made(place, &rows->shape, is_read ? place->nbytes : 0, &layout);
    enum rmap_status st = reserve_made(rows, layout.at[RMAP_MADE_PARTS], err);
    if (st != RMAP_OK)
        return st;
    if (is_read)
        *bytes = (const uint8_t *)(rows->made + 1);
    *rows->made = (struct rmap_history_made){.nbytes = layout.at[RMAP_MADE_PARTS]};
    point_made(rows, layout.at);
    return reserve_marks(view, err);
}

static enum rmap_status open_form(struct rmap_history_view *view,
                                  const struct rmap_history_place *place, const uint8_t *bytes,
                                  struct rmap_error *err)
{
    struct rmap_history_shape *shape = &view->rows->shape;
    struct rmap_history_layout layout;
    const bool by_path = place->form == RMAP_HISTORY_PATHS;
    memcpy(shape, bytes, sizeof *shape);
    rmap_history_arrange(place, shape, &layout);
    if (layout.at[RMAP_PART_COUNT_OF] != place->nbytes || (!by_path && !shape_holds(shape)))
        return bad(view, err);
    enum rmap_status st = make_room(view, place, &bytes, err);
    if (st != RMAP_OK)
        return st;
    point_bytes(view, place, bytes, layout.at);
    if (by_path)
        return open_paths(view, err);
    return open_kinds(view, bytes, layout.at) && open_counts(view, bytes, layout.at) &&
                   open_segments(view, bytes, layout.at)
               ? RMAP_OK
               : bad(view, err);
}

/* A view with nothing of the portion yet but its rows. */
static enum rmap_status begin(const struct rmap_history_index *index, size_t portion,
                              struct rmap_history_view *view, struct rmap_error *err)
{
    const struct rmap_history_place *place = &index->place[portion];
    struct rmap_history_rows *rows = view->rows ? view->rows : rmap_alloc(1, sizeof *rows);
    *view = (struct rmap_history_view){.index = index,
                                       .form = (enum rmap_history_form)place->form,
                                       .first_ray = place->first_ray,
                                       .unit_weight = place->unit_weight == 1,
                                       .nbytes = place->nbytes,
                                       .rows = rows};
    if (!rows)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for a history index");
    rows->made = NULL;
    for (int t = 0; t < RMAP_TABLE_HISTORY_COUNT; t++)
        view->n_row[t] = place->n_row[t];
    return RMAP_OK;
}

enum rmap_status rmap_history_view_open(const struct rmap_history_index *index, size_t portion,
                                        struct rmap_history_view *view, struct rmap_error *err)
{
    const struct rmap_history_place *place = &index->place[portion];
    const uint8_t *bytes = NULL;
    enum rmap_status st = begin(index, portion, view, err);
    if (st == RMAP_OK)
        st = fetch(index, place, view, &bytes, err);
    return st == RMAP_OK ? open_form(view, place, bytes, err) : st;
}

enum rmap_status rmap_history_view_reopen(const struct rmap_history_index *index, size_t portion,
                                          struct rmap_history_made *made,
                                          struct rmap_history_view *view, struct rmap_error *err)
{
    const struct rmap_history_place *place = &index->place[portion];
    const uint8_t *bytes =
        index->body.bytes ? index->body.bytes + place->offset : (const uint8_t *)(made + 1);
    struct rmap_history_layout layout;
    enum rmap_status st = begin(index, portion, view, err);
    if (st != RMAP_OK)
        return st;
    struct rmap_history_rows *rows = view->rows;
    rows->made = made;
    memcpy(&rows->shape, bytes, sizeof rows->shape);
    rmap_history_arrange_made(place, &rows->shape, index->body.bytes ? 0 : place->nbytes, &layout);
    point_made(rows, layout.at);
    rmap_history_arrange(place, &rows->shape, &layout);
    point_bytes(view, place, bytes, layout.at);
    return reserve_marks(view, err);
}

size_t rmap_history_made_nbytes(const struct rmap_history_view *view)
{
    return (size_t)view->rows->made->nbytes;
}

void rmap_history_made_copy(const struct rmap_history_view *view, struct rmap_history_made *to)
{
    const struct rmap_history_rows *rows = view->rows;
    const struct rmap_history_made *from = rows->made;
    const uint8_t *begin = (const uint8_t *)from;
    const uint8_t *part[] = {begin, (const uint8_t *)rows->rare_mark, (const uint8_t *)rows->rank,
                             begin + from->nbytes};
    const bool is_there[] = {true, from->has_rare, from->is_ranked};
    for (size_t k = 0; k < sizeof is_there / sizeof *is_there; k++)
        if (is_there[k])
            memcpy((uint8_t *)to + (part[k] - begin), part[k], (size_t)(part[k + 1] - part[k]));
}

void rmap_history_view_fini(struct rmap_history_view *view)
{
    if (view->rows) {
        rmap_free(view->rows->own);
        rmap_free(view->rows->mark_hit);
        rmap_history_sets_fini(&view->rows->sets);
        rmap_free(view->rows);
    }
    *view = (struct rmap_history_view){0};
}

/* Segments whose class is rare, and registrations that are wanted, as a bit each. */

const uint64_t *rmap_history_rare_segments(const struct rmap_history_view *view)
{
    struct rmap_history_rows *rows = view->rows;
    const size_t n_segment = view->n_row[RMAP_TABLE_SEGMENT];
    uint64_t *rare = rows->rare_mark;
    uint8_t member[256] = {0};
    uint32_t n = 0;
    if (rows->shape.n_rare == 0)
        return NULL;
    if (rows->made->is_ranked)
        return rare;
    for (uint32_t k = 0; k < rmap_history_n_page(rows->shape.n_local); k++)
        member[255 - k] = 1;
    if (!rows->made->has_rare)
        rmap_byte_set_bits(rows->code, n_segment, member, rare);
    for (size_t w = 0; w < rmap_bit_words(n_segment); w++) {
        rows->rank[w] = n;
        n += (uint32_t)__builtin_popcountll(rare[w]);
    }
    rows->made->has_rare = rows->made->is_ranked = 1;
    return rare;
}

const uint64_t *rmap_history_mark_hits(const struct rmap_history_view *view, const uint8_t *wanted)
{
    const struct rmap_history_rows *rows = view->rows;
    size_t n = view->n_row[RMAP_TABLE_REGISTRATION];
    unsigned nbytes = rows->shape.hit_nbytes;
    uint8_t member[256] = {0};
    if (n == 0 || (nbytes == 0 && !wanted[rmap_history_number(rows->hit, 0, 0)]))
        return NULL;
    memset(rows->mark_hit, nbytes == 0 ? UINT8_MAX : 0,
           rmap_history_hit_words(view) * sizeof *rows->mark_hit);
    for (size_t k = 0; k < sizeof member && k < view->index->n_hit; k++)
        member[k] = wanted[k] != 0;
    if (nbytes == 1)
        rmap_byte_set_bits(rows->hit, n, member, rows->mark_hit);
    for (size_t i = 0; nbytes == 2 && i < n; i++)
        rows->mark_hit[i / 64] |= (uint64_t)(wanted[rmap_history_number(rows->hit, nbytes, i)] != 0)
                                  << i % 64;
    return rows->mark_hit;
}

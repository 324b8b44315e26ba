/* SPDX-License-Identifier: MIT
 *
 * Classes of legs, of all rays of a portion or of some.
 */
#include <string.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/intrinsics.h"
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
                                .rare = rmap_history_rare_legs(view)};
    for (uint32_t k = 0; k < codes.n_common; k++)
        codes.class_of[k] = view->local_class[k];
    return codes;
}

static inline uint16_t class_at(const struct rmap_history_view *view,
                                const struct class_codes *codes, size_t leg)
{
    uint8_t code = view->rows->code[leg];
    return code < codes->n_common || !codes->rare
               ? codes->class_of[code]
               : view->local_class[rmap_history_rare_at(view, codes->rare, leg)];
}

void rmap_history_row_classes(const struct rmap_history_view *view, uint16_t *row_class)
{
    const struct class_codes codes = class_codes(view);
    for (size_t i = 0; i < view->n_row[RMAP_TABLE_SEGMENT]; i++)
        row_class[i] = class_at(view, &codes, i);
}

/* Where legs and registrations of each of n rays begin, registrations in the upper half; returns
 * where the next ones do. */
static inline uint64_t place_block(const uint32_t *legs, const uint32_t *hits, size_t n,
                                   uint64_t at, uint64_t *begin)
{
    RMAP_UNROLL
    for (size_t i = 0; i < n; i++) {
        begin[i] = at;
        at += legs[i] | (uint64_t)hits[i] << 32;
    }
    return at;
}

size_t rmap_history_place_rays(const struct rmap_history_view *view, const uint64_t *bits,
                               struct rmap_history_place_of_ray *ray)
{
    enum { BLOCK = 64 };
    const size_t n_ray = view->n_row[RMAP_TABLE_RAY];
    const bool has_hits = view->registration_count != NULL;
    const uint32_t *legs = view->segment_count, *hits = has_hits ? view->registration_count : legs;
    uint64_t at = 0, begin[BLOCK];
    size_t n = 0;
    for (size_t first = 0; first < n_ray; first += BLOCK) {
        size_t few = n_ray - first < BLOCK ? n_ray - first : BLOCK;
        at = place_block(legs + first, hits + first, few, at, begin);
        for (uint64_t left = bits[first / BLOCK]; left != 0; left &= left - 1) {
            size_t i = (size_t)__builtin_ctzll(left);
            ray[n++] =
                (struct rmap_history_place_of_ray){(uint32_t)(first + i), (uint32_t)begin[i],
                                                   has_hits ? (uint32_t)(begin[i] >> 32) : 0};
        }
    }
    return n;
}

/* Far legs of registrations before one of them, counted on from an earlier one. */
struct far_walk {
    size_t at;
    uint32_t n;
};

static uint32_t far_before(const struct rmap_history_rows *rows, struct far_walk *walk, size_t hit)
{
    for (; rows->shape.n_far > 0 && walk->at < hit; walk->at++)
        walk->n += rows->leg[walk->at] == UINT8_MAX;
    return walk->n;
}

/* The leg on which a registration happened; later ones must be asked for after earlier ones. */
static uint32_t leg_of_hit(const struct rmap_history_rows *rows, struct far_walk *walk, size_t hit)
{
    uint32_t leg = rows->leg[hit];
    return leg == UINT8_MAX && far_before(rows, walk, hit) < rows->shape.n_far ? rows->far[walk->n]
                                                                               : leg;
}

void rmap_history_seen_behind(const struct rmap_history_view *view,
                              const struct rmap_history_place_of_ray *ray, size_t n,
                              const uint64_t *leg, const uint8_t *wanted, const uint8_t *follows,
                              uint64_t *bits)
{
    const struct rmap_history_rows *rows = view->rows;
    struct far_walk walk = {0};
    for (size_t k = 0; view->registration_count && k < n; k++) {
        size_t first = ray[k].registration, end = first + view->registration_count[ray[k].ray];
        uint32_t n_leg = view->segment_count[ray[k].ray], most = 0; /* legs before one of them */
        for (size_t i = first; i < end; i++) {
            uint32_t hit = rmap_history_number(rows->hit, rows->shape.hit_nbytes, i);
            uint32_t leg_of = leg_of_hit(rows, &walk, i);
            uint32_t before = leg_of < n_leg ? leg_of + follows[hit] : n_leg;
            most = wanted[hit] && before > most ? before : most;
        }
        bits[ray[k].ray / 64] |= (uint64_t)rmap_bits_any(leg, ray[k].leg, most) << ray[k].ray % 64;
    }
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
        out->registration.segment[to] = leg_of_hit(rows, walk, i);
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
        uint32_t n_leg = view->segment_count[ray[k].ray];
        uint32_t n_hit = view->registration_count ? view->registration_count[ray[k].ray] : 0;
        for (size_t leg = ray[k].leg; leg < (size_t)ray[k].leg + n_leg; leg++)
            *row_class++ = class_at(view, &codes, leg);
        copy_hits(view, &walk, ray[k].registration, n_hit, out);
        out->ray.segment_count[k] = n_leg;
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

static void unfold_rare_legs(const struct rmap_history_view *view, rmap_column_set columns,
                             struct rmap_portion *out)
{
    const uint64_t *rare = rmap_history_rare_legs(view);
    const struct rmap_history_class *what = view->index->class_of;
    for (size_t w = 0; rare && w * 64 < view->n_row[RMAP_TABLE_SEGMENT]; w++)
        for (uint64_t left = rare[w]; left != 0; left &= left - 1) {
            size_t leg = w * 64 + (size_t)__builtin_ctzll(left);
            const struct rmap_history_class *is =
                &what[view->local_class[rmap_history_rare_at(view, rare, leg)]];
            if (asked(columns, RMAP_SEGMENT_object))
                out->segment.object[leg] = is->object;
            if (asked(columns, RMAP_SEGMENT_event))
                out->segment.event[leg] = is->event;
            if (asked(columns, RMAP_SEGMENT_medium))
                out->segment.medium[leg] = (int16_t)is->medium;
        }
}

/* What the classes with codes are, then each leg's, then the rare ones. */
static void unfold_legs(const struct rmap_history_view *view, rmap_column_set columns,
                        struct rmap_portion *out)
{
    const uint8_t *code = view->rows->code;
    const struct rmap_history_class *what = view->index->class_of;
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
    unfold_rare_legs(view, columns, out);
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
           rmap_history_widen(rows->leg, n, rows->far, rows->shape.n_far,
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
    unfold_legs(view, columns, out);
    return unfold_hits(view, columns, out) ? RMAP_OK : does_not_add_up(view, err);
}

/* Legs whose class is wanted: codes become a bit each. Sets of classes that were asked for in the
 * portion before are likely to be asked for again, so all of them are marked in one go. */

enum {
    AT_ONCE = RMAP_HISTORY_SETS_AT_ONCE, /* a bit of a byte for each, and one for rare legs */
    PAGE = 256,                          /* rare classes that share a code */
    STEP = 8, /* rare legs that are put at once, and sets that they are put to */
    PUT_AT_ONCE = 4,
    SPARE = 4, /* sets that a portion has room for beside those known before */
    SET_MAX = RMAP_HISTORY_SET_MAX
};

/* Sets that are marked at once. */
struct batch {
    unsigned n;
    uint8_t number[AT_ONCE];     /* of each, among those known */
    uint64_t *bits[AT_ONCE + 1]; /* of each; then of the rare legs */
    uint8_t of_code[256];        /* sets that a code is of */
    uint8_t common, rare;        /* sets with classes that have codes, with others */
};

static uint64_t *slot(const struct rmap_history_view *view, size_t s)
{
    return view->rows->sets.mark + s * rmap_history_mark_words(view);
}

RMAP_WIDE static void add_set(const uint8_t *restrict wanted, size_t n_class, unsigned bit,
                              uint8_t *restrict of_class)
{
    for (size_t c = 0; c < n_class; c++)
        of_class[c] |= (uint8_t)(wanted[c] << bit);
}

/* of_local [n]: sets of each local class; those of any of them. */
static uint8_t gather(const uint8_t *restrict of_class, const uint16_t *restrict local, size_t n,
                      uint8_t *restrict of_local)
{
    uint8_t any = 0;
    for (size_t k = 0; k < n; k++)
        any |= of_local[k] = of_class[local[k]];
    return any;
}

/* What the sets are in local classes. */
static void localise(const struct rmap_history_view *view, struct batch *batch)
{
    struct rmap_history_sets *sets = &view->rows->sets;
    const struct rmap_history_shape *shape = &view->rows->shape;
    if (sets->n_composed != batch->n ||
        memcmp(sets->composed, batch->number, batch->n * sizeof *batch->number) != 0) {
        memset(sets->of_class, 0, sets->n_class);
        for (unsigned b = 0; b < batch->n; b++)
            add_set(sets->wanted + batch->number[b] * sets->n_class, sets->n_class, b,
                    sets->of_class);
        memcpy(sets->composed, batch->number, sizeof batch->number);
        sets->n_composed = batch->n;
    }
    batch->common = gather(sets->of_class, view->local_class, shape->n_common, batch->of_code);
    batch->rare = gather(sets->of_class, view->local_class + shape->n_common,
                         shape->n_local - shape->n_common, sets->of_rare);
}

/* Sets of the legs in the list of rare ones, in their order; 0 behind them. How many there are.
 * What is stored may be shorter than it should, or name classes that are not there: damage that a
 * checksum hides. */
RMAP_WIDE_SHIFTS static size_t list_rare(const struct rmap_history_view *view, const uint64_t *rare)
{
    const struct rmap_history_rows *rows = view->rows;
    const uint8_t *of_rare = rows->sets.of_rare;
    const uint8_t *code = rows->code, *number = rows->rare;
    uint8_t *const sets_of = rows->sets.of_leg;
    size_t n = 0, most = rows->shape.n_rare,
           n_word = rmap_bit_words(view->n_row[RMAP_TABLE_SEGMENT]);
    for (size_t w = 0; w < n_word; w++, code += 64)
        for (uint64_t left = rare[w]; left != 0 && n < most; left &= left - 1, n++)
            sets_of[n] = of_rare[number[n] + 255u * PAGE -
                                 (size_t)code[(size_t)__builtin_ctzll(left)] * PAGE];
    memset(sets_of + n, 0, STEP);
    return n;
}

/* Where the bits of a set's rare legs go. */
struct target {
    unsigned bit; /* of the set in a leg's sets */
    uint64_t *mark;
};

static void plain_put(const uint8_t *sets_of, size_t n, const uint64_t *rare,
                      const struct target *to, unsigned n_set)
{
    for (size_t w = 0, at = 0; at < n; w++)
        for (uint64_t left = rare[w]; left != 0 && at < n; left &= left - 1, at++)
            for (unsigned s = 0; s < n_set; s++)
                to[s].mark[w] |= sets_of[at] >> to[s].bit & 1 ? left & (0 - left) : 0;
}

#ifdef RMAP_INTRINSICS
/* A set's bits of eight legs are taken together, and put where the legs are. n_set: known where
 * this is copied to. */
__attribute__((target("bmi,bmi2,popcnt"))) RMAP_COPIED void put_sets(const uint8_t *sets_of,
                                                                     size_t n, const uint64_t *rare,
                                                                     const struct target *to,
                                                                     unsigned n_set)
{
    uint64_t which[PUT_AT_ONCE], *mark[PUT_AT_ONCE];
    for (unsigned s = 0; s < n_set; s++) {
        which[s] = UINT64_C(0x0101010101010101) << to[s].bit;
        mark[s] = to[s].mark;
    }
    for (size_t w = 0, at = 0, end; at < n; w++, at = end) {
        uint64_t left = rare[w];
        end = at + (size_t)_mm_popcnt_u64(left);
        for (; left != 0 && at < n; at += STEP, left = _pdep_u64(UINT64_MAX << STEP, left)) {
            uint64_t eight;
            memcpy(&eight, sets_of + at, sizeof eight);
            RMAP_UNROLL
            for (unsigned s = 0; s < n_set; s++)
                mark[s][w] |= _pdep_u64(_pext_u64(eight, which[s]), left);
        }
    }
}

__attribute__((target("bmi,bmi2,popcnt"))) static void wide_put(const uint8_t *sets_of, size_t n,
                                                                const uint64_t *rare,
                                                                const struct target *to,
                                                                unsigned n_set)
{
    switch (n_set) {
    case 1:
        put_sets(sets_of, n, rare, to, 1);
        break;
    case 2:
        put_sets(sets_of, n, rare, to, 2);
        break;
    case 3:
        put_sets(sets_of, n, rare, to, 3);
        break;
    default:
        put_sets(sets_of, n, rare, to, PUT_AT_ONCE);
    }
}

static bool is_wide(void)
{
    return __builtin_cpu_supports("bmi2") && __builtin_cpu_supports("popcnt");
}
#else
#define wide_put plain_put

static bool is_wide(void)
{
    return false;
}
#endif

/* The rare legs of the sets that may have some. */
static void put_rare(const struct rmap_history_view *view, const struct batch *batch)
{
    const struct rmap_history_rows *rows = view->rows;
    struct target to[AT_ONCE];
    size_t n_rare = list_rare(view, rows->rare_mark);
    unsigned n = 0;
    for (unsigned b = 0; b < batch->n; b++)
        if (batch->rare >> b & 1)
            to[n++] = (struct target){b, batch->bits[b]};
    for (unsigned b = 0; b < n; b += PUT_AT_ONCE)
        (is_wide() ? wide_put : plain_put)(rows->sets.of_leg, n_rare, rows->rare_mark, to + b,
                                           n - b < PUT_AT_ONCE ? n - b : PUT_AT_ONCE);
}

static void mark_batch(const struct rmap_history_view *view, struct batch *batch)
{
    struct rmap_history_rows *rows = view->rows;
    uint64_t *rare = rows->rare_mark;
    unsigned n = batch->n;
    localise(view, batch);
    if (batch->rare && !rows->made->has_rare) {
        for (uint32_t k = 0; k < rmap_history_n_page(rows->shape.n_local); k++)
            batch->of_code[255 - k] = (uint8_t)(1u << n);
        batch->bits[n++] = rare;
        rows->made->has_rare = 1;
    }
    if (batch->common | batch->rare)
        rmap_byte_sets_bits(rows->code, view->n_row[RMAP_TABLE_SEGMENT], batch->of_code, n,
                            batch->bits);
    if (batch->rare)
        put_rare(view, batch);
}

static void add_to_batch(const struct rmap_history_view *view, size_t s, struct batch *batch)
{
    batch->number[batch->n] = (uint8_t)s;
    batch->bits[batch->n++] = slot(view, s);
}

/* A set's legs, and those of others that will be asked for if this portion is like the last one. */
static void mark_together(const struct rmap_history_view *view, size_t wanted)
{
    struct rmap_history_sets *sets = &view->rows->sets;
    struct batch batch = {0};
    add_to_batch(view, wanted, &batch);
    for (size_t s = 0; s < sets->n && batch.n < AT_ONCE; s++)
        if (s != wanted && sets->set[s].marked != sets->portion &&
            sets->set[s].asked + 1 == sets->portion)
            add_to_batch(view, s, &batch);
    mark_batch(view, &batch);
    for (unsigned b = 0; b < batch.n; b++) {
        sets->set[batch.number[b]].marked = sets->portion;
        sets->set[batch.number[b]].any = (batch.common | batch.rare) >> b & 1;
    }
}

/* Where a set stands that is known, or is entered in the place of that which nobody asked for the
 * longest. */
static size_t place_set(struct rmap_history_sets *sets, const uint8_t *wanted)
{
    size_t oldest = 0;
    for (size_t s = 0; s < sets->n; s++) {
        if (memcmp(sets->wanted + s * sets->n_class, wanted, sets->n_class) == 0)
            return s;
        if (sets->set[s].asked < sets->set[oldest].asked)
            oldest = s;
    }
    size_t s = sets->n < sets->n_room ? sets->n++ : oldest;
    memcpy(sets->wanted + s * sets->n_class, wanted, sets->n_class);
    sets->set[s] = (struct rmap_history_set){0};
    sets->n_composed = 0;
    return s;
}

const uint64_t *rmap_history_mark(const struct rmap_history_view *view, const uint8_t *wanted)
{
    struct rmap_history_sets *sets = &view->rows->sets;
    size_t s = place_set(sets, wanted);
    sets->set[s].asked = sets->portion;
    if (sets->set[s].marked != sets->portion)
        mark_together(view, s);
    return sets->set[s].any ? slot(view, s) : NULL;
}

enum rmap_status rmap_history_sets_enter(struct rmap_history_view *view, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_history_sets *sets = &view->rows->sets;
    const struct rmap_history_shape *shape = &view->rows->shape;
    size_t n_class = view->index->n_class, n_rare = shape->n_local - shape->n_common;
    size_t n_paged = PAGE * (size_t)rmap_history_n_page(shape->n_local);
    if (sets->n_class != n_class)
        sets->n = sets->n_composed = 0;
    sets->n_class = n_class;
    sets->portion++;
    sets->n_room = sets->n + SPARE < SET_MAX ? sets->n + SPARE : SET_MAX;
    RMAP_TRY(RMAP_RESERVE(sets->wanted, sets->cap_wanted, sets->n_room * n_class + 1, err));
    RMAP_TRY(RMAP_RESERVE(sets->of_class, sets->cap_of_class, n_class + 1, err));
    RMAP_TRY(RMAP_RESERVE(sets->of_rare, sets->cap_of_rare,
                          (n_paged > n_rare ? n_paged : n_rare) + 1, err));
    RMAP_TRY(RMAP_RESERVE(sets->of_leg, sets->cap_of_leg, shape->n_rare + STEP, err));
    memset(sets->of_rare, 0, n_paged > n_rare ? n_paged : n_rare);
    RMAP_TRY(RMAP_RESERVE(sets->mark, sets->cap_mark, sets->n_room * rmap_history_mark_words(view),
                          err));
out:
    return st;
}

void rmap_history_sets_fini(struct rmap_history_sets *sets)
{
    rmap_free(sets->wanted);
    rmap_free(sets->of_class);
    rmap_free(sets->of_rare);
    rmap_free(sets->of_leg);
    rmap_free(sets->mark);
    *sets = (struct rmap_history_sets){0};
}

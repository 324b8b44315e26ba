/* SPDX-License-Identifier: MIT
 *
 * Legs whose class is wanted: codes become a bit each. Sets of classes that were asked for in the
 * portion before are likely to be asked for again, so all of them are marked in one go.
 */
#include <string.h>

#include "base/alloc.h"
#include "base/byte_set.h"
#include "base/intrinsics.h"
#include "base/wide.h"
#include "history/history_parts.h"

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

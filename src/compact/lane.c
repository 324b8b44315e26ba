/* SPDX-License-Identifier: MIT
 *
 * A lane is a column whose numbers are predicted.
 */
#include <math.h>

#include "base/alloc.h"
#include "compact/angles.h"
#include "compact/damaged.h"
#include "compact/lane.h"
#include "compact/own_lengths.h"
#include "compact/streams.h"

static const struct {
    enum rmap_column column;
    enum rmap_lane_role role;
} known_lane[RMAP_LANE_COUNT] = {
#define COLUMN(column, role) {RMAP_##column, RMAP_LANE_##role},
    RMAP_LANES(COLUMN)
#undef COLUMN
};

/* Bits of number i, widened. */
static uint64_t get_bits(const uint8_t *data, size_t i, size_t nbytes)
{
    uint16_t two;
    uint32_t four;
    uint64_t eight;
    switch (nbytes) {
    case 2:
        memcpy(&two, data + 2 * i, 2);
        return two;
    case 4:
        memcpy(&four, data + 4 * i, 4);
        return four;
    default:
        memcpy(&eight, data + 8 * i, 8);
        return eight;
    }
}

static uint64_t mask_of(size_t nbytes)
{
    return nbytes == 8 ? UINT64_MAX : (UINT64_C(1) << (8 * nbytes)) - 1;
}

/* Floats in the order of their values: negative ones have their magnitude bits turned. Its own
 * inverse. */
static uint64_t ordered(enum rmap_element element, uint64_t bits)
{
    if (element == RMAP_F32 && bits >> 31)
        return bits ^ UINT64_C(0x7fffffff);
    if (element == RMAP_F64 && bits >> 63)
        return bits ^ (UINT64_MAX >> 1);
    return bits;
}

static uint64_t difference(const struct rmap_lane *lane, uint64_t truth, uint64_t predicted)
{
    uint64_t mask = mask_of(lane->element_nbytes);
    uint64_t d = (ordered(lane->element, truth) - ordered(lane->element, predicted)) & mask;
    uint64_t sign = d >> (8 * lane->element_nbytes - 1);
    return (d << 1 & mask) ^ (sign ? mask : 0);
}

static uint64_t corrected(const struct rmap_lane *lane, uint64_t predicted, uint64_t value)
{
    uint64_t mask = mask_of(lane->element_nbytes);
    uint64_t d = (value & mask) >> 1 ^ (value & 1 ? mask : 0);
    return ordered(lane->element, (ordered(lane->element, predicted) + d) & mask);
}

void rmap_lane_note(struct rmap_lane *lane, size_t first, size_t count, void *value)
{
    uint8_t *predicted = value;
    size_t nbytes = lane->element_nbytes;
    if (lane->status != RMAP_OK)
        count = 0;
    for (size_t i = 0; i < count; i++) {
        uint64_t truth = get_bits(lane->from, first + i, nbytes);
        uint64_t d = difference(lane, truth, get_bits(predicted, i, nbytes));
        if (d == 0)
            continue;
        size_t n = lane->n_patch, at = lane->before + first + i, skip = at - lane->last;
        lane->status = RMAP_RESERVE(lane->skip, lane->cap_patch, n + 1, NULL);
        if (lane->status == RMAP_OK)
            lane->status = RMAP_RESERVE(lane->value, lane->cap_value, n + 1, NULL);
        if (lane->status != RMAP_OK)
            return;
        lane->skip[n] = skip > UINT32_MAX ? UINT32_MAX : (uint32_t)skip; /* then not patched */
        lane->value[n] = d;
        lane->n_patch = n + 1;
        lane->last = at + 1;
        rmap_put_bits(predicted, i, nbytes, truth);
    }
}

bool rmap_lane_correct(struct rmap_lane *lane, size_t first, size_t count, void *value)
{
    uint8_t *number = value;
    size_t nbytes = lane->element_nbytes;
    bool right = true;
    for (size_t i = 0; i < count; i++) {
        uint64_t predicted = get_bits(number, i, nbytes), bits = predicted;
        switch (lane->mode) {
        case RMAP_LANE_VERBATIM:
            bits = get_bits(lane->dense, first + i, nbytes);
            break;
        case RMAP_LANE_RESIDUAL:
            bits = corrected(lane, bits, get_bits(lane->dense, first + i, nbytes));
            break;
        default:
            if (first + i != lane->next)
                break;
            bits = corrected(lane, bits, *lane->patch_value++);
            lane->patches_left--;
            lane->next = lane->patches_left > 0 ? lane->next + 1 + *++lane->patch_skip : SIZE_MAX;
        }
        right = right && bits == predicted;
        rmap_put_bits(number, i, nbytes, bits);
    }
    if (lane->to)
        memcpy(lane->to + first * nbytes, number, count * nbytes);
    return right;
}

bool rmap_lane_match(struct rmap_lane *lane, size_t first, size_t count, const void *predicted)
{
    const uint8_t *number = predicted;
    size_t nbytes = lane->element_nbytes;
    if (memcmp(lane->from + first * nbytes, number, count * nbytes) == 0)
        return true;
    for (size_t i = 0; i < count; i++) {
        uint8_t one[8];
        memcpy(one, number + i * nbytes, nbytes);
        if (memcmp(lane->from + (first + i) * nbytes, one, nbytes) != 0)
            rmap_lane_note(lane, first + i, 1, one);
    }
    return false;
}

void rmap_lane_amend(struct rmap_lane *lane, size_t first, size_t end)
{
    size_t nbytes = lane->element_nbytes;
    bool dense = lane->mode == RMAP_LANE_RESIDUAL || lane->mode == RMAP_LANE_VERBATIM;
    for (size_t i = first; i < end; i++) {
        uint8_t one[8] = {0};
        if (!dense && lane->next >= end)
            return;
        i = dense || lane->next < i ? i : lane->next;
        if (lane->to)
            memcpy(one, lane->to + i * nbytes, nbytes);
        (void)rmap_lane_correct(lane, i, 1, one);
    }
}

void rmap_lanes_init(struct rmap_lane *lane)
{
    memset(lane, 0, RMAP_LANE_COUNT * sizeof *lane);
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        const struct rmap_column_info *info = rmap_column_info(known_lane[i].column);
        lane[i].column = known_lane[i].column;
        lane[i].role = known_lane[i].role;
        lane[i].element = info->element;
        lane[i].element_nbytes = rmap_element_nbytes(info->element);
    }
}

void rmap_lanes_fini(struct rmap_lane *lane)
{
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        rmap_free(lane[i].skip);
        rmap_free(lane[i].value);
        rmap_free(lane[i].whole);
    }
}

/* Numbers that the lane has in a portion. */
static size_t lane_numbers(const struct rmap_lane *lane, const struct rmap_portion *portion)
{
    return portion->n_row[rmap_column_info(lane->column)->table] *
           (rmap_portion_row_nbytes(portion, lane->column) / lane->element_nbytes);
}

void rmap_lanes_begin(struct rmap_lane *lane)
{
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        lane[i].to = NULL;
        lane[i].n = lane[i].before = lane[i].n_patch = lane[i].last = 0;
        lane[i].status = RMAP_OK;
    }
}

/* Its numbers of the part in hand, behind those of the parts before. */
static void keep_whole(struct rmap_lane *lane)
{
    const size_t nbytes = lane->element_nbytes;
    if (lane->status == RMAP_OK)
        lane->status = RMAP_RESERVE(lane->whole, lane->cap_whole, lane->n * nbytes + 1, NULL);
    if (lane->status == RMAP_OK && lane->n > lane->before)
        memcpy(lane->whole + lane->before * nbytes, lane->from, (lane->n - lane->before) * nbytes);
}

void rmap_lanes_continue(struct rmap_lane *lane, const struct rmap_portion *part)
{
    for (int i = 0; i < rmap_lane_count(part->timed); i++) {
        lane[i].before = lane[i].n;
        lane[i].n += lane_numbers(&lane[i], part);
        lane[i].from = rmap_portion_column(part, lane[i].column);
    }
    keep_whole(&lane[RMAP_LANE_REGISTRATION_relative]);
}

/* How the lanes of a portion are stored, each in the way that costs least, and read again. */

/* Bytes that entropy coding per byte plane leaves of numbers of element_nbytes each. */
static double coded_nbytes(const uint8_t *data, size_t n, size_t element_nbytes)
{
    double bits = 0.0;
    for (size_t plane = 0; plane < element_nbytes && n > 0; plane++) {
        uint32_t count[256] = {0};
        size_t stride = n > 65536 ? n / 65536 : 1, sampled = 0;
        for (size_t i = 0; i < n; i += stride, sampled++)
            count[data[i * element_nbytes + plane]]++;
        double sum = 0.0;
        for (int i = 0; i < 256; i++)
            if (count[i])
                sum -= count[i] * log2((double)count[i] / (double)sampled);
        bits += sum * ((double)n / (double)sampled);
    }
    return bits / 8.0;
}

/* The differences of a lane, one per number. */
static void spread(const struct rmap_lane *lane, uint8_t *dense)
{
    size_t at = 0;
    memset(dense, 0, lane->n * lane->element_nbytes);
    for (size_t i = 0; i < lane->n_patch; i++) {
        at += lane->skip[i];
        rmap_put_bits(dense, at++, lane->element_nbytes, lane->value[i]);
    }
}

/* dense: room for the lane's numbers. It keeps the differences when they are chosen. */
static enum rmap_lane_mode choose(const struct rmap_lane *lane, uint8_t *dense)
{
    if (lane->n > UINT32_MAX)
        return RMAP_LANE_VERBATIM; /* a patch could skip more than 32 bits hold */
    spread(lane, dense);
    double k = (double)lane->n_patch;
    double patched = coded_nbytes((const uint8_t *)lane->skip, lane->n_patch, 4) +
                     coded_nbytes((const uint8_t *)lane->value, lane->n_patch, 8) + 0.01 * k;
    double residual = coded_nbytes(dense, lane->n, lane->element_nbytes);
    double verbatim = coded_nbytes(lane->from, lane->n, lane->element_nbytes);
    if (verbatim <= patched && verbatim <= residual)
        return RMAP_LANE_VERBATIM;
    return patched <= residual ? RMAP_LANE_PATCHED : RMAP_LANE_RESIDUAL;
}

/* Room for n more numbers of a pool; *at_ret: where they begin. */
static enum rmap_status grow_pool(struct rmap_lane_store *store, size_t nbytes, size_t n,
                                  uint8_t **at_ret, struct rmap_error *err)
{
    enum rmap_status st;
    switch (nbytes) {
    case 2:
        st = RMAP_RESERVE(store->pool16, store->cap16, store->n16 + n, err);
        *at_ret = (uint8_t *)store->pool16 + 2 * store->n16;
        break;
    case 4:
        st = RMAP_RESERVE(store->pool32, store->cap32, store->n32 + n, err);
        *at_ret = (uint8_t *)store->pool32 + 4 * store->n32;
        break;
    default:
        st = RMAP_RESERVE(store->pool64, store->cap64, store->n64 + n, err);
        *at_ret = (uint8_t *)store->pool64 + 8 * store->n64;
    }
    return st;
}

static void take_pool(struct rmap_lane_store *store, size_t nbytes, size_t n)
{
    *(nbytes == 2 ? &store->n16 : nbytes == 4 ? &store->n32 : &store->n64) += n;
}

/* A lane is patched without further thought up to one number in so many. */
#define FEW_PATCHES 256

bool rmap_lanes_sparse(const struct rmap_lane *lane)
{
    bool sparse = true;
    for (int i = 0; i < RMAP_LANE_COUNT; i++)
        sparse = sparse &&
                 (lane[i].role == RMAP_LANE_PLACED || lane[i].n_patch * FEW_PATCHES <= lane[i].n);
    return sparse;
}

static enum rmap_status store_lane(const struct rmap_lane *lane, struct rmap_lane_store *store,
                                   enum rmap_lane_mode *mode_ret, struct rmap_error *err)
{
    enum rmap_status st = lane->status;
    if (st != RMAP_OK)
        return rmap_error_set(err, st, "out of memory for a portion's patches");
    size_t n = lane->n_patch;
    uint8_t *dense = NULL;
    if (lane->whole) {
        RMAP_TRY(grow_pool(store, lane->element_nbytes, lane->n, &dense, err));
        if (lane->n > 0)
            memcpy(dense, lane->whole, lane->n * lane->element_nbytes);
        take_pool(store, lane->element_nbytes, lane->n);
        *mode_ret = RMAP_LANE_VERBATIM;
        return RMAP_OK;
    }
    *mode_ret = n == 0 ? RMAP_LANE_PREDICTED : RMAP_LANE_PATCHED;
    if (n == 0)
        return RMAP_OK;
    /* Cells that are not those of their place are one off: patches of two bytes or so. */
    if (n * FEW_PATCHES > lane->n && (lane->role != RMAP_LANE_PLACED || lane->n > UINT32_MAX)) {
        RMAP_TRY(grow_pool(store, lane->element_nbytes, lane->n, &dense, err));
        *mode_ret = choose(lane, dense);
        if (*mode_ret == RMAP_LANE_VERBATIM)
            memcpy(dense, lane->from, lane->n * lane->element_nbytes);
        if (*mode_ret != RMAP_LANE_PATCHED) {
            take_pool(store, lane->element_nbytes, lane->n);
            return RMAP_OK;
        }
    }
    RMAP_TRY(RMAP_RESERVE(store->skip, store->cap_skip, store->n_patch + n, err));
    RMAP_TRY(RMAP_RESERVE(store->value, store->cap_value, store->n_patch + n, err));
    memcpy(store->skip + store->n_patch, lane->skip, n * sizeof *lane->skip);
    memcpy(store->value + store->n_patch, lane->value, n * sizeof *lane->value);
    store->n_patch += n;
out:
    return st;
}

enum rmap_status rmap_lanes_store(const struct rmap_lane *lane, struct rmap_lane_header *header,
                                  struct rmap_lane_store *store, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    enum rmap_lane_mode mode = RMAP_LANE_PREDICTED;
    store->n16 = store->n32 = store->n_patch = 0;
    store->n64 = rmap_lane_header_rows(header->n_lane);
    RMAP_TRY(RMAP_RESERVE(store->pool64, store->cap64, store->n64, err));
    for (int i = 0; i < header->n_lane; i++) {
        RMAP_TRY(store_lane(&lane[i], store, &mode, err));
        header->mode[i] = (uint8_t)mode;
        header->n_patch[i] = mode == RMAP_LANE_PATCHED ? lane[i].n_patch : 0;
    }
    rmap_lane_header_write(header, store->pool64);
out:
    return st;
}

void rmap_lane_store_fini(struct rmap_lane_store *store)
{
    rmap_free(store->pool16);
    rmap_free(store->pool32);
    rmap_free(store->pool64);
    rmap_free(store->skip);
    rmap_free(store->value);
    *store = (struct rmap_lane_store){0};
}

/* ---- decoding ---- */

struct rmap_lane_store rmap_lane_store_of(const struct rmap_rows *rows)
{
    return (struct rmap_lane_store){.pool16 = rows->data[RMAP_STREAM_pool16],
                                    .pool32 = rows->data[RMAP_STREAM_pool32],
                                    .pool64 = rows->data[RMAP_STREAM_pool64],
                                    .skip = rows->data[RMAP_STREAM_patch_skip],
                                    .value = rows->data[RMAP_STREAM_patch_value],
                                    .n16 = rows->n_row[RMAP_COMPACT_POOL16],
                                    .n32 = rows->n_row[RMAP_COMPACT_POOL32],
                                    .n64 = rows->n_row[RMAP_COMPACT_POOL64],
                                    .n_patch = rows->n_row[RMAP_COMPACT_PATCH],
                                    .n16_behind =
                                        rmap_own_length_rows(rows->n_row[RMAP_COMPACT_OWN])};
}

/* What has been taken of the store so far. */
struct taken {
    size_t n16, n32, n64, n_patch;
};

static enum rmap_status load_dense(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                   bool is_used, struct taken *taken, struct rmap_error *err)
{
    const uint8_t *pool = (const uint8_t *)store->pool64;
    size_t *used = &taken->n64, all = store->n64;
    if (lane->element_nbytes == 2) {
        pool = (const uint8_t *)store->pool16;
        used = &taken->n16;
        all = store->n16;
    } else if (lane->element_nbytes == 4) {
        pool = (const uint8_t *)store->pool32;
        used = &taken->n32;
        all = store->n32;
    }
    if (lane->n > all - *used)
        return rmap_portion_damaged("a pool has too few rows", err);
    if (is_used) {
        lane->dense = pool + *used * lane->element_nbytes;
        lane->next = 0;
    }
    *used += lane->n;
    return RMAP_OK;
}

static enum rmap_status load_patches(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                     bool is_used, uint64_t n, struct taken *taken,
                                     struct rmap_error *err)
{
    uint64_t at = 0;
    const size_t first = taken->n_patch;
    if (n > store->n_patch - first)
        return rmap_portion_damaged("it has other patches than its header says", err);
    taken->n_patch += (size_t)n;
    if (!is_used)
        return RMAP_OK;
    lane->patch_skip = store->skip + first;
    lane->patch_value = store->value + first;
    lane->patches_left = (size_t)n;
    lane->next = lane->patch_skip[0];
    for (uint64_t i = 0; i < n; i++, at++) {
        at += lane->patch_skip[i];
        if (at >= lane->n)
            return rmap_portion_damaged("a patch lies beyond its lane", err);
    }
    return RMAP_OK;
}

enum rmap_status rmap_lanes_load(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                 rmap_column_set columns, rmap_column_set used,
                                 struct rmap_portion *portion, struct rmap_lane_header *header,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct taken taken = {.n64 = 0};
    RMAP_TRY(rmap_lane_header_read(store->pool64, store->n64, header, &taken.n64, err));
    if (header->n_lane != rmap_lane_count(portion->timed))
        RMAP_TRY(rmap_portion_damaged(
            "its header has lanes of times in a map without, or none in one with them", err));
    for (int i = 0; i < header->n_lane; i++) {
        struct rmap_lane *l = &lane[i];
        const bool wanted = columns & RMAP_COLUMN_BIT(l->column);
        const bool is_used = used & RMAP_COLUMN_BIT(l->column);
        l->n = lane_numbers(l, portion);
        l->from = NULL;
        l->to = wanted ? rmap_portion_column(portion, l->column) : NULL;
        l->mode = (enum rmap_lane_mode)header->mode[i];
        l->next = SIZE_MAX;
        l->patches_left = 0;
        if (l->mode == RMAP_LANE_PATCHED)
            RMAP_TRY(load_patches(l, store, is_used, header->n_patch[i], &taken, err));
        else if (l->mode != RMAP_LANE_PREDICTED)
            RMAP_TRY(load_dense(l, store, is_used, &taken, err));
    }
    const size_t n_angle = header->angled ? portion->n_row[RMAP_TABLE_REGISTRATION] : 0;
    if (n_angle > 0 && store->pool16 && store->pool32)
        header->angles =
            (struct rmap_angle_rows){store->pool32 + taken.n32, store->pool16 + taken.n16};
    if (taken.n16 + rmap_angle_part_rows(n_angle) + header->n_arrival +
                (header->measured ? store->n16_behind : 0) !=
            store->n16 ||
        taken.n32 + rmap_angle_degree_rows(n_angle) != store->n32 || taken.n64 != store->n64 ||
        taken.n_patch != store->n_patch)
        return rmap_portion_damaged("it has other rows than its header says", err);
out:
    return st;
}

void rmap_lane_finish(struct rmap_lane *lane)
{
    if (lane->mode == RMAP_LANE_VERBATIM && lane->n > 0)
        memcpy(lane->to, lane->dense, lane->n * lane->element_nbytes);
    else if (lane->next < lane->n)
        rmap_lane_amend(lane, 0, lane->n);
}

void rmap_lane_fill_ids(struct rmap_lane *lane, uint64_t first, size_t n, uint64_t *out)
{
    uint64_t id = first;
    if (lane->mode == RMAP_LANE_VERBATIM && n > 0) {
        memcpy(out, lane->dense, n * sizeof *out);
        return;
    }
    if (lane->next >= n) { /* none is patched */
        for (size_t i = 0; i < n; i++)
            out[i] = first + i;
        return;
    }
    for (size_t i = 0; i < n; i++, id++)
        (void)rmap_lane_offer(lane, i, 1, sizeof id, &id);
}

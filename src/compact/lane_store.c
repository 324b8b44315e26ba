/* SPDX-License-Identifier: MIT
 *
 * How the lanes of a portion are stored, each in the way that costs least, and read again.
 */
#include <math.h>

#include "base/alloc.h"
#include "compact/damaged.h"
#include "compact/lane.h"

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
        sparse = sparse && lane[i].n_patch * FEW_PATCHES <= lane[i].n;
    return sparse;
}

static enum rmap_status store_lane(const struct rmap_lane *lane, struct rmap_lane_store *store,
                                   enum rmap_lane_mode *mode_ret, struct rmap_error *err)
{
    enum rmap_status st = lane->status;
    if (st != RMAP_OK)
        return rmap_error_set(err, st, "out of memory for a portion's patches");
    size_t n = lane->n_patch;
    *mode_ret = n == 0 ? RMAP_LANE_PREDICTED : RMAP_LANE_PATCHED;
    if (n == 0)
        return RMAP_OK;
    if (n * FEW_PATCHES > lane->n) {
        uint8_t *dense = NULL;
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

enum rmap_status rmap_lanes_store(const struct rmap_lane *lane,
                                  const uint64_t start[RMAP_HEADER_COUNT],
                                  struct rmap_lane_store *store, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    enum rmap_lane_mode mode = RMAP_LANE_PREDICTED;
    uint64_t header[RMAP_HEADER_COUNT + RMAP_LANE_COUNT];
    size_t n_header = RMAP_HEADER_COUNT;
    memcpy(header, start, RMAP_HEADER_COUNT * sizeof *header);
    store->n16 = store->n32 = store->n_patch = 0;
    store->n64 = RMAP_HEADER_COUNT + RMAP_LANE_COUNT; /* the most it can take; closed up below */
    RMAP_TRY(RMAP_RESERVE(store->pool64, store->cap64, store->n64, err));
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        RMAP_TRY(store_lane(&lane[i], store, &mode, err));
        header[RMAP_HEADER_MODES] |= (uint64_t)mode << (2 * i);
        if (mode == RMAP_LANE_PATCHED)
            header[n_header++] = lane[i].n_patch;
    }
    size_t spare = RMAP_HEADER_COUNT + RMAP_LANE_COUNT - n_header;
    memmove(store->pool64 + n_header, store->pool64 + n_header + spare,
            (store->n64 - n_header - spare) * sizeof *store->pool64);
    memcpy(store->pool64, header, n_header * sizeof *header);
    store->n64 -= spare;
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

/* What has been taken of the store so far. */
struct taken {
    size_t n16, n32, n64, n_patch, n_header;
};

static enum rmap_status load_dense(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                   struct taken *taken, struct rmap_error *err)
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
    lane->dense = pool + *used * lane->element_nbytes;
    lane->next = 0;
    *used += lane->n;
    return RMAP_OK;
}

static enum rmap_status load_patches(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                     struct taken *taken, struct rmap_error *err)
{
    uint64_t n = store->pool64[taken->n_header++], at = 0;
    if (n == 0 || n > store->n_patch - taken->n_patch)
        return rmap_portion_damaged("it has other patches than its header says", err);
    lane->patch_skip = store->skip + taken->n_patch;
    lane->patch_value = store->value + taken->n_patch;
    lane->patches_left = (size_t)n;
    lane->next = lane->patch_skip[0];
    taken->n_patch += (size_t)n;
    for (uint64_t i = 0; i < n; i++, at++) {
        at += lane->patch_skip[i];
        if (at >= lane->n)
            return rmap_portion_damaged("a patch lies beyond its lane", err);
    }
    return RMAP_OK;
}

enum rmap_status rmap_lanes_load(struct rmap_lane *lane, const struct rmap_lane_store *store,
                                 rmap_column_set columns, struct rmap_portion *portion,
                                 struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct taken taken = {.n_header = RMAP_HEADER_COUNT, .n64 = RMAP_HEADER_COUNT};
    if (store->n64 < RMAP_HEADER_COUNT)
        return rmap_portion_damaged("it has no header", err);
    uint64_t modes = store->pool64[RMAP_HEADER_MODES];
    if (modes >= RMAP_HEADER_ONE_BY_ONE << 1)
        return rmap_portion_damaged("its header has unknown lanes", err);
    for (int i = 0; i < RMAP_LANE_COUNT; i++)
        taken.n64 += (modes >> (2 * i) & 3) == RMAP_LANE_PATCHED;
    if (store->n64 < taken.n64)
        return rmap_portion_damaged("its header is cut off", err);
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        struct rmap_lane *l = &lane[i];
        bool wanted = columns & RMAP_COLUMN_BIT(l->column);
        l->n = rmap_lane_numbers(l, portion);
        l->from = NULL;
        l->to = wanted ? rmap_portion_column(portion, l->column) : NULL;
        l->mode = (enum rmap_lane_mode)(modes >> (2 * i) & 3);
        l->next = SIZE_MAX;
        l->patches_left = 0;
        if (l->mode == RMAP_LANE_PATCHED)
            RMAP_TRY(load_patches(l, store, &taken, err));
        else if (l->mode != RMAP_LANE_PREDICTED)
            RMAP_TRY(load_dense(l, store, &taken, err));
    }
    if (taken.n16 != store->n16 || taken.n32 != store->n32 || taken.n64 != store->n64 ||
        taken.n_patch != store->n_patch)
        return rmap_portion_damaged("it has more rows than its header says", err);
out:
    return st;
}

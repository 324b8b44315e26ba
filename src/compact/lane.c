/* SPDX-License-Identifier: MIT */
#include "compact/lane.h"

#include "base/alloc.h"
#include "compact/streams.h"

static const enum rmap_column lane_column[RMAP_LANE_COUNT] = {
#define COLUMN(column) RMAP_##column,
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
        const struct rmap_column_info *info = rmap_column_info(lane_column[i]);
        lane[i].column = lane_column[i];
        lane[i].element = info->element;
        lane[i].element_nbytes = rmap_element_nbytes(info->element);
    }
}

void rmap_lanes_fini(struct rmap_lane *lane)
{
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        rmap_free(lane[i].skip);
        rmap_free(lane[i].value);
    }
}

size_t rmap_lane_numbers(const struct rmap_lane *lane, const struct rmap_portion *portion)
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

void rmap_lanes_continue(struct rmap_lane *lane, const struct rmap_portion *part)
{
    for (int i = 0; i < RMAP_LANE_COUNT; i++) {
        lane[i].before = lane[i].n;
        lane[i].n += rmap_lane_numbers(&lane[i], part);
        lane[i].from = rmap_portion_column(part, lane[i].column);
    }
}

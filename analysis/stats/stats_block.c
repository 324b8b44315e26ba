/* SPDX-License-Identifier: MIT */
#include "analysis/stats/stats_block.h"

#include <string.h>

#include "analysis/stats/stats_stored.h"
#include "base/alloc.h"
#include "base/pick.h"
#include "base/wide.h"

void rmap_stats_setup_init(struct rmap_stats_setup *setup, const struct rmap_quantities *quantities,
                           enum rmap_stats_by by, size_t budget_nbytes)
{
    *setup = (struct rmap_stats_setup){.quantities = quantities,
                                       .by = by,
                                       .n_group = 1,
                                       .n_source = quantities->scene->n_source,
                                       .budget_nbytes = budget_nbytes};
    if (by == RMAP_STATS_BY_SOURCE)
        setup->n_group = quantities->scene->n_source;
    if (by == RMAP_STATS_BY_DETECTOR)
        setup->n_group = quantities->scene->n_detector;
    setup->n_class = setup->n_group * setup->n_source;
}

void rmap_stats_reader_fini(struct rmap_stats_reader *reader)
{
    rmap_readings_fini(&reader->readings);
    rmap_free(reader->tag);
    rmap_free(reader->weight);
    for (size_t i = 0; i < RMAP_QUANTITIES_MAX; i++)
        rmap_free(reader->arranged.value[i]);
    rmap_free(reader->arranged.weight);
    rmap_free(reader->arranged.tag);
    rmap_free(reader->arranged.place);
    rmap_free(reader->run);
    rmap_free(reader->source);
    *reader = (struct rmap_stats_reader){0};
}

/* Makes the array at `address` hold n elements. */
static enum rmap_status hold(void *address, size_t *cap, size_t n, size_t size,
                             struct rmap_error *err)
{
    void *memory;
    memcpy(&memory, address, sizeof memory);
    enum rmap_status st = rmap_reserve(&memory, cap, n, size, err);
    memcpy(address, &memory, sizeof memory);
    return st;
}

static enum rmap_status reserve(struct rmap_stats_reader *reader, size_t n, struct rmap_error *err)
{
    enum rmap_status st = hold(&reader->tag, &reader->tag_cap, n, sizeof *reader->tag, err);
    if (st == RMAP_OK)
        st = hold(&reader->weight, &reader->weight_cap, n, sizeof *reader->weight, err);
    return st;
}

static void swap(double *a, double *b)
{
    double kept = *a;
    *a = *b;
    *b = kept;
}

/* Sorts the readings [first, end) of one ray by class; equal ones keep their order. */
static void sort_by_class(struct rmap_stats_reader *reader, size_t n_quantity, size_t first,
                          size_t end)
{
    struct rmap_readings *readings = &reader->readings;
    for (size_t k = first + 1; k < end; k++)
        for (size_t j = k; j > first && reader->tag[j - 1] > reader->tag[j]; j--) {
            uint32_t tag = reader->tag[j];
            reader->tag[j] = reader->tag[j - 1];
            reader->tag[j - 1] = tag;
            swap(&reader->weight[j], &reader->weight[j - 1]);
            for (size_t i = 0; i < n_quantity; i++)
                swap(&readings->value[i][j], &readings->value[i][j - 1]);
        }
}

/* Classes of all readings, and where clusters begin. */
static void tag(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                const struct rmap_portion *portion)
{
    const struct rmap_readings *readings = &reader->readings;
    const bool by_source = setup->by == RMAP_STATS_BY_SOURCE;
    uint32_t before = UINT32_MAX; /* ray */
    for (size_t k = 0; k < readings->n; k++) {
        const uint32_t ray = readings->ray[k], source = (uint32_t)portion->ray.source[ray];
        const uint32_t class = by_source ? source * (uint32_t)setup->n_source + source : source;
        reader->tag[k] = class | (ray != before ? RMAP_STATS_FIRST : 0);
        before = ray;
    }
}

/* The same by detector, for the readings [first, end) of one ray. */
static void tag_ray(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                    const struct rmap_portion *portion, size_t first, size_t end)
{
    const struct rmap_readings *readings = &reader->readings;
    const size_t source = (size_t)portion->ray.source[readings->ray[first]];
    for (size_t k = first; k < end; k++) {
        size_t group = (size_t)portion->registration.detector[readings->place[k]];
        reader->tag[k] = (uint32_t)(group * setup->n_source + source);
    }
    sort_by_class(reader, setup->quantities->n, first, end);
    uint32_t before = UINT32_MAX;
    for (size_t k = first; k < end; k++) {
        uint32_t own = reader->tag[k];
        if (own != before)
            reader->tag[k] |= RMAP_STATS_FIRST;
        before = own;
    }
}

static enum rmap_status reserve_arranged(struct rmap_stats_arranged *arranged, size_t n,
                                         const struct rmap_stats_setup *setup,
                                         struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    for (size_t i = 0; i < setup->quantities->n; i++)
        RMAP_TRY(
            hold(&arranged->value[i], &arranged->value_cap[i], n, sizeof *arranged->value[i], err));
    RMAP_TRY(hold(&arranged->weight, &arranged->weight_cap, n, sizeof *arranged->weight, err));
    RMAP_TRY(hold(&arranged->tag, &arranged->tag_cap, n, sizeof *arranged->tag, err));
    st = hold(&arranged->place, &arranged->place_cap, setup->n_class + 1, sizeof *arranged->place,
              err);
out:
    return st;
}

static bool is_arranged(const struct rmap_stats_block *block)
{
    uint32_t turned_back = 0;
    for (size_t k = 1; k < block->n; k++)
        turned_back |= rmap_stats_class(block->tag[k]) < rmap_stats_class(block->tag[k - 1]);
    return !turned_back;
}

/* Puts readings in the order of their classes, those of a class keeping theirs. */
static enum rmap_status arrange(struct rmap_stats_reader *reader,
                                const struct rmap_stats_setup *setup,
                                struct rmap_stats_block *block, struct rmap_error *err)
{
    const struct rmap_stats_block from = *block;
    const size_t n_quantity = setup->quantities->n;
    struct rmap_stats_arranged *to = &reader->arranged;
    if (setup->n_class == 1 || is_arranged(block))
        return RMAP_OK;
    enum rmap_status st = reserve_arranged(to, from.n, setup, err);
    if (st != RMAP_OK)
        return st;
    memset(to->place, 0, (setup->n_class + 1) * sizeof *to->place);
    for (size_t k = 0; k < from.n; k++)
        to->place[rmap_stats_class(from.tag[k]) + 1]++;
    for (size_t class = 1; class <= setup->n_class; class ++)
        to->place[class] += to->place[class - 1];
    for (size_t k = 0; k < from.n; k++) {
        const size_t at = to->place[rmap_stats_class(from.tag[k])]++;
        to->tag[at] = from.tag[k];
        to->value[0][at] = from.value[0][k];
        if (n_quantity > 1)
            to->value[1][at] = from.value[1][k];
        if (from.weight)
            to->weight[at] = from.weight[k];
    }
    *block = (struct rmap_stats_block){.n = from.n,
                                       .value = {to->value[0], to->value[1]},
                                       .tag = to->tag,
                                       .weight = from.weight ? to->weight : NULL};
    return RMAP_OK;
}

RMAP_WIDE static uint32_t any_other(const int32_t *source, size_t n)
{
    uint32_t other = 0;
    for (size_t i = 1; i < n; i++)
        other |= (uint32_t)(source[i] ^ source[0]);
    return other;
}

/* Sources of the readings, which are those of matching rays. */
static const int32_t *sources_of(struct rmap_stats_reader *reader, const struct rmap_matched *rays)
{
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY];
    const int32_t *all = rays->portion->ray.source;
    if (!rays->match || rays->n_match == n_ray)
        return all;
    for (size_t i = 0, n = 0; i < n_ray; i++) { /* room for one more: no branch */
        reader->source[n] = all[i];
        n += rays->match[i];
    }
    return reader->source;
}

/* Puts readings in the order of their sources, those of a source keeping theirs, and lists the
 * runs. There is room for picking. */
static void arrange_rays(struct rmap_stats_reader *reader, const struct rmap_stats_setup *setup,
                         const int32_t *source, struct rmap_stats_block *block)
{
    const size_t n = block->n, n_quantity = setup->quantities->n;
    size_t end = 0;
    for (size_t s = 0; s < setup->n_source; s++) {
        const size_t first = end;
        for (size_t q = 0; q < n_quantity; q++) {
            double *to = reader->arranged.value[q] + first;
            end = first + rmap_pick_of(block->value[q], source, (int32_t)s, n, to);
        }
        if (end > first)
            reader->run[block->n_run++] =
                (struct rmap_stats_run){end, rmap_stats_class_of(setup, (int32_t)s)};
    }
    for (size_t q = 0; q < n_quantity; q++)
        block->value[q] = reader->arranged.value[q];
}

/* So many sources are told apart by a portion's summary. */
enum { TOLD_APART = 64 };

int32_t rmap_stats_told_source(const struct rmap_stats_setup *setup,
                               const struct rmap_portion_info *portion)
{
    const uint64_t bits = portion->summary.sources;
    int32_t source = -1;
    if (setup->n_source == 1)
        source = 0;
    else if (setup->n_source <= TOLD_APART && bits && !(bits & (bits - 1)))
        source = __builtin_ctzll(bits);
    return (size_t)source < setup->n_source ? source : -1; /* a damaged one may name one too many */
}

/* The source of all rays of the portion, or -1 where there may be several: then that of each. */
static enum rmap_status find_source(const struct rmap_stats_setup *setup,
                                    const struct rmap_matched *rays, int32_t *source_ret,
                                    const int32_t **of_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    *source_ret =
        rmap_stats_told_source(setup, rmap_map_portion(setup->quantities->map, rays->index));
    if (*source_ret >= 0)
        return RMAP_OK;
    RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_source), err));
    *of_ret = rays->portion->ray.source;
    if (setup->n_source > TOLD_APART && !any_other(*of_ret, rays->portion->n_row[RMAP_TABLE_RAY]))
        *source_ret = (*of_ret)[0];
out:
    return st;
}

/* Room for rmap_stats_read_stored. */
static enum rmap_status reserve_stored(struct rmap_stats_reader *reader,
                                       const struct rmap_stats_setup *setup,
                                       const struct rmap_matched *rays, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(
        hold(&reader->run, &reader->run_cap, RMAP_STATS_SOURCES_FEW + 1, sizeof *reader->run, err));
    if (!reader->into[0])
        st = reserve_arranged(&reader->arranged, rays->n_match + RMAP_PICK_MORE, setup, err);
out:
    return st;
}

/* Rays of weight 1, one reading of each. */
static enum rmap_status read_plain(struct rmap_stats_reader *reader,
                                   const struct rmap_stats_setup *setup,
                                   const struct rmap_matched *rays, int32_t source,
                                   struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_readings *readings = &reader->readings;
    const size_t n_ray = rays->portion->n_row[RMAP_TABLE_RAY];
    RMAP_TRY(
        hold(&reader->run, &reader->run_cap, RMAP_STATS_SOURCES_FEW + 1, sizeof *reader->run, err));
    *block = (struct rmap_stats_block){
        .n = readings->n, .value = {readings->at[0], readings->at[1]}, .run = reader->run};
    if (readings->n == 0)
        return RMAP_OK;
    if (source >= 0) {
        block->n_run = 1;
        reader->run[0] = (struct rmap_stats_run){readings->n, rmap_stats_class_of(setup, source)};
        return RMAP_OK;
    }
    RMAP_TRY(hold(&reader->source, &reader->source_cap, n_ray + 1, sizeof *reader->source, err));
    RMAP_TRY(reserve_arranged(&reader->arranged, readings->n + RMAP_PICK_MORE, setup, err));
    arrange_rays(reader, setup, sources_of(reader, rays), block);
out:
    return st;
}

enum rmap_status rmap_stats_reader_read(struct rmap_stats_reader *reader,
                                        const struct rmap_stats_setup *setup,
                                        const struct rmap_matched *rays,
                                        struct rmap_stats_block *block, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_readings *readings = &reader->readings;
    bool all_one = true;
    const double *column[RMAP_QUANTITIES_MAX] = {NULL};
    const int32_t *of = NULL;
    int32_t source = -1;
    readings->lean = false;
    if (setup->by != RMAP_STATS_BY_DETECTOR)
        RMAP_TRY(find_source(setup, rays, &source, &of, err));
    if (setup->by != RMAP_STATS_BY_DETECTOR &&
        (setup->n_source <= RMAP_STATS_SOURCES_FEW || source >= 0))
        RMAP_TRY(rmap_fold_weights(rays, &readings->lean, err));
    if (readings->lean && rmap_quantities_stored(setup->quantities, rays, column)) {
        RMAP_TRY(reserve_stored(reader, setup, rays, err));
        if (rmap_stats_read_stored(reader, setup, rays, source, of, column, block))
            return RMAP_OK;
    }
    if (source < 0)
        RMAP_TRY(rmap_fold_fetch(rays, RMAP_COLUMN_BIT(RMAP_RAY_source), err));
    RMAP_TRY(rmap_quantities_read(setup->quantities, rays, readings, err));
    if (readings->lean)
        return read_plain(reader, setup, rays, source, block, err);
    RMAP_TRY(rmap_fold_fetch(rays, setup->quantities->deferred, err));
    RMAP_TRY(reserve(reader, readings->n + 1, err));
    for (size_t k = 0; k < readings->n; k++) {
        double weight = rays->portion->ray.weight[readings->ray[k]] * readings->share[k];
        reader->weight[k] = weight;
        all_one = all_one && weight == 1.0;
    }
    if (setup->by != RMAP_STATS_BY_DETECTOR)
        tag(reader, setup, rays->portion);
    for (size_t first = 0, end = 0; setup->by == RMAP_STATS_BY_DETECTOR && first < readings->n;
         first = end) {
        for (end = first + 1; end < readings->n && readings->ray[end] == readings->ray[first];)
            end++;
        tag_ray(reader, setup, rays->portion, first, end);
    }
    *block = (struct rmap_stats_block){.n = readings->n,
                                       .value = {readings->value[0], readings->value[1]},
                                       .tag = reader->tag,
                                       .weight = all_one ? NULL : reader->weight};
    if (readings->n > 0)
        st = arrange(reader, setup, block, err);
out:
    return st;
}

/* SPDX-License-Identifier: MIT
 *
 * Which rank works on which portions of a map, known to every rank.
 */
#include "mpi/parallel/deal.h"

#include "base/alloc.h"
#include "io/map/map_held.h"

static uint64_t rows(const struct rmap_map *map, size_t portion)
{
    const struct rmap_portion_info *info = rmap_map_portion(map, portion);
    return info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT];
}

static void find_owners(const struct rmap_map *map, enum rmap_deal_kind kind, int size,
                        uint32_t *owner)
{
    size_t n = rmap_map_n_portion(map), n_rank = (size_t)size;
    double total = 0.0, before = 0.0;
    for (size_t i = 0; i < n; i++)
        total += (double)rows(map, i);
    for (size_t i = 0; i < n; i++) {
        size_t shard = (size_t)rmap_map_portion(map, i)->shard;
        size_t share = (size_t)(before / total * (double)n_rank); /* where it begins */
        before += (double)rows(map, i);
        owner[i] = (uint32_t)(kind == RMAP_DEAL_LOCAL    ? shard % n_rank
                              : kind == RMAP_DEAL_SHARES ? (share < n_rank ? share : n_rank - 1)
                                                         : i / RMAP_DEAL_STEP_MAX % n_rank);
    }
}

enum rmap_status rmap_deal_init(const struct rmap_map *map, enum rmap_deal_kind kind, int size,
                                struct rmap_deal *deal, struct rmap_error *err)
{
    size_t n = rmap_map_n_portion(map), n_rank = (size_t)size;
    if (rmap_map_is_held(map)) /* nobody else can read it */
        kind = RMAP_DEAL_LOCAL;
    *deal = (struct rmap_deal){.step = RMAP_DEAL_STEP_MAX,
                               .portion = rmap_alloc(n, sizeof *deal->portion),
                               .first = rmap_alloc(n_rank + 2, sizeof *deal->first)};
    uint32_t *owner = rmap_alloc(n, sizeof *owner);
    if (!deal->portion || !deal->first || !owner) {
        rmap_free(owner);
        rmap_deal_fini(deal);
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the list of portions");
    }
    if (kind == RMAP_DEAL_LOCAL) /* rank 0 holds a part of every rank at a time */
        deal->step = n_rank < RMAP_DEAL_STEP_MAX ? RMAP_DEAL_STEP_MAX / n_rank : 1;
    find_owners(map, kind, size, owner);
    for (size_t i = 0; i < n; i++)
        deal->first[owner[i] + 2]++;
    for (size_t r = 2; r <= n_rank; r++)
        deal->first[r] += deal->first[r - 1];
    for (size_t i = 0; i < n; i++)
        deal->portion[deal->first[owner[i] + 1]++] = i;
    rmap_free(owner);
    return RMAP_OK;
}

void rmap_deal_fini(struct rmap_deal *deal)
{
    rmap_free(deal->portion);
    rmap_free(deal->first);
    *deal = (struct rmap_deal){0};
}

size_t rmap_deal_n_part(const struct rmap_deal *deal, int rank)
{
    return (deal->first[rank + 1] - deal->first[rank] + deal->step - 1) / deal->step;
}

const size_t *rmap_deal_part(const struct rmap_deal *deal, int rank, size_t part, size_t *n_ret)
{
    size_t from = deal->first[rank] + part * deal->step, left = deal->first[rank + 1] - from;
    *n_ret = left < deal->step ? left : deal->step;
    return deal->portion + from;
}

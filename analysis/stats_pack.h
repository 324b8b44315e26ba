/* SPDX-License-Identifier: MIT
 *
 * Readings on their way to another rank: functions of rmap_stats_gather_kind, and what they share
 * with the others.
 */
#ifndef RMAP_STATS_PACK_H
#define RMAP_STATS_PACK_H

#include "analysis/stats_gather.h"

static inline size_t rmap_stats_n_range(const struct rmap_stats_setup *setup)
{
    return setup->n_group * setup->quantities->n;
}

/* Room for n readings in n_part parts. Tags and weights of plain parts are never touched: no
 * memory stands behind them. */
enum rmap_status rmap_stats_gathered_reserve(struct rmap_stats_gathered *gathered, size_t n,
                                             size_t n_part, bool tags,
                                             struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_stats_gathered_pack(const void *state, uint8_t **bytes_ret,
                                          size_t *nbytes_ret, struct rmap_error *err);
enum rmap_status rmap_stats_gathered_unpack(const void *context, const uint8_t *bytes,
                                            size_t nbytes, void **state_ret,
                                            struct rmap_error *err);

#endif

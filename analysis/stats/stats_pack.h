/* SPDX-License-Identifier: MIT
 *
 * Readings on their way to another rank: functions of rmap_stats_gather_kind, and what they share
 * with the others.
 */
#ifndef RMAP_STATS_PACK_H
#define RMAP_STATS_PACK_H

#include "analysis/stats/stats_gather.h"

static inline size_t rmap_stats_n_range(const struct rmap_stats_setup *setup)
{
    return setup->n_group * setup->quantities->n;
}

/* Room for a part of n readings, which are to be filled in. */
enum rmap_status rmap_stats_gathered_add_part(struct rmap_stats_gathered *gathered, size_t n,
                                              bool plain, struct rmap_stats_part **part_ret,
                                              struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_stats_gathered_pack(const void *state, uint8_t **bytes_ret,
                                          size_t *nbytes_ret, struct rmap_error *err);
enum rmap_status rmap_stats_gathered_unpack(const void *context, const uint8_t *bytes,
                                            size_t nbytes, void **state_ret,
                                            struct rmap_error *err);

#endif

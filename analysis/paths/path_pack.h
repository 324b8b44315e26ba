/* SPDX-License-Identifier: MIT
 *
 * Classes of paths on their way to another rank: functions of rmap_path_count_kind.
 */
#ifndef RMAP_PATH_PACK_H
#define RMAP_PATH_PACK_H

#include "analysis/paths/path_count.h"

enum rmap_status rmap_path_counts_pack(const void *state, uint8_t **bytes_ret, size_t *nbytes_ret,
                                       struct rmap_error *err);
enum rmap_status rmap_path_counts_unpack(const void *context, const uint8_t *bytes, size_t nbytes,
                                         void **state_ret, struct rmap_error *err);

#endif

/* SPDX-License-Identifier: MIT
 *
 * Statistics as files.
 */
#ifndef RMAP_STATS_OUT_H
#define RMAP_STATS_OUT_H

#include "analysis/stats/stats_text.h"

/* ".csv", ..., NULL. */
extern const char *const rmap_stats_suffixes[];

/* Not collective; the file's name says what it is. RMAP_SYSTEM. */
enum rmap_status rmap_stats_write(const struct rmap_stats *stats,
                                  const struct rmap_stats_labels *labels, const char *path,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Whether the rays that a map keeps by name are sound. Stale ones are: nobody uses them.
 */
#ifndef RMAP_VERIFY_NAMED_H
#define RMAP_VERIFY_NAMED_H

#include "io/recovery/verify.h"

enum rmap_status rmap_verify_named_rays(const struct rmap_map *map, struct rmap_findings *findings,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Removes those that are damaged: they can be selected again. */
enum rmap_status rmap_remove_damaged_rays(const struct rmap_map *map, struct rmap_findings *done,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif

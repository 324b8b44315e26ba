/* SPDX-License-Identifier: MIT
 *
 * What every file of a map says of its origin, as attributes of its root.
 */
#ifndef RMAP_PROVENANCE_H
#define RMAP_PROVENANCE_H

#include "io/h5.h"
#include "io/map_writer.h"

/* 32 hex digits of XXH3-128 over the packed bundle: which scene this is. */
enum rmap_status rmap_scene_digest(const struct rmap_bundle *bundle, char text[33],
                                   struct rmap_error *err) RMAP_MUST_USE;

enum rmap_status rmap_provenance_put(struct rmap_h5 *h5, const char *filetype,
                                     const struct rmap_run *run, const char *scene_digest,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* Checks filetype and version of an open file. RMAP_FORMAT, with what to do. */
enum rmap_status rmap_provenance_check(struct rmap_h5 *h5, const char *filetype,
                                       struct rmap_error *err) RMAP_MUST_USE;

#endif

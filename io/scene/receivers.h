/* SPDX-License-Identifier: MIT
 *
 * A file of receivers: detectors that were not in the scene when it was traced, to be laid over
 * its map. The keys are those of `detectors:` in a scene file (docs/scene.md).
 */
#ifndef RMAP_RECEIVERS_H
#define RMAP_RECEIVERS_H

#include <stddef.h>

#include "io/file/diagnostics.h"
#include "io/mesh/bundle.h"

struct rmap_receivers {
    const char *path; /* for messages */
    const char *text; /* [nbytes] */
    size_t nbytes;
    struct rmap_diagnostics *diagnostics; /* mistakes in the text, each with its place */
};

/* Reads such a file's text (regular file or pipe, at most 1 MiB); rmap_free. RMAP_INPUT: missing, a
 * directory, empty or binary; RMAP_SYSTEM: no permission, no memory. */
enum rmap_status rmap_receivers_open(const char *path, char **text_ret, size_t *nbytes_ret,
                                     struct rmap_error *err) RMAP_MUST_USE;

/* The scene of a bundle that carries all its meshes (a map's), in the colours and with the parts
 * that the options choose, with the receivers behind its own detectors; what was left out of the
 * scene leaves them untouched. RMAP_INPUT with the mistakes in receivers->diagnostics. */
enum rmap_status rmap_scene_read_receivers(const struct rmap_bundle *bundle,
                                           const struct rmap_scene_options *options,
                                           const struct rmap_receivers *receivers,
                                           struct rmap_scene **scene_ret,
                                           struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Parts of a scene that stand in files of their own. Their texts are put behind that of the scene,
 * each behind a line that says whose it is: so the scene stays one text, which maps keep and ranks
 * hand on.
 */
#ifndef RMAP_SCENE_INCLUDE_H
#define RMAP_SCENE_INCLUDE_H

#include "io/mesh/bundle.h"

/* Such a line, before the file's name, and how many a scene may have. */
#define RMAP_INCLUDE_MARK "--- # include: "
#define RMAP_INCLUDE_MAX  64

/* Reads the files that `include` names, relative to the scene's folder, unless the text goes on
 * with them already. What cannot be read, and what the text has unnamed, is put into diagnostics.
 * RMAP_SYSTEM when memory is short. */
enum rmap_status rmap_scene_include_files(struct rmap_bundle *bundle,
                                          struct rmap_diagnostics *diagnostics,
                                          struct rmap_error *err) RMAP_MUST_USE;

/* A file's own part of such a text; the name is not ended, and empty for the scene's own. */
struct rmap_include_part {
    const char *name, *text;
    size_t n_name, nbytes;
};

/* The next; *at: the whole text at first. false: there are no more. */
bool rmap_include_next(const char **at, struct rmap_include_part *part);

/* Where a part's file is, and the text that it is to have; both rmap_free, NULL when memory is
 * short. */
char *rmap_include_path(const char *scene_path, const struct rmap_include_part *part);
char *rmap_include_text(const struct rmap_include_part *part);

/* Is a file of that name outside of the scene's folder? */
bool rmap_include_stands_elsewhere(const char *name);

/* Has the file that text? */
bool rmap_include_is_stored(const struct rmap_include_part *part, const char *path);

#endif

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

/* Reads the files that `include` names, relative to the scene's folder, unless the bundle has them.
 * What cannot be read is put into diagnostics, where it is named. RMAP_SYSTEM when memory is short.
 */
enum rmap_status rmap_scene_include_files(struct rmap_bundle *bundle,
                                          struct rmap_diagnostics *diagnostics,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif

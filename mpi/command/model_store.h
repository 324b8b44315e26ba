/* SPDX-License-Identifier: MIT
 *
 * The folder of an imported model: scene.yaml and attributes.yaml, which are the user's, parts.yaml
 * and meshes/, which are made of the model.
 */
#ifndef RMAP_MODEL_STORE_H
#define RMAP_MODEL_STORE_H

#include "io/assembly/assembly_match.h"

/* "FOLDER/name"; rmap_free. */
char *rmap_model_path(const char *folder, const char *name);

/* RMAP_USAGE: a text that is to be written anew has edits, unless `force`. with_user: of all three,
 * else of parts.yaml alone. */
enum rmap_status rmap_model_check_edits(const char *folder, bool with_user, bool force,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* What the folder was made of; meshes that are not as they were written are findings, and of no
 * shape any more. RMAP_USAGE: it is of no model. */
enum rmap_status rmap_model_read_stored(const char *folder, struct rmap_assembly *assembly,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* Texts that were taken away, which an update makes anew. */
enum rmap_status rmap_model_tell_missing(const char *folder, struct rmap_diagnostics *findings,
                                         struct rmap_error *err) RMAP_MUST_USE;

struct rmap_model_stored {
    size_t n_mesh_written, n_mesh_kept, n_mesh_removed;
    char *kept[3]; /* copies of texts with edits; NULL: none */
};
void rmap_model_stored_fini(struct rmap_model_stored *stored);

/* Writes meshes that the match (NULL: an import) does not keep, the assembly, parts.yaml and, of an
 * import, the user's files, of an update those of them that are not there; removes mesh files of
 * `before` (or NULL) that nothing has any more. */
enum rmap_status rmap_model_store(const char *folder, const char *made,
                                  struct rmap_assembly *assembly,
                                  const struct rmap_assembly *before,
                                  const struct rmap_assembly_match *match, bool force,
                                  struct rmap_model_stored *stored,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

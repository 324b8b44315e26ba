/* SPDX-License-Identifier: MIT
 *
 * What an import of a model found, and what an update changed: for people, and as JSON.
 */
#ifndef RMAP_MODEL_OUT_H
#define RMAP_MODEL_OUT_H

#include <stdio.h>

#include "mpi/command/model_store.h"

void rmap_model_print(const struct rmap_assembly *assembly, const char *scene, FILE *out);
json_t *rmap_model_json(const struct rmap_assembly *assembly, const char *path, const char *scene);

struct rmap_model_revision {
    const struct rmap_assembly *before, *after;
    const struct rmap_assembly_match *match;
    const struct rmap_model_stored *stored;
    const struct rmap_diagnostics *rules; /* [RMAP_MODEL_RULE_FILES] */
    bool dry_run;
};
void rmap_revision_print(const struct rmap_model_revision *revision, const char *scene, FILE *out);
json_t *rmap_revision_json(const struct rmap_model_revision *revision, const char *path,
                           const char *scene);

#endif

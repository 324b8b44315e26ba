/* SPDX-License-Identifier: MIT
 *
 * The names that objects go by at a level of paths.
 */
#ifndef RMAP_PATH_LABEL_H
#define RMAP_PATH_LABEL_H

#include "analysis/paths/path_key.h"

struct rmap_path_labels {
    size_t n;
    const char **name;  /* [n], borrowed from the scene */
    int32_t *of_object; /* [n_object] */
};

/* Labels are numbered by their first objects. Released by fini whatever happened. */
enum rmap_status rmap_path_labels_init(struct rmap_path_labels *labels,
                                       const struct rmap_scene *scene, enum rmap_path_level level,
                                       struct rmap_error *err) RMAP_MUST_USE;
void rmap_path_labels_fini(struct rmap_path_labels *labels);

#endif

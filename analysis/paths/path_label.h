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

#endif

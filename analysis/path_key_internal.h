/* SPDX-License-Identifier: MIT
 *
 * What path_key.c and path_text.c share.
 */
#ifndef RMAP_PATH_KEY_INTERNAL_H
#define RMAP_PATH_KEY_INTERNAL_H

#include <string.h>

#include "analysis/path_label.h"

enum { RMAP_PATH_LETTER_ANY = 13, RMAP_PATH_LETTER_BITS = 4 };

/* Places of symbols: 0 none, 1 + label, then media, then detectors. */
struct rmap_path_keys {
    const struct rmap_scene *scene;
    struct rmap_path_view view;
    struct rmap_path_labels labels;
    uint8_t *letter;  /* [2^13] of sets of events */
    uint8_t *met;     /* [2^13] the same at an object: ANY without events */
    uint32_t *place;  /* [n_object] of its label, above the letter */
    uint8_t *follows; /* [n_detector] registers behind the step that ends the leg */
    uint8_t *clashes; /* [n_medium] an object or a group has the name, too */
    bool reads_media; /* something can happen inside one */
};

#endif

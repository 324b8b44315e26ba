/* SPDX-License-Identifier: MIT
 *
 * What path_key.c and path_text.c share.
 */
#ifndef RMAP_PATH_KEY_INTERNAL_H
#define RMAP_PATH_KEY_INTERNAL_H

#include <string.h>

#include "analysis/criterion/path_table.h"
#include "analysis/paths/path_label.h"

enum { RMAP_PATH_LETTER_ANY = 13, RMAP_PATH_LETTER_BITS = 4 };

/* Of a detector. */
struct rmap_path_hit {
    rmap_path_step step;
    uint32_t follows; /* 1: registers behind the step that ends the segment */
};

/* Places of symbols: 0 none, 1 + label, then media, then detectors. */
struct rmap_path_keys {
    const struct rmap_scene *scene;
    struct rmap_path_view view;
    struct rmap_path_labels labels;
    uint8_t *letter; /* [2^13] of sets of events */
    uint8_t *met;    /* [2^13] the same at an object: ANY without events */
    uint32_t *place; /* [1 + n_object] of no object, then of each one's label, above the letter */
    struct rmap_path_hit *hit; /* [n_detector] */
    uint8_t *clashes;          /* [n_medium] an object or a group has the name, too */
    bool reads_media;          /* something can happen inside one */
};

/* The step that ends the segment in this row. */
static inline rmap_path_step rmap_path_step_of(const struct rmap_path_keys *keys,
                                               const struct rmap_segment_columns *rows, size_t row)
{
    const uint32_t events = rows->event[row] % RMAP_PATH_EVENT_CODES;
    if (rows->object[row] >= 0)
        return keys->place[rows->object[row] + 1] | keys->met[events];
    const uint32_t letter = keys->letter[events];
    if (!(RMAP_PATH_INSIDE >> letter & 1) || !rows->medium || rows->medium[row] < 0)
        return letter;
    /* Absorption and scattering without an object are told by their medium. */
    return (rmap_path_step)((1 + keys->labels.n + (size_t)rows->medium[row])
                            << RMAP_PATH_LETTER_BITS) |
           letter;
}

#endif

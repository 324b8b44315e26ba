/* SPDX-License-Identifier: MIT
 *
 * Text for a terminal: what would steer it is written as an escape instead. Names come from scenes,
 * maps, folders and command lines of strangers.
 */
#ifndef RMAP_VISIBLE_TEXT_H
#define RMAP_VISIBLE_TEXT_H

#include <stddef.h>

/* Of a UTF-8 sequence that has begun and may go on in the next bytes. Zeroed at the start. */
struct rmap_visible_text {
    unsigned char begun[4];
    size_t n_begun;
};

/* Room for what may come of `nbytes` bytes, and of a sequence that was begun before them. */
#define RMAP_VISIBLE_NBYTES(nbytes) (6 * ((nbytes) + 4))

/* Copies bytes to `out` and returns how many it wrote there: control characters (C0 but newline and
 * tab, DEL, C1) and marks of direction (the trick of CVE-2021-42574) become \uXXXX, which in a JSON
 * string is the same character; bytes that are no UTF-8 become \xXX. */
size_t rmap_visible_text(struct rmap_visible_text *state, const char *bytes, size_t nbytes,
                         char *out);

#endif

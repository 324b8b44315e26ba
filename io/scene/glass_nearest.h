/* SPDX-License-Identifier: MIT
 *
 * Which glass of the catalogue may be meant by a name that it does not have.
 */
#ifndef RMAP_GLASS_NEAREST_H
#define RMAP_GLASS_NEAREST_H

#include <stddef.h>

/* The name behind a prefix of one or two letters and a hyphen (N-, S-, H-: free of lead). */
const char *rmap_glass_stem(const char *name);

/* How much a name differs from another, in half edits; a missing or other prefix counts one. */
size_t rmap_glass_difference(const char *name, const char *other);

/* Names that differ least, or by half an edit more, into a text that may be NULL: "'N-SK16',
 * 'J-SK16'"; "" where none is near. Returns by how much the nearest differs; where none is near,
 * what would just be. */
size_t rmap_glass_nearest(const char *name, char *text, size_t nbytes);

#endif

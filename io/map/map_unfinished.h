/* SPDX-License-Identifier: MIT
 *
 * Files that killed writers left in a map, of which nothing counts: halves of an index, of named
 * rays, of kept columns, and of pieces without a journal.
 */
#ifndef RMAP_MAP_UNFINISHED_H
#define RMAP_MAP_UNFINISHED_H

#include "io/file/findings.h"

/* Adds each of them; none while a writer is at work. RMAP_SYSTEM. */
enum rmap_status rmap_map_note_unfinished(const char *map_path, struct rmap_findings *findings,
                                          struct rmap_error *err) RMAP_MUST_USE;

#endif

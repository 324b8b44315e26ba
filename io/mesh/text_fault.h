/* SPDX-License-Identifier: MIT
 *
 * Where a mesh that is text is wrong, since assimp does not tell.
 */
#ifndef RMAP_TEXT_FAULT_H
#define RMAP_TEXT_FAULT_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* The first line of an OBJ, or of an STL file that is text, that assimp may have stumbled over,
 * with what is wrong; false: none is found. Bytes behind which stands a 0. */
bool rmap_obj_fault(const uint8_t *bytes, size_t nbytes, char *why, size_t why_nbytes);
bool rmap_stl_fault(const uint8_t *bytes, size_t nbytes, char *why, size_t why_nbytes);

#endif

/* SPDX-License-Identifier: MIT
 *
 * HDF5's shuffle: byte k of every element together, k = 0 first, and back.
 */
#ifndef RMAP_SHUFFLE_H
#define RMAP_SHUFFLE_H

#include <stddef.h>
#include <stdint.h>

/* n elements to planes that begin `stride` bytes after each other. element_nbytes: 1, 2, 4 or 8;
 * element arrays are aligned as such. Little-endian machines. */
void rmap_shuffle(const void *element, size_t n, size_t element_nbytes, uint8_t *plane,
                  size_t stride);

/* Elements [first, first + n_range) of planes of n elements. */
void rmap_unshuffle(const uint8_t *plane, size_t n, size_t first, size_t n_range,
                    size_t element_nbytes, void *element);

#endif

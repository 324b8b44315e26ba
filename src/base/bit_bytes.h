/* SPDX-License-Identifier: MIT
 *
 * A bit each as a byte each.
 */
#ifndef RMAP_BIT_BYTES_H
#define RMAP_BIT_BYTES_H

#include <stddef.h>
#include <stdint.h>

/* byte [n]: `is` for bits that are set, `other` for the others. */
void rmap_bits_to_bytes(const uint64_t *bits, size_t n, uint8_t is, uint8_t other, uint8_t *byte);

#endif

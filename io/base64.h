/* SPDX-License-Identifier: MIT
 *
 * Bytes as text (RFC 4648, section 4).
 */
#ifndef RMAP_BASE64_H
#define RMAP_BASE64_H

#include <stddef.h>
#include <stdint.h>

/* Four characters for the first three of n bytes, n >= 1; '=' where there are fewer. */
void rmap_base64_four(const uint8_t *bytes, size_t n, char four[4]);

#endif

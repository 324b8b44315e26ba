/* SPDX-License-Identifier: MIT
 *
 * Bytes as text (RFC 4648, section 4).
 */
#ifndef RMAP_BASE64_H
#define RMAP_BASE64_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* Four characters for the first three of n bytes, n >= 1; '=' where there are fewer. */
void rmap_base64_four(const uint8_t *bytes, size_t n, char four[4]);

/* The bytes of n characters, at most n / 4 * 3 of them. False where it is no such text. */
bool rmap_base64_bytes(const char *text, size_t n, uint8_t *bytes, size_t *nbytes_ret);

#endif

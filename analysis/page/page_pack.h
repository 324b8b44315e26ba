/* SPDX-License-Identifier: MIT
 *
 * Arrays of numbers inside JSON: an object {"t": type, "d": little-endian bytes in base64} with
 * the types f32, f64, u8, u16, i32, u64; integers may say "o", which is to be added to each of
 * them. Every function returns a new reference, or NULL when memory is short.
 */
#ifndef RMAP_PAGE_PACK_H
#define RMAP_PAGE_PACK_H

#include <jansson.h>
#include <stddef.h>
#include <stdint.h>

#include "base/vec.h"

json_t *rmap_page_floats(const float *value, size_t n);
json_t *rmap_page_doubles(const double *value, size_t n);
json_t *rmap_page_words(const uint64_t *value, size_t n);
json_t *rmap_page_bytes(const uint8_t *value, size_t n);
json_t *rmap_page_shorts(const uint16_t *value, size_t n);

/* In the narrowest type that holds them all. */
json_t *rmap_page_integers(const int32_t *value, size_t n);

/* The text without what is not UTF-8; null for NULL. */
json_t *rmap_page_string(const char *text);

json_t *rmap_page_vector(struct rmap_vec3 v);

#endif

/* SPDX-License-Identifier: MIT
 *
 * A bundle as bytes, for broadcasting and for keeping inside a map. Little-endian; a text is its
 * length (64 bits; all ones: none) and its bytes; arrays follow their counts. What came later
 * stands at the end, where there is any, each in its turn.
 */
#ifndef RMAP_BUNDLE_PACK_H
#define RMAP_BUNDLE_PACK_H

#include "io/mesh/bundle.h"

/* Little-endian bytes that hold the whole bundle, and back. *blob_ret: rmap_free. Every length in
 * a blob is checked: RMAP_FORMAT when it is not one. */
enum rmap_status rmap_bundle_pack(const struct rmap_bundle *bundle, uint8_t **blob_ret,
                                  size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;
/* XXH3-128 of these bytes. RMAP_SYSTEM. */
enum rmap_status rmap_bundle_digest(const struct rmap_bundle *bundle, char text[33],
                                    struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_bundle_unpack(const uint8_t *blob, size_t nbytes,
                                    struct rmap_bundle **bundle_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif

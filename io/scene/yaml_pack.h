/* SPDX-License-Identifier: MIT
 *
 * A YAML tree as bytes, kept of a scene's text for later starts: it is read in a tenth of the time.
 */
#ifndef RMAP_YAML_PACK_H
#define RMAP_YAML_PACK_H

#include <stdint.h>

#include "io/scene/yaml_tree.h"

/* *bytes_ret: rmap_free. RMAP_SYSTEM. */
enum rmap_status rmap_yaml_pack(const struct rmap_yaml_node *root, uint8_t **bytes_ret,
                                size_t *nbytes_ret, struct rmap_error *err) RMAP_MUST_USE;

/* RMAP_FORMAT: the bytes are no tree; RMAP_SYSTEM. */
enum rmap_status rmap_yaml_unpack(const uint8_t *bytes, size_t nbytes,
                                  struct rmap_yaml_node **root_ret,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Media: refractive index and absorption on the scene's channels.
 */
#ifndef RMAP_SCENE_MEDIA_H
#define RMAP_SCENE_MEDIA_H

#include "io/scene/scene_reader.h"

/* `key` names a medium, or a glass of the catalogue, which then becomes one. *medium_ret is
 * untouched when the key is absent. NULL: the name is only looked up. */
void rmap_reader_medium(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, int32_t *medium_ret);

/* A new medium `vacuum` of index 1; there must be none of that name. */
void rmap_reader_vacuum(struct rmap_reader *reader, int32_t *medium_ret);

void rmap_reader_read_media(struct rmap_reader *reader);

#endif

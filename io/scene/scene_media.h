/* SPDX-License-Identifier: MIT
 *
 * Media: refractive index and absorption on the scene's channels.
 */
#ifndef RMAP_SCENE_MEDIA_H
#define RMAP_SCENE_MEDIA_H

#include "io/scene/scene_reader.h"

/* `key` names a medium, or a glass of the built-in list, which then becomes one. *medium_ret is
 * untouched when the key is absent. */
void rmap_reader_medium(struct rmap_reader *reader, const struct rmap_yaml_node *map,
                        const char *key, int32_t *medium_ret);

/* The glass that `glass` of the mapping names; NULL after a complaint. */
const struct rmap_glass *rmap_reader_glass(struct rmap_reader *reader,
                                           const struct rmap_yaml_node *node);

/* {B: [..], C: [..]}, with C brought to um^2 from the square of unit_um. False after a complaint.
 */
bool rmap_reader_sellmeier(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                           double unit_um, struct rmap_sellmeier *sellmeier);

/* A new medium `vacuum` of index 1; there must be none of that name. */
void rmap_reader_vacuum(struct rmap_reader *reader, int32_t *medium_ret);

void rmap_reader_read_media(struct rmap_reader *reader);

#endif

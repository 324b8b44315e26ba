/* SPDX-License-Identifier: MIT
 *
 * Sources of light.
 */
#ifndef RMAP_SCENE_SOURCES_H
#define RMAP_SCENE_SOURCES_H

#include "io/scene/scene_reader.h"

void rmap_reader_read_sources(struct rmap_reader *reader);

/* `air`, `vacuum`, or what most objects stand in; else a vacuum is made. */
void rmap_reader_surrounding_medium(struct rmap_reader *reader, int32_t *medium_ret);

#endif

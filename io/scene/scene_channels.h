/* SPDX-License-Identifier: MIT
 *
 * The sections that everything else is measured by: units, limits, spectrum.
 */
#ifndef RMAP_SCENE_CHANNELS_H
#define RMAP_SCENE_CHANNELS_H

#include "io/scene/scene_reader.h"

/* The unit of length that `key` names; NULL when absent or wrong. */
const struct rmap_written_unit *rmap_reader_length_unit(struct rmap_reader *reader,
                                                        const struct rmap_yaml_node *map,
                                                        const char *key);

/* Channel of a wavelength; -1 after a complaint. */
int32_t rmap_reader_channel(struct rmap_reader *reader, const struct rmap_yaml_node *at,
                            double wavelength_nm);

void rmap_reader_read_units(struct rmap_reader *reader);

void rmap_reader_read_limits(struct rmap_reader *reader);

void rmap_reader_limits(struct rmap_reader *reader, const struct rmap_yaml_node *node);

void rmap_reader_read_channels(struct rmap_reader *reader);

#endif

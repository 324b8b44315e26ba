/* SPDX-License-Identifier: MIT
 *
 * A picture of all that is around, as light: of a sky of model `environment`, or of `background`.
 */
#ifndef RMAP_SCENE_ENVIRONMENT_H
#define RMAP_SCENE_ENVIRONMENT_H

#include "io/scene/scene_skies.h"

/* Is there a `background` that sends rays? */
bool rmap_reader_background_shines(const struct rmap_reader *reader);

/* `file`, `map` and `unit`: the picture's numbers as bands of the source's sky. */
void rmap_reader_read_environment(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                                  struct rmap_source *source, struct rmap_source_light *light,
                                  struct rmap_sky_plan *plan);

/* Once it is known whether sources are in W or lm: radiances, and what channels a band lies on.
 * False after a complaint. */
bool rmap_reader_colour_environment(struct rmap_reader *reader, const struct rmap_sky_plan *plan,
                                    struct rmap_source *source);
/* The mean colour of what comes in. */
void rmap_environment_mean(struct rmap_source *source, int n_channel);

#endif

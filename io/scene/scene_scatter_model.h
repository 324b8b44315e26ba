/* SPDX-License-Identifier: MIT
 *
 * A scatter model's parameters, and what they make of it.
 */
#ifndef RMAP_SCENE_SCATTER_MODEL_H
#define RMAP_SCENE_SCATTER_MODEL_H

#include "io/scene/scene_reader.h"
#include "scatter/scatter.h"

struct rmap_model_read {
    const struct rmap_yaml_node *node;
    struct rmap_scatter *its; /* the last row of the scene's */
    bool relative;            /* a table is of what is reflected, or let pass */
    bool has_tis;             /* how much it scatters is said */
};

/* The mapping under `key`, which is there. False after a complaint. */
bool rmap_reader_read_model(struct rmap_reader *reader, const struct rmap_yaml_node *node,
                            const char *key, bool passes, struct rmap_model_read *read);

/* Those whose parameters say a shape alone take `tis`, or all of the reflectance. */
bool rmap_scatter_is_shape_alone(enum rmap_scatter_model model);
void rmap_scatter_set_amount(struct rmap_scatter *its, int n_channel, const double *share);

#endif

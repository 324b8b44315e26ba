/* SPDX-License-Identifier: MIT
 *
 * Light that arrives at the cells of objects, and that is absorbed there: a kind of fold.
 */
#ifndef RMAP_IRRADIANCE_SUMS_H
#define RMAP_IRRADIANCE_SUMS_H

#include "analysis/detector/cell_sums.h"
#include "analysis/detector/irradiance_cells.h"
#include "analysis/query/fold.h"

/* ARRIVING: what comes, before anything becomes of it; ABSORBED: of it. In weights of rays, of
 * `luminous` in lm. */
enum rmap_irradiance_what {
    RMAP_IRRADIANCE_ARRIVING,
    RMAP_IRRADIANCE_ABSORBED,
    RMAP_IRRADIANCE_PARTS
};

struct rmap_irradiance_ask {
    const struct rmap_map *map;                /* borrowed */
    const struct rmap_irradiance_cells *cells; /* borrowed */
    enum rmap_side side;                       /* from which light comes */
    bool luminous; /* sources in W: V(lambda) makes lm of the light's wavelengths */
};

struct rmap_irradiance_sums {
    const struct rmap_irradiance_ask *ask;
    double unit; /* of amounts: 1; of `luminous` the most lm that a W of any channel has */
    struct rmap_cell_sums cell[RMAP_IRRADIANCE_PARTS], object[RMAP_IRRADIANCE_PARTS];
};

/* The context is a struct rmap_irradiance_ask; states are struct rmap_irradiance_sums. RMAP_USAGE
 * from `create` when they would take too much memory. */
extern const struct rmap_fold_kind rmap_irradiance_kind;
rmap_column_set rmap_irradiance_columns(const struct rmap_irradiance_ask *ask);

#endif

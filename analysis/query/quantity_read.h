/* SPDX-License-Identifier: MIT
 *
 * Values of quantities: places first (rays, or registrations), then each quantity at all of them.
 */
#ifndef RMAP_QUANTITY_READ_H
#define RMAP_QUANTITY_READ_H

#include "analysis/query/quantity.h"

/* False: no ray of the portion has a reading. */
bool rmap_quantities_may_count(const struct rmap_quantities *quantities,
                               const struct rmap_portion_info *portion);

/* Times which numbers in the map's unit are in that of the quantity. */
double rmap_quantity_scale(const struct rmap_quantities *quantities, size_t index);

void rmap_readings_fini(struct rmap_readings *readings);

/* Readings of the matching rays. The portion has the columns. RMAP_FORMAT when rows do not fit. */
enum rmap_status rmap_quantities_read(const struct rmap_quantities *quantities,
                                      const struct rmap_matched *rays,
                                      struct rmap_readings *readings,
                                      struct rmap_error *err) RMAP_MUST_USE;

#endif

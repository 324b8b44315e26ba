/* SPDX-License-Identifier: MIT
 *
 * /portion of a piece or of an index, with the last ids that files of picked rays have besides.
 */
#ifndef RMAP_PORTION_ROWS_H
#define RMAP_PORTION_ROWS_H

#include "io/map/map_format.h"

/* *portion_ret: rmap_free. fields: rmap_portion_fields_piece or _index. */
enum rmap_status rmap_portion_rows_read(struct rmap_h5 *h5, struct rmap_field_table fields,
                                        struct rmap_portion_info **portion_ret, size_t *n_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

/* picked: with the last ids. */
enum rmap_status rmap_portion_rows_write(struct rmap_h5 *h5, struct rmap_field_table fields,
                                         const struct rmap_portion_info *portion, size_t n,
                                         bool picked, struct rmap_error *err) RMAP_MUST_USE;

#endif

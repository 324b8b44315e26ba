/* SPDX-License-Identifier: MIT
 *
 * Tables of a piece against those of the index of the map (verify_piece.c).
 */
#ifndef RMAP_VERIFY_TABLES_H
#define RMAP_VERIFY_TABLES_H

#include "io/map/map_format.h"
#include "io/recovery/verify.h"

/* Findings for every dataset in which two lists of equal length differ; `file` says the first.
 * portion: whose rays they cost (NULL: none), row by row. */
struct rmap_table_pair {
    const char *file;
    const char *what; /* the other, "shard-00000/piece-00000.h5" */
    struct rmap_field_table table;
    const void *says, *is;
    size_t n, row_nbytes;
    const struct rmap_portion_info *portion;
};
enum rmap_status rmap_verify_tables(const struct rmap_table_pair *pair,
                                    struct rmap_findings *findings,
                                    struct rmap_error *err) RMAP_MUST_USE;

#endif

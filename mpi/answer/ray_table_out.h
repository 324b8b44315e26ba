/* SPDX-License-Identifier: MIT
 *
 * The matching rays of a query as tables of plain columns in an HDF5 file.
 */
#ifndef RMAP_RAY_TABLE_OUT_H
#define RMAP_RAY_TABLE_OUT_H

#include "io/map/map_reader.h"
#include "mpi/scan/ray_stream.h"

/* What goes into the file beside the rays. Borrowed. */
struct rmap_table_request {
    const char *path;
    const char *from;      /* the map, as it was named */
    const char *criterion; /* the question */
    const char *answer;    /* which of the rays that match: "all", "limit 10" */
    const char *columns;   /* see rmap_ray_table_create */
    const char *at;        /* of a file of rays: the detector, or NULL */
};

struct rmap_table_out;
enum rmap_status rmap_table_out_begin(const struct rmap_map *map,
                                      const struct rmap_table_request *request,
                                      struct rmap_table_out **out_ret,
                                      struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_table_out_take(struct rmap_table_out *out,
                                     const struct rmap_streamed_ray *ray,
                                     struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_table_out_finish(struct rmap_table_out *out,
                                       struct rmap_error *err) RMAP_MUST_USE;
/* Removes what was not finished. NULL is fine. */
void rmap_table_out_destroy(struct rmap_table_out *out);

#endif

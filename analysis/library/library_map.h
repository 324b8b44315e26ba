/* SPDX-License-Identifier: MIT
 *
 * A map as the library's callers hold it, and how they are told of failures.
 */
#ifndef RMAP_LIBRARY_MAP_H
#define RMAP_LIBRARY_MAP_H

#include "analysis/criterion/criterion.h"
#include "analysis/library/raymap.h"
#include "io/hdf5/h5_process.h"
#include "io/map/map_reader.h"

struct raymap_map {
    struct rmap_map *map;
};

/* A call of the library: HDF5 prints for the caller as it did, once it is left. */
struct rmap_library_call {
    struct rmap_h5_printing printing;
    struct rmap_error error;
};
struct rmap_library_call rmap_library_enter(void);
/* Returns the status as the caller is told, with the call's text in `error` where it failed. */
enum raymap_status rmap_library_leave(struct rmap_library_call *call, enum rmap_status status,
                                      struct raymap_error *error);

/* text NULL: all rays. */
enum rmap_status rmap_library_criterion(const struct rmap_map *map, const char *text,
                                        struct rmap_criterion **criterion_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif

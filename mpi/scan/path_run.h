/* SPDX-License-Identifier: MIT
 *
 * The classes of paths of a whole map: one pass over it, or a second one where there are more
 * classes than are counted at once, or where their peaks take too much memory.
 */
#ifndef RMAP_PATH_RUN_H
#define RMAP_PATH_RUN_H

#include "analysis/paths/path_report.h"
#include "mpi/command/command.h"

/* Classes, and cells with light of one class, that a thread counts exactly: tables of 64 MiB. */
#define RMAP_PATH_CLASSES_MOST ((uint64_t)3 << 18)
#define RMAP_PATH_CELLS_MOST   ((uint64_t)3 << 18)

/* All borrowed. */
struct rmap_path_request {
    const struct rmap_map *map;
    const struct rmap_overlay *overlay;
    const struct rmap_criterion *criterion; /* NULL: all rays */
    const struct rmap_which *which;         /* of registrations on view.detector; NULL: all count */
    const struct rmap_path_keys *keys;
    struct rmap_path_view view; /* that of the keys */
    enum rmap_path_sort sort;
    uint64_t top;
    uint64_t most_classes, most_cells;
    bool timed; /* mean times are wanted, which the map has */
};

/* Collective. *report_ret: on rank 0, NULL on the others. Where not all classes are counted, all
 * with the share report->bound of the flux are: 1e-5 or 2 / most_classes, unless there is no room.
 */
enum rmap_status rmap_path_run(const struct rmap_context *context,
                               const struct rmap_path_request *request,
                               struct rmap_path_report **report_ret,
                               struct rmap_error *err) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT */
#include "mpi/image_scan.h"

#include <stdatomic.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/agree.h"
#include "mpi/scan.h"

/* What one thread adds up. */
struct part {
    size_t first, last; /* portions */
    struct rmap_detector_sums sums;
    enum rmap_status status;
    struct rmap_error error;
};

struct scan {
    const struct rmap_map *map;
    const struct rmap_criterion *criterion;
    int n_part;
    struct part *part;
    _Atomic int next; /* part that the next free thread takes */
};

static void scan_parts(void *context, int thread)
{
    struct scan *scan = context;
    (void)thread;
    for (int i = atomic_fetch_add(&scan->next, 1); i < scan->n_part;
         i = atomic_fetch_add(&scan->next, 1)) {
        struct part *part = &scan->part[i];
        part->status = rmap_detector_sums_scan(&part->sums, scan->map, scan->criterion, part->first,
                                               part->last, &part->error);
    }
}

static enum rmap_status scan_share(const struct rmap_context *context, struct scan *scan,
                                   struct rmap_detector_sums *sums, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    size_t first, last;
    rmap_scan_range(scan->map, 0, rmap_map_n_portion(scan->map), context->rank, context->size,
                    &first, &last);
    scan->part = rmap_alloc((size_t)scan->n_part, sizeof *scan->part);
    if (!scan->part)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", scan->n_part);
    for (int i = 0; i < scan->n_part; i++) {
        RMAP_TRY(rmap_detector_sums_init(&scan->part[i].sums, scan->map, sums->detector,
                                         sums->n_colour > 0, err));
        rmap_scan_range(scan->map, first, last, i, scan->n_part, &scan->part[i].first,
                        &scan->part[i].last);
    }
    RMAP_TRY(rmap_workers_start(scan->n_part, scan_parts, scan, &workers, err));
    rmap_workers_join(workers);
    for (int i = 0; i < scan->n_part; i++) {
        if (scan->part[i].status != RMAP_OK) {
            *err = scan->part[i].error;
            RMAP_TRY(scan->part[i].status);
        }
        rmap_detector_sums_merge(sums, &scan->part[i].sums);
    }
out:
    for (int i = 0; scan->part && i < scan->n_part; i++)
        rmap_detector_sums_fini(&scan->part[i].sums);
    rmap_free(scan->part);
    return st;
}

/* Collective. In pieces that MPI's int counts hold. Whole numbers: exact in any order. */
static enum rmap_status reduce(const struct rmap_context *context, void *values, size_t n,
                               MPI_Datatype type, struct rmap_error *err)
{
    enum { PIECE = 1 << 24, VALUE_NBYTES = 8 };
    enum rmap_status st = RMAP_OK;
    for (size_t at = 0; at < n; at += PIECE) {
        int count = (int)(n - at < PIECE ? n - at : PIECE);
        void *from = (char *)values + at * VALUE_NBYTES;
        RMAP_TRY(RMAP_MPI(MPI_Reduce(context->rank == 0 ? MPI_IN_PLACE : from, from, count, type,
                                     MPI_SUM, 0, context->comm)));
    }
out:
    return st;
}

enum rmap_status rmap_image_scan(const struct rmap_context *context, const struct rmap_map *map,
                                 const struct rmap_criterion *criterion,
                                 struct rmap_detector_sums *sums, struct rmap_error *err)
{
    struct scan scan = {.map = map, .criterion = criterion, .n_part = context->n_thread};
    enum rmap_status st = scan_share(context, &scan, sums, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(reduce(context, sums->weight, sums->n_weight, MPI_DOUBLE, err));
    if (sums->n_colour)
        RMAP_TRY(reduce(context, sums->colour, sums->n_colour, MPI_INT64_T, err));
out:
    return st;
}

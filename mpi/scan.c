/* SPDX-License-Identifier: MIT */
#include "mpi/scan.h"

#include <stdatomic.h>

#include "base/alloc.h"
#include "base/workers.h"
#include "mpi/agree.h"
#include "mpi/gather.h"

/* What one thread scans. */
struct part {
    const struct scan *scan;
    size_t first, last;       /* portions */
    struct rmap_count *count; /* [n_criterion] */
    struct rmap_portion *collect;
    enum rmap_status status;
    struct rmap_error error;
};

struct scan {
    const struct rmap_context *context;
    const struct rmap_map *map;
    struct rmap_criterion *const *criterion;
    size_t n_criterion, n_source;
    uint64_t limit;
    bool collecting;
    struct part *part; /* [n_thread] */
    _Atomic int next;  /* part that the next free thread takes: fewer threads may start */
};

static uint64_t rows(const struct rmap_map *map, size_t portion)
{
    const struct rmap_portion_info *info = rmap_map_portion(map, portion);
    return info->n_row[RMAP_TABLE_SEGMENT] + info->n_row[RMAP_TABLE_RAY];
}

void rmap_scan_range(const struct rmap_map *map, size_t first, size_t last, int part, int n_part,
                     size_t *first_ret, size_t *last_ret)
{
    double total = 0.0, before = 0.0;
    for (size_t p = first; p < last; p++)
        total += (double)rows(map, p);
    double from = total * part / n_part, to = total * (part + 1) / n_part;
    *first_ret = *last_ret = last;
    bool begun = false;
    for (size_t p = first; p < last; p++) { /* a portion belongs where its middle lies */
        double middle = before + 0.5 * (double)rows(map, p);
        before += (double)rows(map, p);
        if (!begun && middle >= from) {
            *first_ret = p;
            begun = true;
        }
        if (part + 1 < n_part && middle >= to) {
            *last_ret = p;
            break;
        }
    }
    if (*first_ret > *last_ret)
        *first_ret = *last_ret;
}

static void scan_parts(void *context, int thread)
{
    struct scan *scan = context;
    (void)thread;
    for (;;) {
        int i = atomic_fetch_add(&scan->next, 1);
        if (i >= scan->context->n_thread)
            return;
        struct part *part = &scan->part[i];
        part->status =
            rmap_query_scan(scan->map, scan->criterion, scan->n_criterion, part->first, part->last,
                            part->count, part->collect, scan->limit, &part->error);
    }
}

static void destroy_parts(struct scan *scan)
{
    for (int i = 0; scan->part && i < scan->context->n_thread; i++) {
        for (size_t c = 0; scan->part[i].count && c < scan->n_criterion; c++)
            rmap_count_fini(&scan->part[i].count[c]);
        rmap_free(scan->part[i].count);
        rmap_portion_destroy(scan->part[i].collect);
    }
    rmap_free(scan->part);
    scan->part = NULL;
}

static enum rmap_status create_parts(struct scan *scan, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int n_thread = scan->context->n_thread;
    scan->part = rmap_alloc((size_t)n_thread, sizeof *scan->part);
    if (!scan->part)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    for (int i = 0; i < n_thread; i++) {
        struct part *part = &scan->part[i];
        part->count = rmap_alloc(scan->n_criterion, sizeof *part->count);
        if (!part->count)
            RMAP_TRY(rmap_error_set(err, RMAP_SYSTEM, "out of memory for the counts"));
        for (size_t c = 0; c < scan->n_criterion; c++)
            RMAP_TRY(rmap_count_init(&part->count[c], scan->n_source, err));
        if (scan->collecting)
            RMAP_TRY(rmap_portion_create(0, rmap_map_n_channel(scan->map), &part->collect, err));
    }
out:
    return st;
}

/* This rank's share of the portions [first, last), thread by thread; counts and rays appended in
 * the order of the portions. */
static enum rmap_status scan_share(struct scan *scan, size_t first, size_t last,
                                   struct rmap_count *count, struct rmap_portion *collect,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_workers *workers = NULL;
    int n_thread = scan->context->n_thread;
    size_t from, to;
    rmap_scan_range(scan->map, first, last, scan->context->rank, scan->context->size, &from, &to);
    RMAP_TRY(create_parts(scan, err));
    for (int i = 0; i < n_thread; i++)
        rmap_scan_range(scan->map, from, to, i, n_thread, &scan->part[i].first,
                        &scan->part[i].last);
    atomic_store(&scan->next, 0);
    RMAP_TRY(rmap_workers_start(n_thread, scan_parts, scan, &workers, err));
    rmap_workers_join(workers);
    for (int i = 0; i < n_thread; i++) {
        struct part *part = &scan->part[i];
        if (part->status != RMAP_OK) {
            *err = part->error;
            RMAP_TRY(part->status);
        }
        for (size_t c = 0; c < scan->n_criterion; c++)
            rmap_count_add(&count[c], &part->count[c], scan->n_source);
        if (scan->collecting)
            RMAP_TRY(rmap_portion_append(collect, part->collect, err));
    }
out:
    destroy_parts(scan);
    return st;
}

/* Collective. Analog weights are whole numbers: their sums are exact in any order. */
static enum rmap_status reduce_count(const struct scan *scan, struct rmap_count *count,
                                     struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Comm comm = scan->context->comm;
    uint64_t whole[] = {count->rays, count->segments, count->portions_read, count->nbytes_read};
    int n_source = (int)scan->n_source;
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, whole, 4, MPI_UINT64_T, MPI_SUM, comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, count->source_weight, n_source, MPI_DOUBLE, MPI_SUM, comm)));
    RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, count->source_weight_squared, n_source,
                                    MPI_DOUBLE, MPI_SUM, comm)));
    count->rays = whole[0];
    count->segments = whole[1];
    count->portions_read = whole[2];
    count->nbytes_read = whole[3];
out:
    return st;
}

/* Collective. One wave: portions [first, last) on all ranks; rays go to rank 0. */
static enum rmap_status scan_wave(struct scan *scan, size_t first, size_t last,
                                  struct rmap_count *total, struct rmap_portion *collect,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *mine = NULL;
    struct rmap_count *count = rmap_alloc(scan->n_criterion, sizeof *count);
    if (!count)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for the counts");
    for (size_t c = 0; st == RMAP_OK && c < scan->n_criterion; c++)
        st = rmap_count_init(&count[c], scan->n_source, err);
    if (st == RMAP_OK && scan->collecting)
        st = rmap_portion_create(0, rmap_map_n_channel(scan->map), &mine, err);
    if (st == RMAP_OK)
        st = scan_share(scan, first, last, count, mine, err);
    RMAP_TRY(rmap_agree(scan->context, st, err));
    for (size_t c = 0; c < scan->n_criterion; c++) {
        RMAP_TRY(reduce_count(scan, &count[c], err));
        rmap_count_add(&total[c], &count[c], scan->n_source);
    }
    if (scan->collecting)
        RMAP_TRY(rmap_gather_portion(scan->context, mine, err));
    if (collect)
        st = rmap_portion_append(collect, mine, err);
    RMAP_TRY(rmap_agree(scan->context, st, err));
out:
    for (size_t c = 0; count && c < scan->n_criterion; c++)
        rmap_count_fini(&count[c]);
    rmap_free(count);
    rmap_portion_destroy(mine);
    return st;
}

/* Collective. Without a limit one wave; with one, waves that double, until the rays asked for are
 * certain: portions are in the order of ray ids, so the first ones found are the smallest. */
static enum rmap_status scan_waves(struct scan *scan, struct rmap_count *count,
                                   struct rmap_portion *collect, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const uint64_t rays_before = count[0].rays;
    size_t n_portion = rmap_map_n_portion(scan->map), first = 0;
    size_t wave = scan->limit == UINT64_MAX
                      ? n_portion
                      : (size_t)scan->context->size * (size_t)scan->context->n_thread;
    do {
        size_t last = n_portion - first > wave ? first + wave : n_portion;
        RMAP_TRY(scan_wave(scan, first, last, count, collect, err));
        first = last;
        wave *= 2;
    } while (first < n_portion && count[0].rays - rays_before < scan->limit);
    if (collect && scan->limit < collect->n_row[RMAP_TABLE_RAY])
        rmap_portion_truncate(collect, (size_t)scan->limit);
out:
    return st;
}

enum rmap_status rmap_scan_map(const struct rmap_context *context, const struct rmap_map *map,
                               struct rmap_criterion *const *criterion, size_t n_criterion,
                               struct rmap_count *count, struct rmap_portion **collect_ret,
                               uint64_t limit, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_portion *collect = NULL;
    struct scan scan = {.context = context,
                        .map = map,
                        .criterion = criterion,
                        .n_criterion = n_criterion,
                        .n_source = rmap_map_scene(map)->n_source,
                        .limit = limit,
                        .collecting = collect_ret != NULL};
    if (collect_ret && context->rank == 0)
        st = rmap_portion_create(0, rmap_map_n_channel(map), &collect, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(scan_waves(&scan, count, collect, err));
    if (collect_ret) {
        *collect_ret = collect;
        collect = NULL;
    }
out:
    rmap_portion_destroy(collect);
    return st;
}

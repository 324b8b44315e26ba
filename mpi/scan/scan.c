/* SPDX-License-Identifier: MIT
 *
 * One scan of a whole map, its portions scattered over ranks and threads.
 */
#include "mpi/scan/scan.h"

#include "analysis/query/query_pieces.h"
#include "base/alloc.h"
#include "io/map/map_memory.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/parts.h"
#include "mpi/scan/ray_stream.h"

/* A thread's sums. */
struct worker {
    struct rmap_query_scanner *scanner; /* made when first needed */
    struct rmap_count *count;           /* [n_criterion] */
};

struct scan {
    const struct rmap_context *context;
    const struct rmap_map *map;
    struct rmap_criterion *const *criterion;
    size_t n_criterion, n_source;
    struct rmap_deal deal;
    struct rmap_parts parts;
    uint8_t *counted;      /* [n_criterion][n_piece] whose rays were counted by paths, or NULL */
    int n_thread;          /* as many as fit into a query's memory */
    struct worker *worker; /* [n_thread] */
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

/* Portions that follow each other are scanned in one go. */
static enum rmap_status scan_part(struct scan *scan, struct worker *worker, size_t part,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t n = 0, run = 0;
    const size_t *portion = rmap_deal_part(&scan->deal, scan->context->rank, part, &n);
    for (size_t i = 0; i < n && st == RMAP_OK; i += run) {
        run = 1;
        while (i + run < n && portion[i + run] == portion[i] + run)
            run++;
        st = rmap_query_scanner_scan(worker->scanner, portion[i], portion[i] + run, worker->count,
                                     NULL, UINT64_MAX, err);
    }
    return st;
}

static enum rmap_status scan_parts(void *context, int thread, size_t first, size_t last,
                                   struct rmap_error *err)
{
    struct scan *scan = context;
    struct worker *worker = &scan->worker[thread];
    enum rmap_status st = RMAP_OK;
    if (!worker->scanner)
        RMAP_TRY(rmap_query_scanner_create(scan->map, scan->criterion, scan->n_criterion,
                                           &worker->scanner, err));
    rmap_query_scanner_set_counted(worker->scanner, scan->counted);
    for (size_t k = first; k < last; k++)
        RMAP_TRY(scan_part(scan, worker, k, err));
out:
    return st;
}

static void destroy_counts(struct rmap_count *count, size_t n)
{
    for (size_t c = 0; count && c < n; c++)
        rmap_count_fini(&count[c]);
    rmap_free(count);
}

static enum rmap_status create_counts(const struct scan *scan, struct rmap_count **count_ret,
                                      struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_count *count = rmap_alloc(scan->n_criterion, sizeof *count);
    *count_ret = count;
    if (!count)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for the counts");
    for (size_t c = 0; c < scan->n_criterion && st == RMAP_OK; c++)
        st = rmap_count_init(&count[c], scan->n_source, err);
    return st;
}

/* This rank's share; added to count. */
static enum rmap_status scan_share(struct scan *scan, struct rmap_count *count,
                                   struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int n_thread = scan->n_thread;
    scan->worker = rmap_alloc((size_t)n_thread, sizeof *scan->worker);
    if (!scan->worker)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    for (int i = 0; i < n_thread; i++)
        RMAP_TRY(create_counts(scan, &scan->worker[i].count, err));
    scan->parts.context = scan;
    scan->parts.last = rmap_deal_n_part(&scan->deal, scan->context->rank);
    scan->parts.step = 1;
    scan->parts.order = RMAP_PARTS_NEAR; /* parts share chunks */
    scan->parts.work = scan_parts;
    RMAP_TRY(rmap_parts_run(&scan->parts, n_thread, err));
    for (int i = 0; i < n_thread; i++)
        for (size_t c = 0; c < scan->n_criterion; c++)
            rmap_count_add(&count[c], &scan->worker[i].count[c], scan->n_source);
out:
    for (int i = 0; i < n_thread; i++) {
        rmap_query_scanner_destroy(scan->worker[i].scanner);
        destroy_counts(scan->worker[i].count, scan->n_criterion);
    }
    rmap_free(scan->worker);
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

/* Collective. Whole pieces first, where they say how many rays have each path. */
static enum rmap_status count_pieces(struct scan *scan, struct rmap_count *count,
                                     struct rmap_error *err)
{
    const struct rmap_context *context = scan->context;
    const size_t n = scan->n_criterion * rmap_map_n_piece(scan->map);
    enum rmap_status st = rmap_query_pieces_count(scan->map, scan->criterion, scan->n_criterion,
                                                  (size_t)context->rank, (size_t)context->size,
                                                  count, &scan->counted, err);
    RMAP_TRY(rmap_agree(context, st, err));
    if (scan->counted)
        st = RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, scan->counted, (int)n, MPI_UINT8_T, MPI_MAX,
                                    context->comm));
out:
    return st;
}

/* Small maps are cut finer, so that every thread has some parts to take. */
static void choose_step(struct scan *scan)
{
    size_t n = rmap_map_n_portion(scan->map);
    size_t few = n / (4 * (size_t)scan->context->size * (size_t)scan->n_thread);
    if (few < scan->deal.step)
        scan->deal.step = few > 0 ? few : 1;
}

/* A thread has a portion as it is read, and its undecided rays. */
static int count_threads(const struct scan *scan)
{
    rmap_column_set columns = 0;
    for (size_t c = 0; c < scan->n_criterion; c++) {
        const struct rmap_criterion *one = scan->criterion[c];
        columns |= rmap_query_columns(&one, 1);
    }
    return rmap_map_readers(scan->map, columns, 2, scan->context->n_thread);
}

enum rmap_status rmap_scan_map(const struct rmap_context *context, const struct rmap_map *map,
                               struct rmap_criterion *const *criterion, size_t n_criterion,
                               enum rmap_deal_kind deal, struct rmap_count *count,
                               struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_count *mine = NULL;
    struct scan scan = {.context = context,
                        .map = map,
                        .criterion = criterion,
                        .n_criterion = n_criterion,
                        .n_source = rmap_map_scene(map)->n_source};
    scan.n_thread = count_threads(&scan);
    st = rmap_deal_init(map, deal, context->size, &scan.deal, err);
    if (st == RMAP_OK)
        st = create_counts(&scan, &mine, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(count_pieces(&scan, mine, err));
    choose_step(&scan);
    st = scan_share(&scan, mine, err);
    RMAP_TRY(rmap_agree(context, st, err));
    for (size_t c = 0; c < n_criterion; c++) {
        RMAP_TRY(reduce_count(&scan, &mine[c], err));
        rmap_count_add(&count[c], &mine[c], scan.n_source);
    }
out:
    destroy_counts(mine, n_criterion);
    rmap_deal_fini(&scan.deal);
    rmap_free(scan.counted);
    return st;
}

/* ---- rays kept ---- */

struct collection {
    struct rmap_portion *rays;
    uint16_t *wide; /* colours of a ray with fewer channels, at its own rows */
    size_t cap;
};

/* A ray's colours with as many channels as the collection has. */
static enum rmap_status widen(struct collection *self, const struct rmap_streamed_ray *ray,
                              struct rmap_portion *portion, struct rmap_error *err)
{
    size_t few = (size_t)portion->n_channel, many = (size_t)self->rays->n_channel;
    size_t first = ray->segment, end = first + portion->ray.segment_count[ray->row];
    enum rmap_status st = RMAP_RESERVE(self->wide, self->cap, end * many + 1, err);
    for (size_t i = first * many; st == RMAP_OK && i < end * many; i++)
        self->wide[i] = i % many < few ? portion->colour[i / many * few + i % many] : 0;
    portion->n_channel = (int)many;
    portion->colour = self->wide;
    return st;
}

static enum rmap_status keep_ray(void *context, const struct rmap_streamed_ray *ray,
                                 struct rmap_error *err)
{
    struct collection *self = context;
    struct rmap_portion portion = *ray->portion;
    enum rmap_status st = RMAP_OK;
    if (portion.n_channel != self->rays->n_channel)
        st = widen(self, ray, &portion, err);
    return st != RMAP_OK ? st
                         : rmap_portion_append_ray(self->rays, &portion, ray->row, ray->segment,
                                                   ray->registration, err);
}

enum rmap_status rmap_scan_collect(const struct rmap_context *context, const struct rmap_map *map,
                                   const struct rmap_pick *pick, uint64_t limit,
                                   struct rmap_portion **rays_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct collection collection = {0};
    const struct rmap_ray_sink sink = {&collection, keep_ray};
    uint64_t n = 0;
    *rays_ret = NULL;
    if (context->rank == 0)
        st = rmap_portion_create(0, rmap_map_n_channel(map), &collection.rays, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(rmap_ray_stream(context, map, pick, RMAP_DEAL_TURNS, limit, &sink, &n, err));
    *rays_ret = collection.rays;
    collection.rays = NULL;
out:
    rmap_portion_destroy(collection.rays);
    rmap_free(collection.wide);
    return st;
}

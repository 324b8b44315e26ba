/* SPDX-License-Identifier: MIT
 *
 * The classes of paths of a whole map: one pass over it, or a second one where there are more
 * classes than are counted at once, or where their peaks take too much memory.
 */
#include "mpi/scan/path_run.h"

#include <math.h>
#include <string.h>

#include "analysis/paths/path_report_texts.h"
#include "base/alloc.h"
#include "mpi/parallel/agree.h"
#include "mpi/scan/fold_run.h"
#include "mpi/scan/head_reads.h"

/* Threads whose states fit into a GiB. */
enum { THREADS_MOST = 6 };

/* Shares of the flux that are tried, each RAISED_BY times the one before, until the classes that
 * may have it are no more than can be counted. The first: 2 / most_classes, but well above what the
 * sketch may be wrong by (e / 2^20). */
enum { RAISED_BY = 4 };
static const double SHARE_LEAST = 1e-5;

struct run {
    struct rmap_context context;
    const struct rmap_path_request *request;
    struct rmap_path_counting counting;
    struct rmap_path_counts *counts; /* rank 0 */
    struct rmap_path_sketch sketch;
    uint32_t *least; /* [n_source] */
    double bound;
};

static enum rmap_status fold(struct run *run, struct rmap_path_counts **counts_ret,
                             struct rmap_error *err)
{
    const struct rmap_path_request *request = run->request;
    const struct rmap_fold fold = {.kind = &rmap_path_count_kind,
                                   .context = &run->counting,
                                   .map = request->map,
                                   .overlay = request->overlay,
                                   .criterion = request->criterion,
                                   .which = request->which,
                                   .columns = rmap_path_count_columns(&run->counting),
                                   .deferred = rmap_path_count_columns(&run->counting)};
    void *state = NULL;
    *counts_ret = NULL;
    enum rmap_status st = rmap_fold_run(&run->context, &fold, &state, err);
    *counts_ret = state;
    return st;
}

/* Collective: what rank 0 says. */
static enum rmap_status tell(const struct run *run, bool *answer, struct rmap_error *err)
{
    int value = *answer;
    enum rmap_status st = RMAP_OK;
    RMAP_TRY(RMAP_MPI(MPI_Bcast(&value, 1, MPI_INT, 0, run->context.comm)));
    *answer = value != 0;
out:
    return st;
}

/* Fewest rays with which a class of each source can have the share `bound` of all flux: none weighs
 * more than the heaviest. On rank 0. */
static void set_least(struct run *run, const struct rmap_path_counts *counts)
{
    const double *unit = rmap_map_flux_per_weight(run->request->map);
    double flux, error;
    rmap_count_flux(&counts->total, run->request->map, &flux, &error);
    for (size_t s = 0; s < rmap_map_scene(run->request->map)->n_source; s++) {
        double rays = ceil(run->bound * flux / (unit[s] * counts->most_weight) * (1.0 - 1e-12));
        run->least[s] = rays < (double)UINT32_MAX ? (uint32_t)fmax(rays, 1.0) : UINT32_MAX;
    }
}

/* Collective: hands the sketch out. */
static enum rmap_status share_sketch(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t nbytes = RMAP_PATH_SKETCH_NBYTES;
    uint8_t *blob = NULL;
    if (run->context.rank == 0) {
        blob = (uint8_t *)run->counts->sketch.rays;
        run->counts->sketch.rays = NULL;
    }
    RMAP_TRY(rmap_broadcast_blob(&run->context, &blob, &nbytes, err));
out:
    run->sketch.rays = (uint32_t *)(void *)blob;
    return st;
}

/* Collective. The second pass: classes of which the sketch says that they may be large. */
static enum rmap_status count_large(struct run *run, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const int n_source = (int)rmap_map_scene(run->request->map)->n_source;
    bool again = true;
    RMAP_TRY(share_sketch(run, err));
    run->least = rmap_alloc((size_t)n_source + 1, sizeof *run->least);
    if (!run->least)
        st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d sources", n_source);
    RMAP_TRY(rmap_agree(&run->context, st, err));
    run->counting.sketch = &run->sketch;
    run->counting.least = run->least;
    run->bound = fmax(2.0 / (double)run->request->most_classes, SHARE_LEAST) / RAISED_BY;
    while (again) {
        struct rmap_path_counts *counts = NULL;
        run->bound *= RAISED_BY;
        if (run->context.rank == 0)
            set_least(run, run->counts);
        RMAP_TRY(RMAP_MPI(MPI_Bcast(run->least, n_source, MPI_UINT32_T, 0, run->context.comm)));
        RMAP_TRY(fold(run, &counts, err));
        rmap_path_count_kind.destroy(run->counts);
        run->counts = counts;
        again = counts && counts->is_full && run->bound < 1.0;
        RMAP_TRY(tell(run, &again, err));
    }
out:
    return st;
}

/* How many rows' cells are sure to fit; at least one is tried. */
static size_t rows_with_cells(const struct run *run, size_t n_row)
{
    const struct rmap_path_request *request = run->request;
    const struct rmap_scene *scene = rmap_scene_with(request->map, request->overlay);
    uint64_t n_cell = 1;
    for (size_t d = 0; d < scene->n_detector; d++)
        if (!request->view.until_detector || (int32_t)d == request->view.detector)
            n_cell += (uint64_t)scene->detector[d].cells[0] * scene->detector[d].cells[1];
    uint64_t most = request->most_cells / n_cell;
    most = most > 0 ? most : 1;
    return n_row < most ? n_row : (size_t)most;
}

/* Collective: the keys of the first rows, on every rank. */
static enum rmap_status share_rows(struct run *run, const struct rmap_path_report *report,
                                   struct rmap_key_sums *chosen, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key *key = NULL;
    uint8_t *blob = NULL;
    size_t n = report ? rows_with_cells(run, report->n_row) : 0, nbytes = n * sizeof *key;
    if (report) {
        key = rmap_alloc(n + 1, sizeof *key);
        for (size_t k = 0; key && k < n; k++)
            key[k] = report->row[k].key;
        if (!key)
            st = rmap_error_set(err, RMAP_SYSTEM, "out of memory for %zu paths", n);
        blob = (uint8_t *)key;
    }
    RMAP_TRY(rmap_agree(&run->context, st, err));
    st = rmap_broadcast_blob(&run->context, &blob, &nbytes, err);
    key = (struct rmap_key *)(void *)blob;
    rmap_key_sums_init(chosen, nbytes / sizeof *key);
    for (size_t k = 0; st == RMAP_OK && k < nbytes / sizeof *key; k++) {
        struct rmap_key_sum *entry;
        st = rmap_key_sums_enter(chosen, key[k], &entry, err);
    }
    st = rmap_agree(&run->context, st, err);
out:
    rmap_free(blob);
    return st;
}

/* Collective. Another pass for the cells of the first rows alone. */
static enum rmap_status count_cells(struct run *run, struct rmap_path_report *report,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_key_sums chosen = {0};
    struct rmap_path_counts *counts = NULL;
    RMAP_TRY(share_rows(run, report, &chosen, err));
    run->counting.chosen = &chosen;
    run->counting.sketch = NULL;
    run->counting.timed = false; /* they are known */
    run->counting.most_classes = chosen.n;
    run->counting.most_cells = (size_t)run->request->most_cells;
    RMAP_TRY(fold(run, &counts, err));
    if (report) {
        report->peaks_missing = chosen.n < report->n_row || counts->cells_full;
        st = rmap_path_report_add_peaks(report, &counts->cells, err);
    }
    st = rmap_agree(&run->context, st, err);
out:
    rmap_path_count_kind.destroy(counts);
    rmap_key_sums_fini(&chosen);
    return st;
}

/* Collective. */
static enum rmap_status make_report(struct run *run, struct rmap_path_report **report_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_path_request *request = run->request;
    struct rmap_path_report *report = NULL;
    struct rmap_head_reads *reads = NULL;
    bool more_cells = false;
    if (run->counts) {
        st = rmap_path_report_create(run->counts, request->sort, request->top, run->bound, &report,
                                     err);
        if (report) {
            report->view = request->view;
            report->which = request->which;
            report->criterion = request->criterion ? rmap_criterion_text(request->criterion) : NULL;
            more_cells = run->counts->cells_full && request->most_cells > 0 && report->n_row > 0;
        }
        if (report && !more_cells)
            st = rmap_path_report_add_peaks(report, &run->counts->cells, err);
    }
    RMAP_TRY(rmap_agree(&run->context, st, err));
    rmap_path_count_kind.destroy(run->counts);
    run->counts = NULL;
    RMAP_TRY(tell(run, &more_cells, err));
    if (more_cells)
        RMAP_TRY(count_cells(run, report, err));
    RMAP_TRY(rmap_head_reads_begin(&run->context, request->map, &reads, err));
    if (report)
        st = rmap_path_report_add_texts(report, err);
    rmap_head_reads_end(reads);
    RMAP_TRY(rmap_agree(&run->context, st, err));
    *report_ret = report;
    report = NULL;
out:
    rmap_path_report_destroy(report);
    return st;
}

enum rmap_status rmap_path_run(const struct rmap_context *context,
                               const struct rmap_path_request *request,
                               struct rmap_path_report **report_ret, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct run run = {
        .context = *context,
        .request = request,
        .counting = {.map = request->map,
                     .overlay = request->overlay,
                     .keys = request->keys,
                     .detector = request->view.until_detector ? request->view.detector : -1,
                     .most_classes = (size_t)request->most_classes,
                     .most_cells = (size_t)request->most_cells,
                     .timed = request->timed}};
    struct rmap_map_summary summary;
    bool is_full = false;
    *report_ret = NULL;
    rmap_map_summarise(request->map, &summary);
    if (run.counting.most_classes > summary.n_row[RMAP_TABLE_RAY])
        run.counting.most_classes = (size_t)summary.n_row[RMAP_TABLE_RAY];
    if (run.context.n_thread > THREADS_MOST)
        run.context.n_thread = THREADS_MOST;
    if (rmap_map_scene(request->map)->n_source > RMAP_PATH_SOURCES_MAX)
        return rmap_error_set(err, RMAP_INPUT, "paths of more than %zu sources are not told apart",
                              RMAP_PATH_SOURCES_MAX);
    RMAP_TRY(fold(&run, &run.counts, err));
    is_full = run.counts && run.counts->is_full;
    RMAP_TRY(tell(&run, &is_full, err));
    if (is_full)
        RMAP_TRY(count_large(&run, err));
    st = make_report(&run, report_ret, err);
out:
    rmap_path_count_kind.destroy(run.counts);
    rmap_path_sketch_fini(&run.sketch);
    rmap_free(run.least);
    return st;
}

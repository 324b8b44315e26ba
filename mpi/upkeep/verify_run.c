/* SPDX-License-Identifier: MIT
 *
 * Verifying a map on all ranks and threads.
 */
#include "mpi/upkeep/verify_run.h"

#include <string.h>

#include "base/alloc.h"
#include "io/map/map_cursor.h"
#include "io/recovery/verify_piece.h"
#include "io/recovery/verify_rays.h"
#include "mpi/parallel/agree.h"
#include "mpi/parallel/gather_findings.h"
#include "mpi/parallel/parts.h"
#include "mpi/parallel/progress.h"
#include "mpi/parallel/tally_reduce.h"

struct worker {
    struct rmap_chunk_verifier *chunks;
    struct rmap_cursor *cursor;
    struct rmap_tally *listed, *found; /* of portions in the index, of finished pieces beside it */
    struct rmap_findings findings;
};

struct check {
    const struct rmap_context *context;
    struct rmap_verification *what;
    struct rmap_parts parts;
    struct worker *worker; /* [n_thread] */
    struct rmap_findings *findings;
    struct rmap_progress progress;
    _Atomic uint64_t done;
};

static enum rmap_status show(void *context, struct rmap_error *err)
{
    struct check *check = context;
    (void)err;
    rmap_progress_show(&check->progress, atomic_load(&check->done));
    return RMAP_OK;
}

/* ---- chunks ---- */

static double chunk_nbytes(void *context, size_t chunk)
{
    return ((struct check *)context)->what->content->chunk[chunk].nbytes;
}

static enum rmap_status verify_chunks(void *context, int thread, size_t first, size_t last,
                                      struct rmap_error *err)
{
    struct check *check = context;
    struct worker *self = &check->worker[thread];
    enum rmap_status st = RMAP_OK;
    if (!self->chunks)
        RMAP_TRY(rmap_chunk_verifier_create(check->what, &self->chunks, err));
    for (size_t i = first; i < last; i++) {
        RMAP_TRY(rmap_verify_chunk(self->chunks, i, &self->findings, err));
        atomic_fetch_add(&check->done, check->what->content->chunk[i].nbytes);
    }
out:
    return st;
}

/* ---- rays ---- */

static double portion_rows(void *context, size_t portion)
{
    const struct rmap_portion_info *info =
        &((struct check *)context)->what->content->portion[portion];
    return (double)(info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT]);
}

static enum rmap_status verify_rays(void *context, int thread, size_t first, size_t last,
                                    struct rmap_error *err)
{
    struct check *check = context;
    struct rmap_verification *what = check->what;
    struct worker *self = &check->worker[thread];
    enum rmap_status st = RMAP_OK;
    if (!self->cursor)
        RMAP_TRY(rmap_cursor_create(what->map, RMAP_COLUMNS_ALL | RMAP_COLUMNS_ANGLES,
                                    &self->cursor, err));
    for (size_t i = first; i < last; i++) {
        const struct rmap_portion_info *info = &what->content->portion[i];
        bool is_open = what->content->piece[info->piece].is_open;
        struct rmap_tally *tally = info->is_added ? (is_open ? NULL : self->found) : self->listed;
        RMAP_TRY(rmap_verify_portion(what, self->cursor, i, tally, &self->findings, err));
        atomic_fetch_add(&check->done,
                         info->n_row[RMAP_TABLE_RAY] + info->n_row[RMAP_TABLE_SEGMENT]);
    }
out:
    return st;
}

/* ---- the parts of it ---- */

/* Not collective: this rank's share of one kind of items. */
static enum rmap_status verify_items(struct check *check, const char *what, size_t n,
                                     double (*size_of)(void *context, size_t item),
                                     enum rmap_status (*work)(void *context, int thread,
                                                              size_t first, size_t last,
                                                              struct rmap_error *err),
                                     struct rmap_error *err)
{
    const struct rmap_context *context = check->context;
    enum rmap_status st = RMAP_OK;
    double total = 0.0;
    check->parts.context = check;
    check->parts.step = 1;
    check->parts.order = RMAP_PARTS_NEAR; /* neighbouring portions share chunks of /ray */
    check->parts.work = work;
    check->parts.meanwhile = show;
    rmap_parts_share(&check->parts, size_of, n, context->rank, context->size);
    for (size_t i = check->parts.first; i < check->parts.last; i++)
        total += size_of(check, i);
    atomic_store(&check->done, 0);
    rmap_progress_init(&check->progress, context, what, (uint64_t)total);
    st = rmap_parts_run(&check->parts, context->n_thread, err);
    rmap_progress_fini(&check->progress);
    for (int t = 0; t < context->n_thread && st == RMAP_OK; t++) {
        struct rmap_findings *found = &check->worker[t].findings;
        st = rmap_findings_append(check->findings, found->row, found->n, err);
        found->n = 0;
    }
    return st;
}

/* Collective: every rank knows what each found. */
static enum rmap_status share_flags(const struct check *check, struct rmap_error *err)
{
    const size_t most = (size_t)1 << 30;
    enum rmap_status st = RMAP_OK;
    struct rmap_verification *what = check->what;
    uint8_t *const flag[2] = {what->piece_flag, what->portion_flag};
    const size_t n[2] = {what->content->n_piece, what->content->n_portion};
    for (int k = 0; k < 2; k++)
        for (size_t at = 0; at < n[k]; at += most)
            RMAP_TRY(RMAP_MPI(MPI_Allreduce(MPI_IN_PLACE, flag[k] + at,
                                            (int)(n[k] - at < most ? n[k] - at : most), MPI_UINT8_T,
                                            MPI_BOR, check->context->comm)));
out:
    return st;
}

/* Collective. */
static enum rmap_status verify_pieces(struct check *check, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    size_t rank = (size_t)check->context->rank, size = (size_t)check->context->size;
    for (size_t i = rank; i < check->what->claimed->n_piece && st == RMAP_OK; i += size)
        st = rmap_verify_piece(check->what, i, check->findings, err);
    RMAP_TRY(rmap_agree_patiently(check->context, st, err));
    RMAP_TRY(share_flags(check, err));
out:
    return st;
}

/* Collective. */
static enum rmap_status verify_content(struct check *check, struct rmap_error *err)
{
    const struct rmap_map_content *content = check->what->content;
    enum rmap_status st =
        verify_items(check, "bytes", content->n_chunk, chunk_nbytes, verify_chunks, err);
    RMAP_TRY(rmap_agree_patiently(check->context, st, err));
    RMAP_TRY(share_flags(check, err));
    if (!check->what->map)
        goto out;
    st = verify_items(check, "rays and segments", content->n_portion, portion_rows, verify_rays,
                      err);
    RMAP_TRY(rmap_agree_patiently(check->context, st, err));
    RMAP_TRY(share_flags(check, err));
out:
    return st;
}

/* Collective. The sums of all threads and ranks, on rank 0, against the index's; not when rays are
 * lost, which makes sums another. *tally_ret: all of them, on rank 0. */
static enum rmap_status verify_sums(struct check *check, struct rmap_tally **tally_ret,
                                    struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_verification *what = check->what;
    struct worker *first = &check->worker[0];
    bool whole = true;
    if (!what->map)
        return RMAP_OK;
    for (int t = 1; t < check->context->n_thread; t++) {
        rmap_tally_merge(first->listed, check->worker[t].listed);
        rmap_tally_merge(first->found, check->worker[t].found);
    }
    for (size_t i = 0; i < what->content->n_portion; i++)
        whole = whole && !(what->portion_flag[i] & RMAP_PORTION_LOST);
    RMAP_TRY(rmap_tally_reduce(check->context, first->listed, err));
    RMAP_TRY(rmap_tally_reduce(check->context, first->found, err));
    if (check->context->rank == 0)
        st = rmap_verify_sums(check->what, whole ? first->listed : NULL, check->findings, err);
    RMAP_TRY(rmap_agree(check->context, st, err));
    if (check->context->rank == 0) {
        rmap_tally_merge(first->listed, first->found);
        *tally_ret = first->listed;
        first->listed = NULL;
    }
out:
    return st;
}

static void count(const struct rmap_verification *what, struct rmap_verified *verified)
{
    const struct rmap_map_content *content = what->content;
    verified->pieces = content->n_piece;
    verified->chunks = content->n_chunk;
    verified->portions = content->n_portion;
    for (size_t i = 0; i < content->n_portion; i++) {
        verified->rays += content->portion[i].n_row[RMAP_TABLE_RAY];
        verified->segments += content->portion[i].n_row[RMAP_TABLE_SEGMENT];
    }
    for (size_t i = 0; i < content->n_piece; i++)
        verified->bytes += content->piece[i].nbytes;
}

static enum rmap_status create_workers(struct check *check, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    int n_thread = check->context->n_thread;
    check->worker = rmap_alloc((size_t)n_thread, sizeof *check->worker);
    if (!check->worker)
        return rmap_error_set(err, RMAP_SYSTEM, "out of memory for %d threads", n_thread);
    for (int t = 0; t < n_thread && check->what->map; t++) {
        const struct rmap_scene *scene = rmap_map_scene(check->what->map);
        RMAP_TRY(rmap_tally_create(scene, &check->worker[t].listed, err));
        RMAP_TRY(rmap_tally_create(scene, &check->worker[t].found, err));
    }
out:
    return st;
}

static void destroy_workers(struct check *check)
{
    for (int t = 0; check->worker && t < check->context->n_thread; t++) {
        rmap_chunk_verifier_destroy(check->worker[t].chunks);
        rmap_cursor_destroy(check->worker[t].cursor);
        rmap_tally_destroy(check->worker[t].listed);
        rmap_tally_destroy(check->worker[t].found);
        rmap_findings_fini(&check->worker[t].findings);
    }
    rmap_free(check->worker);
}

/* Collective. Ranks open the map one after the other; a map that is being written to may be another
 * by then. */
static enum rmap_status agree_on_content(const struct check *check, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_map_content *content = check->what->content;
    uint64_t mine[] = {content->n_piece, content->n_chunk, content->n_portion, content->digest.low,
                       check->what->claimed->n_piece};
    enum { N = sizeof mine / sizeof *mine };
    uint64_t least[N], most[N];
    memcpy(least, mine, sizeof mine);
    memcpy(most, mine, sizeof mine);
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, least, N, MPI_UINT64_T, MPI_MIN, check->context->comm)));
    RMAP_TRY(RMAP_MPI(
        MPI_Allreduce(MPI_IN_PLACE, most, N, MPI_UINT64_T, MPI_MAX, check->context->comm)));
    if (memcmp(least, most, sizeof least) != 0)
        st = rmap_error_set(err, RMAP_SYSTEM,
                            "%s is being written to: verify it with one rank, or later",
                            check->what->path);
out:
    return st;
}

enum rmap_status rmap_verify_run(const struct rmap_context *context, const char *path,
                                 struct rmap_verify_result *result, struct rmap_error *err)
{
    struct check check = {.context = context, .findings = &result->findings};
    double begun = rmap_clock_seconds();
    *result = (struct rmap_verify_result){0};
    enum rmap_status st = rmap_verification_open(path, &check.what, check.findings, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(agree_on_content(&check, err));
    st = create_workers(&check, err);
    RMAP_TRY(rmap_agree(context, st, err));
    RMAP_TRY(verify_pieces(&check, err));
    RMAP_TRY(verify_content(&check, err));
    RMAP_TRY(verify_sums(&check, &result->tally, err));
    RMAP_TRY(rmap_gather_findings(context, check.findings, err));
    count(check.what, &result->verified);
    result->verified.seconds = rmap_clock_seconds() - begun;
    result->verification = check.what;
    check.what = NULL;
out:
    destroy_workers(&check);
    rmap_verification_close(check.what);
    return st;
}

void rmap_verify_result_fini(struct rmap_verify_result *result)
{
    rmap_tally_destroy(result->tally);
    rmap_findings_fini(&result->findings);
    rmap_verification_close(result->verification);
    *result = (struct rmap_verify_result){0};
}

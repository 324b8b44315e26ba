/* SPDX-License-Identifier: MIT
 *
 * Measurement of ranks against threads, on a pair of ranks: the first two of the run or, when the
 * program was started alone, this rank and one that it starts for the purpose.
 */
#include <unistd.h>

#include "bench.h"
#include "mpi/command/load.h"
#include "mpi/parallel/agree.h"

static enum rmap_status start_partner(MPI_Comm *pair, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    char program[1024], command[] = "bench", option[] = "--partner";
    char *arguments[] = {command, option, NULL};
    MPI_Comm between = MPI_COMM_NULL;
    MPI_Errhandler before;
    ssize_t len = readlink("/proc/self/exe", program, sizeof program - 1);
    program[len > 0 ? len : 0] = 0;
    RMAP_TRY(RMAP_MPI(MPI_Comm_get_errhandler(MPI_COMM_SELF, &before)));
    (void)MPI_Comm_set_errhandler(MPI_COMM_SELF, MPI_ERRORS_RETURN);
    st = RMAP_MPI(MPI_Comm_spawn(program, arguments, 1, MPI_INFO_NULL, 0, MPI_COMM_SELF, &between,
                                 MPI_ERRCODES_IGNORE));
    (void)MPI_Comm_set_errhandler(MPI_COMM_SELF, before);
    (void)MPI_Errhandler_free(&before);
    RMAP_TRY(st);
    RMAP_TRY(RMAP_MPI(MPI_Intercomm_merge(between, 0, pair)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_free(&between)));
out:
    return st;
}

static enum rmap_status join_parent(MPI_Comm *pair, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    MPI_Comm between = MPI_COMM_NULL;
    RMAP_TRY(RMAP_MPI(MPI_Comm_get_parent(&between)));
    if (between == MPI_COMM_NULL)
        RMAP_TRY(rmap_error_set(err, RMAP_USAGE, "--partner is for the program's own use"));
    RMAP_TRY(RMAP_MPI(MPI_Intercomm_merge(between, 1, pair)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_free(&between)));
out:
    return st;
}

enum rmap_status rmap_bench_pair_open(const struct rmap_bench *bench, bool partner,
                                      struct rmap_context *pair, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    const struct rmap_context *context = bench->context;
    *pair = *context;
    pair->comm = MPI_COMM_NULL;
    if (partner)
        RMAP_TRY(join_parent(&pair->comm, err));
    else if (context->size == 1)
        RMAP_TRY(start_partner(&pair->comm, err));
    else
        RMAP_TRY(RMAP_MPI(
            MPI_Comm_split(context->comm, context->rank < 2 ? 0 : MPI_UNDEFINED, 0, &pair->comm)));
    if (pair->comm == MPI_COMM_NULL)
        goto out;
    RMAP_TRY(RMAP_MPI(MPI_Comm_set_errhandler(pair->comm, MPI_ERRORS_RETURN)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_rank(pair->comm, &pair->rank)));
    RMAP_TRY(RMAP_MPI(MPI_Comm_size(pair->comm, &pair->size)));
out:
    return st;
}

void rmap_bench_pair_close(struct rmap_context *pair)
{
    if (pair->comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&pair->comm);
}

/* Collective on the pair. The one that waits sleeps: spinning, it would take a core away. */
static enum rmap_status measure(struct rmap_bench *bench, const struct rmap_context *pair,
                                const struct rmap_bench_scene *scene, struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    const struct rmap_bench_store none = {0};
    uint64_t n_ray = bench->quick ? 200000 : 1000000;
    double ranks_s = 1.0, threads_s = 1.0, n_segment = 0.0;
    for (int i = 0; i < bench->n_repeat; i++) {
        RMAP_TRY(rmap_bench_trace(pair, 1, scene, n_ray, &none, &ranks_s, &n_segment, err));
        if (pair->rank == 0)
            st = rmap_bench_trace(&bench->alone, 2, scene, n_ray, &none, &threads_s, &n_segment,
                                  err);
        RMAP_TRY(rmap_agree_patiently(pair, st, err));
        rmap_bench_add(&series, 1e-6 * n_segment / ranks_s, 1e-6 * n_segment / threads_s);
    }
    if (pair->rank == 0)
        rmap_bench_report(bench, "ranks_vs_threads", scene, &series, "million segments/s", NULL);
out:
    return st;
}

enum rmap_status rmap_bench_pair_round(struct rmap_bench *bench, const struct rmap_context *pair,
                                       struct rmap_bench_scene *scene, const char *path, bool *more,
                                       struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_scene_options none = {0};
    int round[3] = {*more, bench->n_repeat, bench->quick};
    RMAP_TRY(RMAP_MPI(MPI_Bcast(round, 3, MPI_INT, 0, pair->comm)));
    *more = round[0] != 0;
    bench->n_repeat = round[1];
    bench->quick = round[2] != 0;
    if (!*more)
        goto out;
    RMAP_TRY(rmap_load_scene(pair, path, &none, &scene->bundle, &scene->scene, err));
    st = rmap_accel_create(scene->scene, pair->n_thread, &scene->accel, err);
    RMAP_TRY(rmap_agree(pair, st, err));
    RMAP_TRY(measure(bench, pair, scene, err));
out:
    rmap_bench_scene_fini(scene);
    return st;
}

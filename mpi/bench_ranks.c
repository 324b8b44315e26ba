/* SPDX-License-Identifier: MIT
 *
 * Measurement of ranks against threads.
 */
#include "mpi/agree.h"
#include "mpi/bench.h"

enum rmap_status rmap_bench_ranks(struct rmap_bench *bench, const struct rmap_bench_scene *scene,
                                  struct rmap_error *err)
{
    enum rmap_status st = RMAP_OK;
    struct rmap_bench_series series = {0};
    struct rmap_context pair = *bench->context;
    uint64_t n_ray = bench->quick ? 200000 : 1000000;
    double ranks_s = 0.0, threads_s = 0.0, n_segment = 0.0;
    pair.comm = MPI_COMM_NULL;
    int colour = bench->context->rank < 2 ? 0 : MPI_UNDEFINED;
    RMAP_TRY(RMAP_MPI(MPI_Comm_split(bench->context->comm, colour, 0, &pair.comm)));
    pair.size = 2;
    for (int i = 0; i < bench->n_repeat; i++) {
        if (bench->context->rank < 2)
            st = rmap_bench_trace(&pair, 1, scene, n_ray, NULL, &ranks_s, &n_segment, err);
        RMAP_TRY(rmap_agree_patiently(bench->context, st, err));
        if (bench->context->rank == 0)
            st =
                rmap_bench_trace(&bench->alone, 2, scene, n_ray, NULL, &threads_s, &n_segment, err);
        RMAP_TRY(rmap_agree_patiently(bench->context, st, err));
        rmap_bench_add(&series, 1e-6 * n_segment / ranks_s, 1e-6 * n_segment / threads_s);
    }
    if (bench->context->rank == 0)
        rmap_bench_report(bench, "ranks_vs_threads", scene, &series, "million segments/s", NULL);
out:
    if (pair.comm != MPI_COMM_NULL)
        (void)MPI_Comm_free(&pair.comm);
    return st;
}

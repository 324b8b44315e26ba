/* SPDX-License-Identifier: MIT
 *
 * How many worker threads a rank starts when nobody says.
 */
#define _GNU_SOURCE /* sched_getaffinity */
#include "mpi/parallel/threads.h"

#include <sched.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

/* Variables that a batch system documents as the cores of one task, or of the whole job, heeded in
 * its jobs alone. */
static const struct {
    const char *cores, *job;
    bool of_job;
} batch_system[] = {{"SLURM_CPUS_PER_TASK", "SLURM_JOB_ID", false},
                    {"NCPUS", "PBS_JOBID", false},
                    {"LSB_DJOB_NUMPROC", "LSB_JOBID", true}, /* LSF */
                    {"NSLOTS", "JOB_ID", true}};             /* Grid Engine */

/* 0: nobody says. Cores of a job are those of its only task: with more ranks than one they may lie
 * on other hosts. */
static int cores_per_task(bool is_alone)
{
    for (size_t i = 0; i < sizeof batch_system / sizeof *batch_system; i++) {
        const char *cores = getenv(batch_system[i].cores);
        const bool says =
            cores && getenv(batch_system[i].job) && (is_alone || !batch_system[i].of_job);
        const long n = says ? strtol(cores, NULL, 10) : 0;
        if (n > 0)
            return n < CPU_SETSIZE ? (int)n : CPU_SETSIZE;
    }
    return 0;
}

/* A launcher may give all ranks of a node all its cores, or each its own: the union of the
 * masks, divided by the ranks, is right for both. A rank that is bound to nothing sees cores that
 * are other jobs', too. */
int rmap_threads_share(MPI_Comm comm)
{
    MPI_Comm node = MPI_COMM_NULL;
    cpu_set_t mine, all;
    int n_rank = 1, n_rank_of_job = 1;
    if (sched_getaffinity(0, sizeof mine, &mine) != 0)
        memset(&mine, 0, sizeof mine);
    all = mine;
    if (MPI_Comm_split_type(comm, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &node) == MPI_SUCCESS) {
        (void)MPI_Comm_size(node, &n_rank);
        (void)MPI_Allreduce(&mine, &all, (int)sizeof all, MPI_BYTE, MPI_BOR, node);
        (void)MPI_Comm_free(&node);
    }
    (void)MPI_Comm_size(comm, &n_rank_of_job);
    int share = CPU_COUNT(&all) / n_rank;
    int own = CPU_COUNT(&mine);
    const int given = own >= sysconf(_SC_NPROCESSORS_ONLN) ? cores_per_task(n_rank_of_job == 1) : 0;
    share = share < own ? share : own;
    if (given > 0 && given < share)
        share = given;
    return share > 1 ? share : 1;
}

/* SPDX-License-Identifier: MIT
 *
 * `raymap bench` is a program of its own.
 */
#ifndef RMAP_CMD_BENCH_H
#define RMAP_CMD_BENCH_H

#include "mpi/command/command.h"

/* Goes on as raymap-bench, which lies beside this program, with the same arguments. Before MPI is
 * started; comes back when there is none. */
void rmap_bench_start(char **argv);

#endif

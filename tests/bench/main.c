/* SPDX-License-Identifier: MIT
 *
 * raymap-bench: the one command `bench`, as `raymap bench` says it.
 */
#include "bench.h"
#include "mpi/cli/program.h"

int main(int argc, char **argv)
{
    struct rmap_command bench = rmap_command_bench;
    bench.run = rmap_bench_run;
    return rmap_program(&(const struct rmap_command *){&bench}, 1, argc, argv);
}

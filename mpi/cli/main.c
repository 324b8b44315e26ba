/* SPDX-License-Identifier: MIT
 *
 * raymap: the list of its commands.
 */
#include <string.h>

#include "mpi/cli/cmd_bench.h"
#include "mpi/cli/program.h"

static const struct rmap_command *const command[] = {
    &rmap_command_check,      &rmap_command_trace,    &rmap_command_info,    &rmap_command_query,
    &rmap_command_report,     &rmap_command_detector, &rmap_command_stats,   &rmap_command_compare,
    &rmap_command_paths,      &rmap_command_ghosts,   &rmap_command_draw,    &rmap_command_render,
    &rmap_command_verify,     &rmap_command_repair,   &rmap_command_convert, &rmap_command_merge,
    &rmap_command_select,     &rmap_command_keep,     &rmap_command_index,   &rmap_command_session,
    &rmap_command_glass,      &rmap_command_import,   &rmap_command_update,  &rmap_command_voxels,
    &rmap_command_irradiance, &rmap_command_glare,    &rmap_command_events,  &rmap_command_sweep,
    &rmap_command_serve,      &rmap_command_open,     &rmap_command_bench,
};

int main(int argc, char **argv)
{
    if (argc > 1 && strcmp(argv[1], "bench") == 0)
        rmap_bench_start(argv);
    return rmap_program(command, sizeof command / sizeof *command, argc, argv);
}

/* SPDX-License-Identifier: MIT
 *
 * raymap bench: the program's speed against references, as ratios in one run. The references are no
 * part of the program: a second one, raymap-bench (tests/bench), has them and is started here.
 */
#include "mpi/cli/cmd_bench.h"

#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

static const struct rmap_option options[] = {
    {"only", 0, "NAME", "one measurement: trace_vs_roofline, record_vs_trace, ..."},
    {"quick", 0, NULL, "fewer rays and repeats"},
    {"repeats", 0, "N", "rounds of each comparison (default 7; quick 3)"},
    {"scene", 0, "NAME", "room or double-gauss alone"},
    {"examples", 0, "FOLDER", "where the example scenes are"},
    {"partner", 0, NULL, "for the program's own use: the second rank of ranks_vs_threads"},
    {NULL}};

void rmap_bench_start(char **argv)
{
    char program[1024];
    ssize_t len = readlink("/proc/self/exe", program, sizeof program - sizeof "-bench");
    if (len <= 0)
        return;
    (void)strcpy(program + len, "-bench");
    (void)execv(program, argv);
}

static enum rmap_status refuse(const struct rmap_context *context,
                               const struct rmap_arguments *given, struct rmap_error *err)
{
    (void)context;
    (void)given;
    return rmap_error_set(err, RMAP_SYSTEM,
                          "raymap-bench, which measures, cannot be started: it is built and "
                          "installed beside raymap");
}

const struct rmap_command rmap_command_bench = {
    .name = "bench",
    .summary = "measure the program against references built into it",
    .operands = "[options]",
    .help =
        "Measures tracing against Embree alone, recording against tracing alone and against\n"
        "the classic way of storing rays (36-byte records, zlib), decoding and queries against\n"
        "reading all of those, what safety costs, going on with a large map, ranks against\n"
        "threads, and gradient media against the scheme of Sharma et al. Both sides of a ratio\n"
        "run in turns in this process; the median is given with the least and the greatest.\n"
        "render_preview: pictures of 640 x 480 a second; render_overhead: a picture against its\n"
        "index evaluations and its surface queries alone. tm25_write_vs_plain, "
        "tm25_read_vs_plain:\n"
        "rays to a TM-25 file and from it against write() and read() of its bytes. "
        "timed_vs_plain:\n"
        "maps of a scintillator with times and spectra, against one wavelength. move_vs_build:\n"
        "one of 20,968 instances is moved, against building all; moved_trace_vs_fresh: rays after\n"
        "a hundred moves against those in a structure made anew; cache_vs_none: a start with the\n"
        "meshes kept of an earlier one (--cache), against one without, in processor time.",
    .options = options,
    .min_operands = 0,
    .max_operands = 0,
    .run = refuse,
};

/* SPDX-License-Identifier: MIT
 *
 * What a command of the program is. Each command is one file, cmd_NAME.c, which defines one
 * `const struct rmap_command rmap_command_NAME` and is listed in main.c.
 *
 * A command is collective: every rank runs it with the same arguments. Whatever can fail on one
 * rank alone is followed by rmap_agree (agree.h), so that all ranks leave the same way with the
 * same status and text; main prints that text once. Only rank 0 writes to stdout and stderr:
 * stdout is data, stderr is talk.
 */
#ifndef RMAP_COMMAND_H
#define RMAP_COMMAND_H

#include <stdbool.h>

#include "base/status.h"
#include "mpi/command/arguments.h"
#include "mpi/parallel/context.h"

struct rmap_command {
    const char *name;
    const char *summary;               /* one line, for `raymap --help` */
    const char *operands;              /* "SCENE -o MAP", after "raymap NAME" in the usage line */
    const char *help;                  /* paragraphs before the list of options */
    const struct rmap_option *options; /* ends with an entry without a name; the common options
                                          (--json --quiet --threads --help) are added */
    int min_operands, max_operands;    /* checked before run */
    bool stops_in_order;               /* when a signal asks it to (interrupt.h) */
    /* Collective. The same status on every rank; err->text says what went wrong. */
    enum rmap_status (*run)(const struct rmap_context *context, const struct rmap_arguments *given,
                            struct rmap_error *err);
};

extern const struct rmap_command rmap_command_check;
extern const struct rmap_command rmap_command_trace;
extern const struct rmap_command rmap_command_info;
extern const struct rmap_command rmap_command_query;
extern const struct rmap_command rmap_command_report;
extern const struct rmap_command rmap_command_detector;
extern const struct rmap_command rmap_command_compare;
extern const struct rmap_command rmap_command_stats;
extern const struct rmap_command rmap_command_paths;
extern const struct rmap_command rmap_command_ghosts;
extern const struct rmap_command rmap_command_draw;
extern const struct rmap_command rmap_command_render;
extern const struct rmap_command rmap_command_verify;
extern const struct rmap_command rmap_command_repair;
extern const struct rmap_command rmap_command_convert;
extern const struct rmap_command rmap_command_merge;
extern const struct rmap_command rmap_command_index;
extern const struct rmap_command rmap_command_select;
extern const struct rmap_command rmap_command_keep;
extern const struct rmap_command rmap_command_session;
extern const struct rmap_command rmap_command_glass;
extern const struct rmap_command rmap_command_import;
extern const struct rmap_command rmap_command_update;
extern const struct rmap_command rmap_command_voxels;
extern const struct rmap_command rmap_command_irradiance;
extern const struct rmap_command rmap_command_glare;
extern const struct rmap_command rmap_command_events;
extern const struct rmap_command rmap_command_sweep;
extern const struct rmap_command rmap_command_serve;
extern const struct rmap_command rmap_command_open;
extern const struct rmap_command rmap_command_bench;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Requests that are commands of the command line, run on what is in memory: keys become options,
 * the answer is the document of --json.
 */
#ifndef RMAP_SERVE_COMMAND_H
#define RMAP_SERVE_COMMAND_H

#include "mpi/serve/serve_state.h"

struct rmap_serve_command {
    const char *name;
    const struct rmap_command *command;
    const char *fixed;   /* options that it always has, "count" */
    const char *operand; /* key whose value, or list of values, stands as operands; "": none */
    const char *takes;   /* keys that may be given; "rays=sample": key and option */
    const char *formats; /* of a file that is the answer, the first if none is asked for; NULL: none
                          */
};

/* NULL: there is no such command. */
const struct rmap_serve_command *rmap_serve_command_find(const char *name);
const struct rmap_serve_command *rmap_serve_command_at(size_t index);

/* Collective. *result_ret: on rank 0. */
enum rmap_status rmap_serve_command_run(struct rmap_serve *self,
                                        const struct rmap_serve_command *known,
                                        const json_t *message, json_t **result_ret,
                                        struct rmap_error *err) RMAP_MUST_USE;

#endif

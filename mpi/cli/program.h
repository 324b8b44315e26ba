/* SPDX-License-Identifier: MIT
 *
 * A program of commands: which command, on which ranks, and how it ends.
 */
#ifndef RMAP_PROGRAM_H
#define RMAP_PROGRAM_H

#include <stddef.h>

#include "mpi/command/command.h"

/* Starts MPI, runs what argv[1] names and ends MPI. The exit status; for main alone. */
int rmap_program(const struct rmap_command *const *command, size_t n_command, int argc,
                 char **argv);

#endif

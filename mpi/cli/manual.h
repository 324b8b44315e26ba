/* SPDX-License-Identifier: MIT
 *
 * The manual page and the shell completion, made at build time from the same tables as --help.
 */
#ifndef RMAP_MANUAL_H
#define RMAP_MANUAL_H

#include <stddef.h>
#include <stdio.h>

#include "mpi/command/command.h"

/* raymap(1), for man. */
void rmap_manual_print(const struct rmap_command *const *command, size_t n, FILE *out);

/* raymap-COMMAND(1). */
void rmap_manual_print_command(const struct rmap_command *command, FILE *out);

/* A file for bash-completion. */
void rmap_completion_print(const struct rmap_command *const *command, size_t n, FILE *out);

#endif

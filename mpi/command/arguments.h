/* SPDX-License-Identifier: MIT
 *
 * Command lines: options before or after operands, from one table per command that also makes
 * the command's --help. Wrong ones are RMAP_USAGE with the remedy.
 */
#ifndef RMAP_ARGUMENTS_H
#define RMAP_ARGUMENTS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>

#include "base/status.h"

struct rmap_command;

/* Ends the `argument` of a file or criterion that may be given again. */
#define RMAP_ARGUMENT_AGAIN "..."

struct rmap_option {
    const char *name;     /* without the dashes */
    char letter;          /* 0: none */
    const char *argument; /* "FILE", shown in the help; NULL: takes none */
    const char *help;
    const char *goes_with; /* "output plot": means nothing without one of these; NULL: alone */
    const char *words;     /* "plain compact": what the argument may be, "@detectors": names of that
                              kind in the map; for completion. NULL: a file, or anything */
};

struct rmap_arguments {
    const struct rmap_command *command;
    int n_operand;
    char **operand; /* borrowed from argv */
    size_t n_value, cap_value;
    struct rmap_argument_value {
        const struct rmap_option *option;
        const char *text; /* borrowed from argv; "" for an option without an argument */
    } * value;            /* in the order given */
};

/* argv[0] is the command's name. May reorder argv. With --help anywhere, nothing else is
 * checked. */
enum rmap_status rmap_arguments_parse(const struct rmap_command *command, int argc, char **argv,
                                      struct rmap_arguments *arguments,
                                      struct rmap_error *err) RMAP_MUST_USE;
void rmap_arguments_fini(struct rmap_arguments *arguments);

/* The last value given for an option ("" if it takes none); NULL when it was not given. */
const char *rmap_argument(const struct rmap_arguments *arguments, const char *name);

/* The command line as a shell takes it, with one more option; rmap_free. NULL when memory is short.
 */
char *rmap_arguments_again(const struct rmap_arguments *arguments, const char *option);

/* Every value given for an option, split at commas; *list_ret: rmap_argument_list_free. NULL and 0
 * when there is none. */
enum rmap_status rmap_argument_list(const struct rmap_arguments *arguments, const char *name,
                                    char ***list_ret, size_t *n_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Every value, whole. */
enum rmap_status rmap_argument_each(const struct rmap_arguments *arguments, const char *name,
                                    char ***list_ret, size_t *n_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

void rmap_argument_list_free(char **list, size_t n);

/* Those that every command takes; ends with an entry without a name. */
const struct rmap_option *rmap_common_options(void);

/* The --help of a command. */
void rmap_arguments_help(const struct rmap_command *command, FILE *out);

#endif

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

/* Every value given for an option, split at commas, as owned strings; *list_ret: rmap_free each
 * and the list. NULL and 0 when there is none. */
enum rmap_status rmap_argument_list(const struct rmap_arguments *arguments, const char *name,
                                    char ***list_ret, size_t *n_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Every value, whole. */
enum rmap_status rmap_argument_each(const struct rmap_arguments *arguments, const char *name,
                                    char ***list_ret, size_t *n_ret,
                                    struct rmap_error *err) RMAP_MUST_USE;

/* Numbers; *value is left as it is when the option was not given. A count may be written 1000000,
 * 1e6, 2.5M, 3k, 1G, 256Mi. Seconds: 90, 90s, 1.5 min, 3h50min, 500 ms,
 * and as Slurm writes them, 1:30:00, 1-00:00:00. */
enum rmap_status rmap_argument_count(const struct rmap_arguments *arguments, const char *name,
                                     uint64_t *value, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_argument_number(const struct rmap_arguments *arguments, const char *name,
                                      double *value, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_argument_seconds(const struct rmap_arguments *arguments, const char *name,
                                       double *value, struct rmap_error *err) RMAP_MUST_USE;

/* The same for a text that is no option, such as an operand; `what` names it in messages. */
enum rmap_status rmap_parse_count(const char *text, const char *what, uint64_t *value,
                                  struct rmap_error *err) RMAP_MUST_USE;

/* Those that every command takes; ends with an entry without a name. */
const struct rmap_option *rmap_common_options(void);

/* The --help of a command. */
void rmap_arguments_help(const struct rmap_command *command, FILE *out);

#endif

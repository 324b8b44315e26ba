/* SPDX-License-Identifier: MIT
 *
 * Numbers on a command line: counts, decimals, times.
 */
#ifndef RMAP_ARGUMENT_NUMBERS_H
#define RMAP_ARGUMENT_NUMBERS_H

#include "mpi/command/arguments.h"

/* Numbers; *value is left as it is when the option was not given. A count may be written 1000000,
 * 1e6, 2.5M, 3k, 1G, 256Mi. Seconds: 90, 90s, 1.5 min, 3h50min, 500 ms,
 * and as Slurm writes them, 1:30:00, 1-00:00:00. */
enum rmap_status rmap_argument_count(const struct rmap_arguments *arguments, const char *name,
                                     uint64_t *value, struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_argument_number(const struct rmap_arguments *arguments, const char *name,
                                      double *value, struct rmap_error *err) RMAP_MUST_USE;
/* "0, 30,90"; *list_ret: rmap_free; NULL and 0 when the option was not given. */
enum rmap_status rmap_argument_numbers(const struct rmap_arguments *arguments, const char *name,
                                       double **list_ret, size_t *n_ret,
                                       struct rmap_error *err) RMAP_MUST_USE;
enum rmap_status rmap_argument_seconds(const struct rmap_arguments *arguments, const char *name,
                                       double *value, struct rmap_error *err) RMAP_MUST_USE;

/* The same for a text that is no option, such as an operand; `what` names it in messages. */
enum rmap_status rmap_parse_count(const char *text, const char *what, uint64_t *value,
                                  struct rmap_error *err) RMAP_MUST_USE;

#endif

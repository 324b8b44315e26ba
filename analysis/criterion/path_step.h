/* SPDX-License-Identifier: MIT
 *
 * A path's text as it is read, for the files that parse it.
 */
#ifndef RMAP_PATH_STEP_H
#define RMAP_PATH_STEP_H

#include "analysis/criterion/path_regex.h"

struct rmap_path_reader {
    struct rmap_parser *parser;
    struct rmap_path_regex *regex;
    const char *text;
    size_t at, end; /* what is left of the string's inside */
    int depth;
};

#define RMAP_PATH_FAIL(reader, from, to, ...)                                                      \
    rmap_criterion_fail((reader)->text, from, to, (reader)->parser->err, __VA_ARGS__)

/* The next character that is no blank; 0 at the end. */
char rmap_path_peek(struct rmap_path_reader *reader);

/* Where the character that is next ends. */
size_t rmap_path_code_point_end(const struct rmap_path_reader *reader);

/* Reads letters and the name behind them: T, [TR], .@name; *atom_ret: its number in the regex. */
enum rmap_status rmap_path_read_atom(struct rmap_path_reader *reader,
                                     uint32_t *atom_ret) RMAP_MUST_USE;

#endif

/* SPDX-License-Identifier: MIT
 *
 * Words of a command line that a user can paste.
 */
#ifndef RMAP_SHELL_WORD_H
#define RMAP_SHELL_WORD_H

#include <stdio.h>

/* A blank and the word, in quotes where a shell wants any. */
void rmap_shell_word_put(FILE *line, const char *word);

#endif

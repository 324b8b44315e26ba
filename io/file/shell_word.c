/* SPDX-License-Identifier: MIT
 *
 * Words of a command line that a user can paste.
 */
#include "io/file/shell_word.h"

#include <string.h>

void rmap_shell_word_put(FILE *line, const char *word)
{
    static const char plain[] = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789"
                                "_-./=,:+@%";
    if (*word && !word[strspn(word, plain)]) {
        fprintf(line, " %s", word);
        return;
    }
    fputs(" '", line);
    for (; *word; word++)
        fputs(*word == '\'' ? "'\\''" : (const char[]){*word, 0}, line);
    fputs("'", line);
}

/* SPDX-License-Identifier: MIT
 *
 * Glass catalogues of Zemax (.agf): NM begins a glass, CD has the coefficients of its formula, LD
 * the range of its data in um.
 */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "base/alloc.h"
#include "io/lensfile/lens_text.h"

enum { FORMULAS = 13 };

static enum rmap_status begin_glass(char *const *word, size_t n, size_t line,
                                    struct rmap_prescription *lens, struct rmap_error *err)
{
    const double formula = rmap_lens_value(word, n, 2, 0);
    if (n < 3 || !(formula >= 1 && formula <= FORMULAS))
        return rmap_error_set(err, RMAP_INPUT,
                              "line %zu: a name and the number of its formula, 1 to %d, stand "
                              "behind NM",
                              line, FORMULAS);
    if (lens->n_glass >= RMAP_PRESCRIPTION_GLASSES_MAX)
        return rmap_error_set(err, RMAP_INPUT, "line %zu: more than %d glasses", line,
                              RMAP_PRESCRIPTION_GLASSES_MAX);
    if (RMAP_RESERVE(lens->glass, lens->cap_glass, lens->n_glass + 1, err) != RMAP_OK)
        return RMAP_SYSTEM;
    struct rmap_agf_glass *glass = &lens->glass[lens->n_glass++];
    *glass = (struct rmap_agf_glass){.line = line,
                                     .formula = (int)formula,
                                     .nd = rmap_lens_value(word, n, 4, 0),
                                     .vd = rmap_lens_value(word, n, 5, 0)};
    rmap_lens_copy(glass->name, sizeof glass->name, word[1]);
    return RMAP_OK;
}

static void read_line(struct rmap_agf_glass *glass, char *line)
{
    char *word[RMAP_LENS_WORDS_MAX];
    if (strncmp(line, "GC", 2) == 0) {
        rmap_lens_copy(glass->remark, sizeof glass->remark, line + 2 + strspn(line + 2, " \t"));
        return;
    }
    const size_t n = rmap_lens_words(line, "", word);
    if (n == 0)
        return;
    if (strcmp(word[0], "CD") == 0) {
        for (size_t i = 0; i < RMAP_AGF_COEFFICIENTS; i++)
            glass->coefficient[i] = rmap_lens_value(word, n, i + 1, 0);
    } else if (strcmp(word[0], "LD") == 0) {
        glass->from_um = rmap_lens_value(word, n, 1, 0);
        glass->to_um = rmap_lens_value(word, n, 2, 0);
    }
}

enum rmap_status rmap_prescription_read_agf(const char *bytes, size_t nbytes,
                                            struct rmap_prescription *lens, struct rmap_error *err)
{
    char *text = NULL, *word[RMAP_LENS_WORDS_MAX];
    const size_t before = lens->n_glass;
    enum rmap_status st = rmap_lens_decode(bytes, nbytes, &text, err);
    struct rmap_lens_lines lines = {.at = text};
    while (st == RMAP_OK && rmap_lens_next_line(&lines)) {
        if (strncmp(lines.line, "NM ", 3) == 0)
            st = begin_glass(word, rmap_lens_words(lines.line, "", word), lines.number, lens, err);
        else if (lens->n_glass > before)
            read_line(&lens->glass[lens->n_glass - 1], lines.line);
    }
    rmap_free(text);
    if (st == RMAP_OK && lens->n_glass == before)
        st = rmap_error_set(err, RMAP_INPUT, "it has no line 'NM': is it a glass catalogue?");
    return st;
}
